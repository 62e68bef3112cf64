//! Steps in time: sub-steps, their halving and their stages.

use crate::{Core, Drive, Error, Exchange, Scheme, Statistics, StepRule, TRAPEZOID_PART, Vector};

/// Maximum number of sub-steps of `max_step` in a step.
const MAX_STEPS: f64 = 1e4;

/// Part of a step towards the state of the base at the end of the step.
pub struct Span<'a, B> {
    /// Begin, as a fraction of the step.
    pub from: f64,
    /// End, as a fraction of the step.
    pub to: f64,
    /// Length, s.
    pub dt: f64,
    /// Length of the whole step, s.
    pub duration: f64,
    /// Number of halvings that led to this part.
    pub halvings: u32,
    /// Base at the end of the whole step.
    pub base: &'a B,
}

impl<B> Span<'_, B> {
    /// Return the first `part` and the rest.
    fn split(&self, part: f64) -> (Self, Self) {
        let middle = self.from + part * (self.to - self.from);
        (Self { to: middle, dt: part * self.dt, ..*self }, Self { from: middle, dt: (1.0 - part) * self.dt, ..*self })
    }
}

/// Force, N, moment, N m, and power, W, of the drive on a structure.
pub type Reaction<const D: usize> = (Vector<D>, [f64; 3], f64);

/// What a kind of structure adds: elastic forces, masses, supports and a solver.
///
/// Methods fail for numbers outside their ranges, for shapes without elastic forces, and if the solver does.
pub trait Structure<const D: usize> {
    /// Memory of this kind alone.
    type Own: Clone;
    /// Errors of this kind alone.
    type Failure;
    /// State of the base.
    type Base;

    /// Maximum number of halvings of a failed sub-step or of a failed increase of the loads.
    const HALVINGS: u32;
    /// Factor of the next increase of the loads after one that succeeds.
    const LOAD_GROWTH: u32;

    /// Return state and scratch.
    fn core(&self) -> &Core<D, Self::Own>;

    /// Return state and scratch.
    fn core_mut(&mut self) -> &mut Core<D, Self::Own>;

    /// Return the base at the end of the next step.
    fn next_base(&self) -> Result<Self::Base, Error<Self::Failure>>;

    /// Check the loads and write `force` and `impedance`.
    fn collect_loads(&mut self) -> Result<(), Error<Self::Failure>>;

    /// Return the load on node `k` at the end of a step without gravity and impedance, N.
    fn load(&self, k: usize) -> Vector<D>;

    /// Prepare a step of `duration`, s, to `base`.
    fn prepare(&mut self, base: &Self::Base, duration: f64) -> Result<(), Error<Self::Failure>>;

    /// Set accelerations and net forces before the first step.
    fn start(&mut self) -> Result<(), Error<Self::Failure>>;

    /// Return a rule for the next sub-step of `dt`, s, in place of the scheme; most have none.
    fn rule(&mut self, _dt: f64) -> Result<Option<StepRule>, Error<Self::Failure>> {
        Ok(None)
    }

    /// Solve for one stage by `rule`; the loads lie at the fraction `load_part` between old and present loads.
    fn stage(&mut self, rule: &StepRule, load_part: f64, span: &Span<Self::Base>) -> Result<(), Error<Self::Failure>>;

    /// Refuse a sub-step that gains energy.
    fn guard(&mut self, span: &Span<Self::Base>) -> Result<(), Error<Self::Failure>>;

    /// Complete a step to `base` and return the reaction of a drive; `None` without a drive.
    fn complete(&mut self, base: &Self::Base) -> Result<Option<Reaction<D>>, Error<Self::Failure>>;

    /// Align the elastic forces with the memory of the state.
    fn align(&mut self);

    /// Forget factors of the solver: results must not depend on earlier steps.
    fn forget(&mut self) {}

    /// Write the elastic forces of the present shape at rest to `product`.
    fn find_elastic_forces(&mut self) -> Result<(), Error<Self::Failure>>;

    /// Solve the equation for `guess`, from the positions `origin`.
    fn solve(&mut self, origin: &[Vector<D>]) -> Result<(), Error<Self::Failure>>;
}

