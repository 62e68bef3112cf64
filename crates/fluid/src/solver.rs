//! The fluid and its default time stepping; [`rk2`] has the other scheme, [`forces`] the loads on the bodies.
//!
//! Two-step backward differences with extrapolated advection, split so that what is local in space and what is local
//! in wavenumber are each solved exactly (Douglas–Rachford in incremental form). With `c_0 … c_2` the difference
//! coefficients, `e_1, e_2` the extrapolation, `tau = 1/c_0`, `N = omega × u` and `G = ∇Pi − nu ∇²u` (plus what the
//! filter removes),
//!
//! ```text
//! (c_0 + Σ a_b) u*  = c_1 u^n + c_2 u^{n−1} − e_1 N^n − e_2 N^{n−1} − G^n + Σ a_b u_b      point by point
//! (1 − tau nu ∇²) u^{n+1} + tau ∇Pi^{n+1} = F (u* + tau G^n),   ∇·u^{n+1} = 0             wave by wave
//! G^{n+1} = c_0 (u* + tau G^n − u^{n+1})                                                  point by point
//! ```
//!
//! The sum of the two is the scheme with both parts implicit but for `a tau (G^{n+1} − G^n)`, of second order. Both
//! parts are monotone, so neither stiff drag nor viscosity bounds the step; advection does. A step takes five real
//! transforms: two forward (u* + tau G) and three inverse (u, v, omega).
//!
//! The drag on the bodies in the step is `rho a_b (u* − u_b)`. It is linear in u_b with the slope
//! `−rho a_b (1 − a_b/(c_0 + Σ a))`, which is what the impedance of the loads is.

mod forces;
mod rk2;

use std::sync::atomic::{AtomicU64, Ordering};

use scene::{Load, Scene, TimeScheme};
use serde::{Deserialize, Serialize};

use crate::beam::{Beam, Exchange, Loads, Stations};
use crate::body::{Cells, Painted};
use crate::cylinder::Cylinder;
use crate::drag::DragProfile;
use crate::fft::{Fft2, Quad, Scratch, on_threads};
use crate::grid::Grid;
use crate::kernel::{self, Component, Differences};
use crate::probe::Probe;
use crate::projection::Projection;
use crate::zone::Zone;

use forces::BodyState;
pub use forces::Force;
use rk2::{Rk2, Stage};

/// Points that the local solve takes at a time, so that what both components read stays in the first cache.
const BLOCK: usize = 256;

/// More of the fluid's own steps than this in one communication step are taken for divergence.
const MAX_SUBSTEPS: f64 = 1e5;

/// Parts of a two-step step, in their order, for [`Fluid::advance_marking`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The moving bodies are painted where they are.
    Paint,
    /// Bodies with a wall target look at the flow.
    Look,
    /// The local solve.
    Solve,
    /// The velocities of bodies and zones are added.
    Velocities,
    /// The forces on the bodies are summed up.
    Forces,
    /// Two transforms along y.
    Forward,
    /// Five transforms along x, and the projection.
    Rows,
    /// Three transforms back along y, and the CFL number.
    Back,
    /// The loads on the stations for the coming step.
    Loads,
}

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
        "station {station} of the beam is at ({x}, {y}) m with velocity ({vx}, {vy}) m/s, but it must be finite and within one box length of the box"
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
        "C_eta = {c_eta:.3e} s is too small for the scheme rk2: its steps may not be longer, which makes {substeps:.0} of them in the communication step of {step} s from t = {time} s; use sbdf2, a larger C_eta or a smaller communication step"
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

/// Everything the next step depends on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Time, s.
    pub time: f64,
    /// The flow at this time.
    flow: Flow,
    /// The flow one step earlier; empty with RK2.
    flow_before: Flow,
    /// `w = u* + tau G` of the last step, m/s, `[nx, ny]` per component; empty with RK2.
    w: [Vec<f64>; 2],
    /// Spectrum of the velocity, m/s, `[ny/2 + 1, nx]` per component; empty with SBDF2.
    u_hat: [Vec<Quad>; 2],
    /// `1/tau` of the last step, 1/s, so that `G = (w − u)/tau`; 0 before the first, where G is 0.
    per_tau: f64,
    /// The last step, s; 0 before the first.
    step: f64,
    /// Largest `|u|/dx + |v|/dy`, 1/s.
    advection_rate: f64,
    /// The cylinders, then the beam.
    bodies: Vec<BodyState>,
    /// The beam, where there is one.
    beam: Option<BeamState>,
}

