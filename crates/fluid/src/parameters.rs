//! Parameters of a fluid: plain data, in SI units, in the plane per metre of depth.

use std::borrow::Cow;
use std::ops::RangeInclusive;
use std::sync::Arc;

use contact::{BodyLaw, Skin};
use geometry::AXES;
use method::{Filter, Mask, Precision, Support, TimeScheme};

use crate::error::Error;
use crate::grid::Grid;
use crate::gust::Gust;
use crate::shapes::{Between, Shape};
use crate::space::{Freedoms, Kinematics, Space, Spin};

pub use crate::law::Law;

/// Largest extent of a thin body, cells: more markers take too long to be spread over it.
const MOST_CELLS: f64 = 4e4;

/// Cells of the domain by which a fine box that moves may come nearer to the ends of the middle one.
const CELLS_TO_FOLLOW: usize = 2;

/// Part of a cell by which a fine box and a wall or a zone that touch may overlap by rounding.
const TOUCH_CELLS: f64 = 1e-6;

/// A fluid and the bodies in it. [`Parameters::new`] has every default: a periodic domain without a body.
#[derive(Clone, Debug)]
pub struct Parameters<const D: usize = 2>
where
    [f64; D]: Space<D>,
{
    /// Lower and upper end of the periodic domain along each axis, m.
    pub domain: [[f64; 2]; D],
    /// Number of grid points along each axis; lengths with prime factors up to 13 are fastest.
    pub cells: [usize; D],
    /// Box of finer cells with all bodies in it; absent: the bodies are on the cells of the domain.
    pub fine_box: Option<FineBox<D>>,
    /// Box of cells between those of the domain and those of the fine box, which is in it; absent: there is none.
    pub middle_box: Option<MiddleBox<D>>,
    /// Density, kg/m³.
    pub density: f64,
    /// Kinematic viscosity, m²/s.
    pub kinematic_viscosity: f64,
    /// Uniform velocity at t = 0, m/s.
    pub initial_velocity: [f64; D],
    /// Amplitude of the disturbance of the initial velocity, m/s; absent: none.
    pub disturbance: Option<f64>,
    /// Prescribed mean velocity of the domain, m/s; absent: free.
    pub mean_flow: Option<[Law; D]>,
    /// Lower and upper wall along each axis, m; absent: periodic.
    pub walls: [Option<[f64; 2]>; D],
    /// Zone in which the velocity is imposed, with the drag profile of the walls at its ends. A parabola lies between
    /// the walls along y.
    pub inflow: Option<Zone>,
    /// Zone in which the flow is softly drawn to a velocity.
    pub sponge: Option<Zone>,
    /// Velocity that the master adds to the laws of mean flow, inflow and sponge; absent: none.
    pub gust: Option<Gust>,
    /// Rigid bodies.
    pub bodies: Vec<Body<D>>,
    /// Contact of the bodies on a mount; absent: they pass through everything.
    pub contact: Option<Contact<D>>,
    /// Beams, rods and wings: bodies whose nodes are set from outside.
    pub flexible: Vec<Flexible<D>>,
    /// Drag of solids on the fluid.
    pub mask: Mask,
    /// Points at which velocity and pressure are read, m.
    pub probes: Vec<[f64; D]>,
    /// Removal of aliasing errors.
    pub filter: Filter,
    /// Precision of fields and transforms.
    pub precision: Precision,
    /// Largest number of threads; results do not depend on it.
    pub threads: usize,
    /// Time scheme.
    pub scheme: TimeScheme,
    /// Largest step of the fluid, s.
    pub max_step: f64,
    /// Largest CFL number `max(|u|/dx + |v|/dy + …) dt`.
    pub max_cfl: f64,
    /// Usual communication step, s.
    pub communication_step: f64,
    /// Whether loads on the nodes of flexible bodies are predicted for the coming step.
    pub loads: bool,
    /// Whether the pressure around beams with a mask is an output; it needs an inflow.
    pub pressure_around: bool,
}

