//! Cuboids, capsules and cylinders on each other in space, in two-step backward differences.

#[path = "common/flying.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod flying;

use geometry::space::Solid;
use nalgebra::SVector;
use nervure_contact::{BodyLaw, Obstacle, Pose};
use flying::{Free, LAW, Random, World, throw};

fn solid(kind: usize, random: &mut Random) -> Obstacle<3> {
    let [a, b, c] = std::array::from_fn(|_| random.between(0.12, 0.35));
    let axis = random.between(0.0, 3.0) as usize;
    let solid = match kind {
        0 => Solid::Cuboid([a, b, c]),
        1 => Solid::Capsule { axis, radius: 0.7 * a, half_length: b },
        _ => Solid::Cylinder { axis, radius: a, half_length: b },
    };
    Obstacle::of_solid(&solid, Pose::at([0.0; 3])).expect("no ellipsoid")
}

#[test]
fn explore() {
    let kinds: Vec<Vec<usize>> = vec![vec![0], vec![0, 1], vec![2], vec![0, 1, 2]];
    for own in kinds {
        let clock = std::time::Instant::now();
        let (mut steps, mut gain, mut depth, mut failed, mut bad) = (0.0, 0.0_f64, 0.0_f64, 0, 0);
        for case in 0..200 {
            let shape = |random: &mut Random| {
                let kind = own[random.between(0.0, own.len() as f64) as usize];
                (solid(kind, random), 0.12)
            };
            let pillar = match own[0] {
                0 => Solid::Cuboid([0.2, 0.15, 0.15]),
                _ => Solid::Cylinder { axis: 1, radius: 0.15, half_length: 0.2 },
            };
            let pillar = Obstacle::of_solid(&pillar, Pose::at([0.0; 3])).expect("");
            match throw::<3>(case, shape, pillar) {
                Ok([touched, gained, deepest]) => {
                    (steps, gain, depth) = (steps + touched, gain.max(gained), depth.max(deepest));
                    if gained > 1e-12 { bad += 1; eprintln!("case {case}: {gained:.2e}"); }
                }
                Err(error) => { eprintln!("{own:?}: {error}"); failed += 1 }
            }
        }
        println!("{own:?}: steps {steps} gain {gain:.2e} bad {bad} depth {depth:.3} failed {failed} {:.2} s", clock.elapsed().as_secs_f64());
    }
}
