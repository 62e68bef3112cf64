//! What a body carries at a hinge: its force on the body, with the rate at which it falls with the body's velocities.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::force::Drag;
use crate::kinematics::{Freedoms, Kinematics};

/// Force and moment about a root along its freedoms, and the rate at which they fall with its velocities.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RootResponse {
    /// Force and moment on what holds the root, if that keeps its accelerations.
    pub reaction: Freedoms,
    /// Rate at which they fall with the velocities of the root.
    pub impedance: [Freedoms; 6],
}

impl RootResponse {
    /// Return the force along the freedoms of the root with velocities that differ by `change` from those announced.
    pub fn at(&self, change: &Freedoms) -> Freedoms {
        std::array::from_fn(|i| {
            self.reaction[i] - self.impedance[i].iter().zip(change).map(|(entry, v)| entry * v).sum::<f64>()
        })
    }
}

/// Return the velocities of a point at `arm` (m) of a body for those of its pivot.
pub fn rates_at(arm: &Vector3<f64>, rates: &Freedoms) -> Freedoms {
    let along = <[f64; 3]>::jacobian(1.0, (*arm).into());
    std::array::from_fn(|i| match along.get(i) {
        Some(row) => row.iter().zip(rates).map(|(entry, rate)| entry * rate).sum(),
        None => rates[i],
    })
}

/// Return force and moment about the pivot of a force and moment about a point at `arm` (m).
pub fn force_about(arm: &Vector3<f64>, of: &Freedoms) -> Freedoms {
    let moment = arm.cross(&Vector3::new(of[0], of[1], of[2]));
    [of[0], of[1], of[2], of[3] + moment.x, of[4] + moment.y, of[5] + moment.z]
}

impl Drag<3> {
    /// Add what acts at a root at `arm` (m) from the pivot.
    pub fn add_root(&mut self, response: &RootResponse, arm: &Vector3<f64>) {
        let force = force_about(arm, &response.reaction);
        self.force.force += Vector3::new(force[0], force[1], force[2]);
        self.force.moment += Vector3::new(force[3], force[4], force[5]);
        for j in 0..6 {
            let unit = std::array::from_fn(|i| f64::from(u8::from(i == j)));
            let of_root = rates_at(arm, &unit);
            let falls = RootResponse { reaction: [0.0; 6], ..*response }.at(&of_root);
            for (row, fall) in self.impedance.iter_mut().zip(force_about(arm, &falls)) {
                row[j] -= fall;
            }
        }
    }
}
