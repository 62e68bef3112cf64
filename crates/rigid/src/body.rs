//! A free body that carries others.
//!
//! With the generalised velocities q' = (v of the pivot, omega), the velocity v + omega × a of the centre of mass at `a`
//! from the pivot, momentum P, angular momentum L about the centre of mass, and two-step backward differences 𝒟,
//!
//! ```text
//! J(q)ᵀ (𝒟P, 𝒟L) = r_ref − Z (q' − q'_ref) + weight − springs and dampers + defect,      J = (v, omega of the centre)/q'
//! ```
//!
//! What it carries announces the force `r_ref` that it will exert if the body keeps its accelerations,
//! `q'_ref = 2 q'_n − q'_(n−1)`, and the rate `Z` at which it falls with q'. Then the body and all it carries are one
//! implicit system, stable at every ratio of masses. What the force turns out to be less what the step assumed is the
//! defect, which the next step adds: momentum is not lost.
//!
//! The orientation R obeys the differences as a deviation θ from a body that turns without moments,
//!
//! ```text
//! R_f' = omega_f × R_f,  R_f(t_n) = R_n,  R_f I R_fᵀ omega_f = L_n;      R = exp(θ) R_f,  𝒟θ = omega − omega_f,  θ_n = 0
//! ```
//!
//! so that a body without moments turns as it would to fifth order. A body that is held about an axis deviates from one
//! that keeps omega.

use std::array::from_fn;

use method::Support;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::force::Drag;
use crate::history::DisplacementHistory;
use crate::kinematics::{Freedoms, Kinematics, join};
use crate::pose::Pose;
use crate::step::{Mass, SpringStep};

/// Largest ratio of two steps that the two-step differences allow; else a step is of first order.
const LARGEST_RATIO: f64 = 2.4;
/// Change of an angle in an iteration of the orientation that counts as rounding, rad.
const ROUNDING: f64 = 1e-14;
/// Most iterations of the orientation; each one shortens the change by about the angle of a step.
const ITERATIONS: usize = 30;

/// Parameters of a body.
#[derive(Clone, Debug)]
pub struct BodyParameters {
    /// Mass, kg.
    pub mass: f64,
    /// Inertia about the centre of mass, in the axes of the body, kg m².
    pub inertia: Matrix3<f64>,
    /// Centre of mass from the pivot, in the axes of the body, m.
    pub centre: Vector3<f64>,
    /// Spring and damper along each axis and about it; absent where the body is held.
    pub supports: [Option<Support>; 6],
    /// Gravity, m/s².
    pub gravity: Vector3<f64>,
    /// Position of the pivot at rest, m.
    pub position: Vector3<f64>,
}

/// Place and motion of a body, or of a root on it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placed {
    /// Position of the pivot, m.
    pub position: Vector3<f64>,
    /// Turn from rest.
    pub orientation: UnitQuaternion<f64>,
    /// Velocity of the pivot, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub omega: Vector3<f64>,
}

impl Placed {
    /// Return place and motion of what turns about a point at `arm` (m) in the axes of the body by `turn`, with the rate
    /// `rate` (rad/s) in these axes.
    pub fn hinged(&self, arm: &Vector3<f64>, turn: &UnitQuaternion<f64>, rate: &Vector3<f64>) -> Self {
        let arm = self.orientation * arm;
        Self {
            position: self.position + arm,
            orientation: self.orientation * turn,
            velocity: self.velocity + self.omega.cross(&arm),
            omega: self.omega + self.orientation * rate,
        }
    }

    /// Return the velocities along the freedoms.
    pub fn rates(&self) -> Freedoms {
        join::<3>(&self.velocity, self.omega)
    }

    /// Return whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        let vectors = [self.position, self.velocity, self.omega];
        vectors.iter().flatten().chain(self.orientation.coords.iter()).all(|x| x.is_finite())
    }

    /// Return place and motion as a displacement from rest, with the rotation vector as the angle.
    pub fn displacement(&self, rest: &Vector3<f64>) -> Pose<3> {
        Pose {
            position: self.position - rest,
            angle: self.orientation.scaled_axis(),
            velocity: self.velocity,
            omega: self.omega,
        }
    }
}