/// Advance `structure` by `duration`, s, under the present loads.
///
/// The structure takes equal sub-steps no longer than `max_step` and halves a failed sub-step. The loads are the loads
/// at the end of the step. Forces with an impedance refer to the velocity at the beginning of the step.
///
/// # Errors
/// A step may fail to converge, gain energy or fold the structure. After an error the state is the state before.
pub fn step<const D: usize, S: Structure<D>>(structure: &mut S, duration: f64) -> Result<(), Error<S::Failure>> {
    if !(duration.is_finite() && duration > 0.0) {
        return Err(Error::value("duration", duration, "a finite number of seconds above 0"));
    }
    // A duration that exceeds a multiple of `max_step` by rounding needs no extra sub-step.
    let steps = structure.core().max_step.map_or(1.0, |longest| (duration / longest - 1e-9).ceil().max(1.0));
    if steps > MAX_STEPS {
        return Err(Error::value("duration", duration, "at most 10000 times max_step"));
    }
    let base = structure.next_base()?;
    structure.collect_loads()?;
    let core = structure.core_mut();
    core.weigh_first();
    core.before.copy_from(&core.state);
    core.statistics = Statistics::default();
    let result = advance(structure, duration, steps as u64, &base);
    let core = structure.core_mut();
    if result.is_err() {
        core.state.copy_from(&core.before);
        structure.align();
    } else {
        core.publish();
    }
    result
}

/// Make the sub-steps of a step; a failure leaves the state undefined.
fn advance<const D: usize, S: Structure<D>>(
    structure: &mut S,
    duration: f64,
    steps: u64,
    base: &S::Base,
) -> Result<(), Error<S::Failure>> {
    structure.prepare(base, duration)?;
    if structure.core().state.last_step == 0.0 {
        let core = structure.core_mut();
        core.state.loads.copy_from_slice(&core.force);
        structure.start()?;
    }
    let whole = 1_u64 << S::HALVINGS;
    let total = steps * whole;
    let (mut size, mut remaining) = (whole, total);
    while remaining > 0 {
        let span = Span {
            from: (total - remaining) as f64 / total as f64,
            to: (total - remaining + size) as f64 / total as f64,
            dt: duration * (size as f64 / total as f64),
            duration,
            halvings: S::HALVINGS - size.ilog2(),
            base,
        };
        let result = substep(structure, &span);
        let core = structure.core_mut();
        match result {
            Ok(()) => {
                core.statistics.substeps += 1;
                remaining -= size;
                if size < whole && remaining.is_multiple_of(2 * size) {
                    size *= 2;
                    structure.forget();
                }
            }
            Err(_) if size > 1 => {
                core.statistics.halvings += 1;
                core.state.copy_from(&core.before_substep);
                size /= 2;
                structure.align();
                structure.forget();
            }
            Err(failure) => return Err(failure),
        }
    }
    sum_up(structure, duration, base)
}

/// Make a sub-step by the time scheme; a failure leaves the state undefined.
fn substep<const D: usize, S: Structure<D>>(structure: &mut S, span: &Span<S::Base>) -> Result<(), Error<S::Failure>> {
    let core = structure.core_mut();
    core.before_substep.copy_from(&core.state);
    let (scheme, last_step) = (core.scheme, core.state.last_step);
    match (structure.rule(span.dt)?, scheme) {
        (Some(rule), _) => structure.stage(&rule, 1.0, span)?,
        (None, Scheme::Trapezoid) => structure.stage(&StepRule::trapezoid(span.dt), 1.0, span)?,
        (None, Scheme::GeneralisedAlpha { rho_inf }) => {
            structure.stage(&StepRule::generalised_alpha(rho_inf, span.dt), 1.0, span)?;
        }
        (None, Scheme::Bdf2) => structure.stage(&StepRule::bdf2(span.dt, last_step), 1.0, span)?,
        (None, Scheme::TrBdf2) => {
            let (first, second) = span.split(TRAPEZOID_PART);
            structure.stage(&StepRule::trapezoid(first.dt), TRAPEZOID_PART, &first)?;
            structure.stage(&StepRule::bdf2(second.dt, first.dt), 1.0, &second)?;
        }
    }
    let core = structure.core_mut();
    core.state.loads.copy_from_slice(&core.force);
    structure.guard(span)
}

/// Record force, power and work of loads and drive in the step of `duration`, s, just made.
fn sum_up<const D: usize, S: Structure<D>>(
    structure: &mut S,
    duration: f64,
    base: &S::Base,
) -> Result<(), Error<S::Failure>> {
    let reaction = structure.complete(base)?;
    let core = structure.core();
    let (mut force, mut power) = (Vector::zeros(), 0.0);
    for (k, v) in core.state.velocities.iter().enumerate() {
        let load = structure.load(k) - core.resistance(k, v);
        force += load;
        power += load.dot(v);
    }
    let state = &mut structure.core_mut().state;
    state.exchange = Exchange { force, power, work: state.exchange.work + power * duration };
    if let Some((force, moment, power)) = reaction {
        state.drive = Drive { force, moment, power, work: state.drive.work + power * duration };
    }
    state.check_exchange()
}
