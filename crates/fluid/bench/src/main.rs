//! How fast the fluid is: its transforms beside FFTW and rustfft, its step and the phases of it, on one core.
//!
//! `fluid-bench FILE.csv` writes `table,scene,grid,what,value,unit`. `FFTW_LIBRARY` is the path of FFTW 3.
//!
//! What is compared takes turns, so that what else runs on the machine meets all, and the times are processor times of
//! the thread. A ratio is that of the shortest times; beside it stands the median of the ratios of neighbouring times.

mod fftw;
mod rows;

use std::fmt::Write;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use fftw::Fftw;
use nervure_fluid::internals::{Fft2, Phase, Projection};
use nervure_fluid::{Fluid, Grid, Stations};
use rows::RustFft;
use scene::{Scene, TimeLaw};

/// How long a row of a table is measured.
const TIME: Duration = Duration::from_millis(3000);

/// The grids of the shipped scenes, some beside them that suit FFTW better, and one with factors for which there is no
/// kernel: 646 = 2 · 17 · 19.
const SIZES: [[usize; 2]; 14] = [
    [325, 72],
    [650, 144],
    [960, 216],
    [1300, 288],
    [450, 90],
    [900, 180],
    [384, 192],
    [288, 256],
    [320, 240],
    [320, 72],
    [640, 144],
    [1280, 288],
    [1100, 220],
    [646, 144],
];

/// A scene and its step, s.
const SCENES: [(&str, f64); 5] = [
    ("fsi3-325x72", 2e-4),
    ("fsi3-650x144", 1e-4),
    ("fsi3-1300x288", 5e-5),
    ("cylinder-2d2-900x180", 1e-4),
    ("vein-forward-384x192", 5e-4),
];

/// Names of [`Phase`]s, in their order.
const PHASES: [&str; 9] = [
    "painting of the moving bodies",
    "wall target",
    "local solve",
    "velocities of bodies and zones",
    "transforms, two along y",
    "transforms along x and projection",
    "transforms, three back along y, and the CFL number",
    "forces on the bodies",
    "loads and impedance of the stations",
];

/// How far the bar jumps from step to step, cells; a body that goes with the flow moves by at most the CFL number.
const JUMPS: [f64; 6] = [0.0, 0.01, 0.03, 0.1, 0.3, 1.0];

fn processor_time() -> f64 {
    ThreadTime::now().as_duration().as_secs_f64()
}

fn wall_time() -> f64 {
    static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64()
}

/// Seconds that each of several things took, turn by turn.
struct Times<const N: usize>(Vec<[f64; N]>);

impl<const N: usize> Times<N> {
    fn take(mut things: [&mut dyn FnMut(); N], clock: fn() -> f64) -> Self {
        let (begin, mut turns) = (Instant::now(), Vec::new());
        while begin.elapsed() < TIME || turns.len() < 20 {
            turns.push(things.each_mut().map(|thing| {
                // What the others left in the cache is not counted.
                thing();
                let start = clock();
                thing();
                clock() - start
            }));
        }
        Self(turns)
    }

    fn shortest(&self, which: usize) -> f64 {
        self.0.iter().map(|turn| turn[which]).fold(f64::INFINITY, f64::min)
    }
}

/// The file that is written, the part of it that is being measured, and the grid.
struct Table {
    text: String,
    part: String,
    cells: [usize; 2],
}

impl Table {
    fn begin(&mut self, table: &str, scene: &str, cells: [usize; 2]) {
        (self.part, self.cells) = (format!("{table},{scene}"), cells);
    }

    fn row(&mut self, what: &str, value: f64, unit: &str) {
        let (part, [nx, ny]) = (&self.part, self.cells);
        let line = format!("{part},{nx} x {ny},\"{what}\",{value:.6},{unit}");
        eprintln!("{line}");
        writeln!(self.text, "{line}").expect("a string takes everything");
    }

    fn time(&mut self, what: &str, seconds: f64) {
        self.row(what, 1e6 * seconds, "µs");
    }

    /// `a / b`: ratio of the shortest times, and the median of the turns' ratios.
    fn ratio<const N: usize>(&mut self, what: &str, times: &Times<N>, a: usize, b: usize) {
        let mut ratios: Vec<_> = times.0.iter().map(|turn| turn[a] / turn[b]).collect();
        ratios.sort_by(f64::total_cmp);
        self.row(what, times.shortest(a) / times.shortest(b), "1");
        self.row(&format!("{what}, median"), ratios[ratios.len() / 2], "1");
    }
}

/// A field of numbers between −0.5 and 0.5 without a pattern.
fn noise(n: usize) -> Vec<f64> {
    (0..n).map(|c| (c as f64 * 0.618_033_988_749_894_9).fract() - 0.5).collect()
}

