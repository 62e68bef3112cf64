//! What a structure on a moving root announces before its step: its force on the root, and the root's impedance.
//!
//! Elastic forces do not change in a rigid motion. So with A = c M + D + K/c, the matrix of a stage for velocities, and
//! rigid velocities J of all nodes, those of the root held (b), the free nodes (f) deviate by w from J, and
//!
//! ```text
//! A_ff w = −[(c M + D) J]_f,      Z = Jᵀ (c M + D) (J + w)
//! ```
//!
//! is the Schur complement of A on the root, without the entries of A between root and free nodes.

use std::array::from_fn;

use rigid::{Freedoms, Kinematics, RootResponse};

use crate::{Error, Structure, Vector, step};

/// A structure in space that another one may carry.
pub trait Mounted: Structure<3> {
    /// Return the point of the root about which moments are taken, m.
    fn centre(&self) -> Vector<3>;

    /// Factorise the matrix of the last stage in the present shape.
    fn factorise(&mut self) -> Result<(), Error<Self::Failure>>;

    /// Write w M times `guess` to `product`; 0 with lumped masses, which the diagonal holds.
    fn multiply_mass(&mut self);

    /// Replace `product`, N, at the free nodes by the displacements under these forces, m.
    fn displace(&mut self);

    /// Keep of a trial, in whose end the structure is factorised, what its step may start from; by default nothing.
    fn keep_trial(&mut self) {
        self.forget();
    }
}

/// Return what the root bears in a step of `duration`, s, under the present loads and motion of the base; the structure
/// stays as it is.
///
/// # Errors
/// As [`step`].
pub fn root_response<S: Mounted>(structure: &mut S, duration: f64) -> Result<RootResponse, Error<S::Failure>> {
    let statistics = structure.core().statistics;
    step(structure, duration)?;
    let response = response(structure);
    match response {
        Ok(_) => structure.keep_trial(),
        Err(_) => structure.forget(),
    }
    let core = structure.core_mut();
    core.state.copy_from(&core.before);
    core.statistics = statistics;
    core.publish();
    structure.align();
    response
}

fn response<S: Mounted>(structure: &mut S) -> Result<RootResponse, Error<S::Failure>> {
    let drive = structure.core().state.drive;
    let mut impedance = [[0.0; 6]; 6];
    structure.factorise()?;
    let (centre, rate) = (structure.centre(), structure.core().balance.rate);
    for j in 0..6 {
        let core = structure.core_mut();
        for (velocity, x) in core.guess.iter_mut().zip(&core.state.positions) {
            *velocity = Vector::from_fn(|d, _| jacobian(x - centre)[d][j]);
        }
        inertia(structure);
        structure.displace();
        let core = structure.core_mut();
        for k in (0..core.held.len()).filter(|&k| !core.held[k]) {
            core.guess[k] -= core.product[k] * rate;
        }
        inertia(structure);
        let core = structure.core();
        for (force, x) in core.product.iter().zip(&core.state.positions) {
            for (along, part) in jacobian(x - centre).iter().zip(force) {
                for (row, to) in impedance.iter_mut().zip(along) {
                    row[j] += to * part;
                }
            }
        }
    }
    let reaction = from_fn(|i| if i < 3 { -drive.force[i] } else { -drive.moment[i - 3] });
    Ok(RootResponse { reaction, impedance })
}

/// Return the velocity of a node at `arm` with the freedoms of the root.
fn jacobian(arm: Vector<3>) -> [Freedoms; 3] {
    <[f64; 3]>::jacobian(1.0, arm.into())
}

/// Write (c M + D) times the velocities in `guess` to `product`.
fn inertia<S: Mounted>(structure: &mut S) {
    structure.multiply_mass();
    let core = structure.core_mut();
    for (k, (product, velocity)) in core.product.iter_mut().zip(&core.guess).enumerate() {
        *product = (*product + core.balance.d_times(k, velocity)) / core.balance.rate;
    }
}
