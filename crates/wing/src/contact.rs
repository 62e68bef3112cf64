//! Contact of the membrane with obstacles.
//!
//! ```text
//! U_c(x) = Σ_m A_m U(d(p_m))
//! ```
//!
//! Points p_m of the triangles touch ([`points_of_surface`]), A_m is the area that belongs to one, and U the potential
//! of a [`Law`] per area. A point moves with the corners of its triangle, so Newton's matrix keeps its pattern.

use ::contact::{Encounter, HELD, Law, Obstacle, Obstacles, Push, SurfacePoint, points_of_surface};
use nalgebra::Matrix3;
use structure::{finite, not_negative, positive};

use crate::elastic::Elastic;
use crate::face::Face;
use crate::geometry::{Geometry, Vector};
use crate::parameters::Parameters;
use crate::{Error, WingError};

/// Most parts of an edge between points that touch.
const MOST_PARTS: f64 = 16.0;

/// What a membrane touches, and how; it has no thickness.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Forces per area.
    pub law: Law,
    /// Obstacles.
    pub obstacles: Vec<Obstacle<3>>,
}

impl Contact {
    /// Refuse numbers outside their ranges.
    pub(crate) fn check(&self, parameters: &Parameters) -> Result<(), Error> {
        let Law { range, stiffness, depth, damping, friction, .. } = self.law;
        positive("contact.range", range)?;
        positive("contact.stiffness", stiffness)?;
        positive("contact.depth", depth)?;
        not_negative("contact.damping", damping)?;
        not_negative("contact.friction", friction)?;
        self.obstacles.iter().try_for_each(|own| finite("contact.obstacles", own.pose.origin.as_slice()))?;
        if self.parts(parameters) > MOST_PARTS {
            return Err(Error::value("contact.range", range, "beside solids at least a 27th of the longest edge"));
        }
        Ok(())
    }

    /// Return the range from which on the nodes alone touch solids, m: nothing comes closer to an equilateral triangle than
    /// to all its corners by more.
    fn range_of_one(&self, parameters: &Parameters) -> f64 {
        let mesh = &parameters.mesh;
        let edges = mesh.triangles.iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
        let longest = edges.map(|[a, b]| (mesh.node(*a) - mesh.node(*b)).norm()).fold(0.0, f64::max);
        longest / 3_f64.sqrt()
    }

    /// Return the parts of an edge between points: one where there are only planes.
    fn parts(&self, parameters: &Parameters) -> f64 {
        if self.obstacles.iter().all(Obstacle::is_half_space) {
            return 1.0;
        }
        (self.range_of_one(parameters) / self.law.range).ceil().max(1.0)
    }
}

/// Contact of a wing during a stage.
pub(crate) struct Contacts {
    law: Law,
    pub(crate) obstacles: Obstacles<3>,
    points: Vec<SurfacePoint>,
    /// Points that touch each obstacle: all but those beside a root that is held there.
    of: Vec<Vec<u32>>,
    /// Length of the stage, s; `None` in an equilibrium.
    dt: Option<f64>,
    /// Forces on the nodes, N: `[nodes]`.
    pub(crate) forces: Vec<Vector>,
    /// Whether the wing might touch anything at the begin of the sub-step.
    pub(crate) is_near: bool,
}

impl Contacts {
    /// Return the contact of a wing at rest.
    pub(crate) fn new(own: &Contact, parameters: &Parameters) -> Self {
        let Parameters { mesh, root, .. } = parameters;
        let points = points_of_surface(&mesh.nodes, &mesh.triangles, own.parts(parameters) as usize);
        let held = |place: Vector| root.nodes.iter().any(|&k| (mesh.node(k) - place).norm() < HELD * own.law.range);
        let of = own.obstacles.iter().map(|obstacle| {
            let touches = |k: &usize| obstacle.nearest(mesh.node(*k)).distance < own.law.range;
            let root_touches = root.nodes.iter().any(touches);
            let place = |point: &SurfacePoint| point.of(mesh.triangles[point.triangle].map(|k| mesh.node(k)));
            let free = points.iter().enumerate().filter(|(_, point)| !(root_touches && held(place(point))));
            free.map(|(m, _)| m as u32).collect()
        });
        Self {
            law: own.law,
            obstacles: Obstacles::new(own.obstacles.clone()),
            of: of.collect(),
            points,
            dt: None,
            forces: vec![Vector::zeros(); mesh.nodes.len()],
            is_near: false,
        }
    }

    /// Begin a stage of `dt` (s) between these fractions of the step.
    pub(crate) fn begin(&mut self, dt: f64, between: [f64; 2]) {
        self.dt = Some(dt);
        self.obstacles.begin(between);
    }