/// A box of finer cells in the domain. Its rim of some coarse cells is for the flow to become the coarse one.
#[derive(Clone, Copy, Debug)]
pub struct FineBox<const D: usize = 2> {
    /// Number of the point of the domain's grid at its lower end along each axis.
    pub first: [usize; D],
    /// Coarse cells across it along each axis.
    pub cells: [usize; D],
    /// Fine cells in a coarse one along an axis.
    pub ratio: usize,
    /// Body that it follows by whole coarse cells; absent: it stays.
    pub follows: Option<Followed>,
}

/// A box of finer cells in the domain, with still finer ones in it. It moves with these.
#[derive(Clone, Copy, Debug)]
pub struct MiddleBox<const D: usize = 2> {
    /// Number of the point of the domain's grid at its lower end along each axis.
    pub first: [usize; D],
    /// Cells of the domain across it along each axis.
    pub cells: [usize; D],
    /// Its cells in one of the domain along an axis.
    pub ratio: usize,
}

/// What a fine box follows: a body, by its number among those of its kind, or a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Followed {
    /// The centroid of a rigid body.
    Rigid(usize),
    /// The mean of the nodes of a flexible one.
    Flexible(usize),
    /// A point that the master moves, see [`Fluid::box_displacement_mut`](crate::Fluid::box_displacement_mut).
    Master,
}

impl<const D: usize> FineBox<D> {
    /// Width of the rim in which the fine flow is damped to the coarse one, coarse cells. With two cells the numbers of
    /// `studies/two_grids.py` change by at most 0.6 % at a ratio of 2.
    pub const RIM: f64 = 3.0;

    /// Width beyond the rim in which W, the share of the flow that is given back, grows from 0 to 1, coarse cells.
    pub const GROWTH: f64 = 2.0;

    /// Return the cells of the domain that a middle box reaches beyond it, if they move or not.
    fn rim_of_box(moves: bool) -> usize {
        (Self::RIM + Self::GROWTH) as usize + if moves { CELLS_TO_FOLLOW } else { 0 }
    }

    /// Fewest coarse cells across it: both rims, and a body.
    pub const LEAST_CELLS: usize = 2 * (Self::RIM + Self::GROWTH) as usize + 6;

    /// Fine cells in a coarse one.
    pub const RATIOS: RangeInclusive<usize> = 2..=8;

    /// Return the same box in the cells of a larger one around it.
    pub(crate) fn within(&self, around: &Self) -> Self {
        Self {
            first: std::array::from_fn(|axis| (self.first[axis] - around.first[axis]) * around.ratio),
            cells: self.cells.map(|cells| cells * around.ratio),
            ratio: self.ratio / around.ratio,
            follows: self.follows,
        }
    }

    /// Return the cells of a larger box by which it may move back and forth: within a range of coarse cells, and no nearer
    /// to the ends of the larger one, which has its own range, than a body may be.
    pub(crate) fn range_within(&self, around: &Self, of_around: [[f64; 2]; D], own: [[f64; 2]; D]) -> [[f64; 2]; D] {
        let rim = Self::RIM + Self::GROWTH;
        std::array::from_fn(|axis| {
            let before = self.first[axis] as f64 - around.first[axis] as f64 - rim;
            let behind = around.cells[axis] as f64 - self.cells[axis] as f64 - before - 2.0 * rim;
            let [[back, forth], [least, most]] = [own[axis], of_around[axis]];
            [back.max(least - before), forth.min(most + behind)].map(|cells| cells * around.ratio as f64)
        })
    }

    /// Return its grid.
    pub(crate) fn grid(&self, coarse: &Grid<D>) -> Grid<D> {
        let domain = std::array::from_fn(|axis| {
            let low = coarse.coordinate(axis, self.first[axis]);
            [low, low + self.cells[axis] as f64 * coarse.spacing[axis]]
        });
        Grid::new(domain, self.cells.map(|cells| cells * self.ratio))
    }
}

/// A zone across the domain in which the flow is drawn to `(shape(y) · mean_velocity(t), 0)`.
#[derive(Clone, Debug)]
pub struct Zone {
    /// Ends along x, m.
    pub x: [f64; 2],
    /// Whether `shape` is the parabola between the walls of the channel; otherwise it is 1.
    pub parabolic: bool,
    /// Mean velocity, m/s.
    pub mean_velocity: Law,
    /// Relaxation time, s; of a sponge the one in its middle.
    pub c_eta: f64,
}

