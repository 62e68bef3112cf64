//! Limits of the steps and of the motion of the beams.

use crate::bodies::{Pose, Rigid};
use crate::error::Error;
use crate::grid::Grid;
use crate::parameters::{Extent, Flexible};
use crate::space::{Kinematics, Space};
use contact::Stations;

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
    /// Usual communication step, s.
    pub communication_step: f64,
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
            communication_step,
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
        if let Some(c_eta) = explicit {
            let substeps = (h / c_eta - 1e-9).ceil();
            if substeps > MAX_EXPLICIT_SUBSTEPS {
                return Err(Error::Stiff { time: t, step: h, c_eta, substeps, most: MAX_EXPLICIT_SUBSTEPS });
            }
        }
        Ok(Self::count(h, self.longest_step(advection_rate, explicit)))
    }

    /// Return the longest step with an advection rate (1/s) and the longest one of explicit drag, s.
    pub fn longest_step(&self, advection_rate: f64, explicit: Option<f64>) -> f64 {
        let longest = self.max_step.min(self.max_cfl / advection_rate).min(explicit.unwrap_or(f64::INFINITY));
        // A step that would have to be shorter is refused.
        longest.max(self.shortest)
    }

    /// Return the number of equal steps of at most `longest` in `h` seconds.
    pub fn count(h: f64, longest: f64) -> f64 {
        (h / longest - 1e-9).ceil().max(1.0)
    }

    /// Refuse `displacements` by the master that are not finite or lead far outside the domain.
    pub fn check_displacements<'a, const D: usize>(
        &self,
        carried: impl Iterator<Item = &'a Rigid<D>>,
        displacements: &[Pose<D>],
        grid: &Grid<D>,
    ) -> Result<(), Error>
    where
        [f64; D]: Space<D>,
    {
        for (rigid, displacement) in carried.zip(displacements).filter(|(rigid, _)| rigid.is_driven()) {
            let (places, rates) = (displacement.places(), displacement.rates());
            let finite = places.iter().chain(&rates).all(|value| value.is_finite());
            if !finite || is_far(rigid.pose_of(displacement).position.into(), grid) {
                let freedoms = <[f64; D]>::FREEDOMS;
                return Err(Error::Displacement {
                    body: rigid.name().into(),
                    displacement: list(&places[..D]),
                    angle: list(&places[D..freedoms]),
                    velocity: list(&rates[..D]),
                    omega: list(&rates[D..freedoms]),
                });
            }
        }
        Ok(())
    }

    /// Refuse stations that are not finite, far outside the domain or too fast, and lines of coincident stations or
    /// folded back.
    pub fn check_stations<const D: usize>(
        &self,
        bodies: &[Contour],
        all: &[Stations<D>],
        grid: &Grid<D>,
    ) -> Result<(), Error> {
        bodies.iter().zip(all).try_for_each(|(body, stations)| self.check_body(body, stations, grid))
    }

    fn check_body<const D: usize>(&self, body: &Contour, at: &Stations<D>, grid: &Grid<D>) -> Result<(), Error> {
        let get = |field: &[Vec<f64>; D], k: usize| field.each_ref().map(|of| of[k]);
        let along = |k: usize| {
            let [from, to] = [k - 1, k].map(|k| get(&at.position, k));
            let along: [f64; D] = std::array::from_fn(|axis| to[axis] - from[axis]);
            (along, along.iter().fold(0.0_f64, |length, component| length.hypot(*component)))
        };
        for k in 0..at.len() {
            let (position, velocity) = (get(&at.position, k), get(&at.velocity, k));
            let place = || format!("{} {} of {}", body.part, k + 1, body.name);
            if !position.iter().chain(&velocity).all(|c| c.is_finite()) || is_far(position, grid) {
                let (position, velocity) = (list(&position), list(&velocity));
                return Err(Error::Station { place: place(), position, velocity });
            }
            if k > 0 && body.is_line && position == get(&at.position, k - 1) {
                return Err(Error::Coincide { beam: body.name.clone(), station: k, position: list(&position) });
            }
            if k > 1 && body.is_line {
                let ((a, length_a), (b, length_b)) = (along(k - 1), along(k));
                if a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() < FOLDED * length_a * length_b {
                    let position = list(&get(&at.position, k - 1));
                    return Err(Error::Folded { beam: body.name.clone(), station: k, position });
                }
            }
            let rate = velocity.iter().zip(grid.spacing).map(|(u, spacing)| u.abs() / spacing).sum::<f64>();
            let needed = self.max_cfl / rate;
            if needed < self.shortest {
                let (velocity, shortest) = (list(&velocity), self.shortest);
                return Err(Error::FastStation { place: place(), velocity, needed, shortest });
            }
        }
        Ok(())
    }
}

/// What the stations of a flexible body are called, and whether they form a line.
pub struct Contour {
    name: String,
    part: &'static str,
    is_line: bool,
}

impl<const D: usize> From<&Flexible<D>> for Contour {
    fn from(body: &Flexible<D>) -> Self {
        let is_line = !matches!(body.extent, Extent::Surface(_));
        Self { name: body.name.clone(), part: if is_line { "station" } else { "node" }, is_line }
    }
}

/// Return whether a point is farther from the middle of the domain than one and a half times its size.
fn is_far<const D: usize>(position: [f64; D], grid: &Grid<D>) -> bool {
    (0..D).any(|axis| (position[axis] - grid.middle(axis)).abs() > 1.5 * grid.size[axis])
}

/// Return numbers as a text: one alone, several in parentheses.
fn list(numbers: &[f64]) -> String {
    match numbers {
        [number] => format!("{number:.3e}"),
        _ => format!("({})", numbers.iter().map(|number| format!("{number:.3e}")).collect::<Vec<_>>().join(", ")),
    }
}