/// Fields of one time, `[nx, ny]` each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Flow {
    /// Velocity, m/s, per component.
    velocity: [Vec<f64>; 2],
    /// Vorticity, 1/s.
    vorticity: Vec<f64>,
}

/// The beam as the fluid last saw it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct BeamState {
    stations: Stations,
    /// Loads for the coming step; absent where the scene uses the pressure jump.
    loads: Option<Loads>,
    exchange: Exchange,
}

/// A fluid with the bodies of a scene in it.
pub struct Fluid {
    grid: Grid,
    density: f64,
    nu: f64,
    max_step: f64,
    max_cfl: f64,
    fft: Fft2,
    projection: Projection,
    /// Inflow and sponge.
    zones: Vec<Zone>,
    mean_flow: Option<scene::MeanFlow>,
    cylinders: Vec<Cylinder>,
    beam: Option<MovingBeam>,
    /// Total drag rate Σ a_b, 1/s, `[nx, ny]`; absent where there is no body at all.
    rate: Option<Vec<f64>>,
    painted: Painted,
    probes: Vec<Probe>,
    /// Heun's method; absent with SBDF2.
    rk2: Option<Rk2>,
    /// `w` of the step that is being made, m/s. Between steps the first is Pi, m²/s², if that is current.
    w: [Vec<f64>; 2],
    total_pressure_is_current: bool,
    /// Spectra of both components and of the vorticity or pressure.
    spectra: [Vec<Quad>; 3],
    /// What each thread needs for itself.
    scratch: Vec<Scratch>,
    state: State,
}

/// A beam, and where it is told to go.
struct MovingBeam {
    body: Beam,
    /// Stations at the end of the coming communication step, set from outside.
    target: Stations,
    /// Stations at the beginning of the communication step.
    from: Stations,
    /// Pressure jump at the stations, Pa, and the pressure field it came from; made when asked for.
    pressure_jump: Vec<f64>,
    pressure_jump_is_current: bool,
}

impl State {
    /// The first part that a state `own` of the same scene would have otherwise: in another size, or, of the numbers that
    /// are not fields, not finite.
    fn misfit(&self, own: &Self) -> Option<&'static str> {
        let numbers = [self.time, self.per_tau, self.step, self.advection_rate];
        let sizes = |state: &Self| {
            let fields =
                [&state.flow, &state.flow_before].map(|Flow { velocity: [u, v], vorticity }| [u, v, vorticity]);
            (
                fields.map(|field| field.map(Vec::len)),
                state.w.each_ref().map(Vec::len),
                state.u_hat.each_ref().map(Vec::len),
            )
        };
        let beam = match (&self.beam, &own.beam) {
            (None, None) => true,
            (Some(a), Some(b)) => {
                a.stations.has_shape_of(&b.stations)
                    && match (&a.loads, &b.loads) {
                        (None, None) => true,
                        (Some(a), Some(b)) => a.has_shape_of(b),
                        _ => false,
                    }
            }
            _ => false,
        };
        [
            ("the time or a step", numbers.iter().all(|number| number.is_finite())),
            ("a field", sizes(self) == sizes(own)),
            ("the list of bodies", self.bodies.len() == own.bodies.len()),
            ("the beam", beam),
        ]
        .into_iter()
        .find_map(|(part, fits)| (!fits).then_some(part))
    }

    /// What one component of the local solve reads.
    fn component(&self, axis: usize) -> Component<'_> {
        let other = 1 - axis;
        Component {
            u: &self.flow.velocity[axis],
            u_before: &self.flow_before.velocity[axis],
            w: &self.w[axis],
            per_tau: self.per_tau,
            omega: &self.flow.vorticity,
            omega_before: &self.flow_before.vorticity,
            other: &self.flow.velocity[other],
            other_before: &self.flow_before.velocity[other],
            // omega × u = (−omega v, omega u)
            sign: if axis == 0 { -1.0 } else { 1.0 },
        }
    }
}

