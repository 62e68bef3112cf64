//! A free body with what it carries at its hinges.

use std::array::from_fn;

use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::body::{Body, BodyState, FreeStep, Placed};
use crate::force::Drag;
use crate::hinge::{RootResponse, force_about, rates_at};
use crate::kinematics::{Freedoms, join};
use crate::step::Mass;

/// Turn of a hinge and its rate, in the axes of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HingeTurn {
    /// Turn from rest.
    pub turn: UnitQuaternion<f64>,
    /// Angular velocity, rad/s.
    pub rate: Vector3<f64>,
}

/// What the fluid does to a body.
#[derive(Clone, Copy, Debug)]
pub struct FluidLoad {
    /// Force and moment about the pivot if the body keeps its velocities, and how they fall with them.
    pub drag: Drag<3>,
    /// The displaced fluid.
    pub displaced: Mass<3>,
}

impl Default for FluidLoad {
    fn default() -> Self {
        Self { drag: Drag::default(), displaced: Mass { mass: 0.0, inertia: [[0.0; 3]; 3], arm: Vector3::zeros() } }
    }
}

/// A free body with hinges.
#[derive(Clone, Debug)]
pub struct Flyer {
    body: Body,
    /// Hinges from the pivot, in the axes of the body, m.
    hinges: Vec<Vector3<f64>>,
    /// Force along the freedoms that the last step assumed of all that the body carries.
    assumed: Freedoms,
}

/// State of a body with hinges between two steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlyerState {
    /// State of the body.
    pub body: BodyState,
    /// See [`Flyer::step`].
    pub assumed: Freedoms,
}

impl Flyer {
    /// Return a `body` with `hinges` at these places from the pivot, in the axes of the body, m.
    pub fn new(body: Body, hinges: Vec<Vector3<f64>>) -> Self {
        Self { body, hinges, assumed: [0.0; 6] }
    }

    /// Return the body.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// Put the body in a place, before a first step.
    pub fn place(&mut self, now: Placed) {
        self.body.place(now);
        self.assumed = [0.0; 6];
    }

    /// Return the state.
    pub fn state(&self) -> FlyerState {
        FlyerState { body: self.body.state, assumed: self.assumed }
    }

    /// Continue from a state.
    pub fn restore(&mut self, state: &FlyerState) {
        (self.body.state, self.assumed) = (state.body, state.assumed);
    }

    /// Return the root of what hinge `k` carries, on the body `at` a place.
    pub fn root(&self, k: usize, at: &Placed, hinge: &HingeTurn) -> Placed {
        at.hinged(&self.hinges[k], &hinge.turn, &hinge.rate)
    }

    /// Advance by `h` seconds.
    ///
    /// `responses` are what the hinges bear in this step if the body moves as its reference, `reactions` what they bore
    /// at the end of the last step.
    pub fn step(&mut self, h: f64, responses: &[RootResponse], reactions: &[Freedoms], fluid: &FluidLoad) -> FreeStep {
        let reference = self.body.reference(h);
        let known = reference.rates();
        let mut load = fluid.drag;
        // The fluid announces its force for a body that keeps its velocities.
        let (kept, impedance) = (self.body.state.now.rates(), fluid.drag.impedance);
        let falls = RootResponse { reaction: join::<3>(&load.force.force, load.force.moment), impedance };
        let mut forces = falls.at(&from_fn(|i| known[i] - kept[i]));
        if self.body.state.last_step > 0.0 {
            forces = from_fn(|i| forces[i] - self.assumed[i]);
            for (hinge, reaction) in self.hinges.iter().zip(reactions) {
                let borne = force_about(&(self.body.state.now.orientation * hinge), reaction);
                forces = from_fn(|i| forces[i] + borne[i]);
            }
        }
        load.force.force = Vector3::new(forces[0], forces[1], forces[2]);
        load.force.moment = Vector3::new(forces[3], forces[4], forces[5]);
        for (response, hinge) in responses.iter().zip(&self.hinges) {
            load.add_root(response, &(reference.orientation * hinge));
        }
        let gravity = self.body.parameters().gravity;
        let lift = -fluid.displaced.mass * gravity;
        let lift = join::<3>(&lift, fluid.displaced.arm.cross(&lift));
        let step = self.body.step(h, &load, &fluid.displaced, &lift);
        self.assume(&step.reference, responses);
        step
    }

    /// Change the velocities of the body at the end of the step that has just been made with these `responses`.
    pub fn change(&mut self, step: &FreeStep, change: &Freedoms, responses: &[RootResponse]) {
        self.body.change(step, change);
        self.assume(&step.reference, responses);
    }

    /// Keep what the step assumed of what the body carries.
    fn assume(&mut self, reference: &Placed, responses: &[RootResponse]) {
        let (rates, known) = (self.body.state.now.rates(), reference.rates());
        let change: Freedoms = from_fn(|i| rates[i] - known[i]);
        self.assumed = [0.0; 6];
        for (response, hinge) in responses.iter().zip(&self.hinges) {
            let arm = reference.orientation * hinge;
            let assumed = force_about(&arm, &response.at(&rates_at(&arm, &change)));
            self.assumed = from_fn(|i| self.assumed[i] + assumed[i]);
        }
    }
}
