//! The fluid and the bodies in it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Check, interval, require};
use crate::{Body, SceneError, TimeLaw};

/// A two-dimensional incompressible fluid in a periodic box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fluid {
    /// Density, kg/m³.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub density: f64,
    /// Kinematic viscosity, m²/s.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub kinematic_viscosity: f64,
    /// The periodic box and its grid.
    pub r#box: FluidBox,
    /// Velocity of the fluid at rest everywhere at t = 0, m/s.
    #[serde(default)]
    pub initial_velocity: [f64; 2],
    /// Solid walls above and below; absent in an open (periodic) scene.
    #[serde(default)]
    pub channel: Option<Channel>,
    /// Zone across the box in which the velocity is imposed; absent where nothing drives the flow.
    #[serde(default)]
    pub inflow: Option<Inflow>,
    /// Zone across the box in which the flow is drawn softly to a velocity; absent where nothing has to be damped.
    #[serde(default)]
    pub sponge: Option<Sponge>,
    /// Mean velocity that is held over the whole box; absent where it is free. Not together with an inflow.
    #[serde(default)]
    pub mean_flow: Option<MeanFlow>,
    /// Circular cylinders, still or in prescribed motion.
    #[serde(default)]
    pub cylinders: Vec<Cylinder>,
    /// Rigid bodies of any shape, still or in prescribed motion.
    #[serde(default)]
    pub bodies: Vec<Body>,
    /// How solids are smeared over the grid and how hard they hold the fluid.
    pub mask: Mask,
    /// What removes aliasing errors.
    #[serde(default)]
    pub filter: Filter,
    /// The fluid's own step inside a communication step.
    pub time_stepping: TimeStepping,
    /// Points whose velocity and pressure are outputs.
    #[serde(default)]
    pub probes: Vec<Probe>,
    /// Precision of the fields and transforms.
    #[serde(default)]
    pub precision: Precision,
    /// Threads that share the work of a step, as far as the grid is large enough for so many to gain time; results do not
    /// depend on it.
    #[serde(default = "one_thread")]
    #[schemars(range(min = 1, max = 1024))]
    pub threads: usize,
}

fn one_thread() -> usize {
    1
}

/// Most cells of a grid: 8192 x 8192, for which the fluid takes about 8.5 GB.
const MOST_CELLS: usize = 1 << 26;

/// The periodic box and its grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FluidBox {
    /// From where to where along x, m.
    pub x: [f64; 2],
    /// From where to where along y, m.
    pub y: [f64; 2],
    /// Number of grid points along x and y; at least 8 each, together at most 67108864, fast for products
    /// of small primes.
    #[schemars(inner(range(min = 8, max = 65536)))]
    pub cells: [usize; 2],
}

/// Solid walls above and below.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Channel {
    /// Lower and upper wall, m; the fluid is between them.
    pub y: [f64; 2],
}

/// Zone across the box in which the velocity is imposed: `(profile(y) · law(t), 0)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Inflow {
    /// From where to where along x, m.
    pub x: [f64; 2],
    /// Shape of the velocity across the zone; the law gives its size.
    pub profile: InflowProfile,
    /// Mean velocity of the profile over time, m/s.
    pub mean_velocity: TimeLaw,
    /// Relaxation time of the zone, s.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub c_eta: f64,
}

/// Zone across the box in which the flow is drawn to `(profile(y) · law(t), 0)` at the rate
/// `sin²(π (x − x_0)/(x_1 − x_0)) / c_eta`, which takes out what comes in and reflects little of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sponge {
    /// From where to where along x, m.
    pub x: [f64; 2],
    /// Shape of the velocity across the zone; the law gives its size.
    #[serde(default)]
    pub profile: InflowProfile,
    /// Mean velocity of the profile over time, m/s.
    pub mean_velocity: TimeLaw,
    /// Relaxation time in the middle of the zone, s.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub c_eta: f64,
}

/// Mean velocity over the whole box, solids included (thesis' U_inf), m/s.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeanFlow {
    /// Along x, m/s.
    #[serde(default)]
    pub x: TimeLaw,
    /// Along y, m/s.
    #[serde(default)]
    pub y: TimeLaw,
}

