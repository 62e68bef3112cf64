//! Equilibrium.

use crate::geometry::Vector;
use crate::newton::Statistics;
use crate::state::State;
use crate::step::HALVINGS;
use crate::{Error, Wing};

impl Wing {
    /// Move to the equilibrium under the present loads, at rest, as before a first step; ignore the impedance.
    ///
    /// If Newton's method fails, the loads grow in parts, halved up to twelve times, from the loads that the present
    /// shape balances.
    ///
    /// # Errors
    /// Newton's method may fail, and a free wing has no equilibrium. After an error the state is unchanged.
    pub fn solve_static(&mut self) -> Result<(), Error> {
        if self.parameters.root.nodes.is_empty() {
            return Err(Error::value("root.nodes", "empty", "at least one node: a free wing has no equilibrium"));
        }
        self.collect_loads()?;
        self.statistics = Statistics::default();
        let problem = &mut self.problem;
        problem.own.fill(0.0);
        problem.velocity.fill(Vector::zeros());
        (problem.mass, problem.elastic, problem.rate) = (0.0, 1.0, 0.0);
        self.elastic.omega = Vector::zeros();
        let mut missing = self.force.clone();
        self.guess.fill(Vector::zeros());
        self.elastic.gradient(&self.state.positions, &self.guess, &mut self.product)?;
        missing.iter_mut().zip(&self.product).for_each(|(missing, elastic)| *missing -= elastic);
        let mut settled = self.state.positions.clone();
        let whole = 1_u32 << HALVINGS;
        let (mut done, mut size) = (0, whole);
        while done < whole {
            let Self { newton, elastic, problem, force, guess, statistics, .. } = self;
            let left = f64::from(whole - done - size) / f64::from(whole);
            for ((load, force), missing) in problem.load.iter_mut().zip(&*force).zip(&missing) {
                *load = force - missing * left;
            }
            guess.copy_from_slice(&settled);
            newton.forget();
            match newton.solve(elastic, problem, &settled, guess, statistics) {
                Ok(()) => {
                    done += size;
                    settled.copy_from_slice(guess);
                    size = size.min(whole - done);
                }
                Err(_) if size > 1 => {
                    statistics.halvings += 1;
                    size /= 2;
                }
                Err(failure) => {
                    self.align_support();
                    return Err(self.error(failure));
                }
            }
        }
        let still = crate::Pose { velocity: [0.0; 3], angular_velocity: [0.0; 3], ..self.state.pose };
        self.state = State::at_rest(settled, still);
        self.align_support();
        self.publish();
        Ok(())
    }
}
