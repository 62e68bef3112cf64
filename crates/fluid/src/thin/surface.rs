//! A surface of triangles in patches of about the same area, one for each marker.
//!
//! The patches are a centroidal Voronoi partition of the surface at rest, so that markers, the centres of the patches,
//! keep their distance on any mesh.

use std::ops::Range;

use mesh::triangle_area;

use super::parts::Parts;
use crate::space::{Kinematics, Space, Vector};

/// Root of the area of a patch, cells. At 1.5 a floppy sheet without mass is unstable with its lumped impedance,
/// because each marker has six neighbours; at 2 a disk leaks, and lacks a sixth of its added mass.
const SPACING_CELLS: f64 = 1.75;

/// Length of the grains that make the patches, by the size of a patch.
const GRAIN: f64 = 0.2;

/// Width of the rim, cells, in which the weight of a grain in the centre of its patch falls to 0 at the edge. It draws
/// the markers in, because the kernel reaches beyond them. With it the forces on a plate in a stream change least with the
/// grid.
const RIM: f64 = 0.5;

/// Distance of the centres of patches around one, by the size of a patch: beyond the six of a honeycomb, below the next.
const AROUND: f64 = 1.5;

/// Rounds in which each patch becomes what is nearest to its centre.
const ROUNDS: usize = 40;

/// Relative difference of squares of distances that is none: rounding, which differs with the place of a surface, must not
/// decide between grains or centres that symmetry makes equally far. The first of them is taken.
const TIE: f64 = 1e-6;

/// Most blocks of centres along an axis.
const MOST_BLOCKS: f64 = 64.0;

/// A small triangle: its middle, its area, the area that counts for the centre of its patch, and the shares of nodes in
/// the middle.
struct Grain {
    middle: [f64; 3],
    area: f64,
    weight: f64,
    shares: [(usize, f64); 3],
}

impl Grain {
    /// Return the nodes of the triangle that it is of.
    fn corners(&self) -> [usize; 3] {
        self.shares.map(|(node, _)| node)
    }
}

/// Return the number of markers of a surface of an area (m²) on cells of a size (m).
pub fn count(area: f64, cell: f64) -> f64 {
    ((1.0 + TIE) * area / (SPACING_CELLS * cell).powi(2)).round().max(1.0)
}

/// The patches of a surface.
pub struct Patches {
    /// Shares of the nodes in each.
    pub parts: Parts,
    /// Triangles of each.
    pub facets: Facets,
    /// Areas, m².
    pub areas: Vec<f64>,
    /// Distances from the nearest free edge, of a closed surface the root of its area, m.
    pub edges: Vec<f64>,
    /// Numbers of the patches around each.
    pub around: Vec<Vec<usize>>,
}

/// Triangles of each patch, with their shares of its area.
#[derive(Default)]
pub struct Facets {
    patches: Vec<Range<usize>>,
    triangles: Vec<([usize; 3], f64)>,
}

impl Facets {
    /// Return the normal of a patch at places of the nodes (m), of any length.
    pub fn normal<const D: usize>(&self, patch: usize, places: &[Vec<f64>; D]) -> Vector<D>
    where
        [f64; D]: Space<D>,
    {
        let at = |node: usize| Vector::from(places.each_ref().map(|along| along[node]));
        let normals = self.triangles[self.patches[patch].clone()].iter().map(|([a, b, c], share)| {
            let normal = <[f64; D]>::components(<[f64; D]>::cross(&(at(*b) - at(*a)), &(at(*c) - at(*a))));
            Vector::from_fn(|axis, _| share * normal[axis])
        });
        normals.sum()
    }
}

