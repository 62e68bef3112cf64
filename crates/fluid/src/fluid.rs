//! The fluid of a scene in one precision: its time loop, and what can be set and read.

use std::borrow::Cow;
use std::hint::black_box;
use std::mem::take;

use scene::{Load, Scene};

use crate::bodies::{Loads, Pose, Stations};
use crate::domain::Domain;
use crate::error::Error;
use crate::force::{Exchange, Force};
use crate::grid::Grid;
use crate::outlet::Outlet;
use crate::probe::Probe;
use crate::state::{Beams, Flow, Present, StateIn};
use crate::step::{Scheme, Step};
use line_fft::Real;
use line_fft::Team;

/// The usual step of the fluid's own is the smaller of `max_step` and the scene's communication step. Flow and beam may
/// make steps so many times shorter, and no more.
const SHORTEST: f64 = 100.0;

/// A communication step may be so many times that of the scene.
const LONGEST: f64 = 1000.0;

/// And it may have so many usual steps.
const MOST_STEPS: f64 = 1e5;

/// Explicit drag, which depends on the scene alone, may divide a communication step into so many.
const MOST_EXPLICIT_STEPS: f64 = 1e4;

/// Memory of a fluid by cell: numbers in its precision, of which 8 are the state and 8 a copy of it; and bytes of what is in
/// both precisions the same, and of what rounding adds.
const NUMBERS_PER_CELL: usize = 27;
const BYTES_PER_CELL: usize = 44;

/// Memory that each beam takes by cell, bytes: the number of a candidate.
const BYTES_PER_BEAM_AND_CELL: usize = 4;

/// Numbers of a state by cell: velocity and vorticity of two times and two components of `w`, or less.
const STATE_NUMBERS_PER_CELL: usize = 8;

/// Memory of the stations and their loads by station, in the fluid and in a state, bytes.
const BYTES_PER_STATION: usize = 400;

/// [`crate::Fluid`] in one precision.
pub struct FluidIn<R: Real> {
    domain: Domain<R>,
    scheme: Scheme<R>,
    present: Present<R>,
    density: f64,
    max_step: f64,
    max_cfl: f64,
    /// The shortest step of its own that it may need, s.
    shortest_step: f64,
    /// The longest communication step, s.
    longest_step: f64,
    probes: Vec<Probe>,
    /// Where the beams are told to go.
    motion: Motion,
    /// Whether `domain.w[0]` is Pi at the present time.
    total_pressure_is_current: bool,
    /// The state before a communication step of several steps, for an error on the way; made when first needed.
    undo: Option<StateIn<R>>,
}

/// The ways of the beams' stations, and the pressure on both sides of them; every list is empty without a beam.
struct Motion {
    /// At the beginning of the communication step.
    from: Vec<Stations>,
    /// At the end of the present step, and then where they go on to in the coming communication step.
    now: Vec<Stations>,
    /// At the end of the coming communication step, set from outside.
    target: Vec<Stations>,
    /// Pressure jumps, Pa.
    pressure_jump: Vec<Vec<f64>>,
    /// Pressure around the beams, Pa, and where it is measured from; both absent where the scene does not want it.
    pressure: Vec<Vec<f64>>,
    outlet: Option<Outlet>,
    /// Whether both pressures are those of the present time: they are made when asked for.
    pressures_are_current: bool,
}

