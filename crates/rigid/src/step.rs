//! A step of a rigid body on springs and dampers.
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

use crate::force::{Drag, Force};
use crate::history::DisplacementHistory;
use crate::kinematics::{Freedoms, Kinematics, Vector, join, split};
use crate::pose::Pose;

/// Least mass that a body resists the change of its velocity with within a step, by that of the displaced fluid.
/// Circles are stable with 0.8 and more, down to 0.03 of the displaced mass; with 0.65 down to 0.3. Ellipses of aspect
/// ratio 3 across the motion would need less, and are stable above 0.7 of the displaced mass.
const LEAST_MASS: f64 = 0.8;

/// A rigid mass: of a body, or of the fluid that it displaces.
#[derive(Clone, Copy, Debug)]
pub struct Mass<const D: usize> {
    /// Mass, kg.
    pub mass: f64,
    /// Moments of inertia about the pivot, as a matrix in the axes of the domain.
    pub inertia: [[f64; 3]; 3],
    /// Centre from the pivot, m.
    pub arm: Vector<D>,
}

/// A body in a step.
pub struct SpringStep<'a, const D: usize>
where
    [f64; D]: Kinematics<D>,
{
    /// Spring and damper along each freedom; absent where the body is held.
    pub supports: &'a [Option<Support>; 6],
    /// Displacement before the step.
    pub history: &'a DisplacementHistory<D>,
    /// Coefficients of the backward differences.
    pub c: [f64; 3],
    /// Mass matrix of the body along the freedoms.
    pub mass: [Freedoms; 6],
    /// Force that the body needs along the freedoms to keep its velocities.
    pub gyroscopic: Freedoms,
    /// The displaced fluid.
    pub fluid: Mass<D>,
    /// Weight less that of the fluid that carries the body, with its moment.
    pub weight: Freedoms,
    /// Velocities along the freedoms with which the drag was found.
    pub predicted: Freedoms,
}

/// What a body does in a step.
#[derive(Clone, Copy, Debug)]
pub struct SpringMotion<const D: usize>
where
    [f64; D]: Kinematics<D>,
{
    /// Displacement at the end.
    pub displacement: Pose<D>,
    /// Accelerations along the freedoms.
    pub acceleration: Freedoms,
    /// Change of the velocities from those predicted.
    pub change: Freedoms,
    /// Rate of change of the momentum of the displaced fluid.
    pub unsteady: Force<D>,
    /// Rate at which a force grows with the velocities, kg/s; its row is that of the identity where the body is held,
    /// and 0 for a body that was put to its place.
    pub matrix: [Freedoms; 6],
}