/// A rigid body.
#[derive(Clone, Debug)]
pub struct Body<const D: usize = 2>
where
    [f64; D]: Space<D>,
{
    /// Name in errors, e.g. `body 2`.
    pub name: String,
    /// Shape, in the axes of the body.
    pub shape: Arc<dyn Shape<D>>,
    /// Position of the pivot, m.
    pub position: [f64; D],
    /// Pivot in the axes of the body, m.
    pub pivot: [f64; D],
    /// Turn from the axes of the domain to those of the body; in the plane an angle, rad, positive to the left.
    pub turn: <[f64; D] as Kinematics<D>>::Turn,
    /// How it moves; absent: still.
    pub motion: Option<Motion<D>>,
    /// Whether the load of the next step is announced, to a unit that moves the body.
    pub announces: bool,
}

/// Contact of bodies on a mount with each other, with all other bodies, and with walls; and of flexible bodies with each
/// other and with bodies on a mount; and of a body that another unit moves with all that moves.
#[derive(Clone, Debug)]
pub struct Contact<const D: usize = 2>
where
    [f64; D]: Space<D>,
{
    /// How they touch.
    pub law: BodyLaw,
    /// Obstacles that the fluid does not see: still, or moved by laws.
    pub obstacles: Vec<Body<D>>,
    /// Lower and upper wall along each axis, m; absent: none.
    pub walls: [Option<[f64; 2]>; D],
    /// Lengths after which everything repeats along each axis of the domain, m; infinite between walls.
    pub periods: [f64; D],
    /// Stiffness of flexible bodies where they meet, of lines per metre, N/m², of surfaces per area, N/m³; it acts at most
    /// as that of their skins.
    pub flexible_stiffness: f64,
    /// Skin of each flexible body; absent: it touches no other one.
    pub skins: Vec<Option<Skin>>,
    /// The body whose load is announced; absent: none touches what moves.
    pub carrier: Option<Carrier>,
}

/// What contact has to know of a body that another unit moves.
#[derive(Clone, Debug)]
pub struct Carrier {
    /// Mass, kg, and least moment of inertia, kg m², infinite where it cannot turn.
    pub inertia: [f64; 2],
    /// Numbers of the flexible bodies that it carries and does not touch.
    pub carries: Vec<usize>,
}

/// How a body moves.
#[derive(Clone, Debug)]
pub enum Motion<const D: usize = 2>
where
    [f64; D]: Space<D>,
{
    /// By laws of time.
    Laws(Laws<D>),
    /// As set from outside for the end of each communication step.
    Master,
    /// On springs and dampers, under the force of the fluid.
    Mount(Mount<D>),
    /// By laws until its release, and from there on, as fast as it is then, on a mount. A step that ends later is free.
    Released {
        /// The laws.
        laws: Laws<D>,
        /// Time of the release, s.
        release: f64,
        /// The mount.
        mount: Mount<D>,
    },
}

/// A motion by laws of time.
#[derive(Clone, Debug)]
pub struct Laws<const D: usize = 2>
where
    [f64; D]: Space<D>,
{
    /// Displacement of the pivot, m.
    pub displacement: [Law; D],
    /// Axis in the domain, of the length 1, in the plane 1, and angle, rad, of the rotations about the pivot after the
    /// turn at rest, in order.
    pub rotations: Vec<(Spin<D>, Law)>,
}

/// A body on springs and dampers. Its centre of mass is the pivot.
#[derive(Clone, Copy, Debug)]
pub struct Mount<const D: usize = 2>
where
    [f64; D]: Space<D>,
{
    /// Mass, kg, in the plane per metre of depth.
    pub mass: f64,
    /// Moments of inertia about the pivot in the axes of the body, kg m², in the plane per metre of depth.
    pub inertia: <[f64; D] as Kinematics<D>>::Inertia,
    /// Spring and damper along each axis, then about z in the plane or each axis in space; absent in a direction in
    /// which the body cannot move.
    pub supports: [Option<Support>; 6],
    /// Gravity, m/s². The fluid carries the body with the weight of what it displaces.
    pub gravity: [f64; D],
}

