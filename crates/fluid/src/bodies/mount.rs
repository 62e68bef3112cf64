//! Bodies on springs and dampers.
//!
//! With the velocities `V` of the pivot and of the angle, the mass `M` of the body, the mass `B` of the displaced fluid
//! and the drag `D` on the cells, the body obeys
//!
//! ```text
//! M V' = D + B V' − m_d omega² r − damping V − stiffness (X − rest)
//! ```
//!
//! with the mass `m_d` of that fluid and its centroid at `r` from the pivot. V' and X' are the two-step backward
//! differences of the fluid. `D = D(V~) − H (V − V~)` is linear in V, so both are solved together: the body is implicit
//! in the drag, and the fluid gets the momentum that the body loses.
//!
//! A light body would be unstable, because the fluid around it answers with the pressure of the next step only. So
//! `K (V' − V'_before)` is added to `M V'`, with the virtual mass K that a body lacks to [`LEAST_MASS`]; heavier bodies
//! than the displaced fluid lack little or nothing.

use serde::{Deserialize, Serialize};

use super::body_pose::Pose;
use crate::force::Force;
use crate::parameters::{Mount, Support};

/// Least mass that a body resists the change of its velocity with within a step, by that of the displaced fluid.
/// Circles are stable with 0.8 and more, down to 0.03 of the displaced mass; with 0.65 down to 0.3. Ellipses of aspect
/// ratio 3 across the motion would need less, and are stable above 0.7 of the displaced mass.
const LEAST_MASS: f64 = 0.8;

/// Displacement of a body that laws do not move, from its place at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Carried {
    /// At the present time.
    pub now: Pose,
    /// One step earlier.
    pub before: Pose,
    /// Accelerations of x, y and the angle in the last step, of a body on springs.
    pub acceleration: [f64; 3],
}

impl Carried {
    /// Return the displacement expected after a step of `dt` seconds, the last one being `before` (s; 0 if there was
    /// none).
    pub fn predicted(&self, dt: f64, before: f64) -> Pose {
        let ratio = if before > 0.0 { dt / before } else { 0.0 };
        let ([places, rates], earlier) = ([self.now.places(), self.now.rates()], self.before.rates());
        let growth = [0, 1, 2].map(|i| ratio * (rates[i] - earlier[i]));
        let to = [0, 1, 2].map(|i| places[i] + dt * (rates[i] + 0.5 * growth[i]));
        Pose::new(to, [0, 1, 2].map(|i| rates[i] + growth[i]))
    }

    /// Return whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        let Self { now, before, acceleration } = self;
        [now.places(), now.rates(), before.places(), before.rates(), *acceleration]
            .as_flattened()
            .iter()
            .all(|x| x.is_finite())
    }
}

/// Drag on a body, and how it falls with the velocities of the body.
#[derive(Clone, Copy, Debug, Default)]
pub struct Drag {
    /// Force and moment about the pivot.
    pub force: Force,
    /// Rate at which they fall with the velocities of the pivot and the angle.
    pub impedance: [[f64; 3]; 3],
}

impl Drag {
    /// Add the `force` (N/m) on a cell at `arm` (m) from the pivot, which falls with the velocity there by `slope`
    /// (kg/(m s)) along each axis.
    pub fn add(&mut self, force: [f64; 2], slope: [f64; 2], arm: [f64; 2]) {
        self.force.add(force, arm);
        // Velocity of the cell with those of the body.
        let along = [[1.0, 0.0, -arm[1]], [0.0, 1.0, arm[0]]];
        for (slope, along) in slope.iter().zip(along) {
            for (row, to) in self.impedance.iter_mut().zip(along) {
                row.iter_mut().zip(along).for_each(|(entry, from)| *entry += to * slope * from);
            }
        }
    }
}

/// A body on springs in a step.
pub struct Release<'a> {
    pub mount: Mount,
    /// Displacement before the step.
    pub carried: &'a Carried,
    /// Coefficients of the backward differences.
    pub c: [f64; 3],
    /// Mass and moment of inertia about the pivot of the displaced fluid, and its centroid from the pivot.
    pub fluid: (f64, f64, [f64; 2]),
    /// Velocities of x, y and the angle with which the drag was found.
    pub predicted: [f64; 3],
}

