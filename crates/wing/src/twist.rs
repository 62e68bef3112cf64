//! Veins with torsion: a director on each segment, and springs between neighbouring frames.
//!
//! A segment with the tangent t has the frame R = (d, t × d, t). Its director d follows t by parallel transport and
//! turns about it by the unknown φ, which has no inertia. At the joint of the segments a and b,
//!
//! ```text
//! U = ½ ω · K ω,     Q = R_aᵀ R_b,     E = Q Q_restᵀ,     ω = 2 axial(E − Eᵀ)/(1 + tr E) = 2 tan(ψ/2) axis,
//! K⁻¹ = ½ (l_a C_a + l_b Q_rest C_b Q_restᵀ),     C = diag(1/EI, 1/EI, 1/GJ).
//! ```
//!
//! So half of each segment bends and twists about its own tangent, and a kink passes one to the other. A straight joint
//! without twist has the spring of the rod.
//!
//! A vein c that begins or ends inside another one, between its segments a and b, turns with their node, whose turn lies
//! between theirs. With the shares s_a = l_b/(l_a + l_b), s_b = 1 − s_a, and the spring K of a and b as above,
//!
//! ```text
//! K_c⁻¹ = ½ l_c C_c + n s_a s_b K⁻¹:     joints s_a K_c of a and c, s_b K_c of b and c, K − Σ s_a s_b K_c of a and b
//! ```
//!
//! with sum and number n of all that meet there, in one frame. At small turns a vein c at any angle to a straight one bends
//! and twists it as if the node had a frame of its own; so do several if they bear the same moment.
//!
//! The spins of the frames w = (t × ė)/l + φ̇ t give the derivatives,
//! ω̇ = J u with J = 1 − ½ [ω] + ¼ ω ωᵀ and u = R_aᵀ (w_b − w_a). A membrane that bends has its hinges between triangle
//! and director. Directors on a path of shapes: Bergou et al. (2010, ACM Trans. Graph. 29, 116).

use std::collections::HashMap;

use mesh::MeshEdge;
use nalgebra::{Matrix3, SMatrix};
use serde::{Deserialize, Serialize};
use structure::{Motion, StepRule};

use crate::face::FaceShape;
use crate::geometry::{Geometry, Vector};
use crate::parameters::{Parameters, Support, Vein};
use crate::{Error, WingError};

/// Limit of 1 + tr E, twice 1 + cos ψ; beyond it the joint counts as folded.
const FOLD: f64 = 2e-12;
/// Tolerance of the length of a director and of its component along the segment, for rounding.
const UNIT: f64 = 1e-6;

/// Number of positions and turns of a joint: the ends of both segments, then φ of each.
pub(crate) const FREEDOMS: usize = 14;

/// Derivatives by the freedoms of a joint.
pub(crate) type JointHessian = SMatrix<f64, FREEDOMS, FREEDOMS>;

/// Memory of the director of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// Director: a unit vector across the segment.
    pub director: [f64; 3],
    /// Rate of its turn φ, rad/s.
    pub rate: f64,
    /// Second rate, rad/s².
    pub acceleration: f64,
    /// Turn in the last step, rad.
    pub last_turn: f64,
    /// Rate one step earlier, rad/s.
    pub previous_rate: f64,
}

/// Segment with a director.
pub(crate) struct Strand {
    pub(crate) nodes: [usize; 2],
    /// Length at rest, m.
    pub(crate) length: f64,
    /// Whether the root holds both ends, so that the director turns with the support.
    pub(crate) rigid: bool,
    /// Director at rest.
    rest: Vector,
}

/// Segment of a vein that begins or ends inside another one.
struct Branch {
    strand: usize,
    /// C, in its own axes, 1/(N m²).
    compliance: Matrix3<f64>,
    /// Segments of the other vein before and after the node.
    sides: [usize; 2],
}

/// Spring between the frames of two segments.
pub(crate) struct Joint {
    /// Segment before; `None` for the support, whose frame at rest is that of the segment after it.
    pub(crate) before: Option<usize>,
    pub(crate) after: usize,
    /// Q_restᵀ.
    back: Matrix3<f64>,
    /// Frame of the support at rest.
    support: Matrix3<f64>,
    /// K, N m.
    stiffness: Matrix3<f64>,
}

#[derive(Clone, Copy)]
struct Pose {
    tangent: Vector,
    director: Vector,
    /// φ since the begin of the sub-step, rad.
    turn: f64,
}

