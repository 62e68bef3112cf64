//! Parameters of a fluid in space: plain data, in SI units.

use std::borrow::Cow;

use crate::error::Error;
use crate::grid::Grid;
use crate::parameters::{Filter, Law, Mask, Precision, Zone};

/// Largest extent of a thin body, cells: more markers take too long to be spread over it.
const MOST_CELLS: f64 = 4e4;

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
    /// Zone in which the velocity is imposed, with the drag profile of the walls at its ends. A parabola lies between
    /// the walls along y.
    pub inflow: Option<Zone>,
    /// Zone in which the flow is softly drawn to a velocity.
    pub sponge: Option<Zone>,
    /// Rigid bodies.
    pub bodies: Vec<Body>,
    /// Thin bodies, whose nodes are set from outside.
    pub flexible: Vec<Flexible>,
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

/// A thin body, which markers represent, with nodes that are set from outside.
#[derive(Clone, Debug)]
pub struct Flexible {
    /// Name in errors, e.g. `the wing`.
    pub name: String,
    /// Nodes at rest, m.
    pub nodes: Vec<[f64; 3]>,
    /// What lies between the nodes.
    pub extent: Extent,
    /// Point about which moments are taken, m; absent: the first node.
    pub pivot: Option<[f64; 3]>,
}

impl Body {
    /// Return the surface as a thin body in its own axes, whose first node is the pivot; none of a solid.
    pub(super) fn thin(&self) -> Option<Flexible> {
        let Shape::Surface(own, triangles) = &self.shape else { return None };
        let mut nodes = vec![self.pivot];
        nodes.extend(own);
        let triangles = triangles.iter().map(|corners| corners.map(|node| node.saturating_add(1))).collect();
        let extent = Extent::Surface(triangles);
        Some(Flexible { name: "a rigid surface".into(), nodes, extent, pivot: None })
    }
}

impl Flexible {
    /// Return the number of markers on cells of a size (m), about; none of nodes that do not exist.
    fn count(&self, cell: f64) -> Option<f64> {
        match &self.extent {
            Extent::Line => {
                let square =
                    |ends: &[[f64; 3]]| (0..3).map(|axis| (ends[1][axis] - ends[0][axis]).powi(2)).sum::<f64>();
                Some(self.nodes.windows(2).map(|ends| square(ends).sqrt()).sum::<f64>() / cell)
            }
            Extent::Surface(triangles) => {
                let known = triangles.as_flattened().iter().all(|node| *node < self.nodes.len());
                known.then(|| mesh::area(&self.nodes, triangles) / (cell * cell))
            }
        }
    }
}

/// What lies between the nodes of a thin body.
#[derive(Clone, Debug)]
pub enum Extent {
    /// A line through them.
    Line,
    /// Triangles, each of three nodes.
    Surface(Vec<[usize; 3]>),
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
    /// Nodes, m, and triangles of no thickness, which markers represent.
    Surface(Vec<[f64; 3]>, Vec<[usize; 3]>),
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
            flexible: Vec::new(),
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
        self.check_flexible()?;
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

    /// Return the number of markers of the thin bodies, about.
    pub(super) fn markers(&self) -> usize {
        let cell = Grid::new(self.domain, self.cells).cell_size();
        self.thin().filter_map(|body| body.count(cell)).sum::<f64>() as usize
    }

    /// Return the thin bodies, flexible and rigid.
    fn thin(&self) -> impl Iterator<Item = Cow<'_, Flexible>> {
        let rigid = self.bodies.iter().filter_map(|body| body.thin().map(Cow::Owned));
        self.flexible.iter().map(Cow::Borrowed).chain(rigid)
    }

    /// Refuse thin bodies without an extent, or with more markers than a step has time for.
    fn check_flexible(&self) -> Result<(), Error> {
        let cell = Grid::new(self.domain, self.cells).cell_size();
        for body in self.thin() {
            let count = body.count(cell).unwrap_or(0.0);
            if count == 0.0 {
                let allowed = "above 0: a line has two nodes, a surface triangles of its nodes";
                return Err(Error::Parameter { name: "extent of a thin body", value: 0.0, allowed });
            }
            if count.is_nan() || count > MOST_CELLS {
                let allowed = "at most 4e4: coarser cells or a smaller body";
                return Err(Error::Parameter { name: "extent of a thin body in cells", value: count, allowed });
            }
        }
        Ok(())
    }
}