impl<R: Real> FluidIn<R> {
    /// The `fluid` of a scene at t = 0.
    pub fn new(scene: &Scene, fluid: &scene::Fluid) -> Self {
        let loads_are_wanted = scene.load().is_none_or(|load| load == Load::Momentum);
        let mut domain = Domain::new(scene, fluid);
        let stations: Vec<_> = scene.beams().map(|beam| Stations::at_rest(scene, beam)).collect();
        domain.bodies.place(0.0, &stations, &stations, &domain.grid);
        let [u, v] = fluid.initial_velocity;
        let present = Present {
            time: 0.0,
            step: 0.0,
            flow: Flow::uniform([u, v], domain.grid.len()),
            advection_rate: u.abs() / domain.grid.dx + v.abs() / domain.grid.dy,
            bodies: domain.bodies.without_force(&stations),
            beams: Beams {
                stations: stations.clone(),
                loads: stations.iter().filter(|_| loads_are_wanted).map(|s| Loads::none(s.len())).collect(),
                exchange: vec![Exchange::default(); stations.len()],
            },
        };
        let outlet = if scene.axial_pressure_strain() { Outlet::of(fluid, &domain.grid) } else { None };
        let zeros = |stations: &Stations| vec![0.0; stations.len()];
        let motion = Motion {
            pressure_jump: stations.iter().map(zeros).collect(),
            pressure: stations.iter().filter(|_| outlet.is_some()).map(zeros).collect(),
            outlet,
            pressures_are_current: false,
            now: stations.clone(),
            target: stations.clone(),
            from: stations,
        };
        let max_step = fluid.time_stepping.max_step;
        let usual_step = max_step.min(scene.time.communication_step);
        Self {
            scheme: Scheme::new(fluid.time_stepping.scheme, [u, v], &domain),
            density: fluid.density,
            max_step,
            max_cfl: fluid.time_stepping.max_cfl,
            shortest_step: usual_step / SHORTEST,
            longest_step: (LONGEST * scene.time.communication_step).min(MOST_STEPS * usual_step),
            probes: Probe::of(fluid, &domain.grid),
            total_pressure_is_current: false,
            undo: None,
            motion,
            present,
            domain,
        }
    }

    /// Memory that the `fluid` of a scene takes, about, bytes.
    pub fn bytes(scene: &Scene, fluid: &scene::Fluid) -> usize {
        let cells = fluid.r#box.cells.iter().product::<usize>();
        let beams = scene.beams().map(|beam| BYTES_PER_STATION * (beam.segments + 1) + BYTES_PER_BEAM_AND_CELL * cells);
        (NUMBERS_PER_CELL * size_of::<R>() + BYTES_PER_CELL) * cells + beams.sum::<usize>()
    }

    /// Memory that a state takes, about, bytes.
    pub fn state_bytes(&self) -> usize {
        let stations = self.stations().iter().map(Stations::len).sum::<usize>();
        STATE_NUMBERS_PER_CELL * size_of::<R>() * self.domain.grid.len() + BYTES_PER_STATION * stations
    }

    /// Start anew from a velocity field (m/s at a point in m), of which the divergence-free part is taken.
    pub fn set_velocity(&mut self, velocity: impl Fn(f64, f64) -> [f64; 2]) {
        let grid = &self.domain.grid;
        for i in 0..grid.nx {
            for j in 0..grid.ny {
                let [u, v] = velocity(grid.x(i), grid.y(j));
                self.domain.w[0][i * grid.ny + j] = R::rounded(u);
                self.domain.w[1][i * grid.ny + j] = R::rounded(v);
            }
        }
        self.total_pressure_is_current = false;
        self.scheme.start(&mut self.present, &mut self.domain);
    }