/// Return the patches of a surface on cells of a size (m), the first one for the marker `first`.
pub fn patches(nodes: &[[f64; 3]], triangles: &[[usize; 3]], cell: f64, first: usize) -> Patches {
    let mut grains = grains(nodes, triangles, GRAIN * SPACING_CELLS * cell);
    let edges: Vec<_> = free_edges(triangles).into_iter().map(|ends| ends.map(|node| nodes[node])).collect();
    let whole = grains.iter().map(|grain| grain.area).sum::<f64>();
    let from_edge = |point: &[f64; 3]| edges.iter().map(|ends| from_line(point, ends)).fold(whole, f64::min).sqrt();
    for grain in &mut grains {
        grain.weight = grain.area * (from_edge(&grain.middle) / (RIM * cell)).min(1.0);
    }
    let total = grains.iter().map(|grain| grain.area).sum::<f64>();
    let mut centres = spread_out(&grains, count(total, cell) as usize);
    let spacing = (total / centres.len() as f64).sqrt();
    let mut patches = vec![0; grains.len()];
    for _ in 0..ROUNDS {
        let blocks = Blocks::new(&centres, 2.0 * spacing);
        patches.iter_mut().zip(&grains).for_each(|(patch, grain)| *patch = blocks.nearest(&centres, grain.middle));
        let mut sums = vec![[0.0; 4]; centres.len()];
        for (patch, Grain { middle: [x, y, z], weight, .. }) in patches.iter().zip(&grains) {
            let moments = [weight * x, weight * y, weight * z, *weight];
            sums[*patch].iter_mut().zip(moments).for_each(|(sum, moment)| *sum += moment);
        }
        for (centre, [x, y, z, weight]) in centres.iter_mut().zip(sums).filter(|(_, sums)| sums[3] > 0.0) {
            *centre = [x, y, z].map(|sum| sum / weight);
        }
    }
    let mut members = vec![Vec::new(); centres.len()];
    patches.iter().zip(&grains).for_each(|(patch, grain)| members[*patch].push(grain));
    let mut own = members.iter().map(|members| !members.is_empty());
    centres.retain(|_| own.next() == Some(true));
    members.retain(|members| !members.is_empty());
    let is_near = |a: usize, b: usize| a != b && square(&centres[a], &centres[b]) < (AROUND * spacing).powi(2);
    let around = (0..centres.len()).map(|a| (0..centres.len()).filter(|b| is_near(a, *b)).collect()).collect();
    let (mut parts, mut facets, mut areas, mut distances) = (Parts::new(first), Facets::default(), vec![], vec![]);
    for (members, centre) in members.iter().zip(&centres) {
        let weight = members.iter().map(|grain| grain.weight).sum::<f64>();
        let shares = members.iter().flat_map(|grain| grain.shares.map(|(node, share)| (node, share * grain.weight)));
        let mut shares: Vec<_> = shares.collect();
        shares.sort_by_key(|(node, _)| *node);
        let sum =
            |of_node: &[(usize, f64)]| (of_node[0].0, of_node.iter().map(|(_, share)| share).sum::<f64>() / weight);
        parts.add(|all| all.extend(shares.chunk_by(|a, b| a.0 == b.0).map(sum)));
        areas.push(members.iter().map(|grain| grain.area).sum());
        distances.push(from_edge(centre));
        let begin = facets.triangles.len();
        let of_triangle = members.chunk_by(|a, b| a.corners() == b.corners());
        facets.triangles.extend(of_triangle.map(|grains| {
            let triangle = grains[0].corners();
            let whole = triangle_area(&triangle.map(|node| nodes[node]));
            (triangle, grains.iter().map(|grain| grain.area).sum::<f64>() / whole)
        }));
        facets.patches.push(begin..facets.triangles.len());
    }
    Patches { parts, facets, areas, edges: distances, around }
}

/// Divide each triangle into equal ones with sides of at most `size` (m), but for a tie.
fn grains(nodes: &[[f64; 3]], triangles: &[[usize; 3]], size: f64) -> Vec<Grain> {
    let mut grains = Vec::new();
    for corners in triangles {
        let points = corners.map(|node| nodes[node]);
        let longest = (0..3).map(|k| square(&points[k], &points[(k + 1) % 3])).fold(0.0, f64::max).sqrt();
        let n = ((1.0 - TIE) * longest / size).ceil().max(1.0);
        let area = triangle_area(&points) / (n * n);
        let mut add = |weights: [f64; 3]| {
            let middle = [0, 1, 2].map(|axis| (0..3).map(|k| weights[k] * points[k][axis]).sum());
            grains.push(Grain { middle, area, weight: area, shares: [0, 1, 2].map(|k| (corners[k], weights[k])) });
        };
        for i in 0..n as usize {
            for j in 0..n as usize - i {
                let at = |third: f64| {
                    let (a, b) = ((i as f64 + third) / n, (j as f64 + third) / n);
                    [a, b, 1.0 - a - b]
                };
                add(at(1.0 / 3.0));
                if i + j + 1 < n as usize {
                    add(at(2.0 / 3.0));
                }
            }
        }
    }
    grains
}

