//! Polygons whose corners are in left-hand order.

use std::f64::consts::SQRT_2;

use crate::region::{Nearest, Section};

/// Points along each side of the bounding rectangle at which the search for the largest circle begins.
const SEARCH_POINTS: usize = 48;

/// Number of times that the search halves its stride.
const HALVINGS: usize = 30;

/// Return twice the area, positive if the corners are in left-hand order.
pub fn signed_area(corners: &[[f64; 2]]) -> f64 {
    sides(corners).map(|([x0, y0], [x1, y1])| x0 * y1 - x1 * y0).sum()
}

/// Return the sides, each from a corner to the next.
fn sides(corners: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]))
}

/// Return the area and its moments.
pub fn section(corners: &[[f64; 2]]) -> Section {
    // Green's theorem about the first corner, so that a place far from the origin costs no digits.
    let [x0, y0] = corners[0];
    let (mut area, mut first, mut second) = (0.0, [0.0; 2], 0.0);
    for (a, b) in sides(corners) {
        let [a, b] = [a, b].map(|[x, y]| [x - x0, y - y0]);
        let cross = a[0] * b[1] - a[1] * b[0];
        area += 0.5 * cross;
        (0..2).for_each(|axis| first[axis] += cross / 6.0 * (a[axis] + b[axis]));
        second += (0..2).map(|i| cross / 12.0 * (a[i] * a[i] + a[i] * b[i] + b[i] * b[i])).sum::<f64>();
    }
    let [cx, cy] = first.map(|moment| moment / area);
    Section { area, centroid: [x0 + cx, y0 + cy], polar: second - area * (cx * cx + cy * cy) }
}

/// Return the nearest point of the outline. A convex corner is nearest to points in the fluid only, a concave one to
/// points in the body only.
pub fn nearest(point: [f64; 2], corners: &[[f64; 2]]) -> Nearest<2> {
    let (mut least, mut side, mut corner) = (f64::INFINITY, 0, None);
    for (i, (a, b)) in sides(corners).enumerate() {
        let (along, offset) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
        let fraction = (offset[0] * along[0] + offset[1] * along[1]) / (along[0] * along[0] + along[1] * along[1]);
        let at = fraction.clamp(0.0, 1.0);
        let distance = (offset[0] - at * along[0]).hypot(offset[1] - at * along[1]);
        if distance < least {
            // The corner at the beginning of a side has the number of the side.
            corner = if fraction <= 0.0 {
                Some(i)
            } else if fraction >= 1.0 {
                Some((i + 1) % corners.len())
            } else {
                None
            };
            (least, side) = (distance, i);
        }
    }
    // Distance to the line of a side, and its normal.
    let line = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let normal = [(b[1] - a[1]) / length, (a[0] - b[0]) / length];
        ((point[0] - a[0]) * normal[0] + (point[1] - a[1]) * normal[1], normal)
    };
    let Some(corner) = corner else {
        let (distance, normal) = line(side);
        return Nearest { distance, surface: [0, 1].map(|axis| point[axis] - distance * normal[axis]), normal };
    };
    let before = (corner + corners.len() - 1) % corners.len();
    let (one, other) = (line(before), line(corner));
    let points_outwards = one.1[0] * other.1[1] - one.1[1] * other.1[0] >= 0.0;
    if points_outwards {
        let (distance, normal) = if one.0 > other.0 { one } else { other };
        // Cut corners sharper than a right angle: lines of equal distance would reach far beyond them.
        let distance = distance.max(least / SQRT_2);
        Nearest { distance, surface: [0, 1].map(|axis| point[axis] - distance * normal[axis]), normal }
    } else {
        let surface = corners[corner];
        let normal = [0, 1].map(|axis| (surface[axis] - point[axis]) / least.max(f64::MIN_POSITIVE));
        Nearest { distance: -least, surface, normal }
    }
}

/// Return the radius of the largest circle inside, m: a pattern search from the deepest point of a grid.
pub fn depth(corners: &[[f64; 2]]) -> f64 {
    let range = |axis: usize| {
        let values = corners.iter().map(|corner| corner[axis]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        [low, high - low]
    };
    let ([x0, width], [y0, height]) = (range(0), range(1));
    let depth_at = |point: [f64; 2]| -nearest(point, corners).distance;
    let (mut best, mut deepest) = (corners[0], 0.0);
    let mut take = |point: [f64; 2], best: &mut [f64; 2]| {
        let there = depth_at(point);
        if there > deepest {
            (*best, deepest) = (point, there);
        }
    };
    for i in 0..SEARCH_POINTS * SEARCH_POINTS {
        let share = |k: usize| (k as f64 + 0.5) / SEARCH_POINTS as f64;
        take([x0 + width * share(i / SEARCH_POINTS), y0 + height * share(i % SEARCH_POINTS)], &mut best);
    }
    let mut stride = [width, height].map(|size| 0.5 * size / SEARCH_POINTS as f64);
    for _ in 0..HALVINGS {
        for (sx, sy) in
            [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
        {
            take([best[0] + sx * stride[0], best[1] + sy * stride[1]], &mut best);
        }
        stride = stride.map(|s| 0.5 * s);
    }
    deepest
}