/// One pair of transforms, forward and back.
fn pairs(fftw: &Fftw, table: &mut Table) {
    for [nx, ny] in SIZES {
        table.begin("pair", "", [nx, ny]);
        let (theirs, mut rust) = (fftw.plan(nx, ny), RustFft::new(nx, ny));
        let pair = |modes: usize| {
            let fft = Fft2::new(nx, ny, modes);
            let (mut spectrum, mut scratch) = (fft.spectrum(), fft.scratch());
            let (field, mut back) = (noise(nx * ny), vec![0.0; nx * ny]);
            move || {
                fft.forward(&field, &mut spectrum, &mut scratch);
                fft.inverse(&mut spectrum, &mut back, &mut scratch);
            }
        };
        let (mut whole, mut pruned) = (pair(ny / 2 + 1), pair(ny / 3 + 1));
        let mut other = || {
            theirs.forward();
            theirs.inverse();
        };
        let times = Times::take([&mut whole, &mut other, &mut pruned, &mut || rust.pair()], processor_time);
        for (which, what) in ["ours", "FFTW", "pruned", "rustfft"].into_iter().enumerate() {
            table.time(what, times.shortest(which));
        }
        table.ratio("ours/FFTW", &times, 0, 1);
        table.ratio("pruned/FFTW", &times, 2, 1);
        table.ratio("ours/rustfft", &times, 0, 3);
    }
}

/// A flow of a shipped scene past its ramp, in which the bar, where there is one, swings about its place.
struct Flow {
    fluid: Fluid,
    /// Stations at rest, where there are some.
    rest: Option<Stations>,
    length: f64,
    step: f64,
    steps: u32,
}

impl Flow {
    /// A scene, and some steps of it.
    fn new(scene: &Scene, step: f64) -> Self {
        let mut scene = scene.clone();
        let fluid = scene.fluid.as_mut().expect("the scene has a fluid");
        if let Some(inflow) = &mut fluid.inflow
            && let TimeLaw::CosineRamp { value, .. } = inflow.mean_velocity
        {
            inflow.mean_velocity = TimeLaw::Steady(value);
        }
        let fluid = Fluid::new(&scene).unwrap_or_else(|error| panic!("{error}"));
        let (rest, length) = (fluid.stations().cloned(), scene.beam.as_ref().map_or(0.0, |beam| beam.length));
        let mut flow = Self { fluid, rest, length, step, steps: 0 };
        (0..100).for_each(|_| flow.swing());
        flow
    }

    /// One step of the swing.
    fn swing(&mut self) {
        let omega = 30.0;
        let phase = omega * f64::from(self.steps + 1) * self.step;
        let amplitude = 0.086 * self.length;
        self.advance(|s| amplitude * s * s * phase.sin(), |s| amplitude * s * s * omega * phase.cos());
    }

    /// One step to a deflection (m) and a velocity (m/s) of the bar over the share of its length.
    fn advance(&mut self, deflection: impl Fn(f64) -> f64, velocity: impl Fn(f64) -> f64) {
        if let (Some(rest), Some(stations)) = (&self.rest, self.fluid.stations_mut()) {
            let last = (rest.len() - 1) as f64;
            for k in 0..rest.len() {
                let s = k as f64 / last;
                stations.position[1][k] = rest.position[1][k] + deflection(s);
                stations.velocity[1][k] = velocity(s);
            }
        }
        self.fluid.advance(f64::from(self.steps) * self.step, self.step).unwrap_or_else(|error| panic!("{error}"));
        self.steps += 1;
        let cfl = self.fluid.cfl();
        assert!(cfl < 0.4, "the step was divided: CFL number {cfl}");
    }
}

