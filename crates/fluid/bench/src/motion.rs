//! What the motion of the stations costs.

use fluid::Phase;

use crate::phases::of_step;
use crate::{Flow, Table, cells, shipped};

/// How far the bar jumps from step to step, cells; a body that goes with the flow moves by at most the CFL number.
const JUMPS: [f64; 6] = [0.0, 0.01, 0.03, 0.1, 0.3, 1.0];

/// Painting, wall target, forces and station loads, and the step, with the bar jumping to and fro by a part of a cell.
///
/// Its velocity is 0: the cost of a place is asked for, not a flow.
pub fn measure(table: &mut Table) {
    for (name, step) in [("fsi3-325x72", 2e-4), ("fsi3-650x144", 1e-4)] {
        let scene = shipped(name);
        let [_, ny] = cells(&scene);
        let [low, high] = scene.fluid.as_ref().expect("the scene has a fluid").domain.y;
        let dy = (high - low) / ny as f64;
        for jump in JUMPS {
            let mut flow = Flow::new(&scene, step);
            let mut side = 0.5;
            let (spent, whole) = of_step(|mark| {
                side = -side;
                flow.bend(|_| side * jump * dy, |_| 0.0);
                flow.advance(&mut |phase: Phase| mark(phase));
            });
            let [paint, look, _, _, forces, .., loads] = spent;
            table.time("motion", name, cells(&scene), &format!("{jump} cells, bar"), paint + look + forces + loads);
            table.time("motion", name, cells(&scene), &format!("{jump} cells, step"), whole);
        }
    }
}