/// Joint in a shape.
struct Bent {
    /// R_a, K ω, J and the spatial moment R_a Jᵀ K ω.
    frame: Matrix3<f64>,
    omega: Vector,
    jacobian: Matrix3<f64>,
    moment: Vector,
}

/// Directors and joints of all veins with torsion.
#[derive(Default)]
pub(crate) struct Twists {
    pub(crate) strands: Vec<Strand>,
    pub(crate) joints: Vec<Joint>,
    /// ∂U/∂φ, N m: `[strands]`.
    pub(crate) torques: Vec<f64>,
    /// Rates of φ, rad/s: `[strands]`.
    pub(crate) spins: Vec<f64>,
    /// Rate and second rate at the end of a stage without turn: `[strands]`.
    without_turn: Vec<(f64, f64)>,
    now: Vec<Pose>,
    /// Poses before a line search, and before a solve.
    marked: Vec<Pose>,
    kept: Vec<Pose>,
    /// Segment between two nodes, the lower number first.
    places: HashMap<[usize; 2], usize>,
}

impl Pose {
    fn frame(&self) -> Matrix3<f64> {
        frame(self.tangent, self.director)
    }

    /// Move the director to another tangent by parallel transport.
    fn carry(&mut self, tangent: Vector) {
        if tangent != self.tangent {
            self.director = transport(&self.tangent, &tangent, &self.director);
            self.tangent = tangent;
        }
    }
}

fn frame(tangent: Vector, director: Vector) -> Matrix3<f64> {
    Matrix3::from_columns(&[director, tangent.cross(&director), tangent])
}

/// Return `director` after the smallest rotation from one tangent to another, across the latter.
fn transport(from: &Vector, to: &Vector, director: &Vector) -> Vector {
    let (axis, cosine) = (from.cross(to), from.dot(to));
    let turned = director * cosine + axis.cross(director) + axis * (axis.dot(director) / (1.0 + cosine));
    (turned - to * to.dot(&turned)).normalize()
}

/// Return C of a vein at its node `j`, in the axes of a segment, 1/(N m²).
fn compliance(vein: &Vein, j: usize) -> Matrix3<f64> {
    let scale = vein.diameter_at(j).powi(4);
    let [bending, torsion] = [vein.bending_stiffness, vein.torsional_stiffness].map(|stiffness| stiffness * scale);
    Matrix3::from_diagonal(&Vector::new(1.0 / bending, 1.0 / bending, 1.0 / torsion))
}