/// A body with nodes that are set from outside: a beam or rod from root to tip, or a wing.
#[derive(Clone, Debug)]
pub struct Flexible<const D: usize = 2> {
    /// Name in errors, e.g. `the beam`.
    pub name: String,
    /// Nodes at rest, m.
    pub nodes: Vec<[f64; D]>,
    /// What lies between the nodes.
    pub extent: Extent,
    /// Point about which moments are taken, m; absent: the first node.
    pub pivot: Option<[f64; D]>,
}

/// What lies between the nodes of a flexible body, or of the shape of a rigid one.
#[derive(Clone, Debug)]
pub enum Extent {
    /// A line of markers through them, which stands for a plate of 1.5 cells in the plane whatever its thickness.
    Line {
        /// Which ends are free.
        free: [bool; 2],
    },
    /// Such a line for a rod in space, by its diameter at the nodes, m.
    Rod(Vec<f64>),
    /// Triangles, each of three nodes, in space: a surface of markers.
    Surface(Vec<[usize; 3]>),
    /// The mask of a band around the line through them, for a thickness of some cells in the plane.
    Band {
        /// Length, m.
        length: f64,
        /// Thickness at the nodes and at the middles of the segments in turn, m: `[2 segments + 1]`.
        thickness: Vec<f64>,
        /// The circle that the beam is clamped to, by its number among the rigid bodies. It bears the forces on the
        /// mask behind the root.
        support: Option<usize>,
    },
}

