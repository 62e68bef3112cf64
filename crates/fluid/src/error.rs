//! Errors of the fluid.

/// Why the fluid refused an input or could not continue.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A parameter with which no step can be made.
    #[error("the {name} is {value:.3e}, but it must be {allowed}")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Value.
        value: f64,
        /// Allowed values, as the end of the sentence "but it must be …".
        allowed: &'static str,
    },
    /// A fine box that cannot be.
    #[error("the fine box {0}")]
    FineBox(String),
    /// A middle box with which no step can be made.
    #[error("the middle box {0}")]
    MiddleBox(String),
    /// A body in the rim of the fine box.
    #[error(
        "a body drags the fluid at {place:.4?} m at t = {time:.6e} s, in the rim of the fine box: it must stay {rim} \
         coarse cells from its ends"
    )]
    Rim {
        /// Time, s.
        time: f64,
        /// A point that the body drags, m.
        place: Vec<f64>,
        /// Width of the rim, coarse cells.
        rim: f64,
    },
    /// A body on springs in a fluid with the explicit scheme.
    #[error("a body on springs needs the scheme sbdf2: the explicit drag of rk2 does not hold it")]
    MountScheme,
    /// A line in a fluid with the explicit scheme.
    #[error("a line needs the scheme sbdf2")]
    LineScheme,
    /// A body on springs that is no circle and lighter than the fluid it displaces.
    #[error(
        "the {name} of a body on springs is {value:.6e}, but that of the fluid it displaces is {displaced:.6e}, and \
         only a circle may be lighter"
    )]
    LightBody {
        /// Mass or moment of inertia.
        name: &'static str,
        /// Its value, kg/m or kg m.
        value: f64,
        /// That of the displaced fluid.
        displaced: f64,
    },
    /// A place of a body, set from outside, that is not finite or far outside the domain.
    #[error(
        "{body} is moved by {displacement} m and {angle} rad with {velocity} m/s and {omega} rad/s, but all must be \
         finite, and its place no farther from the middle of the box than one and a half times the box"
    )]
    Displacement {
        /// Name of the body, e.g. `body 2`.
        body: String,
        /// Displacement, m.
        displacement: String,
        /// Angle, rad.
        angle: String,
        /// Velocity, m/s.
        velocity: String,
        /// Rate of the angle, rad/s.
        omega: String,
    },
    /// The scene has no fluid.
    #[error("the scene `{0}` has no fluid")]
    NoFluid(String),
    /// The fluid of the scene has another number of dimensions.
    #[error("the fluid of the scene `{scene}` has {dimensions} dimensions")]
    Dimension {
        /// Name of the scene.
        scene: String,
        /// Its dimensions.
        dimensions: usize,
    },
    /// A state of a fluid with other parameters, or with numbers that are not finite.
    #[error("{0} of the state is not of the size that it has in this scene, or not finite")]
    State(&'static str),
    /// A state of a fluid in the other precision.
    #[error("the state is in {state} precision, but the scene asks for {own} (`fluid.precision`)")]
    Precision {
        /// Precision of the state.
        state: &'static str,
        /// Precision of the fluid.
        own: &'static str,
    },
    /// A step that is not a positive number.
    #[error("the step from t = {time:.6e} s is {step:.3e} s, but it must be a finite number above 0")]
    Step {
        /// Beginning of the step, s.
        time: f64,
        /// Length of the step, s.
        step: f64,
    },
    /// A communication step that would take too many steps.
    #[error(
        "the step from t = {time:.6e} s is {step:.3e} s, but it may be no longer than {longest:.3e} s: 1000 \
         communication steps of the scene, or 1e5 of `max_step`"
    )]
    Long {
        /// Beginning of the step, s.
        time: f64,
        /// Length of the step, s.
        step: f64,
        /// Longest step, s.
        longest: f64,
    },
    /// A station or node that is not finite or far outside the domain.
    #[error(
        "{place} is at {position} m with velocity {velocity} m/s, but it must be finite and within one box length of \
         the box"
    )]
    Station {
        /// Name of the station, e.g. `station 3 of the beam`, `node 2 of the wing`.
        place: String,
        /// Position, m.
        position: String,
        /// Velocity, m/s.
        velocity: String,
    },
    /// Two neighbouring stations of a beam at one point.
    #[error(
        "stations {station} and {} of {beam} coincide at {position} m, where no segment can be; a master has to give \
         their places before the first step: the start values are those at rest", station + 1
    )]
    Coincide {
        /// Name of the beam: `the beam`, or `beam 2` of several.
        beam: String,
        /// Number of the first one, from 1.
        station: usize,
        /// Position, m.
        position: String,
    },
    /// A beam that is folded back on itself at a station.
    #[error(
        "{beam} is folded back on itself at station {station}, {position} m: two neighbouring segments must not point \
         against each other"
    )]
    Folded {
        /// Name of the beam: `the beam`, or `beam 2` of several.
        beam: String,
        /// Number of the station, from 1.
        station: usize,
        /// Position, m.
        position: String,
    },
    /// A station or node that is too fast for any reasonable step.
    #[error(
        "{place} has the velocity {velocity} m/s, for which `max_cfl` asks for steps of {needed:.3e} s, but they may \
         be no shorter than {shortest:.3e} s, a hundredth of the usual step: the smaller of `max_step` and the scene's \
         communication step"
    )]
    FastStation {
        /// Name of the station.
        place: String,
        /// Velocity, m/s.
        velocity: String,
        /// Step that its velocity requires, s.
        needed: f64,
        /// Shortest step, s.
        shortest: f64,
    },
    /// An explicit drag too stiff for any reasonable step.
    #[error(
        "C_eta = {c_eta:.3e} s is too small for the scheme rk2: its steps may not be longer, which makes \
         {substeps:.3e} of them in the communication step of {step:.3e} s from t = {time:.6e} s, but it may have \
         {most:.0}; use sbdf2, a larger C_eta or a smaller communication step"
    )]
    Stiff {
        /// Beginning of the step, s.
        time: f64,
        /// Length of the step, s.
        step: f64,
        /// Shortest relaxation time in the domain, s.
        c_eta: f64,
        /// Number of steps of the fluid that it would take.
        substeps: f64,
        /// Largest number of steps.
        most: f64,
    },
    /// The flow became too fast for any reasonable step, or not a number.
    #[error(
        "the flow diverged at t = {time:.6e} s: `max_cfl` asks for steps of {needed:.3e} s, but they may be no \
         shorter than {shortest:.3e} s, a hundredth of the usual step; try a smaller `max_step`, communication step or \
         `max_cfl`"
    )]
    Diverged {
        /// Time reached, s.
        time: f64,
        /// Step that the flow requires, s; 0 or NaN if the flow is not finite.
        needed: f64,
        /// Shortest step, s.
        shortest: f64,
    },
    /// Contact of rigid bodies fails.
    #[error(transparent)]
    Contact(#[from] contact::BodyError),
    /// Several steps of the fluid under loads that were announced for one.
    #[error(
        "the communication step is {step:.3e} s at t = {time:.6e} s, but the announced loads hold for one step of the \
         fluid, which is at most {longest:.3e} s by `max_step` and `max_cfl`: make the communication step no longer \
         than the output `longest_step`"
    )]
    Divided {
        /// Time, s.
        time: f64,
        /// Length of the communication step, s.
        step: f64,
        /// Longest step of the fluid, s.
        longest: f64,
    },
    /// No solution for the drag of thin bodies.
    #[error(
        "the drag of the thin bodies at t = {time:.6e} s was not found: the flow is not finite, or lines lie on each \
         other"
    )]
    Markers {
        /// End of the step, s.
        time: f64,
    },
    /// The loads on a beam are not finite numbers.
    #[error("the loads on the beam at t = {time:.6e} s are not finite")]
    Loads {
        /// Time reached, s.
        time: f64,
    },
    /// No memory for the copy of the state that a communication step of several steps needs.
    #[error("{bytes} bytes for a copy of the state are more than the system gives")]
    Memory {
        /// Size of the copy.
        bytes: usize,
    },
}