/// A point whose velocity and pressure are outputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Its name: a letter, then letters, digits and `_`.
    #[schemars(regex(pattern = PROBE_NAME))]
    pub name: String,
    /// Where it is, m.
    pub position: [f64; 2],
}

/// Shape of an inflow, of mean 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum InflowProfile {
    /// The same velocity at every y.
    #[default]
    Uniform,
    /// Poiseuille's parabola between the walls of the channel.
    Parabolic,
}

/// A circular cylinder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cylinder {
    /// Centre, m; where it moves, the point that its motion is added to.
    pub center: [f64; 2],
    /// Radius, m.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius: f64,
    /// Prescribed motion; absent for a still cylinder.
    #[serde(default)]
    pub motion: Option<Motion>,
}

/// Prescribed displacement of a cylinder, m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Displacement along x, m.
    #[serde(default = "at_rest")]
    pub x: TimeLaw,
    /// Displacement along y, m.
    #[serde(default = "at_rest")]
    pub y: TimeLaw,
}

fn a_quarter() -> f64 {
    0.25
}

fn at_rest() -> TimeLaw {
    TimeLaw::Constant(0.0)
}

fn yes() -> bool {
    true
}

/// How a solid holds the fluid: the drag rate as a function of the signed distance to its surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Mask {
    /// chi = 1 inside, 0 outside (thesis ch. 3); the wall is moved by √(ν C_eta) so that no-slip holds where it should.
    Sharp {
        /// Relaxation time C_eta, s.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        c_eta: f64,
        /// Whether the wall is moved; if not, the mask is that of the thesis.
        #[serde(default = "yes")]
        displacement_corrected: bool,
    },
    /// Cosine layer around the surface (thesis eq. 4.1), shifted so that no-slip holds where it should (Hester, Vasil &
    /// Burns 2021).
    Cosine {
        /// Relaxation time C_eta, s.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        c_eta: f64,
        /// Half the width of the layer in grid cells.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        half_width: f64,
        /// Whether the layer is shifted; if not, the mask is that of the thesis.
        #[serde(default = "yes")]
        displacement_corrected: bool,
    },
    /// Drag rate that grows exponentially with depth, so that no-slip holds at the surface whatever the grid's position.
    LogLinear {
        /// Smallest relaxation time, s, reached inside the solid.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        c_eta: f64,
        /// Length of e-fold growth in grid cells. A quarter is the shortest that the grid resolves: the wall keeps its place to
        /// 0.03 cells wherever the grid lies.
        #[serde(default = "a_quarter")]
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        decay_length_cells: f64,
        /// Depth at which the core of a cylinder or another still body begins, in grid cells: from there on the drag grows
        /// three times as fast, up to 1/C_eta. Above a deep core it stays where the grid resolves it. Absent: one and a half
        /// e-folds, three without a wall target. With 2 the forces depend much less on C_eta, but a body of less than 25 cells
        /// across is porous. A depth beyond a fifth of a body's thickness counts as that; in a thinner body the core begins
        /// earlier still. A beam or a body that moves has no core but where it is thinner than some four cells.
        #[serde(default)]
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        core_depth: Option<f64>,
        /// What the cylinders and the beam draw the fluid at their surface to.
        #[serde(default)]
        wall_correction: WallCorrection,
    },
}

/// What a body draws the fluid at its surface to, and thereby which flows along a wall are right to the order of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WallCorrection {
    /// The body's own velocity: no-slip is where it should be in linear shear, but the smooth profile lets a flux through.
    None,
    /// Inside, weakly, the mirror image of the flow outside: no flux beyond that of linear shear either.
    Shear,
    /// Besides, at the surface, what the second difference of the flow outside asks for: no slip where a pressure gradient
    /// bends the velocity profile either.
    #[default]
    Curvature,
}

/// Precision of the fields and transforms. Bodies, forces and loads are in double precision in both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// 16 digits.
    #[default]
    Double,
    /// 7 digits, at half of the memory. Not where small differences matter: a lift of 1e-5 of the drag, or orders of
    /// convergence.
    Single,
}

