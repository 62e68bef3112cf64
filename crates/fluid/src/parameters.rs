//! Parameters of a fluid: plain data, in SI units, per metre of depth.

use std::fmt;
use std::sync::Arc;

use crate::error::Error;

/// A fluid and the bodies in it. [`Parameters::new`] has every default: a periodic domain without a body.
#[derive(Clone, Debug)]
pub struct Parameters {
    /// Lower and upper end of the periodic domain along x and y, m.
    pub domain: [[f64; 2]; 2],
    /// Number of grid points along x and y; lengths with prime factors up to 13 are fastest.
    pub cells: [usize; 2],
    /// Density, kg/m³.
    pub density: f64,
    /// Kinematic viscosity, m²/s.
    pub kinematic_viscosity: f64,
    /// Uniform velocity at t = 0, m/s.
    pub initial_velocity: [f64; 2],
    /// Amplitude of the disturbance of the initial velocity, m/s; absent: none.
    pub disturbance: Option<f64>,
    /// Prescribed mean velocity of the domain, m/s; absent: free.
    pub mean_flow: Option<[Law; 2]>,
    /// y of the lower and the upper wall of a channel, m.
    pub channel: Option<[f64; 2]>,
    /// Zone in which the velocity is imposed, with the drag profile of the walls at its ends.
    pub inflow: Option<Zone>,
    /// Zone in which the flow is softly drawn to a velocity.
    pub sponge: Option<Zone>,
    /// Circular cylinders.
    pub cylinders: Vec<Cylinder>,
    /// Other rigid bodies.
    pub bodies: Vec<Body>,
    /// Beams.
    pub beams: Vec<Beam>,
    /// Drag of solids on the fluid.
    pub mask: Mask,
    /// Points at which velocity and pressure are read, m.
    pub probes: Vec<[f64; 2]>,
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
    /// Largest CFL number `max(|u|/dx + |v|/dy) dt`.
    pub max_cfl: f64,
    /// Usual communication step, s.
    pub communication_step: f64,
    /// Whether loads on the stations of the beams are predicted for the coming step.
    pub loads: bool,
    /// Whether the pressure around the beams is an output; it needs an inflow.
    pub pressure_around: bool,
}

/// A function of time (s) with its rate.
#[derive(Clone)]
pub struct Law(Arc<dyn Fn(f64) -> (f64, f64) + Send + Sync>);

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

/// A circular cylinder.
#[derive(Clone, Debug)]
pub struct Cylinder {
    /// Centre, m.
    pub center: [f64; 2],
    /// Radius, m.
    pub radius: f64,
    /// Prescribed displacement, m; absent: still.
    pub motion: Option<[Law; 2]>,
}

/// A rigid body.
#[derive(Clone, Debug)]
pub struct Body {
    /// Outline, in the axes of the body.
    pub shape: Shape,
    /// Position of the pivot, m.
    pub position: [f64; 2],
    /// Pivot in the axes of the body, m.
    pub pivot: [f64; 2],
    /// Angle from the x axis to the body's, rad, positive to the left.
    pub angle: f64,
    /// How it moves; absent: still.
    pub motion: Option<Motion>,
}

/// How a body moves.
#[derive(Clone, Debug)]
pub enum Motion {
    /// By laws of time.
    Laws {
        /// Displacement of the pivot, m.
        displacement: [Law; 2],
        /// Angle that is added, rad.
        angle: Law,
    },
    /// As set from outside for the end of each communication step.
    Master,
    /// On springs and dampers, under the force of the fluid.
    Mount(Mount),
}

/// A body on springs and dampers. Its centre of mass is the pivot.
#[derive(Clone, Copy, Debug)]
pub struct Mount {
    /// Mass, kg per metre of depth.
    pub mass: f64,
    /// Moment of inertia about the pivot, kg m²/m.
    pub inertia: f64,
    /// Spring and damper along x and y and about the pivot; absent in a direction in which the body cannot move.
    pub supports: [Option<Support>; 3],
}

/// A spring and a damper in parallel.
#[derive(Clone, Copy, Debug)]
pub struct Support {
    /// Stiffness, N/m or N m/rad, per metre of depth.
    pub stiffness: f64,
    /// Damping, N s/m or N m s/rad, per metre of depth.
    pub damping: f64,
    /// Displacement or angle at which the spring has no force, m or rad.
    pub rest: f64,
}

