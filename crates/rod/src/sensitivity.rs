//! How the end of the last step answers to a change of its loads.

use scene::RodScheme;

use crate::Error;
use crate::banded::Singular;
use crate::elastic::Vector;
use crate::newton::Problem;
use crate::parameters::Loads;
use crate::rod::{Rod, pressure_area};
use crate::scheme::{LastStage, StepRule, TRAPEZOID_PART};
use crate::state::State;

/// Changes of the nodes, component after component: `[D, n + 1]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivity {
    /// Of the positions, m.
    pub positions: Vec<f64>,
    /// Of the velocities, m/s.
    pub velocities: Vec<f64>,
    /// Of the accelerations, m/s².
    pub accelerations: Vec<f64>,
}

impl<const D: usize> Rod<D> {
    /// Derivative of the state at the end of the last step in the direction of a `change` of the loads of that step: the
    /// implicit function theorem with the exact Hessian at the solution. Arrays that are empty in `change` do not change.
    ///
    /// Refuses a change of the wrong size, a damped torsion spring at the root, and to answer where the last step was not taken in one piece or where there
    /// was none since the rod was made, placed or restored.
    pub fn sensitivity(&mut self, change: &Loads) -> Result<Sensitivity, Error> {
        let nodes = self.tributary.len();
        change.check_numbers::<D>(nodes)?;
        if self.hinge.is_some_and(|hinge| hinge.damping > 0.0) {
            let allowed = "without damping: sensitivities know of no history but that of the nodes";
            return Err(Error::value("hold", format!("{:?}", self.parameters.hold), allowed));
        }
        let Some(LastStage { rule, previous_direction }) = self.last else {
            return Err(Error::NoSensitivity { substeps: self.statistics().substeps });
        };
        let mut force = vec![Vector::<D>::zeros(); nodes];
        for (k, force) in force.iter_mut().enumerate() {
            for (d, component) in force.iter_mut().enumerate() {
                *component = change.force.get(d * nodes + k).copied().unwrap_or(0.0);
            }
            if let Some(jump) = change.pressure_jump.get(k) {
                *force += pressure_area(&self.before.positions, k) * *jump;
            }
        }
        let mut changed = State::at_rest(vec![Vector::zeros(); nodes], Vector::zeros(), None);
        let end = self.state.clone();
        if self.parameters.scheme == RodScheme::TrBdf2 {
            let first = StepRule::trapezoid(end.last_step * TRAPEZOID_PART / (1.0 - TRAPEZOID_PART));
            let share: Vec<_> = force.iter().map(|force| force * TRAPEZOID_PART).collect();
            let middle = (&end.previous_positions[..], &end.previous_velocities[..]);
            self.elastic.direction = previous_direction;
            let result = self.propagate(&first, middle, &share, &change.impedance, &mut changed);
            self.elastic.direction = end.direction;
            result?;
        }
        self.propagate(&rule, (&end.positions, &end.velocities), &force, &change.impedance, &mut changed)?;
        let by_component = |vectors: &[Vector<D>]| (0..D).flat_map(|d| vectors.iter().map(move |v| v[d])).collect();
        Ok(Sensitivity {
            positions: by_component(&changed.positions),
            velocities: by_component(&changed.velocities),
            accelerations: by_component(&changed.accelerations),
        })
    }

    /// Take the change of the state through a stage by `rule` that ended at these positions and velocities.
    fn propagate(
        &mut self,
        rule: &StepRule,
        (positions, velocities): (&[Vector<D>], &[Vector<D>]),
        force: &[Vector<D>],
        impedance: &[f64],
        changed: &mut State<D>,
    ) -> Result<(), Error> {
        let StepRule { c_v, c_a, new_mass, old_mass, new_force, old_force, .. } = *rule;
        let nodes = positions.len();
        let first = self.elastic.first;
        let mut update = vec![0.0; (nodes - first) * D];
        for (k, update) in (first..nodes).zip(update.chunks_exact_mut(D)) {
            let (v_star, a_star) = rule.at_no_displacement(changed, k);
            let (m, weight) = (self.mass(k), self.balance.weight[k]);
            // What the step's damping and impedance were: the loads may be the next ones by now.
            let drag = (weight - new_mass * m * c_a) / (new_force * c_v);
            let by_impedance = impedance.get(k).copied().unwrap_or(0.0);
            let slip = velocities[k] - self.before.velocities[k];
            let load = (force[k] - v_star * drag - slip * by_impedance) * new_force + changed.net_forces[k] * old_force
                - (a_star * new_mass + changed.accelerations[k] * old_mass) * m;
            update.copy_from_slice((changed.positions[k] * weight + load).as_slice());
        }
        let Self { newton, elastic, balance, .. } = self;
        let problem = Problem { elastic, balance, origin: positions };
        if let Err(shape) = newton.assemble(problem, positions) {
            return Err(self.error(shape.into()));
        }
        newton.factorise().map_err(|Singular| Error::NoSensitivity { substeps: 1 })?;
        newton.solve_factorised(&mut update);
        for (k, update) in (first..nodes).zip(update.chunks_exact(D)) {
            let (v_star, a_star) = rule.at_no_displacement(changed, k);
            let new = Vector::from_column_slice(update);
            let u = new - changed.positions[k];
            changed.previous_positions[k] = changed.positions[k];
            changed.previous_velocities[k] = changed.velocities[k];
            changed.positions[k] = new;
            changed.velocities[k] = u * c_v + v_star;
            changed.accelerations[k] = u * c_a + a_star;
        }
        Ok(())
    }
}
