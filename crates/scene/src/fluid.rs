//! The fluid: box, zones, cylinders and probes.

use geometry::AXES;
use method::{Filter, Mask, Precision, Surface, TimeScheme, marker_reach};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::beam::Beam;
use crate::body::{Body, BodyDrive, BodyMotion, ByMaster};
use crate::fault::{Check, Fault, Faults};
use crate::law::TimeLaw;
use crate::shape::Shape;
use crate::stepping::{TimeStepping, check_mask};

/// An incompressible fluid in a periodic box of two or three dimensions.
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
    /// A smaller box of finer cells around all bodies and beams; absent where `box` has the cells for them. The stored
    /// fields have the cells of `box`.
    #[serde(default)]
    pub fine_box: Option<FineBox>,
    /// A box between `box` and `fine_box`, around the latter, with cells of a size between theirs; absent: there is none. It
    /// saves time where the fine box would else be long, and where its cells are more than twice as fine.
    #[serde(default)]
    pub middle_box: Option<MiddleBox>,
    /// Uniform velocity at t = 0, m/s; a component that is left out is 0.
    #[serde(default = "still")]
    #[schemars(length(min = 2, max = 3))]
    pub initial_velocity: Vec<f64>,
    /// Amplitude a of a smooth disturbance of the initial velocity, m/s: the waves `a sin(2π (y − y_0)/L_y)` along x and
    /// `a sin(2π (x − x_0)/L_x)` along y, in a box from x_0 and y_0 of the lengths L_x and L_y; in space the wave along y
    /// varies with z, and that along z with x. Absent: none. A symmetric flow needs one to shed vortices; a hundredth of
    /// the stream is enough.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub disturbance: Option<f64>,
    /// Solid walls; absent in a periodic scene.
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
    /// With `master` the inputs `gust.x`, `.y`, `.z` are added to the velocity of inflow, mean flow and sponge, m/s; beside
    /// an inflow only `gust.x`. Absent: nothing is added.
    #[serde(default)]
    pub gust: Option<ByMaster>,
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

fn still() -> Vec<f64> {
    vec![0.0; 2]
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
    /// Ends along z, m; absent in two dimensions.
    #[serde(default)]
    pub z: Option<[f64; 2]>,
    /// Number of grid points along x, y and, if present, z: at least 8 each, at most 67108864 together. Products of small
    /// primes are fast.
    #[schemars(length(min = 2, max = 3), inner(range(min = 8, max = 65536)))]
    pub cells: Vec<usize>,
}

/// Width of the rim of a fine box, in which no body may be, cells of the large box.
pub const FINE_BOX_RIM_CELLS: f64 = 5.0;

/// Cells of the large box that a body needs beyond the rim if the box follows it by whole cells.
const CELLS_TO_FOLLOW: f64 = 2.0;

/// What a fine box follows that stays.
pub(crate) const NOTHING: &str = "nothing";

/// Fewest cells of the large box across a fine one.
const LEAST_CELLS_OF_FINE_BOX: usize = 16;

/// A smaller box of finer cells. It keeps five cells of the large box from the bodies, seven if it follows one, and needs
/// at least sixteen. Its ends move to the nearest points of the large grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FineBox {
    /// Ends along x, m.
    pub x: [f64; 2],
    /// Ends along y, m.
    pub y: [f64; 2],
    /// Ends along z, m; absent in two dimensions.
    #[serde(default)]
    pub z: Option<[f64; 2]>,
    /// Fine cells in a cell of the large box along each axis. A body wants six of the large cells with 2, and no fewer
    /// than four.
    #[serde(default = "two")]
    #[schemars(range(min = 2, max = 8))]
    pub ratio: usize,
    /// Body, rod or wing with which the box moves, by the name of its outputs: `body[1]`, `cylinder[1]`, `beam`, `wing`,
    /// of several `beam[2]`, `wing[2]`. It may go through the large box from one side to the other. With `master` the inputs
    /// `fine_box.motion.x`, `.y`, `.z` displace it, m. With `nothing` the box stays. Absent: it moves with the shape of a
    /// flyer that may leave its place, else it stays.
    #[serde(default)]
    pub follow: Option<String>,
}