/// Centres and radii of the cylinders that do not move, m.
fn still_circles(fluid: &scene::Fluid) -> Vec<([f64; 2], f64)> {
    let still = fluid.cylinders.iter().filter(|cylinder| cylinder.motion.is_none());
    still.map(|cylinder| (cylinder.center, cylinder.radius)).collect()
}

fn probes(fluid: &scene::Fluid, grid: &Grid) -> Vec<Probe> {
    let (circles, walls) = (still_circles(fluid), fluid.channel.as_ref().map(|channel| channel.y));
    fluid.probes.iter().map(|probe| Probe::new(probe.position, &circles, walls, grid)).collect()
}

impl Fluid {
    /// The fluid of a scene at t = 0.
    pub fn new(scene: &Scene) -> Result<Self, Error> {
        let loads_are_wanted = scene.load().is_none_or(|load| load == Load::Momentum);
        let fluid = scene.fluid.as_ref().ok_or_else(|| Error::NoFluid(scene.name.clone()))?;
        let grid = Grid::new(&fluid.domain);
        let nu = fluid.kinematic_viscosity;
        let profile = DragProfile::new(&fluid.mask, fluid.mask.c_eta(), nu, grid.cell_size());
        let zones = Zone::of(fluid, &grid);
        let cylinders: Vec<_> = fluid.cylinders.iter().map(|c| Cylinder::new(c, &grid, &profile)).collect();
        let beam = scene.beam.as_ref().map(|beam| {
            let stations = Stations::at_rest(scene, beam);
            MovingBeam {
                body: Beam::new(beam, &grid, &profile),
                pressure_jump: vec![0.0; stations.len()],
                pressure_jump_is_current: false,
                target: stations.clone(),
                from: stations,
            }
        });
        let projection = Projection::new(&grid, fluid.filter);
        let fft = Fft2::new(grid.nx, grid.ny, projection.modes());
        let field = || vec![0.0; grid.len()];
        let [u, v] = fluid.initial_velocity;
        let rk2 =
            (fluid.time_stepping.scheme == TimeScheme::Rk2).then(|| Rk2::new(&grid, fft.spectrum().len() / grid.nx));
        let past = || if rk2.is_some() { Vec::new() } else { field() };
        let state = State {
            time: 0.0,
            flow_before: Flow { velocity: [past(), past()], vorticity: past() },
            flow: Flow { velocity: [vec![u; grid.len()], vec![v; grid.len()]], vorticity: field() },
            w: [past(), past()],
            u_hat: [Vec::new(), Vec::new()],
            per_tau: 0.0,
            step: 0.0,
            advection_rate: u.abs() / grid.dx + v.abs() / grid.dy,
            bodies: Vec::new(),
            beam: beam.as_ref().map(|b| BeamState {
                stations: b.target.clone(),
                loads: loads_are_wanted.then(|| Loads::none(b.target.len())),
                exchange: Exchange::default(),
            }),
        };
        let has_bodies = !zones.is_empty() || fluid.channel.is_some() || !cylinders.is_empty() || beam.is_some();
        let mut solver = Self {
            rate: has_bodies.then(field),
            w: [field(), field()],
            spectra: [fft.spectrum(), fft.spectrum(), fft.spectrum()],
            scratch: (0..fluid.threads).map(|_| fft.scratch()).collect(),
            density: fluid.density,
            max_step: fluid.time_stepping.max_step,
            max_cfl: fluid.time_stepping.max_cfl,
            painted: Painted::default(),
            nu,
            fft,
            zones,
            mean_flow: fluid.mean_flow.clone(),
            probes: probes(fluid, &grid),
            rk2,
            total_pressure_is_current: false,
            grid,
            cylinders,
            beam,
            projection,
            state,
        };
        solver.paint_still_bodies(fluid, &profile.plain());
        solver.paint_moving_bodies();
        solver.state.bodies = solver.bodies_without_force();
        if solver.rk2.is_some() {
            solver.state.u_hat = [u, v].map(|velocity| solver.uniform_spectrum(velocity));
        }
        Ok(solver)
    }

    /// The grid.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Time, s.
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// Velocity component (0: x, 1: y), m/s, `[nx, ny]`.
    pub fn velocity(&self, axis: usize) -> &[f64] {
        &self.state.flow.velocity[axis]
    }