/// Return the middles of `count` grains, each as far as possible from those before it, the first of those as far.
fn spread_out(grains: &[Grain], count: usize) -> Vec<[f64; 3]> {
    let mut distances = vec![f64::INFINITY; grains.len()];
    let (mut centres, mut farthest) = (Vec::with_capacity(count), 0);
    while centres.len() < count.min(grains.len()) {
        let centre = grains[farthest].middle;
        centres.push(centre);
        let mut most = -1.0;
        for (k, (distance, grain)) in distances.iter_mut().zip(grains).enumerate() {
            *distance = distance.min(square(&grain.middle, &centre));
            if *distance > (1.0 + TIE) * most {
                (most, farthest) = (*distance, k);
            }
        }
    }
    centres
}

/// Centres in cubic blocks.
struct Blocks {
    low: [f64; 3],
    size: f64,
    counts: [usize; 3],
    members: Vec<Vec<usize>>,
}

impl Blocks {
    /// Sort centres into blocks of at least a size (m).
    fn new(centres: &[[f64; 3]], size: f64) -> Self {
        let ends = |axis: usize| {
            let along = centres.iter().map(|centre| centre[axis]);
            (along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max))
        };
        let ends = [0, 1, 2].map(ends);
        let size = ends.iter().fold(size, |size, (low, high)| size.max((high - low) / MOST_BLOCKS));
        let counts = ends.map(|(low, high)| ((high - low) / size) as usize + 1);
        let mut blocks =
            Self { low: ends.map(|(low, _)| low), size, counts, members: vec![vec![]; counts.iter().product()] };
        for (k, centre) in centres.iter().enumerate() {
            let [x, y, z] = blocks.block(centre);
            blocks.members[(x * counts[1] + y) * counts[2] + z].push(k);
        }
        blocks
    }

    fn block(&self, point: &[f64; 3]) -> [usize; 3] {
        [0, 1, 2].map(|axis| (((point[axis] - self.low[axis]) / self.size) as usize).min(self.counts[axis] - 1))
    }

    /// Return the first of the centres nearest to a point, of all where none is in the blocks around it.
    fn nearest(&self, centres: &[[f64; 3]], point: [f64; 3]) -> usize {
        let block = self.block(&point);
        let [xs, ys, zs] =
            [0, 1, 2].map(|axis| block[axis].saturating_sub(1)..(block[axis] + 2).min(self.counts[axis]));
        let order = |a: &(f64, usize), b: &(f64, usize)| match (a.0 - b.0).abs() <= TIE * a.0 {
            true => a.1.cmp(&b.1),
            false => a.0.total_cmp(&b.0),
        };
        let nearest =
            |own: &mut dyn Iterator<Item = usize>| own.map(|k| (square(&centres[k], &point), k)).min_by(order);
        let [_, ny, nz] = self.counts;
        let around = xs.flat_map(|x| {
            let zs = &zs;
            ys.clone().flat_map(move |y| zs.clone().map(move |z| (x * ny + y) * nz + z))
        });
        let found = nearest(&mut around.flat_map(|block| self.members[block].iter().copied()));
        found.or_else(|| nearest(&mut (0..centres.len()))).map_or(0, |(_, k)| k)
    }
}

/// Return the edges of a single triangle.
fn free_edges(triangles: &[[usize; 3]]) -> Vec<[usize; 2]> {
    let edges = triangles.iter().flat_map(|corners| [0, 1, 2].map(|k| [corners[k], corners[(k + 1) % 3]]));
    let mut edges: Vec<_> = edges.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    edges.chunk_by(|a, b| a == b).filter(|same| same.len() == 1).map(|same| same[0]).collect()
}

/// Return the square of the distance of a point from a straight line between two.
fn from_line(point: &[f64; 3], [a, b]: &[[f64; 3]; 2]) -> f64 {
    let along = (0..3).map(|axis| (point[axis] - a[axis]) * (b[axis] - a[axis])).sum::<f64>() / square(a, b);
    let share = along.clamp(0.0, 1.0);
    square(point, &[0, 1, 2].map(|axis| a[axis] + share * (b[axis] - a[axis])))
}