/// What removes aliasing errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Filter {
    /// exp(−36 (k/k_max)³⁶) (Hou & Li 2007).
    #[default]
    Smooth,
    /// Truncation outside the ellipse of two thirds (thesis eq. 3.14).
    TwoThirds,
    /// None.
    None,
}

/// The fluid's own step inside a communication step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend(
    "if" = { "properties": { "scheme": { "const": TimeScheme::Rk2 } }, "required": ["scheme"] },
    "then" = { "properties": { "max_cfl": { "maximum": TimeScheme::Rk2.largest_cfl() } } },
    "else" = { "properties": { "max_cfl": { "maximum": TimeScheme::Sbdf2.largest_cfl() } } }
))]
pub struct TimeStepping {
    /// Largest step, s.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub max_step: f64,
    /// Largest CFL number max(|u|/dx + |v|/dy) dt; smaller steps are taken where it would be exceeded. At most 0.4 with
    /// sbdf2 and 0.6 with rk2: above, advection is unstable.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub max_cfl: f64,
    /// How a step is made.
    #[serde(default)]
    pub scheme: TimeScheme,
}

/// How the fluid makes a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TimeScheme {
    /// Two-step backward differences, drag and viscosity implicit: the step is limited by advection alone.
    #[default]
    Sbdf2,
    /// Heun's method, drag explicit, viscosity exact (thesis eq. 3.15 – 3.18): steps above C_eta are divided.
    Rk2,
}

impl TimeScheme {
    /// Largest CFL number that a scene may ask for.
    ///
    /// Both schemes are weakly unstable for advection without viscosity. Up to these numbers the fastest growing wave under the
    /// smooth filter grows by half in a step (52 %).
    pub fn largest_cfl(self) -> f64 {
        match self {
            Self::Sbdf2 => 0.4,
            Self::Rk2 => 0.6,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Sbdf2 => "sbdf2",
            Self::Rk2 => "rk2",
        }
    }
}

impl Precision {
    /// Fewest grid points along x: as many columns are transformed together.
    fn fewest_columns(self) -> usize {
        match self {
            Self::Double => 8,
            Self::Single => 16,
        }
    }
}

impl Mask {
    /// Relaxation time C_eta deep inside the solid, s.
    pub fn c_eta(&self) -> f64 {
        match *self {
            Self::Sharp { c_eta, .. } | Self::Cosine { c_eta, .. } | Self::LogLinear { c_eta, .. } => c_eta,
        }
    }
}