    /// Start anew from a velocity field (m/s at a point in m), of which the divergence-free part is taken.
    pub fn set_velocity(&mut self, velocity: impl Fn(f64, f64) -> [f64; 2]) {
        for i in 0..self.grid.nx {
            for j in 0..self.grid.ny {
                let [u, v] = velocity(self.grid.x(i), self.grid.y(j));
                self.w[0][i * self.grid.ny + j] = u;
                self.w[1][i * self.grid.ny + j] = v;
            }
        }
        (self.state.step, self.state.per_tau) = (0.0, 0.0);
        self.total_pressure_is_current = false;
        if self.rk2.is_some() {
            self.solve_stage(Stage::Start);
        } else {
            // In no time viscosity does nothing: what is left of the solve is the projection.
            self.hold_mean_flow();
            self.solve_wave_by_wave(f64::MIN_POSITIVE, &mut |_| ());
        }
    }

    /// Vorticity, 1/s, `[nx, ny]`.
    pub fn vorticity(&self) -> &[f64] {
        &self.state.flow.vorticity
    }

    /// Static pressure p = rho (Pi − u²/2), Pa, `[nx, ny]`; Pi has zero mean over the box.
    pub fn pressure(&mut self) -> Vec<f64> {
        self.make_total_pressure();
        (0..self.grid.len()).map(|point| self.density * self.pressure_at(point)).collect()
    }

    /// Static pressure over the density at a grid point, Pi − u²/2, m²/s²; Pi must be current.
    fn pressure_at(&self, point: usize) -> f64 {
        let [u, v] = self.state.flow.velocity.each_ref().map(|velocity| velocity[point]);
        self.w[0][point] - 0.5 * (u * u + v * v)
    }

    /// Velocity at a probe, numbered from 0 as in the scene, m/s.
    pub fn probe_velocity(&self, probe: usize) -> [f64; 2] {
        self.state.flow.velocity.each_ref().map(|velocity| self.probes[probe].velocity(velocity))
    }

    /// Static pressure at a probe, Pa. The first after a step costs three transforms.
    pub fn probe_pressure(&mut self, probe: usize) -> f64 {
        self.make_total_pressure();
        self.density * self.probes[probe].pressure(|point| self.pressure_at(point))
    }

    /// Largest divergence of the velocity times the cell size over the largest speed; three transforms.
    pub fn divergence(&mut self) -> f64 {
        let ([u, v], field) = (&self.state.flow.velocity, &mut self.w[1]);
        let [u_hat, v_hat, divergence] = &mut self.spectra;
        let scratch = &mut self.scratch[0];
        self.fft.forward(u, u_hat, scratch);
        self.fft.forward(v, v_hat, scratch);
        self.projection.divergence(u_hat, v_hat, divergence);
        self.fft.inverse(divergence, field, scratch);
        let largest = field.iter().fold(0.0_f64, |most, divergence| most.max(divergence.abs()));
        let fastest = u.iter().zip(v).fold(0.0_f64, |most, (u, v)| most.max(u.hypot(*v)));
        largest * self.grid.cell_size() / fastest.max(f64::MIN_POSITIVE)
    }

    /// Stations at the end of the coming step.
    pub fn stations(&self) -> Option<&Stations> {
        self.beam.as_ref().map(|beam| &beam.target)
    }

    /// Stations at the end of the coming step, to be set before [`Self::advance`].
    pub fn stations_mut(&mut self) -> Option<&mut Stations> {
        self.beam.as_mut().map(|beam| &mut beam.target)
    }

    /// Loads on the stations for the coming step; none without a beam or where the scene uses the pressure jump.
    pub fn loads(&self) -> Option<&Loads> {
        self.state.beam.as_ref()?.loads.as_ref()
    }

    /// CFL number max(|u|/dx + |v|/dy) dt of the last step.
    pub fn cfl(&self) -> f64 {
        self.state.advection_rate * self.state.step
    }

    /// Flow rate through the column in the middle of the box, m²/s.
    pub fn flow_rate(&self) -> f64 {
        let (ny, middle) = (self.grid.ny, self.grid.nx / 2);
        self.state.flow.velocity[0][middle * ny..(middle + 1) * ny].iter().sum::<f64>() * self.grid.dy
    }