impl<const D: usize> Mass<D>
where
    [f64; D]: Kinematics<D>,
{
    /// Return the mass matrix along the freedoms.
    pub fn matrix(&self) -> [Freedoms; 6] {
        let mut matrix = [[0.0; 6]; 6];
        let at_centre = <[f64; D]>::jacobian(1.0, self.arm.into());
        for (i, row) in at_centre.iter().enumerate() {
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

    /// Return the force under which it has an `acceleration` along the freedoms, at these `velocities`.
    pub fn rate_of_momentum(&self, acceleration: &Freedoms, velocities: &Freedoms) -> Force<D> {
        let (matrix, gyroscopic) = (self.matrix(), self.gyroscopic(velocities));
        let sum = |row: &Freedoms| {
            row[..<[f64; D]>::FREEDOMS].iter().zip(acceleration).map(|(mass, a)| mass * a).sum::<f64>()
        };
        let (force, moment) = split::<D>(&from_fn(|i| sum(&matrix[i]) + gyroscopic[i]));
        Force { force, moment }
    }

    /// Return the force that it needs along the freedoms to keep its `velocities`: `m omega × (omega × r)`, and in
    /// space `omega × I omega`.
    pub fn gyroscopic(&self, velocities: &Freedoms) -> Freedoms {
        let (_, omega) = split::<D>(velocities);
        let centripetal = self.mass * <[f64; D]>::swing(omega, &<[f64; D]>::swing(omega, &self.arm));
        let mut force = join::<D>(&centripetal, Default::default());
        if D == 3 {
            let omega = [3, 4, 5].map(|i| velocities[i]);
            let momentum =
                self.inertia.map(|row| row.iter().zip(omega).map(|(entry, omega)| entry * omega).sum::<f64>());
            for i in 0..3 {
                let (next, last) = ((i + 1) % 3, (i + 2) % 3);
                force[3 + i] = omega[next] * momentum[last] - omega[last] * momentum[next];
            }
        }
        force
    }
}

impl<const D: usize> SpringMotion<D>
where
    [f64; D]: Kinematics<D>,
{
    /// Return the step of a body that was put to `displacement`, with the differences `c` and the velocities `predicted`
    /// before that was known.
    pub fn given(
        displacement: Pose<D>,
        c: [f64; 3],
        history: &DisplacementHistory<D>,
        fluid: &Mass<D>,
        predicted: &Freedoms,
    ) -> Self {
        let (v, acceleration) = (displacement.rates(), history.acceleration_to(&displacement, &c));
        let change = from_fn(|i| v[i] - predicted[i]);
        let unsteady = fluid.rate_of_momentum(&acceleration, predicted);
        Self { displacement, acceleration, change, unsteady, matrix: [[0.0; 6]; 6] }
    }

    /// Let a force that the step did not know change the velocities along free directions, as [`Self::add`] does, and
    /// return the change; none where that is at most the part `rounding` of the velocities and the `predicted` ones.
    pub fn yield_to(
        &mut self,
        force: &Force<D>,
        supports: &[Option<Support>; 6],
        predicted: &Freedoms,
        c_0: f64,
        fluid: &Mass<D>,
        rounding: f64,
    ) -> Option<Freedoms> {
        let force = join::<D>(&force.force, force.moment);
        let force: Freedoms = from_fn(|i| if supports[i].is_some() { force[i] } else { 0.0 });
        let change = solve(self.matrix, force);
        let dot = |a: &Freedoms, b: &Freedoms| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let whole = |v: &Freedoms| dot(v, &self.matrix.map(|row| dot(&row, v)));
        let all = whole(predicted) + whole(&self.displacement.rates());
        let is_rounding = dot(&change, &force) <= rounding * rounding * all;
        (!is_rounding).then(|| self.add(&change, c_0, fluid)).map(|()| change)
    }

    /// Change the velocities in a step with the first coefficient `c_0` of the differences; `fluid` is the displaced one.
    pub fn add(&mut self, change: &Freedoms, c_0: f64, fluid: &Mass<D>) {
        let more: Freedoms = from_fn(|i| c_0 * change[i]);
        (0..6).for_each(|i| {
            self.acceleration[i] += more[i];
            self.change[i] += change[i];
        });
        self.unsteady = self.unsteady.plus(&fluid.rate_of_momentum(&more, &[0.0; 6]));
        let ((way, turn), (velocity, omega)) = (split::<D>(&change.map(|v| v / c_0)), split::<D>(change));
        let Pose { position, angle, velocity: known, omega: turning } = self.displacement;
        let (angle, _) = <[f64; D]>::turned((angle, turning), turn, omega);
        self.displacement =
            Pose { position: position + way, angle, velocity: known + velocity, omega: turning + omega };
    }
}

impl<const D: usize> SpringStep<'_, D>
where
    [f64; D]: Kinematics<D>,
{
    /// Find the velocities under `drag`.
    pub fn solve(&self, drag: &Drag<D>) -> SpringMotion<D> {
        let &Self {
            supports,
            history: &DisplacementHistory { now, before, acceleration },
            c,
            ref fluid,
            predicted,
            ..
        } = self;
        let freedoms = 0..<[f64; D]>::FREEDOMS;
        let [v, v_before, x, x_before] = [now.rates(), before.rates(), now.places(), before.places()];
        let (displaced, gyroscopic) = (fluid.matrix(), fluid.gyroscopic(&predicted));
        let on_body = join::<D>(&drag.force.force, drag.force.moment);

        let known: Freedoms = from_fn(|i| c[1] * v[i] + c[2] * v_before[i]);
        let (mut matrix, mut right) = ([[0.0; 6]; 6], [0.0; 6]);
        for i in 0..6 {
            let Some(Support { stiffness, damping, rest }) = supports[i].filter(|_| freedoms.contains(&i)) else {
                matrix[i][i] = 1.0;
                continue;
            };
            right[i] = on_body[i] + gyroscopic[i] - self.gyroscopic[i] + self.weight[i];
            for j in freedoms.clone().filter(|&j| supports[j].is_some()) {
                let net = self.mass[i][j] - displaced[i][j];
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
        SpringMotion {
            displacement: Pose::new(&to, &v),
            acceleration,
            change: from_fn(|i| v[i] - predicted[i]),
            unsteady: fluid.rate_of_momentum(&acceleration, &predicted),
            matrix,
        }
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