/// A box of finer cells around the fine box, in which its cells are finer still. It keeps five cells of the large box from
/// the fine box, seven if that follows a body; then it follows too. Its ends move to the nearest points of the large grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MiddleBox {
    /// Ends along x, m.
    pub x: [f64; 2],
    /// Ends along y, m.
    pub y: [f64; 2],
    /// Ends along z, m; absent in two dimensions.
    #[serde(default)]
    pub z: Option<[f64; 2]>,
    /// Its cells in a cell of the large box along each axis. `fine_box.ratio`, which counts the same of the fine ones, is a
    /// multiple, such as 4 of 2. The fine box needs sixteen of these cells, and keeps five of them from the bodies.
    #[serde(default = "two")]
    #[schemars(range(min = 2, max = 4))]
    pub ratio: usize,
}

fn two() -> usize {
    2
}

/// Pairs of solid walls.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Channel {
    /// Places of the lower and the upper wall, m; absent where the box is periodic along y.
    #[serde(default)]
    pub y: Option<[f64; 2]>,
    /// Places of two walls across x, m; absent where the box is periodic along x.
    #[serde(default)]
    pub x: Option<[f64; 2]>,
    /// Places of two walls across z, m; only in three dimensions.
    #[serde(default)]
    pub z: Option<[f64; 2]>,
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
    /// Along z, m/s; only in three dimensions.
    #[serde(default)]
    pub z: TimeLaw,
}

/// A point whose velocity and pressure are outputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Name: a letter, then letters, digits and `_`.
    #[schemars(regex(pattern = PROBE_NAME))]
    pub name: String,
    /// Place, m.
    #[schemars(length(min = 2, max = 3))]
    pub position: Vec<f64>,
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
        let motion = |Motion { x, y }: Motion| BodyDrive::Laws(BodyMotion { x, y, ..BodyMotion::default() });
        Self {
            shape: Shape::Circle { radius: cylinder.radius },
            position: cylinder.center.to_vec(),
            pivot: vec![0.0; 2],
            angle: 0.0,
            turn: None,
            motion: cylinder.motion.clone().map(motion),
            mount: None,
            reference: None,
        }
    }
}

/// A rigid body of a fluid, from `cylinders` or from `bodies`.
pub(crate) struct Obstacle {
    /// Path of the body, e.g. `fluid.bodies[0]`.
    pub key: String,
    /// Path of its place.
    pub place: String,
    /// Name in a sentence, e.g. `body 1`.
    pub name: String,
    /// Name of its force, e.g. `body_1`.
    pub force: String,
    pub body: Body,
}

impl Fluid {
    /// Return the rigid bodies, cylinders first.
    pub(crate) fn obstacles(&self) -> impl Iterator<Item = Obstacle> {
        let obstacle = |list: &str, place: &str, name: &str, (i, body): (usize, Body)| Obstacle {
            key: format!("fluid.{list}[{i}]"),
            place: format!("fluid.{list}[{i}].{place}"),
            name: format!("{name} {}", i + 1),
            force: format!("{name}_{}", i + 1),
            body,
        };
        let cylinders = self.cylinders.iter().map(Body::from).enumerate();
        let cylinders = cylinders.map(move |own| obstacle("cylinders", "center", "cylinder", own));
        cylinders
            .chain(self.bodies.iter().cloned().enumerate().map(move |own| obstacle("bodies", "position", "body", own)))
    }
}

impl FluidBox {
    /// Return the ends along each axis, m.
    pub fn ends(&self) -> impl Iterator<Item = [f64; 2]> {
        [self.x, self.y].into_iter().chain(self.z)
    }

