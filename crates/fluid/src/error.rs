//! What the fluid refuses, and why it could not go on.

/// Why the fluid refused or could not go on.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The scene has no fluid.
    #[error("the scene `{0}` has no fluid")]
    NoFluid(String),
    /// A state of another scene, or no state at all.
    #[error("{0} of the state is not of the size that it has in this scene, or not finite")]
    State(&'static str),
    /// A step that is no positive number.
    #[error("the step from t = {time} s is {step} s, but it must be a finite number above 0")]
    Step {
        /// Beginning of the step, s.
        time: f64,
        /// Length of the step, s.
        step: f64,
    },
    /// A station of the beam that is no number or far outside the box.
    #[error(
        "station {station} of the beam is at ({x}, {y}) m with velocity ({vx}, {vy}) m/s, but it must be finite and \
         within one box length of the box"
    )]
    Station {
        /// Number of the station, from 1.
        station: usize,
        /// Position, m.
        x: f64,
        /// Position, m.
        y: f64,
        /// Velocity, m/s.
        vx: f64,
        /// Velocity, m/s.
        vy: f64,
    },
    /// An explicit drag too stiff for any reasonable step.
    #[error(
        "C_eta = {c_eta:.3e} s is too small for the scheme rk2: its steps may not be longer, which makes {substeps:.0} \
         of them in the communication step of {step} s from t = {time} s; use sbdf2, a larger C_eta or a smaller \
         communication step"
    )]
    Stiff {
        /// Beginning of the step, s.
        time: f64,
        /// Length of the step, s.
        step: f64,
        /// Shortest relaxation time in the box, s.
        c_eta: f64,
        /// Steps of the fluid's own that it would take.
        substeps: f64,
    },
    /// The flow became too fast for any reasonable step, or not a number.
    #[error("the flow diverged at t = {time} s: CFL number {cfl} at a step of {step} s; try a smaller step or max_cfl")]
    Diverged {
        /// Time reached, s.
        time: f64,
        /// CFL number there.
        cfl: f64,
        /// Step, s.
        step: f64,
    },
}