impl<const D: usize> Parameters<D>
where
    [f64; D]: Space<D>,
{
    /// Fluid at rest in a periodic domain: double precision, one thread, smooth filter, two-step backward differences
    /// with CFL numbers up to 0.4, and a log-linear mask.
    pub fn new(
        domain: [[f64; 2]; D],
        cells: [usize; D],
        density: f64,
        kinematic_viscosity: f64,
        communication_step: f64,
    ) -> Self {
        Self {
            domain,
            cells,
            fine_box: None,
            middle_box: None,
            density,
            kinematic_viscosity,
            initial_velocity: [0.0; D],
            disturbance: None,
            mean_flow: None,
            walls: [None; D],
            inflow: None,
            sponge: None,
            gust: None,
            bodies: Vec::new(),
            contact: None,
            flexible: Vec::new(),
            mask: Mask::log_linear(1e-5),
            probes: Vec::new(),
            filter: Filter::Smooth,
            precision: Precision::Double,
            threads: 1,
            scheme: TimeScheme::Sbdf2,
            max_step: communication_step,
            max_cfl: 0.4,
            communication_step,
            loads: true,
            pressure_around: false,
        }
    }

    /// Refuse fewer cells than the transforms work on: blocks of lines along the axis before the last.
    pub(crate) fn check_cells(&self) -> Result<(), Error> {
        const NAMES: [&str; 3] = ["number of cells along x", "number of cells along y", "number of cells along z"];
        for (axis, (name, cells)) in NAMES.into_iter().zip(self.cells).enumerate() {
            let (least, allowed) = if axis + 2 == D {
                (self.precision.fewest_columns(), "at least 8, or 16 in single precision")
            } else {
                (8, "at least 8")
            };
            if cells < least {
                return Err(Error::Parameter { name, value: cells as f64, allowed });
            }
        }
        Ok(())
    }

    /// Refuse a fine box that has no room between its rims, or is not well within the domain, between walls and zones; and
    /// the same of a middle box, which must be well around it.
    pub(crate) fn check_boxes(&self) -> Result<(), Error> {
        let (Some(fine), middle) = (&self.fine_box, &self.middle_box) else {
            let lacks_fine = self.middle_box.map(|_| Error::MiddleBox("has no fine box in it".into()));
            return lacks_fine.map_or(Ok(()), Err);
        };
        let between = middle.map_or(1, |middle| middle.ratio.max(1));
        self.check_box(fine, between).map_err(Error::FineBox)?;
        let Some(middle) = self.middle() else { return Ok(()) };
        self.check_box(&middle, 1).map_err(Error::MiddleBox)?;
        if fine.ratio <= middle.ratio || !fine.ratio.is_multiple_of(middle.ratio) {
            let (own, finest) = (middle.ratio, fine.ratio);
            let reason =
                format!("has cells {own} times as fine, of which the {finest} of the fine box are no multiple");
            return Err(Error::MiddleBox(reason));
        }
        let rim = FineBox::<D>::rim_of_box(fine.follows.is_some());
        for (axis, name) in AXES.into_iter().enumerate().take(D) {
            let [low, high] = [fine.first[axis], fine.first[axis] + fine.cells[axis]];
            if low < middle.first[axis] + rim || high + rim > middle.first[axis] + middle.cells[axis] {
                return Err(Error::MiddleBox(format!(
                    "must reach {rim} coarse cells beyond the fine box along {name}"
                )));
            }
        }
        Ok(())
    }

    /// Return what is wrong with a fine box in whose place each cell of the domain is `between` cells.
    fn check_box(&self, fine: &FineBox<D>, between: usize) -> Result<(), String> {
        let refuse = |reason: String| Err(reason);
        let (grid, least) = (self.grid(), FineBox::<D>::LEAST_CELLS);
        let own = fine.grid(&grid);
        let ends = |axis: usize| [0.0, own.size[axis]].map(|of| own.coordinate(axis, 0) + of);
        if !FineBox::<D>::RATIOS.contains(&fine.ratio) {
            let [low, high] = [FineBox::<D>::RATIOS.start(), FineBox::<D>::RATIOS.end()];
            return refuse(format!("has cells {} times as fine, but it must be {low} to {high} times", fine.ratio));
        }
        if self.scheme != TimeScheme::Sbdf2 {
            return refuse("needs the scheme sbdf2".into());
        }
        if self.pressure_around {
            return refuse("does not reach the outlet, from which the pressure around a beam is taken".into());
        }
        for (axis, name) in AXES.into_iter().enumerate().take(D) {
            let (cells, [low, high]) = (fine.cells[axis] * between, ends(axis));
            if cells < least {
                return refuse(format!("has {cells} coarse cells along {name}, but it needs {least}"));
            }
            if fine.first[axis] + fine.cells[axis] > grid.cells[axis] {
                return refuse(format!("reaches along {name} from {low:.6e} to {high:.6e} m, out of the domain"));
            }
            let rounding = TOUCH_CELLS * grid.spacing[axis];
            let crosses = |[from, to]: &[f64; 2]| low < from - rounding || high > to + rounding;
            if let Some([from, to]) = self.walls[axis].filter(crosses) {
                let walls = format!("the walls at {from:.6e} and {to:.6e} m");
                return refuse(format!("reaches along {name} from {low:.6e} to {high:.6e} m, through {walls}"));
            }
        }
        let ([low, high], rounding) = (ends(0), TOUCH_CELLS * grid.spacing[0]);
        for (name, zone) in [("inflow", &self.inflow), ("sponge", &self.sponge)] {
            if let Some(Zone { x: [from, to], .. }) = zone
                && low < to - rounding
                && high > from + rounding
            {
                let zone = format!("the {name} from {from:.6e} to {to:.6e} m");
                return refuse(format!("reaches along x from {low:.6e} to {high:.6e} m, into {zone}"));
            }
        }
        let known = match fine.follows {
            None | Some(Followed::Master) => true,
            Some(Followed::Rigid(body)) => body < self.bodies.len(),
            Some(Followed::Flexible(body)) => self.flexible.get(body).is_some_and(|body| !body.nodes.is_empty()),
        };
        if !known {
            return refuse("follows a body that does not exist".into());
        }
        Ok(())
    }

    /// Return the coarse cells by which a fine box may move back and forth along each axis, between walls and zones.
    pub(crate) fn range_of_fine_box(&self, fine: &FineBox<D>) -> [[f64; 2]; D] {
        std::array::from_fn(|axis| self.range_along(fine, axis))
    }

    fn range_along(&self, fine: &FineBox<D>, axis: usize) -> [f64; 2] {
        let (grid, own) = (self.grid(), fine.grid(&self.grid()));
        let (spacing, size) = (grid.spacing[axis], grid.size[axis]);
        let [low, high] = [0.0, own.size[axis]].map(|of| own.coordinate(axis, 0) + of);
        let zones = [&self.inflow, &self.sponge].into_iter().flatten().filter(|_| axis == 0);
        // What lies from one end to the other, periodically, the box may not enter.
        let walls = self.walls[axis].map(|[from, to]| [to, from + size]);
        let closed = zones.map(|zone| zone.x).chain(walls);
        closed.fold([f64::NEG_INFINITY, f64::INFINITY], |[back, forth], [from, to]| {
            // Whole cells of a gap that is less than a period.
            let cells = |gap: f64| ((gap / spacing + TOUCH_CELLS).rem_euclid(size / spacing)).floor();
            [back.max(-cells(low - to)), forth.min(cells(from - high))]
        })
    }

    pub(crate) fn check_body(&self, body: &Body<D>) -> Result<(), Error> {
        let implicit = self.scheme == TimeScheme::Sbdf2;
        if let Some(thin) = body.thin() {
            if !implicit {
                return Err(Error::LineScheme);
            }
            self.check_thin(&thin)?;
        }
        if let Some(Motion::Released { release, .. }) = body.motion
            && !(release.is_finite() && release >= 0.0)
        {
            let (name, allowed) = ("time of the release of a body", "a finite number of at least 0");
            return Err(Error::Parameter { name, value: release, allowed });
        }
        let Some(mount) = body.mount() else { return Ok(()) };
        if !implicit {
            return Err(Error::MountScheme);
        }
        let (about, displaced) = (&mount.supports[D..], self.displaced_by(body));
        let turns = (D..<[f64; D]>::FREEDOMS).filter(|i| about[i - D].is_some());
        let moves = mount.supports[..D].iter().any(Option::is_some);
        let own = mount.own_inertia();
        require_positive("mass of a body on springs", mount.mass)?;
        turns.clone().try_for_each(|i| require_positive("moment of inertia of a body on springs", own[i]))?;
        let name = |i: usize| if i < D { "mass" } else { "moment of inertia" };
        for i in moves.then_some(0).into_iter().chain(turns) {
            if body.shape.radius().is_none() && own[i] < displaced[i] {
                return Err(Error::LightBody { name: name(i), value: own[i], displaced: displaced[i] });
            }
        }
        Ok(())
    }

    /// Return the mass of the fluid that a body displaces along each axis, then its moments of inertia about the axes of
    /// the body through the pivot.
    fn displaced_by(&self, body: &Body<D>) -> Freedoms {
        let (mass, inertia) = body.shape.moments(&self.grid().size).about(body.pivot, self.density);
        freedoms::<D>(mass, inertia)
    }

    pub(crate) fn check_flexible(&self, body: &Flexible<D>) -> Result<(), Error> {
        let Extent::Band { thickness, support, .. } = &body.extent else { return self.check_thin(body) };
        let segments = body.nodes.len().saturating_sub(1);
        if segments < 2 || thickness.len() != 2 * segments + 1 {
            let allowed = "twice the number of segments plus 1, of at least 2 segments";
            return Err(Error::Parameter {
                name: "number of thicknesses of a beam",
                value: thickness.len() as f64,
                allowed,
            });
        }
        if D != 2 {
            return Err(Error::Parameter {
                name: "number of dimensions of a mask of a beam",
                value: 3.0,
                allowed: "2",
            });
        }
        match support {
            Some(body) if *body >= self.bodies.len() => {
                let allowed = "less than the number of rigid bodies";
                Err(Error::Parameter { name: "cylinder of a beam", value: *body as f64, allowed })
            }
            _ => Ok(()),
        }
    }

    /// Refuse a thin body without an extent, or with more markers than a step has time for.
    fn check_thin(&self, body: &Flexible<D>) -> Result<(), Error> {
        let count = body.markers(self.grid_of_bodies().cell_size()).unwrap_or(0.0);
        if count == 0.0 {
            let allowed = "above 0: a line has two nodes, a surface triangles of its nodes";
            return Err(Error::Parameter { name: "extent of a thin body", value: 0.0, allowed });
        }
        if count.is_nan() || count > MOST_CELLS {
            let allowed = "at most 4e4: coarser cells or a smaller body";
            return Err(Error::Parameter { name: "extent of a thin body in cells", value: count, allowed });
        }
        if let Extent::Rod(diameters) = &body.extent {
            if diameters.len() != body.nodes.len() {
                let (value, allowed) = (diameters.len() as f64, "one of each node");
                return Err(Error::Parameter { name: "number of diameters of a rod", value, allowed });
            }
            diameters.iter().try_for_each(|diameter| require_positive("diameter of a rod", *diameter))?;
        }
        Ok(())
    }

    /// Return the grid of the domain.
    pub(crate) fn grid(&self) -> Grid<D> {
        Grid::new(self.domain, self.cells)
    }

    /// Return the number of cells, of all grids.
    pub(crate) fn all_cells(&self) -> usize {
        let grid = self.grid();
        let boxes = self.fine_box.into_iter().chain(self.middle());
        grid.len() + boxes.map(|own| own.grid(&grid).len()).sum::<usize>()
    }

    /// Return the middle box as a fine one of the domain; absent where there is none, or no fine box in it.
    pub(crate) fn middle(&self) -> Option<FineBox<D>> {
        let (fine, MiddleBox { first, cells, ratio }) = (self.fine_box?, self.middle_box?);
        Some(FineBox { first, cells, ratio, follows: fine.follows.map(|_| Followed::Master) })
    }

    /// Return the grid with the bodies: that of the fine box, or of the domain.
    pub(crate) fn grid_of_bodies(&self) -> Grid<D> {
        let grid = self.grid();
        self.fine_box.as_ref().map_or(grid, |fine| fine.grid(&grid))
    }

    /// Return the parameters of the fluid around the bodies: in the fine box without walls and zones, or the same.
    pub(crate) fn around_bodies(&self) -> Cow<'_, Self> {
        self.fine_box.as_ref().map_or(Cow::Borrowed(self), |fine| Cow::Owned(self.within(fine)))
    }

    /// Return the parameters in a box of finer cells, without walls and zones.
    pub(crate) fn within(&self, fine: &FineBox<D>) -> Self {
        let grid = fine.grid(&self.grid());
        Self {
            domain: std::array::from_fn(|axis| {
                let low = grid.coordinate(axis, 0);
                [low, low + grid.size[axis]]
            }),
            cells: grid.cells,
            fine_box: None,
            middle_box: None,
            mean_flow: None,
            walls: [None; D],
            inflow: None,
            sponge: None,
            ..self.clone()
        }
    }

    /// Return the parameters of the same fluid without bodies.
    pub(crate) fn without_bodies(&self) -> Self {
        Self { bodies: vec![], flexible: vec![], ..self.clone() }
    }

    /// Return the number of markers of the thin bodies, about.
    pub(crate) fn markers(&self) -> usize {
        let cell = self.grid_of_bodies().cell_size();
        self.thin().filter_map(|(_, body)| body.markers(cell)).sum::<f64>() as usize
    }

    /// Return the thin bodies, first the flexible ones, with the number of each among all bodies, of which the rigid
    /// ones are first.
    pub(crate) fn thin(&self) -> impl Iterator<Item = (usize, Cow<'_, Flexible<D>>)> {
        let flexible = (self.bodies.len()..).zip(&self.flexible).map(|(k, body)| (k, Cow::Borrowed(body)));
        let rigid = self.bodies.iter().enumerate().filter_map(|(k, body)| Some((k, Cow::Owned(body.thin()?))));
        flexible.filter(|(_, body)| !matches!(body.extent, Extent::Band { .. })).chain(rigid)
    }
}