/// A shipped scene, on its own or another grid, and the grid.
fn scene(name: &str, cells: Option<[usize; 2]>) -> (Scene, [usize; 2]) {
    let path = format!("{}/../../../scenes/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let mut scene = Scene::from_file(path.as_ref()).unwrap_or_else(|error| panic!("{error}"));
    let domain = &mut scene.fluid.as_mut().expect("the scene has a fluid").domain;
    domain.cells = cells.unwrap_or(domain.cells);
    let cells = domain.cells;
    (scene, cells)
}

/// A step, beside FFTW's time for the five transforms that it has (two forward, three back).
fn steps(fftw: &Fftw, table: &mut Table) {
    let grids = [[[325, 72], [320, 72]], [[650, 144], [640, 144]], [[900, 180], [1100, 220]]];
    for ((name, step), grids) in [SCENES[0], SCENES[1], SCENES[3]].into_iter().zip(grids) {
        for [nx, ny] in grids {
            table.begin("step", name, [nx, ny]);
            let mut flow = Flow::new(&scene(name, Some([nx, ny])).0, step);
            let theirs = fftw.plan(nx, ny);
            let mut five = || {
                (0..2).for_each(|_| theirs.forward());
                (0..3).for_each(|_| theirs.inverse());
            };
            let times = Times::take([&mut || flow.swing(), &mut five], processor_time);
            table.time("step", times.shortest(0));
            table.time("five of FFTW", times.shortest(1));
            table.ratio("step/FFTW", &times, 0, 1);
        }
    }
}

/// Processor times of the phases of a step and of the whole step, s: means over the fastest quarter of the steps, so
/// that the phases add up and what else runs on the machine counts little.
fn phases_of(flow: &mut Flow, mut step: impl FnMut(&mut Flow)) -> ([f64; PHASES.len()], f64) {
    flow.fluid.clock().now = Some(processor_time);
    let (begin, mut steps) = (Instant::now(), Vec::new());
    while begin.elapsed() < TIME || steps.len() < 20 {
        flow.fluid.clock().spent = [0.0; PHASES.len()];
        let start = processor_time();
        step(flow);
        steps.push((flow.fluid.clock().spent, processor_time() - start));
    }
    steps.sort_by(|(_, a), (_, b)| a.total_cmp(b));
    steps.truncate(steps.len().div_ceil(4));
    let mean =
        |value: &dyn Fn(&([f64; PHASES.len()], f64)) -> f64| steps.iter().map(value).sum::<f64>() / steps.len() as f64;
    (std::array::from_fn(|phase| mean(&|step| step.0[phase])), mean(&|step| step.1))
}

/// What the projection takes, s: row by row in the cache, as it does between the transforms along x.
fn projection(scene: &Scene) -> f64 {
    let fluid = scene.fluid.as_ref().expect("the scene has a fluid");
    let grid = Grid::new(&fluid.domain);
    let mut projection = Projection::new(&grid, fluid.filter);
    projection.set_viscosity(1e-8);
    let fft = Fft2::new(grid.nx, grid.ny, projection.modes());
    let (mut scratch, rows) = (fft.scratch(), fft.spectrum().len() / grid.nx);
    let [u, v, omega] = &mut scratch.rows;
    let mut all = || (0..rows).for_each(|row| projection.project(row, u, v, omega));
    Times::take([&mut all], processor_time).shortest(0)
}

/// The phases of a step, the bars swinging.
fn phases(table: &mut Table) {
    for (name, step) in SCENES {
        let (scene, cells) = scene(name, None);
        table.begin("phases", name, cells);
        let (spent, whole) = phases_of(&mut Flow::new(&scene, step), Flow::swing);
        let projection = projection(&scene);
        for (phase, (what, seconds)) in PHASES.into_iter().zip(spent).enumerate() {
            if phase == Phase::Rows as usize {
                table.time("transforms, five along x", seconds - projection);
                table.time("projection", projection);
            } else {
                table.time(what, seconds);
            }
        }
        table.time("rest", whole - spent.iter().sum::<f64>());
        table.time("step", whole);
    }
}

/// What the bar costs and the whole step, with the bar jumping to and fro by a part of a cell; its velocity is 0: the
/// cost of a place is asked for, not a flow.
fn motion(table: &mut Table) {
    for (name, step) in [SCENES[0], SCENES[1]] {
        let (scene, cells) = scene(name, None);
        table.begin("motion", name, cells);
        for jump in JUMPS {
            let mut flow = Flow::new(&scene, step);
            let mut off = 0.5 * jump * flow.fluid.grid().dy;
            let (spent, whole) = phases_of(&mut flow, |flow| {
                off = -off;
                flow.advance(|_| off, |_| 0.0);
            });
            let of_the_bar =
                [Phase::Paint, Phase::Sample, Phase::Forces, Phase::Loads].map(|phase| spent[phase as usize]);
            table.time(&format!("{jump} cells, bar"), of_the_bar.iter().sum());
            table.time(&format!("{jump} cells, step"), whole);
        }
    }
}

/// A step on one and on two threads: wall time, and processor time of the calling thread.
fn threads(table: &mut Table) {
    for (name, cells) in [("fsi3-650x144", [650, 144]), ("cylinder-2d2-900x180", [1100, 220])] {
        table.begin("threads", name, cells);
        let [mut one, mut two] = [1, 2].map(|threads| {
            let (mut scene, _) = scene(name, Some(cells));
            scene.fluid.as_mut().expect("the scene has a fluid").threads = threads;
            Flow::new(&scene, 1e-4)
        });
        for (name, clock) in [("wall", wall_time as fn() -> f64), ("processor", processor_time)] {
            let times = Times::take([&mut || one.swing(), &mut || two.swing()], clock);
            table.time(&format!("{name}, one"), times.shortest(0));
            table.time(&format!("{name}, two"), times.shortest(1));
            table.ratio(&format!("{name}, one/two"), &times, 0, 1);
        }
        assert!(one.fluid.state() == two.fluid.state(), "{name}: two threads give other bits than one");
    }
}

fn main() -> Result<(), String> {
    let path = std::env::args().nth(1).ok_or("give the file to write to")?;
    let library = std::env::var("FFTW_LIBRARY").map_err(|error| format!("FFTW_LIBRARY: {error}"))?;
    let fftw = Fftw::load(&library).map_err(|error| format!("cannot load FFTW: {error}"))?;
    let mut table = Table { text: "table,scene,grid,what,value,unit\n".into(), part: String::new(), cells: [0, 0] };
    table.begin("about", &fftw.version(), [0, 0]);
    table.row("FFTW, planned by measuring", 1.0, "1");
    pairs(&fftw, &mut table);
    steps(&fftw, &mut table);
    phases(&mut table);
    motion(&mut table);
    threads(&mut table);
    std::fs::write(&path, table.text).map_err(|error| format!("cannot write {path}: {error}"))
}
