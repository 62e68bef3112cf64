//! The unit: a body with its scene, its inputs and what it carries.

use method::Support;
use nalgebra::{Matrix3, UnitQuaternion, UnitVector3, Vector3};
use rigid::{
    Body, BodyParameters, BodyState, Drag, FluidLoad, Flyer, FlyerState, Force, Freedoms, HingeTurn, Mass, Placed,
    RootResponse, nearest,
};
use scene::{FlyerHinge, FreedomName, Scene};
use serde::{Deserialize, Serialize};

use crate::touch::Touch;

const BUILT: &str = "an instance has a body";

/// Largest difference of the norm of a quaternion from 1, which rounding makes.
const TURNED: f64 = 1e-6;

/// The unit of a free body.
pub struct BodyUnit {
    pub scene: Scene,
    pub own: scene::Flyer,
    /// Parameters that a master may set before the start.
    pub mass: f64,
    pub gravity: [f64; 3],
    /// None in a description.
    flyer: Option<Flyer>,
    touch: Option<Touch>,
    pub hinges: Vec<Carrying>,
    /// Length of the coming step, s.
    pub step: f64,
    pub fluid: Option<OfFluid>,
    time: f64,
    /// Rotation vector from rest, continuous in time.
    pub angle: [f64; 3],
    /// Room for the turn of a root that is read, row by row.
    pub rotation: [f64; 9],
}

/// A hinge with what it carries.
pub struct Carrying {
    pub name: String,
    hinge: FlyerHinge,
    /// Turn of the axes of the wing.
    rest: UnitQuaternion<f64>,
    /// Direction of a rod in the axes of the body; none of a wing.
    pub direction: Option<Vector3<f64>>,
    /// Stroke, deviation and pitch at the end of the next step, where the master sets them, with their rates.
    pub angles: [f64; 3],
    pub rates: [f64; 3],
    /// What it announces for the coming step.
    pub response: RootResponse,
    /// Force of the body on the root, and moment, at the end of the last step.
    pub force: [f64; 3],
    pub moment: [f64; 3],
}

/// What the fluid announces for a body that keeps its velocities.
pub struct OfFluid {
    pub force: [f64; 3],
    pub moment: [f64; 3],
    pub impedance: [Freedoms; 6],
    /// Mass of the displaced fluid, its moments of inertia about the pivot and its centroid, in the axes of the body.
    displaced: (f64, Matrix3<f64>, Vector3<f64>),
}

/// State of the unit between two steps.
#[derive(Clone, Serialize, Deserialize)]
pub struct UnitState {
    flyer: FlyerState,
    time: f64,
    angle: [f64; 3],
}

impl BodyUnit {
    /// Return the unit without its solver.
    pub fn new(scene: Scene) -> Result<Self, String> {
        let Some(own) = scene.flyer.clone() else { return Err(format!("the scene {:?} has no flyer", scene.name)) };
        let hinges = own.hinges.iter().map(|hinge| {
            let beam = scene.beams_with_rods().find(|beam| beam.name.unwrap_or("rod") == hinge.carries);
            let rest = hinge.turn.as_ref().map_or(UnitQuaternion::identity(), |turn| {
                let axis = UnitVector3::new_normalize(Vector3::from(turn.axis));
                UnitQuaternion::from_axis_angle(&axis, turn.angle)
            });
            let start = hinge.laws().map_or([(0.0, 0.0); 3], |laws| laws.angles(0.0));
            Carrying {
                name: hinge.carries.clone(),
                hinge: hinge.clone(),
                rest,
                direction: beam.map(|own| Vector3::from(scene.beam_root(own.beam).1)),
                angles: start.map(|(angle, _)| angle),
                rates: start.map(|(_, rate)| rate),
                response: RootResponse::default(),
                force: [0.0; 3],
                moment: [0.0; 3],
            }
        });
        let fluid = own.shape.and_then(|k| {
            let (mass, inertia, arm) = scene.displaced_by_body(k)?;
            let displaced = (mass, Matrix3::from_fn(|i, j| inertia[i][j]), Vector3::from(arm));
            Some(OfFluid { force: [0.0; 3], moment: [0.0; 3], impedance: [[0.0; 6]; 6], displaced })
        });
        Ok(Self {
            hinges: hinges.collect(),
            step: scene.time.communication_step,
            mass: own.mass,
            gravity: own.gravity,
            flyer: None,
            touch: None,
            fluid,
            time: 0.0,
            angle: [0.0; 3],
            rotation: [0.0; 9],
            own,
            scene,
        })
    }

    /// Build the body, at its start.
    pub fn build(&mut self) -> Result<(), String> {
        let own = &self.own;
        let [x, y, z] = own.inertia.about();
        let [yz, zx, xy] = own.products_of_inertia;
        let names = [
            FreedomName::X,
            FreedomName::Y,
            FreedomName::Z,
            FreedomName::AngleX,
            FreedomName::AngleY,
            FreedomName::AngleZ,
        ];
        let supports = names.map(|name| {
            let mut springs = own.springs.iter().filter(|spring| spring.along == name);
            let free = Support { stiffness: 0.0, damping: 0.0, rest: 0.0 };
            (!own.held.contains(&name)).then(|| springs.next().map_or(free, |spring| spring.support))
        });
        let body = Body::new(BodyParameters {
            mass: self.mass,
            inertia: Matrix3::new(x, xy, zx, xy, y, yz, zx, yz, z),
            centre: own.centre_of_mass.into(),
            supports,
            gravity: self.gravity.into(),
            position: own.position.into(),
        });
        let start = Placed { velocity: own.velocity.into(), omega: own.angular_velocity.into(), ..body.state.now };
        let mut flyer = Flyer::new(body, own.hinges.iter().map(|hinge| hinge.position.into()).collect());
        flyer.place(start);
        let displaced = self.fluid.as_ref().map_or(0.0, |fluid| fluid.displaced.0);
        self.touch = Touch::new(&self.scene, flyer.body(), displaced)?;
        (self.flyer, self.angle) = (Some(flyer), [0.0; 3]);
        Ok(())
    }

