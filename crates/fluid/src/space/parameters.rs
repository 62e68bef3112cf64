//! Parameters of a fluid in space: plain data, in SI units.

use crate::error::Error;
use crate::parameters::{Filter, Law, Mask, Precision, Zone};

/// A fluid in space. [`Parameters::new`] has every default: a periodic domain without a body.
#[derive(Clone, Debug)]
pub struct Parameters {
    /// Lower and upper end of the periodic domain along x, y and z, m.
    pub domain: [[f64; 2]; 3],
    /// Number of grid points along x, y and z; lengths with prime factors up to 13 are fastest.
    pub cells: [usize; 3],
    /// Density, kg/m³.
    pub density: f64,
    /// Kinematic viscosity, m²/s.
    pub kinematic_viscosity: f64,
    /// Uniform velocity at t = 0, m/s.
    pub initial_velocity: [f64; 3],
    /// Prescribed mean velocity of the domain, m/s; absent: free.
    pub mean_flow: Option<[Law; 3]>,
    /// Lower and upper wall along each axis, m; absent: periodic.
    pub walls: [Option<[f64; 2]>; 3],
    /// Zone in which the velocity is imposed, with the drag profile of the walls at its ends. A parabola lies between the
    /// walls along y.
    pub inflow: Option<Zone>,
    /// Zone in which the flow is softly drawn to a velocity.
    pub sponge: Option<Zone>,
    /// Rigid bodies.
    pub bodies: Vec<Body>,
    /// Drag of solids on the fluid.
    pub mask: Mask,
    /// Points at which velocity and pressure are read, m.
    pub probes: Vec<[f64; 3]>,
    /// Removal of aliasing errors.
    pub filter: Filter,
    /// Precision of fields and transforms.
    pub precision: Precision,
    /// Largest number of threads; results do not depend on it.
    pub threads: usize,
    /// Largest step of the fluid, s.
    pub max_step: f64,
    /// Largest CFL number `max(|u|/dx + |v|/dy + |w|/dz) dt`.
    pub max_cfl: f64,
    /// Usual communication step, s.
    pub communication_step: f64,
}

/// A rigid body.
#[derive(Clone, Debug)]
pub struct Body {
    /// Shape, in the axes of the body.
    pub shape: Shape,
    /// Position of the pivot, m.
    pub position: [f64; 3],
    /// Pivot in the axes of the body, m.
    pub pivot: [f64; 3],
    /// Turn from the axes of the domain to those of the body.
    pub turn: Turn,
    /// Prescribed motion; absent: still.
    pub motion: Option<Motion>,
}

/// A turn about an axis.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// Axis, of any length above 0.
    pub axis: [f64; 3],
    /// Angle, rad, positive by the right-hand rule.
    pub angle: f64,
}

/// Prescribed motion of a body.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Displacement of the pivot, m.
    pub displacement: [Law; 3],
    /// Axis in the domain about which the body turns, of any length above 0.
    pub axis: [f64; 3],
    /// Angle, rad, after the turn at rest.
    pub angle: Law,
}

/// Shape of a body, about the origin of its axes.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Sphere of a radius, m.
    Sphere(f64),
    /// Ellipsoid of semi-axes, m.
    Ellipsoid([f64; 3]),
    /// Circular cylinder.
    Cylinder {
        /// Axis of the body along which it lies: 0, 1 or 2.
        axis: usize,
        /// Radius, m.
        radius: f64,
        /// Half the length, m; infinite for a cylinder through the whole domain.
        half_length: f64,
    },
    /// Cuboid of half its lengths, m; a plate is a thin one.
    Cuboid([f64; 3]),
}

impl Parameters {
    /// Fluid at rest in a periodic domain: double precision, one thread, smooth filter, and CFL numbers up to 0.4.
    pub fn new(
        domain: [[f64; 2]; 3],
        cells: [usize; 3],
        density: f64,
        kinematic_viscosity: f64,
        communication_step: f64,
    ) -> Self {
        Self {
            domain,
            cells,
            density,
            kinematic_viscosity,
            initial_velocity: [0.0; 3],
            mean_flow: None,
            walls: [None; 3],
            inflow: None,
            sponge: None,
            bodies: Vec::new(),
            mask: Mask::log_linear(1e-5),
            probes: Vec::new(),
            filter: Filter::Smooth,
            precision: Precision::Double,
            threads: 1,
            max_step: communication_step,
            max_cfl: 0.4,
            communication_step,
        }
    }

    /// Refuse numbers with which no step can be made.
    pub(super) fn check(&self) -> Result<(), Error> {
        let [x, y, z] = self.domain.map(|[low, high]| high - low);
        let numbers = [
            ("width of the domain along x", x),
            ("width of the domain along y", y),
            ("width of the domain along z", z),
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
        let [nx, ny, nz] = self.cells;
        let least = self.precision.least_block();
        for (name, cells, least, allowed) in [
            ("number of cells along x", nx, 8, "at least 8"),
            ("number of cells along y", ny, least, "at least 8, or 16 in single precision"),
            ("number of cells along z", nz, 8, "at least 8"),
        ] {
            if cells < least {
                return Err(Error::Parameter { name, value: cells as f64, allowed });
            }
        }
        Ok(())
    }
}