/// Outline of a body, about the origin of its axes.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Circle of a radius, m.
    Circle(f64),
    /// Ellipse of semi-axes, m.
    Ellipse([f64; 2]),
    /// Rectangle of half its length and half its thickness, m.
    Rectangle([f64; 2]),
    /// Rectangle whose ends are half circles: half the length of its straight sides, and half its thickness, m.
    Capsule([f64; 2]),
    /// Polygon of at least 3 corners in either order, m. Its sides must not cross.
    Polygon(Vec<[f64; 2]>),
    /// Open line of no thickness through at least 2 points, m: markers drag the fluid, as at a beam with
    /// [`Surface::Line`].
    Line(Vec<[f64; 2]>),
}

/// A beam: a band around the line of its stations.
#[derive(Clone, Debug)]
pub struct Beam {
    /// Stations at rest from root to tip, m, at least 3.
    pub stations: Vec<[f64; 2]>,
    /// Length, m.
    pub length: f64,
    /// Thickness at the stations and at the middles of the segments in turn, m: `[2 segments + 1]`.
    pub thickness: Vec<f64>,
    /// The cylinder that the beam is clamped to. It bears the forces on the mask behind the root.
    pub support_cylinder: Option<usize>,
    /// How it meets the fluid.
    pub surface: Surface,
}

/// How a beam meets the fluid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surface {
    /// By the mask of the band around its line, for a thickness of some cells.
    Mask,
    /// By markers along its line, which stands for a plate of 1.5 cells whatever its thickness.
    Line,
}

/// Drag rate of a solid as a function of the signed distance to its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mask {
    /// `1/c_eta` inside (thesis ch. 3).
    Sharp {
        /// Relaxation time C_eta, s.
        c_eta: f64,
        /// Whether the wall is shifted so that no-slip holds at the surface.
        displacement_corrected: bool,
    },
    /// Cosine layer around the surface (thesis eq. 4.1; Hester, Vasil & Burns 2021).
    Cosine {
        /// Relaxation time C_eta, s.
        c_eta: f64,
        /// Half the width of the layer, cells.
        half_width: f64,
        /// Whether the layer is shifted so that no-slip holds at the surface.
        displacement_corrected: bool,
    },
    /// Exponential growth with the depth, so that no-slip holds at the surface for any position of the grid.
    LogLinear {
        /// Smallest relaxation time, s.
        c_eta: f64,
        /// Length over which the drag grows by e, cells.
        decay_length_cells: f64,
        /// Depth at which the core of a still body begins, cells; absent: the default depth.
        core_depth: Option<f64>,
        /// Correction of the velocity at the surface.
        wall_correction: WallCorrection,
    },
}

/// Velocity to which a body draws the fluid at its surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WallCorrection {
    /// The velocity of the body.
    None,
    /// Inside, weakly, the mirror image of the flow outside.
    Shear,
    /// Also a second difference of the flow outside.
    Curvature,
}

/// Removal of aliasing errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// `exp(−36 (k/k_max)³⁶)` (Hou & Li 2007).
    Smooth,
    /// Truncation outside the ellipse of two thirds (thesis eq. 3.14).
    TwoThirds,
    /// None.
    None,
}

/// Precision of fields and transforms; bodies, forces and loads are in double precision in both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// `f64`.
    Double,
    /// `f32`.
    Single,
}

/// Time scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeScheme {
    /// Two-step backward differences, drag and viscosity implicit.
    Sbdf2,
    /// Heun's method, drag explicit, viscosity exact.
    Rk2,
}