    /// Advance from `t` to `t + h` (s); the stations go from where they are to where they were set.
    ///
    /// The steps are equal, but those that are left are divided anew where the flow has become too fast for them on the
    /// way. Refuses what would take more than a hundred times as many as usual. An error leaves everything as it was;
    /// only after [`Error::Loads`] a state has to be put back.
    pub fn advance(&mut self, t: f64, h: f64) -> Result<(), Error> {
        self.domain.clock.start();
        let substeps = self.divide(t, h)?;
        Stations::copy_all(&mut self.motion.from, &self.present.beams.stations);
        // A single step changes nothing before it is known to be good.
        let several = substeps > 1.0;
        if several {
            self.save_for_undo()?;
        }
        self.total_pressure_is_current = false;
        if let Err(error) = Team::with(self.domain.spectral.threads(), |team| self.make_steps(team, substeps, t, h)) {
            if let Some(undo) = self.undo.as_ref().filter(|_| several) {
                self.present.copy_from(&undo.present);
                self.scheme.restore(&undo.memory);
            }
            let stations = &self.present.beams.stations;
            self.domain.bodies.place(self.present.time, stations, stations, &self.domain.grid);
            return Err(error);
        }
        self.motion.pressures_are_current = false;
        self.scheme.predict_loads(&mut self.present, &mut self.domain);
        self.domain.clock.mark(crate::clock::Phase::Loads);
        if !self.loads().iter().all(Loads::are_finite) {
            // The flow before is gone. With no rate there is no way on but a state put back.
            self.present.advection_rate = f64::NAN;
            return Err(Error::Loads { time: self.present.time });
        }
        Ok(())
    }

    /// Check a communication step, and find the number of steps that it takes.
    fn divide(&self, t: f64, h: f64) -> Result<f64, Error> {
        if !(t.is_finite() && h.is_finite() && h > 0.0) {
            return Err(Error::Step { time: t, step: h });
        }
        if h > self.longest_step {
            return Err(Error::Long { time: t, step: h, longest: self.longest_step });
        }
        self.check_stations(&self.motion.target)?;
        let (needed, shortest) = (self.max_cfl / self.present.advection_rate, self.shortest_step);
        if needed.is_nan() || needed < shortest {
            return Err(Error::Diverged { time: t, needed, shortest });
        }
        let mut largest = self.max_step.min(needed);
        if let Some(c_eta) = self.scheme.longest_step(&self.domain) {
            let substeps = (h / c_eta - 1e-9).ceil();
            if substeps > MOST_EXPLICIT_STEPS {
                return Err(Error::Stiff { time: t, step: h, c_eta, substeps, most: MOST_EXPLICIT_STEPS });
            }
            largest = largest.min(c_eta);
        }
        Ok((h / largest - 1e-9).ceil().max(1.0))
    }

    /// Make the steps of a communication step, at first so many.
    fn make_steps(&mut self, team: &Team, mut substeps: f64, t: f64, h: f64) -> Result<(), Error> {
        // The shares of `h` that are done, and that were done when what was left was last divided into `substeps`.
        let (mut done, mut divided, mut substep) = (0.0, 0.0, 0.0);
        let mut dt = h / substeps;
        while done < 1.0 {
            let rate = self.present.advection_rate;
            if substep > 0.0 && rate * dt > self.max_cfl {
                let left = h * (1.0 - done);
                (divided, substep, substeps) = (done, 0.0, (left * rate / self.max_cfl).ceil());
                dt = left / substeps;
            }
            substep += 1.0;
            done = if substep == substeps { 1.0 } else { divided + (1.0 - divided) * (substep / substeps) };
            let Motion { from, now, target, .. } = &mut self.motion;
            let (stations, ahead) = if done == 1.0 {
                now.iter_mut().zip(&*target).for_each(|(now, target)| now.go_on(target, h));
                (&*target, (!self.present.beams.loads.is_empty()).then_some(&**now))
            } else {
                now.iter_mut().zip(from.iter().zip(&*target)).for_each(|(now, (a, b))| now.interpolate(a, b, done, h));
                (&*now, None)
            };
            let (end, max_cfl, shortest) = (t + done * h, self.max_cfl, self.shortest_step);
            let step = Step { dt, end, stations, ahead, max_cfl, shortest, team };
            self.scheme.step(step, &mut self.present, &mut self.domain)?;
        }
        Ok(())
    }

    fn save_for_undo(&mut self) -> Result<(), Error> {
        match &mut self.undo {
            Some(undo) => {
                undo.present.copy_from(&self.present);
                self.scheme.save(&mut undo.memory);
            }
            None => {
                // Where memory runs out, Rust ends the process: it is asked for before.
                let (bytes, mut probe) = (self.state_bytes(), Vec::<u8>::new());
                probe.try_reserve_exact(bytes).map_err(|_| Error::Memory { bytes })?;
                drop(black_box(probe));
                self.undo = Some(self.state());
            }
        }
        Ok(())
    }

