//! A fluid with its bodies and beams: the communication step.

use std::f64::consts::PI;

use contact::{BodyLaw, FlexibleBody, FlexibleContact, Loads, MountedBody, Stations};
use line_fft::ThreadTeam;

use crate::bodies::{Bodies, DisplacementHistory, Placement, Pose, Rigid, place};
use crate::error::Error;
use crate::field::is_available;
use crate::force::Exchange;
use crate::grid::Grid;
use crate::gust::Gust;
use crate::limits::{Contour, StepLimits};
use crate::outlet::Outlet;
use crate::parameters::{Extent, Flexible, Parameters};
use crate::present::{ContactOwed, Interfaces, Present};
use crate::pressures::{Cached, Pressures};
use crate::probe::Probe;
use crate::problem::Problem;
use crate::solver::{FluidSolver, Solvable};
use crate::state::State;
use crate::step::Substep;
use crate::thin::pay;
use crate::timer::Phase;

/// Memory that does not depend on the precision, bytes for each cell: the penalization rate of solids, rounded up.
const BYTES_PER_CELL: usize = 44;

/// Memory of each beam with a mask for each cell, bytes: the number of a candidate.
const BYTES_PER_BEAM_AND_CELL: usize = 4;

/// Memory of a station with its loads in the fluid and in a state, and of a marker with its grid points, bytes.
const BYTES_PER_STATION: usize = 600;
const BYTES_PER_MARKER: usize = 4000;

/// A fluid with the bodies in it.
///
/// In single precision its fields and transforms are of `f32`. Everything that is set and read is of `f64` in both.
pub struct Fluid<const D: usize = 2>
where
    [f64; D]: Solvable<D>,
{
    pub(crate) problem: Problem<D>,
    /// Grid of the domain.
    pub(crate) grid: Grid<D>,
    pub(crate) present: Present<D>,
    pub(crate) solver: Box<dyn FluidSolver<D>>,
    pub(crate) density: f64,
    pub(crate) probes: Vec<Probe>,
    pub(crate) probe_places: Vec<[f64; D]>,
    /// Reference of the pressure around the beams; absent if that pressure is not wanted.
    pub(crate) outlet: Option<Outlet>,
    pub(crate) pressures: Cached<Pressures>,
    pub(crate) motion: Motion<D>,
    gust: Option<Gust>,
    contours: Vec<Contour>,
    /// Contact of flexible bodies and the body that another unit moves with all that moves; absent without.
    pub(crate) flexible_contact: Option<FlexibleContact<D>>,
    limits: StepLimits,
    bytes_per_number: usize,
    /// Number of cells, of all grids.
    cells: usize,
    /// The state before a communication step of several steps, for errors within it; made when first needed.
    undo: Option<State<D>>,
}

/// Stations of the flexible bodies and displacements of the bodies that laws do not move, in a communication step; every
/// list is empty without such a body.
pub(crate) struct Motion<const D: usize>
where
    [f64; D]: Solvable<D>,
{
    /// At the beginning of the step.
    from: Vec<Stations<D>>,
    /// At the end of a step of the fluid, or after the communication step with the velocities of its end.
    between: Vec<Stations<D>>,
    /// At the end of the step, set from outside.
    pub target: Vec<Stations<D>>,
    /// Displacements at the beginning of the step.
    displaced_from: Vec<Pose<D>>,
    /// Displacements at the end of a step of the fluid, and those that the master gives.
    displaced: Vec<Pose<D>>,
    displaced_at_end: Vec<Pose<D>>,
    /// Displacements at the end of the step, set from outside; of a body on springs unused.
    pub displaced_to: Vec<Pose<D>>,
}

/// Return the numbers of a state for each cell: velocity and vorticity at three times, and `w`.
const fn numbers_of_state<const D: usize>() -> usize {
    if D == 2 { 11 } else { 21 }
}

/// Return the numbers of a fluid for each cell: those of its state and of a copy, `w`, and the spectra.
const fn numbers_of_fluid<const D: usize>() -> usize {
    if D == 2 { 33 } else { 52 }
}

