//! Newton's matrix: pattern and assembly.
//!
//! The unknowns are the free nodes, then the turns φ of directors (`twist`), then the turns α of the edges with
//! hinges. With the weights w of the masses, d
//! of the impedance and s of the elastic forces, and the Hessian ∂²U/∂x∂x at constant moments, the matrix of
//! the nodes is w M + d + s ∂²U/∂x∂x + s Bᵀ C⁻¹ B, B = ∂θ/∂x. The last term is full. But B = Σ B_T
//! and C = Σ C_T are sums over the triangles, and each triangle has moments of its own if α makes them equal on
//! both sides of each edge:
//!
//! ```text
//! δM_T = C_T⁻¹ (B_T δx ∓ α),     [ … + s Σ B_Tᵀ C_T⁻¹ B_T    ∓ s Σ B_Tᵀ C_T⁻¹ ]
//!                                [ ∓ s Σ C_T⁻¹ B_T             s Σ C_T⁻¹      ].
//! ```
//!
//! This is the hybrid form of Arnold & Brezzi (1985, RAIRO Modél. Math. Anal. Numér. 19, 7): positive definite where
//! the full matrix is, with neighbours alone. Damping multiplies C_T⁻¹ by 1 + τ dv/du.

use nalgebra::{Matrix3, Vector3};
use rod::VertexDerivatives;
use structure::Balance;

use crate::elastic::{Elastic, folded};
use crate::face::PAIRS;
use crate::geometry::Vector;
use crate::plate::{Side, add_hessian, stiffness};
use crate::sparse::Symmetric;
use crate::twist::{FREEDOMS, Joint};
use crate::{Error, WingError};

/// Place of an entry of a held node.
const NOWHERE: u32 = u32::MAX;

/// Places of the blocks (j, k) of three nodes, [`PAIRS`], row by row.
type Places = [[u32; 9]; 6];

/// Places of the entries of a joint of veins.
type JointPlaces = [[u32; FREEDOMS]; FREEDOMS];

/// Places of the entries of the turns of a triangle: by the components of its corners, and by its turns.
struct TurnPlaces {
    corners: [[u32; 9]; 3],
    turns: [[u32; 3]; 3],
    /// 1 in the first triangle of an edge, −1 in the second.
    signs: [f64; 3],
}

/// Newton's matrix with the places of the elements in it.
pub(crate) struct System {
    pub(crate) matrix: Symmetric,
    /// First unknown of each node; `None` at a held node.
    pub(crate) unknowns: Vec<Option<usize>>,
    /// Rotation of each node since the assembly: `[nodes]`.
    pub(crate) rotations: Vec<Matrix3<f64>>,
    /// Number of unknown positions.
    pub(crate) positions: usize,
    /// Places of the block of each node, row by row.
    nodes: Vec<[u32; 9]>,
    faces: Vec<Places>,
    segments: Vec<Places>,
    vertices: Vec<Places>,
    /// Places of the entries of each joint.
    joints: Vec<JointPlaces>,
    /// Unknown of the turn of each segment with a director; `None` if the root holds it.
    pub(crate) twists: Vec<Option<usize>>,
    turns: Vec<TurnPlaces>,
    springs: Vec<u32>,
    /// Unknowns of the update: `[order]`.
    pub(crate) update: Vec<f64>,
}

