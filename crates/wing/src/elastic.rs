//! Elastic energy of the wing with gradient, in the order membrane, plate, veins.

use mesh::{Bend, Mesh, MeshEdge};
use nalgebra::Matrix3;

use crate::energy::Energy;
use crate::face::{Face, FaceShape};
use crate::geometry::{Geometry, Vector, refused};
use crate::parameters::{Parameters, Support, Vein};
use crate::plate::{Hinge, Side, compliance};
use crate::sparse::Symmetric;
use crate::twist::Twists;
use crate::vein::{Segment, Vertex};
use crate::{Error, WingError};

/// Largest turn of a hinge in a sub-step, rad: beyond it Newton's method may have found another solution, a fold.
const MOST_TURN: f64 = std::f64::consts::FRAC_PI_4;

/// Springs of the wing, with the scratch of the last evaluation.
pub(crate) struct Elastic {
    pub(crate) faces: Vec<Face>,
    pub(crate) hinges: Vec<Hinge>,
    /// Hinge at the edge opposite to each corner.
    pub(crate) face_hinges: Vec<[Option<usize>; 3]>,
    pub(crate) segments: Vec<Segment>,
    pub(crate) vertices: Vec<Vertex>,
    pub(crate) twists: Twists,
    /// Inverse of C_T among the edges of a triangle that have a hinge, N m; 0 for other edges.
    pub(crate) bending: Vec<Matrix3<f64>>,
    /// Compliance of the torsion spring of each hinge, rad/(N m); 0 without a spring.
    pub(crate) springs: Vec<f64>,
    /// Factors of C; `None` without hinges.
    compliance: Option<Symmetric>,
    /// τ, s.
    pub(crate) relaxation_time: f64,
    /// Rotation of the support from rest, and its angular velocity, rad/s.
    pub(crate) support: Matrix3<f64>,
    pub(crate) omega: Vector,
    pub(crate) shapes: Vec<FaceShape>,
    /// Positions, m, and support of the normals and angles: `[nodes]`, or empty.
    found_at: (Vec<Vector>, Matrix3<f64>),
    /// Whether the moments are those of the angles, without rates.
    without_rates: bool,
    /// Angles of the hinges, rad, and those before a solve.
    turns: Vec<f64>,
    turns_before: Vec<f64>,
    /// Moments of the hinges, N m.
    pub(crate) moments: Vec<f64>,
    /// Stress of each triangle, N/m, and tension of each segment, N, in Newton's matrix.
    pub(crate) stresses: Vec<[f64; 3]>,
    pub(crate) tensions: Vec<f64>,
}