impl Parameters {
    /// Fluid at rest in a periodic domain: double precision, one thread, smooth filter, two-step backward differences
    /// with CFL numbers up to 0.4, and a log-linear mask.
    pub fn new(
        domain: [[f64; 2]; 2],
        cells: [usize; 2],
        density: f64,
        kinematic_viscosity: f64,
        communication_step: f64,
    ) -> Self {
        Self {
            domain,
            cells,
            density,
            kinematic_viscosity,
            initial_velocity: [0.0; 2],
            disturbance: None,
            mean_flow: None,
            channel: None,
            inflow: None,
            sponge: None,
            cylinders: Vec::new(),
            bodies: Vec::new(),
            beams: Vec::new(),
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

    /// Refuse numbers with which no step can be made.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let [x, y] = self.domain.map(|[low, high]| high - low);
        let numbers = [
            ("width of the domain along x", x),
            ("width of the domain along y", y),
            ("density", self.density),
            ("kinematic viscosity", self.kinematic_viscosity),
            ("C_eta of the mask", self.mask.c_eta()),
            ("largest step", self.max_step),
            ("largest CFL number", self.max_cfl),
            ("communication step", self.communication_step),
        ];
        for (name, value) in numbers {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::Parameter { name, value, allowed: "a finite number above 0" });
            }
        }
        let [nx, ny] = self.cells;
        if nx < self.precision.least_block() {
            let allowed = "at least 8, or 16 in single precision";
            return Err(Error::Parameter { name: "number of cells along x", value: nx as f64, allowed });
        }
        if ny < 8 {
            return Err(Error::Parameter { name: "number of cells along y", value: ny as f64, allowed: "at least 8" });
        }
        for body in &self.bodies {
            if let Shape::Line(points) = &body.shape {
                if self.scheme != TimeScheme::Sbdf2 {
                    return Err(Error::LineScheme);
                }
                if points.len() < 2 {
                    let (name, value) = ("number of points of a line", points.len() as f64);
                    return Err(Error::Parameter { name, value, allowed: "at least 2" });
                }
            }
            let Some(Motion::Mount(mount)) = &body.motion else { continue };
            if self.scheme != TimeScheme::Sbdf2 {
                return Err(Error::MountScheme);
            }
            for (name, value, used) in [
                ("mass of a body on springs", mount.mass, true),
                ("moment of inertia of a body on springs", mount.inertia, mount.supports[2].is_some()),
            ] {
                if used && !(value.is_finite() && value > 0.0) {
                    return Err(Error::Parameter { name, value, allowed: "a finite number above 0" });
                }
            }
            let round = matches!(body.shape, Shape::Circle(_));
            let [mass, inertia] = body.displaced(self.density);
            for (name, value, displaced, used) in [
                ("mass", mount.mass, mass, mount.supports[0].or(mount.supports[1]).is_some()),
                ("moment of inertia", mount.inertia, inertia, mount.supports[2].is_some()),
            ] {
                if used && !round && value < displaced {
                    return Err(Error::LightBody { name, value, displaced });
                }
            }
        }
        for beam in &self.beams {
            let segments = beam.stations.len().saturating_sub(1);
            if segments < 2 || beam.thickness.len() != 2 * segments + 1 {
                let allowed = "twice the number of segments plus 1, of at least 2 segments";
                let value = beam.thickness.len() as f64;
                return Err(Error::Parameter { name: "number of thicknesses of a beam", value, allowed });
            }
            if beam.support_cylinder.is_some_and(|cylinder| cylinder >= self.cylinders.len()) {
                let value = beam.support_cylinder.map_or(0.0, |cylinder| cylinder as f64);
                let allowed = "less than the number of cylinders";
                return Err(Error::Parameter { name: "cylinder of a beam", value, allowed });
            }
        }
        Ok(())
    }
}

impl Law {
    /// A law from its value and its rate (1/s) at a time (s).
    pub fn new(value_and_rate: impl Fn(f64) -> (f64, f64) + Send + Sync + 'static) -> Self {
        Self(Arc::new(value_and_rate))
    }

    /// A constant value.
    pub fn constant(value: f64) -> Self {
        Self::new(move |_| (value, 0.0))
    }

    /// Return the value at a time (s).
    pub fn value(&self, t: f64) -> f64 {
        self.value_and_rate(t).0
    }

    /// Return the value and its rate (1/s) at a time (s).
    pub fn value_and_rate(&self, t: f64) -> (f64, f64) {
        (self.0)(t)
    }
}

impl fmt::Debug for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Law")
    }
}

impl Mask {
    /// A log-linear mask with the default decay length of a quarter of a cell and the correction of curvature.
    pub fn log_linear(c_eta: f64) -> Self {
        Self::LogLinear {
            c_eta,
            decay_length_cells: 0.25,
            core_depth: None,
            wall_correction: WallCorrection::Curvature,
        }
    }

    /// Return the relaxation time C_eta deep inside a solid, s.
    pub fn c_eta(&self) -> f64 {
        match *self {
            Self::Sharp { c_eta, .. } | Self::Cosine { c_eta, .. } | Self::LogLinear { c_eta, .. } => c_eta,
        }
    }
}

impl Precision {
    /// Return the size of a number, bytes.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::Double => size_of::<f64>(),
            Self::Single => size_of::<f32>(),
        }
    }

    /// Return the lines that a block of the transforms needs.
    pub(crate) fn least_block(self) -> usize {
        match self {
            Self::Double => 8,
            Self::Single => 16,
        }
    }
}

/// A cylinder is a circle that does not turn.
impl From<&Cylinder> for Body {
    fn from(cylinder: &Cylinder) -> Self {
        let motion =
            |displacement: &[Law; 2]| Motion::Laws { displacement: displacement.clone(), angle: Law::constant(0.0) };
        Self {
            shape: Shape::Circle(cylinder.radius),
            position: cylinder.center,
            pivot: [0.0; 2],
            angle: 0.0,
            motion: cylinder.motion.as_ref().map(motion),
        }
    }
}
