//! Time stepping.
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

use std::sync::atomic::{AtomicU64, Ordering};

use scene::{InflowProfile, Load, Scene};
use serde::{Deserialize, Serialize};

use crate::beam::{Beam, Loads, Stations};
use crate::body::{Cell, Cells, Painted};
use crate::cylinder::Cylinder;
use crate::drag::DragProfile;
use crate::fft::{Fft2, Quad, Scratch, on_threads};
use crate::grid::Grid;
use crate::kernel::{self, Component, Differences};
use crate::projection::Projection;

/// Points that the local solve takes at a time, so that what both components read stays in the first cache.
const BLOCK: usize = 256;

/// More of the fluid's own steps than this in one communication step are taken for divergence.
const MAX_SUBSTEPS: f64 = 1e5;

/// Why the fluid refused or could not go on.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The scene has no fluid.
    #[error("the scene `{0}` has no fluid")]
    NoFluid(String),
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
    /// The flow one step earlier.
    flow_before: Flow,
    /// `w = u* + tau G` of the last step, m/s, `[nx, ny]` per component.
    w: [Vec<f64>; 2],
    /// `1/tau` of the last step, 1/s, so that `G = (w − u)/tau`; 0 before the first, where G is 0.
    per_tau: f64,
    /// The last step, s; 0 before the first.
    step: f64,
    /// Largest `|u|/dx + |v|/dy`, 1/s.
    advection_rate: f64,
    /// What the fluid does to the bodies, N/m.
    force: [f64; 2],
    /// Momentum of the fluid that the moving bodies displace, kg/s.
    displaced_momentum: [f64; 2],
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
}

/// Numbers that tell how the flow is doing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diagnostics {
    /// CFL number max(|u|/dx + |v|/dy) dt of the last step.
    pub cfl: f64,
    /// Flow rate through the column in the middle of the box, m²/s.
    pub flow_rate: f64,
    /// Kinetic energy of the whole box, J/m.
    pub kinetic_energy: f64,
}

