//! Generated meshes: rows of nearly equilateral triangles, mapped to outlines. The root lies on the y axis.

use crate::surface::{Chain, Mesh};

/// Share of the angle between the first and the last ray of [`insect_wing`] at which each vein runs.
const VEINS: [(&str, f64); 5] = [("costa", 0.0), ("radius", 0.25), ("media", 0.5), ("cubitus", 0.75), ("anal", 1.0)];

/// Mesh of the unit square.
struct Square {
    places: Vec<[f64; 2]>,
    triangles: Vec<[usize; 3]>,
    /// Nodes of each row.
    rows: Vec<Vec<usize>>,
}

/// Return a mesh of the unit square: `across` rows of `along` edges, every other row shifted by half an edge.
fn square(along: usize, across: usize) -> Square {
    let (mut places, mut rows, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for j in 0..=across {
        let y = j as f64 / across as f64;
        let first = places.len();
        if j % 2 == 0 {
            places.extend((0..=along).map(|i| [i as f64 / along as f64, y]));
        } else {
            places.push([0.0, y]);
            places.extend((0..along).map(|i| [(i as f64 + 0.5) / along as f64, y]));
            places.push([1.0, y]);
        }
        rows.push((first..places.len()).collect::<Vec<_>>());
    }
    for (j, pair) in rows.windows(2).enumerate() {
        let [lower, upper] = pair else { continue };
        // The shorter row is the one without shift.
        if j % 2 == 0 {
            triangles.extend((0..=along).map(|i| [lower[i], upper[i + 1], upper[i]]));
            triangles.extend((0..along).map(|i| [lower[i], lower[i + 1], upper[i + 1]]));
        } else {
            triangles.extend((0..=along).map(|i| [lower[i], lower[i + 1], upper[i]]));
            triangles.extend((0..along).map(|i| [upper[i], lower[i + 1], upper[i + 1]]));
        }
    }
    Square { places, triangles, rows }
}

/// Return the rows across that make triangles of `height` nearly equilateral, with `along` edges in `length`.
fn rows(length: f64, height: f64, along: usize) -> usize {
    let edge = length / along as f64;
    ((height / (edge * 0.75_f64.sqrt())).round() as usize).max(2)
}

/// Return a rectangle of `length` along x, from 0, and `width` along y, about 0, with `along` edges in a row.
///
/// Chains: `root` (x = 0), `tip`, `left` (y = width/2) and `right`.
pub fn rectangle(length: f64, width: f64, along: usize) -> Mesh {
    let along = along.max(1);
    // An even number of rows makes the mesh its own mirror image.
    let across = rows(length, width, along).div_ceil(2) * 2;
    let Square { places, triangles, rows } = square(along, across);
    let nodes = places.iter().map(|[s, t]| [s * length, (t - 0.5) * width, 0.0]).collect();
    Mesh { nodes, triangles, chains: sides(&rows) }
}

/// Return an ellipse of `length` along x, from 0, and `width` along y, about 0, with `along` edges in a row.
///
/// Chains: `root`, the quarter of the outline about x = 0, and `tip`, the quarter beyond.
pub fn ellipse(length: f64, width: f64, along: usize) -> Mesh {
    let along = along.max(2);
    let across = rows(length, width, along).div_ceil(2) * 2;
    let Square { places, triangles, rows } = square(along, across);
    // A square goes to a disk, x = u √(1 − v²/2), y = v √(1 − u²/2).
    let nodes = places.iter().map(|[s, t]| {
        let (u, v) = (2.0 * s - 1.0, 2.0 * t - 1.0);
        let (x, y) = (u * (1.0 - 0.5 * v * v).sqrt(), v * (1.0 - 0.5 * u * u).sqrt());
        [0.5 * length * (1.0 + x), 0.5 * width * y, 0.0]
    });
    let nodes = nodes.collect();
    let chains = sides(&rows).into_iter().filter(|chain| ["root", "tip"].contains(&&chain.name[..])).collect();
    Mesh { nodes, triangles, chains }
}

/// Return a simplified insect wing: `span` along x, `chord` the largest depth towards negative y, `along` edges a vein.
///
/// The outline is not that of a species. Like the wings of flies it has a nearly straight leading edge, a rounded tip
/// and its largest depth beyond the middle of the span. Straight rays run from the root, a line of a tenth of the chord on
/// the y axis, to the outline. Five of them carry the names of veins of an insect: `costa` (the leading edge),
/// `radius`, `media`, `cubitus` and `anal`. Further chains: `root`, and `margin`, the outline from costa to anal.
pub fn insect_wing(span: f64, chord: f64, along: usize) -> Mesh {
    let along = along.max(4);
    // A multiple of four rows puts every vein on a row.
    let across = (along * 2 / 3).div_ceil(4).max(2) * 4;
    let Square { places, triangles, rows } = square(along, across);
    let root = 0.1 * chord;
    let nodes = places.iter().map(|&[s, t]| {
        let begin = [0.0, -root * t];
        let [x, y] = margin(t);
        let end = [span * x, chord * y];
        [begin[0] + s * (end[0] - begin[0]), begin[1] + s * (end[1] - begin[1]), 0.0]
    });
    let nodes: Vec<[f64; 3]> = nodes.collect();
    let mut chains: Vec<_> = VEINS
        .iter()
        .map(|&(name, share)| Chain { name: name.into(), nodes: rows[(share * across as f64) as usize].clone() })
        .collect();
    chains.push(Chain { name: "root".into(), nodes: rows.iter().filter_map(|row| row.first().copied()).collect() });
    chains.push(Chain { name: "margin".into(), nodes: rows.iter().filter_map(|row| row.last().copied()).collect() });
    Mesh { nodes, triangles, chains }
}

/// Return a point of the outline of [`insect_wing`], by span and chord, for t from 0 (costa) to 1 (anal).
///
/// Two halves of ellipses meet at the tip, (1, −0.45); the outline runs from 60° before it to 130° behind it.
fn margin(t: f64) -> [f64; 2] {
    let (sin, cos) = (60.0 - 190.0 * t).to_radians().sin_cos();
    [0.55 + 0.45 * cos, -0.45 + if sin > 0.0 { 0.45 * sin } else { 0.55 * sin }]
}

/// Return the sides of a mesh of the unit square.
fn sides(rows: &[Vec<usize>]) -> Vec<Chain> {
    let ends = |pick: fn(&Vec<usize>) -> Option<&usize>| rows.iter().filter_map(|row| pick(row).copied()).collect();
    vec![
        Chain { name: "root".into(), nodes: ends(|row| row.first()) },
        Chain { name: "tip".into(), nodes: ends(|row| row.last()) },
        Chain { name: "right".into(), nodes: rows[0].clone() },
        Chain { name: "left".into(), nodes: rows[rows.len() - 1].clone() },
    ]
}
