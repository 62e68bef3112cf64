//! The bodies at their present places, and the drag that they exert on the fluid.

mod beam;
mod cells;
mod contact;
mod measure;
mod pose;
mod rigid;

use ::contact::{MountPush, Stations};
use line_fft::Real;

use crate::error::Error;
use crate::field::Field;
use crate::force::{BodyForce, Exchange, Force};
use crate::grid::Grid;
use crate::parameters::{Mount, Parameters};
use crate::space::{Freedoms, Kinematics, Space, Vector, join, split};
use crate::wall::DragProfile;
use crate::zone::DrivingZone;

pub use ::rigid::{DisplacementHistory, Drag, Pose};
use ::rigid::{Mass, MountedStep, SpringMotion};
pub use beam::Beam;
pub use cells::Cell;
use cells::{Cells, Painted};
pub use contact::{Contacts, place};
pub use rigid::Rigid;

/// Part of the velocities of a body that their change must exceed to be no rounding.
const ROUNDING: f64 = 1e-9;

/// The same where the flow has single precision.
const SINGLE_ROUNDING: f64 = 1e-5;

/// Most turns in which bodies answer each other in a step; masks that overlap by some cells take about five.
pub const MOST_TURNS: usize = 50;

/// Walls, zones, rigid bodies and beams with a mask, as a field of drag and as cells.
pub struct Bodies<const D: usize>
where
    [f64; D]: Space<D>,
{
    /// The rigid bodies.
    pub rigid: Vec<Rigid<D>>,
    /// The beams with a mask.
    pub beams: Vec<Beam<D>>,
    zones: Vec<DrivingZone>,
    /// Total penalization rate Σ a_b, 1/s; absent without a solid.
    rate: Option<Field<f64>>,
    painted: Painted,
    /// Loads of the next step on the bodies, where they are announced, with contact.
    announced: Vec<(usize, Drag<D>)>,
    /// The same without it.
    of_fluid: Vec<Drag<D>>,
    /// Contact of the bodies on a mount; absent without.
    contacts: Option<Contacts<D>>,
    /// Density of the fluid, kg/m³.
    density: f64,
    /// Mass of the fluid in a cell, kg.
    pub cell_mass: f64,
}

/// The bodies without the field of their drag.
pub struct MovingBodies<'a, const D: usize>
where
    [f64; D]: Space<D>,
{
    rigid: &'a mut [Rigid<D>],
    beams: &'a mut [Beam<D>],
}

/// Where the bodies are put: at a time (s), those without a law by displacements from rest, and the flexible ones from
/// the stations `before` to `stations`.
#[derive(Clone, Copy)]
pub struct Placement<'a, const D: usize>
where
    [f64; D]: Space<D>,
{
    /// Time, s.
    pub time: f64,
    /// Displacements of the bodies that laws do not move.
    pub displacements: &'a [Pose<D>],
    /// Stations of the flexible bodies.
    pub stations: &'a [Stations<D>],
    /// Stations at the beginning of the step.
    pub before: &'a [Stations<D>],
}

impl<const D: usize> MovingBodies<'_, D>
where
    [f64; D]: Space<D>,
{
    /// Move the bodies.
    pub fn place(&mut self, to: &Placement<D>, grid: &Grid<D>) {
        let mut displacements = to.displacements.iter().peekable();
        for rigid in self.rigid.iter_mut().filter(|rigid| rigid.moves()) {
            match displacements.next_if(|_| rigid.is_carried()) {
                Some(displacement) => rigid.place(rigid.pose_of(displacement), grid),
                None => rigid.follow(to.time, grid),
            }
        }
        self.beams.iter_mut().for_each(|beam| beam.place(to.stations, to.before, grid));
    }

    /// Let bodies with a wall target sample the flow; `velocity` gives it at a grid point, m/s.
    pub fn sample(&mut self, velocity: impl Fn(usize) -> [f64; D]) {
        self.rigid.iter_mut().for_each(|rigid| rigid.cells.sample(&velocity));
        self.beams.iter_mut().for_each(|beam| beam.cells_mut().sample(&velocity));
    }
}