impl Elastic {
    /// Return the springs at rest; `held` tells the held nodes.
    pub(crate) fn new(parameters: &Parameters, held: &[bool]) -> Result<Self, Error> {
        let mesh = &parameters.mesh;
        let corners = |t: usize| mesh.triangles[t].map(|k| mesh.node(k));
        let triangles = 0..mesh.triangles.len();
        let faces: Vec<_> =
            triangles.clone().map(|t| Face::new(mesh.triangles[t], corners(t), parameters.membrane(t))).collect();
        let shapes: Vec<_> = triangles.clone().filter_map(|t| FaceShape::new(corners(t))).collect();
        let edges = mesh.edges().map_err(refused)?;
        let twists = Twists::new(parameters, held, &edges, &shapes)?;
        let (hinges, face_hinges) = hinges(parameters, held, &shapes, &edges, &twists);
        let mut compliances = Vec::new();
        let mut bending = vec![Matrix3::zeros(); faces.len()];
        for t in triangles.filter(|&t| face_hinges[t].iter().any(Option::is_some)) {
            let &crate::Membrane { bending_stiffness, poisson_ratio, .. } = parameters.membrane(t);
            let own = compliance(&faces[t], corners(t), bending_stiffness, poisson_ratio).ok_or(WingError::Singular)?;
            // The moment of an edge without a hinge is 0, so its rows and columns are left out.
            let on = face_hinges[t].map(|hinge| hinge.is_some());
            let among = Matrix3::from_fn(|i, j| if on[i] && on[j] { own[(i, j)] } else { f64::from(i == j) });
            let inverse = among.try_inverse().ok_or(WingError::Singular)?;
            bending[t] = Matrix3::from_fn(|i, j| if on[i] && on[j] { inverse[(i, j)] } else { 0.0 });
            for (i, hinge_i) in face_hinges[t].iter().enumerate() {
                for (j, hinge_j) in face_hinges[t].iter().enumerate() {
                    if let (&Some(row), &Some(column)) = (hinge_i, hinge_j)
                        && row >= column
                    {
                        compliances.push((row, column, own[(i, j)]));
                    }
                }
            }
        }
        let mut springs = vec![0.0; hinges.len()];
        if let Support::TorsionSpring { stiffness } = parameters.root.support {
            let length = |hinge: &Hinge| (mesh.node(hinge.nodes[1]) - mesh.node(hinge.nodes[0])).norm();
            let held = |hinge: &&Hinge| matches!(hinge.second, Side::Support(_));
            let whole: f64 = hinges.iter().filter(held).map(length).sum();
            for (e, hinge) in hinges.iter().enumerate().filter(|(_, hinge)| held(hinge)) {
                springs[e] = whole / (stiffness * length(hinge));
                compliances.push((e, e, springs[e]));
            }
        }
        let mut compliance = None;
        if !hinges.is_empty() {
            let places = compliances.iter().map(|&(i, j, _)| (j as u32, i as u32)).collect();
            let ends: Vec<_> = hinges.iter().map(|hinge| hinge.nodes.map(|k| mesh.node(k))).collect();
            let mut matrix = Symmetric::new(places, &ends)?;
            for &(i, j, value) in &compliances {
                let place = matrix.place(i, j);
                matrix.values[place] += value;
            }
            if !matrix.factorise() {
                return Err(WingError::Singular.into());
            }
            compliance = Some(matrix);
        }
        let (mut segments, mut vertices) = (Vec::new(), Vec::new());
        for vein in &parameters.veins {
            add_vein(vein, mesh, held, parameters.root.support, &mut segments, &mut vertices)?;
        }
        let mut elastic = Self {
            moments: vec![0.0; hinges.len()],
            stresses: vec![[0.0; 3]; faces.len()],
            tensions: vec![0.0; segments.len()],
            turns: Vec::with_capacity(hinges.len()),
            turns_before: vec![0.0; hinges.len()],
            faces,
            hinges,
            face_hinges,
            segments,
            vertices,
            twists,
            bending,
            springs,
            compliance,
            relaxation_time: parameters.relaxation_time,
            support: Matrix3::identity(),
            omega: Vector::zeros(),
            shapes,
            found_at: (Vec::with_capacity(mesh.nodes.len()), Matrix3::identity()),
            without_rates: false,
        };
        // The rest angles of the hinges are still 0.
        let rest: Vec<_> = (0..mesh.nodes.len()).map(|k| mesh.node(k)).collect();
        elastic.update(&rest, None)?;
        for (hinge, turn) in elastic.hinges.iter_mut().zip(&elastic.turns) {
            hinge.rest = *turn;
        }
        elastic.without_rates = false;
        Ok(elastic)
    }

    /// Find normals, angles and moments of the shape `x`, with velocities if they matter.
    pub(crate) fn update(&mut self, x: &[Vector], rates: Option<(&[Vector], f64)>) -> Result<(), WingError> {
        self.find_turns(x)?;
        if self.without_rates && rates.is_none() {
            return Ok(());
        }
        self.without_rates = rates.is_none();
        for ((hinge, turn), moment) in self.hinges.iter().zip(&self.turns).zip(&mut self.moments) {
            *moment = turn - hinge.rest;
        }
        if let Some((v, tau)) = rates {
            self.add_rates(x, v, tau);
        }
        if let Some(compliance) = &mut self.compliance {
            compliance.solve(&mut self.moments);
        }
        Ok(())
    }

    /// Add the rates of the angles in the shape `x` that moves at `v`, times `tau`, to the moments.
    fn add_rates(&mut self, x: &[Vector], v: &[Vector], tau: f64) {
        for ((shape, face), hinges) in self.shapes.iter().zip(&self.faces).zip(&self.face_hinges) {
            let out = Vector::from(face.nodes.map(|k| shape.normal.dot(&v[k])));
            let rates = shape.by_across * out * tau;
            for (hinge, rate) in hinges.iter().zip(&rates) {
                if let Some(e) = *hinge {
                    self.moments[e] += rate;
                }
            }
        }
        for (hinge, moment) in self.hinges.iter().zip(&mut self.moments) {
            match hinge.second {
                Side::Support(_) => *moment -= tau * self.omega.dot(&hinge.edge(x).normalize()),
                Side::Vein(strand, along) => *moment -= tau * along * self.twists.spins[strand],
                Side::Face(..) => (),
            }
        }
    }

