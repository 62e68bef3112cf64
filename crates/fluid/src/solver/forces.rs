//! What the fluid does to each body: penalization integral and unsteady term.

use serde::{Deserialize, Serialize};

use super::Fluid;
use crate::beam::{Exchange, Loads};
use crate::body::{Cell, Cells, Displaced};
use crate::kernel::Differences;

/// Force and moment of the fluid on a body in the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Force {
    /// Force, N per metre of depth.
    pub force: [f64; 2],
    /// Moment about the centre of a cylinder or the root of the beam, N m per metre of depth, positive to the left.
    pub moment: f64,
}

/// What the next step has to know of a body's force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct BodyState {
    pub force: Force,
    pub displaced: Displaced,
}

impl Fluid {
    /// Force of the fluid on all cylinders and the beam in the last step, N per metre of depth.
    pub fn force(&self) -> [f64; 2] {
        let sum = |axis: usize| self.state.bodies.iter().map(|body| body.force.force[axis]).sum();
        [sum(0), sum(1)]
    }

    /// Force of the fluid on a cylinder, numbered from 0, in the last step.
    pub fn force_on_cylinder(&self, cylinder: usize) -> Force {
        assert!(cylinder < self.cylinders.len(), "there are {} cylinders", self.cylinders.len());
        self.state.bodies[cylinder].force
    }

    /// Force of the fluid on the beam in the last step; none without a beam.
    pub fn force_on_beam(&self) -> Option<Force> {
        self.beam.as_ref().map(|_| self.state.bodies[self.cylinders.len()].force)
    }

    /// What the fluid did to the beam, without the unsteady term of [`Self::force_on_beam`]; none without a beam.
    pub fn exchange(&self) -> Option<Exchange> {
        self.state.beam.as_ref().map(|beam| beam.exchange)
    }

    /// Cells and displaced fluid of the cylinders, then of the beam.
    fn bodies(&self) -> impl Iterator<Item = (&Cells, Displaced)> {
        let cylinders = self.cylinders.iter().map(|c| (&c.cells, c.displaced(self.density)));
        let beam = self.beam.iter().zip(&self.state.beam);
        let beam = beam.map(|(beam, known)| (&beam.body.cells, beam.body.displaced(&known.stations, self.density)));
        cylinders.chain(beam)
    }

    /// The displaced fluid of all bodies as they are, with no force yet.
    pub(super) fn bodies_without_force(&self) -> Vec<BodyState> {
        self.bodies().map(|(_, displaced)| BodyState { displaced, force: Force::default() }).collect()
    }

    /// Sum up the forces of a step of size `dt` from `drag`, the drag on a cell over the density, m/s².
    ///
    /// The penalization integral lacks the rate of change of the momentum that the fluid displaced by a moving body
    /// would have (thesis eq. 3.20).
    pub(super) fn sum_up_forces(&mut self, dt: f64, drag: impl Fn(&Self, &Cell) -> [f64; 2]) {
        let mut known = std::mem::take(&mut self.state.bodies);
        let weight = self.density * self.grid.cell_area();
        let (mut beam_drag, mut power) = ([0.0; 2], 0.0);
        for (number, (known, (cells, displaced))) in known.iter_mut().zip(self.bodies()).enumerate() {
            let beam = self.beam.as_ref().zip(self.state.beam.as_ref()).filter(|_| number == self.cylinders.len());
            let mut section = beam.into_iter().flat_map(|(beam, known)| beam.body.section_velocities(&known.stations));
            let mut sum = Force::default();
            for cell in cells.iter() {
                let [fx, fy] = drag(self, cell).map(|drag| weight * drag);
                sum.force[0] += fx;
                sum.force[1] += fy;
                sum.moment += cell.arm[0] * fy - cell.arm[1] * fx;
                if let Some([u, v]) = section.next() {
                    power += fx * u + fy * v;
                }
            }
            beam_drag = sum.force;
            let unsteady = displaced.rate_of_change(&known.displaced, dt);
            (0..2).for_each(|axis| sum.force[axis] += unsteady.force[axis]);
            sum.moment += unsteady.moment;
            *known = BodyState { force: sum, displaced };
        }
        self.state.bodies = known;
        if let Some(beam) = &mut self.state.beam {
            let work = beam.exchange.work + power * dt;
            beam.exchange = Exchange { force: beam_drag, power, work };
        }
    }

    /// Loads on the stations in the coming step of the same size, were the stations to keep their velocities.
    pub(super) fn predict_loads(&mut self) {
        let Some(mut loads) = self.state.beam.as_mut().and_then(|known| known.loads.take()) else { return };
        if self.rk2.is_some() {
            self.loads_of_rk2(&mut loads)
        } else {
            self.loads_of_sbdf2(&mut loads)
        }
        if let Some(known) = &mut self.state.beam {
            known.loads = Some(loads);
        }
    }

    fn loads_of_sbdf2(&self, loads: &mut Loads) {
        let (Some(beam), Some(rate)) = (&self.beam, &self.rate) else { return };
        let scheme = Differences::new(self.state.step, self.state.step);
        let components = [0, 1].map(|axis| self.state.component(axis));
        let weight = self.density * self.grid.cell_area();
        let drag = |cell: &Cell| {
            let share = cell.rate / (scheme.c[0] + rate[cell.index]);
            // a_b (u* − u_b) with u* = (r + a_b u_b)/(c_0 + Σ a).
            let force = [0, 1].map(|axis| {
                let (r, _) = components[axis].right_side(&scheme, cell.index);
                let momentum = cell.rate * cell.velocity[axis];
                weight * (share * (r + momentum) - momentum)
            });
            (force, cell.gain.map(|gain| weight * cell.rate * gain * (1.0 - share)))
        };
        beam.body.collect(drag, loads);
    }

    /// The drag as it is. A change of the body's velocity in the coming step moves the fluid along with `dt a_b/2`.
    fn loads_of_rk2(&self, loads: &mut Loads) {
        let Some(beam) = &self.beam else { return };
        let weight = self.density * self.grid.cell_area();
        let drag = |cell: &Cell| {
            let force = self.present_drag(cell).map(|drag| weight * drag);
            (force, cell.gain.map(|gain| weight * cell.rate * gain * (1.0 - 0.5 * self.state.step * cell.rate)))
        };
        beam.body.collect(drag, loads);
    }

    /// Drag of the present flow on a cell over the density, `a_b (u − u_b)`, m/s².
    pub(super) fn present_drag(&self, cell: &Cell) -> [f64; 2] {
        [0, 1].map(|axis| cell.rate * (self.state.flow.velocity[axis][cell.index] - cell.velocity[axis]))
    }
}