/// State of a body between two steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyState {
    /// At the present time.
    pub now: Placed,
    /// One step earlier.
    pub before: Placed,
    /// Accelerations along the freedoms in the last step.
    pub acceleration: Freedoms,
    /// Length of the last step, s; 0 before the first.
    pub last_step: f64,
}

/// A step that contact may still change.
#[derive(Clone, Copy, Debug)]
pub struct FreeStep {
    /// State before it.
    pub from: BodyState,
    /// Place and motion with which the load was announced.
    pub reference: Placed,
    /// Coefficients of the backward differences, 1/s.
    pub c: [f64; 3],
    /// Length, s.
    pub h: f64,
    /// Rate at which a force grows with the velocities, kg/s.
    pub matrix: [Freedoms; 6],
}

/// A free body.
#[derive(Clone, Debug)]
pub struct Body {
    parameters: BodyParameters,
    /// Inertia that turns where no moment acts: about a held pivot, else about the centre of mass; and its inverse.
    turning: [Matrix3<f64>; 2],
    /// State.
    pub state: BodyState,
}

impl Body {
    /// Return a body at rest.
    pub fn new(parameters: BodyParameters) -> Self {
        let still = Vector3::zeros();
        let orientation = UnitQuaternion::identity();
        let now = Placed { position: parameters.position, orientation, velocity: still, omega: still };
        let state = BodyState { now, before: now, acceleration: [0.0; 6], last_step: 0.0 };
        let BodyParameters { mass, inertia, centre, supports, .. } = &parameters;
        let is_held = supports[..3].iter().all(Option::is_none);
        let turning = if is_held { <[f64; 3]>::shifted(*inertia, *mass, centre) } else { *inertia };
        Self { turning: [turning, turning.try_inverse().unwrap_or_default()], parameters, state }
    }

    /// Return the parameters.
    pub fn parameters(&self) -> &BodyParameters {
        &self.parameters
    }

    /// Return the body in a place, before a first step.
    pub fn place(&mut self, now: Placed) {
        self.state = BodyState { now, before: now, acceleration: [0.0; 6], last_step: 0.0 };
    }

    /// Return momentum, kg m/s, and angular momentum about the origin of coordinates, kg m²/s.
    pub fn momentum(&self) -> [Vector3<f64>; 2] {
        let [momentum, angular] = self.momentum_of(&self.state.now);
        let centre = self.state.now.position + self.state.now.orientation * self.parameters.centre;
        [momentum, angular + centre.cross(&momentum)]
    }

    /// Return the kinetic energy, and the potential energy in gravity, 0 at rest, J.
    pub fn energy(&self) -> [f64; 2] {
        let BodyParameters { mass, centre, gravity, position, .. } = &self.parameters;
        let now = &self.state.now;
        let [momentum, angular] = self.momentum_of(now);
        let arm = now.orientation * centre;
        let velocity = now.velocity + now.omega.cross(&arm);
        let moved = now.position - position + arm - centre;
        [0.5 * (momentum.dot(&velocity) + angular.dot(&now.omega)), -mass * gravity.dot(&moved)]
    }

    /// Return place and motion that a body with the accelerations of the last step would have after a step of `h`
    /// seconds.
    pub fn reference(&self, h: f64) -> Placed {
        self.reference_by(&self.differences(h), h)
    }

    fn reference_by(&self, c: &[f64; 3], h: f64) -> Placed {
        let BodyState { now, before, last_step, .. } = &self.state;
        let ratio = if *last_step > 0.0 { h / last_step } else { 0.0 };
        let velocities = from_fn(|i| now.rates()[i] + ratio * (now.rates()[i] - before.rates()[i]));
        self.moved(c, h, &velocities)
    }