    /// Find angles anew, as directors have changed.
    pub(crate) fn forget_shape(&mut self) {
        if !self.twists.strands.is_empty() {
            self.found_at.0.clear();
        }
    }

    /// Find normals and angles of the shape `x`, if they are not those of the last shape.
    fn find_turns(&mut self, x: &[Vector]) -> Result<(), WingError> {
        if self.found_at.0 == x && self.found_at.1 == self.support {
            return Ok(());
        }
        self.found_at.0.clear();
        self.without_rates = false;
        self.twists.carry(x, &self.support);
        for (shape, face) in self.shapes.iter_mut().zip(&self.faces) {
            let [a, b, _] = face.nodes;
            let lost = WingError::Fold { nodes: [a, b], what: "a triangle there has lost its area" };
            *shape = FaceShape::new(face.nodes.map(|k| x[k])).ok_or(lost)?;
        }
        self.turns.clear();
        for hinge in &self.hinges {
            let [a, b] = hinge.nodes;
            let folded = WingError::Fold {
                nodes: [a, b],
                what: "the triangles beside this edge turn by more than 160°; stiffer bending helps",
            };
            self.turns.push(hinge.turn(&self.shapes, &self.support, &self.twists).ok_or(folded)?);
        }
        self.found_at.0.extend_from_slice(x);
        self.found_at.1 = self.support;
        Ok(())
    }

    /// Return the elastic energies of the shape `x`; the others are 0.
    pub(crate) fn energy(&mut self, x: &[Vector]) -> Result<Energy, WingError> {
        self.update(x, None)?;
        let stretching: f64 = self.faces.iter().map(|face| face.energy(x)).sum();
        let turns = self.turns.iter().zip(&self.hinges).zip(&self.moments);
        let bending = turns.map(|((turn, hinge), moment)| 0.5 * moment * (turn - hinge.rest)).sum();
        let mut veins = 0.0;
        for Segment { nodes, length, stiffness, .. } in &self.segments {
            veins += 0.5 * stiffness * ((x[nodes[1]] - x[nodes[0]]).norm() - length).powi(2);
        }
        for vertex in &self.vertices {
            veins += vertex.energy(x, self.support * vertex.direction).ok_or_else(|| folded(vertex))?;
        }
        veins += self.twists.energy(&self.support)?;
        Ok(Energy { stretching, bending, veins, ..Energy::default() })
    }

    /// Return the sum of the tension at rest over the area, J.
    pub(crate) fn tension_energy(&self) -> f64 {
        self.faces.iter().map(Face::tension_energy).sum()
    }

    /// Write ∂U/∂x plus the viscous forces in the shape `x` that moves at `v` to `gradient`, N: `[nodes]`.
    pub(crate) fn gradient(&mut self, x: &[Vector], v: &[Vector], gradient: &mut [Vector]) -> Result<(), WingError> {
        let rates = self.rates(v);
        self.update(x, rates)?;
        gradient.fill(Vector::zeros());
        for ((shape, face), hinges) in self.shapes.iter().zip(&self.faces).zip(&self.face_hinges) {
            let moments = Vector::from(hinges.map(|hinge| hinge.map_or(0.0, |e| self.moments[e])));
            let out = shape.by_across.tr_mul(&moments);
            for ((&k, force), out) in face.nodes.iter().zip(face.gradient(x, rates)).zip(&out) {
                gradient[k] += force + shape.normal * *out;
            }
        }
        for &Segment { nodes: [a, b], length, stiffness, .. } in &self.segments {
            let edge = x[b] - x[a];
            let l = edge.norm();
            let rate = rates.map_or(0.0, |(v, tau)| tau * edge.dot(&(v[b] - v[a])) / l);
            let force = edge * (stiffness * (l - length + rate) / l);
            gradient[a] -= force;
            gradient[b] += force;
        }
        for vertex in &self.vertices {
            let [before, after] = vertex.gradient(x, self.support * vertex.direction).ok_or_else(|| folded(vertex))?;
            let [node, next] = vertex.nodes;
            if let Some(k) = vertex.before {
                gradient[k] -= before;
                gradient[node] += before;
            }
            gradient[node] -= after;
            gradient[next] += after;
        }
        if self.twists.strands.is_empty() {
            return Ok(());
        }
        self.twists.torques.fill(0.0);
        for (hinge, moment) in self.hinges.iter().zip(&self.moments) {
            if let Side::Vein(strand, along) = hinge.second {
                self.twists.torques[strand] -= along * moment;
            }
        }
        self.twists.add_gradient(x, &self.support, gradient)
    }