    fn check_stations(&self, beams: &[Stations]) -> Result<(), Error> {
        let name = |k| if beams.len() == 1 { "the beam".into() } else { format!("beam {}", k + 1) };
        beams.iter().enumerate().try_for_each(|(k, stations)| self.check_stations_of(&|| name(k), stations))
    }

    /// Check the stations of the beam that `name` gives the name of.
    fn check_stations_of(&self, name: &dyn Fn() -> String, stations: &Stations) -> Result<(), Error> {
        let Stations { position: [x, y], velocity: [vx, vy] } = stations;
        let far = |p: f64, middle: f64, size: f64| (p - middle).abs() > 1.5 * size;
        let grid = &self.domain.grid;
        let middle = [grid.x(grid.nx / 2), grid.y(grid.ny / 2)];
        for k in 0..x.len() {
            let finite = [x[k], y[k], vx[k], vy[k]].iter().all(|c| c.is_finite());
            if !finite || far(x[k], middle[0], grid.length) || far(y[k], middle[1], grid.height) {
                let (beam, station) = (name(), k + 1);
                return Err(Error::Station { beam, station, x: x[k], y: y[k], vx: vx[k], vy: vy[k] });
            }
            if k > 0 && x[k] == x[k - 1] && y[k] == y[k - 1] {
                return Err(Error::Coincide { beam: name(), station: k, x: x[k], y: y[k] });
            }
            let needed = self.max_cfl / (vx[k].abs() / grid.dx + vy[k].abs() / grid.dy);
            if needed < self.shortest_step {
                let (beam, station, shortest) = (name(), k + 1, self.shortest_step);
                return Err(Error::FastStation { beam, station, vx: vx[k], vy: vy[k], needed, shortest });
            }
        }
        Ok(())
    }

    /// A copy of everything that the next step depends on.
    pub fn state(&self) -> StateIn<R> {
        StateIn { present: self.present.clone(), memory: self.scheme.memory() }
    }

    /// Go back (or on) to a state of this scene; a state that is refused changes nothing.
    pub fn restore(&mut self, state: &StateIn<R>) -> Result<(), Error> {
        if let Some(part) = state.misfit(&self.present, self.scheme.fits(&state.memory)) {
            return Err(Error::State(part));
        }
        self.check_stations(&state.present.beams.stations)?;
        self.present.copy_from(&state.present);
        self.scheme.restore(&state.memory);
        Stations::copy_all(&mut self.motion.target, &state.present.beams.stations);
        self.motion.pressures_are_current = false;
        self.total_pressure_is_current = false;
        let stations = &self.present.beams.stations;
        self.domain.bodies.place(self.present.time, stations, stations, &self.domain.grid);
        Ok(())
    }

    /// The grid.
    pub fn grid(&self) -> &Grid {
        &self.domain.grid
    }

    /// Time, s.
    pub fn time(&self) -> f64 {
        self.present.time
    }

