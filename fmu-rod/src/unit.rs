//! The unit: a rod with its scene, inputs and results.

use adapter::{Announced, Carried, Dimensions, either};
use rod::{BaseMotion, Energy, Error, Loads, RootResponse, RootSupport};
use scene::{Beam, FlyerHinge, RootMotion, Scene};

use crate::body::{Body, Plan};
use crate::parameters::Parameters;
use crate::{body, from_scene};

const BUILT: &str = "an instance has a body";

/// The unit of one rod of a scene.
pub struct RodUnit {
    /// Name in the model description.
    pub name: String,
    /// Scene of this rod alone.
    pub scene: Scene,
    pub beam: Beam,
    pub rod: scene::Rod,
    pub parameters: Parameters,
    /// Parameters of the body that is built of them.
    pub plan: Plan,
    /// Loads of the next step.
    pub loads: Loads,
    /// None in a description.
    body: Option<Body>,
    /// Solids that the rod touches.
    obstacles: Vec<scene::Body>,
    pub base: BaseInputs,
    /// Name of the load from a fluid and the reason for the choice; empty without a fluid.
    pub load: [String; 2],
    pub energy: Energy,
    /// Response of the root, if a body carries the rod.
    pub announced: Option<Announced>,
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
    /// Return the unit without its body.
    pub fn new(
        name: String,
        scene: Scene,
        (beam, mut rod): (Beam, scene::Rod),
        load: [String; 2],
        hinge: Option<&FlyerHinge>,
    ) -> Result<Self, Error> {
        if hinge.is_some() {
            rod.root_motion = Some(RootMotion::Master);
        }
        let announced = hinge.map(|_| Announced::new(scene.time.communication_step));
        let plan = body::plan(&scene, &beam, &rod);
        either!(&plan, parameters => parameters.check()?);
        let (position, direction) = scene.beam_root(&beam);
        let angle = direction[1].atan2(direction[0]);
        let still = [0.0; 3];
        Ok(Self {
            name,
            parameters: Parameters::of(&plan),
            load,
            loads: from_scene::loads(&scene, plan.count(), beam.segments + 1),
            energy: Energy::default(),
            base: BaseInputs { position, velocity: still, angle, omega: 0.0, direction, direction_rate: still },
            obstacles: scene.contact_bodies(),
            scene,
            beam,
            rod,
            plan,
            body: None,
            announced,
        })
    }

    /// Build the body, at the place of time 0.
    pub fn build(&mut self) -> Result<(), Error> {
        self.set_body(body::build(&self.plan)?);
        self.energy = either!(self.body(), rod => rod.energy()?);
        self.place(0.0)
    }

    /// Build the body again if its parameters changed.
    pub fn apply_parameters(&mut self) -> Result<(), Error> {
        if Parameters::of(&self.plan) == self.parameters {
            return Ok(());
        }
        let mut plan = self.plan.clone();
        self.parameters.apply(&mut plan);
        self.set_body(body::build(&plan)?);
        self.plan = plan;
        Ok(())
    }

    fn set_body(&mut self, mut body: Body) {
        either!(&mut body, rod => rod.loads = self.loads.clone());
        if let (Some(_), Dimensions::Space(rod)) = (&self.announced, &mut body) {
            rod.carry();
        }
        self.body = Some(body);
    }

    pub fn body(&self) -> &Body {
        self.body.as_ref().expect(BUILT)
    }

    pub fn body_mut(&mut self) -> &mut Body {
        self.body.as_mut().expect(BUILT)
    }

    /// Return the number of stations.
    pub fn stations(&self) -> usize {
        self.beam.segments + 1
    }

    /// Return component `axis` of the nodal forces.
    pub fn force_mut(&mut self, axis: usize) -> &mut [f64] {
        self.mark_stale();
        let stations = self.stations();
        &mut self.loads.force[axis * stations..(axis + 1) * stations]
    }

    /// Compute the energy, which several outputs read.
    pub fn copy_to_outputs(&mut self) -> Result<(), Error> {
        self.energy = either!(self.body(), rod => rod.energy()?);
        let Energy { stretching, bending, kinetic, contact, gravity } = self.energy;
        let total = stretching + bending + kinetic + contact + gravity;
        if total.is_finite() {
            return Ok(());
        }
        Err(Error::Value { name: "the energy of the rod".into(), value: format!("{total} J"), allowed: "finite" })
    }

    pub fn support(&self) -> RootSupport {
        either!(&self.plan, parameters => parameters.support)
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
                match self.plan {
                    Plan::Plane(_) => {
                        let (sin, cos) = angle.sin_cos();
                        [position, velocity, [cos, sin, 0.0], [-omega * sin, omega * cos, 0.0]]
                    }
                    Plan::Space(_) => [position, velocity, direction, direction_rate],
                }
            }
        })
    }

    /// Return the motion of the root that a master sets.
    pub fn base_mut(&mut self) -> &mut BaseInputs {
        self.mark_stale();
        &mut self.base
    }

    /// Place the rod at rest with its root in the state of time `t`, if the root moves.
    pub fn place(&mut self, t: f64) -> Result<(), Error> {
        self.move_obstacles([t; 2]);
        match self.base_at(t) {
            Some(base) => either!(self.body_mut(), rod => rod.place(base_motion(base))),
            None => Ok(()),
        }
    }

    /// Move the solids that laws move, between two times, s.
    fn move_obstacles(&mut self, times: [f64; 2]) {
        let body = self.body.as_mut().expect(BUILT);
        for (i, own) in self.obstacles.iter().enumerate().filter(|(_, own)| own.laws().is_some()) {
            either!(&mut *body, rod => rod.move_obstacle(i, times.map(|t| own.place_at(t))));
        }
    }

    /// Advance from `t` to `t + h`.
    pub fn step(&mut self, t: f64, h: f64) -> Result<(), Error> {
        self.move_obstacles([t, t + h]);
        if let Some(base) = self.base_at(t + h) {
            either!(self.body_mut(), rod => rod.base_motion = Some(base_motion(base)));
        }
        if let Some(towing) = self.rod.root.towing_force(t + h) {
            either!(self.body_mut(), rod => rod.towing = std::array::from_fn(|d| towing[d]));
        }
        let (body, loads) = (self.body.as_mut().expect(BUILT), &self.loads);
        either!(body, rod => {
            rod.loads.copy_from(loads);
            rod.step(h)?;
        });
        self.copy_to_outputs()
    }
}

impl Carried for RodUnit {
    fn announced(&mut self) -> Option<&mut Announced> {
        self.announced.as_mut()
    }

    fn response(&mut self) -> &RootResponse {
        let base = self.base_at(0.0);
        let Self { announced: Some(announced), body: Some(Dimensions::Space(rod)), loads, .. } = self else {
            return &adapter::UNKNOWN;
        };
        announced.or_find(|step| {
            rod.base_motion = base.map(base_motion);
            rod.loads.copy_from(loads);
            rod.root_response(step)
        })
    }
}
