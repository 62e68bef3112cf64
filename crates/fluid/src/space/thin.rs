//! Thin bodies in space, lines and surfaces of markers: flexible ones, whose nodes are set from outside, and rigid
//! ones.

use line_fft::Real;
use nalgebra::Vector3;

use super::force::{BodyForce, Displaced};
use super::parameters::{Extent, Flexible, Parameters};
use super::rigid::{Pose, Rigid};
use crate::bodies::{Loads, Stations};
use crate::error::Error;
use crate::field::Field;
use crate::force::Exchange;
use crate::grid::Grid;
use crate::thin::{MarkerDrag, Markers, Parts, ROD_SECTION_CELLS, SURFACE_THICKNESS_CELLS, surface};

/// A thin body.
struct Thin {
    /// Number of its force among those of all bodies.
    number: usize,
    parts: Parts,
    /// Fluid that moves with each marker, m³.
    layers: Vec<f64>,
    /// Point about which moments are taken, m; absent: the first node.
    pivot: Option<[f64; 3]>,
}

/// Nodes of a rigid surface; the first one is the pivot.
struct RigidNodes {
    /// Nodes from the pivot in the axes of the body, m.
    rest: Vec<Vector3<f64>>,
    nodes: Stations<3>,
}

/// The thin bodies of a fluid: the flexible ones in the order of their nodes, then the rigid ones.
#[derive(Default)]
pub struct ThinBodies {
    bodies: Vec<Thin>,
    rigid: Vec<RigidNodes>,
    drag: MarkerDrag<3>,
    density: f64,
}

impl Thin {
    fn new(number: usize, body: &Flexible, c_eta: f64, cell: f64, markers: &mut Markers<3>) -> Self {
        let first = markers.len();
        let (parts, measures, layer) = match &body.extent {
            Extent::Line => {
                let (parts, length) = Parts::of_line(&body.nodes, [true; 2], cell, first);
                let each = length / parts.len() as f64;
                let measures = vec![each; parts.len()];
                (parts, measures, ROD_SECTION_CELLS * cell * cell)
            }
            Extent::Surface(triangles) => {
                let (parts, areas) = surface::parts(&body.nodes, triangles, cell, first);
                (parts, areas, SURFACE_THICKNESS_CELLS * cell)
            }
        };
        measures.iter().for_each(|measure| markers.add(*measure, layer / c_eta));
        Self { number, parts, layers: measures.iter().map(|measure| layer * measure).collect(), pivot: body.pivot }
    }

    /// Return the point about which moments are taken, and its velocity.
    fn centre(&self, nodes: &Stations<3>) -> [Vector3<f64>; 2] {
        match self.pivot {
            Some(pivot) => [pivot.into(), Vector3::zeros()],
            None => [&nodes.position, &nodes.velocity].map(|all| all.each_ref().map(|all| all[0]).into()),
        }
    }

    /// Return the fluid of a density (kg/m³) in the layer that moves with the body.
    fn displaced(&self, nodes: &Stations<3>, markers: &Markers<3>, density: f64) -> Displaced {
        let [centre, velocity] = self.centre(nodes);
        let mut sum = Displaced::default();
        for (k, layer) in self.parts.markers().zip(&self.layers) {
            let marker = markers.get(k);
            let momentum = density * layer * Vector3::from(marker.velocity);
            sum.momentum += momentum;
            sum.angular += (Vector3::from(marker.position) - centre).cross(&momentum);
        }
        Displaced { transport: velocity.cross(&sum.momentum), ..sum }
    }
}

impl RigidNodes {
    /// Move to the place of a body.
    fn place(&mut self, Rigid { pose: Pose { position, velocity, omega, .. }, rotation, .. }: &Rigid) {
        let [position, velocity, omega] = [position, velocity, omega].map(|vector| Vector3::from(*vector));
        for (k, rest) in self.rest.iter().enumerate() {
            let arm = rotation * rest;
            let (place, rate) = (position + arm, velocity + omega.cross(&arm));
            for axis in 0..3 {
                (self.nodes.position[axis][k], self.nodes.velocity[axis][k]) = (place[axis], rate[axis]);
            }
        }
    }
}

