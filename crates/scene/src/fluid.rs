//! The fluid: box, zones, cylinders and probes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::body::{Body, BodyDrive, BodyMotion, Shape};
use crate::fault::{Check, Faults};
use crate::law::TimeLaw;
use crate::method::{Filter, Mask, Precision, TimeScheme, TimeStepping};

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
    /// Uniform velocity at t = 0, m/s.
    #[serde(default)]
    pub initial_velocity: [f64; 2],
    /// Amplitude a of a smooth disturbance of the initial velocity, m/s: the waves `a sin(2π (y − y_0)/L_y)` along x and
    /// `a sin(2π (x − x_0)/L_x)` along y, in a box from x_0 and y_0 of the lengths L_x and L_y. Absent: none. A
    /// symmetric flow needs one to shed vortices; a hundredth of the stream is enough.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub disturbance: Option<f64>,
    /// Solid walls below and above; absent in a periodic scene.
    #[serde(default)]
    pub channel: Option<Channel>,
    /// Zone across the box in which the velocity is imposed; absent where no inflow drives the flow.
    #[serde(default)]
    pub inflow: Option<Inflow>,
    /// Zone across the box in which the flow relaxes softly to a velocity; absent where nothing must be damped.
    #[serde(default)]
    pub sponge: Option<Sponge>,
    /// Mean velocity over the whole box; absent where it is free. Not together with an inflow.
    #[serde(default)]
    pub mean_flow: Option<MeanFlow>,
    /// Circular cylinders, still or in prescribed motion.
    #[serde(default)]
    pub cylinders: Vec<Cylinder>,
    /// Rigid bodies of any shape: still, in prescribed motion, or on springs.
    #[serde(default)]
    pub bodies: Vec<Body>,
    /// Drag rate of solids on the grid.
    pub mask: Mask,
    /// Filter of aliasing errors.
    #[serde(default)]
    pub filter: Filter,
    /// Steps of the fluid inside a communication step.
    pub time_stepping: TimeStepping,
    /// Points whose velocity and pressure are outputs.
    #[serde(default)]
    pub probes: Vec<Probe>,
    /// Precision of the fields and transforms.
    #[serde(default)]
    pub precision: Precision,
    /// Largest number of threads in a step. A small grid uses fewer, and results do not depend on the number.
    #[serde(default = "one_thread")]
    #[schemars(range(min = 1, max = 1024))]
    pub threads: usize,
}

fn one_thread() -> usize {
    1
}

/// Most cells of a grid: 8192 x 8192, which need about 8.5 GB.
const MOST_CELLS: usize = 1 << 26;

/// The periodic box and its grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FluidBox {
    /// Ends along x, m.
    pub x: [f64; 2],
    /// Ends along y, m.
    pub y: [f64; 2],
    /// Number of grid points along x and y: at least 8 each, at most 67108864 together. Products of small primes are
    /// fast.
    #[schemars(inner(range(min = 8, max = 65536)))]
    pub cells: [usize; 2],
}

/// Solid walls below and above.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Channel {
    /// Places of the lower and the upper wall, m.
    pub y: [f64; 2],
}

/// Zone across the box in which the velocity is imposed: `(profile(y) · law(t), 0)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Inflow {
    /// Ends along x, m.
    pub x: [f64; 2],
    /// Profile of the velocity across the zone, of mean 1.
    pub profile: InflowProfile,
    /// Mean velocity of the profile over time, m/s.
    pub mean_velocity: TimeLaw,
    /// Relaxation time of the zone, s.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub c_eta: f64,
}

/// Zone across the box in which the flow relaxes to `(profile(y) · law(t), 0)` at the rate
/// `sin²(π (x − x_0)/(x_1 − x_0)) / c_eta`, which damps a wake and reflects little of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sponge {
    /// Ends along x, m.
    pub x: [f64; 2],
    /// Profile of the velocity across the zone, of mean 1.
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
    /// Name: a letter, then letters, digits and `_`.
    #[schemars(regex(pattern = PROBE_NAME))]
    pub name: String,
    /// Place, m.
    pub position: [f64; 2],
}

/// Profile of an inflow, of mean 1.
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
    /// Centre, m; the motion is added to it.
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

fn at_rest() -> TimeLaw {
    TimeLaw::Constant(0.0)
}

/// A cylinder is a circle that does not turn.
impl From<&Cylinder> for Body {
    fn from(cylinder: &Cylinder) -> Self {
        let motion = |Motion { x, y }: Motion| BodyDrive::Laws(BodyMotion { x, y, angle: TimeLaw::default() });
        Self {
            shape: Shape::Circle { radius: cylinder.radius },
            position: cylinder.center,
            pivot: [0.0; 2],
            angle: 0.0,
            motion: cylinder.motion.clone().map(motion),
            mount: None,
        }
    }
}

impl FluidBox {
    /// Return the lengths of a cell along x and y, m.
    pub(crate) fn spacing(&self) -> [f64; 2] {
        let [nx, ny] = self.cells.map(|count| count as f64);
        [(self.x[1] - self.x[0]) / nx, (self.y[1] - self.y[0]) / ny]
    }
}