/// A fluid with the bodies of a scene in it.
pub struct Fluid {
    grid: Grid,
    density: f64,
    nu: f64,
    max_step: f64,
    max_cfl: f64,
    profile: DragProfile,
    fft: Fft2,
    projection: Projection,
    inflow: Option<Inflow>,
    /// The reflecting layer of the walls; empty where they do not reflect.
    walls: Cells,
    cylinders: Vec<Cylinder>,
    beam: Option<MovingBeam>,
    /// Total drag rate Σ a_b, 1/s, `[nx, ny]`; absent where there is no body at all.
    rate: Option<Vec<f64>>,
    painted: Painted,
    /// `w` of the step that is being made, m/s.
    w: [Vec<f64>; 2],
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

/// The zone that drives the flow.
struct Inflow {
    law: scene::TimeLaw,
    /// Drag rate of the zone by column, 1/s, for the columns where it is above 0.
    columns: Vec<(usize, f64)>,
    /// Velocity over its mean, by row.
    shape: Vec<f64>,
}

impl Inflow {
    fn new(inflow: &scene::Inflow, fluid: &scene::Fluid, grid: &Grid) -> Self {
        let profile = DragProfile::new(&fluid.mask, inflow.c_eta, fluid.kinematic_viscosity, grid.cell_size());
        let [from, to] = inflow.x;
        let (center, half) = (0.5 * (from + to), 0.5 * (to - from));
        let columns = (0..grid.nx)
            .map(|i| (i, profile.rate(grid.periodic_x(grid.x(i) - center).abs() - half)))
            .filter(|(_, rate)| *rate > 0.0)
            .collect();
        let shape = match (inflow.profile, &fluid.channel) {
            (InflowProfile::Parabolic, Some(channel)) => {
                let [low, high] = channel.y;
                let parabola = |y: f64| 6.0 * (y - low) * (high - y) / (high - low).powi(2);
                (0..grid.ny).map(|j| parabola(grid.y(j)).max(0.0)).collect()
            }
            _ => vec![1.0; grid.ny],
        };
        Self { law: inflow.mean_velocity.clone(), columns, shape }
    }
}

impl State {
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

impl Fluid {
    /// The fluid of a scene at t = 0.
    pub fn new(scene: &Scene) -> Result<Self, Error> {
        let loads_are_wanted = scene.coupling.as_ref().is_none_or(|c| c.load == Load::Momentum);
        let fluid = scene.fluid.as_ref().ok_or_else(|| Error::NoFluid(scene.name.clone()))?;
        let grid = Grid::new(&fluid.domain);
        let nu = fluid.kinematic_viscosity;
        let profile = DragProfile::new(&fluid.mask, fluid.mask.c_eta(), nu, grid.cell_size());
        let inflow = fluid.inflow.as_ref().map(|inflow| Inflow::new(inflow, fluid, &grid));
        let cylinders: Vec<_> = fluid.cylinders.iter().map(|c| Cylinder::new(c, &grid, &profile)).collect();
        let beam = scene.beam.as_ref().map(|beam| {
            let stations = Stations::at_rest(scene, beam);
            MovingBeam {
                body: Beam::new(beam, &grid),
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
        let state = State {
            time: 0.0,
            flow_before: Flow { velocity: [field(), field()], vorticity: field() },
            flow: Flow { velocity: [vec![u; grid.len()], vec![v; grid.len()]], vorticity: field() },
            w: [field(), field()],
            per_tau: 0.0,
            step: 0.0,
            advection_rate: u.abs() / grid.dx + v.abs() / grid.dy,
            force: [0.0; 2],
            displaced_momentum: [0.0; 2],
            beam: beam.as_ref().map(|b| BeamState {
                stations: b.target.clone(),
                loads: loads_are_wanted.then(|| Loads::none(b.target.len())),
            }),
        };
        let has_bodies = inflow.is_some() || fluid.channel.is_some() || !cylinders.is_empty() || beam.is_some();
        let mut solver = Self {
            rate: has_bodies.then(field),
            w: [field(), field()],
            spectra: [fft.spectrum(), fft.spectrum(), fft.spectrum()],
            scratch: (0..fluid.threads).map(|_| fft.scratch()).collect(),
            density: fluid.density,
            max_step: fluid.time_stepping.max_step,
            max_cfl: fluid.time_stepping.max_cfl,
            painted: Painted::default(),
            grid,
            nu,
            profile,
            fft,
            inflow,
            walls: Cells::default(),
            cylinders,
            beam,
            projection,
            state,
        };
        solver.paint_still_bodies(fluid);
        solver.paint_moving_bodies();
        solver.state.displaced_momentum = solver.displaced_momentum();
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
        // In no time viscosity does nothing: what is left of the solve is the projection.
        self.solve_wave_by_wave(f64::MIN_POSITIVE);
    }

    /// Vorticity, 1/s, `[nx, ny]`.
    pub fn vorticity(&self) -> &[f64] {
        &self.state.flow.vorticity
    }

    /// Static pressure p = rho (Pi − u²/2), Pa, `[nx, ny]`; Pi has zero mean over the box.
    pub fn pressure(&mut self) -> Vec<f64> {
        let mut pressure = vec![0.0; self.grid.len()];
        self.total_pressure(&mut pressure);
        let [u, v] = &self.state.flow.velocity;
        for ((p, u), v) in pressure.iter_mut().zip(u).zip(v) {
            *p = self.density * (*p - 0.5 * (u * u + v * v));
        }
        pressure
    }

    /// Force of the fluid on all cylinders and the beam in the last step, N per metre of depth.
    pub fn force(&self) -> [f64; 2] {
        self.state.force
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

    /// How the flow is doing.
    pub fn diagnostics(&self) -> Diagnostics {
        let [u, v] = &self.state.flow.velocity;
        let ny = self.grid.ny;
        let middle = self.grid.nx / 2;
        let squares: f64 = u.iter().zip(v).map(|(u, v)| u * u + v * v).sum();
        Diagnostics {
            cfl: self.state.advection_rate * self.state.step,
            flow_rate: u[middle * ny..(middle + 1) * ny].iter().sum::<f64>() * self.grid.dy,
            kinetic_energy: 0.5 * self.density * squares * self.grid.cell_area(),
        }
    }

    /// Everything the next step depends on.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Go back (or on) to a state of this scene.
    pub fn restore(&mut self, state: &State) {
        self.state.clone_from(state);
        if let (Some(beam), Some(known)) = (&mut self.beam, &state.beam) {
            beam.target.copy_from(&known.stations);
            beam.pressure_jump_is_current = false;
        }
        self.paint_moving_bodies();
    }

    /// Advance from `t` to `t + h` (s) in equal steps; the stations go from where they are to where they were set.
    ///
    /// What is refused leaves the state as it was; after [`Error::Diverged`] only [`Self::restore`] helps.
    pub fn advance(&mut self, t: f64, h: f64) -> Result<(), Error> {
        if !(t.is_finite() && h.is_finite() && h > 0.0) {
            return Err(Error::Step { time: t, step: h });
        }
        self.check_stations()?;
        let largest = self.max_step.min(self.max_cfl / self.state.advection_rate.max(f64::MIN_POSITIVE));
        let substeps = (h / largest - 1e-9).ceil().max(1.0);
        if substeps > MAX_SUBSTEPS {
            let cfl = self.state.advection_rate * h;
            return Err(Error::Diverged { time: t, cfl, step: h });
        }
        if let (Some(beam), Some(known)) = (&mut self.beam, &self.state.beam) {
            beam.from.copy_from(&known.stations);
        }
        let substeps = substeps as u32;
        let dt = h / f64::from(substeps);
        for substep in 1..=substeps {
            let fraction = f64::from(substep) / f64::from(substeps);
            if let (Some(beam), Some(known)) = (&self.beam, &mut self.state.beam) {
                if substep == substeps {
                    known.stations.copy_from(&beam.target);
                } else {
                    known.stations.interpolate(&beam.from, &beam.target, fraction, h);
                }
            }
            self.step(dt, t + fraction * h)?;
        }
        self.reflect();
        self.predict_loads();
        Ok(())
    }

    /// Pressure jump p_above − p_below at the stations, Pa; made when first asked for after a step.
    pub fn pressure_jump(&mut self) -> Option<&[f64]> {
        self.beam.as_ref()?;
        if self.beam.as_ref().is_some_and(|beam| !beam.pressure_jump_is_current) {
            // Between steps the array of the coming w is free.
            let mut total = std::mem::take(&mut self.w[0]);
            self.total_pressure(&mut total);
            let (grid, [u, v]) = (&self.grid, &self.state.flow.velocity);
            if let (Some(beam), Some(known)) = (&mut self.beam, &self.state.beam) {
                for k in 0..known.stations.len() {
                    let at = |side: f64| -> f64 {
                        let point = beam.body.surface_point(&known.stations, k, side);
                        let value = |c: usize| total[c] - 0.5 * (u[c] * u[c] + v[c] * v[c]);
                        grid.interpolation(point).iter().map(|&(c, weight)| weight * value(c)).sum()
                    };
                    beam.pressure_jump[k] = self.density * (at(1.0) - at(-1.0));
                }
                beam.pressure_jump_is_current = true;
            }
            self.w[0] = total;
        }
        self.beam.as_ref().map(|beam| beam.pressure_jump.as_slice())
    }

    /// Pi as a field: what made w free of divergence in the last step.
    fn total_pressure(&mut self, field: &mut [f64]) {
        let [wx_hat, wy_hat, pressure] = &mut self.spectra;
        let scratch = &mut self.scratch[0];
        self.fft.forward(&self.state.w[0], wx_hat, scratch);
        self.fft.forward(&self.state.w[1], wy_hat, scratch);
        self.projection.pressure(wx_hat, wy_hat, self.state.per_tau, pressure);
        self.fft.inverse(pressure, field, scratch);
    }

    fn check_stations(&self) -> Result<(), Error> {
        let Some(beam) = &self.beam else { return Ok(()) };
        let Stations { position: [x, y], velocity: [vx, vy] } = &beam.target;
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

    fn paint_still_bodies(&mut self, fluid: &scene::Fluid) {
        let Some(rate) = &mut self.rate else { return };
        let grid = &self.grid;
        if let Some(channel) = &fluid.channel {
            let [low, high] = channel.y;
            for j in 0..grid.ny {
                let distance = 0.5 * (high - low) - grid.periodic_y(grid.y(j) - 0.5 * (low + high)).abs();
                let wall = self.profile.rate(distance);
                (0..grid.nx).for_each(|i| rate[i * grid.ny + j] += wall);
                let thickness = grid.height - (high - low);
                let weight = self.profile.reflection(thickness).map_or(0.0, |reflection| reflection.weight(distance));
                if weight > 0.0 {
                    let inwards = -grid.periodic_y(grid.y(j) - 0.5 * (low + high)).signum();
                    for i in 0..grid.nx {
                        self.walls.push(i * grid.ny + j, wall, [0.0; 2]);
                        let image = [grid.x(i), grid.y(j) - 2.0 * distance * inwards];
                        self.walls.reflect_last(weight, image, grid);
                    }
                }
            }
        }
        if let Some(inflow) = &self.inflow {
            for &(i, zone) in &inflow.columns {
                rate[i * grid.ny..(i + 1) * grid.ny].iter_mut().for_each(|r| *r += zone);
            }
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
            cylinder.place(self.state.time, &self.grid, &self.profile);
            self.painted.add(&cylinder.cells, rate);
        }
        if let (Some(beam), Some(known)) = (&mut self.beam, &self.state.beam) {
            beam.body.place(&known.stations, &self.grid, &self.profile);
            self.painted.add(&beam.body.cells, rate);
        }
    }

    /// One step of size `dt` to the time `end`; the stations are already there.
    fn step(&mut self, dt: f64, end: f64) -> Result<(), Error> {
        let scheme = Differences::new(dt, self.state.step);
        self.state.time = end;
        self.paint_moving_bodies();
        self.reflect();
        self.solve_locally(&scheme);
        self.add_body_velocities(&scheme);
        let (drag, momentum) = (self.drag_on_bodies(&scheme), self.displaced_momentum());
        for axis in 0..2 {
            self.state.force[axis] = drag[axis] + (momentum[axis] - self.state.displaced_momentum[axis]) / dt;
        }
        self.state.displaced_momentum = momentum;
        self.solve_wave_by_wave(scheme.tau);
        std::mem::swap(&mut self.state.w, &mut self.w);
        (self.state.step, self.state.per_tau) = (dt, scheme.c[0]);
        if let Some(beam) = &mut self.beam {
            beam.pressure_jump_is_current = false;
        }
        let cfl = self.state.advection_rate * dt;
        if cfl.is_finite() { Ok(()) } else { Err(Error::Diverged { time: end, cfl, step: dt }) }
    }

    /// Let the bodies that reflect look at the present flow.
    fn reflect(&mut self) {
        let flow = &self.state.flow.velocity;
        self.walls.reflect(flow);
        self.cylinders.iter_mut().for_each(|cylinder| cylinder.cells.reflect(flow));
        if let Some(beam) = &mut self.beam {
            beam.body.cells.reflect(flow);
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

    /// The bodies' part of u*: `Σ a_b u_b / (c_0 + Σ a_b)`.
    fn add_body_velocities(&mut self, scheme: &Differences) {
        let Some(rate) = &self.rate else { return };
        let ny = self.grid.ny;
        if let Some(Inflow { law, columns, shape }) = &self.inflow {
            let mean = law.value(self.state.time);
            for &(i, zone) in columns {
                for (j, shape) in shape.iter().enumerate() {
                    let index = i * ny + j;
                    self.w[0][index] += zone * mean * shape / (scheme.c[0] + rate[index]);
                }
            }
        }
        let cylinders = self.cylinders.iter().filter(|c| c.moves() || c.cells.reflects()).map(|c| &c.cells);
        let beam = self.beam.iter().map(|b| &b.body.cells);
        for cell in cylinders.chain(beam).chain([&self.walls]).flat_map(Cells::iter) {
            let weight = cell.rate / (scheme.c[0] + rate[cell.index]);
            self.w[0][cell.index] += weight * cell.velocity[0];
            self.w[1][cell.index] += weight * cell.velocity[1];
        }
    }

    /// Drag of the fluid on the cylinders and the beam in this step, `rho ∫ Σ a_b (u* − u_b) dV`, N/m.
    fn drag_on_bodies(&self, scheme: &Differences) -> [f64; 2] {
        let weight = self.density * self.grid.cell_area();
        let bodies = self.cylinders.iter().map(|c| &c.cells).chain(self.beam.iter().map(|b| &b.body.cells));
        let mut sum = [0.0; 2];
        for cell in bodies.flat_map(Cells::iter) {
            for (axis, sum) in sum.iter_mut().enumerate() {
                let (_, g) = self.state.component(axis).right_side(scheme, cell.index);
                let u_star = self.w[axis][cell.index] - scheme.tau * g;
                *sum += weight * cell.rate * (u_star - cell.velocity[axis]);
            }
        }
        sum
    }

    /// Momentum that the fluid displaced by the moving bodies would have, kg/s per metre of depth.
    ///
    /// The penalization force lacks its rate of change (thesis eq. 3.20). It is taken over the true section, so that
    /// neither the mask's width nor its way through the grid enters.
    fn displaced_momentum(&self) -> [f64; 2] {
        let mut momentum = [0.0; 2];
        let mut add = |mass: f64, velocity: [f64; 2]| {
            momentum[0] += mass * velocity[0];
            momentum[1] += mass * velocity[1];
        };
        for cylinder in self.cylinders.iter().filter(|c| c.moves()) {
            add(cylinder.displaced_mass(self.density), cylinder.velocity);
        }
        if let (Some(beam), Some(known)) = (&self.beam, &self.state.beam) {
            add(self.density * beam.body.thickness(), known.stations.velocity_integral());
        }
        momentum
    }

    /// From w to the flow at the new time.
    ///
    /// Between the two passes along y, each row of modes goes through both transforms along x and the projection while
    /// it is in the cache.
    fn solve_wave_by_wave(&mut self, tau: f64) {
        let State { flow, flow_before, advection_rate, .. } = &mut self.state;
        std::mem::swap(flow, flow_before);
        let [u_hat, v_hat, omega_hat] = &mut self.spectra;
        let (fft, nx, ny) = (&self.fft, self.grid.nx, self.grid.ny);
        fft.forward_along_y([&self.w[0], &self.w[1]], [&mut *u_hat, &mut *v_hat], &mut self.scratch);

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
    }

    /// Loads on the stations in the coming step of the same size, were the stations to keep their velocities.
    fn predict_loads(&mut self) {
        let (Some(beam), Some(rate)) = (&self.beam, &self.rate) else { return };
        let Some(mut loads) = self.state.beam.as_mut().and_then(|known| known.loads.take()) else { return };
        let scheme = Differences::new(self.state.step, self.state.step);
        let components = [0, 1].map(|axis| self.state.component(axis));
        let weight = self.density * self.grid.cell_area();
        let drag = |cell: &Cell| {
            let share = cell.rate / (scheme.c[0] + rate[cell.index]);
            // a_b (u* − u_b) with u* = (r + a_b u_b)/(c_0 + Σ a).
            let force = [0, 1].map(|axis| {
                let (r, _) = components[axis].right_side(&scheme, cell.index);
                let momentum = cell.rate * cell.velocity[axis];
                weight * (share * (r + momentum) - momentum)
            });
            (force, weight * cell.rate * cell.gain * (1.0 - share))
        };
        beam.body.collect(drag, &mut loads);
        if let Some(known) = &mut self.state.beam {
            known.loads = Some(loads);
        }
    }
}
