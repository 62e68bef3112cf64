//! Times of the phases of a step. Without the feature `internals` nothing is compiled in.

/// Phases of a step of backward differences, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Moving bodies are painted.
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

/// Times the phases with the clock of a benchmark.
#[derive(Default)]
pub struct PhaseTimer {
    /// Clock, s; absent: nothing is measured.
    #[cfg(feature = "internals")]
    pub now: Option<fn() -> f64>,
    /// Time at the last mark, s.
    #[cfg(feature = "internals")]
    last: f64,
    /// Time spent in each phase, s.
    #[cfg(feature = "internals")]
    pub spent: [f64; Phase::Loads as usize + 1],
}

#[cfg(feature = "internals")]
impl PhaseTimer {
    /// Start the first phase.
    pub fn start(&mut self) {
        if let Some(now) = self.now {
            self.last = now();
        }
    }

    /// End a phase and start the next.
    pub fn mark(&mut self, phase: Phase) {
        if let Some(now) = self.now {
            let time = now();
            self.spent[phase as usize] += time - self.last;
            self.last = time;
        }
    }
}

#[cfg(not(feature = "internals"))]
impl PhaseTimer {
    /// Start the first phase.
    #[inline(always)]
    pub fn start(&mut self) {}

    /// End a phase and start the next.
    #[inline(always)]
    pub fn mark(&mut self, _: Phase) {}
}
