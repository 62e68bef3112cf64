//! A Newton iteration of the thesis' beam in space beside what the machine could do with its bytes, its operations and its
//! longest chain: `roofline FILE.csv`.
//!
//! Bytes and operations are counted by hand, as for the fluid's step: what is read, what is written, and that once more
//! where it was not read before. A multiply-add is two operations, a division or a root one.

#[path = "../../../../crates/rod/tests/common/mod.rs"]
mod common;
#[path = "../../fluid/src/machine.rs"]
mod machine;
#[allow(dead_code, reason = "the studies use the rest")]
#[path = "../src/rods.rs"]
mod rods;

use std::hint::black_box;
use std::time::Instant;

use machine::{Clock, Fused, shortest};
use nervure_rod::Parameters;
use rods::{build, thesis_beam};

/// Segments.
const SIZES: [usize; 2] = [128, 1024];
/// Step, s.
const DT: f64 = 1e-3;
/// Entries of a column of the band.
const BAND: usize = 9;

/// Part of an iteration.
struct Part {
    name: &'static str,
    /// Time, s.
    seconds: f64,
    /// Bytes that it moves, by segment.
    moved: usize,
    /// Operations by segment.
    flops: usize,
    /// What it can do only one after the other, by segment.
    links: usize,
}

fn main() -> Result<(), String> {
    let path = std::env::args().nth(1).ok_or("give the file to write to")?;
    let begin = Instant::now();
    let clock = || begin.elapsed().as_secs_f64();
    let peak = f64::peak(&clock);
    let mut lines = vec!["n,part,seconds,bytes,set,flops,bandwidth,peak,chain".to_string()];
    for n in SIZES {
        let set = n * SET;
        let bandwidth = machine::bandwidth(set, &clock);
        for Part { name, seconds, moved, flops, links } in parts(n, &clock) {
            let chain = if links > 0 { chain(n * links, &clock).to_string() } else { String::new() };
            let (bytes, flops) = (n * moved, n * flops);
            lines.push(format!("{n},{name},{seconds},{bytes},{set},{flops},{bandwidth},{peak},{chain}"));
        }
    }
    std::fs::write(&path, lines.join("\n") + "\n").map_err(|error| format!("cannot write {path}: {error}"))
}

/// Bytes of a segment's part of the band, of a vector by nodes and of a number by segments.
const MATRIX: usize = 3 * BAND * 8;
const VECTOR: usize = 3 * 8;
const NUMBER: usize = 8;

/// What an iteration uses: the band, six vectors (positions, origin, load, right-hand side, update, first guess) and four
/// numbers (length without tension, both stiffnesses, mass).
const SET: usize = MATRIX + 6 * VECTOR + 4 * NUMBER;

/// The parts of an iteration with n segments. Of the whole, which is that of a beam that falls from rest, what is not the
/// band's is the rest of a step by its iterations.
fn parts(n: usize, clock: Clock) -> [Part; 3] {
    let mut rod = build(thesis_beam::<3>(n));
    let times = (0..(163_840 / n).clamp(100, 2000)).map(|_| {
        let start = clock();
        rod.step(DT).expect("an easy step");
        (clock() - start) / rod.statistics().iterations as f64
    });
    let whole = times.fold(f64::INFINITY, f64::min);

    // Bent in the diagonal plane, so that no entry of the band vanishes.
    let mut rod = build(Parameters { gravity: [0.0, -0.5, -0.5], ..thesis_beam::<3>(n) });
    (0..5).for_each(|_| rod.step(DT).expect("an easy step"));
    let mut matrix = rod.stiffness().expect("a shape that steps have reached");
    let inertia = 4.0 * 0.0571 / n as f64 / (DT * DT);
    (0..matrix.order()).for_each(|j| matrix.column_mut(j)[0] += inertia);
    let mut factors = matrix.clone();
    let copy = shortest(clock, || factors.clone_from(black_box(&matrix)));
    let factorise = shortest(clock, || {
        factors.clone_from(black_box(&matrix));
        factors.factorise().expect("a positive definite matrix");
    });
    let mut b = vec![0.0; matrix.order()];
    let solve = shortest(clock, || {
        b.fill(1.0);
        factors.solve(black_box(&mut b));
    });
    let factorise = factorise - copy;
    let rest = whole - factorise - solve;
    [
        Part {
            name: "derivatives; assembly; update; residual",
            seconds: rest,
            // Assembly reads three vectors and four numbers and writes band and right-hand side; the update is read three times,
            // and what it is added to is read and written; the residual reads what assembly reads and writes the right-hand
            // side.
            moved: (3 + 2) * VECTOR + 4 * NUMBER + 2 * MATRIX + (3 + 2) * VECTOR + (3 + 2) * VECTOR + 4 * NUMBER,
            flops: EDGE + COSINE + SLOPES + HESSIAN + BY_EDGES + ENTRIES + UPDATE + RESIDUAL,
            links: 0,
        },
        Part {
            name: "factorise",
            seconds: factorise,
            // The band, read and written.
            moved: 2 * MATRIX,
            // Of each column the pivot's inverse, the factors, and a multiply-add for each entry of the triangle below.
            flops: 3 * (1 + (BAND - 1) + 2 * (BAND - 1) * BAND / 2),
            links: 3,
        },
        Part {
            name: "solve",
            seconds: solve,
            // Copies the right-hand side, then goes through band and vector forward and back.
            moved: 3 * VECTOR + 2 * (MATRIX + 2 * VECTOR),
            flops: 3 * (2 * 2 * (BAND - 1) + 1),
            links: 0,
        },
    ]
}

/// Operations of a vertex. An edge: difference (3), square (5), root, inverse (2) and tangent (3).
const EDGE: usize = 3 + 5 + 1 + 2 + 3;
/// 1 + c (3 + 5 + 1) and whether it is folded (2).
const COSINE: usize = 11;
/// Derivatives of the energy by c (1 + 1 + 3 + 2), and of c by two edges (9 each).
const SLOPES: usize = 7 + 2 * 9;
/// Second derivatives by the edges: what all share (9 + 9 + 6), the own blocks (65 each), the mixed one (69).
const HESSIAN: usize = 24 + 2 * 65 + 69;
/// From edges to nodes: tension (8 + 33), sums of gradients (3 + 3) and of blocks (9 + 27 + 18).
const BY_EDGES: usize = 41 + 6 + 54;
/// What goes into a column: the balance (15), entries times the weight (6 + 9 + 9), mass (3), the stiffest (21).
const ENTRIES: usize = 15 + 24 + 3 + 21;
/// The largest change of an edge (8), and the sum (6).
const UPDATE: usize = 14;
/// Edge, cosine and slopes again, the gradient (6 + 3 + 8 + 3), the balance (15) and its sum (3).
const RESIDUAL: usize = EDGE + COSINE + SLOPES + 20 + 18;

/// Seconds of so many pivots one after the other: each is an entry less what the one before leaves of it, by a division, a
/// product and a difference.
fn chain(pivots: usize, clock: Clock) -> f64 {
    let times = (0..400).map(|_| {
        let (entry, beside) = black_box((2.0, 1.0));
        let mut pivot = entry;
        let start = clock();
        for _ in 0..pivots {
            pivot = entry - 1.0 / pivot * beside * beside;
        }
        black_box(pivot);
        clock() - start
    });
    times.fold(f64::INFINITY, f64::min)
}
