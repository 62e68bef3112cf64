//! How fast the fluid is: its transforms beside FFTW and rustfft, its step and the phases of it beside what the machine
//! could do, on one core.
//!
//! `fluid-bench FILE.csv` writes `table,scene,grid,what,value,unit`; names of tables after it ask for these alone.
//! `FFTW_LIBRARY` is the path of FFTW 3.
//!
//! What is compared takes turns, so that what else runs on the machine meets all, and the times are processor times of
//! the thread. A ratio is that of the shortest times; beside it stands the median of the ratios of neighbouring times.

mod fftw;
mod machine;
mod roofline;
mod rows;

use std::array::from_fn;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use libloading::Library;
use line_fft::{Fft2, Fft3, Real, Scratch, ThreadTeam};
use nervure_fluid::internals::{Implicit, Phase, Projection};
use nervure_fluid::{Filter, Fluid, Parameters};
use scene::{Precision, Scene};

use machine::{Clock, Fused};
use roofline::Work;

/// How long a row of a table is measured.
const TIME: Duration = Duration::from_millis(3000);

/// The grids of the shipped scenes, some beside them that suit FFTW better, and one with factors for which there is no
/// kernel: 646 = 2 · 17 · 19.
#[rustfmt::skip]
const SIZES: [[usize; 2]; 14] = [
    [325, 72], [650, 144], [960, 216], [1300, 288], [450, 90], [900, 180], [384, 192], [288, 256], [320, 240],
    [320, 72], [640, 144], [1280, 288], [1100, 220], [646, 144],
];

/// A scene, its grid and its step, s.
const SCENES: [(&str, [usize; 2], f64); 5] = [
    ("fsi3-325x72", [325, 72], 2e-4),
    ("fsi3-650x144", [650, 144], 1e-4),
    ("fsi3-1300x288", [1300, 288], 5e-5),
    ("cylinder-2d2-900x180", [900, 180], 1e-4),
    ("vein-forward-288x144", [288, 144], 6.25e-4),
];

/// Names of the [`Phase`]s in their order, and of all of them; the projection has a row apart from the transforms.
const PHASES: [&str; 10] = [
    "painting of the moving bodies",
    "wall target",
    "local solve",
    "velocities of bodies and zones",
    "transforms, two along y",
    "transforms, five along x",
    "transforms, three back along y, and the CFL number",
    "forces on the bodies",
    "loads and impedance of the stations",
    "step",
];
const STEP: usize = PHASES.len() - 1;

/// The same in space.
const VOLUME_PHASES: [&str; 10] = {
    let mut names = PHASES;
    names[4] = "three transforms along z and y";
    names[5] = "nine along x, and the projection";
    names[6] = "six back along y and z, and the CFL number";
    names
};

/// Coefficients of a solve wave by wave; its time does not depend on them.
const STEP_COEFFICIENTS: Implicit<2> = Implicit { tau_nu: 1e-8, cfl: 0.3, mean: None, limit: f64::INFINITY };

/// Bytes of the streams that the machine is measured by: some for each of its caches, and for the memory.
const STREAMS: [usize; 4] = [24_000, 500_000, 8_000_000, 200_000_000];

/// A name, and two numbers of things whose times are divided.
type Ratio<'a> = (&'a str, usize, usize);

/// A name and what is measured.
type Thing<'a> = (&'a str, &'a mut dyn FnMut());

fn processor_time() -> f64 {
    ThreadTime::now().as_duration().as_secs_f64()
}

fn wall_time() -> f64 {
    static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
    BEGIN.elapsed().as_secs_f64()
}

/// What `measure` returns, again and again for [`TIME`].
fn repeated<T>(mut measure: impl FnMut() -> T) -> Vec<T> {
    let (begin, mut found) = (Instant::now(), Vec::new());
    while begin.elapsed() < TIME || found.len() < 20 {
        found.push(measure());
    }
    found
}

/// The file that is written, and the first columns of what is being measured.
struct Table {
    file: csv::Writer<std::fs::File>,
    part: [String; 3],
}

impl Table {
    fn begin<const D: usize>(&mut self, table: &str, scene: &str, cells: [usize; D]) {
        self.part = [table.into(), scene.into(), cells.map(|count| count.to_string()).join(" x ")];
    }