impl<const D: usize> Bodies<D>
where
    [f64; D]: Space<D>,
{
    /// The bodies at t = 0, the still ones painted.
    pub fn new(parameters: &Parameters<D>, grid: &Grid<D>) -> Self {
        let &Parameters { ref mask, kinematic_viscosity: nu, density, ref walls, .. } = parameters;
        let zones = DrivingZone::all([&parameters.inflow, &parameters.sponge], mask, nu, walls[1], grid);
        let rigid: Vec<_> = parameters.bodies.iter().map(|body| Rigid::new(body, grid, mask, nu, density)).collect();
        let beams = Beam::all(parameters, grid);
        let has_walls = walls.iter().any(Option::is_some);
        let thick = !beams.is_empty() || rigid.iter().any(|rigid| !rigid.is_thin());
        let any = !zones.is_empty() || has_walls || thick;
        let announcing = parameters.bodies.iter().enumerate().filter(|(_, body)| body.announces);
        let mut bodies = Self {
            // The parameters were checked.
            contacts: Contacts::new(parameters).unwrap_or_default(),
            of_fluid: announcing.clone().map(|_| Drag::default()).collect(),
            announced: announcing.map(|(k, _)| (k, Drag::default())).collect(),
            rigid,
            beams,
            zones,
            rate: any.then(|| Field::uniform(0.0, grid.len())),
            painted: Painted::default(),
            density,
            cell_mass: density * grid.cell_volume(),
        };
        bodies.paint_still(walls, &DragProfile::new(mask, mask.c_eta(), nu, grid.cell_size()), grid);
        bodies
    }

    fn paint_still(&mut self, walls: &[Option<[f64; 2]>; D], profile: &DragProfile, grid: &Grid<D>) {
        let Some(rate) = &mut self.rate else { return };
        if walls.iter().any(Option::is_some) {
            let rates = rate.iter_mut().enumerate();
            rates.for_each(|(point, rate)| *rate += profile.rate(distance_from(walls, grid, point)));
        }
        let plane = grid.len() / grid.cells[0];
        for &(i, zone) in self.zones.iter().flat_map(|zone| &zone.columns) {
            rate[i * plane..(i + 1) * plane].iter_mut().for_each(|r| *r += zone);
        }
        for rigid in self.rigid.iter().filter(|rigid| !rigid.changes()) {
            rigid.cells.iter().for_each(|cell| rate[cell.index] += cell.rate);
        }
    }

    /// Return the grid points in which changing bodies are painted, with the total penalization rate, 1/s. A point that
    /// two bodies share is there twice.
    pub fn painted(&self) -> impl Iterator<Item = (usize, f64)> {
        let rate = self.rate.as_deref().unwrap_or_default();
        self.painted.points().map(|point| (point, rate[point]))
    }

    /// Return the total penalization rate Σ a_b, 1/s; none without a solid.
    pub fn rate(&self) -> Option<&[f64]> {
        self.rate.as_deref()
    }

    /// Move the bodies, and paint them.
    pub fn place(&mut self, to: &Placement<D>, grid: &Grid<D>) {
        self.moving().place(to, grid);
        self.paint();
    }

    /// Return the rigid bodies that the master or the fluid moves, each with its number.
    pub fn carried(&self) -> impl Iterator<Item = (usize, &Rigid<D>)> {
        self.rigid.iter().enumerate().filter(|(_, rigid)| rigid.is_carried())
    }

    /// Let the bodies that are released move in a step of `dt` seconds to a time (s) after their release.
    pub fn release(&mut self, time: f64, dt: f64) {
        self.rigid.iter_mut().for_each(|rigid| rigid.release(time, dt));
    }

    /// Set what contact does to bodies in the coming step, each by its number.
    pub fn push<'a>(&mut self, pushes: impl Iterator<Item = (usize, &'a MountPush<D>)>) {
        pushes.for_each(|(number, push)| self.rigid[number].push = *push);
        for ((number, load), own) in self.announced.iter_mut().zip(&self.of_fluid) {
            *load = *own;
            add_load(load, &self.rigid[*number].push.load);
        }
    }

    /// Let the solid bodies that were put to a predicted place move: those on springs find their velocities together with
    /// the drag of the fluid, those whose load was announced have the displacements `ends`. Add what the change of their
    /// velocities does to `u*` to `w`.
    ///
    /// `c` are the coefficients of the backward differences; `u_star(point, w)` is `u*` at a grid point.
    pub fn solve_motion<R: Real>(
        &mut self,
        c: [f64; 3],
        histories: &[DisplacementHistory<D>],
        ends: &[Pose<D>],
        u_star: impl Fn(usize, [f64; D]) -> [f64; D],
        w: &mut [Field<R>; D],
        grid: &Grid<D>,
    ) {
        let Some(rate) = &self.rate else { return };
        let bodies = self.rigid.iter_mut().filter(|rigid| rigid.is_carried());
        for ((rigid, history), end) in bodies.zip(histories).zip(ends) {
            if rigid.is_thin() || !rigid.is_predicted() {
                continue;
            }
            let of_fluid =
                rigid.drag(c[0], self.cell_mass, rate, |point| u_star(point, w.each_ref().map(|w| w[point].to_f64())));
            let mut drag = of_fluid;
            rigid.add_push(&mut drag);
            let change = rigid
                .solve_springs(c, history, self.density, &drag)
                .unwrap_or_else(|| rigid.move_to(*end, c, history, self.density));
            rigid.change_velocities(&change, c[0], rate, w);
            rigid.known = of_fluid.after(&change);
        }
        self.answer_each_other(c[0], u_star, w, grid);
    }

    /// Let bodies on springs answer what those that moved after them did to cells that they share, in turns until nothing
    /// changes: so their order does not count, and each loses the momentum that the fluid gains.
    fn answer_each_other<R: Real>(
        &mut self,
        c_0: f64,
        u_star: impl Fn(usize, [f64; D]) -> [f64; D],
        w: &mut [Field<R>; D],
        grid: &Grid<D>,
    ) {
        let Self { rate: Some(rate), rigid, cell_mass, density, .. } = self else { return };
        let is_solved = |own: &Rigid<D>| !own.is_thin() && own.is_predicted();
        for k in 0..rigid.len() {
            let (own, others) = (&rigid[k], rigid.iter().enumerate().filter(|(other, _)| *other != k));
            let mut others = others.filter(|(_, other)| is_solved(other));
            rigid[k].shares = is_solved(own) && others.any(|(_, other)| own.may_share_cells(other, grid));
        }
        let rounding = if size_of::<R>() < size_of::<f64>() { SINGLE_ROUNDING } else { ROUNDING };
        for _ in 0..MOST_TURNS {
            let mut changes = false;
            for own in rigid.iter_mut().filter(|own| own.shares && own.mount().is_some()) {
                let drag =
                    own.drag(c_0, *cell_mass, rate, |point| u_star(point, w.each_ref().map(|w| w[point].to_f64())));
                if let Some(change) = own.answer(&drag.force, c_0, *density, rounding) {
                    own.change_velocities(&change, c_0, rate, w);
                    own.known = drag.after(&change);
                    changes = true;
                }
            }
            if !changes {
                break;
            }
        }
    }

    /// Let the bodies on a mount touch in a step between two times (s), after [`Self::solve_motion`], and add what that
    /// does to `u*` to `w`.
    ///
    /// # Errors
    /// [`Error::Contact`].
    pub fn solve_contact<R: Real>(
        &mut self,
        c_0: f64,
        times: [f64; 2],
        histories: &[DisplacementHistory<D>],
        w: &mut [Field<R>; D],
    ) -> Result<(), Error> {
        let Self { contacts: Some(contacts), rigid, rate: Some(rate), density, .. } = self else { return Ok(()) };
        let changes = contacts.solve(c_0, times, rigid, histories)?.unwrap_or_default();
        for (rigid, change) in rigid.iter_mut().zip(changes).filter(|(rigid, _)| rigid.mount().is_some()) {
            let fluid = rigid.displaced_mass(*density);
            if let Some(found) = &mut rigid.spring_motion {
                found.add(change, c_0, &fluid);
                rigid.change_velocities(change, c_0, rate, w);
            }
        }
        Ok(())
    }

    /// Let a thin body on springs move under a drag, as [`Self::solve_springs`] does; return the change of its
    /// velocities along the freedoms, none if it is not on springs. `sliding` is the part of the displaced fluid, as a
    /// matrix along the freedoms, that does not move with it.
    pub fn solve_springs_of(
        &mut self,
        rigid: usize,
        c: [f64; 3],
        histories: &[DisplacementHistory<D>],
        mut drag: Drag<D>,
        sliding: &[Freedoms; 6],
    ) -> Option<Freedoms> {
        let place = self.carried().position(|(own, _)| own == rigid)?;
        let (own, history) = (&mut self.rigid[rigid], &histories[place]);
        let inertia = |acceleration: &Freedoms| inertia_of(sliding, acceleration);
        let (predicted, now, before) = (own.pose.rates(), history.now.rates(), history.before.rates());
        let expected = std::array::from_fn(|i| c[0] * predicted[i] - c[1] * now[i] - c[2] * before[i]);
        drag.force = drag.force.plus(&inertia(&expected));
        for (row, sliding) in drag.impedance.iter_mut().zip(sliding) {
            row.iter_mut().zip(sliding).for_each(|(entry, mass)| *entry += c[0] * mass);
        }
        let change = own.solve_springs(c, history, self.density, &drag)?;
        if let Some(found) = &mut own.spring_motion {
            found.unsteady = found.unsteady.plus(&inertia(&found.acceleration));
        }
        Some(change)
    }

    /// Let a thin body on springs answer a force that its motion did not know, as [`Self::solve_springs_of`] does.
    pub fn answer_of(&mut self, rigid: usize, force: &Force<D>, c_0: f64, sliding: &[Freedoms; 6]) -> Option<Freedoms> {
        let own = &mut self.rigid[rigid];
        let change = own.answer(force, c_0, self.density, ROUNDING)?;
        if let Some(found) = &mut own.spring_motion {
            found.unsteady = found.unsteady.plus(&inertia_of(sliding, &change.map(|v| c_0 * v)));
        }
        Some(change)
    }

    /// Return the load of the next step on body `k`, if it is announced.
    pub fn announced(&self, k: usize) -> Option<&Drag<D>> {
        self.announced.iter().find_map(|(own, drag)| (*own == k).then_some(drag))
    }

    /// Return whether any load is announced.
    pub fn announce(&self) -> bool {
        !self.announced.is_empty()
    }

    /// Put the bodies whose loads are announced to where a step of `dt` seconds after one of `before` seconds puts them.
    pub fn place_predicted(&mut self, histories: &[DisplacementHistory<D>], dt: f64, before: f64, grid: &Grid<D>) {
        for (rigid, history) in self.rigid.iter_mut().filter(|rigid| rigid.is_carried()).zip(histories) {
            if rigid.announces() {
                rigid.place(rigid.pose_of(&history.predicted(dt, before)), grid);
            }
        }
    }

    /// Return the cells of the bodies whose loads are announced.
    pub fn announced_cells(&self) -> impl Iterator<Item = &Cell<D>> {
        self.announced.iter().flat_map(|(k, _)| self.rigid[*k].cells.iter())
    }

    /// Announce the loads after [`Self::place_predicted`] in a step with the first coefficient `c_0` of the differences;
    /// `u_star` is `u*` at a grid point.
    pub fn set_announced(
        &mut self,
        c_0: f64,
        histories: &[DisplacementHistory<D>],
        u_star: impl Fn(usize) -> [f64; D],
    ) {
        let Self { announced, of_fluid, rigid, rate: Some(rate), cell_mass, .. } = self else { return };
        let bodies = rigid.iter_mut().filter(|rigid| rigid.is_carried()).zip(histories);
        let bodies = bodies.filter(|(rigid, _)| rigid.announces());
        for ((rigid, history), ((_, all), load)) in bodies.zip(announced.iter_mut().zip(of_fluid)) {
            *load = rigid.drag(c_0, *cell_mass, rate, &u_star);
            // The cells have the predicted velocities.
            let (predicted, kept) = (rigid.pose.rates(), history.now.rates());
            let rises = load.impedance.map(|row| (0..6).map(|j| row[j] * (predicted[j] - kept[j])).sum::<f64>());
            let (force, moment) = split::<D>(&rises);
            load.force = load.force.plus(&Force { force, moment });
            *all = *load;
            rigid.pose = rigid.pose_of(&history.now);
        }
    }

    /// Put the bodies that laws do not move to where they are after a step in which they were placed by
    /// `displacements`, and write that; `dt` is its length, s, and `c` are the coefficients of the backward differences.
    pub fn commit(
        &mut self,
        displacements: &[Pose<D>],
        dt: f64,
        c: [f64; 3],
        histories: &mut [DisplacementHistory<D>],
    ) {
        let bodies = self.rigid.iter_mut().filter(|rigid| rigid.is_carried());
        for ((rigid, history), placed) in bodies.zip(histories).zip(displacements) {
            let (now, acceleration) = match &rigid.spring_motion {
                Some(found) => (found.displacement, found.acceleration),
                None => (*placed, history.acceleration_to(placed, &c)),
            };
            *history = DisplacementHistory { now, before: history.now, acceleration };
            rigid.pose = rigid.pose_of(&now);
            let (rates, MountPush { velocities, change, .. }) = (rigid.pose.rates(), &mut rigid.push);
            (0..6).for_each(|i| change[i] += dt * (rates[i] - velocities[i]));
        }
    }

    /// Let bodies with a wall target sample the flow, and paint them; `velocity` gives the flow at a grid point, m/s.
    pub fn sample(&mut self, velocity: impl Fn(usize) -> [f64; D]) {
        self.moving().sample(velocity);
        self.paint();
    }

    /// Return the bodies, to be moved and to sample before they are painted.
    pub fn moving(&mut self) -> MovingBodies<'_, D> {
        MovingBodies { rigid: &mut self.rigid, beams: &mut self.beams }
    }

    /// Return the penalization rate of still bodies (1/s), and the bodies, to be moved while the rate is read and then
    /// to be painted with [`Self::paint`].
    pub fn split_still(&mut self) -> (Option<&[f64]>, MovingBodies<'_, D>) {
        if let Some(rate) = &mut self.rate {
            self.painted.erase(rate);
        }
        (self.rate.as_deref(), MovingBodies { rigid: &mut self.rigid, beams: &mut self.beams })
    }

    /// Return the cells of all bodies.
    pub fn cells(&self) -> impl Iterator<Item = &Cell<D>> {
        let rigid = self.rigid.iter().flat_map(|rigid| rigid.cells.iter());
        rigid.chain(self.beams.iter().flat_map(|beam| beam.cells().iter()))
    }

    /// Return the cells of the bodies whose drag changes: those that move or have a wall target.
    fn changing(&self) -> impl Iterator<Item = &Cells<D>> {
        let rigid = self.rigid.iter().filter(|rigid| rigid.changes()).map(|rigid| &rigid.cells);
        rigid.chain(self.beams.iter().map(Beam::cells))
    }

    /// Paint the bodies whose drag changes.
    pub fn paint(&mut self) {
        let Self { rate: Some(rate), painted, rigid, beams, .. } = self else { return };
        painted.erase(rate);
        let rigid = rigid.iter().filter(|rigid| rigid.changes()).map(|rigid| &rigid.cells);
        rigid.chain(beams.iter().map(Beam::cells)).for_each(|cells| painted.add(cells, rate));
    }

    /// Add `weight(Σ a) a_b u_b` of all zones and bodies at a time (s) to `w`.
    pub fn add_velocities<R: Real>(
        &self,
        time: f64,
        weight: impl Fn(f64) -> f64,
        grid: &Grid<D>,
        w: &mut [Field<R>; D],
    ) {
        let Some(rate) = &self.rate else { return };
        let (plane, row) = (grid.len() / grid.cells[0], grid.len() / (grid.cells[0] * grid.cells[1]));
        for DrivingZone { mean_velocity, columns, shape } in &self.zones {
            let mean = mean_velocity.value(time);
            for &(i, zone) in columns {
                let points = i * plane..(i + 1) * plane;
                let rows = w[0][points.clone()].chunks_exact_mut(row).zip(rate[points].chunks_exact(row));
                for ((w, rate), shape) in rows.zip(shape) {
                    for (w, rate) in w.iter_mut().zip(rate) {
                        *w = R::rounded(w.to_f64() + weight(*rate) * zone * mean * shape);
                    }
                }
            }
        }
        for cell in self.changing().flat_map(Cells::iter) {
            let weight = weight(rate[cell.index]) * cell.rate;
            for (w, velocity) in w.iter_mut().zip(&cell.velocity) {
                w[cell.index] = R::rounded(w[cell.index].to_f64() + weight * velocity);
            }
        }
    }

    /// Add `Σ a_b u_b` of all zones and bodies at a time (s) to `sums` at some points in ascending order.
    pub fn add_velocities_at(&self, time: f64, grid: &Grid<D>, points: &[usize], sums: &mut [[f64; D]]) {
        if points.is_empty() {
            return;
        }
        let (plane, row) = (grid.len() / grid.cells[0], grid.len() / (grid.cells[0] * grid.cells[1]));
        for DrivingZone { mean_velocity, columns, shape } in &self.zones {
            let mean = mean_velocity.value(time);
            for (sum, point) in sums.iter_mut().zip(points) {
                if let Ok(column) = columns.binary_search_by_key(&(point / plane), |(i, _)| *i) {
                    sum[0] += columns[column].1 * mean * shape[point / row % grid.cells[1]];
                }
            }
        }
        for cell in self.changing().flat_map(Cells::iter) {
            if let Ok(k) = points.binary_search(&cell.index) {
                (0..D).for_each(|axis| sums[k][axis] += cell.rate * cell.velocity[axis]);
            }
        }
    }

    /// Write the displaced fluid of the rigid bodies and the beams with a mask to their numbers in `forces`.
    pub fn set_displaced(&self, stations: &[Stations<D>], forces: &mut [BodyForce<D>]) {
        let (on_rigid, on_flexible) = forces.split_at_mut(self.rigid.len());
        on_rigid.iter_mut().zip(&self.rigid).for_each(|(own, rigid)| own.displaced = rigid.displaced(self.density));
        for beam in &self.beams {
            on_flexible[beam.number].displaced = beam.displaced(&stations[beam.number], self.density);
        }
    }

    /// Sum up the forces of a step of size `dt` (s) from `drag`, the drag on a cell over the density, m/s².
    ///
    /// The penalization integral lacks the rate of change of the momentum that the fluid displaced by a moving body
    /// would have (thesis eq. 3.20). The drag on the part of a beam inside its cylinder acts on the cylinder.
    pub fn sum_up_forces(
        &self,
        dt: f64,
        drag: impl Fn(&Cell<D>) -> Vector<D>,
        stations: &[Stations<D>],
        forces: &mut [BodyForce<D>],
        exchange: &mut [Exchange<D>],
    ) {
        let drag = &|cell: &Cell<D>| drag(cell) * self.cell_mass;
        let (on_rigid, on_flexible) = forces.split_at_mut(self.rigid.len());
        for (known, rigid) in on_rigid.iter_mut().zip(&self.rigid) {
            let mut sum = Force::default();
            rigid.cells.iter().for_each(|cell| sum.add(&drag(cell), &cell.arm));
            match &rigid.spring_motion {
                Some(found) => known.update_with(sum, found.unsteady, rigid.displaced(self.density)),
                None if rigid.is_thin() => (),
                None => known.update(sum, rigid.displaced(self.density), dt),
            }
        }
        for beam in &self.beams {
            let (k, stations) = (beam.number, &stations[beam.number]);
            let (force, power) = beam.force(drag, stations, |support, force, at| {
                on_rigid[support].force.add(&force, &(at - self.rigid[support].pose.position));
            });
            exchange[k] = Exchange { force: force.force.into(), power, work: exchange[k].work + power * dt };
            on_flexible[k].update(force, beam.displaced(stations, self.density), dt);
        }
    }
}

