//! Thin bodies: the drag of lines of markers, solved exactly within the local solve of a step.
//!
//! A marker k at X_k stands for a part of a line of the length l_k (in space: of a surface of that area). With
//! interpolation E_k by a smooth kernel and its transpose, the drag on the fluid is `−Σ_k f_k δ_h(x − X_k)` with
//! `f_k = kappa l_k (E_k u* − U_k)`, the force on the part over the density. It is symmetric and monotone like the drag
//! of a mask, so the splitting of the step holds as it is. With `C = c_0 + Σ a` of the masks the local solve becomes
//!
//! ```text
//! (1/(kappa l) + E C⁻¹ Eᵗ/V) f = E C⁻¹ (r + Σ a u_b) − U,      u* = C⁻¹ (r + Σ a u_b − Eᵗ f/V)
//! ```
//!
//! with the volume V of a cell: a sparse, symmetric, positive definite system of as many rows as markers.

mod drag;
mod markers;
mod owed;
mod parts;
mod rigid;
mod slip;
mod stress;
mod surface;
mod system;

use line_fft::Real;
use method::{ROD_RADIUS_CELLS, ROD_SECTION_CELLS};
use nalgebra::SMatrix;

use crate::bodies::{Bodies, DisplacementHistory, MOST_TURNS, Rigid};
use crate::field::Field;
use crate::force::{BodyForce, Displaced, Exchange, Force};
use crate::grid::Grid;
use crate::kernel::{Kernel, layer_thickness};
use crate::parameters::{Extent, Flexible, Parameters};
use crate::space::{Freedoms, Kinematics, Space, Vector, join};
use contact::{Loads, Stations};

use drag::{Dragged, MarkerDrag};
use markers::Markers;
use owed::Taken;
pub use owed::pay;
use parts::Parts;
use rigid::{Responses, RigidNodes};
use slip::Slip;
use stress::{LineStress, SurfaceStress};
use surface::Facets;

/// A thin body.
struct Thin<const D: usize> {
    /// Number of its force among those of all bodies.
    number: usize,
    parts: Parts,
    /// What turns the markers with the nodes.
    facing: Facing,
    /// Point about which moments are taken, m; absent: the first node.
    pivot: Option<[f64; D]>,
    /// Stress on a line in the plane.
    stress: Option<LineStress>,
}

/// What turns the markers of a body.
enum Facing {
    /// The markers beside each one, in the plane.
    Line,
    /// The same of a rod in space, which takes its layer along in all directions.
    Rod,
    /// Nothing: the body does not slip.
    Unknown,
    /// The triangles of each, and what a flexible one has.
    Surface(Facets, Option<FlexibleSurface>),
}

/// Stresses on a flexible surface, and the load that it takes.
struct FlexibleSurface {
    stress: SurfaceStress,
    taken: Taken,
}

/// The thin bodies of a fluid: the flexible ones in the order of their nodes, then the rigid ones.
pub struct ThinBodies<const D: usize>
where
    [f64; D]: Space<D>,
{
    bodies: Vec<Thin<D>>,
    /// Numbers of the flexible ones among all flexible bodies.
    flexible: Vec<usize>,
    rigid: Vec<RigidNodes<D>>,
    drag: MarkerDrag<D>,
    dragged: Dragged<D>,
    responses: Responses<D>,
    /// Density of the fluid, kg/m³.
    density: f64,
}

