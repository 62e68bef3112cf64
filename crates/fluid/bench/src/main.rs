//! How fast the fluid is beside FFTW in the same run, on one core.
//!
//! `fluid-bench FILE.csv` writes `table,scene,grid,what,value,unit`. `FFTW_LIBRARY` is the path of FFTW 3.
//!
//! What is compared takes turns, so that what else runs on the machine meets both, and the times are processor times of
//! the thread. A ratio is that of the shortest times; beside it stands the median of the ratios of neighbouring times.

mod fftw;
mod motion;
mod phases;

use std::fmt::Write;
use std::process::exit;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use fftw::Fftw;
use fluid::fft::Fft2;
use fluid::{Fluid, Phase, Stations};
use scene::{Scene, TimeLaw};

/// How long a row of a table is measured.
const TIME: Duration = Duration::from_millis(5000);

/// The last has factors for which there is no kernel: 646 = 2 · 17 · 19.
const SIZES: [[usize; 2]; 9] =
    [[325, 72], [320, 72], [650, 144], [640, 144], [900, 180], [1100, 220], [1300, 288], [1280, 288], [646, 144]];

/// Seconds that each of several things took, turn by turn.
pub struct Times<const N: usize>(Vec<[f64; N]>);

impl<const N: usize> Times<N> {
    /// Processor times of things that take turns.
    pub fn take(things: [&mut dyn FnMut(); N]) -> Self {
        Self::take_with(things, || {
            let start = ThreadTime::now();
            move || start.elapsed()
        })
    }

    /// Times by a clock that `start` starts.
    fn take_with<C: Fn() -> Duration>(mut things: [&mut dyn FnMut(); N], start: impl Fn() -> C) -> Self {
        let (begin, mut turns) = (Instant::now(), Vec::new());
        while begin.elapsed() < TIME || turns.len() < 20 {
            turns.push(things.each_mut().map(|thing| {
                // What the others left in the cache is not counted.
                thing();
                let elapsed = start();
                thing();
                elapsed().as_secs_f64()
            }));
        }
        Self(turns)
    }

    /// The shortest time of one of the things, s.
    pub fn shortest(&self, which: usize) -> f64 {
        self.0.iter().map(|turn| turn[which]).fold(f64::INFINITY, f64::min)
    }

    /// `a / b`: ratio of the shortest times, and the median of the turns' ratios.
    pub fn ratio(&self, a: usize, b: usize) -> [f64; 2] {
        let mut ratios: Vec<_> = self.0.iter().map(|turn| turn[a] / turn[b]).collect();
        ratios.sort_by(f64::total_cmp);
        [self.shortest(a) / self.shortest(b), ratios[ratios.len() / 2]]
    }
}

/// The file that is written.
pub struct Table(String);

impl Table {
    /// One number.
    pub fn row(&mut self, table: &str, scene: &str, [nx, ny]: [usize; 2], what: &str, value: f64, unit: &str) {
        writeln!(self.0, "{table},{scene},{nx} x {ny},\"{what}\",{value:.6},{unit}")
            .expect("a string takes everything");
        eprintln!("{table}, {scene}, {nx} x {ny}, {what}: {value:.3} {unit}");
    }

    /// A time in seconds, as microseconds.
    pub fn time(&mut self, table: &str, scene: &str, cells: [usize; 2], what: &str, seconds: f64) {
        self.row(table, scene, cells, what, 1e6 * seconds, "µs");
    }

    /// A ratio of shortest times, and its median over the turns.
    fn ratio(&mut self, table: &str, scene: &str, cells: [usize; 2], what: &str, [shortest, median]: [f64; 2]) {
        self.row(table, scene, cells, what, shortest, "1");
        self.row(table, scene, cells, &format!("{what}, median"), median, "1");
    }
}

/// Numbers between −0.5 and 0.5 without a pattern.
pub fn noise(c: usize) -> f64 {
    (c as f64 * 0.618_033_988_749_894_9).fract() - 0.5
}