    /// Begin at time `t`, s.
    pub fn start(&mut self, t: f64) -> Result<(), String> {
        self.build()?;
        self.time = t;
        Ok(())
    }

    /// Return the body.
    pub fn body(&self) -> &Body {
        self.flyer().body()
    }

    fn flyer(&self) -> &Flyer {
        self.flyer.as_ref().expect(BUILT)
    }

    /// Return place and motion of the root at hinge `k`.
    pub fn root(&self, k: usize) -> Placed {
        self.flyer().root(k, &self.body().state.now, &self.turn(k, self.time))
    }

    /// Return those at the end of the coming step if the body keeps its accelerations.
    pub fn reference(&self, k: usize) -> Placed {
        self.flyer().root(k, &self.body().reference(self.step), &self.turn(k, self.time + self.step))
    }

    /// Return the turn of hinge `k` at time `t`.
    fn turn(&self, k: usize, t: f64) -> HingeTurn {
        let Carrying { hinge, rest, angles, rates, .. } = &self.hinges[k];
        let (mut angles, mut rates) = (*angles, *rates);
        if let Some(laws) = hinge.laws() {
            let now = laws.angles(t);
            (angles, rates) = (now.map(|(angle, _)| angle), now.map(|(_, rate)| rate));
        }
        let [stroke, deviation, pitch] = [
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angles[0]),
            UnitQuaternion::from_axis_angle(&Vector3::y_axis(), angles[1]),
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), angles[2]),
        ];
        let rate = Vector3::z() * rates[0] + stroke * (Vector3::y() * rates[1] + deviation * Vector3::x() * rates[2]);
        HingeTurn { turn: rest * stroke * deviation * pitch, rate: rest * rate }
    }

    /// Advance from `t` to `t + h`.
    pub fn advance(&mut self, t: f64, h: f64) -> Result<(), String> {
        if (h - self.step).abs() > 1e-9 * h {
            return Err(format!("the step of {h:e} s must be the announced `step`, {:e} s", self.step));
        }
        let responses: Vec<_> = self.hinges.iter().map(|own| own.response).collect();
        let reactions: Vec<Freedoms> = self.hinges.iter().map(Carrying::reaction).collect();
        let before = self.flyer().state();
        let mut load = FluidLoad::default();
        if let Some(OfFluid { force, moment, impedance, displaced: (mass, inertia, arm) }) = &self.fluid {
            let turn = self.body().predicted(h);
            let inertia = turn * inertia * turn.inverse();
            let force = Force { force: Vector3::from(*force), moment: Vector3::from(*moment) };
            load.drag = Drag { force, impedance: *impedance };
            load.displaced = Mass { mass: *mass, inertia: inertia.into(), arm: turn * arm };
        }
        let flyer = self.flyer.as_mut().expect(BUILT);
        let step = flyer.step(h, &responses, &reactions, &load);
        let end = flyer.body().state.now;
        let pushed = match &mut self.touch {
            Some(touch) if end.is_finite() => touch.solve(t, &step, &end),
            _ => Ok(None),
        };
        if let Ok(Some(change)) = &pushed {
            flyer.change(&step, change, &responses);
        }
        let is_finite = flyer.body().state.now.is_finite() && flyer.body().energy().iter().all(|own| own.is_finite());
        if !is_finite || pushed.is_err() {
            flyer.restore(&before);
        }
        pushed?;
        if !is_finite {
            return Err("the place or the energy of the body is no finite number".into());
        }
        self.time = t + h;
        self.angle = nearest(self.body().state.now.orientation.scaled_axis(), &self.angle.into()).into();
        Ok(())
    }

    pub fn save(&self) -> UnitState {
        UnitState { flyer: self.flyer().state(), time: self.time, angle: self.angle }
    }

    pub fn restore(&mut self, state: &UnitState) -> Result<(), String> {
        if !state.flyer.body.now.is_finite() || !state.flyer.body.before.is_finite() {
            return Err("the place of the body is no finite number".into());
        }
        let BodyState { now, before, last_step, .. } = &state.flyer.body;
        if [now, before].iter().any(|own| (own.orientation.coords.norm() - 1.0).abs() > TURNED) || *last_step < 0.0 {
            return Err("the body is turned by no rotation, or its last step is negative".into());
        }
        self.build()?;
        self.flyer.as_mut().expect(BUILT).restore(&state.flyer);
        (self.time, self.angle) = (state.time, state.angle);
        Ok(())
    }
}

impl Carrying {
    /// Return whether the master sets its angles.
    pub fn is_driven(&self) -> bool {
        self.hinge.is_driven()
    }

    /// Return force and moment on the body at the end of the last step.
    fn reaction(&self) -> Freedoms {
        let ([x, y, z], [about_x, about_y, about_z]) = (self.force, self.moment);
        [-x, -y, -z, -about_x, -about_y, -about_z]
    }
}