/// Return the contact of the flexible bodies and the body that another unit moves with each other and with the bodies on a
/// mount; none where nothing may touch.
fn contact_of<const D: usize>(parameters: &Parameters<D>) -> Option<FlexibleContact<D>>
where
    [f64; D]: Solvable<D>,
{
    let own = parameters.contact.as_ref()?;
    let flexible = flexible_of(parameters);
    let size = parameters.grid().size;
    let mounted = parameters.bodies.iter().enumerate().filter_map(|(number, body)| {
        let carrier = own.carrier.as_ref().filter(|_| body.announces);
        let inertia = body.mount().map(|mount| mount.least_inertia()).or(carrier.map(|own| own.inertia))?;
        Some(MountedBody {
            displaced: parameters.density * body.shape.moments(&size).volume,
            pivot: body.pivot.into(),
            law: carrier.map(|_| own.law),
            carries: carrier.map_or(vec![], |own| own.carries.clone()),
            ..MountedBody::new(number, body.shape.obstacle()?, inertia)
        })
    });
    let BodyLaw { range, damping, friction, .. } = own.law;
    let law =
        contact::Law { range, stiffness: own.flexible_stiffness, depth: f64::INFINITY, damping, friction, film: None };
    FlexibleContact::new(&flexible, mounted.collect(), &law, own.periods)
}

/// Return the flexible bodies with the skins by which they touch; empty without contact.
fn flexible_of<const D: usize>(parameters: &Parameters<D>) -> Vec<FlexibleBody<'_, D>>
where
    [f64; D]: Solvable<D>,
{
    let skins = parameters.contact.iter().flat_map(|own| &own.skins);
    let both = parameters.flexible.iter().zip(skins);
    both.map(|(body, skin)| FlexibleBody {
        nodes: &body.nodes,
        triangles: if let Extent::Surface(triangles) = &body.extent { Some(triangles) } else { None },
        skin: skin.as_ref(),
    })
    .collect()
}

/// Return a function that returns place and motion of the rigid body with a number, if nothing but its state tells them.
fn poses<'a, const D: usize>(
    bodies: &'a Bodies<D>,
    histories: &'a [DisplacementHistory<D>],
) -> impl Fn(usize) -> Option<(contact::Pose<D>, Pose<D>)> + 'a
where
    [f64; D]: Solvable<D>,
{
    move |number| {
        let ((_, rigid), history) = bodies.carried().zip(histories).find(|((k, _), _)| *k == number)?;
        let pose = rigid.pose_of(&history.now);
        Some((place(rigid.body(), &pose), pose))
    }
}

