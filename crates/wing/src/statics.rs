//! Equilibrium.

use structure::{Structure, find_equilibrium};

use crate::{Error, Memory, Wing, WingState};

impl Wing {
    /// Move to the equilibrium under the present loads, at rest, as before a first step; ignore the impedance.
    ///
    /// If Newton's method fails, the loads grow in parts ([`structure::find_equilibrium`]).
    ///
    /// # Errors
    /// Newton's method may fail, and a free wing has no equilibrium. After an error the state is unchanged.
    pub fn solve_static(&mut self) -> Result<(), Error> {
        if self.parameters.root.nodes.is_empty() {
            return Err(Error::value("root.nodes", "empty", "at least one node: a free wing has no equilibrium"));
        }
        self.forget();
        self.collect_loads()?;
        let settled = find_equilibrium(self);
        let twists = self.elastic.twists.at_rest();
        self.align();
        let base = self.core.state.own.base.stopped();
        self.core.state = WingState::at_rest(settled?, Memory { base, twists });
        self.align();
        self.core.publish();
        Ok(())
    }
}