    /// Remember the angles of the hinges in the shape `x`.
    pub(crate) fn set_angles(&mut self, x: &[Vector]) -> Result<(), WingError> {
        self.find_turns(x)?;
        self.turns_before.copy_from_slice(&self.turns);
        Ok(())
    }

    /// Refuse the last shape if a hinge has turned too far from the angle that is remembered.
    pub(crate) fn check_angles(&self) -> Result<(), WingError> {
        let turned = self.turns.iter().zip(&self.turns_before).map(|(turn, before)| (turn - before).abs());
        match turned.zip(&self.hinges).find(|(turned, _)| *turned > MOST_TURN) {
            None => Ok(()),
            Some((_, &Hinge { nodes: [a, b], .. })) => Err(WingError::Fold {
                nodes: [a, b],
                what: "the triangles beside this edge turn by 45° in a sub-step; shorter steps help",
            }),
        }
    }

    /// Set the stresses and tensions of Newton's matrix to those of the shape `x` at rest.
    pub(crate) fn set_stresses(&mut self, x: &[Vector]) {
        for (stress, face) in self.stresses.iter_mut().zip(&self.faces) {
            *stress = face.stress(x, None).1;
        }
        for (tension, Segment { nodes: [a, b], length, stiffness, .. }) in self.tensions.iter_mut().zip(&self.segments)
        {
            *tension = stiffness * ((x[*b] - x[*a]).norm() - length);
        }
    }

    /// Set the stresses and tensions of Newton's matrix to those of the shape `x` that moves at `v`, plus the
    /// first-order change by the `update` of the nodes; `viscous` is 1 + τ dv/du.
    pub(crate) fn extrapolate_stresses(
        &mut self,
        x: &[Vector],
        v: &[Vector],
        viscous: f64,
        update: impl Fn(usize) -> Vector,
    ) {
        let rates = self.rates(v).map(|(_, tau)| (v, tau));
        for (stress, face) in self.stresses.iter_mut().zip(&self.faces) {
            let now = face.stress(x, rates).1;
            let change = face.stress_change(x, face.nodes.map(&update), viscous);
            *stress = std::array::from_fn(|i| now[i] + change[i]);
        }
        for (tension, Segment { nodes: [a, b], length, stiffness, .. }) in self.tensions.iter_mut().zip(&self.segments)
        {
            let edge = x[*b] - x[*a];
            let l = edge.norm();
            let change = (update(*b) - update(*a)).dot(&edge) / l;
            let rate = rates.map_or(0.0, |(v, tau)| tau * (v[*b] - v[*a]).dot(&edge) / l);
            *tension = stiffness * (l - length + rate + change * viscous);
        }
    }

    /// Return the velocities with τ, if there is damping.
    pub(crate) fn rates<'a>(&self, v: &'a [Vector]) -> Option<(&'a [Vector], f64)> {
        (self.relaxation_time > 0.0).then_some((v, self.relaxation_time))
    }

    /// Write M y to `product` with the consistent mass matrix M.
    pub(crate) fn mass_times(&self, y: &[Vector], product: &mut [Vector]) {
        product.fill(Vector::zeros());
        for face in &self.faces {
            let part = face.mass / 12.0;
            let sum: Vector = face.nodes.iter().map(|&k| y[k]).sum();
            face.nodes.iter().for_each(|&k| product[k] += (sum + y[k]) * part);
        }
        for &Segment { nodes: [a, b], mass, .. } in &self.segments {
            let part = mass / 6.0;
            product[a] += (y[a] * 2.0 + y[b]) * part;
            product[b] += (y[b] * 2.0 + y[a]) * part;
        }
    }
}

pub(crate) fn folded(vertex: &Vertex) -> WingError {
    WingError::Fold { nodes: vertex.nodes, what: "a vein folds back there" }
}