impl<const D: usize> Thin<D>
where
    [f64; D]: Space<D>,
{
    /// A body on cells of a size (m) in a fluid of a viscosity (m²/s) and a density (kg/m³). A rigid one, a surface and
    /// a rod slip.
    fn new(
        number: usize,
        body: &Flexible<D>,
        is_rigid: bool,
        c_eta: f64,
        (nu, density): (f64, f64),
        cell: f64,
        markers: &mut Markers<D>,
    ) -> Self {
        let (first, thickness) = (markers.len(), layer_thickness(D) * cell);
        let (mut stress, mut around) = (None, vec![]);
        let is_line = !matches!(body.extent, Extent::Surface(_));
        let whole = if is_line && D != 2 { ROD_SECTION_CELLS * cell * cell } else { thickness };
        let along = |edges: &[f64]| edges.iter().map(|edge| Slip::along(nu, cell, *edge, thickness)).collect();
        let (parts, facing, measures, layers, slips): (_, _, Vec<_>, Vec<_>, Vec<_>) = match &body.extent {
            Extent::Surface(triangles) => {
                let nodes = body.nodes_in_space();
                let surface::Patches { parts, facets, areas, edges, around: beside } =
                    surface::patches(&nodes, triangles, cell, first);
                let flexible = (!is_rigid).then(|| {
                    around = beside;
                    let stress = SurfaceStress::new(body.nodes.len(), &parts, areas.clone(), thickness);
                    FlexibleSurface { stress, taken: Taken::new(&nodes, triangles, density * thickness) }
                });
                let count = areas.len();
                (parts, Facing::Surface(facets, flexible), areas, vec![whole; count], along(&edges))
            }
            extent => {
                let slips = is_rigid && D == 2;
                let free = if let Extent::Line { free } = extent { *free } else { [true; 2] };
                let (parts, edges, length) = Parts::of_line(
                    &body.nodes,
                    free,
                    if slips { slip::DRAWN_IN } else { Kernel::of(D).drawn_in },
                    cell,
                    first,
                );
                let count = parts.len();
                if D == 2 {
                    stress = Some(LineStress::new(&body.nodes, &parts, length, thickness));
                }
                // A rod thinner than its line takes less fluid with it.
                let size = |diameter: f64| cell.min(0.5 * diameter / ROD_RADIUS_CELLS);
                let (facing, layers, slips) = match extent {
                    Extent::Rod(all) if all.iter().any(|diameter| size(*diameter) < cell) => {
                        let mean = |shares: &[(usize, f64)]| shares.iter().map(|(k, share)| all[*k] * share).sum();
                        let of_parts: Vec<f64> = parts.iter().map(|(_, shares)| mean(shares)).collect();
                        let layers = of_parts.iter().map(|diameter| ROD_SECTION_CELLS * size(*diameter).powi(2));
                        let slips = of_parts.iter().map(|diameter| Slip::of_rod(nu, cell, *diameter));
                        (Facing::Rod, layers.collect(), slips.collect())
                    }
                    _ if slips => (Facing::Line, vec![whole; count], along(&edges)),
                    _ => (Facing::Unknown, vec![whole; count], vec![Slip::default(); count]),
                };
                (parts, facing, vec![length / count as f64; count], layers, slips)
            }
        };
        around.resize(measures.len(), vec![]);
        let own = measures.iter().zip(layers).zip(slips);
        for (((measure, layer), slip), beside) in own.zip::<Vec<Vec<usize>>>(around) {
            let k = markers.len();
            markers.add(*measure, whole * measure, c_eta, slip, beside.into_iter().map(|k| first + k));
            // A thin rod follows as fast as a thick one.
            markers.get_mut(k).layer = layer * measure;
        }
        Self { number, parts, facing, pivot: body.pivot, stress }
    }

    /// Move the markers to the nodes.
    fn place(&self, nodes: &Stations<D>, markers: &mut Markers<D>) {
        self.parts.place(nodes, markers);
        let own = self.parts.markers();
        if let Facing::Unknown = self.facing {
            return;
        }
        for k in own.clone() {
            let normal_or_tangent = match &self.facing {
                Facing::Line | Facing::Rod if own.len() > 1 => {
                    let place = |k: usize| markers.get(k).position;
                    place((k + 1).min(own.end - 1)) - place(k.max(own.start + 1) - 1)
                }
                Facing::Line | Facing::Rod | Facing::Unknown => {
                    let end = |k: usize| Vector::from(nodes.position.each_ref().map(|of| of[k]));
                    end(nodes.len() - 1) - end(0)
                }
                Facing::Surface(facets, _) => facets.normal(k - own.start, &nodes.position),
            };
            let length = normal_or_tangent.iter().fold(0.0_f64, |length, part| length.hypot(*part));
            let axis = normal_or_tangent / length.max(f64::MIN_POSITIVE);
            let along = axis * axis.transpose();
            markers.get_mut(k).along =
                if let Facing::Surface(..) = self.facing { SMatrix::identity() - along } else { along };
        }
    }

    /// Return the point about which moments are taken, and its velocity.
    fn centre(&self, nodes: &Stations<D>) -> [Vector<D>; 2] {
        match self.pivot {
            Some(pivot) => [pivot.into(), Vector::zeros()],
            None => [&nodes.position, &nodes.velocity].map(|all| all.each_ref().map(|all| all[0]).into()),
        }
    }

    /// Return the fluid of a density (kg/m³) in the layer that moves with the body, across it or with a rod in all
    /// directions, with moments about a point (m) of some velocity (m/s).
    fn displaced(&self, [centre, velocity]: [Vector<D>; 2], markers: &Markers<D>, density: f64) -> Displaced<D> {
        let mut sum = Force::default();
        for k in self.parts.markers() {
            let marker = markers.get(k);
            let along = if let Facing::Rod = self.facing { Vector::zeros() } else { marker.along * marker.velocity };
            let across = marker.velocity - along;
            sum.add(&(density * marker.layer * across), &(marker.position - centre));
        }
        let Force { force: momentum, moment: angular } = sum;
        Displaced { momentum, angular, transport: <[f64; D]>::cross(&velocity, &momentum) }
    }

    /// Return the inertia of the layer of a flexible surface whose nodes were at `before`, with moments about a point (m):
    /// across it, and along it, where the fluid slides but the mass of the body leaves the layer out, with its power, W.
    /// `rate` is the density over the step, kg/(m³ s).
    fn inertia(
        &self,
        about: &Vector<D>,
        before: &Stations<D>,
        markers: &Markers<D>,
        rate: f64,
    ) -> (Force<D>, Force<D>, f64) {
        let (mut across, mut along, mut power) = (Force::default(), Force::default(), 0.0);
        for (k, velocity) in self.parts.means(&before.velocity) {
            let marker = markers.get(k);
            let whole = (marker.velocity - velocity) * (marker.layer * rate);
            let part = marker.along * whole;
            across.add(&(whole - part), &(marker.position - about));
            along.add(&part, &(marker.position - about));
            power += part.dot(&marker.velocity);
        }
        (across, along, power)
    }

    /// Return the force of the layer that slips along a turning body, which the fluid at a body of no thickness has not: the
    /// part across of its acceleration and of that of Coriolis, less the rate of the momentum across.
    fn gliding(&self, body: &RigidNodes<D>, drag: &MarkerDrag<D>, density: f64) -> Force<D> {
        let mut sum = Force::default();
        for k in self.parts.markers() {
            let marker = drag.markers.get(k);
            let (layer, along, velocity) = (density * marker.layer, marker.along, marker.velocity);
            let slip = along * (drag.markers.inverse_drag(k) * drag.force[k]);
            let (across, swing) = (velocity - along * velocity, |of: &Vector<D>| <[f64; D]>::swing(body.spin, of));
            let turning = swing(&(slip * 2.0 + velocity));
            sum.add(&((turning - along * turning - swing(&across)) * layer), &(marker.position - body.pivot));
            sum.moment = sum.moment - <[f64; D]>::cross(&velocity, &across) * layer;
        }
        sum
    }

    /// Return the sum of the forces on the markers with the moment about a point (m), and the power, W.
    fn force(&self, about: &Vector<D>, drag: &MarkerDrag<D>, density: f64) -> (Force<D>, f64) {
        let (mut sum, mut power) = (Force::default(), 0.0);
        for k in self.parts.markers() {
            let marker = drag.markers.get(k);
            let force = drag.on_body(k) * density;
            sum.add(&force, &(marker.position - about));
            power += force.dot(&marker.velocity);
        }
        (sum, power)
    }
}