    fn row(&mut self, what: &str, value: f64, unit: &str) {
        let row = (&self.part, what, format!("{value:.6}"), unit);
        eprintln!("{row:?}");
        self.file.serialize(row).expect("the file can be written");
    }

    fn time(&mut self, what: &str, seconds: f64) {
        self.row(what, 1e6 * seconds, "µs");
    }

    /// The shortest times of things that take turns, their ratios, and the medians of the turns' ratios.
    fn compare<const N: usize>(&mut self, clock: Clock, mut things: [Thing; N], ratios: &[Ratio]) -> [f64; N] {
        let turns = repeated(|| {
            things.each_mut().map(|(_, thing)| {
                thing(); // what the others left in the cache is not counted
                let start = clock();
                thing();
                clock() - start
            })
        });
        let shortest: [_; N] = from_fn(|k| turns.iter().map(|turn| turn[k]).fold(f64::INFINITY, f64::min));
        things.iter().zip(shortest).for_each(|((what, _), seconds)| self.time(what, seconds));
        for (what, a, b) in ratios {
            let mut ratios: Vec<_> = turns.iter().map(|turn| turn[*a] / turn[*b]).collect();
            ratios.sort_by(f64::total_cmp);
            self.row(what, shortest[*a] / shortest[*b], "1");
            self.row(&format!("{what}, median"), ratios[ratios.len() / 2], "1");
        }
        shortest
    }
}

/// A field of numbers between −0.5 and 0.5 without a pattern.
fn noise(n: usize) -> Vec<f64> {
    (0..n).map(|c| (c as f64 * 0.618_033_988_749_894_9).fract() - 0.5).collect()
}

/// One pair of transforms, forward and back.
fn pairs(library: &Library, table: &mut Table) {
    for [nx, ny] in SIZES {
        table.begin("pair", "", [nx, ny]);
        let ours = |modes: usize| {
            let fft = Fft2::<f64>::new(nx, ny, modes);
            let (mut spectrum, mut scratch, mut block) = (fft.spectrum(), fft.scratch(), fft.y.block());
            let (field, mut back) = (noise(nx * ny), vec![0.0; nx * ny]);
            move || {
                fft.forward(&field, &mut spectrum, &mut scratch, &mut block);
                fft.inverse(&mut spectrum, &mut back, &mut scratch, &mut block);
            }
        };
        let (mut whole, mut pruned, mut rustfft) = (ours(ny / 2 + 1), ours(ny / 3 + 1), rows::pair(nx, ny));
        let theirs = fftw::plan::<f64>(library, &[nx, ny]);
        let mut fftw = || theirs.iter().for_each(|transform| transform());
        let things: [Thing; 4] =
            [("ours", &mut whole), ("FFTW", &mut fftw), ("pruned", &mut pruned), ("rustfft", &mut rustfft)];
        let ratios = [("ours/FFTW", 0, 1), ("pruned/FFTW", 2, 1), ("ours/rustfft", 0, 3)];
        table.compare(&processor_time, things, &ratios);
    }
}

/// The nine transforms of a step in space, three forward and six back: those of the step, which leave out what the
/// filter cuts off, beside FFTW's.
fn volume<R: Real>(library: &Library, precision: &str, table: &mut Table) {
    for shape in [[64; 3], [128; 3], [144, 96, 96]] {
        table.begin("volume", precision, shape);
        let [_, ny, nz] = shape;
        let points = shape.iter().product();
        let field: Vec<_> = noise(points).into_iter().map(R::rounded).collect();
        // The smooth filter of a step leaves the waves within the ellipsoid of the shortest ones.
        let share = |mode: usize, points: usize| (2.0 * mode as f64 / points as f64).powi(2);
        let kept = (0..nz / 2).step_by(R::LANES);
        let kept = kept.map(|k| (0..=ny / 2).take_while(|j| share(*j, ny) + share(k, nz) < 1.0).count()).collect();
        let fft = Fft3::<R>::new(shape, kept);
        let (mut spectra, mut scratch): ([_; 6], _) = (from_fn(|_| fft.spectrum()), vec![fft.scratch::<6>()]);
        let (mut fields, team): ([_; 6], _) = (from_fn(|_| vec![R::zero(); points]), ThreadTeam::alone());
        let mut ours = || {
            fft.forward(&team, [&field[..]; 3], &mut spectra, &mut scratch);
            fft.along_x(&team, &mut spectra, [0..3, 0..6], &mut scratch, |_, _, _| ());
            let fields = fields.each_mut().map(|field| &mut field[..]);
            fft.inverse(&team, spectra.each_ref().map(|spectrum| &spectrum[..]), fields, &mut scratch, |_| ());
        };
        let [forward, inverse] = fftw::plan::<R>(library, &shape);
        let mut nine = || {
            (0..3).for_each(|_| forward());
            (0..6).for_each(|_| inverse());
        };
        let things: [Thing; 2] = [("ours", &mut ours), ("FFTW", &mut nine)];
        table.compare(&processor_time, things, &[("ours/FFTW", 0, 1)]);
    }
}

