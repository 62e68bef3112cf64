//! Contact of the membrane with obstacles, and with itself.
//!
//! ```text
//! U_c(x) = Σ_m A_m U(d(p_m))
//! ```
//!
//! Points p_m of the triangles touch ([`points_of_surface`]), A_m is the area that belongs to one, and U the potential
//! of a [`Law`] per area. A point moves with the corners of its triangle, so Newton's matrix keeps its pattern.

use ::contact::{ContactError, HELD, Law, Meeting, Obstacles, Push, SurfacePoint, points_of_surface};
use nalgebra::Matrix3;

use crate::WingError;
use crate::elastic::Elastic;
use crate::face::Face;
use crate::geometry::{Geometry, Vector};
use crate::itself::{Itself, Spot};
use crate::parameters::{Contact, Parameters};

/// Contact of a wing during a stage.
pub(crate) struct Contacts {
    pub(crate) detection: Detection,
    /// Length of the stage, s; `None` in an equilibrium.
    dt: Option<f64>,
    /// Forces on the nodes, N: `[nodes]`.
    pub(crate) forces: Vec<Vector>,
    /// Whether the wing might touch anything at the begin of the sub-step.
    pub(crate) is_near: bool,
}

/// Points of a wing, and what they may touch.
pub(crate) struct Detection {
    law: Law,
    pub(crate) obstacles: Obstacles<3>,
    itself: Option<Itself>,
    points: Vec<SurfacePoint>,
    /// Points that touch each obstacle: all but those beside a root that is held there.
    of: Vec<Vec<u32>>,
}

impl Contacts {
    /// Return the contact of a wing at rest.
    pub(crate) fn new(own: &Contact, parameters: &Parameters) -> Self {
        let Parameters { mesh, root, .. } = parameters;
        let points = points_of_surface(&mesh.nodes, &mesh.triangles, own.parts(mesh) as usize);
        let held = |place: Vector| root.nodes.iter().any(|&k| (mesh.node(k) - place).norm() < HELD * own.law.range);
        let of = own.obstacles.iter().map(|obstacle| {
            let touches = |k: &usize| obstacle.nearest(mesh.node(*k)).distance < own.law.range;
            let root_touches = root.nodes.iter().any(touches);
            let place = |point: &SurfacePoint| point.of(mesh.triangles[point.triangle].map(|k| mesh.node(k)));
            let free = points.iter().enumerate().filter(|(_, point)| !(root_touches && held(place(point))));
            free.map(|(m, _)| m as u32).collect()
        });
        let detection = Detection {
            law: own.law,
            obstacles: Obstacles::new(own.obstacles.clone()),
            of: of.collect(),
            itself: own.with_itself.then(|| Itself::new(&own.law, mesh, own.parts_for_itself(mesh) as usize)),
            points,
        };
        Self { detection, dt: None, forces: vec![Vector::zeros(); mesh.nodes.len()], is_near: false }
    }

    /// Begin a stage of `dt` (s) between these fractions of the step, from `origin` to the first guess `guess`, m.
    pub(crate) fn begin(
        &mut self,
        faces: &[Face],
        origin: &[Vector],
        guess: &[Vector],
        dt: f64,
        between: [f64; 2],
    ) -> Result<(), WingError> {
        self.dt = Some(dt);
        self.detection.obstacles.begin(between);
        self.detection.itself.as_mut().map_or(Ok(()), |own| Ok(own.begin(faces, origin, guess)?))
    }

    /// Begin an equilibrium from the shape `origin`, m.
    pub(crate) fn begin_static(&mut self, faces: &[Face], origin: &[Vector]) -> Result<(), WingError> {
        self.stand();
        self.detection.itself.as_mut().map_or(Ok(()), |own| Ok(own.begin_static(faces, origin)?))
    }

    /// Find whether the wing of this shape (m) and velocity (m/s) may touch anything in `dt`, s.
    pub(crate) fn detect_nearby(
        &mut self,
        faces: &[Face],
        x: &[Vector],
        velocity: &[Vector],
        dt: f64,
    ) -> Result<(), WingError> {
        let moved = dt * velocity.iter().map(Vector::norm).fold(0.0, f64::max);
        let closer = 2.0 * moved;
        self.stand();
        self.detection.itself.as_mut().map_or(Ok(()), |own| own.search_ahead(faces, x, moved))?;
        let mut near = !self.detection.obstacles.are_still();
        self.detection.visit(faces, x, x, closer, |law, met| near |= met.met.gaps[1] < law.reach() + closer);
        self.is_near = near;
        Ok(())
    }

