//! What can be set and read of a fluid.

use std::borrow::Cow;

use crate::bodies::{Drag, Pose, Rigid};
use crate::fluid::Fluid;
use crate::force::{Exchange, Force};
use crate::grid::Grid;
use crate::pressures::{PressurePlaces, Pressures};
use crate::solver::Solvable;
use contact::{FastMeeting, FlexibleContact, Loads, Stations};

/// A grid point with its weight.
type Weighted = (usize, f64);

/// Most points of a cubic interpolation.
const MOST: usize = 64;

/// The place of a probe on two grids, m: in the fine box where that was first, or in the domain.
enum OnGrids<const D: usize> {
    InBox([f64; D]),
    Outside([f64; D]),
}

impl<const D: usize> OnGrids<D> {
    /// Return the place of a point (m) of a domain with such a fine box.
    fn find(position: [f64; D], domain: &Grid<D>, fine: &Grid<D>) -> Self {
        let low = fine.low();
        let image = std::array::from_fn(|axis| low[axis] + (position[axis] - low[axis]).rem_euclid(domain.size[axis]));
        let is_inside = |axis: usize| {
            let cells = (image[axis] - low[axis]) / fine.spacing[axis];
            2.0 <= cells && cells <= fine.cells[axis] as f64 - 2.0
        };
        if (0..D).all(is_inside) { Self::InBox(image) } else { Self::Outside(position) }
    }
}

