//! Where the time of a step goes. Without the feature `internals` nothing of it is compiled in.

/// Parts of a two-step step, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The moving bodies are painted where they are.
    Paint,
    /// Bodies with a wall target sample the flow.
    Sample,
    /// The local solve.
    Solve,
    /// The velocities of bodies and zones are added.
    Velocities,
    /// Two transforms along y.
    Forward,
    /// Five transforms along x, and the projection.
    Rows,
    /// Three transforms back along y, and the CFL number.
    Back,
    /// The forces on the bodies are summed up.
    Forces,
    /// The loads on the stations for the coming step.
    Loads,
}

/// Times the phases, by a clock that the measurement brings along.
#[derive(Default)]
pub struct Clock {
    /// Gives the time, s; absent where nothing is measured.
    #[cfg(feature = "internals")]
    pub now: Option<fn() -> f64>,
    /// Time at the last mark, s.
    #[cfg(feature = "internals")]
    last: f64,
    /// Time spent in each phase, s, in their order.
    #[cfg(feature = "internals")]
    pub spent: [f64; Phase::Loads as usize + 1],
}

#[cfg(feature = "internals")]
impl Clock {
    /// Begin with the first phase.
    pub fn start(&mut self) {
        if let Some(now) = self.now {
            self.last = now();
        }
    }

    /// A phase has ended.
    pub fn mark(&mut self, phase: Phase) {
        if let Some(now) = self.now {
            let time = now();
            self.spent[phase as usize] += time - self.last;
            self.last = time;
        }
    }
}

#[cfg(not(feature = "internals"))]
impl Clock {
    /// Begin with the first phase.
    #[inline(always)]
    pub fn start(&mut self) {}

    /// A phase has ended.
    #[inline(always)]
    pub fn mark(&mut self, _: Phase) {}
}