    /// Begin an equilibrium.
    pub(crate) fn begin_static(&mut self) {
        self.dt = None;
        self.obstacles.begin_static();
    }

    /// Find whether the wing of this shape (m) and velocity (m/s) may touch anything in `dt`, s.
    pub(crate) fn look(&mut self, faces: &[Face], x: &[Vector], velocity: &[Vector], dt: f64) {
        let closer = 2.0 * dt * velocity.iter().map(Vector::norm).fold(0.0, f64::max);
        self.begin_static();
        let (reach, mut near) = (self.law.reach() + closer, !self.obstacles.are_still());
        self.visit(faces, x, x, reach, |_, met| near |= met.gaps[1] < reach);
        self.is_near = near;
    }

    /// Visit each point in the shape `x` with each obstacle that it may touch, from the shape `origin`, m; still obstacles
    /// farther than `reach` (m) are left out.
    fn visit(
        &self,
        faces: &[Face],
        x: &[Vector],
        origin: &[Vector],
        reach: f64,
        mut visit: impl FnMut(&SurfacePoint, Encounter<3>),
    ) {
        let balls = [origin, x].map(ball);
        for (i, points) in self.of.iter().enumerate().filter(|(i, _)| !self.obstacles.is_beyond(*i, balls, reach)) {
            for point in points.iter().map(|&m| &self.points[m as usize]) {
                let corners = faces[point.triangle].nodes;
                let ends = [origin, x].map(|shape| point.of(corners.map(|k| shape[k])));
                if let Some(met) = self.obstacles.meet(i, ends, 0.0, reach) {
                    visit(point, met);
                }
            }
        }
    }

    /// Return the energy of the penalty in the shape `x`, J.
    pub(crate) fn energy(&self, faces: &[Face], x: &[Vector]) -> f64 {
        let mut sum = 0.0;
        let add = |point: &SurfacePoint, met: Encounter<3>| {
            sum += point.area * self.law.penalty(met.gaps[1]).potential;
        };
        self.visit(faces, x, x, self.law.reach(), add);
        sum
    }

    /// Write the forces on the nodes in the shape `x` of a stage from `origin`, m, to `forces`.
    pub(crate) fn find_forces(&mut self, elastic: &Elastic, x: &[Vector], origin: &[Vector]) -> Result<(), WingError> {
        let mut forces = std::mem::take(&mut self.forces);
        forces.fill(Vector::zeros());
        let (law, dt, mut result) = (&self.law, self.dt, Ok(()));
        self.visit(&elastic.faces, x, origin, law.reach(), |point, met| {
            let corners = elastic.faces[point.triangle].nodes;
            if -met.gaps[1] >= law.depth {
                result = Err(WingError::Deep { node: corners[0], depth: -met.gaps[1], allowed: law.depth });
                return;
            }
            let pushes = [met.push(law, point.area, dt), met.friction(law, point.area, dt)];
            for Push { force, .. } in pushes.into_iter().flatten() {
                corners.into_iter().zip(point.shares).for_each(|(k, share)| forces[k] += force * share);
            }
        });
        self.forces = forces;
        result
    }

    /// Pass second derivatives of the potential by the place of a point of a triangle, N/m, to `emit`, with the shares of
    /// its corners; `safe` ones are positive semi-definite.
    pub(crate) fn hessian(
        &self,
        faces: &[Face],
        x: &[Vector],
        origin: &[Vector],
        safe: bool,
        mut emit: impl FnMut(&SurfacePoint, Matrix3<f64>),
    ) {
        self.visit(faces, x, origin, self.law.reach(), |point, mut met| {
            if safe {
                met.curvature = Matrix3::zeros();
            }
            let pushes = [met.push(&self.law, point.area, self.dt), met.friction(&self.law, point.area, self.dt)];
            pushes.into_iter().flatten().for_each(|push| emit(point, push.hessian));
        });
    }

    /// Refuse a stage from `origin` to `x`, m, in which the wing may have passed through something.
    pub(crate) fn check(&self, faces: &[Face], x: &[Vector], origin: &[Vector]) -> Result<(), WingError> {
        let mut result = Ok(());
        self.visit(faces, x, origin, f64::INFINITY, |point, met| {
            if met.passes_through() {
                result = Err(WingError::Through { node: faces[point.triangle].nodes[0] });
            }
        });
        result
    }
}

/// Return the middle and the radius of a ball around all nodes, m.
fn ball(x: &[Vector]) -> (Vector, f64) {
    let (low, high) = x.iter().fold((x[0], x[0]), |(low, high), x| (low.inf(x), high.sup(x)));
    (0.5 * (low + high), 0.5 * (high - low).norm())
}