impl Fluid {
    /// Return the largest |u|/dx + |v|/dy of initial velocity, inflow, mean flow and sponge, 1/s. Around bodies the
    /// flow is faster.
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

/// Pattern of the name of a probe.
const PROBE_NAME: &str = "^[A-Za-z][A-Za-z0-9_]*$";

impl Check for Fluid {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        self.check_box(&format!("{key}.box"), faults);
        self.check_zones(key, faults);
        self.probes.check_at(&format!("{key}.probes"), faults);
        self.cylinders.check_at(&format!("{key}.cylinders"), faults);
        self.bodies.check_at(&format!("{key}.bodies"), faults);
        for (i, probe) in self.probes.iter().enumerate() {
            let key = format!("{key}.probes[{i}]");
            let twice = self.probes[..i].iter().any(|other| other.name == probe.name);
            faults.require(!twice, &format!("{key}.name"), format!("{:?}", probe.name), || {
                "another probe has this name".into()
            });
            self.check_place(&format!("{key}.position"), probe.position, faults);
        }
        for (i, body) in self.bodies.iter().enumerate() {
            let key = format!("{key}.bodies[{i}]");
            self.check_place(&format!("{key}.position"), body.position, faults);
            let holds = body.mount.is_none() || self.time_stepping.scheme == TimeScheme::Sbdf2;
            faults.require(holds, &format!("{key}.mount"), "with the scheme rk2", || {
                "its explicit drag cannot hold a body on springs; use sbdf2".into()
            });
            if let Some(mount) = &body.mount {
                let displaced = self.density * body.shape.area();
                let round = matches!(body.shape, Shape::Circle { .. }) || mount.x.or(mount.y).is_none();
                faults.require(round || mount.mass >= displaced, &format!("{key}.mount.mass"), mount.mass, || {
                    format!(
                        "a body on springs that is no circle must weigh at least as much as the fluid it displaces, \
                         {displaced:.6}"
                    )
                });
            }
        }
        self.mask.check_at(&format!("{key}.mask"), self.r#box.cells, faults);
        self.time_stepping.check_at(&format!("{key}.time_stepping"), faults);
    }
}

impl Fluid {
    fn check_box(&self, key: &str, faults: &mut Faults) {
        let FluidBox { x, y, cells: [nx, ny] } = self.r#box;
        faults.interval(&format!("{key}.x"), x);
        faults.interval(&format!("{key}.y"), y);
        faults.require(nx * ny <= MOST_CELLS, &format!("{key}.cells"), format!("[{nx}, {ny}]"), || {
            format!("a grid has at most {MOST_CELLS} cells")
        });
        let least = self.precision.fewest_columns();
        faults.require(nx >= least, &format!("{key}.cells[0]"), nx, || {
            format!("single precision needs at least {least} cells along x")
        });
    }

    fn check_zones(&self, key: &str, faults: &mut Faults) {
        let within = |faults: &mut Faults, key: String, [low, high]: [f64; 2], outer: [f64; 2]| {
            if faults.interval(&key, [low, high]) {
                faults.require(outer[0] <= low && high <= outer[1], &key, format!("[{low}, {high}]"), || {
                    format!("it must lie inside the box, {outer:?}")
                });
            }
        };
        let possible = |faults: &mut Faults, key: String, profile: InflowProfile| {
            let possible = profile != InflowProfile::Parabolic || self.channel.is_some();
            faults.require(possible, &key, "parabolic", || "a parabola needs a `channel`".into());
        };
        if let Some(channel) = &self.channel {
            within(faults, format!("{key}.channel.y"), channel.y, self.r#box.y);
        }
        if let Some(inflow) = &self.inflow {
            within(faults, format!("{key}.inflow.x"), inflow.x, self.r#box.x);
            inflow.mean_velocity.check_at(&format!("{key}.inflow.mean_velocity"), faults);
            possible(faults, format!("{key}.inflow.profile"), inflow.profile);
        }
        if let Some(sponge) = &self.sponge {
            within(faults, format!("{key}.sponge.x"), sponge.x, self.r#box.x);
            sponge.mean_velocity.check_at(&format!("{key}.sponge.mean_velocity"), faults);
            possible(faults, format!("{key}.sponge.profile"), sponge.profile);
        }
        if let Some(mean_flow) = &self.mean_flow {
            self.check_mean_flow(mean_flow, &format!("{key}.mean_flow"), faults);
        }
    }

    fn check_mean_flow(&self, mean_flow: &MeanFlow, key: &str, faults: &mut Faults) {
        faults.forbid(self.inflow.is_some(), key, || {
            "the inflow sets the flow rate already; remove one of the two".into()
        });
        for (axis, (name, law)) in [("x", &mean_flow.x), ("y", &mean_flow.y)].into_iter().enumerate() {
            let (key, known) = (format!("{key}.{name}"), faults.len());
            law.check_at(&key, faults);
            if faults.len() == known {
                let (start, initial) = (law.value(0.0), self.initial_velocity[axis]);
                let agrees = (start - initial).abs() <= 1e-9 * initial.abs();
                faults.require(agrees, &key, format!("{start} at t = 0"), || {
                    format!("the initial velocity is {initial}")
                });
            }
        }
    }

    /// Check that the `position` of a part, the value of `key`, lies inside the box.
    pub(crate) fn check_place(&self, key: &str, position: [f64; 2], faults: &mut Faults) {
        for (axis, [low, high]) in [self.r#box.x, self.r#box.y].into_iter().enumerate() {
            let at = position[axis];
            faults.require((low..=high).contains(&at), &format!("{key}[{axis}]"), at, || {
                format!("it must lie inside the box, [{low}, {high}]")
            });
        }
    }
}

impl Check for Probe {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let good = self.name.starts_with(|c: char| c.is_ascii_alphabetic()) && self.name.chars().all(word);
        faults.require(good, &format!("{key}.name"), format!("{:?}", self.name), || {
            "a name is a letter, then letters a-z, A-Z, digits and _".into()
        });
    }
}

impl Check for Cylinder {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        let Some(motion) = &self.motion else { return };
        motion.x.check_at(&format!("{key}.motion.x"), faults);
        motion.y.check_at(&format!("{key}.motion.y"), faults);
    }
}