fn square(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thin::Markers;
    use crate::thin::slip::Slip;
    use contact::{Loads, Stations};

    /// A rectangle of 1 m x 0.5 m in fine and in coarse triangles.
    fn rectangle(along: usize) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
        let mesh = scene::WingMesh::Rectangular { length: 1.0, width: 0.5, along }.build();
        (mesh.nodes, mesh.triangles)
    }

    #[test]
    fn patches_cover_the_surface_and_markers_keep_their_distance() {
        for along in [2, 40] {
            let ((nodes, triangles), cell) = (rectangle(along), 1.0 / 24.0);
            let Patches { parts, areas, .. } = patches(&nodes, &triangles, cell, 0);
            assert!((areas.iter().sum::<f64>() - 0.5).abs() < 1e-12);
            let mean = areas.iter().sum::<f64>() / areas.len() as f64;
            let centre = |shares: &[(usize, f64)]| {
                [0, 1, 2].map(|axis| shares.iter().map(|&(node, share)| share * nodes[node][axis]).sum::<f64>())
            };
            let centres: Vec<_> = parts.iter().map(|(_, shares)| centre(shares)).collect();
            for (k, area) in areas.iter().enumerate() {
                let others = centres.iter().enumerate().filter(|(j, _)| *j != k);
                let nearest = others.map(|(_, other)| square(other, &centres[k])).fold(f64::INFINITY, f64::min);
                assert!((1.2..2.5).contains(&(nearest.sqrt() / cell)), "{along}: {}", nearest.sqrt() / cell);
                assert!((0.5..1.6).contains(&(area / mean)), "{along}: {area} of {mean}");
            }
        }
    }

    /// A surface has the same markers wherever it is, though by symmetry many of its grains are equally far from a centre.
    #[test]
    fn markers_do_not_depend_on_the_place_of_the_surface() {
        let meshes = [2, 6].map(|along| (format!("a rectangle of {along}"), rectangle(along)));
        let disk = scene::WingMesh::Elliptical { length: 1.0, width: 1.0, along: 12 }.build();
        for (name, (nodes, triangles)) in meshes.into_iter().chain([("a disk".into(), (disk.nodes, disk.triangles))]) {
            let own = patches(&nodes, &triangles, 1.0 / 12.0, 0);
            for angle in [0.3, 1.5 * std::f64::consts::PI] {
                let (sin, cos) = f64::sin_cos(angle);
                let turned = nodes.iter().map(|[x, y, z]| [cos * x - sin * z + 0.7, y - 0.3, sin * x + cos * z]);
                let other = patches(&turned.collect::<Vec<_>>(), &triangles, 1.0 / 12.0, 0);
                assert_eq!(own.areas.len(), other.areas.len(), "{name}, {angle}");
                for ((_, one), (_, two)) in own.parts.iter().zip(other.parts.iter()) {
                    let off = one.iter().zip(two).map(|(a, b)| if a.0 == b.0 { (a.1 - b.1).abs() } else { 1.0 });
                    let off = off.fold(one.len().abs_diff(two.len()) as f64, f64::max);
                    assert!(off < 1e-9, "{name}, {angle}: shares differ by {off}");
                }
            }
        }
    }

    /// The power of the loads on the nodes is that of the forces on the markers.
    #[test]
    fn loads_go_back_by_the_transpose() {
        let (nodes, triangles) = rectangle(7);
        let Patches { parts, areas, .. } = patches(&nodes, &triangles, 0.05, 0);
        let mut markers = Markers::<3>::default();
        areas.iter().for_each(|area| markers.add(*area, *area, 1.0, Slip::default(), []));
        let mut stations = Stations::at_rest(&nodes);
        let any = |k: usize, axis: usize| (1.7 * k as f64 + 0.3 * axis as f64).sin();
        (0..nodes.len()).for_each(|k| (0..3).for_each(|axis| stations.velocity[axis][k] = any(k, axis)));
        parts.place(&stations, &mut markers);
        let force: Vec<_> = (0..areas.len()).map(|k| Vector::<3>::from_fn(|axis, _| any(3 * k, axis))).collect();
        let mut loads = Loads::none(nodes.len());
        parts.collect(|k| force[k], &vec![1.0; areas.len()], 2.0, &mut loads);
        let on_nodes = (0..3).map(|axis| (0..nodes.len()).map(move |k| (axis, k)));
        let power: f64 = on_nodes.flatten().map(|(axis, k)| loads.force[axis][k] * stations.velocity[axis][k]).sum();
        let on_markers = |k: usize| force[k].dot(&markers.get(k).velocity);
        let expected = 2.0 * (0..areas.len()).map(on_markers).sum::<f64>();
        assert!((power - expected).abs() < 1e-12 && expected.abs() > 0.1, "{power} against {expected}");
        assert!(loads.impedance.iter().all(|impedance| *impedance > 0.0));
        assert!((loads.impedance.iter().sum::<f64>() - 2.0 * areas.len() as f64).abs() < 1e-10);
    }
}