impl System {
    /// Return the matrix of the springs of a wing whose nodes are at `rest`, m, some of them `held`.
    pub(crate) fn new(elastic: &Elastic, held: &[bool], rest: &[Vector]) -> Result<Self, Error> {
        let mut positions = 0;
        let unknowns: Vec<_> = held
            .iter()
            .map(|held| {
                let first = positions;
                positions += if *held { 0 } else { 3 };
                (!held).then_some(first)
            })
            .collect();
        let mut order = positions;
        let twists = elastic.twists.strands.iter().map(|strand| {
            let unknown = (!strand.rigid).then_some(order);
            order += usize::from(!strand.rigid);
            unknown
        });
        let twists: Vec<_> = twists.collect();
        // An edge that the support clamps does not turn by itself.
        let turns = elastic.hinges.iter().zip(&elastic.springs).map(|(hinge, &spring)| {
            if let Side::Vein(strand, _) = hinge.second {
                return twists[strand];
            }
            let unknown = (matches!(hinge.second, Side::Face(..)) || spring > 0.0).then_some(order);
            order += usize::from(unknown.is_some());
            unknown
        });
        let turns: Vec<_> = turns.collect();
        let of_face = |t: usize| elastic.face_hinges[t].map(|hinge| hinge.and_then(|e| turns[e]));
        let mut pattern: Vec<(u32, u32)> = (0..order as u32).map(|i| (i, i)).collect();
        let mut add = |i: usize, j: usize| pattern.push((i.min(j) as u32, i.max(j) as u32));
        let triples = || {
            let faces = elastic.faces.iter().map(|face| face.nodes.map(Some));
            let segments =
                elastic.segments.iter().map(|segment| [None, Some(segment.nodes[0]), Some(segment.nodes[1])]);
            let vertices =
                elastic.vertices.iter().map(|vertex| [vertex.before, Some(vertex.nodes[0]), Some(vertex.nodes[1])]);
            faces.chain(segments).chain(vertices)
        };
        let first = |node: Option<usize>| node.and_then(|k| unknowns[k]);
        for nodes in triples() {
            for (j, k) in PAIRS {
                if let (Some(row), Some(column)) = (first(nodes[j]), first(nodes[k])) {
                    (0..9).for_each(|i| add(row + i / 3, column + i % 3));
                }
            }
        }
        for (t, face) in elastic.faces.iter().enumerate() {
            for turn in of_face(t).into_iter().flatten() {
                face.nodes.iter().filter_map(|&k| unknowns[k]).for_each(|k| (0..3).for_each(|i| add(turn, k + i)));
                of_face(t).into_iter().flatten().for_each(|other| add(turn, other));
            }
        }
        let freedoms = |joint: &Joint| -> [Option<usize>; FREEDOMS] {
            let strands = [joint.before, Some(joint.after)];
            std::array::from_fn(|i| match i {
                0..12 => unknowns[elastic.twists.strands[strands[i / 6]?].nodes[i / 3 % 2]].map(|first| first + i % 3),
                _ => twists[strands[i - 12]?],
            })
        };
        for joint in &elastic.twists.joints {
            let own = freedoms(joint);
            own.iter().flatten().for_each(|i| own.iter().flatten().for_each(|j| add(*i, *j)));
        }
        let mut ends = vec![[Vector::zeros(); 2]; order];
        let mut put = |i: usize, nodes: [usize; 2]| ends[i] = nodes.map(|k| rest[k]);
        for (k, first) in unknowns.iter().enumerate() {
            first.iter().for_each(|&first| (first..first + 3).for_each(|i| put(i, [k; 2])));
        }
        turns.iter().zip(&elastic.hinges).for_each(|(turn, hinge)| turn.iter().for_each(|i| put(*i, hinge.nodes)));
        twists
            .iter()
            .zip(&elastic.twists.strands)
            .for_each(|(turn, strand)| turn.iter().for_each(|i| put(*i, strand.nodes)));
        let matrix = Symmetric::new(pattern, &ends)?;

        let place = |i: usize, j: usize| matrix.place(i, j) as u32;
        let block = |row: Option<usize>, column: Option<usize>| {
            let (Some(row), Some(column)) = (row, column) else { return [NOWHERE; 9] };
            // A diagonal block goes into the lower triangle once.
            std::array::from_fn(|i| match row == column && i / 3 < i % 3 {
                true => NOWHERE,
                false => place(row + i / 3, column + i % 3),
            })
        };
        let mut blocks: Vec<Places> =
            triples().map(|nodes| PAIRS.map(|(j, k)| block(first(nodes[j]), first(nodes[k])))).collect();
        let nodes = unknowns.iter().map(|first| block(*first, *first)).collect();
        let vertices = blocks.split_off(elastic.faces.len() + elastic.segments.len());
        let segments = blocks.split_off(elastic.faces.len());
        let faces = elastic.faces.iter().enumerate().map(|(t, face)| {
            let turns = of_face(t);
            TurnPlaces {
                corners: turns.map(|turn| {
                    std::array::from_fn(|i| match (turn, unknowns[face.nodes[i / 3]]) {
                        (Some(turn), Some(first)) => place(turn, first + i % 3),
                        _ => NOWHERE,
                    })
                }),
                turns: std::array::from_fn(|i| {
                    std::array::from_fn(|j| match (turns[i], turns[j]) {
                        (Some(row), Some(column)) if row >= column => place(row, column),
                        _ => NOWHERE,
                    })
                }),
                signs: std::array::from_fn(|i| match elastic.face_hinges[t][i] {
                    Some(e) => match elastic.hinges[e].second {
                        Side::Vein(_, along) => along,
                        _ if elastic.hinges[e].first != (t, i) => -1.0,
                        _ => 1.0,
                    },
                    None => 1.0,
                }),
            }
        });
        let joints = elastic.twists.joints.iter().map(|joint| {
            let own = freedoms(joint);
            std::array::from_fn(|i| {
                std::array::from_fn(|j| match (own[i], own[j]) {
                    // Two freedoms may be one: both entries then belong to its diagonal.
                    (Some(row), Some(column)) if row >= column => place(row, column),
                    _ => NOWHERE,
                })
            })
        });
        let joints = joints.collect();
        let of_faces = faces.collect();
        let springs = turns.iter().map(|turn| turn.map_or(NOWHERE, |i| place(i, i))).collect();
        Ok(Self {
            update: vec![0.0; order],
            rotations: vec![Matrix3::identity(); held.len()],
            nodes,
            faces: blocks,
            matrix,
            unknowns,
            positions,
            segments,
            vertices,
            joints,
            twists,
            turns: of_faces,
            springs,
        })
    }