impl Fluid {
    /// Largest |u|/dx + |v|/dy of the flow that initial velocity, inflow, mean flow and sponge ask for, 1/s; cylinders
    /// and beam make the flow faster than that.
    pub(crate) fn advection_rate(&self) -> f64 {
        let rate = |axis: usize, velocity: f64| {
            let [low, high] = [self.r#box.x, self.r#box.y][axis];
            velocity.abs() * self.r#box.cells[axis] as f64 / (high - low)
        };
        let [u, v] = self.initial_velocity;
        let mean = self.mean_flow.as_ref().map_or(0.0, |flow| rate(0, flow.x.largest()) + rate(1, flow.y.largest()));
        let inflow = self.inflow.as_ref().map_or(0.0, |inflow| rate(0, inflow.mean_velocity.largest()));
        let sponge = self.sponge.as_ref().map_or(0.0, |sponge| rate(0, sponge.mean_velocity.largest()));
        (rate(0, u) + rate(1, v)).max(mean).max(inflow).max(sponge)
    }
}

/// What a name of a probe looks like.
const PROBE_NAME: &str = "^[A-Za-z][A-Za-z0-9_]*$";

impl Check for Fluid {
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        interval(&format!("{key}.box.x"), self.r#box.x)?;
        interval(&format!("{key}.box.y"), self.r#box.y)?;
        let [nx, ny] = self.r#box.cells;
        require(nx * ny <= MOST_CELLS, &format!("{key}.box.cells"), format!("[{nx}, {ny}]"), || {
            format!("it must be at most {MOST_CELLS} cells together")
        })?;
        let least = self.precision.fewest_columns();
        require(nx >= least, &format!("{key}.box.cells[0]"), nx, || {
            format!("it must be at least {least} in single precision")
        })?;
        let within = |key: &str, [low, high]: [f64; 2], outer: [f64; 2]| {
            interval(key, [low, high])?;
            require(outer[0] <= low && high <= outer[1], key, format!("[{low}, {high}]"), || {
                format!("it must lie inside the box, {outer:?}")
            })
        };
        let possible = |key: &str, profile: InflowProfile| {
            let possible = profile != InflowProfile::Parabolic || self.channel.is_some();
            require(possible, key, "parabolic", || "a parabola needs a channel".into())
        };
        if let Some(channel) = &self.channel {
            within(&format!("{key}.channel.y"), channel.y, self.r#box.y)?;
        }
        if let Some(inflow) = &self.inflow {
            within(&format!("{key}.inflow.x"), inflow.x, self.r#box.x)?;
            inflow.mean_velocity.check_at(&format!("{key}.inflow.mean_velocity"))?;
            possible(&format!("{key}.inflow.profile"), inflow.profile)?;
        }
        if let Some(sponge) = &self.sponge {
            within(&format!("{key}.sponge.x"), sponge.x, self.r#box.x)?;
            sponge.mean_velocity.check_at(&format!("{key}.sponge.mean_velocity"))?;
            possible(&format!("{key}.sponge.profile"), sponge.profile)?;
        }
        if let Some(mean_flow) = &self.mean_flow {
            let key = format!("{key}.mean_flow");
            require(self.inflow.is_none(), &key, "present", || {
                "the inflow sets the flow rate already: leave one of the two out".into()
            })?;
            for (axis, (name, law)) in [("x", &mean_flow.x), ("y", &mean_flow.y)].into_iter().enumerate() {
                law.check_at(&format!("{key}.{name}"))?;
                let (start, initial) = (law.value(0.0), self.initial_velocity[axis]);
                require((start - initial).abs() <= 1e-9 * initial.abs(), &format!("{key}.{name}"), start, || {
                    format!("at t = 0 it must be the initial velocity, {initial}")
                })?;
            }
        }
        for (i, probe) in self.probes.iter().enumerate() {
            let key = format!("{key}.probes[{i}]");
            let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
            let good = probe.name.starts_with(|c: char| c.is_ascii_alphabetic()) && probe.name.chars().all(word);
            require(good, &format!("{key}.name"), format!("{:?}", probe.name), || {
                "it must be a letter, then letters a-z, A-Z, digits and _".into()
            })?;
            let twice = self.probes[..i].iter().any(|other| other.name == probe.name);
            require(!twice, &format!("{key}.name"), &probe.name, || "another probe has that name".into())?;
            for (axis, [low, high]) in [self.r#box.x, self.r#box.y].into_iter().enumerate() {
                let at = probe.position[axis];
                require((low..=high).contains(&at), &format!("{key}.position[{axis}]"), at, || {
                    format!("it must lie inside the box, [{low}, {high}]")
                })?;
            }
        }
        self.cylinders.check_at(&format!("{key}.cylinders"))?;
        self.bodies.check_at(&format!("{key}.bodies"))?;
        for (i, body) in self.bodies.iter().enumerate() {
            for (axis, [low, high]) in [self.r#box.x, self.r#box.y].into_iter().enumerate() {
                let at = body.position[axis];
                require((low..=high).contains(&at), &format!("{key}.bodies[{i}].position[{axis}]"), at, || {
                    format!("it must lie inside the box, [{low}, {high}]")
                })?;
            }
        }
        let TimeStepping { max_cfl, scheme, .. } = self.time_stepping;
        require(max_cfl <= scheme.largest_cfl(), &format!("{key}.time_stepping.max_cfl"), max_cfl, || {
            format!(
                "it must be at most {} with the scheme {}: above, advection is unstable",
                scheme.largest_cfl(),
                scheme.name()
            )
        })
    }
}

impl Check for Cylinder {
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        let Some(motion) = &self.motion else { return Ok(()) };
        motion.x.check_at(&format!("{key}.motion.x"))?;
        motion.y.check_at(&format!("{key}.motion.y"))
    }
}