    /// Return the turn from rest with which the fluid predicts its load of a step of `h` seconds.
    pub fn predicted(&self, h: f64) -> Rotation3<f64> {
        Rotation3::new(self.history().predicted(h, self.state.last_step).angle)
    }

    /// Return the displacement from rest.
    fn history(&self) -> DisplacementHistory<3> {
        let BodyState { now, before, acceleration, .. } = &self.state;
        let [now, before] = [now, before].map(|at| at.displacement(&self.parameters.position));
        DisplacementHistory { now, before, acceleration: *acceleration }
    }

    /// Advance by `h` seconds under `load`, a force with its moment about the pivot that falls with the velocities from
    /// those of [`Self::reference`] on. `fluid` is the fluid of a density that it displaces, and `lift` the force
    /// of that fluid's weight along the freedoms.
    pub fn step(&mut self, h: f64, load: &Drag<3>, fluid: &Mass<3>, lift: &Freedoms) -> FreeStep {
        let (from, c) = (self.state, self.differences(h));
        let reference = self.reference_by(&c, h);
        FreeStep { from, reference, c, h, matrix: self.step_by(&c, h, &self.history(), load, fluid, lift) }
    }

    /// Change the velocities at the end of the step that has just been made.
    pub fn change(&mut self, step: &FreeStep, change: &Freedoms) {
        let rates = self.state.now.rates();
        let done = std::mem::replace(&mut self.state, step.from);
        let now = self.moved(&step.c, step.h, &from_fn(|i| rates[i] + change[i]));
        let acceleration = from_fn(|i| done.acceleration[i] + step.c[0] * change[i]);
        self.state = BodyState { now, acceleration, ..done };
    }

    /// Do so with the backward differences `c` and the displacement `history` from rest; return the rate at which a force
    /// grows with the velocities, kg/s.
    pub(crate) fn step_by(
        &mut self,
        c: &[f64; 3],
        h: f64,
        history: &DisplacementHistory<3>,
        load: &Drag<3>,
        fluid: &Mass<3>,
        lift: &Freedoms,
    ) -> [Freedoms; 6] {
        let reference = self.reference_by(c, h);
        let BodyParameters { mass, centre, supports, gravity, .. } = &self.parameters;
        let BodyState { now, before, .. } = &self.state;
        let momenta = [now, before].map(|at| self.momentum_of(at));
        let [momentum, angular]: [Vector3<f64>; 2] = from_fn(|i| c[1] * momenta[0][i] + c[2] * momenta[1][i]);
        let (rates, earlier) = (now.rates(), before.rates());
        let known: Freedoms = from_fn(|i| c[1] * rates[i] + c[2] * earlier[i]);
        let (mut end, mut matrix) = (reference, [[0.0; 6]; 6]);
        for _ in 0..ITERATIONS {
            let arm = end.orientation * centre;
            let inertia = self.inertia(&end.orientation);
            let about_pivot = <[f64; 3]>::shifted(inertia, *mass, &arm);
            let own = Mass { mass: *mass, inertia: about_pivot.transpose().into(), arm }.matrix();
            // The backward difference of the momenta less that of the velocities times the mass matrix.
            let needed = join::<3>(&momentum, angular + arm.cross(&momentum));
            let gyroscopic = from_fn(|i| (0..6).map(|j| own[i][j] * known[j]).sum::<f64>() - needed[i]);
            let pull = *mass * gravity;
            let weight = join::<3>(&pull, arm.cross(&pull));
            let step = SpringStep {
                supports,
                history,
                c: *c,
                mass: own,
                gyroscopic,
                fluid: *fluid,
                weight: from_fn(|i| weight[i] + lift[i]),
                predicted: reference.rates(),
            };
            let found = step.solve(load);
            let next = self.moved(c, h, &found.displacement.rates());
            matrix = found.matrix;
            let change = (next.omega - end.omega).norm() * h;
            end = next;
            if change <= ROUNDING {
                break;
            }
        }
        let rates = end.rates();
        let acceleration = from_fn(|i| c[0] * rates[i] - known[i]);
        self.state = BodyState { before: self.state.now, now: end, acceleration, last_step: h };
        matrix
    }

