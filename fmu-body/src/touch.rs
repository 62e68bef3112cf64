//! Contact of the body with walls, obstacles and bodies of the fluid that are still or moved by laws.

use adapter::{obstacles, solid_of};
use contact::{BodyContacts, BodyError, Part, PartMotion, Pose};
use nalgebra::{UnitQuaternion, Vector3};
use rigid::{Body, FreeStep, Freedoms, Placed, join};
use scene::Scene;

/// What the body touches.
pub struct Touch {
    solver: BodyContacts<3>,
    /// Names of all parts but the walls; the first is the body.
    names: Vec<String>,
    /// Solids that laws may move.
    solids: Vec<scene::Body>,
    /// Place of the shape from the pivot, in the axes of the body.
    at_rest: Pose<3>,
}

impl Touch {
    /// Return the contact of the flyer of a scene, a `body` that displaces `displaced` kg of the fluid; none without one.
    ///
    /// # Errors
    /// A sentence about two shapes that cannot touch.
    pub fn new(scene: &Scene, body: &Body, displaced: f64) -> Result<Option<Self>, String> {
        let (Some(contact), Some((_, shape))) = (&scene.contact, scene.flyer_solid()) else { return Ok(None) };
        let Some(solid) = solid_of(shape) else { return Ok(None) };
        let parameters = body.parameters();
        let mut at_rest = solid.pose;
        at_rest.origin -= parameters.position;
        let motion = PartMotion { free: parameters.supports.map(|own| own.is_some()), ..PartMotion::still(solid.pose) };
        let about = parameters.inertia.symmetric_eigenvalues().min();
        let turns = motion.free[3..].iter().any(|free| *free);
        let inertia = Some([parameters.mass.max(displaced), if turns { about } else { f64::INFINITY }]);
        let pivot = Vector3::from_fn(|d, _| shape.pivot.get(d).copied().unwrap_or(0.0));
        let own = Part { solid, inertia, pivot, motion };
        let others = obstacles(scene, solid_of).into_iter().map(|solid| {
            let motion = PartMotion::still(solid.pose);
            Part { solid, inertia: None, pivot: Vector3::zeros(), motion }
        });
        let (mut names, solids): (Vec<_>, Vec<_>) = scene.contact_bodies_with_keys().unzip();
        names.insert(0, "the flyer".into());
        match BodyContacts::new([own].into_iter().chain(others).collect(), &contact.law_of_bodies(scene)) {
            Ok(solver) => Ok(Some(Self { solver, names, solids, at_rest })),
            Err(pair) => Err(BodyError::Touch(BodyError::names(pair, &names)).to_string()),
        }
    }

    /// Return the change of the velocities of the body by contact in a step from time `t`, s; none where it touches
    /// nothing.
    ///
    /// # Errors
    /// A sentence about two parts that cannot part.
    pub fn solve(&mut self, t: f64, step: &FreeStep, end: &Placed) -> Result<Option<Freedoms>, String> {
        let Self { solver, names, solids, at_rest } = self;
        let pose = |at: &Placed| Pose {
            axes: at_rest.axes.map(|axis| at.orientation * axis),
            origin: at.position + at.orientation * at_rest.origin,
        };
        let own = solver.motion_mut(0);
        *own = PartMotion {
            poses: [pose(&step.from.now), pose(end)],
            rates: end.rates(),
            matrix: step.matrix,
            free: own.free,
        };
        for (k, body) in solids.iter().enumerate() {
            let poses: [Pose<3>; 2] = [t, t + step.h].map(|t| body.place_at(t));
            *solver.motion_mut(k + 1) =
                PartMotion { rates: rates(&poses, step.h), poses, ..PartMotion::still(poses[1]) };
        }
        match solver.solve(step.c[0], step.h) {
            Ok(changes) => Ok(changes.map(|changes| changes[0])),
            Err(pair) => Err(BodyError::Deep { time: t + step.h, bodies: BodyError::names(pair, &*names) }.to_string()),
        }
    }
}

/// Return the mean velocities between two poses that are `h` seconds apart.
fn rates([from, to]: &[Pose<3>; 2], h: f64) -> Freedoms {
    let axes = |pose: &Pose<3>| nalgebra::Matrix3::from_columns(&pose.axes);
    let turn = UnitQuaternion::from_matrix(&(axes(to) * axes(from).transpose()));
    join::<3>(&((to.origin - from.origin) / h), turn.scaled_axis() / h)
}
