//! Bodies on springs and dampers.
//!
//! With the velocities `V` along the freedoms (of the pivot, and angular), the mass `M` of the body, the mass `B` of the
//! displaced fluid and the drag `D` on the cells, the body obeys
//!
//! ```text
//! M V' = D + B V' + (B − M) gyroscopic − damping V − stiffness (X − rest) + (M − B) g
//! ```
//!
//! in gravity g, which acts on the mass at the pivot and on the displaced fluid at its centroid, and with the
//! accelerations that a constant angular velocity asks for as the gyroscopic term: `m_d omega × (omega × r)` for that
//! fluid with its centroid at `r` from the pivot, and in space `omega × I omega`. V' and X' are the two-step backward
//! differences of the fluid. `D = D(V~) − H (V − V~)` is linear in V, so both are solved together: the body is implicit
//! in the drag, and the fluid gets the momentum that the body loses.
//!
//! A light body would be unstable, because the fluid around it answers with the pressure of the next step only. So
//! `K (V' − V'_before)` is added to `M V'`, with the virtual mass K that a body lacks to [`LEAST_MASS`]; heavier bodies
//! than the displaced fluid lack little or nothing.

use std::array::from_fn;

use method::Support;
use serde::{Deserialize, Serialize};

use super::pose::Pose;
use crate::force::Force;
use crate::parameters::Mount;
use crate::space::{Freedoms, Space, Vector, join, split};

/// Least mass that a body resists the change of its velocity with within a step, by that of the displaced fluid.
/// Circles are stable with 0.8 and more, down to 0.03 of the displaced mass; with 0.65 down to 0.3. Ellipses of aspect
/// ratio 3 across the motion would need less, and are stable above 0.7 of the displaced mass.
const LEAST_MASS: f64 = 0.8;

/// Displacement of a body that laws do not move, from its place at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Carried<const D: usize>
where
    [f64; D]: Space<D>,
{
    /// At the present time.
    pub now: Pose<D>,
    /// One step earlier.
    pub before: Pose<D>,
    /// Accelerations along the freedoms in the last step, of a body on springs.
    pub acceleration: Freedoms,
}

impl<const D: usize> Default for Carried<D>
where
    [f64; D]: Space<D>,
{
    fn default() -> Self {
        Self { now: Pose::default(), before: Pose::default(), acceleration: [0.0; 6] }
    }
}

impl<const D: usize> Carried<D>
where
    [f64; D]: Space<D>,
{
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

    /// Return whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        let Self { now, before, acceleration } = self;
        let all = [now.places(), now.rates(), before.places(), before.rates(), *acceleration];
        all.as_flattened().iter().all(|x| x.is_finite())
    }
}

/// Drag on a body, and how it falls with the velocities of the body.
#[derive(Clone, Copy, Debug)]
pub struct Drag<const D: usize>
where
    [f64; D]: Space<D>,
{
    /// Force and moment about the pivot.
    pub force: Force<D>,
    /// Rate at which they fall with the velocities along the freedoms.
    pub impedance: [Freedoms; 6],
}

impl<const D: usize> Default for Drag<D>
where
    [f64; D]: Space<D>,
{
    fn default() -> Self {
        Self { force: Force::default(), impedance: [[0.0; 6]; 6] }
    }
}

impl<const D: usize> Drag<D>
where
    [f64; D]: Space<D>,
{
    /// Add the `force` (N) on a cell at `arm` (m) from the pivot, which falls with the velocity there by `slope` (kg/s)
    /// along each axis.
    pub fn add(&mut self, force: Vector<D>, slope: Vector<D>, arm: &Vector<D>) {
        self.force.add(&force, arm);
        let along = <[f64; D]>::jacobian(1.0, (*arm).into());
        for (slope, along) in slope.iter().zip(along) {
            for (row, to) in self.impedance.iter_mut().zip(along).take(<[f64; D]>::FREEDOMS) {
                row.iter_mut().zip(along).for_each(|(entry, from)| *entry += to * slope * from);
            }
        }
    }
}

