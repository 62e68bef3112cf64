//! Contact of the membrane with itself.
//!
//! The membrane has a skin of [`SKIN`] ranges on each side, which no force lets another part reach. Points that divide
//! its edges touch the closest points of other layers, and each side of a pair counts half. Of one layer only the
//! closest triangle counts: it is found among the neighbours of the last one, at most all triangles away.
//!
//! A pair couples nodes that are no neighbours, outside the pattern of Newton's matrix, which takes twice the stiffness
//! on each side alone as that of a rod does: at least the true coupling, so updates descend.

use std::f64::consts::FRAC_PI_2;

use ::contact::{
    Cells, ContactError, Encounter, Law, MOST_PARTNERS, Meeting, SurfacePoint, keep_one_of_each_bend,
    nearest_of_triangle, points_of_surface,
};
use mesh::Mesh;
use nalgebra::Matrix3;

use crate::face::Face;
use crate::geometry::{Geometry, Vector};
use crate::parameters::SKIN;

/// Motion of a node beyond the first guess that the search allows for, over the distance at which layers touch: so small
/// that it finds nothing in a flat wing, of which points closer than π/2 of that distance are left out.
const MARGIN: f64 = 0.2;

/// Distance up to which an equilibrium seeks layers, over that at which they touch.
const STATIC_SEARCH: f64 = 3.0;

/// A point of the membrane: its triangle, and the shares of the corners.
#[derive(Clone, Copy)]
pub(crate) struct Spot {
    pub(crate) triangle: usize,
    pub(crate) shares: [f64; 3],
}

/// Closest point of a layer.
#[derive(Clone, Copy)]
struct Layer {
    spot: Spot,
    /// Vector from there, m.
    from: Vector,
    distance: f64,
}

/// Contact of a membrane with itself during a stage.
pub(crate) struct Itself {
    /// Forces per area.
    pub(crate) law: Law,
    /// Distance at which layers touch, m.
    touching: f64,
    surface: Surface,
    /// Largest motion of a node in the stage that the search allows for, m.
    allowed: f64,
    cells: Cells<3>,
    middles: Vec<Vector>,
    /// Triangles near that of a point.
    candidates: Vec<u32>,
    /// Triangles near which each point may touch, one a layer; those of point m end at `ends[m]`.
    partners: Vec<u32>,
    ends: Vec<usize>,
    /// Shape of the last search, m, and by how much layers may come closer there, m.
    searched: Vec<Vector>,
    closer: f64,
}

/// Points of the membrane, and what is beside them at rest.
struct Surface {
    /// Distance at rest of points that touch, m: half a circle of the diameter at which layers touch.
    apart: f64,
    points: Vec<SurfacePoint>,
    /// Corners of the triangles at rest, m.
    rest_corners: Vec<[Vector; 3]>,
    /// Triangles that are no farther from each point at rest than `apart`; those of point m end at `beside_ends[m]`.
    beside: Vec<u32>,
    beside_ends: Vec<usize>,
    /// Triangles that share a node with each one.
    neighbours: Vec<Vec<u32>>,
}