    /// Kinetic energy of the whole box, J/m.
    pub fn kinetic_energy(&self) -> f64 {
        let [u, v] = &self.state.flow.velocity;
        let squares: f64 = u.iter().zip(v).map(|(u, v)| u * u + v * v).sum();
        0.5 * self.density * squares * self.grid.cell_area()
    }

    /// Half the integral of the squared vorticity over the whole box, m²/s².
    pub fn enstrophy(&self) -> f64 {
        let squares: f64 = self.state.flow.vorticity.iter().map(|omega| omega * omega).sum();
        0.5 * squares * self.grid.cell_area()
    }

    /// Everything the next step depends on.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Go back (or on) to a state of this scene; a state that is refused changes nothing.
    pub fn restore(&mut self, state: &State) -> Result<(), Error> {
        if let Some(part) = state.misfit(&self.state) {
            return Err(Error::State(part));
        }
        if let Some(beam) = &state.beam {
            self.check_stations(&beam.stations)?;
        }
        self.state.clone_from(state);
        if let (Some(beam), Some(known)) = (&mut self.beam, &state.beam) {
            beam.target.copy_from(&known.stations);
            beam.pressure_jump_is_current = false;
        }
        self.total_pressure_is_current = false;
        self.paint_moving_bodies();
        Ok(())
    }

    /// Advance from `t` to `t + h` (s); the stations go from where they are to where they were set.
    ///
    /// The steps are equal, but those that are left are divided anew where the flow has become too fast for them on the way.
    ///
    /// What is refused leaves the state as it was; after [`Error::Diverged`] only [`Self::restore`] helps.
    pub fn advance(&mut self, t: f64, h: f64) -> Result<(), Error> {
        self.advance_marking(t, h, &mut |_| ())
    }

    /// [`Self::advance`] with a call of `mark` at the end of each phase of the two-step scheme, for a clock.
    pub fn advance_marking(&mut self, t: f64, h: f64, mark: &mut impl FnMut(Phase)) -> Result<(), Error> {
        if !(t.is_finite() && h.is_finite() && h > 0.0) {
            return Err(Error::Step { time: t, step: h });
        }
        if let Some(beam) = &self.beam {
            self.check_stations(&beam.target)?;
        }
        let largest = self.max_step.min(self.max_cfl / self.state.advection_rate.max(f64::MIN_POSITIVE));
        let mut substeps = (h / largest - 1e-9).ceil().max(1.0);
        if self.rk2.is_some() {
            let c_eta = self.longest_explicit_step();
            let explicit = (h / c_eta - 1e-9).ceil();
            if explicit > MAX_SUBSTEPS {
                return Err(Error::Stiff { time: t, step: h, c_eta, substeps: explicit });
            }
            substeps = substeps.max(explicit);
        }
        if substeps > MAX_SUBSTEPS {
            let cfl = self.state.advection_rate * h;
            return Err(Error::Diverged { time: t, cfl, step: h });
        }
        if let (Some(beam), Some(known)) = (&mut self.beam, &self.state.beam) {
            beam.from.copy_from(&known.stations);
        }
        // The shares of `h` that are done, and that were done when what was left was last divided into `substeps`.
        let (mut done, mut divided, mut substep) = (0.0, 0.0, 0.0);
        let mut dt = h / substeps;
        while done < 1.0 {
            let rate = self.state.advection_rate;
            if substep > 0.0 && rate * dt > self.max_cfl {
                let left = h * (1.0 - done);
                (divided, substep, substeps) = (done, 0.0, (left * rate / self.max_cfl).ceil());
                if substeps > MAX_SUBSTEPS {
                    return Err(Error::Diverged { time: self.state.time, cfl: rate * dt, step: dt });
                }
                dt = left / substeps;
            }
            substep += 1.0;
            done = if substep == substeps { 1.0 } else { divided + (1.0 - divided) * (substep / substeps) };
            if let (Some(beam), Some(known)) = (&self.beam, &mut self.state.beam) {
                if done == 1.0 {
                    known.stations.copy_from(&beam.target);
                } else {
                    known.stations.interpolate(&beam.from, &beam.target, done, h);
                }
            }
            self.step(dt, t + done * h, mark)?;
        }
        self.look();
        mark(Phase::Look);
        self.predict_loads();
        mark(Phase::Loads);
        Ok(())
    }

