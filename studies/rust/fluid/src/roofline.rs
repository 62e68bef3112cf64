//! What the phases of a step move and calculate, counted from what they do to arrays and lines.
//!
//! Moved is what a phase reads of arrays that are larger than a row or a block of columns, what it writes, and what it
//! writes without having read, once more: a line comes into the cache before it is written to. The same is counted of
//! the triad in `machine`. A fused multiply-add is two operations, a division, a comparison and a change of sign one.
//!
//! The phases that walk along lists of cells (painting, wall target, velocities of bodies and zones, forces, loads)
//! have no count: how long the lists are is not known here.

use std::f64::consts::PI;

use line_fft::{Fft2, Real};
use nervure_fluid::internals::{Phase, Projection};

/// What a phase does in a step.
pub struct Work {
    pub phase: Phase,
    /// Bytes that it moves.
    pub moved: f64,
    /// Operations.
    pub flops: f64,
}

/// The phases that go through whole arrays, and the bytes of all arrays of a step: the flow and w at two times, the
/// penalization rate, three spectra and the coefficients of their modes. In a step each is used once or twice, so what a
/// phase reads comes from where as much as that has room.
pub fn of_step<R: Real>([nx, ny]: [usize; 2], projection: &Projection<R>) -> ([Work; 4], f64) {
    let points = (nx * ny) as f64;
    // Bytes of a field, of one in double precision whatever that of the others, and of a spectrum without the modes
    // that are filtered away.
    let field = points * size_of::<R>() as f64;
    let wide = points * size_of::<f64>() as f64;
    let modes = projection.modes().div_ceil(R::LANES) * R::LANES;
    let spectrum = size_of_val(&Fft2::<R>::new(nx, ny, projection.modes()).spectrum()[..]) as f64;
    // Two coefficients of each mode, in double precision.
    let coefficients = (2 * size_of::<f64>() * modes * nx) as f64;
    // Lines along y: the columns in pairs, in whole vectors of them.
    let pairs = (nx.div_ceil(2 * R::LANES) * R::LANES) as f64;
    let modes = modes as f64;
    let along = |n: usize| operations_of_line(n) as f64;
    let phases = [
        Work {
            phase: Phase::Solve,
            // Reads u, v and omega of two times, both w and the penalization rate; writes the next w.
            moved: 8.0 * field + wide + 2.0 * 2.0 * field,
            // A component: twice omega × u (2 each), G (2), the right-hand side (8), the solve (4).
            flops: 2.0 * 18.0 * points,
        },
        Work {
            phase: Phase::Forward,
            // Reads both w; writes two spectra.
            moved: 2.0 * field + 2.0 * 2.0 * spectrum,
            // Two transforms; the modes of two columns told apart (8 a mode).
            flops: 2.0 * pairs * (along(ny) + 8.0 * modes),
        },
        Work {
            phase: Phase::Rows,
            // Reads two spectra and the coefficients; writes both over what was read, and a third.
            moved: 2.0 * spectrum + coefficients + 2.0 * spectrum + 2.0 * spectrum,
            // Five transforms; the projection of a mode: its gain (7), both components times it (4), what is along the
            // wave (8), taken out (8), the curl (7).
            flops: modes * (5.0 * along(nx) + 34.0 * nx as f64),
        },
        Work {
            phase: Phase::Back,
            // Reads three spectra; writes the flow. The CFL number finds what was just written in the first cache.
            moved: 3.0 * spectrum + 3.0 * 2.0 * field,
            // Three transforms; modes of two columns put together (4 a mode); the CFL number (4 a point).
            flops: 3.0 * pairs * (along(ny) + 4.0 * modes) + 4.0 * points,
        },
    ];
    (phases, 10.0 * field + wide + 3.0 * spectrum + coefficients)
}

/// The phases of a step in space that go through whole arrays of numbers of so many bytes, with what they move, and what
/// they must move: the same without the lines that come into the cache before they are written to.
///
/// The filter leaves the modes within an ellipsoid, of which a spectrum has the rows along y whole.
pub fn in_space(cells: [usize; 3], bytes: f64) -> [(Phase, [f64; 2]); 4] {
    let points = cells.iter().product::<usize>() as f64;
    // A field, the penalization rate in double precision, and a spectrum: half as many modes of two numbers.
    let (field, wide) = (points * bytes, points * size_of::<f64>() as f64);
    let spectrum = field;
    let of = |read: f64, over: f64, written: f64| [read + over + 2.0 * written, read + over + written];
    [
        // Reads u and omega of three times, w of the last step, and the rate; writes w.
        (Phase::Solve, of(21.0 * field + wide, 0.0, 3.0 * field)),
        (Phase::Forward, of(3.0 * field, 0.0, 3.0 * spectrum)),
        // Of modes within the ellipse across x, the only ones that are read. Writes three over what was read.
        (Phase::Rows, of(3.0 * spectrum, 3.0 * spectrum, 3.0 * spectrum).map(|bytes| 0.25 * PI * bytes)),
        (Phase::Back, of(0.25 * PI * 6.0 * spectrum, 0.0, 6.0 * field)),
    ]
}

/// Operations of a complex transform of length n by passes of small factors, as the fluid does it. A length with
/// another factor is counted as 5 n log2 n, by custom.
pub fn operations_of_line(n: usize) -> usize {
    operations_of_passes(n).unwrap_or_else(|| (5.0 * n as f64 * (n as f64).log2()) as usize)
}

/// Operations of the passes of a transform of length n; none if n has a factor without a pass.
const fn operations_of_passes(n: usize) -> Option<usize> {
    let (mut rest, mut first, mut operations) = (n, true, 0);
    let (factors, mut i) = ([13, 11, 7, 5, 4, 3, 2], 0);
    while i < factors.len() {
        let factor = factors[i];
        if !rest.is_multiple_of(factor) {
            i += 1;
            continue;
        }
        // Each input but one is turned by a complex number, but not before the first pass.
        let turns = if first { 0 } else { 6 * (factor - 1) };
        operations += n / factor * (operations_of_butterfly(factor) + turns);
        (rest, first) = (rest / factor, false);
    }
    if rest == 1 { Some(operations) } else { None }
}

/// Operations of a transform of a factor.
const fn operations_of_butterfly(factor: usize) -> usize {
    match factor {
        2 => 2 * 2,
        4 => 8 * 2,
        _ => {
            // Of each pair of inputs sum, difference and a part of the first output (2 each). Of each pair of outputs
            // two sums over the pairs by multiply-adds (4 each, one 2 less), and their sum and difference (2 each).
            let half = factor / 2;
            half * 3 * 2 + half * (8 * half - 2 + 2 * 2)
        }
    }
}

// Small transforms have the operations of their formulas; a check of the compiler spares a build for one test.
const _: () = {
    // Of 3: t = x1 + x2, y0 = x0 + t, m = x0 + cos t, s = sin (x1 − x2), y1, y2 = m ± i s:
    // 2 + 2 + 4 + 2 + 2 + 2 · 2.
    assert!(matches!(operations_of_passes(3), Some(16)));
    // Of 8: two of 4 (8 complex sums each), three turned inputs with the one that is 1, and four pairs of sums.
    assert!(matches!(operations_of_passes(8), Some(72)));
    // Of 15: three of 5, and five of 3 with two turns each.
    let five = operations_of_butterfly(5);
    assert!(matches!(operations_of_passes(15), Some(n) if n == 3 * five + 5 * (16 + 2 * 6)));
    assert!(operations_of_passes(17).is_none());
};
