//! Where the time of a step goes: its phases in the step itself, over the fastest quarter of many steps.

use std::time::Instant;

use cpu_time::ThreadTime;
use fluid::fft::Fft2;
use fluid::projection::Projection;
use fluid::{Grid, Phase};
use scene::Scene;

use crate::{Flow, TIME, Table, Times, cells, shipped};

const PHASES: [(Phase, &str); 9] = [
    (Phase::Paint, "painting of the moving bodies"),
    (Phase::Look, "wall target"),
    (Phase::Solve, "local solve"),
    (Phase::Velocities, "velocities of bodies and zones"),
    (Phase::Forces, "forces on the bodies"),
    (Phase::Forward, "transforms, two along y"),
    (Phase::Rows, "transforms along x and projection"),
    (Phase::Back, "transforms, three back along y, and the CFL number"),
    (Phase::Loads, "loads and impedance of the stations"),
];

const SCENES: [(&str, f64); 5] = [
    ("fsi3-325x72", 2e-4),
    ("fsi3-650x144", 1e-4),
    ("fsi3-1300x288", 5e-5),
    ("cylinder-2d2-900x180", 1e-4),
    ("vein-forward-384x192", 5e-4),
];

/// Processor times of the phases of a step in the order of [`PHASES`], and of the whole step, s: means over the fastest
/// quarter of the steps, so that the phases add up and what else runs on the machine counts little.
pub fn of_step(mut step: impl FnMut(&mut dyn FnMut(Phase))) -> ([f64; PHASES.len()], f64) {
    let (begin, mut steps) = (Instant::now(), Vec::new());
    while begin.elapsed() < TIME || steps.len() < 20 {
        let mut spent = [0.0; PHASES.len()];
        let start = ThreadTime::now();
        let mut last = 0.0;
        step(&mut |phase| {
            let now = start.elapsed().as_secs_f64();
            let which = PHASES.iter().position(|(known, _)| *known == phase).expect("all phases are listed");
            spent[which] += now - last;
            last = now;
        });
        steps.push((spent, start.elapsed().as_secs_f64()));
    }
    steps.sort_by(|(_, a), (_, b)| a.total_cmp(b));
    let fastest = &steps[..steps.len().div_ceil(4)];
    let (mut phases, mut whole) = ([0.0; PHASES.len()], 0.0);
    for (spent, time) in fastest {
        phases.iter_mut().zip(spent).for_each(|(sum, time)| *sum += time / fastest.len() as f64);
        whole += time / fastest.len() as f64;
    }
    (phases, whole)
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
    let times = Times::take([&mut || (0..rows).for_each(|row| projection.project(row, u, v, omega))]);
    times.shortest(0)
}

/// The rows of all scenes, the bars swinging.
pub fn measure(table: &mut Table) {
    for (name, step) in SCENES {
        let scene = shipped(name);
        let mut flow = Flow::new(&scene, step);
        let (spent, whole) = of_step(|mark| flow.step_marking(&mut |phase| mark(phase)));
        let projection = projection(&scene);
        for ((phase, what), seconds) in PHASES.into_iter().zip(spent) {
            if phase == Phase::Rows {
                table.time("phases", name, cells(&scene), "transforms, five along x", seconds - projection);
                table.time("phases", name, cells(&scene), "projection", projection);
            } else {
                table.time("phases", name, cells(&scene), what, seconds);
            }
        }
        table.time("phases", name, cells(&scene), "rest", whole - spent.iter().sum::<f64>());
        table.time("phases", name, cells(&scene), "step", whole);
    }
}
