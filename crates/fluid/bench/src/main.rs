//! How fast the fluid is beside FFTW in the same run, on one core.
//!
//! `fluid-bench FILE.md` replaces what follows the line `## Measured` of the file. `FFTW_LIBRARY` is the path of FFTW 3.
//!
//! What is compared takes turns, so that what else runs on the machine meets both, and the times are processor times of
//! the thread. A ratio is that of the shortest times; in brackets the median of the ratios of neighbouring times.

mod fftw;
mod phases;

use std::fmt::Write;
use std::process::exit;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use fftw::Fftw;
use fluid::Fluid;
use fluid::fft::Fft2;
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

    /// `a / b`: ratio of the shortest times, and in brackets the median of the turns' ratios.
    pub fn ratio(&self, a: usize, b: usize) -> String {
        let mut ratios: Vec<_> = self.0.iter().map(|turn| turn[a] / turn[b]).collect();
        ratios.sort_by(f64::total_cmp);
        format!("{:.2} ({:.2})", self.shortest(a) / self.shortest(b), ratios[ratios.len() / 2])
    }
}

/// Numbers between −0.5 and 0.5 without a pattern.
pub fn noise(c: usize) -> f64 {
    (c as f64 * 0.618_033_988_749_894_9).fract() - 0.5
}

/// Microseconds.
pub fn us(seconds: f64) -> String {
    format!("{:.0}", 1e6 * seconds)
}

fn pairs(fftw: &Fftw, text: &mut String) -> std::fmt::Result {
    writeln!(text, "One pair of transforms, forward and back, µs:\n")?;
    writeln!(text, "| grid | FFTW | ours | ours/FFTW | without the upper third of the modes in y | that/FFTW |")?;
    writeln!(text, "|---|---|---|---|---|---|")?;
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
        let [ours, theirs, pruned] = [0, 1, 2].map(|which| us(times.shortest(which)));
        let (ratio, pruned_ratio) = (times.ratio(0, 1), times.ratio(2, 1));
        writeln!(text, "| {nx}x{ny} | {theirs} | {ours} | {ratio} | {pruned} | {pruned_ratio} |")?;
    }
    Ok(())
}

/// A flow of a shipped scene past its ramp, in which the bar, where there is one, swings.
pub struct Flow {
    fluid: Fluid,
    step: f64,
    steps: u32,
}

impl Flow {
    /// A scene on a grid, and some steps of it.
    pub fn new(scene: &Scene, step: f64) -> Self {
        let mut scene = scene.clone();
        let fluid = scene.fluid.as_mut().expect("the scene has a fluid");
        let inflow = fluid.inflow.as_mut().expect("the fluid has an inflow");
        if let TimeLaw::CosineRamp { value, .. } = inflow.mean_velocity {
            inflow.mean_velocity = TimeLaw::Steady(value);
        }
        let mut flow = Self { fluid: Fluid::new(&scene).unwrap_or_else(|error| panic!("{error}")), step, steps: 0 };
        (0..100).for_each(|_| flow.step());
        flow
    }

    /// One step.
    pub fn step(&mut self) {
        let time = f64::from(self.steps) * self.step;
        self.steps += 1;
        if let Some(stations) = self.fluid.stations_mut() {
            let (amplitude, omega) = (0.03, 30.0);
            let last = (stations.len() - 1) as f64;
            for k in 0..stations.len() {
                let shape = amplitude * (k as f64 / last).powi(2);
                stations.position[1][k] = 0.2 + shape * (omega * (time + self.step)).sin();
                stations.velocity[1][k] = shape * omega * (omega * (time + self.step)).cos();
            }
        }
        self.fluid.advance(time, self.step).unwrap_or_else(|error| panic!("{error}"));
        let cfl = self.fluid.cfl();
        assert!(cfl < 0.4, "the step was divided: CFL number {cfl}");
    }
}

/// A shipped scene with another grid.
pub fn scene(name: &str, cells: [usize; 2]) -> Scene {
    let path = format!("{}/../../../scenes/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let mut scene = Scene::from_file(path.as_ref()).unwrap_or_else(|error| panic!("{error}"));
    scene.fluid.as_mut().expect("the scene has a fluid").domain.cells = cells;
    scene
}

fn steps(fftw: &Fftw, text: &mut String) -> std::fmt::Result {
    writeln!(
        text,
        "\nA step, beside FFTW's time for the five transforms that it has (two forward, three back), µs:\n"
    )?;
    writeln!(text, "| scene | grid | five of FFTW | step | step/FFTW |\n|---|---|---|---|---|")?;
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
        let [ours, theirs] = [0, 1].map(|which| us(times.shortest(which)));
        writeln!(text, "| {name} | {nx}x{ny} | {theirs} | {ours} | {} |", times.ratio(0, 1))?;
    }
    Ok(())
}

fn threads(text: &mut String) -> std::fmt::Result {
    writeln!(
        text,
        "\nA step on one and on two threads, µs of wall time, and of processor time of the calling thread:\n"
    )?;
    writeln!(
        text,
        "| grid | one | two | one/two | processor time one | two | one/two |\n|---|---|---|---|---|---|---|"
    )?;
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
        write!(text, "| {}x{} |", cells[0], cells[1])?;
        for times in [wall, processor] {
            let [first, second] = [0, 1].map(|which| us(times.shortest(which)));
            write!(text, " {first} | {second} | {} |", times.ratio(0, 1))?;
        }
        writeln!(text)?;
    }
    Ok(())
}

fn fail(message: &str) -> ! {
    eprintln!("{message}");
    exit(2)
}

fn main() {
    let Some(path) = std::env::args().nth(1) else { fail("give the file to write to") };
    let library = std::env::var("FFTW_LIBRARY").unwrap_or_else(|_| fail("FFTW_LIBRARY is not set"));
    let fftw = Fftw::load(&library).unwrap_or_else(|error| fail(&format!("cannot load FFTW: {error}")));
    let page = std::fs::read_to_string(&path).unwrap_or_else(|error| fail(&format!("cannot read {path}: {error}")));
    let Some((before, _)) = page.split_once("\n## Measured\n") else { fail(&format!("{path} has no `## Measured`")) };
    let mut text = format!("{before}\n## Measured\n\nBeside {} (planned by measuring). ", fftw.version());
    text.push_str("Times are the shortest; ratios are those of the shortest times and, in brackets, medians.\n\n");
    pairs(&fftw, &mut text)
        .and_then(|()| steps(&fftw, &mut text))
        .and_then(|()| phases::table(&mut text))
        .and_then(|()| threads(&mut text))
        .expect("a string takes everything");
    print!("{}", &text[before.len()..]);
    let written =
        std::fs::write(format!("{path}.new"), &text).and_then(|()| std::fs::rename(format!("{path}.new"), &path));
    written.unwrap_or_else(|error| fail(&format!("cannot write {path}: {error}")));
}