    /// Velocity component (0: x, 1: y), m/s, `[nx, ny]`.
    pub fn velocity(&self, axis: usize) -> Cow<'_, [f64]> {
        R::field_to_f64(&self.present.flow.velocity[axis])
    }

    /// Vorticity, 1/s, `[nx, ny]`.
    pub fn vorticity(&self) -> Cow<'_, [f64]> {
        R::field_to_f64(&self.present.flow.vorticity)
    }

    /// Static pressure p = rho (Pi − u²/2), Pa, `[nx, ny]`; Pi has zero mean over the box.
    pub fn pressure(&mut self) -> Vec<f64> {
        self.make_total_pressure();
        (0..self.domain.grid.len()).map(|point| self.density * self.pressure_at(point)).collect()
    }

    /// Static pressure over the density at a grid point, Pi − u²/2, m²/s²; Pi must be current.
    fn pressure_at(&self, point: usize) -> f64 {
        let [u, v] = self.present.flow.velocity.each_ref().map(|velocity| velocity[point].to_f64());
        self.domain.w[0][point].to_f64() - 0.5 * (u * u + v * v)
    }

    fn make_total_pressure(&mut self) {
        if !self.total_pressure_is_current {
            self.scheme.make_total_pressure(&self.present, &mut self.domain);
            self.total_pressure_is_current = true;
        }
    }

    /// Velocity at a probe, numbered from 0 as in the scene, m/s.
    pub fn probe_velocity(&self, probe: usize) -> [f64; 2] {
        self.present.flow.velocity.each_ref().map(|velocity| self.probes[probe].velocity(velocity))
    }

    /// Static pressure at a probe, Pa. The first after a step costs three transforms.
    pub fn probe_pressure(&mut self, probe: usize) -> f64 {
        self.make_total_pressure();
        self.density * self.probes[probe].pressure(|point| self.pressure_at(point))
    }

    /// Largest divergence of the velocity times the cell size over the largest speed; three transforms.
    pub fn divergence(&mut self) -> f64 {
        let velocity @ [u, v] = &self.present.flow.velocity;
        let divergence = &mut self.domain.w[1];
        self.domain.spectral.divergence(velocity, divergence);
        let largest = divergence.iter().fold(0.0_f64, |most, divergence| most.max(divergence.to_f64().abs()));
        let fastest = u.iter().zip(&**v).fold(0.0_f64, |most, (u, v)| most.max(u.to_f64().hypot(v.to_f64())));
        largest * self.domain.grid.cell_size() / fastest.max(f64::MIN_POSITIVE)
    }

    /// CFL number max(|u|/dx + |v|/dy) dt of the last step.
    pub fn cfl(&self) -> f64 {
        self.present.advection_rate * self.present.step
    }

    /// Flow rate through the column in the middle of the box, m²/s.
    pub fn flow_rate(&self) -> f64 {
        let Grid { nx, ny, dy, .. } = self.domain.grid;
        let column = &self.present.flow.velocity[0][nx / 2 * ny..(nx / 2 + 1) * ny];
        column.iter().map(|u| u.to_f64()).sum::<f64>() * dy
    }

    /// Kinetic energy of the whole box, J/m.
    pub fn kinetic_energy(&self) -> f64 {
        let [u, v] = &self.present.flow.velocity;
        let squares: f64 = u.iter().zip(&**v).map(|(u, v)| u.to_f64().powi(2) + v.to_f64().powi(2)).sum();
        0.5 * self.density * squares * self.domain.grid.cell_area()
    }

    /// Half the integral of the squared vorticity over the whole box, m²/s².
    pub fn enstrophy(&self) -> f64 {
        let squares: f64 = self.present.flow.vorticity.iter().map(|omega| omega.to_f64().powi(2)).sum();
        0.5 * squares * self.domain.grid.cell_area()
    }

    /// Force of the fluid on all bodies in the last step, N per metre of depth.
    pub fn force(&self) -> [f64; 2] {
        let sum = |axis: usize| self.present.bodies.iter().map(|body| body.force.force[axis]).sum();
        [sum(0), sum(1)]
    }

    /// Force of the fluid on a cylinder, numbered from 0, in the last step.
    pub fn force_on_cylinder(&self, cylinder: usize) -> Force {
        let count = self.domain.bodies.cylinders();
        assert!(cylinder < count, "there are {count} cylinders");
        self.present.bodies[cylinder].force
    }

    /// Force of the fluid on a body of `fluid.bodies`, numbered from 0, in the last step.
    pub fn force_on_body(&self, body: usize) -> Force {
        self.present.bodies[self.rigid(body)].force
    }

    /// Power of that force at the end of the step, W per metre of depth.
    pub fn power_on_body(&self, body: usize) -> f64 {
        let rigid = self.rigid(body);
        self.domain.bodies.power(rigid, &self.present.bodies[rigid].force)
    }

    /// Where a body of `fluid.bodies` is, and how it moves.
    pub fn pose(&self, body: usize) -> Pose {
        self.domain.bodies.pose(self.rigid(body))
    }

    /// Number of a body among all that are rigid, the cylinders being the first.
    fn rigid(&self, body: usize) -> usize {
        let (cylinders, all) = (self.domain.bodies.cylinders(), self.domain.bodies.rigid());
        assert!(body < all - cylinders, "there are {} bodies", all - cylinders);
        cylinders + body
    }

    /// Force of the fluid on a beam, numbered from 0, in the last step.
    pub fn force_on_beam(&self, beam: usize) -> Force {
        self.present.bodies[self.domain.bodies.rigid() + beam].force
    }

    /// What the fluid did to each beam, without the unsteady term of [`Self::force_on_beam`].
    pub fn exchange(&self) -> &[Exchange] {
        &self.present.beams.exchange
    }

    /// Loads on the stations of each beam for the coming step; empty where the scene uses the pressure jump.
    pub fn loads(&self) -> &[Loads] {
        &self.present.beams.loads
    }

    /// Stations of each beam at the end of the coming step.
    pub fn stations(&self) -> &[Stations] {
        &self.motion.target
    }

    /// Stations of each beam at the end of the coming step, to be set before [`Self::advance`].
    pub fn stations_mut(&mut self) -> &mut [Stations] {
        &mut self.motion.target
    }

    /// Pressure jump p_above − p_below at the stations of each beam, Pa; made when first asked for after a step.
    pub fn pressure_jump(&mut self) -> &[Vec<f64>] {
        self.make_surface_pressures();
        &self.motion.pressure_jump
    }

    /// Pressure around the stations of each beam, the mean of that above and below, less the mean over the outlet, Pa; made when
    /// first asked for after a step. Empty where the scene does not want its level.
    pub fn pressure_around(&mut self) -> &[Vec<f64>] {
        self.make_surface_pressures();
        &self.motion.pressure
    }

    fn make_surface_pressures(&mut self) {
        if self.motion.pressures_are_current || self.motion.pressure_jump.is_empty() {
            return;
        }
        self.make_total_pressure();
        // Taken out, so that the rest can be read while it is written.
        let (mut jumps, mut around) = (take(&mut self.motion.pressure_jump), take(&mut self.motion.pressure));
        let level = self.motion.outlet.as_ref().map_or(0.0, |outlet| outlet.mean(|point| self.pressure_at(point)));
        for (beam, jumps) in jumps.iter_mut().enumerate() {
            for (k, jump) in jumps.iter_mut().enumerate() {
                let [above, below] = [1.0, -1.0].map(|side| self.surface_pressure(beam, k, side));
                *jump = self.density * (above - below);
                if let Some(around) = around.get_mut(beam) {
                    around[k] = self.density * (0.5 * (above + below) - level);
                }
            }
        }
        (self.motion.pressure_jump, self.motion.pressure) = (jumps, around);
        self.motion.pressures_are_current = true;
    }

    /// Static pressure over the density at the surface of a beam above (1) or below (−1) its station `k`, m²/s².
    fn surface_pressure(&self, beam: usize, k: usize, side: f64) -> f64 {
        let point = self.domain.bodies.surface_point(beam, &self.present.beams.stations[beam], k, side);
        let around = self.domain.grid.interpolation(point);
        around.iter().map(|&(c, weight)| weight * self.pressure_at(c)).sum()
    }

    /// Times the phases of a step.
    #[cfg(feature = "internals")]
    pub fn clock(&mut self) -> &mut crate::clock::Clock {
        &mut self.domain.clock
    }
}