    /// Pressure jump p_above − p_below at the stations, Pa; made when first asked for after a step.
    pub fn pressure_jump(&mut self) -> Option<&[f64]> {
        self.beam.as_ref()?;
        if self.beam.as_ref().is_some_and(|beam| !beam.pressure_jump_is_current) {
            self.make_total_pressure();
            // Taken out, so that the rest can be read while it is written.
            let mut jump = self.beam.as_mut().map(|beam| std::mem::take(&mut beam.pressure_jump)).unwrap_or_default();
            if let (Some(beam), Some(known)) = (&self.beam, &self.state.beam) {
                let at = |point: [f64; 2]| -> f64 {
                    self.grid.interpolation(point).iter().map(|&(c, weight)| weight * self.pressure_at(c)).sum()
                };
                for (k, jump) in jump.iter_mut().enumerate() {
                    let [above, below] = [1.0, -1.0].map(|side| beam.body.surface_point(&known.stations, k, side));
                    *jump = self.density * (at(above) - at(below));
                }
            }
            if let Some(beam) = &mut self.beam {
                (beam.pressure_jump, beam.pressure_jump_is_current) = (jump, true);
            }
        }
        self.beam.as_ref().map(|beam| beam.pressure_jump.as_slice())
    }

    /// Let the first of `w` be Pi at the present time: what makes the rate of change free of divergence.
    fn make_total_pressure(&mut self) {
        if self.total_pressure_is_current {
            return;
        }
        let explicit = self.rk2.is_some();
        if explicit {
            // The velocity itself has no divergence.
            self.add_rate_of_change(1.0);
        }
        let (w, per_tau) = if explicit { (&self.w, 1.0) } else { (&self.state.w, self.state.per_tau) };
        let [wx_hat, wy_hat, pressure] = &mut self.spectra;
        let scratch = &mut self.scratch[0];
        self.fft.forward(&w[0], wx_hat, scratch);
        self.fft.forward(&w[1], wy_hat, scratch);
        self.projection.pressure(wx_hat, wy_hat, per_tau, pressure);
        self.fft.inverse(pressure, &mut self.w[0], scratch);
        self.total_pressure_is_current = true;
    }

    fn check_stations(&self, stations: &Stations) -> Result<(), Error> {
        let Stations { position: [x, y], velocity: [vx, vy] } = stations;
        let far = |p: f64, middle: f64, size: f64| (p - middle).abs() > 1.5 * size;
        let middle = [self.grid.x(self.grid.nx / 2), self.grid.y(self.grid.ny / 2)];
        for k in 0..x.len() {
            let finite = [x[k], y[k], vx[k], vy[k]].iter().all(|c| c.is_finite());
            if !finite || far(x[k], middle[0], self.grid.length) || far(y[k], middle[1], self.grid.height) {
                return Err(Error::Station { station: k + 1, x: x[k], y: y[k], vx: vx[k], vy: vy[k] });
            }
        }
        Ok(())
    }

    fn paint_still_bodies(&mut self, fluid: &scene::Fluid, profile: &DragProfile) {
        let Some(rate) = &mut self.rate else { return };
        let grid = &self.grid;
        if let Some(channel) = &fluid.channel {
            let [low, high] = channel.y;
            for j in 0..grid.ny {
                let distance = 0.5 * (high - low) - grid.periodic_y(grid.y(j) - 0.5 * (low + high)).abs();
                let wall = profile.rate(distance);
                (0..grid.nx).for_each(|i| rate[i * grid.ny + j] += wall);
            }
        }
        for &(i, zone) in self.zones.iter().flat_map(|zone| &zone.columns) {
            rate[i * grid.ny..(i + 1) * grid.ny].iter_mut().for_each(|r| *r += zone);
        }
        for cylinder in self.cylinders.iter().filter(|c| !c.moves()) {
            cylinder.cells.iter().for_each(|cell| rate[cell.index] += cell.rate);
        }
    }

    /// Put the moving bodies where they are at the state's time.
    fn paint_moving_bodies(&mut self) {
        let Some(rate) = &mut self.rate else { return };
        self.painted.erase(rate);
        for cylinder in self.cylinders.iter_mut().filter(|c| c.moves()) {
            cylinder.place(self.state.time, &self.grid);
            self.painted.add(&cylinder.cells, rate);
        }
        if let (Some(beam), Some(known)) = (&mut self.beam, &self.state.beam) {
            beam.body.place(&known.stations, &self.grid);
            self.painted.add(&beam.body.cells, rate);
        }
    }