    /// Return the lengths of a cell along each axis, m.
    pub(crate) fn spacing(&self) -> Vec<f64> {
        self.ends().zip(&self.cells).map(|([low, high], count)| (high - low) / *count as f64).collect()
    }
}

/// Part of a cell by which a fine box and a wall or a zone that touch may overlap by rounding.
const TOUCH_CELLS: f64 = 1e-6;

/// Return the ends of a fine box at the points of the large grid in words.
fn of_grid([low, high]: [f64; 2]) -> String {
    format!("its ends at the points of the grid, {low:.6} and {high:.6},")
}

impl FineBox {
    /// Return the ends along each axis, m.
    fn ends(&self) -> impl Iterator<Item = [f64; 2]> {
        [self.x, self.y].into_iter().chain(self.z)
    }

    /// Return the number of the first point of the large grid and the number of its cells along each axis.
    pub fn places(&self, large: &FluidBox) -> Vec<[usize; 2]> {
        let axes = self.ends().zip(large.ends()).zip(large.spacing());
        axes.map(|((own, [low, _]), cell)| {
            let [first, last] = own.map(|end| ((end - low) / cell).round().max(0.0) as usize);
            [first, last.saturating_sub(first)]
        })
        .collect()
    }

    /// Return how many of the cells around it a body keeps from its ends.
    fn rim(&self) -> f64 {
        FINE_BOX_RIM_CELLS + if self.follows() { CELLS_TO_FOLLOW } else { 0.0 }
    }

    /// Return whether the box moves.
    pub(crate) fn follows(&self) -> bool {
        self.follow.as_ref().is_some_and(|name| name != NOTHING)
    }

    /// Return the ends between the rims along each axis, m. In its place a large cell is `between` cells.
    fn inner(&self, large: &FluidBox, between: usize) -> Vec<[f64; 2]> {
        let axes = self.places(large).into_iter().zip(large.ends()).zip(large.spacing());
        axes.map(|(([first, cells], [low, _]), cell)| {
            let at = |cells: f64| low + (first as f64 + cells) * cell;
            let rim = self.rim() / between as f64;
            [at(rim), at(cells as f64 - rim)]
        })
        .collect()
    }
}

impl MiddleBox {
    /// Return the number of the first point of the large grid and the number of its cells along each axis.
    pub fn places(&self, large: &FluidBox) -> Vec<[usize; 2]> {
        self.alone().places(large)
    }

    /// Return it as a fine box.
    fn alone(&self) -> FineBox {
        FineBox { x: self.x, y: self.y, z: self.z, ratio: self.ratio, follow: None }
    }
}

/// Inflow or sponge: a zone along x whose velocity is imposed.
pub struct Zone<'a> {
    /// Key in the fluid.
    pub name: &'static str,
    /// Ends, m.
    pub x: [f64; 2],
    /// Profile across the channel.
    pub profile: InflowProfile,
    /// Mean velocity along x, m/s.
    pub mean_velocity: &'a TimeLaw,
    /// Relaxation time, s.
    pub c_eta: f64,
}

impl MeanFlow {
    /// Return the laws along x, y and z.
    pub(crate) fn laws(&self) -> [(&'static str, &TimeLaw); 3] {
        [("x", &self.x), ("y", &self.y), ("z", &self.z)]
    }
}

impl Fluid {
    /// Return whether it has three dimensions.
    pub fn is_space(&self) -> bool {
        self.r#box.z.is_some()
    }

    /// Return the lengths of a cell at the bodies along each axis, m.
    pub(crate) fn spacing(&self) -> Vec<f64> {
        let ratio = self.fine_box.as_ref().map_or(1, |fine| fine.ratio) as f64;
        self.r#box.spacing().into_iter().map(|cell| cell / ratio).collect()
    }

    /// Return the largest length of a cell at the bodies, m.
    pub fn largest_cell(&self) -> f64 {
        self.spacing().into_iter().fold(0.0, f64::max)
    }