impl<const D: usize> Rigid<D>
where
    [f64; D]: Space<D>,
{
    /// Find the motion of a body on springs under a drag, and return the change of its velocities; none if it is not on
    /// springs.
    fn solve_springs(
        &mut self,
        c: [f64; 3],
        history: &DisplacementHistory<D>,
        density: f64,
        drag: &Drag<D>,
    ) -> Option<Freedoms> {
        let mount = *self.mount()?;
        let (fluid, predicted) = (self.displaced_mass(density), self.pose.rates());
        let Mount { mass, supports, .. } = &mount;
        let (inertia, weight) = (self.inertia_at_rest(mount.inertia), self.weight(&mount, &fluid));
        let step = MountedStep { supports, history, c, mass: *mass, inertia, fluid, weight, predicted };
        let found = step.solve(drag);
        self.spring_motion = Some(found);
        Some(found.change)
    }

    /// Change the velocities of the cells in a step with the first coefficient `c_0` of the differences, where all bodies
    /// have the penalization rate `rate` (1/s), and add what that does to `u*` to `w`.
    fn change_velocities<R: Real>(&mut self, change: &Freedoms, c_0: f64, rate: &[f64], w: &mut [Field<R>; D]) {
        for cell in self.cells.iter_mut() {
            let share = cell.rate / (c_0 + rate[cell.index]);
            let change = velocity_of(change, &cell.arm);
            for (axis, w) in w.iter_mut().enumerate() {
                let change = cell.gain[axis] * change[axis];
                cell.velocity[axis] += change;
                w[cell.index] = R::rounded(w[cell.index].to_f64() + share * change);
            }
        }
    }

    /// Add the push of contact to the drag.
    fn add_push(&self, drag: &mut Drag<D>) {
        let MountPush { load, velocities, .. } = &self.push;
        let predicted = self.pose.rates();
        let change = |row: &Freedoms| (0..6).map(|j| row[j] * (velocities[j] - predicted[j])).sum::<f64>();
        let (force, moment) = split::<D>(&load.impedance.each_ref().map(change));
        add_load(drag, load);
        drag.force = drag.force.plus(&Force { force, moment });
    }

    /// Return the drag in a step with the first coefficient `c_0` of the differences, on cells of fluid of a mass (kg) at
    /// the penalization rate `rate` (1/s) of all bodies; `u_star` is `u*` at a grid point.
    fn drag(&self, c_0: f64, cell_mass: f64, rate: &[f64], u_star: impl Fn(usize) -> [f64; D]) -> Drag<D> {
        let mut drag = Drag::default();
        for cell in self.cells.iter() {
            let share = cell.rate / (c_0 + rate[cell.index]);
            let slip = Vector::from(u_star(cell.index)) - cell.velocity;
            let weight = cell_mass * cell.rate;
            drag.add(weight * slip, cell.gain.map(|gain| weight * gain * (1.0 - share)), &cell.arm);
        }
        drag
    }

    /// Move from the predicted place to a displacement, and return the change of the velocities.
    fn move_to(&mut self, end: Pose<D>, c: [f64; 3], history: &DisplacementHistory<D>, density: f64) -> Freedoms {
        let found = SpringMotion::given(end, c, history, &self.displaced_mass(density), &self.pose.rates());
        self.spring_motion = Some(found);
        found.change
    }

    /// Return the weight less that of the fluid that carries the body, with its moment about the pivot. A thin body
    /// displaces none.
    fn weight(&self, mount: &Mount<D>, fluid: &Mass<D>) -> Freedoms {
        let (gravity, carrying) = (Vector::from(mount.gravity), if self.is_thin() { 0.0 } else { fluid.mass });
        join::<D>(&(gravity * (mount.mass - carrying)), <[f64; D]>::cross(&fluid.arm, &(gravity * -carrying)))
    }
}