/// One pair of transforms, forward and back.
fn pairs(fftw: &Fftw, table: &mut Table) {
    for [nx, ny] in SIZES {
        let theirs = fftw.plan(nx, ny);
        let field: Vec<_> = (0..nx * ny).map(noise).collect();
        let pair = |modes: usize| {
            let fft = Fft2::new(nx, ny, modes);
            let (mut spectrum, mut scratch) = (fft.spectrum(), fft.scratch());
            let (field, mut back) = (field.clone(), vec![0.0; nx * ny]);
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
        let times = Times::take([&mut whole, &mut other, &mut pruned]);
        for (which, what) in ["ours", "FFTW", "pruned"].into_iter().enumerate() {
            table.time("pair", "", [nx, ny], what, times.shortest(which));
        }
        table.ratio("pair", "", [nx, ny], "ours/FFTW", times.ratio(0, 1));
        table.ratio("pair", "", [nx, ny], "pruned/FFTW", times.ratio(2, 1));
    }
}

/// A flow of a shipped scene past its ramp, in which the bar, where there is one, swings about its place.
pub struct Flow {
    fluid: Fluid,
    /// Stations at rest, where there are some.
    rest: Option<Stations>,
    length: f64,
    step: f64,
    steps: u32,
}

impl Flow {
    /// A scene, and some steps of it.
    pub fn new(scene: &Scene, step: f64) -> Self {
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
        (0..100).for_each(|_| flow.step());
        flow
    }

    /// One step.
    pub fn step(&mut self) {
        self.step_marking(&mut |_| ());
    }

    /// One step, with a call at the end of each of its phases.
    pub fn step_marking(&mut self, mark: &mut impl FnMut(Phase)) {
        let omega = 30.0;
        let phase = omega * f64::from(self.steps + 1) * self.step;
        let amplitude = 0.086 * self.length;
        self.bend(|s| amplitude * s * s * phase.sin(), |s| amplitude * s * s * omega * phase.cos());
        self.advance(mark);
    }

    /// Put the bar off its rest: deflection (m) and velocity (m/s) over the share of the length.
    pub fn bend(&mut self, deflection: impl Fn(f64) -> f64, velocity: impl Fn(f64) -> f64) {
        let (Some(rest), Some(stations)) = (&self.rest, self.fluid.stations_mut()) else { return };
        let last = (rest.len() - 1) as f64;
        for k in 0..rest.len() {
            let s = k as f64 / last;
            stations.position[1][k] = rest.position[1][k] + deflection(s);
            stations.velocity[1][k] = velocity(s);
        }
    }

    /// Advance by a step with the bar where it was put.
    pub fn advance(&mut self, mark: &mut impl FnMut(Phase)) {
        let time = f64::from(self.steps) * self.step;
        self.steps += 1;
        self.fluid.advance_marking(time, self.step, mark).unwrap_or_else(|error| panic!("{error}"));
        let cfl = self.fluid.cfl();
        assert!(cfl < 0.4, "the step was divided: CFL number {cfl}");
    }
}

/// A shipped scene.
pub fn shipped(name: &str) -> Scene {
    let path = format!("{}/../../../scenes/{name}.json", env!("CARGO_MANIFEST_DIR"));
    Scene::from_file(path.as_ref()).unwrap_or_else(|error| panic!("{error}"))
}

/// A shipped scene with another grid.
fn scene(name: &str, cells: [usize; 2]) -> Scene {
    let mut scene = shipped(name);
    scene.fluid.as_mut().expect("the scene has a fluid").domain.cells = cells;
    scene
}

/// Grid of a scene.
pub fn cells(scene: &Scene) -> [usize; 2] {
    scene.fluid.as_ref().expect("the scene has a fluid").domain.cells
}

/// A step, beside FFTW's time for the five transforms that it has (two forward, three back).
fn steps(fftw: &Fftw, table: &mut Table) {
    let scenes = [
        ("fsi3-325x72", [325, 72], 2e-4),
        ("fsi3-325x72", [320, 72], 2e-4),
        ("fsi3-650x144", [650, 144], 1e-4),
        ("fsi3-650x144", [640, 144], 1e-4),
        ("cylinder-2d2-900x180", [900, 180], 1e-4),
        ("cylinder-2d2-900x180", [1100, 220], 1e-4),
    ];
    for (name, [nx, ny], step) in scenes {
        let mut flow = Flow::new(&scene(name, [nx, ny]), step);
        let theirs = fftw.plan(nx, ny);
        let mut five = || {
            (0..2).for_each(|_| theirs.forward());
            (0..3).for_each(|_| theirs.inverse());
        };
        let times = Times::take([&mut || flow.step(), &mut five]);
        table.time("step", name, [nx, ny], "step", times.shortest(0));
        table.time("step", name, [nx, ny], "five of FFTW", times.shortest(1));
        table.ratio("step", name, [nx, ny], "step/FFTW", times.ratio(0, 1));
    }
}

/// A step on one and on two threads: wall time, and processor time of the calling thread.
fn threads(table: &mut Table) {
    for (name, cells) in [("fsi3-650x144", [650, 144]), ("cylinder-2d2-900x180", [1100, 220])] {
        let [mut one, mut two] = [1, 2].map(|threads| {
            let mut scene = scene(name, cells);
            scene.fluid.as_mut().expect("the scene has a fluid").threads = threads;
            Flow::new(&scene, 1e-4)
        });
        let wall = Times::take_with([&mut || one.step(), &mut || two.step()], || {
            let start = Instant::now();
            move || start.elapsed()
        });
        let processor = Times::take([&mut || one.step(), &mut || two.step()]);
        assert!(one.fluid.state() == two.fluid.state(), "{name}: two threads give other bits than one");
        for (clock, times) in [("wall", wall), ("processor", processor)] {
            table.time("threads", name, cells, &format!("{clock}, one"), times.shortest(0));
            table.time("threads", name, cells, &format!("{clock}, two"), times.shortest(1));
            table.ratio("threads", name, cells, &format!("{clock}, one/two"), times.ratio(0, 1));
        }
    }
}

fn fail(message: &str) -> ! {
    eprintln!("{message}");
    exit(2)
}

fn main() {
    let Some(path) = std::env::args().nth(1) else { fail("give the file to write to") };
    let library = std::env::var("FFTW_LIBRARY").unwrap_or_else(|_| fail("FFTW_LIBRARY is not set"));
    let fftw = Fftw::load(&library).unwrap_or_else(|error| fail(&format!("cannot load FFTW: {error}")));
    let mut table = Table("table,scene,grid,what,value,unit\n".into());
    table.row("about", &fftw.version(), [0, 0], "FFTW, planned by measuring", 1.0, "1");
    pairs(&fftw, &mut table);
    steps(&fftw, &mut table);
    phases::measure(&mut table);
    motion::measure(&mut table);
    threads(&mut table);
    let new = format!("{path}.new");
    let written = std::fs::write(&new, &table.0).and_then(|()| std::fs::rename(&new, &path));
    written.unwrap_or_else(|error| fail(&format!("cannot write {path}: {error}")));
}