impl<const D: usize> ThinBodies<D>
where
    [f64; D]: Space<D>,
{
    /// The thin bodies, not yet at a place.
    pub fn new(parameters: &Parameters<D>, grid: &Grid<D>) -> Self {
        let (mut markers, rigid_bodies) = (Markers::default(), parameters.bodies.len());
        let (c_eta, cell) = (parameters.mask.c_eta(), grid.cell_size());
        let (mut bodies, mut flexible, mut rigid) = (Vec::new(), Vec::new(), Vec::new());
        for (number, body) in parameters.thin() {
            let (is_rigid, nu) = (number < rigid_bodies, parameters.kinematic_viscosity);
            let fluid = (nu, parameters.density);
            bodies.push(Thin::new(number, &body, is_rigid, c_eta, fluid, cell, &mut markers));
            match number.checked_sub(rigid_bodies) {
                Some(number) => flexible.push(number),
                None => rigid.push(RigidNodes::new(&body.nodes, &parameters.bodies[number])),
            }
        }
        let responses = if rigid.iter().any(|own| own.on_springs) { <[f64; D]>::FREEDOMS } else { 0 };
        let responses = vec![vec![Vector::zeros(); markers.len()]; responses];
        let (drag, dragged) = (MarkerDrag::new(markers), Dragged::default());
        Self { bodies, flexible, rigid, drag, dragged, responses, density: parameters.density }
    }

    /// Give the rigid bodies the layers of fluid around their markers.
    pub fn give_layers(&mut self, bodies: &mut [Rigid<D>]) {
        let markers = &mut self.drag.markers;
        for (thin, own) in self.bodies[self.flexible.len()..].iter().zip(&self.rigid) {
            let rigid = &mut bodies[thin.number];
            if rigid.has_layer_of_markers() {
                thin.place(&own.nodes, markers);
                let layers = thin.parts.markers().map(|k| (markers.get(k).position, markers.get(k).layer));
                rigid.set_layer(layers, self.density);
            }
        }
    }

    /// Return whether there is none.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Return the number of markers.
    pub fn markers(&self) -> usize {
        self.drag.markers.len()
    }

    /// Move the flexible bodies to `stations`, and the rigid ones to their places, as if no velocity had changed.
    pub fn place(&mut self, stations: &[Stations<D>], bodies: &[Rigid<D>], grid: &Grid<D>) {
        if self.is_empty() {
            return;
        }
        let (flexible, rigid) = self.bodies.split_at(self.flexible.len());
        let markers = &mut self.drag.markers;
        for (thin, number) in flexible.iter().zip(&self.flexible) {
            thin.place(&stations[*number], markers);
        }
        for (thin, own) in rigid.iter().zip(&mut self.rigid) {
            own.place(&bodies[thin.number]);
            thin.place(&own.nodes, markers);
        }
        markers.find_cells(grid);
    }

    /// Take the drag into the local solve, let the bodies on springs move, and give `w`, which holds u* + tau G without
    /// the thin bodies, their part. `c` are the coefficients of the backward differences, and `first` gives that u* at a
    /// grid point for w there. Return whether the forces were found.
    pub fn apply<R: Real>(
        &mut self,
        c: [f64; 3],
        histories: &[DisplacementHistory<D>],
        bodies: &mut Bodies<D>,
        first: impl Fn(usize, [f64; D]) -> [f64; D],
        w: &mut [Field<R>; D],
        grid: &Grid<D>,
    ) -> bool {
        if self.is_empty() {
            return true;
        }
        let first = |point: usize| first(point, std::array::from_fn(|axis| w[axis][point].to_f64()));
        let found = self.drag.solve(c[0], bodies.rate(), first, grid) && self.solve_springs(c, histories, bodies);
        if found {
            self.drag.glide();
            self.drag.spread(w, grid);
        }
        found
    }

    /// Call `add` with each grid point and the force on the fluid there, m/s², after [`Self::apply`].
    pub fn for_each_force(&self, grid: &Grid<D>, add: impl FnMut(usize, Vector<D>)) {
        self.drag.for_each_force(grid, add);
    }

    /// Find the velocities of the bodies on springs together with the forces; return whether they were found.
    ///
    /// In turns, as those with a mask do, each answers what the others did to its markers.
    fn solve_springs(&mut self, c: [f64; 3], histories: &[DisplacementHistory<D>], bodies: &mut Bodies<D>) -> bool {
        let all = self.flexible.len()..self.bodies.len();
        let is_solved = |k: &usize| bodies.rigid[self.bodies[*k].number].mount().is_some();
        let turns = if all.clone().filter(is_solved).count() < 2 { 1 } else { MOST_TURNS };
        for turn in 0..turns {
            let mut changes = false;
            for k in all.clone() {
                match self.solve_springs_of(k, turn == 0, c, histories, bodies) {
                    Some(own) => changes |= own,
                    None => return false,
                }
            }
            if !changes {
                break;
            }
        }
        true
    }

    /// Find the velocities of a body by its number in `bodies`, the `first` time or once more, and return whether they
    /// changed; none if the forces were not found.
    fn solve_springs_of(
        &mut self,
        body: usize,
        first: bool,
        c: [f64; 3],
        histories: &[DisplacementHistory<D>],
        bodies: &mut Bodies<D>,
    ) -> Option<bool> {
        let thin = &self.bodies[body];
        let rigid = &bodies.rigid[thin.number];
        if rigid.mount().is_none() {
            return Some(false);
        }
        let (own, centre) = (thin.parts.markers(), rigid.pose.position);
        let force = thin.force(&centre, &self.drag, self.density).0;
        let layer: f64 = own.clone().map(|k| self.drag.markers.get(k).layer).sum();
        let share = rigid.displaced_mass(1.0).mass / layer;
        let sliding = rigid::sliding(own.clone(), &centre, &self.drag.markers, self.density * share);
        let answer = if first { None } else { bodies.answer_of(thin.number, &force, c[0], &sliding) };
        if !first && answer.is_none() {
            return Some(false);
        }
        for (k, response) in self.responses.iter_mut().enumerate() {
            let motion = |marker: usize, markers: &Markers<D>| {
                let arm = || markers.get(marker).position - centre;
                if own.contains(&marker) { rigid::motion(k, &arm()) } else { Vector::zeros() }
            };
            if !self.drag.respond(motion, response) {
                return None;
            }
        }
        let MarkerDrag { markers, force: on_markers, .. } = &mut self.drag;
        let drag = rigid::drag(force, own.clone(), &centre, markers, &self.responses, self.density);
        let change = answer.or_else(|| bodies.solve_springs_of(thin.number, c, histories, drag, &sliding));
        if let Some(change) = change {
            bodies.rigid[thin.number].known = drag.after(&change);
            rigid::change(&change, own, &centre, &self.responses, markers, on_markers);
        }
        Some(change.is_some())
    }

    /// Write the loads on the nodes of the flexible bodies in a local solve with `right_side` at a grid point; `add` adds
    /// `Σ a u_b` of the masks at grid points in ascending order. Loads are not finite if no solution was found.
    pub fn predict_loads(
        &mut self,
        c_0: f64,
        rate: Option<&[f64]>,
        right_side: impl Fn(usize) -> [f64; D],
        add: impl FnOnce(&[usize], &mut [[f64; D]]),
        grid: &Grid<D>,
        loads: &mut [Loads<D>],
    ) {
        if self.is_empty() {
            return;
        }
        let Self { drag, dragged, .. } = self;
        dragged.list(drag.markers.points(), rate);
        add(&dragged.points, &mut dragged.sums);
        drag.predict(c_0, rate, right_side, dragged, grid);
        for (thin, number) in self.bodies.iter().zip(&self.flexible) {
            thin.parts.collect(|k| drag.on_body(k), &drag.slope, self.density, &mut loads[*number]);
        }
    }

    /// Return whether a flexible body is a surface.
    pub fn has_surface(&self) -> bool {
        self.bodies.iter().any(|thin| matches!(thin.facing, Facing::Surface(_, Some(_))))
    }

    /// Return the flexible bodies, each with its number among them and its nodes among all `stations`.
    fn with_nodes<'a>(&'a self, stations: &'a [Stations<D>]) -> impl Iterator<Item = (&'a Thin<D>, usize)> {
        debug_assert!(self.flexible.iter().all(|number| *number < stations.len()), "a list for each flexible body");
        self.bodies.iter().zip(self.flexible.iter().copied())
    }

    /// Return the rigid bodies that are not on springs, each with its nodes. The layer of a body on springs is in its
    /// equation of motion.
    fn led(&self) -> impl Iterator<Item = (&Thin<D>, &RigidNodes<D>)> {
        self.bodies[self.flexible.len()..].iter().zip(&self.rigid).filter(|(_, own)| !own.on_springs)
    }

    /// Write the displaced fluid of each body but those on springs to its number in `forces`.
    pub fn set_displaced(&self, stations: &[Stations<D>], forces: &mut [BodyForce<D>]) {
        let markers = &self.drag.markers;
        for (thin, number) in self.with_nodes(stations) {
            forces[thin.number].displaced = thin.displaced(thin.centre(&stations[number]), markers, self.density);
        }
        for (thin, own) in self.led() {
            forces[thin.number].displaced = thin.displaced([own.pivot, own.velocity], markers, self.density);
        }
    }

    /// Sum up the forces, and the exchanges of the flexible bodies, of a step of size `dt` (s) that ends with `stations`;
    /// each surface is `owed` its part of what it gets. `forces` has the unsteady terms of the bodies on springs.
    pub fn sum_up_forces(
        &self,
        dt: f64,
        stations: &[Stations<D>],
        before: &[Stations<D>],
        forces: &mut [BodyForce<D>],
        (exchange, owed): (&mut [Exchange<D>], &mut [Freedoms]),
    ) {
        let markers = &self.drag.markers;
        for (thin, number) in self.with_nodes(stations) {
            let (centre, own) = (thin.centre(&stations[number]), &mut exchange[number]);
            let (force, mut power) = thin.force(&centre[0], &self.drag, self.density);
            let mut exchanged = force.force;
            if let Facing::Surface(..) = thin.facing {
                let (across, along, of_layer) = thin.inertia(&centre[0], &before[number], markers, self.density / dt);
                (exchanged, power) = (exchanged - along.force, power - of_layer);
                forces[thin.number].force = force.plus(&across);
                if let Some(owed) = owed.get_mut(number) {
                    let moment = force.moment - along.moment + <[f64; D]>::cross(&centre[0], &exchanged);
                    let given = join(&exchanged, moment);
                    owed.iter_mut().zip(given).for_each(|(owed, given)| *owed += dt * given);
                }
            } else {
                forces[thin.number].update(force, thin.displaced(centre, markers, self.density), dt);
            }
            *own = Exchange { force: exchanged.into(), power, work: own.work + power * dt };
        }
        for (thin, own) in self.bodies[self.flexible.len()..].iter().zip(&self.rigid) {
            let (force, of_body) = (thin.force(&own.pivot, &self.drag, self.density).0, &mut forces[thin.number]);
            if own.on_springs {
                of_body.force = of_body.force.plus(&force);
            } else {
                let gliding = thin.gliding(own, &self.drag, self.density);
                let displaced = thin.displaced([own.pivot, own.velocity], markers, self.density);
                of_body.update(force.plus(&gliding), displaced, dt);
            }
        }
    }

    /// Take off what each surface took of its loads in a step of `h` seconds between two places of all flexible bodies; of
    /// a first step, for which none are announced, nothing is owed.
    pub fn subtract_taken(&mut self, h: f64, ends: [&[Stations<D>]; 2], loads: &[Loads<D>], owed: &mut [Freedoms]) {
        for (thin, number) in self.bodies.iter_mut().zip(&self.flexible) {
            if let Facing::Surface(_, Some(FlexibleSurface { taken, .. })) = &mut thin.facing {
                let (loads, owed) = (&loads[*number], &mut owed[*number]);
                let taken = taken.sum(h, ends.map(|all| &all[*number]), loads);
                owed.iter_mut().zip(taken).for_each(|(owed, taken)| *owed -= h * taken);
                if loads.impedance.iter().all(|impedance| *impedance == 0.0) {
                    *owed = [0.0; 6];
                }
            }
        }
    }

    /// Return the change of the velocity (m/s) of a node by which a flexible body, with these rates of the fluid and of
    /// contact (kg/s) there, lowered its load of contact in the step of `h` seconds of [`Self::subtract_taken`].
    pub fn taken(&self, h: f64, number: usize, node: usize, rates: [f64; 2], change: Vector<D>) -> Vector<D> {
        let place = self.flexible.iter().position(|known| *known == number);
        match place.map(|place| &self.bodies[place].facing) {
            Some(Facing::Surface(_, Some(FlexibleSurface { taken, .. }))) => taken.of_contact(h, node, rates, change),
            _ => change,
        }
    }

    /// Write the pressure jumps and the shear stresses of each line in the plane and surface in space at its stations, Pa,
    /// in a step of `dt` seconds from the stations `before`; both have a list for each flexible body.
    pub fn write_stresses(
        &self,
        dt: f64,
        stations: &[Stations<D>],
        before: &[Stations<D>],
        (jumps, shears): (&mut [Vec<f64>], &mut [Vec<Vec<f64>>]),
    ) {
        for (thin, number) in self.with_nodes(stations) {
            let (force, nodes) = (|k| self.drag.on_body(k), [&stations[number], &before[number]]);
            let (jump, shear) = (&mut jumps[number], &mut shears[number]);
            if let Facing::Surface(facets, Some(FlexibleSurface { stress, .. })) = &thin.facing {
                stress.write((&thin.parts, facets), force, self.density, dt, nodes, (jump, shear));
            } else if let Some(stress) = &thin.stress {
                stress.write(force, self.density, dt, nodes, [jump, &mut shear[0]]);
            }
        }
    }
}