impl Itself {
    /// Return the contact with itself of a wing whose solids touch by `law`, with so many `parts` of an edge.
    pub(crate) fn new(law: &Law, mesh: &Mesh, parts: usize) -> Self {
        let points = points_of_surface(&mesh.nodes, &mesh.triangles, parts);
        let rest_corners: Vec<_> = mesh.triangles.iter().map(|corners| corners.map(|k| mesh.node(k))).collect();
        let mut of_node = vec![Vec::new(); mesh.nodes.len()];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            corners.iter().for_each(|&k| of_node[k].push(t as u32));
        }
        let neighbours = mesh.triangles.iter().enumerate().map(|(t, corners)| {
            let mut all: Vec<_> = corners.iter().flat_map(|&k| of_node[k].iter().copied()).collect();
            all.sort_unstable();
            all.dedup();
            all.retain(|&other| other as usize != t);
            all
        });
        let (skin, apart) = (SKIN * law.range, FRAC_PI_2 * law.range);
        let rest_middles: Vec<_> = rest_corners.iter().map(|[a, b, c]| (a + b + c) / 3.0).collect();
        let around = rest_corners.iter().zip(&rest_middles).flat_map(|(corners, m)| corners.map(|c| (c - m).norm()));
        let mut cells = Cells::new(rest_corners.len());
        cells.sort(apart + around.fold(0.0, f64::max), rest_middles.iter().map(|middle| (*middle).into()));
        let (mut beside, mut beside_ends) = (Vec::new(), Vec::new());
        for point in &points {
            let p = point.of(rest_corners[point.triangle]);
            cells.visit(p.into(), |t| {
                let [a, b, c] = rest_corners[t];
                let [u, v, w] = nearest_of_triangle(p, rest_corners[t]);
                if (p - a * u - b * v - c * w).norm() <= apart {
                    beside.push(t as u32);
                }
            });
            beside_ends.push(beside.len());
        }
        Self {
            // Two layers are springs in series.
            law: Law { range: law.range - 2.0 * skin, stiffness: 0.5 * law.stiffness, depth: skin, ..*law },
            touching: law.range,
            allowed: f64::INFINITY,
            cells,
            candidates: Vec::with_capacity(rest_corners.len()),
            middles: vec![Vector::zeros(); rest_corners.len()],
            partners: Vec::with_capacity((MOST_PARTNERS + 1) * points.len()),
            ends: vec![0; points.len()],
            searched: vec![Vector::repeat(f64::NAN); mesh.nodes.len()],
            closer: 0.0,
            surface: Surface { apart, neighbours: neighbours.collect(), beside, beside_ends, rest_corners, points },
        }
    }

    /// Begin a stage from `origin` to the first guess `guess`, m.
    pub(crate) fn begin(&mut self, faces: &[Face], origin: &[Vector], guess: &[Vector]) -> Result<(), ContactError> {
        let predicted = origin.iter().zip(guess).map(|(x, guess)| (guess - x).norm()).fold(0.0, f64::max);
        self.allowed = predicted + MARGIN * self.touching;
        self.search(faces, origin, 2.0 * self.allowed)
    }

    /// Begin an equilibrium from the shape `origin`, m.
    pub(crate) fn begin_static(&mut self, faces: &[Face], origin: &[Vector]) -> Result<(), ContactError> {
        self.allowed = f64::INFINITY;
        self.search(faces, origin, (STATIC_SEARCH - 1.0) * self.touching)
    }

    /// Begin a stage in which nodes move by this distance, m: find what [`Itself::begin`] then needs in most cases.
    pub(crate) fn search_ahead(&mut self, faces: &[Face], x: &[Vector], moved: f64) -> Result<(), ContactError> {
        self.search(faces, x, 2.0 * (moved + MARGIN * self.touching))
    }

    /// Find the layers that each point may touch if they come closer by `closer`, m. More than these stay where the last
    /// search was for the same shape.
    pub(crate) fn search(&mut self, faces: &[Face], x: &[Vector], closer: f64) -> Result<(), ContactError> {
        if self.searched == x && closer <= self.closer {
            return Ok(());
        }
        self.closer = f64::NEG_INFINITY; // until nothing has failed
        let Self { surface, touching, cells, middles, candidates, partners, ends, .. } = self;
        let mut around = 0.0_f64;
        for (middle, face) in middles.iter_mut().zip(faces) {
            let corners = face.nodes.map(|k| x[k]);
            *middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            corners.iter().for_each(|corner| around = around.max((corner - *middle).norm_squared()));
        }
        let near = *touching + closer;
        let around = around.sqrt();
        let size = near + 2.0 * around;
        cells.sort(size, middles.iter().map(|middle| (*middle).into()));
        let mut of = usize::MAX;
        partners.clear();
        let crowded = surface.points.iter().enumerate().find_map(|(m, point)| {
            if point.triangle != of {
                of = point.triangle;
                candidates.clear();
                let middle = middles[of];
                let is_near = |t: usize| (middle - middles[t]).norm_squared() <= size * size;
                cells.visit(middle.into(), |t| candidates.extend(is_near(t).then_some(t as u32)));
            }
            let found = surface.find_layers(faces, x, m, [near, near + around], (middles, candidates), partners);
            ends[m] = partners.len();
            (found > MOST_PARTNERS).then(|| ContactError::Crowded {
                node: faces[point.triangle].nodes[0],
                found,
                most: MOST_PARTNERS,
            })
        });
        crowded.map_or(Ok(()), Err)?;
        self.searched.copy_from_slice(x);
        self.closer = closer;
        Ok(())
    }

    /// Visit each point that may touch another layer in the shape `x` of a stage from `origin`, m.
    pub(crate) fn visit(
        &self,
        faces: &[Face],
        x: &[Vector],
        origin: &[Vector],
        mut visit: impl FnMut(Meeting<Spot, 3>),
    ) {
        let mut begin = 0;
        let Self { surface, .. } = self;
        for (m, point) in surface.points.iter().enumerate() {
            let partners = &self.partners[begin..self.ends[m]];
            begin = self.ends[m];
            if partners.is_empty() {
                continue;
            }
            let (p, p_before) = (surface.at(faces, x, m), surface.at(faces, origin, m));
            for &t in partners {
                let before = surface.walk(faces, origin, p_before, m, t as usize);
                let now = surface.walk(faces, x, p, m, t as usize);
                let both = [before, now];
                let met = Encounter {
                    distances: both.map(|own| own.distance),
                    gaps: both.map(|own| own.distance - 2.0 * self.law.depth),
                    normals: both.map(|own| own.from / own.distance.max(f64::MIN_POSITIVE)),
                    curvature: Matrix3::zeros(),
                    slip: p - before.spot.on(faces, x) - before.from,
                };
                let spot = Spot { triangle: point.triangle, shares: point.shares };
                visit(Meeting { spot, size: 0.5 * point.area, partners: Some([before.spot, now.spot]), met });
            }
        }
    }

    /// Refuse a stage from `origin` to `x`, m, in which nodes move farther than the search allows for.
    pub(crate) fn check(&self, x: &[Vector], origin: &[Vector]) -> Result<(), ContactError> {
        let moved = x.iter().zip(origin).map(|(x, before)| (x - before).norm()).fold(0.0, f64::max);
        if moved > self.allowed { Err(ContactError::Hasty { moved, allowed: self.allowed }) } else { Ok(()) }
    }
}