/// A body on springs in a step.
pub struct SpringStep<'a, const D: usize>
where
    [f64; D]: Space<D>,
{
    pub mount: Mount<D>,
    /// Displacement before the step.
    pub carried: &'a Carried<D>,
    /// Coefficients of the backward differences.
    pub c: [f64; 3],
    /// Moments of inertia of the body, as a matrix in the axes of the domain.
    pub inertia: [[f64; 3]; 3],
    /// The displaced fluid.
    pub fluid: DisplacedMass<D>,
    /// Weight less that of the fluid that carries the body, with its moment.
    pub weight: Freedoms,
    /// Velocities along the freedoms with which the drag was found.
    pub predicted: Freedoms,
}

/// Mass of displaced fluid.
#[derive(Clone, Copy, Debug)]
pub struct DisplacedMass<const D: usize> {
    /// Mass, kg.
    pub mass: f64,
    /// Moments of inertia about the pivot, as a matrix in the axes of the domain.
    pub inertia: [[f64; 3]; 3],
    /// Centroid from the pivot, m.
    pub arm: Vector<D>,
}

/// What a body on springs does in a step.
#[derive(Clone, Copy, Debug)]
pub struct SpringMotion<const D: usize>
where
    [f64; D]: Space<D>,
{
    /// Displacement at the end.
    pub displacement: Pose<D>,
    /// Accelerations along the freedoms.
    pub acceleration: Freedoms,
    /// Change of the velocities from those predicted.
    pub change: Freedoms,
    /// Rate of change of the momentum of the displaced fluid.
    pub unsteady: Force<D>,
}

impl<const D: usize> DisplacedMass<D>
where
    [f64; D]: Space<D>,
{
    /// Return the mass matrix along the freedoms.
    fn matrix(&self) -> [Freedoms; 6] {
        let mut matrix = [[0.0; 6]; 6];
        let at_centroid = <[f64; D]>::jacobian(1.0, self.arm.into());
        for (i, row) in at_centroid.iter().enumerate() {
            for j in 0..6 {
                matrix[i][j] = self.mass * row[j];
                matrix[j][i] = self.mass * row[j];
            }
        }
        for (i, row) in self.inertia.iter().enumerate().take(<[f64; D]>::FREEDOMS - D) {
            (0..<[f64; D]>::FREEDOMS - D).for_each(|j| matrix[D + i][D + j] = row[j]);
        }
        matrix
    }
}