/// Return the edges with moments, and the hinge opposite to each corner of each triangle.
fn hinges(
    parameters: &Parameters,
    held: &[bool],
    shapes: &[FaceShape],
    edges: &[MeshEdge],
    twists: &Twists,
) -> (Vec<Hinge>, Vec<[Option<usize>; 3]>) {
    let mesh = &parameters.mesh;
    let bends = |t: usize| parameters.membrane(t).bending_stiffness > 0.0;
    let rigid = |t: usize| mesh.triangles[t].iter().all(|&k| held[k]);
    let supported = parameters.root.support != Support::Pinned;
    let mut hinges = Vec::new();
    let mut face_hinges = vec![[None; 3]; mesh.triangles.len()];
    for edge in edges {
        if let Some((strand, _)) = twists.between(edge.nodes).filter(|(strand, _)| !twists.strands[*strand].rigid) {
            for first in [Some(edge.first), edge.second].into_iter().flatten().filter(|(t, _)| bends(*t)) {
                let nodes = [1, 2].map(|k| mesh.triangles[first.0][(first.1 + k) % 3]);
                let along = if twists.strands[strand].nodes == nodes { 1.0 } else { -1.0 };
                face_hinges[first.0][first.1] = Some(hinges.len());
                hinges.push(Hinge { nodes, first, second: Side::Vein(strand, along), rest: 0.0 });
            }
            continue;
        }
        let ends_held = edge.nodes.iter().all(|&k| held[k]);
        // The first triangle of a hinge always bends; the second does, or it is part of the support.
        let (first, second) = match (edge.first, edge.second) {
            (first, Some(second)) if rigid(first.0) => (second, Some(first)),
            (first, second) => (first, second),
        };
        if rigid(first.0) || !bends(first.0) {
            continue;
        }
        let side = match second {
            Some((t, _)) if rigid(t) && supported => Side::Support(shapes[t].normal),
            Some((t, i)) if !rigid(t) && bends(t) => Side::Face(t, i),
            None if ends_held && supported => Side::Support(shapes[first.0].normal),
            _ => continue,
        };
        let place = Some(hinges.len());
        face_hinges[first.0][first.1] = place;
        if let Side::Face(t, i) = side {
            face_hinges[t][i] = place;
        }
        let nodes = [1, 2].map(|k| mesh.triangles[first.0][(first.1 + k) % 3]);
        hinges.push(Hinge { nodes, first, second: side, rest: 0.0 });
    }
    (hinges, face_hinges)
}

/// Add the springs of a vein.
fn add_vein(
    vein: &Vein,
    mesh: &Mesh,
    held: &[bool],
    support: Support,
    segments: &mut Vec<Segment>,
    vertices: &mut Vec<Vertex>,
) -> Result<(), Error> {
    if let Some((k, bend)) = mesh.bend(&vein.nodes)
        && (vein.bending_stiffness > 0.0 && vein.torsional_stiffness == 0.0 || bend != Bend::Turn)
    {
        let allowed = match bend {
            Bend::Point => "followed by a node at another place",
            _ => "on a straight line at rest: a curved vein needs a torsional stiffness",
        };
        return Err(Error::value(format!("veins.{}.nodes", vein.name), k, allowed));
    }
    let edges: Vec<_> = vein.nodes.windows(2).map(|ends| mesh.node(ends[1]) - mesh.node(ends[0])).collect();
    let rigid = |j: usize| held[vein.nodes[j]] && held[vein.nodes[j + 1]];
    for (j, edge) in edges.iter().enumerate() {
        let length = edge.norm();
        // Simpson's rule for μ and the diameter at the middle for EA.
        let [start, end] = [vein.diameter_at(j), vein.diameter_at(j + 1)];
        let middle = 0.5 * (start + end);
        segments.push(Segment {
            nodes: [vein.nodes[j], vein.nodes[j + 1]],
            length,
            stiffness: vein.axial_stiffness * middle * middle / length,
            mass: vein.line_density * length * (start * start + 4.0 * middle * middle + end * end) / 6.0,
        });
    }
    if vein.bending_stiffness == 0.0 || vein.torsional_stiffness > 0.0 {
        return Ok(());
    }
    // Half of each segment that bends belongs to the vertex.
    let half = |j: usize| if rigid(j) { 0.0 } else { 0.5 * edges[j].norm() };
    let stiffness = |i: usize, length: f64| vein.bending_stiffness * vein.diameter_at(i).powi(4) / length;
    for (i, edge) in edges.iter().enumerate() {
        let after = [vein.nodes[i], vein.nodes[i + 1]];
        let direction = edge.normalize();
        if i == 0 {
            if held[after[0]] && !rigid(0) && support == Support::Clamped {
                vertices.push(Vertex { before: None, nodes: after, direction, stiffness: stiffness(0, half(0)) });
            }
            continue;
        }
        let length = half(i - 1) + half(i);
        if length > 0.0 {
            let before = Some(vein.nodes[i - 1]);
            vertices.push(Vertex { before, nodes: after, direction, stiffness: stiffness(i, length) });
        }
    }
    Ok(())
}