pub(crate) fn require_positive(name: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(Error::Parameter { name, value, allowed: "a finite number above 0" })
}

impl<const D: usize> Body<D>
where
    [f64; D]: Space<D>,
{
    /// A still body with its pivot (m) at the origin of its axes, which are those of the domain.
    pub fn still(name: impl Into<String>, shape: impl Shape<D> + 'static, position: [f64; D]) -> Self {
        let (name, shape, turn) = (name.into(), Arc::new(shape), Default::default());
        Self { name, shape, position, pivot: [0.0; D], turn, motion: None, announces: false }
    }

    /// Return the laws that move it, of a body that is released until then.
    pub fn laws(&self) -> Option<&Laws<D>> {
        match &self.motion {
            Some(Motion::Laws(laws) | Motion::Released { laws, .. }) => Some(laws),
            _ => None,
        }
    }

    /// Return its mount, of a body that is released from then on.
    pub fn mount(&self) -> Option<&Mount<D>> {
        match &self.motion {
            Some(Motion::Mount(mount) | Motion::Released { mount, .. }) => Some(mount),
            _ => None,
        }
    }

    /// Return a thin body as one with nodes, in its own axes; none of a solid.
    pub(crate) fn thin(&self) -> Option<Flexible<D>> {
        let (nodes, between) = self.shape.thin()?;
        let extent = match between {
            Between::Line => Extent::Line { free: [true; 2] },
            Between::Triangles(triangles) => Extent::Surface(triangles),
        };
        Some(Flexible { name: self.name.clone(), nodes, extent, pivot: None })
    }
}