    /// One step of size `dt` to the time `end`; the stations are already there.
    fn step(&mut self, dt: f64, end: f64, mark: &mut impl FnMut(Phase)) -> Result<(), Error> {
        if self.rk2.is_some() {
            return self.step_rk2(dt, end);
        }
        let scheme = Differences::new(dt, self.state.step);
        self.state.time = end;
        self.paint_moving_bodies();
        mark(Phase::Paint);
        self.look();
        mark(Phase::Look);
        self.solve_locally(&scheme);
        mark(Phase::Solve);
        self.add_body_velocities(|rate| 1.0 / (scheme.c[0] + rate));
        mark(Phase::Velocities);
        self.sum_up_forces(dt, |fluid, cell| {
            [0, 1].map(|axis| {
                let (_, g) = fluid.state.component(axis).right_side(&scheme, cell.index);
                let u_star = fluid.w[axis][cell.index] - scheme.tau * g;
                cell.rate * (u_star - cell.velocity[axis])
            })
        });
        mark(Phase::Forces);
        self.hold_mean_flow();
        self.solve_wave_by_wave(scheme.tau, mark);
        std::mem::swap(&mut self.state.w, &mut self.w);
        (self.state.step, self.state.per_tau) = (dt, scheme.c[0]);
        self.finish_step(dt)
    }

    /// What depended on the flow before is out of date; and is the new flow one?
    fn finish_step(&mut self, dt: f64) -> Result<(), Error> {
        self.total_pressure_is_current = false;
        if let Some(beam) = &mut self.beam {
            beam.pressure_jump_is_current = false;
        }
        let cfl = self.state.advection_rate * dt;
        if cfl.is_finite() { Ok(()) } else { Err(Error::Diverged { time: self.state.time, cfl, step: dt }) }
    }

    /// Tell the solve wave by wave what the mean flow is at the present time.
    fn hold_mean_flow(&mut self) {
        if let Some(scene::MeanFlow { x, y }) = &self.mean_flow {
            self.projection.mean = Some([x, y].map(|law| law.value(self.state.time)));
        }
    }

    /// Let the bodies that follow a wall target look at the present flow.
    fn look(&mut self) {
        let flow = &self.state.flow.velocity;
        self.cylinders.iter_mut().for_each(|cylinder| cylinder.cells.look(flow));
        if let Some(beam) = &mut self.beam {
            beam.body.cells.look(flow);
        }
    }

    /// u* + tau G without the velocities of the bodies, into `w`.
    fn solve_locally(&mut self, scheme: &Differences) {
        let no_rate = [0.0; BLOCK];
        let components = [0, 1].map(|axis| self.state.component(axis));
        let share = self.grid.len().div_ceil(self.scratch.len());
        let [wx, wy] = self.w.each_mut().map(|w| w.chunks_mut(share));
        on_threads((0..).step_by(share).zip(wx.zip(wy)), |(first, (wx, wy))| {
            for start in (0..wx.len()).step_by(BLOCK) {
                let part = start..(start + BLOCK).min(wx.len());
                let points = first + part.start..first + part.end;
                let rate = self.rate.as_ref().map_or(&no_rate[..part.len()], |rate| &rate[points.clone()]);
                for (component, w) in components.iter().zip([&mut *wx, &mut *wy]) {
                    kernel::solve(&component.points(points.clone()), scheme, rate, &mut w[part.clone()]);
                }
            }
        });
    }

    /// Add `weight(Σ a) a_b u_b` of all bodies and zones to `w`.
    fn add_body_velocities(&mut self, weight: impl Fn(f64) -> f64) {
        let Some(rate) = &self.rate else { return };
        let ny = self.grid.ny;
        for Zone { law, columns, shape } in &self.zones {
            let mean = law.value(self.state.time);
            for &(i, zone) in columns {
                for (j, shape) in shape.iter().enumerate() {
                    let index = i * ny + j;
                    self.w[0][index] += weight(rate[index]) * zone * mean * shape;
                }
            }
        }
        let cylinders = self.cylinders.iter().filter(|c| c.moves() || c.cells.follow_the_flow()).map(|c| &c.cells);
        let beam = self.beam.iter().map(|b| &b.body.cells);
        for cell in cylinders.chain(beam).flat_map(Cells::iter) {
            let weight = weight(rate[cell.index]) * cell.rate;
            self.w[0][cell.index] += weight * cell.velocity[0];
            self.w[1][cell.index] += weight * cell.velocity[1];
        }
    }