/// What a body on springs does in a step.
#[derive(Clone, Copy, Debug)]
pub struct Released {
    /// Displacement at the end.
    pub displacement: Pose,
    /// Accelerations of x, y and the angle.
    pub acceleration: [f64; 3],
    /// Change of the velocities from those predicted.
    pub change: [f64; 3],
    /// Rate of change of the momentum of the displaced fluid.
    pub unsteady: Force,
}

impl Release<'_> {
    /// Find the velocities.
    pub fn solve(&self, drag: &Drag) -> Released {
        let &Self { mount, carried: &Carried { now, before, acceleration }, c, fluid: (mass, inertia, arm), predicted } =
            self;
        let [v, v_before, x, x_before] = [now.rates(), before.rates(), now.places(), before.places()];
        let displaced =
            [[mass, 0.0, -mass * arm[1]], [0.0, mass, mass * arm[0]], [-mass * arm[1], mass * arm[0], inertia]];
        let own = [mount.mass, mount.mass, mount.inertia];
        let centripetal = arm.map(|arm| -mass * predicted[2] * predicted[2] * arm);
        let on_body = [drag.force.force[0] + centripetal[0], drag.force.force[1] + centripetal[1], drag.force.moment];

        let known = [0, 1, 2].map(|i| c[1] * v[i] + c[2] * v_before[i]);
        let (mut matrix, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
        for i in 0..3 {
            let Some(Support { stiffness, damping, rest }) = mount.supports[i] else {
                matrix[i][i] = 1.0;
                continue;
            };
            right[i] = on_body[i];
            for j in (0..3).filter(|&j| mount.supports[j].is_some()) {
                let net = if i == j { own[i] } else { 0.0 } - displaced[i][j];
                matrix[i][j] = c[0] * net + drag.impedance[i][j];
                right[i] += net * known[j] + drag.impedance[i][j] * predicted[j];
            }
            let virtual_mass = (LEAST_MASS * displaced[i][i] - matrix[i][i] / c[0]).max(0.0);
            matrix[i][i] += c[0] * virtual_mass + damping + stiffness / c[0];
            right[i] += virtual_mass * (known[i] + acceleration[i]);
            right[i] -= stiffness * ((c[1] * x[i] + c[2] * x_before[i]) / c[0] - rest);
        }
        let v = solve(matrix, right);
        let acceleration = [0, 1, 2].map(|i| c[0] * v[i] - known[i]);
        let to = [0, 1, 2].map(|i| (c[1] * x[i] + c[2] * x_before[i] + v[i]) / c[0]);
        let [fx, fy, moment] = displaced.map(|row| (0..3).map(|j| row[j] * acceleration[j]).sum::<f64>());
        Released {
            displacement: Pose::new(to, v),
            acceleration,
            change: [0, 1, 2].map(|i| v[i] - predicted[i]),
            unsteady: Force { force: [fx + centripetal[0], fy + centripetal[1]], moment },
        }
    }
}

/// Solve three equations by Gauss's elimination with pivoting.
fn solve(mut matrix: [[f64; 3]; 3], mut right: [f64; 3]) -> [f64; 3] {
    for k in 0..3 {
        let pivot = (k..3).max_by(|&i, &j| matrix[i][k].abs().total_cmp(&matrix[j][k].abs())).unwrap_or(k);
        matrix.swap(k, pivot);
        right.swap(k, pivot);
        for i in k + 1..3 {
            let (row, factor) = (matrix[k], matrix[i][k] / matrix[k][k]);
            matrix[i].iter_mut().zip(row).for_each(|(entry, above)| *entry -= factor * above);
            right[i] -= factor * right[k];
        }
    }
    let z = right[2] / matrix[2][2];
    let y = (right[1] - matrix[1][2] * z) / matrix[1][1];
    [(right[0] - matrix[0][1] * y - matrix[0][2] * z) / matrix[0][0], y, z]
}
