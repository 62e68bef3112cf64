//! Limits of the steps and of the motion of the beams.

use crate::bodies::{Bodies, Pose, Stations};
use crate::error::Error;
use crate::grid::Grid;

/// Flow and beams may shorten the usual step of the fluid by this factor. The usual step is the smaller of `max_step`
/// and the usual communication step.
const SMALLEST_STEP_DIVISOR: f64 = 100.0;

/// Longest communication step, in usual communication steps.
const LONGEST_COMMUNICATION_STEP: f64 = 1000.0;

/// Largest number of usual steps in a communication step.
const MAX_SUBSTEPS: f64 = 1e5;

/// Largest number of steps in a communication step with explicit drag, whose limit depends on the bodies alone.
const MAX_EXPLICIT_SUBSTEPS: f64 = 1e4;

/// Cosine of the angle between two neighbouring segments below which a beam is folded back on itself: within 11° of it
/// the beam has no upper side there.
const FOLDED: f64 = -0.98;

/// Limits of the steps of a fluid.
pub struct StepLimits {
    /// Largest step of the fluid, s.
    max_step: f64,
    /// Largest CFL number.
    pub max_cfl: f64,
    /// Shortest step that flow or beams may require, s.
    pub shortest: f64,
    /// Longest communication step, s.
    longest: f64,
}

impl StepLimits {
    /// Limits from the largest step (s), the largest CFL number and the usual communication step (s).
    pub fn new(max_step: f64, max_cfl: f64, communication_step: f64) -> Self {
        let usual_step = max_step.min(communication_step);
        Self {
            max_step,
            max_cfl,
            shortest: usual_step / SMALLEST_STEP_DIVISOR,
            longest: (LONGEST_COMMUNICATION_STEP * communication_step).min(MAX_SUBSTEPS * usual_step),
        }
    }

    /// Refuse a communication step from `t` to `t + h` (s) that is no positive number or too long.
    pub fn check(&self, t: f64, h: f64) -> Result<(), Error> {
        if !(t.is_finite() && h.is_finite() && h > 0.0) {
            return Err(Error::Step { time: t, step: h });
        }
        if h > self.longest {
            return Err(Error::Long { time: t, step: h, longest: self.longest });
        }
        Ok(())
    }

    /// Return the number of steps in a communication step, with an advection rate (1/s) and the longest step (s) of
    /// explicit drag.
    pub fn divide(&self, t: f64, h: f64, advection_rate: f64, explicit: Option<f64>) -> Result<f64, Error> {
        let (needed, shortest) = (self.max_cfl / advection_rate, self.shortest);
        if needed.is_nan() || needed < shortest {
            return Err(Error::Diverged { time: t, needed, shortest });
        }
        let mut largest = self.max_step.min(needed);
        if let Some(c_eta) = explicit {
            let substeps = (h / c_eta - 1e-9).ceil();
            if substeps > MAX_EXPLICIT_SUBSTEPS {
                return Err(Error::Stiff { time: t, step: h, c_eta, substeps, most: MAX_EXPLICIT_SUBSTEPS });
            }
            largest = largest.min(c_eta);
        }
        Ok((h / largest - 1e-9).ceil().max(1.0))
    }

    /// Refuse `displacements` of the bodies that laws do not move which are not finite or lead far outside the domain.
    pub fn check_bodies(&self, bodies: &Bodies, displacements: &[Pose], grid: &Grid) -> Result<(), Error> {
        for ((rigid, _), displacement) in bodies.carried().zip(displacements) {
            let finite = displacement.places().iter().chain(&displacement.rates()).all(|value| value.is_finite());
            let position = bodies.displaced_pose(rigid, displacement).position;
            let far = (0..2).any(|axis| (position[axis] - grid.middle(axis)).abs() > 1.5 * grid.size[axis]);
            if !finite || far {
                let &Pose { position: [x, y], angle, velocity: [vx, vy], omega } = displacement;
                return Err(Error::Displacement { body: rigid + 1 - bodies.cylinders(), x, y, angle, vx, vy, omega });
            }
        }
        Ok(())
    }

    /// Refuse stations that are not finite, far outside the domain, coincident, folded back or too fast.
    pub fn check_beams(&self, beams: &[Stations], grid: &Grid) -> Result<(), Error> {
        let name = |k| if beams.len() == 1 { "the beam".into() } else { format!("beam {}", k + 1) };
        beams.iter().enumerate().try_for_each(|(k, stations)| self.check_beam(&|| name(k), stations, grid))
    }

    /// Refuse nodes of a thin body in space that are not finite, far outside the domain or too fast.
    pub fn check_nodes(&self, body: &str, nodes: &Stations<3>, grid: &Grid<3>) -> Result<(), Error> {
        for k in 0..nodes.len() {
            let [position, velocity] = [&nodes.position, &nodes.velocity].map(|all| all.each_ref().map(|all| all[k]));
            let near = |axis: usize| (position[axis] - grid.middle(axis)).abs() <= 1.5 * grid.size[axis];
            let rate = (0..3).map(|axis| velocity[axis].abs() / grid.spacing[axis]).sum::<f64>();
            if !((0..3).all(near) && rate * self.shortest <= self.max_cfl) {
                let [position, velocity] = [position, velocity].map(|[x, y, z]| format!("({x:.3e}, {y:.3e}, {z:.3e})"));
                let (body, shortest) = (body.to_owned(), self.shortest);
                return Err(Error::Node { body, node: k + 1, position, velocity, shortest });
            }
        }
        Ok(())
    }

    /// Check the stations of the beam with the name that `name` returns.
    fn check_beam(&self, name: &dyn Fn() -> String, stations: &Stations, grid: &Grid) -> Result<(), Error> {
        let Stations { position: [x, y], velocity: [vx, vy] } = stations;
        let [dx, dy] = grid.spacing;
        let far = |p: f64, axis: usize| (p - grid.middle(axis)).abs() > 1.5 * grid.size[axis];
        for k in 0..x.len() {
            let finite = [x[k], y[k], vx[k], vy[k]].iter().all(|c| c.is_finite());
            if !finite || far(x[k], 0) || far(y[k], 1) {
                let (beam, station) = (name(), k + 1);
                return Err(Error::Station { beam, station, x: x[k], y: y[k], vx: vx[k], vy: vy[k] });
            }
            if k > 0 && x[k] == x[k - 1] && y[k] == y[k - 1] {
                return Err(Error::Coincide { beam: name(), station: k, x: x[k], y: y[k] });
            }
            if k > 1 {
                let [[ax, ay], [bx, by]] = [k - 1, k].map(|k| [x[k] - x[k - 1], y[k] - y[k - 1]]);
                if ax * bx + ay * by < FOLDED * ax.hypot(ay) * bx.hypot(by) {
                    return Err(Error::Folded { beam: name(), station: k, x: x[k - 1], y: y[k - 1] });
                }
            }
            let needed = self.max_cfl / (vx[k].abs() / dx + vy[k].abs() / dy);
            if needed < self.shortest {
                let (beam, station, shortest) = (name(), k + 1, self.shortest);
                return Err(Error::FastStation { beam, station, vx: vx[k], vy: vy[k], needed, shortest });
            }
        }
        Ok(())
    }
}