/// A flow in which the bar, where there is one, swings about its place.
struct Flow {
    fluid: Fluid,
    filter: Filter,
    /// How far the tip of the bar swings, m.
    amplitude: f64,
    step: f64,
}

impl Flow {
    /// Some steps of a shipped scene on a grid.
    fn new(name: &str, cells: [usize; 2], step: f64, threads: usize, precision: Precision) -> Self {
        let path = format!("{}/../../../scenes/{name}.json", env!("CARGO_MANIFEST_DIR"));
        let mut scene = Scene::from_file(path.as_ref()).unwrap_or_else(|error| panic!("{error}"));
        let fluid = scene.fluid.as_mut().expect("the scene has a fluid");
        (fluid.r#box.cells, fluid.threads, fluid.precision) = (cells.to_vec(), threads, precision);
        let amplitude = scene.beam.as_ref().map_or(0.0, |beam| 0.086 * beam.length);
        let parameters = Parameters::<2>::try_from(&scene).unwrap_or_else(|error| panic!("{error}"));
        let filter = parameters.filter;
        let fluid = Fluid::new(&parameters).unwrap_or_else(|error| panic!("{error}"));
        let mut flow = Self { fluid, filter, amplitude, step };
        (0..100).for_each(|_| flow.swing());
        flow
    }

    /// One step of the swing.
    fn swing(&mut self) {
        let omega = 30.0;
        let velocity = self.amplitude * omega * (omega * (self.fluid.time() + self.step)).cos();
        self.advance(|s| s * s, velocity * self.step, velocity);
    }

    /// One step, with a shift (m) and a velocity (m/s) of the bar in a shape over the share of its length.
    fn advance(&mut self, shape: fn(f64) -> f64, shift: f64, velocity: f64) {
        for stations in self.fluid.stations_mut() {
            let last = stations.len() - 1;
            for k in 0..=last {
                let shape = shape(k as f64 / last as f64);
                stations.position[1][k] += shift * shape;
                stations.velocity[1][k] = velocity * shape;
            }
        }
        // It begins where the inflow's ramp has ended.
        let time = self.fluid.time().max(10.0);
        self.fluid.advance(time, self.step).unwrap_or_else(|error| panic!("{error}"));
        let cfl = self.fluid.cfl();
        assert!(cfl < 0.4, "the step was divided: CFL number {cfl}");
    }
}

/// A step in double and in single precision, beside FFTW's time for the five transforms that it has (two forward, three
/// back).
fn steps(library: &Library, table: &mut Table) {
    let grids = [
        (0, [325, 72]),
        (0, [320, 72]),
        (1, [650, 144]),
        (1, [640, 144]),
        (3, [900, 180]),
        (3, [1100, 220]),
        (2, [1300, 288]),
    ];
    for (scene, cells) in grids {
        let (name, _, step) = SCENES[scene];
        table.begin("step", name, cells);
        let [mut double, mut single] =
            [Precision::Double, Precision::Single].map(|precision| Flow::new(name, cells, step, 1, precision));
        let [forward, inverse] = fftw::plan::<f64>(library, &cells);
        let mut five = || {
            (0..2).for_each(|_| forward());
            (0..3).for_each(|_| inverse());
        };
        let things: [Thing; 3] = [
            ("step", &mut || double.swing()),
            ("five of FFTW", &mut five),
            ("step in single precision", &mut || single.swing()),
        ];
        let ratios = [("step/FFTW", 0, 1), ("single/FFTW", 2, 1), ("single/double", 2, 0)];
        table.compare(&processor_time, things, &ratios);
    }
}

/// Processor times of the phases of a step and of all of it, s: means over the fastest quarter of the steps, so that
/// the phases add up and what else runs on the machine counts little.
fn phases_of(flow: &mut Flow, mut step: impl FnMut(&mut Flow)) -> [f64; PHASES.len()] {
    flow.fluid.timer().now = Some(processor_time);
    let mut steps: Vec<[f64; PHASES.len()]> = repeated(|| {
        flow.fluid.timer().spent = [0.0; STEP];
        let start = processor_time();
        step(flow);
        let whole = processor_time() - start;
        from_fn(|phase| *flow.fluid.timer().spent.get(phase).unwrap_or(&whole))
    });
    steps.sort_by(|a, b| a[STEP].total_cmp(&b[STEP]));
    steps.truncate(steps.len().div_ceil(4));
    from_fn(|phase| steps.iter().map(|step| step[phase]).sum::<f64>() / steps.len() as f64)
}

/// What the machine can do.
fn machine(table: &mut Table) {
    table.begin("machine", "", [0, 0]);
    for bytes in STREAMS {
        table.row(&bytes.to_string(), 1e-9 * machine::bandwidth(bytes, &processor_time), "GB/s");
    }
    table.row("double", 1e-9 * f64::peak(&processor_time), "Gflop/s");
    table.row("single", 1e-9 * f32::peak(&processor_time), "Gflop/s");
}

/// The phases of a step, the bars swinging; of FSI3 those that go through whole arrays beside what the machine does
/// with as much. The projection is timed by itself, row by row in the cache as it runs between the transforms along x.
fn phases<R: Real + Fused>(precision: Precision, [title, roofline]: [&str; 2], table: &mut Table) {
    for (name, cells, step) in SCENES {
        table.begin(title, name, cells);
        let mut flow = Flow::new(name, cells, step, 1, precision);
        let mut spent = phases_of(&mut flow, Flow::swing);
        table.time("rest", spent[STEP] - spent[..STEP].iter().sum::<f64>());
        let projection = Projection::<R>::new(flow.fluid.grid(), flow.filter);
        let fft = Fft2::<R>::new(cells[0], cells[1], projection.modes());
        let (mut scratch, rows) = (fft.scratch(), fft.spectrum().len() / cells[0]);
        let [u, v, omega] = &mut scratch.rows;
        let mut all = || (0..rows).for_each(|row| projection.project(&STEP_COEFFICIENTS, row, [u, v, omega]));
        let [seconds] = table.compare(&processor_time, [("projection", &mut all)], &[]);
        let with_projection = spent;
        spent[Phase::Rows as usize] -= seconds;
        PHASES.into_iter().zip(spent).for_each(|(what, seconds)| table.time(what, seconds));

        if !name.starts_with("fsi3") {
            continue;
        }
        table.begin(roofline, name, cells);
        let (works, set) = roofline::of_step(cells, &projection);
        table.row("set", 1e-6 * set, "MB");
        table.row("bandwidth", 1e-9 * machine::bandwidth(set as usize, &processor_time), "GB/s");
        table.row("peak", 1e-9 * R::peak(&processor_time), "Gflop/s");
        let in_cache = in_cache::<R>(precision, cells, &projection, table);
        for (Work { phase, moved, flops }, in_cache) in works.into_iter().zip(in_cache) {
            let name = PHASES[phase as usize];
            table.time(name, with_projection[phase as usize]);
            table.time(&format!("{name}: in cache"), in_cache);
            table.row(&format!("{name}: moved"), 1e-6 * moved, "MB");
            table.row(&format!("{name}: operations"), 1e-6 * flops, "Mflop");
        }
    }
}

/// What the phases of [`roofline::of_step`] would take if nothing came from beyond the second cache, s: by a solve on a
/// small grid, by one block of columns again and again, and by one row of modes.
fn in_cache<R: Real>(
    precision: Precision,
    [nx, ny]: [usize; 2],
    projection: &Projection<R>,
    table: &mut Table,
) -> [f64; 4] {
    let small = [160, 36];
    let mut flow = Flow::new(SCENES[0].0, small, SCENES[0].2, 1, precision);
    let solve = phases_of(&mut flow, Flow::swing)[Phase::Solve as usize];
    let by_points = (nx * ny) as f64 / small.iter().product::<usize>() as f64;

    let (columns, modes) = (2 * R::LANES, projection.modes());
    let (block, blocks) = (Fft2::<R>::new(columns, ny, modes), nx.div_ceil(columns));
    let (field, mut back) =
        (noise(columns * ny).into_iter().map(R::rounded).collect::<Vec<_>>(), vec![R::zero(); columns * ny]);
    let [mut spectrum, mut zeros, empty] = [(); 3].map(|()| block.spectrum());
    let ([mut whole, mut rows], [mut lines, mut columns_back]) =
        ([(); 2].map(|()| block.scratch()), [(); 2].map(|()| block.y.block()));
    let fft = Fft2::<R>::new(nx, ny, modes);
    let mut scratch = fft.scratch();
    let things: [Thing; 4] = [
        ("two whole, a block of columns", &mut || {
            (0..2 * blocks).for_each(|_| block.forward(&field, &mut spectrum, &mut whole, &mut lines));
        }),
        ("their part along x", &mut || {
            for _ in 0..2 * blocks {
                for row in zeros.chunks_exact_mut(columns) {
                    rows.rows[0].copy_from_slice(row);
                    block.x.forward::<false>(&rows.rows[0], row, &mut rows.line);
                }
            }
        }),
        ("five along x, a row of modes", &mut || {
            let Scratch { rows: [u, v, omega], line } = &mut scratch;
            for row in 0..modes.div_ceil(R::LANES) {
                (0..2).for_each(|_| fft.x.forward::<false>(u, v, line));
                projection.project(&STEP_COEFFICIENTS, row, [u, v, omega]);
                (0..3).for_each(|_| fft.x.forward::<true>(u, omega, line));
            }
        }),
        ("three back, a block of columns", &mut || {
            (0..3 * blocks).for_each(|_| block.y.inverse(&empty, 0..columns, &mut back, &mut columns_back));
        }),
    ];
    let [both, along_x, rows, back] = table.compare(&processor_time, things, &[]);
    [solve * by_points, both - along_x, rows, back]
}

/// The phases of a step in space, a sphere in a stream, that go through whole arrays: times on one thread and on two, and
/// the bytes that they move and must move beside the bandwidth of one thread from the memory.
fn volume_phases(table: &mut Table) {
    for (precision, name) in [(Precision::Single, "single"), (Precision::Double, "double")] {
        let cells = [128; 3];
        table.begin("roofline-space", name, cells);
        table.row("bandwidth", 1e-9 * machine::bandwidth(STREAMS[3], &processor_time), "GB/s");
        let bytes = if precision == Precision::Single { 4.0 } else { 8.0 };
        for (phase, [moved, must]) in roofline::in_space(cells, bytes) {
            table.row(&format!("{}: moved", VOLUME_PHASES[phase as usize]), 1e-6 * moved, "MB");
            table.row(&format!("{}: must", VOLUME_PHASES[phase as usize]), 1e-6 * must, "MB");
        }
        let path = format!("{}/../../../scenes/sphere-stream-144x96x96.json", env!("CARGO_MANIFEST_DIR"));
        let mut scene = Scene::from_file(path.as_ref()).unwrap_or_else(|error| panic!("{error}"));
        let fluid = scene.fluid.as_mut().expect("the scene has a fluid");
        (fluid.r#box.cells, fluid.precision) = (cells.to_vec(), precision);
        for (threads, said) in [(1, "one thread"), (2, "two threads")] {
            scene.fluid.as_mut().expect("the scene has a fluid").threads = threads;
            let parameters = Parameters::<3>::try_from(&scene).unwrap_or_else(|error| panic!("{error}"));
            let mut fluid = Fluid::new(&parameters).unwrap_or_else(|error| panic!("{error}"));
            let mut step = || fluid_step(&mut fluid);
            (0..3).for_each(|_| {
                step();
            });
            let mut steps = repeated(step);
            steps.sort_by(|a, b| a[STEP].total_cmp(&b[STEP]));
            steps.truncate(steps.len().div_ceil(4));
            for (phase, what) in VOLUME_PHASES.into_iter().enumerate() {
                let mean = steps.iter().map(|step| step[phase]).sum::<f64>() / steps.len() as f64;
                table.time(&format!("{what}: {said}"), mean);
            }
        }
    }
}

/// Wall times of the phases of a step in space and of all of it, s.
fn fluid_step(fluid: &mut Fluid<3>) -> [f64; PHASES.len()] {
    fluid.timer().now = Some(wall_time);
    fluid.timer().spent = [0.0; STEP];
    let start = wall_time();
    fluid.advance(fluid.time(), 0.01).unwrap_or_else(|error| panic!("{error}"));
    let whole = wall_time() - start;
    from_fn(|phase| *fluid.timer().spent.get(phase).unwrap_or(&whole))
}

/// What the bar costs and the whole step, with the bar jumping to and fro by a part of a cell from step to step (a body
/// that goes with the flow moves by at most the CFL number). Its velocity is 0: the cost of a place is asked for.
fn motion(table: &mut Table) {
    for (name, cells, step) in [SCENES[0], SCENES[1]] {
        table.begin("motion", name, cells);
        for jump in [0.0, 0.01, 0.03, 0.1, 0.3, 1.0] {
            let mut flow = Flow::new(name, cells, step, 1, Precision::Double);
            let mut shift = jump * flow.fluid.grid().spacing[1];
            let spent = phases_of(&mut flow, |flow| {
                shift = -shift;
                flow.advance(|_| 1.0, shift, 0.0);
            });
            let bar = [Phase::Paint, Phase::Sample, Phase::Forces, Phase::Loads].map(|phase| spent[phase as usize]);
            table.time(&format!("{jump} cells, bar"), bar.iter().sum());
            table.time(&format!("{jump} cells, step"), spent[STEP]);
        }
    }
}

/// A step on one and on two threads: wall time, and processor time of the calling thread.
fn threads(table: &mut Table) {
    for (name, cells) in [("fsi3-650x144", [650, 144]), ("cylinder-2d2-900x180", [1100, 220])] {
        table.begin("threads", name, cells);
        let [mut one, mut two] = [1, 2].map(|threads| Flow::new(name, cells, 1e-4, threads, Precision::Double));
        let begin = Instant::now();
        let wall_time = || begin.elapsed().as_secs_f64();
        for (name, clock) in [("wall", &wall_time as Clock), ("processor", &processor_time)] {
            let [first, second, ratio] = ["one", "two", "one/two"].map(|what| format!("{name}, {what}"));
            let things: [Thing; 2] = [(&first, &mut || one.swing()), (&second, &mut || two.swing())];
            table.compare(clock, things, &[(&ratio, 0, 1)]);
        }
        assert!(one.fluid.state() == two.fluid.state(), "{name}: two threads give other bits than one");
    }
}

/// Fills one of the tables.
type Measure<'a> = &'a dyn Fn(&mut Table);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("give the file to write to")?;
    let library = std::env::var("FFTW_LIBRARY").map_err(|error| format!("FFTW_LIBRARY: {error}"))?;
    let (library, single) = (fftw::load(library.as_ref())?, fftw::load_single(library.as_ref())?);
    let mut table = Table { file: csv::Writer::from_path(path)?, part: Default::default() };
    table.file.write_record(["table", "scene", "grid", "what", "value", "unit"])?;
    table.begin("about", &fftw::version(&library), [0, 0]);
    table.row("FFTW, planned by measuring", 1.0, "1");
    let tables: [(&str, Measure); 9] = [
        ("machine", &machine),
        ("pair", &|table| pairs(&library, table)),
        ("volume", &|table| {
            volume::<f32>(&single, "single", table);
            volume::<f64>(&library, "double", table);
        }),
        ("step", &|table| steps(&library, table)),
        ("phases", &|table| phases::<f64>(Precision::Double, ["phases", "roofline"], table)),
        ("phases-single", &|table| {
            phases::<f32>(Precision::Single, ["phases-single", "roofline-single"], table);
        }),
        ("roofline-space", &volume_phases),
        ("motion", &motion),
        ("threads", &threads),
    ];
    let wanted: Vec<_> = std::env::args().skip(2).collect();
    for (name, measure) in tables {
        if wanted.is_empty() || wanted.iter().any(|wanted| wanted == name) {
            measure(&mut table);
        }
    }
    Ok(table.file.flush()?)
}