impl<const D: usize> Flexible<D> {
    /// Return the number of markers on cells of a size (m), about; none of nodes that do not exist, and of a mask.
    fn markers(&self, cell: f64) -> Option<f64> {
        match &self.extent {
            Extent::Line { .. } | Extent::Rod(_) => {
                let square = |ends: &[[f64; D]]| (0..D).map(|k| (ends[1][k] - ends[0][k]).powi(2)).sum::<f64>();
                Some(self.nodes.windows(2).map(|ends| square(ends).sqrt()).sum::<f64>() / cell)
            }
            Extent::Surface(triangles) => {
                let known = triangles.as_flattened().iter().all(|node| *node < self.nodes.len());
                known.then(|| mesh::area(&self.nodes_in_space(), triangles) / (cell * cell))
            }
            Extent::Band { .. } => None,
        }
    }

    /// Return the nodes with three coordinates, m.
    pub(crate) fn nodes_in_space(&self) -> Vec<[f64; 3]> {
        let coordinate = |node: &[f64; D], axis: usize| node.get(axis).copied().unwrap_or(0.0);
        self.nodes.iter().map(|node| [0, 1, 2].map(|axis| coordinate(node, axis))).collect()
    }
}

impl<const D: usize> Motion<D>
where
    [f64; D]: Space<D>,
{
    /// A motion by laws, with an axis of any length above 0.
    pub fn laws(displacement: [Law; D], axis: Spin<D>, angle: Law) -> Self {
        Self::of_rotations(displacement, [(axis, angle)])
    }

    /// A motion by laws with one rotation or more, about axes of any length above 0.
    pub fn of_rotations(displacement: [Law; D], rotations: impl IntoIterator<Item = (Spin<D>, Law)>) -> Self {
        let length = |axis| <[f64; D]>::components(axis).iter().fold(0.0_f64, |length, part| length.hypot(*part));
        let rotations = rotations.into_iter().map(|(axis, angle)| (axis / length(axis), angle)).collect();
        Self::Laws(Laws { displacement, rotations })
    }
}

impl<const D: usize> Mount<D>
where
    [f64; D]: Space<D>,
{
    /// Return the mass along each axis, then the moments of inertia about z in the plane or the axes of the body.
    pub(crate) fn own_inertia(&self) -> Freedoms {
        freedoms::<D>(self.mass, self.inertia)
    }

    /// Return the mass and the least moment of inertia about an axis about which the body turns; infinite without one.
    pub(crate) fn least_inertia(&self) -> [f64; 2] {
        let about = (D..<[f64; D]>::FREEDOMS).filter(|i| self.free()[*i]).map(|i| self.own_inertia()[i]);
        [self.mass, about.fold(f64::INFINITY, f64::min)]
    }

    /// Return whether it lets the body move along each freedom.
    pub(crate) fn free(&self) -> [bool; 6] {
        self.supports.map(|support| support.is_some())
    }
}

/// Return a mass along each axis, then the moments of inertia.
fn freedoms<const D: usize>(mass: f64, inertia: <[f64; D] as Kinematics<D>>::Inertia) -> Freedoms
where
    [f64; D]: Space<D>,
{
    let about = <[f64; D]>::diagonal(inertia);
    std::array::from_fn(|i| if i < D { mass } else { about.get(i - D).copied().unwrap_or(0.0) })
}