/// Return the force that a mass along the freedoms lacks under an acceleration.
fn inertia_of<const D: usize>(mass: &[Freedoms; 6], acceleration: &Freedoms) -> Force<D>
where
    [f64; D]: Space<D>,
{
    let row = |row: &Freedoms| -row.iter().zip(acceleration).map(|(mass, a)| mass * a).sum::<f64>();
    let (force, moment) = split::<D>(&mass.each_ref().map(row));
    Force { force, moment }
}

/// Add another load on the same body.
fn add_load<const D: usize>(load: &mut Drag<D>, other: &Drag<D>)
where
    [f64; D]: Space<D>,
{
    load.force = load.force.plus(&other.force);
    load.impedance.iter_mut().zip(&other.impedance).for_each(|(row, own)| {
        row.iter_mut().zip(own).for_each(|(entry, own)| *entry += own);
    });
}

/// Return the velocity of a point at `arm` (m) from the pivot for velocities along the freedoms.
pub fn velocity_of<const D: usize>(freedoms: &Freedoms, arm: &Vector<D>) -> Vector<D>
where
    [f64; D]: Space<D>,
{
    let (velocity, omega) = split::<D>(freedoms);
    velocity + <[f64; D]>::swing(omega, arm)
}

/// Return the distance (m) of a grid point from the nearest wall, negative in it.
fn distance_from<const D: usize>(walls: &[Option<[f64; 2]>; D], grid: &Grid<D>, index: usize) -> f64
where
    [f64; D]: Space<D>,
{
    let point = grid.point(index);
    let pairs = walls.iter().enumerate().filter_map(|(axis, pair)| pair.map(|[low, high]| (axis, low, high)));
    let distances =
        pairs.map(|(axis, low, high)| 0.5 * (high - low) - grid.periodic(axis, point[axis] - 0.5 * (low + high)).abs());
    distances.fold(f64::INFINITY, f64::min)
}
