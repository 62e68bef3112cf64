//! Points by which a mesh of triangles touches.

use std::collections::HashMap;

use nalgebra::SVector;

/// A point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Number of the triangle.
    pub triangle: usize,
    /// Shares of its corners in the point.
    pub shares: [f64; 3],
    /// Area that belongs to the point, m².
    pub area: f64,
}

impl SurfacePoint {
    /// Return the mean of what the corners have, by their shares.
    #[inline]
    pub fn of<const D: usize>(&self, corners: [SVector<f64, D>; 3]) -> SVector<f64, D> {
        corners[0] * self.shares[0] + corners[1] * self.shares[1] + corners[2] * self.shares[2]
    }
}

/// Return the points that divide each edge of the triangles between these nodes (m) into equal `parts`: corners of small
/// triangles, each of which gives its corners a third of its area.
pub fn points_of_surface(nodes: &[[f64; 3]], triangles: &[[usize; 3]], parts: usize) -> Vec<SurfacePoint> {
    let mut points = Vec::<SurfacePoint>::new();
    let mut known = HashMap::new();
    for (triangle, corners) in triangles.iter().enumerate() {
        let [a, b, c] = corners.map(|k| SVector::<f64, 3>::from(nodes[k]));
        let third = 0.5 * (b - a).cross(&(c - a)).norm() / (3 * parts * parts) as f64;
        let mut add = |steps: [usize; 3]| {
            // Points of an edge belong to both of its triangles: there the third corner has no share.
            let mut place = [0, 1, 2].map(|i| (corners[i], steps[i])).map(|own| if own.1 == 0 { (0, 0) } else { own });
            place.sort_unstable();
            let number = *known.entry(place).or_insert_with(|| {
                let shares = steps.map(|steps| steps as f64 / parts as f64);
                points.push(SurfacePoint { triangle, shares, area: 0.0 });
                points.len() - 1
            });
            points[number].area += third;
        };
        for i in 0..parts {
            for j in 0..parts - i {
                let at = |i: usize, j: usize| [parts - i - j, i, j];
                [at(i, j), at(i + 1, j), at(i, j + 1)].into_iter().for_each(&mut add);
                if i + j + 1 < parts {
                    [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)].into_iter().for_each(&mut add);
                }
            }
        }
    }
    points
}

/// Return the closest point to `p` (m) of a triangle, as the shares of its corners (Ericson, Real-Time Collision Detection,
/// section 5.1.5).
pub fn nearest_of_triangle<const D: usize>(p: SVector<f64, D>, corners: [SVector<f64, D>; 3]) -> [f64; 3] {
    let [a, b, c] = corners;
    let (ab, ac) = (b - a, c - a);
    let along = |from: SVector<f64, D>| [ab.dot(&(p - from)), ac.dot(&(p - from))];
    let [[d1, d2], [d3, d4], [d5, d6]] = [a, b, c].map(along);
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    // Parts of the area opposite to the corners.
    let (of_a, of_b, of_c) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    let edge = |share: f64| [1.0 - share, share];
    if of_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let [a, b] = edge(d1 / (d1 - d3));
        return [a, b, 0.0];
    }
    if of_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let [a, c] = edge(d2 / (d2 - d6));
        return [a, 0.0, c];
    }
    let (from_b, from_c) = (d4 - d3, d5 - d6);
    if of_a <= 0.0 && from_b >= 0.0 && from_c >= 0.0 {
        let [b, c] = edge(from_b / (from_b + from_c));
        return [0.0, b, c];
    }
    [of_a, of_b, of_c].map(|part| part / (of_a + of_b + of_c))
}

#[cfg(test)]
mod tests {
    use super::*;

    type V = SVector<f64, 3>;

    const NODES: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.2], [0.0, 1.0, 0.1]];

    #[test]
    fn points_of_an_edge_come_once_and_all_areas_add_up() {
        let triangles = [[0, 1, 2], [0, 2, 3]];
        let area = |[i, j, k]: [usize; 3]| {
            let [a, b, c] = [i, j, k].map(|n| V::from(NODES[n]));
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        for parts in [1, 2, 5] {
            let points = points_of_surface(&NODES, &triangles, parts);
            assert_eq!(points.len(), (parts + 1) * (parts + 1), "{parts} parts");
            let sum: f64 = points.iter().map(|point| point.area).sum();
            assert!((sum - triangles.map(area).iter().sum::<f64>()).abs() < 1e-14, "{sum} m²");
            let at = |point: &SurfacePoint| point.of(triangles[point.triangle].map(|k| V::from(NODES[k])));
            for (i, one) in points.iter().enumerate() {
                assert!(points[..i].iter().all(|other| (at(one) - at(other)).norm() > 0.1 / parts as f64));
            }
        }
    }

    #[test]
    fn the_nearest_point_of_a_triangle_is_no_farther_than_any_other() {
        let corners = [0, 1, 2].map(|k| V::from(NODES[k]));
        let at = |[a, b, c]: [f64; 3]| corners[0] * a + corners[1] * b + corners[2] * c;
        for k in 0..500 {
            let part = |d: u32| f64::from((k * (7 + 6 * d) + 3 * d) % 97) / 97.0 * 3.0 - 1.0;
            let p = V::new(part(0), part(1), part(2));
            let shares = nearest_of_triangle(p, corners);
            assert!(shares.iter().all(|share| *share >= 0.0) && (shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let found = (p - at(shares)).norm();
            for (i, j) in (0..=40).flat_map(|i| (0..=40 - i).map(move |j| (i, j))) {
                let other = [f64::from(i) / 40.0, f64::from(j) / 40.0, f64::from(40 - i - j) / 40.0];
                assert!(found <= (p - at(other)).norm() + 1e-12, "{k}: {found} at {shares:?}, but {other:?}");
            }
        }
    }
}
