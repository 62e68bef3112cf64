//! Equilibrium.

use crate::{Error, Statistics, Structure, Vector};

/// Return the shape that balances the loads without impedance, m: `[nodes]`.
///
/// If the solver fails, the loads grow in parts, halved again and again, from the loads that the present shape
/// balances.
///
/// # Errors
/// The solver may fail.
pub fn find_equilibrium<const D: usize, S: Structure<D>>(
    structure: &mut S,
) -> Result<Vec<Vector<D>>, Error<S::Failure>> {
    let core = structure.core_mut();
    core.statistics = Statistics::default();
    core.balance.diagonal.fill(0.0);
    core.balance.across.fill(Vector::zeros());
    core.balance.velocity.fill(Vector::zeros());
    (core.balance.mass, core.balance.elastic, core.balance.rate) = (0.0, 1.0, 0.0);
    structure.find_elastic_forces()?;
    let core = structure.core();
    let missing: Vec<_> = core.force.iter().zip(&core.product).map(|(force, elastic)| force - elastic).collect();
    let mut settled = core.state.positions.clone();
    let whole = 1_u32 << S::HALVINGS;
    let (mut done, mut size) = (0, whole);
    while done < whole {
        let left = f64::from(whole - done - size) / f64::from(whole);
        let core = structure.core_mut();
        for ((load, force), missing) in core.balance.load.iter_mut().zip(&core.force).zip(&missing) {
            *load = force - missing * left;
        }
        core.guess.copy_from_slice(&settled);
        structure.forget();
        let result = structure.solve(&settled);
        let core = structure.core_mut();
        match result {
            Ok(()) => {
                settled.copy_from_slice(&core.guess);
                core.statistics.substeps += 1;
                done += size;
                size = (S::LOAD_GROWTH * size).min(whole - done);
            }
            Err(_) if size > 1 => {
                core.statistics.halvings += 1;
                size /= 2;
            }
            Err(failure) => return Err(failure),
        }
    }
    Ok(settled)
}
