//! What a two-step scheme knows of the displacement of a body.

use std::array::from_fn;

use serde::{Deserialize, Serialize};

use crate::kinematics::{Freedoms, Kinematics};
use crate::pose::Pose;

/// Displacement of a body that laws do not move, from its place at rest, at two times.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DisplacementHistory<const D: usize>
where
    [f64; D]: Kinematics<D>,
{
    /// At the present time.
    pub now: Pose<D>,
    /// One step earlier.
    pub before: Pose<D>,
    /// Accelerations along the freedoms in the last step.
    pub acceleration: Freedoms,
}

impl<const D: usize> Default for DisplacementHistory<D>
where
    [f64; D]: Kinematics<D>,
{
    fn default() -> Self {
        Self::at(Pose::default())
    }
}

impl<const D: usize> DisplacementHistory<D>
where
    [f64; D]: Kinematics<D>,
{
    /// Return the displacement of a body that begins at one, in its motion.
    pub fn at(now: Pose<D>) -> Self {
        Self { now, before: now, acceleration: [0.0; 6] }
    }

    /// Return the displacement expected after a step of `dt` seconds, the last one being `before` (s; 0 if there was
    /// none).
    pub fn predicted(&self, dt: f64, before: f64) -> Pose<D> {
        let ratio = if before > 0.0 { dt / before } else { 0.0 };
        let (places, rates, earlier) = (self.now.places(), self.now.rates(), self.before.rates());
        let growth: Freedoms = from_fn(|i| ratio * (rates[i] - earlier[i]));
        // The rate of an angle in space depends on the angle, too.
        let slope = self.now.rates_of_places();
        let half: Freedoms = from_fn(|i| places[i] + 0.5 * dt * slope[i]);
        let middle = Pose::<D>::new(&half, &from_fn(|i| rates[i] + 0.5 * growth[i])).rates_of_places();
        Pose::new(&from_fn(|i| places[i] + dt * middle[i]), &from_fn(|i| rates[i] + growth[i]))
    }

    /// Return the accelerations along the freedoms in a step to a displacement with the coefficients `c` of the backward
    /// differences.
    pub fn acceleration_to(&self, end: &Pose<D>, c: &[f64; 3]) -> Freedoms {
        let [v, now, before] = [end, &self.now, &self.before].map(Pose::rates);
        from_fn(|i| c[0] * v[i] - c[1] * now[i] - c[2] * before[i])
    }

    /// Return whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        let Self { now, before, acceleration } = self;
        let all = [now.places(), now.rates(), before.places(), before.rates(), *acceleration];
        all.as_flattened().iter().all(|x| x.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Return how far from its way a body is expected after a step of `0.7 h` that follows one of `h` seconds. It turns
    /// at `omega(t)` from an angle about other axes, and moves at `velocity(t)`.
    fn off<const D: usize>(h: f64) -> f64
    where
        [f64; D]: Kinematics<D>,
    {
        let rates = |t: f64| from_fn(|i| 0.3 + 0.4 * i as f64 - (1.2 - 0.5 * i as f64) * t);
        let pose = |t: f64| {
            // By Runge and Kutta, because an angle in space does not grow with the angular velocity.
            let (mut places, steps) = (from_fn(|i| 0.4 - 0.2 * i as f64), 200);
            let dt = t / f64::from(steps);
            for k in 0..steps {
                let slope = |places: &Freedoms, t: f64| Pose::<D>::new(places, &rates(t)).rates_of_places();
                let (at, half) = (dt * f64::from(k), 0.5 * dt);
                let one = slope(&places, at);
                let two = slope(&from_fn(|i| places[i] + half * one[i]), at + half);
                let three = slope(&from_fn(|i| places[i] + half * two[i]), at + half);
                let four = slope(&from_fn(|i| places[i] + dt * three[i]), at + dt);
                places = from_fn(|i| places[i] + dt / 6.0 * (one[i] + 2.0 * (two[i] + three[i]) + four[i]));
            }
            Pose::<D>::new(&places, &rates(t))
        };
        let history = DisplacementHistory { now: pose(0.2), before: pose(0.2 - h), acceleration: [0.0; 6] };
        let (found, expected) = (history.predicted(0.7 * h, h), pose(0.2 + 0.7 * h));
        let pairs = [(found.places(), expected.places()), (found.rates(), expected.rates())];
        let difference = |(a, b): (Freedoms, Freedoms)| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        pairs.map(difference).iter().sum::<f64>().sqrt()
    }

    #[test]
    fn a_body_is_expected_where_it_goes_to_third_order() {
        assert!(off::<2>(0.1) < 1e-12, "a constant acceleration is off by {}", off::<2>(0.1));
        let [coarse, fine] = [0.1, 0.05].map(off::<3>);
        assert!(coarse < 1e-3 && coarse / fine > 6.0, "{coarse} m, then {fine} m");
    }
}