    /// Write the matrix in the shape `x` that moves at `v`, with the stresses of `elastic`, for the equation `balance`; a `safe` matrix leaves out
    /// what may be negative.
    pub(crate) fn assemble(
        &mut self,
        elastic: &mut Elastic,
        x: &[Vector],
        v: &[Vector],
        balance: &Balance<3>,
        safe: bool,
    ) -> Result<(), WingError> {
        let rates = elastic.rates(v);
        elastic.update(x, rates)?;
        self.rotations.fill(Matrix3::identity());
        let &Balance { mass, ref diagonal, ref across, elastic: s, rate, .. } = balance;
        let viscous = 1.0 + elastic.relaxation_time * rate;
        let Self { matrix, nodes, faces, segments, vertices, joints, turns, springs, unknowns, .. } = self;
        let values = &mut matrix.values;
        values.fill(0.0);
        for (t, (places, face)) in faces.iter().zip(&elastic.faces).enumerate() {
            let mut blocks = face.hessian(x, elastic.stresses[t], viscous, safe);
            if !safe {
                let moments = elastic.face_hinges[t].map(|hinge| hinge.map_or(0.0, |e| elastic.moments[e]));
                add_hessian(&mut blocks, &elastic.shapes[t], moments);
            }
            let shape = &elastic.shapes[t];
            let (of_corners, moments) = stiffness(shape, &(elastic.bending[t] * viscous));
            let normals = shape.normal * shape.normal.transpose();
            for (block, (j, k)) in blocks.iter_mut().zip(PAIRS) {
                *block += normals * of_corners[(j, k)];
            }
            let TurnPlaces { corners, turns, signs } = &turns[t];
            for i in 0..3 {
                for (j, &place) in corners[i].iter().enumerate() {
                    if place != NOWHERE {
                        values[place as usize] -= s * signs[i] * moments[(i, j / 3)] * shape.normal[j % 3];
                    }
                }
                for (j, &place) in turns[i].iter().enumerate() {
                    if place != NOWHERE {
                        values[place as usize] += s * viscous * signs[i] * signs[j] * elastic.bending[t][(i, j)];
                    }
                }
            }
            let part = mass * face.mass / 12.0;
            for ((block, places), (j, k)) in blocks.iter_mut().zip(places).zip(PAIRS) {
                *block *= s;
                add_to_diagonal(block, if j == k { 2.0 * part } else { part });
                scatter(values, places, block);
            }
        }
        for ((places, segment), &tension) in segments.iter().zip(&elastic.segments).zip(&elastic.tensions) {
            let edge = x[segment.nodes[1]] - x[segment.nodes[0]];
            let l = edge.norm();
            let t = edge / l;
            let across = if safe { tension.max(0.0) } else { tension } / l;
            let along = t * t.transpose();
            let stiffness = ((Matrix3::identity() - along) * across + along * (viscous * segment.stiffness)) * s;
            let part = mass * segment.mass / 6.0;
            for (i, (sign, weight)) in [(3, (1.0, 2.0)), (4, (-1.0, 1.0)), (5, (1.0, 2.0))] {
                let mut block = stiffness * sign;
                add_to_diagonal(&mut block, weight * part);
                scatter(values, &places[i], &block);
            }
        }
        for (places, vertex) in vertices.iter().zip(&elastic.vertices) {
            let derivatives =
                vertex.derivatives(x, elastic.support * vertex.direction).ok_or_else(|| folded(vertex))?;
            let VertexDerivatives { mut before_before, mut before_after, after_after, .. } = derivatives;
            if vertex.before.is_none() {
                (before_before, before_after) = (Matrix3::zeros(), Matrix3::zeros());
            }
            let after_before = before_after.transpose();
            // From the edges to the nodes before, at and after the vertex, in the order of PAIRS.
            let blocks = [
                before_before,
                after_before - before_before,
                -after_before,
                before_before - before_after - after_before + after_after,
                after_before - after_after,
                after_after,
            ];
            for (block, places) in blocks.into_iter().zip(places) {
                scatter(values, places, &(block * s));
            }
        }
        for (places, joint) in joints.iter().zip(&elastic.twists.joints) {
            let hessian = elastic.twists.hessian(joint, x, &elastic.support, safe)?;
            for (i, row) in places.iter().enumerate() {
                for (j, &place) in row.iter().enumerate() {
                    if place != NOWHERE {
                        values[place as usize] += s * hessian[(i, j)];
                    }
                }
            }
        }
        for (&place, &compliance) in springs.iter().zip(&elastic.springs) {
            if place != NOWHERE && compliance > 0.0 {
                values[place as usize] += s * viscous / compliance;
            }
        }
        nodes.iter().zip(across).for_each(|(places, across)| scatter(values, places, &(across * across.transpose())));
        if diagonal.iter().any(|&weight| weight != 0.0) {
            for (first, weight) in unknowns.iter().zip(diagonal) {
                if let Some(first) = *first {
                    (first..first + 3).for_each(|i| matrix.add_to_diagonal(i, *weight));
                }
            }
        }
        Ok(())
    }