impl<const D: usize> Fluid<D>
where
    [f64; D]: Solvable<D>,
{
    /// A fluid at t = 0.
    ///
    /// # Errors
    /// [`Error::Parameter`] for parameters with which no step can be made.
    pub fn new(parameters: &Parameters<D>) -> Result<Self, Error> {
        parameters.check()?;
        let mut problem = Problem::new(&parameters.around_bodies());
        let stations: Vec<_> = parameters.flexible.iter().map(|body| Stations::at_rest(&body.nodes)).collect();
        problem.place(&Placement { time: 0.0, displacements: &[], stations: &stations, before: &stations });
        let at_start = |rigid: &Rigid<D>| DisplacementHistory::at(rigid.before_release(0.0).unwrap_or_default());
        let histories: Vec<_> = problem.bodies.carried().map(|(_, rigid)| at_start(rigid)).collect();
        let displaced = vec![Pose::default(); histories.len()];
        let velocity = parameters.initial_velocity.iter().zip(problem.grid.spacing);
        // Components of the shear stress of a body.
        let components = |extent: &Extent| match extent {
            Extent::Line { .. } if D == 2 => 1,
            Extent::Surface(_) => D,
            _ => 0,
        };
        let room = |body: &Flexible<D>, lists: usize| vec![vec![0.0; body.nodes.len()]; lists];
        let jump = |body: &Flexible<D>| room(body, components(&body.extent).min(1)).pop().unwrap_or_default();
        let shear = |body: &Flexible<D>| room(body, components(&body.extent));
        let flexible_contact = contact_of(parameters);
        let owed_by_contact = |contact: &FlexibleContact<D>| ContactOwed {
            step: parameters.communication_step,
            flexible: stations.iter().map(|own| Loads::none(own.len())).collect(),
            bodies: contact.pushes().map(|_| [0.0; 6]).collect(),
        };
        let nothing = ContactOwed { step: 0.0, flexible: vec![], bodies: vec![] };
        let present = Present {
            time: 0.0,
            step: 0.0,
            advection_rate: velocity.map(|(u, spacing)| u.abs() / spacing).sum(),
            bodies: problem.without_force(&stations),
            histories,
            gust: [0.0; D],
            flexible: Interfaces {
                stations: stations.clone(),
                loads: stations.iter().filter(|_| parameters.loads).map(|s| Loads::none(s.len())).collect(),
                exchange: vec![Exchange::default(); stations.len()],
                owed: vec![[0.0; 6]; if parameters.loads && problem.thin.has_surface() { stations.len() } else { 0 }],
                contact: flexible_contact.as_ref().map_or(nothing, owed_by_contact),
                jump: parameters.flexible.iter().map(jump).collect(),
                shear: parameters.flexible.iter().map(shear).collect(),
            },
        };
        let outlet = if parameters.pressure_around { Outlet::new(parameters, &problem.grid) } else { None };
        let mut fluid = Self {
            solver: <[f64; D]>::new_solver(parameters, &problem),
            grid: parameters.grid(),
            density: parameters.density,
            probes: Probe::all(parameters, &problem.grid),
            probe_places: parameters.probes.clone(),
            pressures: Cached::stale(Pressures::new(parameters.probes.len(), &stations, outlet.is_some())),
            outlet,
            gust: parameters.gust.clone(),
            motion: Motion {
                between: stations.clone(),
                target: stations.clone(),
                from: stations,
                displaced_from: displaced.clone(),
                displaced: displaced.clone(),
                displaced_at_end: displaced.clone(),
                displaced_to: displaced,
            },
            flexible_contact,
            contours: parameters.flexible.iter().map(Contour::from).collect(),
            limits: StepLimits::new(parameters.max_step, parameters.max_cfl, parameters.communication_step),
            bytes_per_number: parameters.precision.bytes(),
            cells: parameters.all_cells(),
            undo: None,
            present,
            problem,
        };
        if let Some(amplitude) = parameters.disturbance {
            fluid.disturb(parameters, amplitude);
        }
        Ok(fluid)
    }

    /// Start with a wave of each velocity along the next axis, m/s, which has no divergence and no mean.
    fn disturb(&mut self, Parameters { domain, initial_velocity, .. }: &Parameters<D>, amplitude: f64) {
        let wave = |at: f64, [low, high]: [f64; 2]| amplitude * (2.0 * PI * (at - low) / (high - low)).sin();
        self.set_velocity(|point| {
            std::array::from_fn(|axis| {
                let next = (axis + 1) % D;
                initial_velocity[axis] + wave(point[next], domain[next])
            })
        });
    }

    /// Return the approximate memory of a fluid, bytes.
    pub fn bytes(parameters: &Parameters<D>) -> usize {
        let cells = parameters.all_cells();
        let body = |stations: usize, extent: &Extent| {
            let has_mask = matches!(extent, Extent::Band { .. });
            BYTES_PER_STATION * stations + if has_mask { BYTES_PER_BEAM_AND_CELL * cells } else { 0 }
        };
        let flexible = parameters.flexible.iter().map(|of| body(of.nodes.len(), &of.extent)).sum::<usize>();
        let per_cell = numbers_of_fluid::<D>() * parameters.precision.bytes() + BYTES_PER_CELL;
        let contact = FlexibleContact::bytes(&flexible_of(parameters), parameters.bodies.len());
        per_cell * cells + flexible + contact + BYTES_PER_MARKER * parameters.markers()
    }

    /// Return the approximate memory of a state, bytes.
    pub fn state_bytes(&self) -> usize {
        let stations = self.motion.target.iter().map(Stations::len).sum::<usize>();
        numbers_of_state::<D>() * self.bytes_per_number * self.cells + BYTES_PER_STATION * stations
    }

    /// Start at another time than 0 (s): the bodies are in their places at that time.
    pub fn start_at(&mut self, time: f64) {
        for ((_, rigid), history) in self.problem.bodies.carried().zip(&mut self.present.histories) {
            if let Some(displacement) = rigid.before_release(time) {
                *history = DisplacementHistory::at(displacement);
            }
        }
        self.begin_at(time);
    }

    /// Start at a time (s) with the present displacements of the bodies that laws do not move.
    fn begin_at(&mut self, time: f64) {
        self.present.time = time;
        if let Some(gust) = &self.gust {
            self.present.gust = gust.target();
        }
        self.place_at_present();
        self.solver.place_grids(&[], &self.present, &self.problem);
        self.present.bodies = self.problem.without_force(&self.present.flexible.stations);
    }

    /// Begin with the displacements of the bodies whose loads are announced, and announce these.
    ///
    /// # Errors
    /// [`Error::Displacement`].
    pub fn announce_first(&mut self) -> Result<(), Error> {
        let (bodies, to) = (&self.problem.bodies, &self.motion.displaced_to);
        if !bodies.announce() {
            return Ok(());
        }
        self.limits.check_displacements(bodies.carried().map(|(_, rigid)| rigid), to, &self.grid_of_bodies())?;
        for (((_, rigid), history), to) in bodies.carried().zip(&mut self.present.histories).zip(to) {
            if rigid.announces() {
                *history = DisplacementHistory::at(*to);
            }
        }
        self.place_at_present();
        self.present.bodies = self.problem.without_force(&self.present.flexible.stations);
        self.predict_loads(self.limits.communication_step);
        // Flexible bodies begin without loads.
        self.present.flexible.loads.iter_mut().for_each(|loads| *loads = Loads::none(loads.impedance.len()));
        self.find_announced_contact();
        Ok(())
    }

    /// Find the part of contact in the present loads; flexible bodies begin without loads.
    fn find_announced_contact(&mut self) {
        let (dt, announces) = (self.coming_step(), self.announces());
        let Some(contact) = &mut self.flexible_contact else { return };
        let Present { flexible, histories, step, .. } = &self.present;
        if *step > 0.0 && announces {
            contact.find(&flexible.stations, poses(&self.problem.bodies, histories), dt);
            contact.pay(flexible.contact.step, &flexible.contact.flexible, &flexible.contact.bodies);
        } else {
            contact.clear();
        }
        self.problem.bodies.push(contact.pushes());
    }

    /// Return whether loads of the next step are announced. These hold for one step of the fluid.
    pub fn announces(&self) -> bool {
        !self.present.flexible.loads.is_empty() || self.problem.bodies.announce()
    }

    /// Return the longest communication step from here in which the fluid makes one step, s.
    pub fn longest_step(&self) -> f64 {
        self.limits.longest_step(self.present.advection_rate, self.solver.longest_step(&self.problem))
    }

    /// Return the length of the last step, s, and the number of equal steps into which the flow divides the coming one.
    fn coming_steps(&self) -> (f64, f64) {
        let last = if self.present.step > 0.0 { self.present.step } else { self.limits.communication_step };
        (last, StepLimits::count(last, self.longest_step()))
    }

    /// Return the length of the coming step, s.
    fn coming_step(&self) -> f64 {
        let (last, count) = self.coming_steps();
        last / count
    }

    /// Write the loads of the coming step, which a last communication step of `h` seconds tells.
    fn predict_loads(&mut self, h: f64) {
        let (last, count) = self.coming_steps();
        let dt = last / count;
        let Interfaces { stations, loads, .. } = &self.present.flexible;
        if !loads.is_empty() {
            let between = &mut self.motion.between;
            between.iter_mut().zip(stations).for_each(|(ahead, now)| ahead.extrapolate(now, h / count));
            self.problem.place_thin(between);
            if count > 1.0 {
                let Problem { bodies, grid, .. } = &mut self.problem;
                bodies.beams.iter_mut().for_each(|beam| beam.find_cells_ahead_again(between, stations, grid));
            }
        }
        self.solver.predict_loads(dt, &mut self.present, &mut self.problem);
        let Present { flexible, histories, .. } = &mut self.present;
        for ((owed, stations), loads) in flexible.owed.iter().zip(&flexible.stations).zip(&mut flexible.loads) {
            pay(&owed.map(|impulse| impulse / dt), stations, loads);
        }
        if let Some(contact) = &mut self.flexible_contact {
            contact.find(&flexible.stations, poses(&self.problem.bodies, histories), dt);
            contact.pay(flexible.contact.step, &flexible.contact.flexible, &flexible.contact.bodies);
            contact.add(&mut flexible.loads);
            self.problem.bodies.push(contact.pushes());
        }
    }

    /// Start again from the divergence-free part of a velocity field (m/s at a point in m).
    pub fn set_velocity(&mut self, velocity: impl Fn([f64; D]) -> [f64; D]) {
        self.pressures.invalidate();
        self.solver.start(&|grid: &Grid<D>, index| velocity(grid.point(index)), &mut self.present, &mut self.problem);
    }

    /// Continue the flow of another fluid on the same grids, with the same flexible and carried bodies and perhaps other
    /// rigid ones: its time, its velocity, and its flexible bodies with their loads.
    ///
    /// # Errors
    /// Another grid, other flexible bodies or other carried bodies; then nothing changes.
    pub fn continue_from(&mut self, other: &Self) -> Result<(), Error> {
        let (own, known) = (&self.present, &other.present);
        for (part, fits) in [
            (
                "a field",
                self.grid.cells == other.grid.cells
                    && self.problem.grid.cells == other.problem.grid.cells
                    && self.cells == other.cells,
            ),
            ("the list of bodies", own.histories.len() == known.histories.len()),
            ("the list of stations", own.flexible.have_shape_of(&known.flexible)),
        ] {
            if !fits {
                return Err(Error::State(part));
            }
        }
        self.present.flexible.copy_from(&known.flexible);
        self.present.histories.copy_from_slice(&known.histories);
        if let Some(contact) = &mut self.flexible_contact {
            contact.copy_from(other.flexible_contact.as_ref());
            self.problem.bodies.push(contact.pushes());
        }
        Stations::copy_all(&mut self.motion.target, &known.flexible.stations);
        self.motion.displaced_to.copy_from_slice(&other.motion.displaced_to);
        self.begin_at(known.time);
        self.pressures.invalidate();
        self.solver.place_grids(&other.solver.ways(), &self.present, &self.problem);
        let velocities: [_; D] = std::array::from_fn(|axis| other.solver.velocities(axis));
        let [finest, coarsest] = [&other.problem.grid, &other.grid].map(|grid| grid.spacing[0]);
        let at = |grid: &Grid<D>, point: usize| {
            // Nearest to one of three.
            let spacing = grid.spacing[0];
            let level = if spacing < 1.5 * finest {
                0
            } else {
                velocities[0].len() - 1 - usize::from(spacing < 0.75 * coarsest)
            };
            velocities.each_ref().map(|on_grids| on_grids[level][point])
        };
        self.solver.start(&at, &mut self.present, &mut self.problem);
        Ok(())
    }

    /// Advance from `t` to `t + h` (s); the stations move from their present places to those of [`Self::stations_mut`].
    ///
    /// The steps are equal; if the flow becomes too fast for them, the remaining time is divided again.
    ///
    /// # Errors
    /// Numbers that are not finite, a flow or stations that need more than a hundred times the usual number of steps, and
    /// several steps in space under announced loads. An error leaves everything unchanged; only after [`Error::Loads`] a
    /// state has to be restored.
    pub fn advance(&mut self, t: f64, h: f64) -> Result<(), Error> {
        self.problem.timer.start();
        self.limits.check(t, h)?;
        let grid = &self.grid_of_bodies();
        self.limits.check_stations(&self.contours, &self.motion.target, grid)?;
        let carried = self.problem.bodies.carried().map(|(_, rigid)| rigid);
        self.limits.check_displacements(carried, &self.motion.displaced_to, grid)?;
        let explicit = self.solver.longest_step(&self.problem);
        let substeps = self.limits.divide(t, h, self.present.advection_rate, explicit)?;
        Stations::copy_all(&mut self.motion.from, &self.present.flexible.stations);
        self.motion
            .displaced_from
            .iter_mut()
            .zip(&self.present.histories)
            .for_each(|(from, history)| *from = history.now);
        if let Some(gust) = &self.gust {
            gust.begin(t, h, &self.present.gust);
        }
        // A single step changes nothing before it is known to be good.
        let several = substeps > 1.0;
        // A rod in the plane may take the pressure jump instead.
        if several && D == 3 && self.announces() {
            return Err(Error::Divided { time: t, step: h, longest: self.longest_step() });
        }
        if several {
            self.save_for_undo()?;
        }
        let threads = self.solver.threads();
        if let Err(error) = ThreadTeam::with(threads, |team| self.make_steps(team, substeps, t, h)) {
            if let Some(undo) = self.undo.as_ref().filter(|_| several) {
                self.solver.restore(&undo.fields)?;
                self.present.copy_from(&undo.present);
            }
            self.place_at_present();
            if several {
                self.find_announced_contact();
            }
            return Err(error);
        }
        if let Some(gust) = &self.gust {
            self.present.gust = gust.target();
        }
        self.pressures.invalidate();
        self.update_owed_impulses(h);
        if let Some(contact) = &self.flexible_contact {
            let Motion { from, target, .. } = &self.motion;
            let ends = from.iter().zip(target);
            for ((own, (before, now)), to) in contact.loads().iter().zip(ends).zip(&mut self.present.flexible.exchange)
            {
                let power = own.power(before, now);
                (to.power, to.work) = (to.power + power, to.work + h * power);
            }
        }
        if self.announces() {
            self.predict_loads(h);
        }
        self.problem.timer.mark(Phase::Loads);
        if !self.present.flexible.loads.iter().all(Loads::are_finite) {
            // The previous flow is lost. Without a rate no step can be made before a state is restored.
            self.present.advection_rate = f64::NAN;
            return Err(Error::Loads { time: self.present.time });
        }
        Ok(())
    }

    /// Take off what surfaces took of the loads in a step of `h` seconds, but for the part of contact, and note by how much
    /// the impulses that both sides of a contact took differ.
    fn update_owed_impulses(&mut self, h: f64) {
        let Self { present, flexible_contact, problem: Problem { thin, bodies, .. }, motion, .. } = self;
        let Interfaces { owed, loads, contact: ContactOwed { step, flexible, bodies: on_bodies }, .. } =
            &mut present.flexible;
        let ends = [&*motion.from, &*motion.target];
        if let Some(contact) = flexible_contact {
            contact.take_off(loads);
        }
        if !owed.is_empty() {
            thin.subtract_taken(h, ends, loads, owed);
        }
        let Some(contact) = flexible_contact else { return };
        // A step of another length pays another part.
        let unpaid = 1.0 - h / *step;
        flexible.iter_mut().flat_map(|own| &mut own.force).flatten().for_each(|impulse| *impulse *= unpaid);
        on_bodies.iter_mut().flatten().for_each(|impulse| *impulse *= unpaid);
        *step = h;
        let taken = |number: usize, node: usize, change| {
            let of = |all: &[Loads<D>]| all[number].impedance[node];
            thin.taken(h, number, node, [of(loads), of(contact.loads())], change)
        };
        contact.add_owed_impulses(h, ends, taken, |number| bodies.rigid[number].push.change, (flexible, on_bodies));
    }

    /// Make the steps of a communication step, at first `substeps`.
    fn make_steps(&mut self, team: &ThreadTeam, mut substeps: f64, t: f64, h: f64) -> Result<(), Error> {
        // Shares of `h` that are done, and that were done when the rest was divided into `substeps`.
        let (mut done, mut divided, mut substep) = (0.0, 0.0, 0.0);
        let mut dt = h / substeps;
        let StepLimits { max_cfl, shortest, .. } = self.limits;
        loop {
            let rate = self.present.advection_rate;
            if substep > 0.0 && rate * dt > max_cfl {
                let left = h * (1.0 - done);
                (divided, substep, substeps) = (done, 0.0, (left * rate / max_cfl).ceil());
                dt = left / substeps;
            }
            substep += 1.0;
            done = if substep == substeps { 1.0 } else { divided + (1.0 - divided) * (substep / substeps) };
            let (is_last, end_time) = (done == 1.0, t + done * h);
            self.problem.bodies.release(end_time, dt);
            let Motion { from, between, target, displaced_from, displaced, displaced_at_end, displaced_to } =
                &mut self.motion;
            let (histories, ends) = (&self.present.histories, displaced_from.iter().zip(&*displaced_to));
            let places = displaced.iter_mut().zip(&mut *displaced_at_end);
            for (((_, rigid), (placed, end)), (history, (a, b))) in
                self.problem.bodies.carried().zip(places).zip(histories.iter().zip(ends))
            {
                *end = if is_last { *b } else { Pose::interpolated(a, b, done, h) };
                *placed = match rigid.before_release(end_time) {
                    _ if rigid.is_predicted() => history.predicted(dt, self.present.step),
                    Some(by_law) => by_law,
                    None => *end,
                };
            }
            let (stations, ahead) = if is_last {
                between.iter_mut().zip(&*target).for_each(|(ahead, target)| ahead.extrapolate(target, h));
                (&*target, (!self.present.flexible.loads.is_empty()).then_some(&**between))
            } else {
                let ends = from.iter().zip(&*target);
                between.iter_mut().zip(ends).for_each(|(now, (a, b))| now.interpolate(a, b, done, h));
                (&*between, None)
            };
            let (displacements, ends) = (&**displaced, &**displaced_at_end);
            let step = Substep { dt, end: end_time, stations, displacements, ends, ahead, max_cfl, shortest, team };
            self.solver.step(&step, &mut self.present, &mut self.problem)?;
            if is_last {
                return Ok(());
            }
        }
    }

    /// Put the bodies to their present places.
    fn place_at_present(&mut self) {
        let (stations, displaced) = (&self.present.flexible.stations, &mut self.motion.displaced);
        displaced.iter_mut().zip(&self.present.histories).for_each(|(now, history)| *now = history.now);
        self.problem.place(&Placement {
            time: self.present.time,
            displacements: displaced,
            stations,
            before: stations,
        });
    }

    fn save_for_undo(&mut self) -> Result<(), Error> {
        match &mut self.undo {
            Some(undo) => {
                undo.present.copy_from(&self.present);
                self.solver.save(&mut undo.fields);
            }
            None => {
                let bytes = self.state_bytes();
                if !is_available(bytes) {
                    return Err(Error::Memory { bytes });
                }
                self.undo = Some(self.state());
            }
        }
        Ok(())
    }

    /// Return a copy of everything that the next step depends on.
    pub fn state(&self) -> State<D> {
        State { present: self.present.clone(), fields: self.solver.fields() }
    }

    /// Go to a state of a fluid with the same parameters.
    ///
    /// # Errors
    /// A state of other parameters, or with numbers that are not finite; it changes nothing.
    pub fn restore(&mut self, state: &State<D>) -> Result<(), Error> {
        self.solver.check(&state.fields)?;
        if let Some(part) = state.present.misfit(&self.present) {
            return Err(Error::State(part));
        }
        let grid = self.problem.grid.moved(&self.solver.way_in(&state.fields));
        self.limits.check_stations(&self.contours, &state.present.flexible.stations, &grid)?;
        self.solver.restore(&state.fields)?;
        self.present.copy_from(&state.present);
        Stations::copy_all(&mut self.motion.target, &self.present.flexible.stations);
        self.motion.displaced_to.iter_mut().zip(&self.present.histories).for_each(|(to, history)| *to = history.now);
        self.pressures.invalidate();
        self.place_at_present();
        self.find_announced_contact();
        if self.problem.bodies.announce() {
            self.predict_loads(self.coming_steps().0);
            // Those of flexible bodies are for stations that the present ones do not tell.
            let known = self.present.flexible.loads.iter_mut().zip(&state.present.flexible.loads);
            known.for_each(|(own, known)| own.copy_from(known));
        }
        Ok(())
    }
}