fn key([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

impl Twists {
    /// Return the directors at rest and the joints of the veins that have torsion.
    pub(crate) fn new(
        parameters: &Parameters,
        held: &[bool],
        edges: &[MeshEdge],
        shapes: &[FaceShape],
    ) -> Result<Self, Error> {
        let mesh = &parameters.mesh;
        let mut twists = Self::default();
        let veins: Vec<_> = parameters.veins.iter().filter(|vein| vein.torsional_stiffness > 0.0).collect();
        if veins.is_empty() {
            return Ok(twists);
        }
        let normals: HashMap<_, Vector> = edges
            .iter()
            .map(|edge| {
                let sides = [Some(edge.first), edge.second].into_iter().flatten();
                (key(edge.nodes), sides.map(|(t, _)| shapes[t].normal).sum())
            })
            .collect();
        let mut in_triangle = vec![false; mesh.nodes.len()];
        mesh.triangles.iter().flatten().for_each(|k| in_triangle[*k] = true);
        // First segment of each vein.
        let mut firsts = Vec::new();
        for vein in &veins {
            firsts.push(twists.strands.len());
            let mut before: Option<Pose> = None;
            for ends in vein.nodes.windows(2) {
                let nodes = [ends[0], ends[1]];
                let refuse = |allowed| Err(Error::value(format!("veins.{}.nodes", vein.name), &nodes[..], allowed));
                let normal = normals.get(&key(nodes)).copied();
                if normal.is_none() && nodes.iter().all(|k| in_triangle[*k]) {
                    return refuse("along the edges of triangles, as this vein has torsion");
                }
                if twists.places.insert(key(nodes), twists.strands.len()).is_some() {
                    return refuse("on no other vein with torsion");
                }
                let edge = mesh.node(nodes[1]) - mesh.node(nodes[0]);
                let tangent = edge.normalize();
                let carried = before.map(|pose| transport(&pose.tangent, &tangent, &pose.director));
                let across = |vector: Vector| vector - tangent * tangent.dot(&vector);
                let axis = Vector::from_fn(|d, _| f64::from(u8::from(d == tangent.iamin())));
                // Opposite normals leave no direction.
                let own = normal.and_then(|normal| across(normal).try_normalize(UNIT));
                let director = own.or(carried).unwrap_or_else(|| across(axis).normalize());
                let rigid = nodes.iter().all(|k| held[*k]);
                twists.strands.push(Strand { nodes, length: edge.norm(), rigid, rest: director });
                let pose = Pose { tangent, director, turn: 0.0 };
                twists.now.push(pose);
                before = Some(pose);
            }
        }
        let mut branches = Vec::new();
        for i in 0..veins.len() {
            twists.add_joints(i, &veins, &firsts, held, parameters.root.support, &mut branches)?;
        }
        twists.add_branches(&branches);
        let count = twists.strands.len();
        (twists.torques, twists.spins) = (vec![0.0; count], vec![0.0; count]);
        twists.without_turn = vec![(0.0, 0.0); count];
        (twists.marked, twists.kept) = (twists.now.clone(), twists.now.clone());
        Ok(twists)
    }

    /// Add the joints along the vein `i`, to the support, and to veins before it that end or begin where it does; append
    /// its branches.
    fn add_joints(
        &mut self,
        i: usize,
        veins: &[&Vein],
        firsts: &[usize],
        held: &[bool],
        support: Support,
        branches: &mut Vec<Branch>,
    ) -> Result<(), Error> {
        let vein = veins[i];
        let (first, count) = (firsts[i], vein.nodes.len() - 1);
        for j in 0..=count {
            let (node, own) = (vein.nodes[j], compliance(vein, j));
            if j > 0 && j < count {
                self.add_joint(Some((first + j - 1, own)), first + j, own, vein, node)?;
                continue;
            }
            let strand = if j == 0 { first } else { first + count - 1 };
            if held[node] {
                if j == 0 && support == Support::Clamped && !self.strands[strand].rigid {
                    self.add_joint(None, strand, own, vein, node)?;
                }
                continue;
            }
            // A vein that runs through the node, or one that ends or begins there.
            let others = || {
                let places = veins.iter().enumerate().filter(|(k, _)| *k != i);
                places.filter_map(|(k, other)| Some((k, *other, other.nodes.iter().position(|own| *own == node)?)))
            };
            if let Some((k, _, at)) = others().find(|(_, other, at)| (1..other.nodes.len() - 1).contains(at)) {
                branches.push(Branch { strand, compliance: own, sides: [firsts[k] + at - 1, firsts[k] + at] });
            } else if let Some((k, other, at)) = others().next().filter(|(k, ..)| *k < i) {
                self.add_joint(Some((firsts[k] + at.max(1) - 1, compliance(other, at))), strand, own, vein, node)?;
            }
        }
        Ok(())
    }

    /// Add a joint at a node of a vein: half of the segment `before`, of such a compliance, and half of that after it bend.
    fn add_joint(
        &mut self,
        before: Option<(usize, Matrix3<f64>)>,
        after: usize,
        own: Matrix3<f64>,
        vein: &Vein,
        node: usize,
    ) -> Result<(), Error> {
        let half = |k: usize| if self.strands[k].rigid { 0.0 } else { 0.5 * self.strands[k].length };
        let (rest, mut fold, mut compliance) = (self.rest(before.map(|(k, _)| k), after), false, Matrix3::zeros());
        if let Some((k, of_before)) = before {
            fold = 1.0 + self.now[k].tangent.dot(&self.now[after].tangent) < FOLD;
            compliance += of_before * half(k);
        }
        compliance += rest * own * rest.transpose() * half(after);
        match compliance.try_inverse() {
            Some(stiffness) if !fold => {
                self.push(before.map(|(k, _)| k), after, stiffness);
                Ok(())
            }
            // Both segments are rigid.
            None => Ok(()),
            Some(_) => {
                let allowed = "a place where the vein does not fold back";
                Err(Error::value(format!("veins.{}.nodes", vein.name), node, allowed))
            }
        }
    }

    /// Join each branch to both segments of the vein that it meets, as the module says.
    fn add_branches(&mut self, branches: &[Branch]) {
        let stems: Vec<_> = self.joints.iter().map(|joint| joint.stiffness).collect();
        let place = |sides: [usize; 2]| move |joint: &Joint| joint.before.zip(Some(joint.after)) == Some(sides.into());
        for &Branch { strand, compliance, sides: [a, b] } in branches {
            let Some(stem) = self.joints.iter().position(place([a, b])) else { continue };
            let meeting = branches.iter().filter(|other| other.sides == [a, b]).count() as f64;
            let [l_a, l_b, own] = [a, b, strand].map(|k| self.strands[k].length);
            let (of_a, of_b) = (l_b / (l_a + l_b), l_a / (l_a + l_b));
            let (rest, turn) = (self.rest(Some(a), strand), self.rest(Some(a), b));
            let bends = rest * compliance * rest.transpose() * (0.5 * own);
            let of_stem = stems[stem].try_inverse().unwrap_or_default() * (meeting * of_a * of_b);
            let Some(stiffness) = (bends + of_stem).try_inverse() else { continue };
            self.push(Some(a), strand, stiffness * of_a);
            self.push(Some(b), strand, turn.transpose() * stiffness * turn * of_b);
            self.joints[stem].stiffness -= stiffness * (of_a * of_b);
        }
    }

    /// Return Q_rest of two segments; of the support the identity.
    fn rest(&self, before: Option<usize>, after: usize) -> Matrix3<f64> {
        let frame = self.now[after].frame();
        before.map_or_else(Matrix3::identity, |before| self.now[before].frame().transpose() * frame)
    }

    fn push(&mut self, before: Option<usize>, after: usize, stiffness: Matrix3<f64>) {
        let (back, support) = (self.rest(before, after).transpose(), self.now[after].frame());
        self.joints.push(Joint { before, after, back, support, stiffness });
    }

    /// Return the segment between two nodes, and 1 or −1 as it runs from the first to the second or back.
    pub(crate) fn between(&self, nodes: [usize; 2]) -> Option<(usize, f64)> {
        let &strand = self.places.get(&key(nodes))?;
        Some((strand, if self.strands[strand].nodes == nodes { 1.0 } else { -1.0 }))
    }

    pub(crate) fn director(&self, strand: usize) -> &Vector {
        &self.now[strand].director
    }

    /// Let the directors follow the shape `x` and the `support`.
    pub(crate) fn carry(&mut self, x: &[Vector], support: &Matrix3<f64>) {
        for (strand, pose) in self.strands.iter().zip(&mut self.now) {
            let tangent = (x[strand.nodes[1]] - x[strand.nodes[0]]).normalize();
            match strand.rigid {
                true => (pose.tangent, pose.director) = (tangent, support * strand.rest),
                false => pose.carry(tangent),
            }
        }
    }

    /// Turn each director by a share of the update φ that `update` returns.
    pub(crate) fn turn(&mut self, share: f64, update: impl Fn(usize) -> f64) {
        for (k, pose) in self.now.iter_mut().enumerate() {
            let turn = share * update(k);
            let (sin, cos) = turn.sin_cos();
            pose.director = (pose.director * cos + pose.tangent.cross(&pose.director) * sin).normalize();
            pose.turn += turn;
        }
    }

    /// Mark the poses before a line search.
    pub(crate) fn mark(&mut self) {
        self.marked.copy_from_slice(&self.now);
    }

    /// Go back to the marked poses.
    pub(crate) fn back_to_mark(&mut self) {
        self.now.copy_from_slice(&self.marked);
    }

    /// Keep the poses before a solve without a time, and let the directors rest.
    pub(crate) fn keep(&mut self) {
        self.kept.copy_from_slice(&self.now);
        self.without_turn.fill((0.0, 0.0));
        self.spins.fill(0.0);
    }

    /// Go back to the kept poses.
    pub(crate) fn back_to_kept(&mut self) {
        self.now.copy_from_slice(&self.kept);
    }

    /// Set the spins to those of the present turns; `rate` is dv/du.
    pub(crate) fn set_spins(&mut self, rate: f64) {
        for ((spin, pose), (star, _)) in self.spins.iter_mut().zip(&self.now).zip(&self.without_turn) {
            *spin = pose.turn * rate + star;
        }
    }

    /// Return the memory of the directors at rest.
    pub(crate) fn at_rest(&self) -> Vec<Twist> {
        let still = |pose: &Pose| Twist {
            director: pose.director.into(),
            rate: 0.0,
            acceleration: 0.0,
            last_turn: 0.0,
            previous_rate: 0.0,
        };
        self.now.iter().map(still).collect()
    }

    /// Return the memory of the directors at rest after the `rotation`, spinning at `omega`, rad/s.
    pub(crate) fn placed(&self, rest: &[Vector], rotation: &Matrix3<f64>, omega: &Vector) -> Vec<Twist> {
        let moved = |strand: &Strand| {
            let tangent = rotation * (rest[strand.nodes[1]] - rest[strand.nodes[0]]).normalize();
            let rate = omega.dot(&tangent);
            let director = (rotation * strand.rest).into();
            Twist { director, rate, acceleration: 0.0, last_turn: 0.0, previous_rate: rate }
        };
        self.strands.iter().map(moved).collect()
    }

    /// Set the directors of the shape `x` to those of the memory.
    pub(crate) fn set(&mut self, memory: &[Twist], x: &[Vector]) {
        for (k, (strand, twist)) in self.strands.iter().zip(memory).enumerate() {
            let tangent = (x[strand.nodes[1]] - x[strand.nodes[0]]).normalize();
            self.now[k] = Pose { tangent, director: Vector::from(twist.director), turn: 0.0 };
            self.spins[k] = twist.rate;
        }
    }

    /// Refuse a memory that does not fit the shape `x`.
    pub(crate) fn check(&self, memory: &[Twist], x: &[Vector]) -> Result<(), Error> {
        Error::check_length("state.own.twists", memory.len(), self.strands.len())?;
        for (k, (twist, strand)) in memory.iter().zip(&self.strands).enumerate() {
            let (director, edge) = (Vector::from(twist.director), x[strand.nodes[1]] - x[strand.nodes[0]]);
            let across = director.dot(&edge).abs() <= UNIT * edge.norm();
            let rates = [twist.rate, twist.acceleration, twist.last_turn, twist.previous_rate];
            if !(across && (director.norm() - 1.0).abs() <= UNIT && rates.iter().all(|rate| rate.is_finite())) {
                let allowed = "a unit vector across its segment, with finite rates";
                return Err(Error::value(format!("state.own.twists[{k}]"), format!("{twist:?}"), allowed));
            }
        }
        Ok(())
    }

    /// Predict a stage over `dt`, s, after a step of `last_step`, s: rates without a turn, and first turns.
    pub(crate) fn predict(&mut self, memory: &[Twist], rule: &StepRule, dt: f64, last_step: f64) {
        for (star, twist) in self.without_turn.iter_mut().zip(memory) {
            *star = rule.at_no_displacement(Motion {
                x: 0.0,
                v: twist.rate,
                a: twist.acceleration,
                previous_x: -twist.last_turn,
                previous_v: twist.previous_rate,
            });
        }
        self.now.iter_mut().for_each(|pose| pose.turn = 0.0);
        if last_step > 0.0 {
            self.turn(dt / last_step, |k| memory[k].last_turn);
        }
    }

    /// Write the end of a stage to the memory.
    pub(crate) fn correct(&mut self, rule: &StepRule, memory: &mut [Twist]) {
        for (k, (twist, pose)) in memory.iter_mut().zip(&self.now).enumerate() {
            let (rate, acceleration) = self.without_turn[k];
            let (turn, previous_rate) = (pose.turn, twist.rate);
            *twist = Twist {
                director: pose.director.into(),
                rate: turn * rule.c_v + rate,
                acceleration: turn * rule.c_a + acceleration,
                last_turn: turn,
                previous_rate,
            };
            self.spins[k] = twist.rate;
        }
    }

    /// Return a joint in the present shape; `None` at a fold.
    fn bent(&self, joint: &Joint, support: &Matrix3<f64>) -> Option<Bent> {
        let frame = joint.before.map_or_else(|| support * joint.support, |before| self.now[before].frame());
        let e = frame.transpose() * self.now[joint.after].frame() * joint.back;
        let above_fold = 1.0 + e.trace();
        let axial = Vector::new(e[(2, 1)] - e[(1, 2)], e[(0, 2)] - e[(2, 0)], e[(1, 0)] - e[(0, 1)]);
        let omega = axial * (2.0 / above_fold);
        let jacobian = Matrix3::identity() - omega.cross_matrix() * 0.5 + omega * omega.transpose() * 0.25;
        let moment = frame * jacobian.tr_mul(&(joint.stiffness * omega));
        (above_fold > FOLD).then_some(Bent { frame, omega, jacobian, moment })
    }

    fn folded(&self, joint: &Joint) -> WingError {
        WingError::Fold { nodes: self.strands[joint.after].nodes, what: "a vein folds back or twists by 180° there" }
    }

    /// Return the energy of the joints, J.
    pub(crate) fn energy(&self, support: &Matrix3<f64>) -> Result<f64, WingError> {
        let mut sum = 0.0;
        for joint in &self.joints {
            let Bent { omega, .. } = self.bent(joint, support).ok_or_else(|| self.folded(joint))?;
            sum += 0.5 * omega.dot(&(joint.stiffness * omega));
        }
        Ok(sum)
    }

    /// Add the forces of the joints in the shape `x` to `gradient`, N, and to the torques.
    pub(crate) fn add_gradient(
        &mut self,
        x: &[Vector],
        support: &Matrix3<f64>,
        gradient: &mut [Vector],
    ) -> Result<(), WingError> {
        for joint in &self.joints {
            let Bent { moment, .. } = self.bent(joint, support).ok_or_else(|| self.folded(joint))?;
            for (strand, moment) in [(joint.before, -moment), (Some(joint.after), moment)] {
                let Some(k) = strand else { continue };
                let ([a, b], tangent) = (self.strands[k].nodes, &self.now[k].tangent);
                let force = moment.cross(tangent) / (x[b] - x[a]).norm();
                gradient[a] -= force;
                gradient[b] += force;
                self.torques[k] += moment.dot(tangent);
            }
        }
        Ok(())
    }

    /// Return the Hessian of a joint in the shape `x`; a `safe` one leaves out what may be negative.
    pub(crate) fn hessian(
        &self,
        joint: &Joint,
        x: &[Vector],
        support: &Matrix3<f64>,
        safe: bool,
    ) -> Result<JointHessian, WingError> {
        let bent = self.bent(joint, support).ok_or_else(|| self.folded(joint))?;
        let Bent { frame, omega, jacobian, moment } = bent;
        let k = joint.stiffness;
        let (mut own, mut spin) = (jacobian.tr_mul(&(k * jacobian)), Matrix3::zeros());
        if !safe {
            let local = k * omega;
            let bend = local.cross_matrix() * jacobian * -0.5
                + (omega * jacobian.tr_mul(&local).transpose() + jacobian * local.dot(&omega)) * 0.25;
            own += (bend + bend.transpose()) * 0.5;
            spin = moment.cross_matrix() * 0.5;
        }
        let own = frame * own * frame.transpose();
        // Spins of both frames by edge and φ; those of the support are 0.
        let mut maps = [SMatrix::<f64, 3, 4>::zeros(); 2];
        let mut bends = [SMatrix::<f64, 4, 4>::zeros(); 2];
        for (i, (strand, sign)) in [(joint.before, -1.0), (Some(joint.after), 1.0)].into_iter().enumerate() {
            let Some(strand) = strand else { continue };
            let ([a, b], t) = (self.strands[strand].nodes, self.now[strand].tangent);
            let over = 1.0 / (x[b] - x[a]).norm();
            maps[i].fixed_view_mut::<3, 3>(0, 0).copy_from(&(t.cross_matrix() * over));
            maps[i].set_column(3, &t);
            if !safe {
                // ẇ = −2 (t · ė)(t × ė)/l² + φ̇ ṫ.
                let across = moment.cross(&t) * over;
                let mixed = t * across.transpose() * -over;
                bends[i].fixed_view_mut::<3, 3>(0, 0).copy_from(&((mixed + mixed.transpose()) * sign));
                let turning = (moment - t * t.dot(&moment)) * (0.5 * sign * over);
                bends[i].fixed_view_mut::<3, 1>(0, 3).copy_from(&turning);
                bends[i].fixed_view_mut::<1, 3>(3, 0).copy_from(&turning.transpose());
            }
        }
        let both = maps[0].tr_mul(&((spin - own) * maps[1]));
        let blocks = [
            [maps[0].tr_mul(&(own * maps[0])) + bends[0], both],
            [both.transpose(), maps[1].tr_mul(&(own * maps[1])) + bends[1]],
        ];
        // From the edges to their ends.
        let place = |i: usize| match i {
            0..12 => (i / 6, i % 3, if i % 6 < 3 { -1.0 } else { 1.0 }),
            _ => (i - 12, 3, 1.0),
        };
        Ok(JointHessian::from_fn(|i, j| {
            let ((a, row, one), (b, column, other)) = (place(i), place(j));
            blocks[a][b][(row, column)] * one * other
        }))
    }
}