    /// Return the coefficients of the backward differences, `c_0 y_(n+1) − c_1 y_n − c_2 y_(n−1)`, 1/s.
    fn differences(&self, h: f64) -> [f64; 3] {
        let last = self.state.last_step;
        if h > LARGEST_RATIO * last {
            return [1.0 / h, 1.0 / h, 0.0];
        }
        let ratio = h / last;
        let (new, old) = ((1.0 + 2.0 * ratio) / (1.0 + ratio) / h, ratio * ratio / (1.0 + ratio) / h);
        [new, new + old, -old]
    }

    /// Return the place after a step of `h` seconds that ends with the `velocities`.
    fn moved(&self, c: &[f64; 3], h: f64, velocities: &Freedoms) -> Placed {
        let BodyState { now, before, last_step, .. } = &self.state;
        let (velocity, omega) = crate::kinematics::split::<3>(velocities);
        let [ahead, omega_ahead] = self.turned_freely(h);
        let mut deviation = omega - omega_ahead;
        if c[2] != 0.0 {
            let [behind, _] = self.turned_freely(-last_step);
            let behind = UnitQuaternion::from_scaled_axis(behind) * now.orientation;
            deviation += c[2] * (before.orientation * behind.inverse()).scaled_axis();
        }
        let turn = UnitQuaternion::from_scaled_axis(deviation / c[0]) * UnitQuaternion::from_scaled_axis(ahead);
        let mut orientation = turn * now.orientation;
        orientation.renormalize();
        // A free body moves with its centre of mass, or its angular momentum would drift.
        let centre = if self.parameters.supports[..3].iter().all(Option::is_some) {
            self.parameters.centre
        } else {
            Vector3::zeros()
        };
        let [place, place_before] = [now, before].map(|at| at.position + at.orientation * centre);
        let arm = orientation * centre;
        let position = (c[1] * place + c[2] * place_before + velocity + omega.cross(&arm)) / c[0] - arm;
        Placed { position, orientation, velocity, omega }
    }

    /// Return the rotation vector and the angular velocity of the body after `h` seconds without moments, or of one that
    /// is held about an axis and keeps its angular velocity.
    fn turned_freely(&self, h: f64) -> [Vector3<f64>; 2] {
        let now = &self.state.now;
        if self.parameters.supports[3..].iter().any(Option::is_none) {
            return [now.omega * h, now.omega];
        }
        let [inertia, inverse] = &self.turning;
        let momentum = inertia * (now.orientation.inverse() * now.omega);
        let omega = |turn: &Vector3<f64>| {
            let own = now.orientation.inverse() * UnitQuaternion::from_scaled_axis(*turn) * now.orientation;
            now.orientation * own * (inverse * (own.inverse() * momentum))
        };
        // Runge and Kutta, for the rotation vector from the beginning of the step.
        let rate = |turn: &Vector3<f64>| <[f64; 3]>::angle_rate(*turn, omega(turn));
        let first = rate(&Vector3::zeros());
        let second = rate(&(first * (0.5 * h)));
        let third = rate(&(second * (0.5 * h)));
        let fourth = rate(&(third * h));
        let turn = (first + 2.0 * (second + third) + fourth) * (h / 6.0);
        [turn, omega(&turn)]
    }

    /// Return the inertia about the centre of mass in the axes of the domain, kg m².
    fn inertia(&self, orientation: &UnitQuaternion<f64>) -> Matrix3<f64> {
        let turn = orientation.to_rotation_matrix();
        turn * self.parameters.inertia * turn.inverse()
    }

    /// Return momentum, and angular momentum about the centre of mass.
    fn momentum_of(&self, at: &Placed) -> [Vector3<f64>; 2] {
        let velocity = at.velocity + at.omega.cross(&(at.orientation * self.parameters.centre));
        [self.parameters.mass * velocity, self.inertia(&at.orientation) * at.omega]
    }
}