    /// Add second derivatives by a point of triangle `t` with these shares of its corners, N/m.
    pub(crate) fn add_to_triangle(&mut self, t: usize, shares: [f64; 3], hessian: Matrix3<f64>) {
        for (places, (j, k)) in self.faces[t].iter().zip(PAIRS) {
            scatter(&mut self.matrix.values, places, &(hessian * (shares[j] * shares[k])));
        }
    }

    /// Return the largest diagonal entry of a node, N/m.
    pub(crate) fn stiffness(&self) -> f64 {
        (0..self.positions).fold(0.0, |largest, i| self.matrix.diagonal(i).abs().max(largest))
    }

    /// Raise the diagonal of the nodes until the matrix is positive definite, at most to a hundred times itself.
    pub(crate) fn factorise_shifted(&mut self) -> bool {
        let (largest, positions) = (self.stiffness(), self.positions);
        let mut shift = 0.0;
        while !self.matrix.factorise() {
            let more = if shift == 0.0 { 1e-8 * largest } else { 9.0 * shift };
            shift += more;
            if !(shift.is_finite() && shift > 0.0 && shift <= 1e2 * largest) {
                return false;
            }
            (0..positions).for_each(|i| self.matrix.add_to_diagonal(i, more));
        }
        true
    }

    /// Solve for the update of the nodes under `residual`, N: `[nodes]`, and `torques` on the directors, N m:
    /// `[strands]` or empty; the result is in `update`.
    pub(crate) fn solve(&mut self, residual: &[Vector], torques: &[f64]) {
        self.update.fill(0.0);
        for (unknown, torque) in self.twists.iter().zip(torques) {
            unknown.iter().for_each(|i| self.update[*i] = *torque);
        }
        for ((first, residual), rotation) in self.unknowns.iter().zip(residual).zip(&self.rotations) {
            if let Some(first) = *first {
                self.update[first..first + 3].copy_from_slice(rotation.tr_mul(residual).as_slice());
            }
        }
        self.matrix.solve(&mut self.update);
        for (first, rotation) in self.unknowns.iter().zip(&self.rotations) {
            if let Some(first) = *first {
                let turned = rotation * Vector3::from_column_slice(&self.update[first..first + 3]);
                self.update[first..first + 3].copy_from_slice(turned.as_slice());
            }
        }
    }

    /// Return the update of the turn of the director `k`.
    pub(crate) fn turn_of(&self, k: usize) -> f64 {
        self.twists[k].map_or(0.0, |i| self.update[i])
    }

    /// Return the update of node `k`.
    pub(crate) fn update_of(&self, k: usize) -> Vector {
        self.unknowns[k].map_or_else(Vector::zeros, |first| Vector3::from_column_slice(&self.update[first..first + 3]))
    }
}

fn add_to_diagonal(block: &mut Matrix3<f64>, value: f64) {
    (0..3).for_each(|i| block[(i, i)] += value);
}

#[inline(always)]
fn scatter(values: &mut [f64], places: &[u32; 9], block: &Matrix3<f64>) {
    for (i, &place) in places.iter().enumerate() {
        if place != NOWHERE {
            values[place as usize] += block[(i / 3, i % 3)];
        }
    }
}

#[cfg(test)]
#[path = "system/tests.rs"]
mod tests;