impl ThinBodies {
    /// The thin bodies, not yet at a place.
    pub fn new(parameters: &Parameters, grid: &Grid<3>) -> Self {
        let (mut markers, cell) = (Markers::default(), grid.cell_size());
        let mut thin =
            |(number, body): (usize, &_)| Thin::new(number, body, parameters.mask.c_eta(), cell, &mut markers);
        let mut bodies: Vec<_> = (parameters.bodies.len()..).zip(&parameters.flexible).map(&mut thin).collect();
        let mut rigid = Vec::new();
        for (number, body) in parameters.bodies.iter().enumerate().filter_map(|(k, body)| Some((k, body.thin()?))) {
            bodies.push(thin((number, &body)));
            let [pivot, ..] = body.nodes[..] else { continue };
            let rest = body.nodes.iter().map(|node| Vector3::from(*node) - Vector3::from(pivot)).collect();
            rigid.push(RigidNodes { rest, nodes: Stations::at_rest(&body.nodes) });
        }
        Self { bodies, rigid, drag: MarkerDrag::new(markers), density: parameters.density }
    }

    /// Return all bodies with their nodes, of which `nodes` are those of the flexible ones.
    fn all<'a>(&'a self, nodes: &'a [Stations<3>]) -> impl Iterator<Item = (&'a Thin, &'a Stations<3>)> {
        self.bodies.iter().zip(nodes.iter().chain(self.rigid.iter().map(|rigid| &rigid.nodes)))
    }

    /// Return whether there is none.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Return the number of markers.
    pub fn markers(&self) -> usize {
        self.drag.markers.len()
    }

    /// Move the flexible bodies to nodes, and the rigid ones to their places among `solids`.
    pub fn place(&mut self, nodes: &[Stations<3>], solids: &[Rigid], grid: &Grid<3>) {
        for (body, rigid) in self.bodies[nodes.len()..].iter().zip(&mut self.rigid) {
            rigid.place(&solids[body.number]);
        }
        let markers = &mut self.drag.markers;
        let all = nodes.iter().chain(self.rigid.iter().map(|rigid| &rigid.nodes));
        self.bodies.iter().zip(all).for_each(|(body, nodes)| body.parts.place(nodes, markers));
        markers.find_cells(grid);
    }

    /// Take the drag into the local solve; see [`MarkerDrag::apply`].
    pub fn apply<R: Real>(
        &mut self,
        c_0: f64,
        rate: Option<&[f64]>,
        first: impl Fn(usize, &[Field<R>; 3]) -> [f64; 3],
        w: &mut [Field<R>; 3],
        time: f64,
        grid: &Grid<3>,
    ) -> Result<(), Error> {
        self.drag.apply(c_0, rate, first, w, time, grid)
    }

    /// Write the loads on the nodes in a local solve with `right_side` at a grid point; `add` adds `Σ a u_b` of the
    /// masks at grid points in ascending order. Loads are not finite if no solution was found.
    pub fn predict_loads(
        &mut self,
        c_0: f64,
        rate: Option<&[f64]>,
        right_side: impl Fn(usize) -> [f64; 3],
        add: impl FnOnce(&[usize], &mut [[f64; 3]]),
        grid: &Grid<3>,
        loads: &mut [Loads<3>],
    ) {
        self.drag.list_dragged(rate);
        let (points, sums) = self.drag.dragged_mut();
        add(points, sums);
        self.drag.predict(c_0, rate, right_side, grid);
        for (body, loads) in self.bodies.iter().zip(loads) {
            body.parts.collect(&self.drag.force, &self.drag.slope, self.density, loads);
        }
    }

    /// Write the displaced fluid of each body to its number in `forces`.
    pub fn set_displaced(&self, nodes: &[Stations<3>], forces: &mut [BodyForce]) {
        for (body, nodes) in self.all(nodes) {
            forces[body.number].displaced = body.displaced(nodes, &self.drag.markers, self.density);
        }
    }

    /// Sum up the forces, and the exchanges of the flexible bodies, of a step of size `dt` (s) that ends with `nodes`.
    pub fn sum_up_forces(
        &self,
        dt: f64,
        nodes: &[Stations<3>],
        forces: &mut [BodyForce],
        exchange: &mut [Exchange<3>],
    ) {
        let MarkerDrag { markers, force: drag, .. } = &self.drag;
        for (k, (body, nodes)) in self.all(nodes).enumerate() {
            let ([centre, _], mut sum, mut power) = (body.centre(nodes), [Vector3::zeros(); 2], 0.0);
            for k in body.parts.markers() {
                let marker = markers.get(k);
                let force = Vector3::from([0, 1, 2].map(|axis| self.density * drag[axis][k]));
                sum[0] += force;
                sum[1] += (Vector3::from(marker.position) - centre).cross(&force);
                power += force.dot(&Vector3::from(marker.velocity));
            }
            if let Some(exchange) = exchange.get_mut(k) {
                *exchange = Exchange { force: sum[0].into(), power, work: exchange.work + power * dt };
            }
            forces[body.number].update(sum, body.displaced(nodes, markers, self.density), dt);
        }
    }
}
