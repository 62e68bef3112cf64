//! The unit: a rod with its scene, inputs and results.

use rod::{BaseMotion, Energy, Error, RootSupport};
use scene::{Beam, RootMotion, Scene};

use crate::body::{Body, either};
use crate::parameters::Parameters;

/// The unit of one rod of a scene.
pub struct RodUnit {
    /// Name in the model description.
    pub name: String,
    /// Scene of this rod alone.
    pub scene: Scene,
    pub beam: Beam,
    pub rod: scene::Rod,
    pub parameters: Parameters,
    pub body: Body,
    pub base: BaseInputs,
    /// Name of the load from a fluid and the reason for the choice; empty without a fluid.
    pub load: [String; 2],
    pub energy: Energy,
}

/// Motion of the root as inputs of a master that drives it.
#[derive(Clone, Copy)]
pub struct BaseInputs {
    pub position: [f64; 3],
    pub velocity: [f64; 3],
    /// Angle of the direction from the x axis, rad, in the plane.
    pub angle: f64,
    /// Rate of the angle, rad/s, in the plane.
    pub omega: f64,
    /// Direction, in space.
    pub direction: [f64; 3],
    /// Rate of the direction, 1/s, in space.
    pub direction_rate: [f64; 3],
}

/// Position, velocity, direction and direction rate of the root.
type BaseVectors = [[f64; 3]; 4];

/// Return the first `D` components of the motion of the root.
fn base_motion<const D: usize>(vectors: BaseVectors) -> BaseMotion<D> {
    let [position, velocity, direction, direction_rate] = vectors.map(|vector| std::array::from_fn(|d| vector[d]));
    BaseMotion { position, velocity, direction, direction_rate }
}

impl RodUnit {
    /// Build the unit with its rod at the place of time 0.
    pub fn new(name: String, scene: Scene, (beam, rod): (Beam, scene::Rod), load: [String; 2]) -> Result<Self, Error> {
        let body = Body::new(&scene, &beam, &rod)?;
        let (position, direction) = scene.beam_root(&beam);
        let angle = direction[1].atan2(direction[0]);
        let still = [0.0; 3];
        let mut unit = Self {
            name,
            parameters: Parameters::of(&body),
            load,
            energy: either!(&body, rod => rod.energy()?),
            base: BaseInputs { position, velocity: still, angle, omega: 0.0, direction, direction_rate: still },
            scene,
            beam,
            rod,
            body,
        };
        unit.place(0.0)?;
        Ok(unit)
    }

    /// Compute the energy, which several outputs read.
    pub fn copy_to_outputs(&mut self) -> Result<(), Error> {
        self.energy = either!(&self.body, rod => rod.energy()?);
        let Energy { stretching, bending, kinetic, gravity } = self.energy;
        let total = stretching + bending + kinetic + gravity;
        if total.is_finite() {
            return Ok(());
        }
        Err(Error::Value { name: "the energy of the rod".into(), value: format!("{total} J"), allowed: "finite" })
    }

    pub fn support(&self) -> RootSupport {
        either!(&self.body, rod => rod.parameters().support)
    }

    /// Return the motion of the root at time `t`; `None` for a root at rest.
    fn base_at(&self, t: f64) -> Option<BaseVectors> {
        Some(match self.rod.root_motion.as_ref()? {
            RootMotion::Laws(laws) => {
                let (rest, direction) = self.scene.beam_root(&self.beam);
                let (displacement, velocity) = laws.displacement(t);
                let (direction, rate) = laws.direction(t, direction);
                [std::array::from_fn(|d| rest[d] + displacement[d]), velocity, direction, rate]
            }
            RootMotion::Master => {
                let BaseInputs { position, velocity, angle, omega, direction, direction_rate } = self.base;
                match self.body {
                    Body::Planar(_) => {
                        let (sin, cos) = angle.sin_cos();
                        [position, velocity, [cos, sin, 0.0], [-omega * sin, omega * cos, 0.0]]
                    }
                    Body::Spatial(_) => [position, velocity, direction, direction_rate],
                }
            }
        })
    }

    /// Place the rod at rest with its root in the state of time `t`, if the root moves.
    pub fn place(&mut self, t: f64) -> Result<(), Error> {
        match self.base_at(t) {
            Some(base) => either!(&mut self.body, rod => rod.place(base_motion(base))),
            None => Ok(()),
        }
    }

    /// Advance from `t` to `t + h`.
    pub fn step(&mut self, t: f64, h: f64) -> Result<(), Error> {
        if let Some(base) = self.base_at(t + h) {
            either!(&mut self.body, rod => rod.base_motion = Some(base_motion(base)));
        }
        if let Some(towing) = self.rod.root.towing_force(t + h) {
            either!(&mut self.body, rod => rod.towing = std::array::from_fn(|d| towing[d]));
        }
        self.body.step(h)?;
        self.copy_to_outputs()
    }
}