impl<const D: usize> SpringStep<'_, D>
where
    [f64; D]: Space<D>,
{
    /// Find the velocities.
    pub fn solve(&self, drag: &Drag<D>) -> SpringMotion<D> {
        let &Self { mount, carried: &Carried { now, before, acceleration }, c, fluid, predicted, .. } = self;
        let freedoms = 0..<[f64; D]>::FREEDOMS;
        let [v, v_before, x, x_before] = [now.rates(), before.rates(), now.places(), before.places()];
        let displaced = fluid.matrix();
        let gyroscopic = self.gyroscopic(&fluid.inertia);
        let own_gyroscopic = self.gyroscopic(&self.inertia);
        let (_, omega) = split::<D>(&predicted);
        let centripetal = fluid.mass * <[f64; D]>::swing(omega, &<[f64; D]>::swing(omega, &fluid.arm));
        let centripetal = join::<D>(&centripetal, Default::default());
        let on_body = join::<D>(&drag.force.force, drag.force.moment);

        let known: Freedoms = from_fn(|i| c[1] * v[i] + c[2] * v_before[i]);
        let (mut matrix, mut right) = ([[0.0; 6]; 6], [0.0; 6]);
        for i in 0..6 {
            let Some(Support { stiffness, damping, rest }) = mount.supports[i].filter(|_| freedoms.contains(&i)) else {
                matrix[i][i] = 1.0;
                continue;
            };
            right[i] = on_body[i] + centripetal[i] + gyroscopic[i] - own_gyroscopic[i] + self.weight[i];
            for j in freedoms.clone().filter(|&j| mount.supports[j].is_some()) {
                let net = self.own_mass(i, j) - displaced[i][j];
                matrix[i][j] = c[0] * net + drag.impedance[i][j];
                right[i] += net * known[j] + drag.impedance[i][j] * predicted[j];
            }
            let virtual_mass = (LEAST_MASS * displaced[i][i] - matrix[i][i] / c[0]).max(0.0);
            matrix[i][i] += c[0] * virtual_mass + damping + stiffness / c[0];
            right[i] += virtual_mass * (known[i] + acceleration[i]);
            right[i] -= stiffness * ((c[1] * x[i] + c[2] * x_before[i]) / c[0] - rest);
        }
        let v = solve(matrix, right);
        let acceleration: Freedoms = from_fn(|i| c[0] * v[i] - known[i]);
        // The angle at the end, to first order, tells how it grows with the angular velocity.
        let rates = Pose::<D>::new(&from_fn(|i| x[i] + v[i] / c[0]), &v).rates_of_places();
        let to = from_fn(|i| (c[1] * x[i] + c[2] * x_before[i] + rates[i]) / c[0]);
        let sums: Freedoms =
            from_fn(|i| displaced[i][..freedoms.end].iter().zip(acceleration).map(|(mass, a)| mass * a).sum::<f64>());
        let (force, moment) = split::<D>(&from_fn(|i| sums[i] + centripetal[i] + gyroscopic[i]));
        SpringMotion {
            displacement: Pose::new(&to, &v),
            acceleration,
            change: from_fn(|i| v[i] - predicted[i]),
            unsteady: Force { force, moment },
        }
    }

    /// Return the mass of the body between two freedoms.
    fn own_mass(&self, i: usize, j: usize) -> f64 {
        match (i < D, j < D) {
            (true, true) if i == j => self.mount.mass,
            (false, false) => self.inertia[i - D][j - D],
            _ => 0.0,
        }
    }

    /// Return `omega × I omega` with the predicted angular velocity, about the axes of the domain; 0 in the plane.
    fn gyroscopic(&self, inertia: &[[f64; 3]; 3]) -> Freedoms {
        if D == 2 {
            return [0.0; 6];
        }
        let omega = [3, 4, 5].map(|i| self.predicted[i]);
        let momentum = inertia.map(|row| row.iter().zip(omega).map(|(entry, omega)| entry * omega).sum::<f64>());
        from_fn(|i| {
            let about =
                |i: usize| omega[(i + 1) % 3] * momentum[(i + 2) % 3] - omega[(i + 2) % 3] * momentum[(i + 1) % 3];
            if i < 3 { 0.0 } else { about(i - 3) }
        })
    }
}

/// Solve equations by Gauss's elimination with pivoting.
fn solve<const N: usize>(mut matrix: [[f64; N]; N], mut right: [f64; N]) -> [f64; N] {
    for k in 0..N {
        let pivot = (k..N).max_by(|&i, &j| matrix[i][k].abs().total_cmp(&matrix[j][k].abs())).unwrap_or(k);
        matrix.swap(k, pivot);
        right.swap(k, pivot);
        for i in k + 1..N {
            let (row, factor) = (matrix[k], matrix[i][k] / matrix[k][k]);
            matrix[i].iter_mut().zip(row).for_each(|(entry, above)| *entry -= factor * above);
            right[i] -= factor * right[k];
        }
    }
    for k in (0..N).rev() {
        (k + 1..N).for_each(|j| right[k] -= matrix[k][j] * right[j]);
        right[k] /= matrix[k][k];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Return how far from its way a body is expected after a step of `0.7 h` that follows one of `h` seconds. It turns
    /// at `omega(t)` from an angle about other axes, and moves at `velocity(t)`.
    fn off<const D: usize>(h: f64) -> f64
    where
        [f64; D]: Space<D>,
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
        let carried = Carried { now: pose(0.2), before: pose(0.2 - h), acceleration: [0.0; 6] };
        let (found, expected) = (carried.predicted(0.7 * h, h), pose(0.2 + 0.7 * h));
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