impl Surface {
    /// Add those `candidates` of the layers that come closer to point `m` than `near`, whose `middles` are closer than
    /// `size` (m), to `partners`; return how many there were, of which at most [`MOST_PARTNERS`] are added.
    fn find_layers(
        &self,
        faces: &[Face],
        x: &[Vector],
        m: usize,
        [near, size]: [f64; 2],
        (middles, candidates): (&[Vector], &[u32]),
        partners: &mut Vec<u32>,
    ) -> usize {
        let (p, begin, mut found) = (self.at(faces, x, m), partners.len(), 0);
        for t in candidates.iter().map(|&t| t as usize) {
            if (p - middles[t]).norm_squared() > size * size || !self.is_apart(m, t) {
                continue;
            }
            let layer = layer(faces, x, p, t);
            if layer.distance < near && self.is_closest(faces, x, p, m, &layer) {
                found += 1;
                if found <= MOST_PARTNERS {
                    partners.push(t as u32);
                }
            }
        }
        let place = |t: u32| {
            let ([a, b, c], shares) = (self.rest_corners[t as usize], layer(faces, x, p, t as usize).spot.shares);
            a * shares[0] + b * shares[1] + c * shares[2]
        };
        let distance = |t: u32| layer(faces, x, p, t as usize).distance;
        keep_one_of_each_bend(partners, begin, distance, |s, t| (place(s) - place(t)).norm() > self.apart);
        found
    }

    /// Return the place of point `m` in the shape `x`, m.
    fn at(&self, faces: &[Face], x: &[Vector], m: usize) -> Vector {
        let point = &self.points[m];
        point.of(faces[point.triangle].nodes.map(|k| x[k]))
    }

    /// Return whether point `m` and triangle `t` are so far apart at rest that they may touch.
    fn is_apart(&self, m: usize, t: usize) -> bool {
        let begin = if m == 0 { 0 } else { self.beside_ends[m - 1] };
        !self.beside[begin..self.beside_ends[m]].contains(&(t as u32))
    }

    /// Return the closest points to `p` on the triangles that share the edge or the node on which that of a layer lies.
    fn beside<'a>(
        &'a self,
        faces: &'a [Face],
        x: &'a [Vector],
        p: Vector,
        Spot { triangle, shares }: Spot,
    ) -> impl Iterator<Item = Layer> + 'a {
        let is_inside = shares.iter().all(|share| *share > 0.0);
        let neighbours = if is_inside { &[][..] } else { &self.neighbours[triangle] };
        let touches = move |t: usize| {
            let own = faces[triangle].nodes.into_iter().zip(shares).filter(|(_, share)| *share > 0.0);
            own.fold(true, |all, (node, _)| all && faces[t].nodes.contains(&node))
        };
        neighbours.iter().map(|&t| t as usize).filter(move |&t| touches(t)).map(move |t| layer(faces, x, p, t))
    }

    /// Return whether the closest point to `p`, which is point `m`, of a triangle is that of the membrane around it.
    fn is_closest(&self, faces: &[Face], x: &[Vector], p: Vector, m: usize, own: &Layer) -> bool {
        let order = |layer: &Layer| (layer.distance, layer.spot.triangle);
        let mut beside = self.beside(faces, x, p, own.spot);
        beside.all(|other| order(own) < order(&other) || !self.is_apart(m, other.spot.triangle))
    }

    /// Return the closest point to `p`, which is point `m`, of the layer near triangle `t`.
    fn walk(&self, faces: &[Face], x: &[Vector], p: Vector, m: usize, t: usize) -> Layer {
        let mut best = layer(faces, x, p, t);
        loop {
            let closer = |other: &Layer| other.distance < best.distance && self.is_apart(m, other.spot.triangle);
            let next = self.beside(faces, x, p, best.spot).filter(closer);
            match next.min_by(|a, b| a.distance.total_cmp(&b.distance)) {
                Some(next) => best = next,
                None => return best,
            }
        }
    }
}

impl Spot {
    /// Return its place in the shape `x`, m.
    fn on(self, faces: &[Face], x: &[Vector]) -> Vector {
        let [a, b, c] = faces[self.triangle].nodes.map(|k| x[k]);
        a * self.shares[0] + b * self.shares[1] + c * self.shares[2]
    }
}

/// Return the closest point to `p` of triangle `t`.
fn layer(faces: &[Face], x: &[Vector], p: Vector, t: usize) -> Layer {
    let shares = nearest_of_triangle(p, faces[t].nodes.map(|k| x[k]));
    let spot = Spot { triangle: t, shares };
    let from = p - spot.on(faces, x);
    Layer { spot, from, distance: from.norm() }
}