impl<const D: usize> Fluid<D>
where
    [f64; D]: Solvable<D>,
{
    /// Return the grid of the domain, on which fields are.
    pub fn grid(&self) -> &Grid<D> {
        &self.grid
    }

    /// Return the grid with the bodies: that of the domain, or of the fine box where it is now.
    pub fn grid_of_bodies(&self) -> Grid<D> {
        self.problem.grid.moved(&self.solver.way())
    }

    /// Return the time, s.
    pub fn time(&self) -> f64 {
        self.present.time
    }

    /// Return a velocity component (0: x, 1: y, 2: z), m/s, `[nx, ny]` or `[nx, ny, nz]`; in single precision a copy.
    pub fn velocity(&self, axis: usize) -> Cow<'_, [f64]> {
        self.solver.velocity(axis)
    }

    /// Return a vorticity component (0: x, 1: y, 2: z; in the plane 0: z), 1/s; in single precision a copy.
    pub fn vorticity(&self, component: usize) -> Cow<'_, [f64]> {
        self.solver.vorticity(component)
    }

    /// Return the static pressure p = rho (Pi − u²/2), Pa; Pi has zero mean over the domain. It takes one more transform
    /// than there are dimensions.
    pub fn pressure(&mut self) -> Vec<f64> {
        let (density, mut pressure) = (self.density, vec![0.0; self.grid.len()]);
        self.solver.read_in_domain(&self.present, &mut self.problem, &mut |at| {
            pressure.iter_mut().enumerate().for_each(|(point, pressure)| *pressure = density * at(point));
        });
        pressure
    }

    /// Return a velocity component on [`Self::grid_of_bodies`], m/s.
    pub fn fine_velocity(&self, axis: usize) -> Vec<f64> {
        self.order_from_low_end(&self.solver.own_velocity(axis))
    }

    /// Return a vorticity component on the same grid, 1/s.
    pub fn fine_vorticity(&self, component: usize) -> Vec<f64> {
        self.order_from_low_end(&self.solver.own_vorticity(component))
    }

    /// Return the static pressure on the same grid, Pa.
    pub fn fine_pressure(&mut self) -> Vec<f64> {
        let (density, mut pressure) = (self.density, vec![0.0; self.problem.grid.len()]);
        self.solver.read_pressure(&self.present, &mut self.problem, &mut |_, at| {
            pressure.iter_mut().enumerate().for_each(|(point, pressure)| *pressure = density * at(point));
        });
        self.order_from_low_end(&pressure)
    }

    /// Return what is given at the periodic points of the bodies' grid in their order from its lower end on.
    fn order_from_low_end(&self, values: &[f64]) -> Vec<f64> {
        let (Grid { cells, spacing, .. }, way) = (&self.problem.grid, self.solver.way());
        let moved = |axis: usize| ((way[axis] / spacing[axis]).round() as i64).rem_euclid(cells[axis] as i64) as usize;
        let moved: [_; D] = std::array::from_fn(moved);
        let place = |point: usize| {
            let (mut rest, mut own, mut stride) = (point, 0, 1);
            for axis in (0..D).rev() {
                own += (rest + moved[axis]) % cells[axis] * stride;
                (rest, stride) = (rest / cells[axis], stride * cells[axis]);
            }
            own
        };
        let mut ordered: Vec<_> = (0..values.len()).map(|point| values[place(point)]).collect();
        if self.has_fine_box() {
            (0..D).for_each(|axis| continue_to_low_end(&mut ordered, cells, axis));
        }
        ordered
    }

    /// Return the velocity at a probe, numbered from 0, m/s.
    pub fn probe_velocity(&self, probe: usize) -> [f64; D] {
        if !self.has_fine_box() {
            return self.solver.velocity_by(&self.probes[probe].around);
        }
        let mut room = [(0, 0.0); MOST];
        match OnGrids::find(self.probe_places[probe], &self.grid, &self.grid_of_bodies()) {
            OnGrids::InBox(at) => self.solver.velocity_by(around(at, &self.problem.grid, &mut room)),
            OnGrids::Outside(at) => self.solver.coarse_velocity_by(around(at, &self.grid, &mut room)),
        }
    }

    /// Return whether there are two grids.
    pub fn has_fine_box(&self) -> bool {
        self.grid.spacing != self.problem.grid.spacing
    }

    /// Return the static pressure at a probe, Pa. The first pressure after a step takes transforms.
    pub fn probe_pressure(&mut self, probe: usize) -> f64 {
        self.pressures().probes[probe]
    }

    /// Return the largest divergence of the velocity times the cell size over the largest speed. It takes as many
    /// transforms as the pressure.
    pub fn divergence(&mut self) -> f64 {
        let [largest, fastest] = self.solver.divergence();
        largest * self.problem.grid.cell_size() / fastest.max(f64::MIN_POSITIVE)
    }

    /// Return the CFL number max(|u|/dx + |v|/dy + …) dt of the last step.
    pub fn cfl(&self) -> f64 {
        self.present.cfl(self.present.step)
    }

    /// Return the flow rate through the middle of the domain along x, m³/s, or m²/s in the plane.
    pub fn flow_rate(&self) -> f64 {
        let Grid { cells, spacing, .. } = &self.grid;
        let plane = self.grid.len() / cells[0];
        let sum = self.solver.sum_of_u(cells[0] / 2 * plane..(cells[0] / 2 + 1) * plane);
        spacing[1..].iter().fold(sum, |product, spacing| product * spacing)
    }

    /// Return the kinetic energy of the domain, J, or J/m in the plane.
    pub fn kinetic_energy(&self) -> f64 {
        let [squares, _] = self.solver.squares();
        0.5 * self.density * squares * self.grid.cell_volume()
    }

    /// Return half the integral of the squared vorticity over the domain, m³/s², or m²/s² in the plane.
    pub fn enstrophy(&self) -> f64 {
        let [_, squares] = self.solver.squares();
        0.5 * squares * self.grid.cell_volume()
    }

    /// Return the force of the fluid on all bodies in the last step, N, in the plane per metre of depth.
    pub fn force(&self) -> [f64; D] {
        std::array::from_fn(|axis| self.present.bodies.iter().map(|body| body.force.force[axis]).sum())
    }

    /// Return the force of the fluid on a rigid body, numbered from 0, in the last step.
    pub fn force_on_body(&self, body: usize) -> Force<D> {
        assert!(body < self.problem.bodies.rigid.len(), "there are {} bodies", self.problem.bodies.rigid.len());
        self.present.bodies[body].force
    }

    /// Return the load of the next step on a rigid body that keeps its velocities, if it is announced.
    pub fn load_on_body(&self, body: usize) -> Option<&Drag<D>> {
        self.problem.bodies.announced(body)
    }

    /// Return the power of [`Self::force_on_body`] at the end of the step, W, in the plane per metre of depth.
    pub fn power_on_body(&self, body: usize) -> f64 {
        self.problem.bodies.rigid[body].power(&self.force_on_body(body))
    }

    /// Return place and motion of a rigid body, numbered from 0.
    pub fn pose(&self, body: usize) -> Pose<D> {
        self.problem.bodies.rigid[body].pose
    }

    /// Return the angle of a rigid body, numbered from 0, about the axis of the laws that move it, rad; 0 without a law.
    pub fn angle_of_law(&self, body: usize) -> f64 {
        self.problem.bodies.rigid[body].angle_of_law()
    }

    /// Return the displacement of a body, numbered from 0, at the end of the coming step, to be set before
    /// [`Self::advance`]; only for a body that the master moves.
    ///
    /// # Panics
    /// For a body that moves otherwise.
    pub fn displacement_mut(&mut self, body: usize) -> &mut Pose<D> {
        let is_driven = |(own, rigid): (usize, &Rigid<D>)| own == body && rigid.is_driven();
        let place = self.problem.bodies.carried().position(is_driven);
        &mut self.motion.displaced_to[place.expect("the master moves the body")]
    }

    /// Return the displacement at the end of the coming step of the point that the fine box follows, m, to be set before
    /// [`Self::advance`]; unused unless the master moves the box.
    pub fn box_displacement_mut(&mut self) -> &mut [f64; D] {
        &mut self.problem.box_displacement
    }

    /// Return the force of the fluid on a flexible body, numbered from 0, in the last step.
    pub fn force_on_flexible(&self, body: usize) -> Force<D> {
        self.present.bodies[self.problem.bodies.rigid.len() + body].force
    }

    /// Return the number of markers of the thin bodies.
    pub fn markers(&self) -> usize {
        self.problem.thin.markers()
    }

    /// Return force, power and work of the drag on each flexible body, without the unsteady term of
    /// [`Self::force_on_flexible`].
    pub fn exchange(&self) -> &[Exchange<D>] {
        &self.present.flexible.exchange
    }

    /// Return who met faster than contact surely stops, each pair once.
    pub fn fast_meetings(&self) -> &[FastMeeting] {
        self.flexible_contact.as_ref().map_or(&[], FlexibleContact::fast)
    }

    /// Return the loads on the stations of each flexible body for the coming step; empty if none are predicted.
    pub fn loads(&self) -> &[Loads<D>] {
        &self.present.flexible.loads
    }

    /// Return the stations of each flexible body at the end of the coming step.
    pub fn stations(&self) -> &[Stations<D>] {
        &self.motion.target
    }

    /// Return the stations of each flexible body at the end of the coming step, to be set before [`Self::advance`].
    pub fn stations_mut(&mut self) -> &mut [Stations<D>] {
        &mut self.motion.target
    }

    /// Return the pressure above less the pressure below the stations of each beam in the plane and surface in space, Pa.
    /// The first pressure after a step takes transforms.
    pub fn pressure_jump(&mut self) -> &[Vec<f64>] {
        &self.pressures().jump
    }

    /// Return the shear stress on both faces together at the stations of each flexible body, Pa, by component: of a line in
    /// the plane towards its tip, of a surface along each axis, of another body nothing.
    pub fn shear(&self) -> &[Vec<Vec<f64>>] {
        &self.present.flexible.shear
    }

    /// Return the mean of the pressures above and below the stations of each beam, less the mean over the outlet, Pa;
    /// empty if not wanted. The first pressure after a step takes transforms.
    pub fn pressure_around(&mut self) -> &[Vec<f64>] {
        &self.pressures().around
    }

    fn pressures(&mut self) -> &Pressures {
        let (fine, is_two, moved) = (self.grid_of_bodies(), self.has_fine_box(), self.solver.way() != [0.0; D]);
        let Self { problem, present, solver, density, probes, probe_places, outlet, pressures, grid, .. } = self;
        let density = *density;
        let places = || probe_places.iter().filter(|_| is_two).map(|position| OnGrids::find(*position, grid, &fine));
        let sum = |of: &Grid<D>, place: [f64; D], at: &dyn Fn(usize) -> f64| {
            density * of.cubic_interpolation(place).map(|(point, share)| share * at(point)).sum::<f64>()
        };
        pressures.get(|pressures| {
            solver.read_pressure(present, problem, &mut |problem, at| {
                let (grid, beams, stations) = (&problem.grid, &problem.bodies.beams, &present.flexible.stations);
                let (outlet, thin) = (outlet.as_ref(), &present.flexible.jump);
                PressurePlaces { grid, density, probes, outlet, beams, stations, thin }.read(at, pressures);
                for (pressure, probe) in pressures.probes.iter_mut().zip(places()).filter(|_| moved) {
                    if let OnGrids::InBox(place) = probe {
                        *pressure = sum(grid, place, at);
                    }
                }
            });
            if places().any(|probe| matches!(probe, OnGrids::Outside(_))) {
                solver.read_in_domain(present, problem, &mut |at| {
                    for (pressure, probe) in pressures.probes.iter_mut().zip(places()) {
                        if let OnGrids::Outside(place) = probe {
                            *pressure = sum(grid, place, at);
                        }
                    }
                });
            }
        })
    }

    /// Return the timer of the phases of a step.
    #[cfg(feature = "internals")]
    pub fn timer(&mut self) -> &mut crate::timer::PhaseTimer {
        &mut self.problem.timer
    }
}

/// Continue a field by a cubic to the first points along an axis, where the fluid knows the mean of both ends of the box.
fn continue_to_low_end<const D: usize>(field: &mut [f64], cells: &[usize; D], axis: usize) {
    let inner: usize = cells[axis + 1..].iter().product();
    for block in field.chunks_exact_mut(cells[axis] * inner) {
        for k in 0..inner {
            let at = |point: usize| block[point * inner + k];
            block[k] = 4.0 * (at(1) + at(3)) - 6.0 * at(2) - at(4);
        }
    }
}

/// Write the grid points around a place (m) with their weights, and return them.
fn around<'a, const D: usize>(place: [f64; D], grid: &Grid<D>, room: &'a mut [Weighted; MOST]) -> &'a [Weighted] {
    let mut count = 0;
    for (own, point) in room.iter_mut().zip(grid.cubic_interpolation(place)) {
        (*own, count) = (point, count + 1);
    }
    &room[..count]
}