    /// Let all obstacles stand still, without a stage.
    fn stand(&mut self) {
        self.dt = None;
        self.detection.obstacles.begin_static();
    }

    /// Return the energy of the penalty in the shape `x`, J.
    pub(crate) fn energy(&mut self, faces: &[Face], x: &[Vector]) -> Result<f64, WingError> {
        self.stand();
        self.detection.itself.as_mut().map_or(Ok(()), |own| own.search(faces, x, 0.0))?;
        let mut sum = 0.0;
        self.detection.visit(faces, x, x, 0.0, |law, met| sum += met.size * law.penalty(met.met.gaps[1]).potential);
        Ok(sum)
    }

    /// Write the forces on the nodes in the shape `x` of a stage from `origin`, m, to `forces`.
    pub(crate) fn find_forces(&mut self, elastic: &Elastic, x: &[Vector], origin: &[Vector]) -> Result<(), WingError> {
        let (Self { detection, dt, forces, .. }, faces) = (self, &elastic.faces);
        forces.fill(Vector::zeros());
        let mut result = Ok(());
        detection.visit(faces, x, origin, 0.0, |law, met| {
            if -met.met.gaps[1] >= law.depth {
                let (node, depth) = (faces[met.spot.triangle].nodes[0], -met.met.gaps[1]);
                result = Err(ContactError::Deep { node, depth, allowed: law.depth }.into());
                return;
            }
            for (Push { force, .. }, partner) in met.pushes(law, *dt) {
                let parts = [(Some(met.spot), force), (partner, -force)];
                for (Spot { triangle, shares }, force) in parts.into_iter().filter_map(|(on, own)| Some((on?, own))) {
                    let corners = faces[triangle].nodes.into_iter().zip(shares);
                    corners.for_each(|(k, share)| forces[k] += force * share);
                }
            }
        });
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
        mut emit: impl FnMut(Spot, Matrix3<f64>),
    ) {
        self.detection.visit(faces, x, origin, 0.0, |law, mut met| {
            if safe {
                met.met.curvature = Matrix3::zeros();
            }
            for (Push { hessian, .. }, partner) in met.pushes(law, self.dt) {
                let both = if partner.is_some() { 2.0 } else { 1.0 };
                [Some(met.spot), partner].into_iter().flatten().for_each(|spot| emit(spot, hessian * both));
            }
        });
    }

    /// Refuse a stage from `origin` to `x`, m, in which the wing may have passed through something.
    pub(crate) fn check(&self, faces: &[Face], x: &[Vector], origin: &[Vector]) -> Result<(), WingError> {
        self.detection.itself.as_ref().map_or(Ok(()), |own| own.check(x, origin))?;
        let mut result = Ok(());
        self.detection.visit(faces, x, origin, f64::INFINITY, |_, Meeting { spot, met, .. }| {
            if met.passes_through() {
                result = Err(ContactError::Through { node: faces[spot.triangle].nodes[0] }.into());
            }
        });
        result
    }
}

impl Detection {
    /// Visit each point in the shape `x` with all that it may touch, from the shape `origin`, m; still obstacles farther
    /// than the reach of the contact by `farther` (m) are left out.
    fn visit(
        &self,
        faces: &[Face],
        x: &[Vector],
        origin: &[Vector],
        farther: f64,
        mut visit: impl FnMut(&Law, Meeting<Spot, 3>),
    ) {
        let (balls, reach) = ([origin, x].map(ball), self.law.reach() + farther);
        for (i, points) in self.of.iter().enumerate().filter(|(i, _)| !self.obstacles.is_beyond(*i, balls, reach)) {
            for point in points.iter().map(|&m| &self.points[m as usize]) {
                let &SurfacePoint { triangle, shares, area } = point;
                let corners = faces[triangle].nodes;
                let ends = [origin, x].map(|shape| point.of(corners.map(|k| shape[k])));
                if let Some(met) = self.obstacles.meet(i, ends, 0.0, reach) {
                    visit(&self.law, Meeting { spot: Spot { triangle, shares }, size: area, partners: None, met });
                }
            }
        }
        if let Some(own) = &self.itself {
            own.visit(faces, x, origin, |meeting| visit(&own.law, meeting));
        }
    }
}

/// Return the middle and the radius of a ball around all nodes, m.
fn ball(x: &[Vector]) -> (Vector, f64) {
    let (low, high) = x.iter().fold((x[0], x[0]), |(low, high), x| (low.inf(x), high.sup(x)));
    (0.5 * (low + high), 0.5 * (high - low).norm())
}
