//! Equilibrium and stiffness.

use crate::Error;
use crate::banded::Banded;
use crate::model::RootSupport;
use crate::newton::{Balance, Problem, Statistics};
use crate::rod::Rod;
use crate::state::State;
use crate::step::HALVINGS;
use crate::vector::Vector;

impl<const D: usize> Rod<D> {
    /// Move to the equilibrium under the present loads, at rest, as before a first step; ignore the impedance.
    ///
    /// If Newton's method fails, the loads grow in parts, halved up to six times, from the loads that the present shape
    /// balances. A pressure jump keeps its direction in the present shape.
    ///
    /// # Errors
    /// Newton's method may fail, and a free or sliding rod has no equilibrium. After an error the state is unchanged.
    pub fn solve_static(&mut self) -> Result<(), Error> {
        if self.parameters.support == RootSupport::Free {
            let allowed = "another support: a free rod has no equilibrium";
            return Err(Error::value("support", "Free".to_string(), allowed));
        }
        if self.parameters.slide.is_some() {
            let allowed = "absent: a rod on a slide has no equilibrium";
            return Err(Error::value("slide", format!("{:?}", self.parameters.slide), allowed));
        }
        self.collect_loads()?;
        self.statistics = Statistics::default();
        self.balance.weight.fill(0.0);
        self.balance.elastic_weight = 1.0;
        if self.hinge.is_some() {
            // Without damping the spring is in series with half a segment.
            self.elastic = self.parameters.elastic(self.state.direction);
        }
        let pressure = self.state.pressure.clone();
        self.follow_pressure(1.0);
        let mut missing = self.force.clone();
        let balanced = self.elastic.gradient(&self.state.positions, &mut self.newton.moments, |k, gradient| {
            missing[k] -= gradient;
        });
        balanced.map_err(|shape| self.error(shape.into()))?;
        let mut settled = self.state.positions.clone();
        let whole = 1_u32 << HALVINGS;
        let (mut done, mut size) = (0, whole);
        while done < whole {
            let Self { newton, elastic, balance, force, guess, statistics, .. } = self;
            let left = f64::from(whole - done - size) / f64::from(whole);
            for ((load, force), missing) in balance.load.iter_mut().zip(&*force).zip(&missing) {
                *load = force - missing * left;
            }
            guess.copy_from_slice(&settled);
            let problem = Problem { elastic, balance, origin: &settled };
            match newton.solve(problem, guess, statistics) {
                Ok(()) => {
                    settled.copy_from_slice(guess);
                    statistics.substeps += 1;
                    done += size;
                    size = (2 * size).min(whole - done);
                }
                Err(_) if size > 1 => size = (size / 2).max(1),
                Err(failure) => {
                    self.state.pressure = pressure;
                    self.align_elastic();
                    return Err(self.error(failure));
                }
            }
        }
        let base = self.state.base();
        let pressure = std::mem::take(&mut self.state.pressure);
        self.state = State { pressure, ..State::at_rest(settled, base.direction, self.state.hinge) };
        self.state.set_base(&base);
        self.settle_hinge()?;
        self.publish();
        Ok(())
    }

    /// Return the stiffness ∂²U/∂x∂x of the present shape, N/m: the components of the first free node first.
    ///
    /// With shear, the unknown moment at the beginning of each segment precedes the components of its end node.
    pub fn stiffness(&mut self) -> Result<Banded, Error> {
        let nodes = self.rest.len();
        let balance = Balance { weight: vec![0.0; nodes], load: vec![Vector::zeros(); nodes], elastic_weight: 1.0 };
        let Self { newton, elastic, state, .. } = self;
        let problem = Problem { elastic, balance: &balance, origin: &state.positions };
        newton.assemble(problem, &state.positions).map_err(|shape| self.error(shape.into()))?;
        Ok(self.newton.matrix.clone())
    }
}