    /// From w to the flow at the new time.
    ///
    /// Between the two passes along y, each row of modes goes through both transforms along x and the projection while
    /// it is in the cache.
    fn solve_wave_by_wave(&mut self, tau: f64, mark: &mut impl FnMut(Phase)) {
        let State { flow, flow_before, advection_rate, .. } = &mut self.state;
        std::mem::swap(flow, flow_before);
        let [u_hat, v_hat, omega_hat] = &mut self.spectra;
        let (fft, nx, ny) = (&self.fft, self.grid.nx, self.grid.ny);
        fft.forward_along_y([&self.w[0], &self.w[1]], [&mut *u_hat, &mut *v_hat], &mut self.scratch);
        mark(Phase::Forward);

        self.projection.set_viscosity(tau * self.nu);
        let projection = &self.projection;
        let share = (u_hat.len() / nx).div_ceil(self.scratch.len());
        let [u_rows, v_rows, omega_rows] =
            [&mut *u_hat, v_hat, omega_hat].map(|spectrum| spectrum.chunks_mut(share * nx));
        let rows = (0..).step_by(share).zip(u_rows.zip(v_rows).zip(omega_rows));
        on_threads(rows.zip(&mut self.scratch), |((first, ((u_hat, v_hat), omega_hat)), scratch)| {
            let Scratch { rows: [u, v, omega], line, .. } = scratch;
            let rows = u_hat.chunks_exact_mut(nx).zip(v_hat.chunks_exact_mut(nx)).zip(omega_hat.chunks_exact_mut(nx));
            for (row, ((u_hat, v_hat), omega_hat)) in (first..).zip(rows) {
                fft.forward_along_x(u_hat, u, line);
                fft.forward_along_x(v_hat, v, line);
                projection.project(row, u, v, omega);
                fft.inverse_along_x(u, u_hat, line);
                fft.inverse_along_x(v, v_hat, line);
                fft.inverse_along_x(omega, omega_hat, line);
            }
        });

        mark(Phase::Rows);

        let Flow { velocity: [u, v], vorticity } = flow;
        let [u_hat, v_hat, omega_hat] = &self.spectra;
        let (per_dx, per_dy) = (1.0 / self.grid.dx, 1.0 / self.grid.dy);
        // Numbers not below 0 are ordered like their bits.
        let largest = AtomicU64::new(0);
        let [mut u_rest, mut v_rest, mut omega_rest] = [&mut *u, &mut *v, vorticity].map(Vec::as_mut_slice);
        let shares = fft.shares(self.scratch.len()).filter_map(|share| {
            let points = ..share.len() * ny;
            let (u, v) = (u_rest.split_off_mut(points)?, v_rest.split_off_mut(points)?);
            Some((share, u, v, omega_rest.split_off_mut(points)?))
        });
        on_threads(shares.zip(&mut self.scratch), |((share, u, v, omega), scratch)| {
            for columns in fft.blocks(share.clone()) {
                let points = (columns.start - share.start) * ny..(columns.end - share.start) * ny;
                let [u, v, omega] = [&mut *u, &mut *v, &mut *omega].map(|field| &mut field[points.clone()]);
                fft.inverse_along_y(u_hat, columns.clone(), u, scratch);
                fft.inverse_along_y(v_hat, columns.clone(), v, scratch);
                fft.inverse_along_y(omega_hat, columns, omega, scratch);
                largest.fetch_max(kernel::advection_rate(per_dx, per_dy, u, v).to_bits(), Ordering::Relaxed);
            }
        });
        // A transform spreads what is not a number to every point: the first tells of all.
        let finite = (u[0] + v[0]).is_finite();
        *advection_rate = if finite { f64::from_bits(largest.into_inner()) } else { f64::NAN };
        mark(Phase::Back);
    }
}