    /// Return the walls of the channel across each axis, m.
    pub fn walls(&self) -> [Option<[f64; 2]>; 3] {
        self.channel.as_ref().map_or([None; 3], |channel| [channel.x, channel.y, channel.z])
    }

    /// Return inflow and sponge.
    pub fn zones(&self) -> [Option<Zone<'_>>; 2] {
        let inflow = self.inflow.as_ref().map(|&Inflow { x, profile, ref mean_velocity, c_eta }| Zone {
            name: "inflow",
            x,
            profile,
            mean_velocity,
            c_eta,
        });
        let sponge = self.sponge.as_ref().map(|&Sponge { x, profile, ref mean_velocity, c_eta }| Zone {
            name: "sponge",
            x,
            profile,
            mean_velocity,
            c_eta,
        });
        [inflow, sponge]
    }

    /// Return the cells in a large one around the fine box: those of the middle box, or one.
    fn cells_around_fine_box(&self) -> usize {
        self.middle_box.as_ref().map_or(1, |middle| middle.ratio)
    }

    /// Return the ends between the rims of the fine box along each axis, m.
    pub(crate) fn inner_of_fine_box(&self) -> Option<Vec<[f64; 2]>> {
        Some(self.fine_box.as_ref()?.inner(&self.r#box, self.cells_around_fine_box()))
    }

    /// Return how far beyond its shape at rest a part, which may be a beam, drags the fluid, m.
    pub(crate) fn reach(&self, rest: &geometry::Shape, beam: Option<&Beam>) -> f64 {
        let cell = self.largest_cell();
        let is_thin = matches!(rest, geometry::Shape::Chain(_) | geometry::Shape::Surface(_));
        if beam.map_or(is_thin, |beam| beam.surface == Surface::Line) {
            marker_reach(self.r#box.cells.len()) as f64 * cell - 0.5 * beam.map_or(0.0, Beam::largest_thickness)
        } else {
            self.mask.reach(self.kinematic_viscosity, cell)
        }
    }

    /// Return the largest |u|/dx + |v|/dy + |w|/dz of initial velocity, inflow, mean flow and sponge, 1/s. Around
    /// bodies the flow is faster.
    pub(crate) fn advection_rate(&self) -> f64 {
        let spacing = self.spacing();
        let rate = |(spacing, velocity): (&f64, f64)| velocity.abs() / spacing;
        let initial: f64 = spacing.iter().zip(self.initial_velocity.iter().copied()).map(rate).sum();
        let mean = self
            .mean_flow
            .as_ref()
            .map_or(0.0, |flow| spacing.iter().zip(flow.laws().map(|(_, law)| law.largest())).map(rate).sum());
        let zones = self.zones().into_iter().flatten().map(|zone| rate((&spacing[0], zone.mean_velocity.largest())));
        zones.fold(initial.max(mean), f64::max)
    }
}

/// Pattern of the name of a probe.
const PROBE_NAME: &str = "^[A-Za-z][A-Za-z0-9_]*$";

impl Check for Fluid {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        self.check_box(&format!("{key}.box"), faults);
        if let Some(fine) = &self.fine_box {
            self.check_fine_box(fine, self.cells_around_fine_box(), &format!("{key}.fine_box"), faults);
        }
        self.check_middle_box(key, faults);
        self.check_zones(key, faults);
        self.probes.check_at(&format!("{key}.probes"), faults);
        let cylinders: Vec<_> = self.cylinders.iter().map(Body::from).collect();
        cylinders.check_at(&format!("{key}.cylinders"), faults);
        self.bodies.check_at(&format!("{key}.bodies"), faults);
        for (i, probe) in self.probes.iter().enumerate() {
            let key = format!("{key}.probes[{i}]");
            let twice = self.probes[..i].iter().any(|other| other.name == probe.name);
            faults.require(!twice, &format!("{key}.name"), format!("{:?}", probe.name), || {
                "another probe has this name".into()
            });
            self.check_place(&format!("{key}.position"), &probe.position, faults);
        }
        let ends: Vec<_> = self.r#box.ends().collect();
        for (i, body) in self.bodies.iter().enumerate() {
            let key = format!("{key}.bodies[{i}]");
            self.check_place(&format!("{key}.position"), &body.position, faults);
            body.check_dimension(&key, self.is_space(), faults);
            let holds = body.mount.is_none() || self.time_stepping.scheme == TimeScheme::Sbdf2;
            faults.require(holds, &format!("{key}.mount"), "with the scheme rk2", || {
                "its explicit drag cannot hold a body on springs; use sbdf2".into()
            });
            let holds = body.shape.line().is_none() || self.time_stepping.scheme == TimeScheme::Sbdf2;
            faults.require(holds, &format!("{key}.shape"), "a line", || "a line needs the scheme sbdf2".into());
            body.check_mass(&format!("{key}.mount"), self.density, &ends, faults);
        }
        check_mask(&self.mask, &format!("{key}.mask"), &self.r#box.cells, faults);
        self.time_stepping.check_at(&format!("{key}.time_stepping"), faults);
        self.check_dimension(key, faults);
    }
}

impl Fluid {
    fn check_box(&self, key: &str, faults: &mut Faults) {
        let FluidBox { x, y, z, ref cells } = self.r#box;
        faults.interval(&format!("{key}.x"), x);
        faults.interval(&format!("{key}.y"), y);
        if let Some(z) = z {
            faults.interval(&format!("{key}.z"), z);
        }
        let axes = if z.is_some() { 3 } else { 2 };
        faults.require(cells.len() == axes, &format!("{key}.cells"), format!("{cells:?}"), || match axes {
            2 => "a box without `z` has 2 numbers of cells".into(),
            _ => "a box with `z` has 3 numbers of cells".into(),
        });
        let all = cells.iter().fold(1_usize, |product, count| product.saturating_mul(*count));
        faults.require(all <= MOST_CELLS, &format!("{key}.cells"), format!("{cells:?}"), || {
            format!("a grid has at most {MOST_CELLS} cells")
        });
        // Lines are transformed in blocks of columns, in space of rows.
        let (axis, least) = (axes - 2, self.precision.fewest_columns());
        faults.require(cells[axis] >= least, &format!("{key}.cells[{axis}]"), cells[axis], || {
            format!("single precision needs at least {least} cells along {}", AXES[axis])
        });
    }

    /// Check that a middle box is well around a fine one, with cells between theirs.
    fn check_middle_box(&self, key: &str, faults: &mut Faults) {
        let Some(middle) = &self.middle_box else { return };
        let key = format!("{key}.middle_box");
        let Some(fine) = &self.fine_box else {
            faults.require(false, &key, "without `fine_box`", || "it must have a `fine_box` in it".into());
            return;
        };
        let known = faults.len();
        self.check_fine_box(&middle.alone(), 1, &key, faults);
        let divides = middle.ratio > 0 && fine.ratio > middle.ratio && fine.ratio.is_multiple_of(middle.ratio);
        faults.require(divides, &format!("{key}.ratio"), middle.ratio, || {
            format!("`fine_box.ratio`, which is {}, must be a multiple of it, such as {}", fine.ratio, 2 * middle.ratio)
        });
        if faults.len() > known || fine.z.is_some() != middle.z.is_some() {
            return;
        }
        let (rim, places) = (fine.rim() as usize, fine.places(&self.r#box).into_iter().zip(middle.places(&self.r#box)));
        for (((name, own), ([first, cells], [from, count])), cell) in
            [("x", middle.x), ("y", middle.y), ("z", middle.z.unwrap_or_default())]
                .into_iter()
                .zip(places)
                .zip(self.r#box.spacing())
        {
            let is_around = from + rim <= first && first + cells + rim <= from + count;
            faults.require(is_around, &format!("{key}.{name}"), format!("{own:?}"), || {
                format!(
                    "it must reach {rim} cells of the large box, {:.6} m, beyond `fine_box` on both sides",
                    rim as f64 * cell
                )
            });
        }
    }

    /// Check that a fine box has room between its rims, and lies between walls and zones. In its place a cell of the large
    /// box is `between` cells.
    fn check_fine_box(&self, fine: &FineBox, between: usize, key: &str, faults: &mut Faults) {
        let known = faults.len();
        let agree = fine.z.is_some() == self.r#box.z.is_some();
        faults.require(agree, &format!("{key}.z"), if fine.z.is_some() { "given" } else { "absent" }, || {
            "it must have the axes of `box`".into()
        });
        let scheme = self.time_stepping.scheme;
        faults.require(scheme == TimeScheme::Sbdf2, key, "with the scheme rk2", || "use sbdf2".into());
        let axes = AXES.into_iter().zip(fine.ends()).zip(self.r#box.ends());
        for ((name, own), large) in axes {
            let key = format!("{key}.{name}");
            if faults.interval(&key, own) {
                let inside = large[0] <= own[0] && own[1] <= large[1];
                faults.require(inside, &key, format!("{own:?}"), || format!("it must lie inside the box, {large:?}"));
            }
        }
        if faults.len() > known {
            return;
        }
        let large = self.r#box.ends().zip(self.r#box.spacing());
        let places = fine.places(&self.r#box).into_iter().zip(fine.ends()).zip(self.walls()).zip(large);
        let mut along_x = fine.x;
        for (axis, ((([first, cells], own), walls), ([low, _], cell))) in places.enumerate() {
            let name = AXES[axis];
            let reached = [first, first + cells].map(|point| low + point as f64 * cell);
            if axis == 0 {
                along_x = reached;
            }
            let key = format!("{key}.{name}");
            let (cells, around) = (cells * between, if between > 1 { "middle" } else { "large" });
            faults.require(cells >= LEAST_CELLS_OF_FINE_BOX, &key, format!("{own:?}"), || {
                format!("it must have {LEAST_CELLS_OF_FINE_BOX} cells of the {around} box across, and has {cells}")
            });
            let rounding = TOUCH_CELLS * cell;
            let between = walls.is_none_or(|[from, to]| from - rounding <= reached[0] && reached[1] <= to + rounding);
            faults.require(between, &key, format!("{own:?}"), || {
                format!("{} must lie between the walls at {:?}", of_grid(reached), walls.unwrap_or_default())
            });
        }
        let rounding = TOUCH_CELLS * self.r#box.spacing()[0];
        for Zone { name, x: zone, .. } in self.zones().into_iter().flatten() {
            let apart = along_x[1] <= zone[0] + rounding || zone[1] - rounding <= along_x[0];
            faults.require(apart, &format!("{key}.x"), format!("{:?}", fine.x), || {
                format!("{} must not reach into the {name}, {zone:?}", of_grid(along_x))
            });
        }
    }

    fn check_zones(&self, key: &str, faults: &mut Faults) {
        let channel_key = format!("{key}.channel");
        let within = |faults: &mut Faults, key: String, [low, high]: [f64; 2], outer: [f64; 2]| {
            if faults.interval(&key, [low, high]) {
                faults.require(outer[0] <= low && high <= outer[1], &key, format!("[{low}, {high}]"), || {
                    format!("it must lie inside the box, {outer:?}")
                });
            }
        };
        if let Some(channel) = &self.channel {
            let Channel { x, y, z } = *channel;
            faults.forbid(z.is_some() && !self.is_space(), &format!("{channel_key}.z"), || {
                "the fluid has two dimensions".into()
            });
            if [x, y, z].iter().all(Option::is_none) {
                faults.push(Fault::needed(&format!("{channel_key}.y"), "a channel has walls across one axis or more"));
            }
            for (axis, walls, ends) in
                [("y", y, Some(self.r#box.y)), ("x", x, Some(self.r#box.x)), ("z", z, self.r#box.z)]
            {
                let walls = walls.into_iter().zip(ends);
                walls.for_each(|(walls, ends)| within(faults, format!("{channel_key}.{axis}"), walls, ends));
            }
        }
        for Zone { name, x, profile, mean_velocity, .. } in self.zones().into_iter().flatten() {
            within(faults, format!("{key}.{name}.x"), x, self.r#box.x);
            mean_velocity.check_at(&format!("{key}.{name}.mean_velocity"), faults);
            let possible = profile != InflowProfile::Parabolic || self.walls()[1].is_some();
            faults.require(possible, &format!("{key}.{name}.profile"), "parabolic", || match self.channel {
                None => "a parabola needs a `channel`".into(),
                Some(_) => format!("a parabola needs `{channel_key}.y`"),
            });
        }
        let is_free = self.inflow.is_none() && self.mean_flow.is_none();
        faults.forbid(self.gust.is_some() && is_free, &format!("{key}.gust"), || {
            "nothing keeps a stream that it could be added to; give an `inflow` or a `mean_flow`".into()
        });
        if let Some(mean_flow) = &self.mean_flow {
            self.check_mean_flow(mean_flow, &format!("{key}.mean_flow"), faults);
        }
    }

    fn check_mean_flow(&self, mean_flow: &MeanFlow, key: &str, faults: &mut Faults) {
        faults.forbid(self.inflow.is_some(), key, || {
            "the inflow sets the flow rate already; remove one of the two".into()
        });
        for (axis, (name, law)) in mean_flow.laws().into_iter().enumerate() {
            let (key, known) = (format!("{key}.{name}"), faults.len());
            law.check_at(&key, faults);
            if faults.len() == known {
                let (start, initial) = (law.value(0.0), self.initial_velocity.get(axis).copied().unwrap_or(0.0));
                let agrees = (start - initial).abs() <= 1e-9 * initial.abs();
                faults.require(agrees, &key, format!("{start} at t = 0"), || {
                    format!("the initial velocity is {initial}")
                });
            }
        }
    }

    /// Check that the `position` of a part, the value of `key`, lies inside the box.
    pub(crate) fn check_place(&self, key: &str, position: &[f64], faults: &mut Faults) {
        let axes = self.r#box.ends().count();
        faults.require(position.len() == axes, key, format!("{position:?}"), || {
            format!("it must have {axes} components like the box")
        });
        for (axis, ([low, high], &at)) in self.r#box.ends().zip(position).enumerate() {
            faults.require((low..=high).contains(&at), &format!("{key}[{axis}]"), at, || {
                format!("it must lie inside the box, [{low}, {high}]")
            });
        }
    }
}

impl Fluid {
    /// Check that the parts exist in the dimensions of the box.
    fn check_dimension(&self, key: &str, faults: &mut Faults) {
        let TimeStepping { scheme, .. } = self.time_stepping;
        if self.is_space() {
            let solid = || "in three dimensions a cylinder is one of the `bodies`".into();
            faults.forbid(!self.cylinders.is_empty(), &format!("{key}.cylinders"), solid);
            let fits = scheme == TimeScheme::Sbdf2;
            faults.require(fits, &format!("{key}.time_stepping.scheme"), "rk2", || "in space it must be sbdf2".into());
        } else {
            let fits = self.initial_velocity.len() == 2;
            faults.require(fits, &format!("{key}.initial_velocity"), format!("{:?}", self.initial_velocity), || {
                "it must have 2 components like the box".into()
            });
            let moves = self.mean_flow.as_ref().is_some_and(|flow| flow.z != TimeLaw::default());
            faults.forbid(moves, &format!("{key}.mean_flow.z"), || "the fluid has two dimensions".into());
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
