//! A free body that carries a wing at a driven hinge, without a fluid.

use method::Support;
use nalgebra::{Matrix3, Matrix6, UnitQuaternion, Vector3};
use nervure_wing::{Membrane, Parameters, RigidMotion, Root, Scheme, Wing, rectangle};
use rigid::{Body, BodyParameters, FluidLoad, Flyer, Freedoms, HingeTurn, Placed, RootResponse};

type Vector = Vector3<f64>;

const FREE: Option<Support> = Some(Support { stiffness: 0.0, damping: 0.0, rest: 0.0 });

/// A body with a wing at its hinge.
struct Flight {
    flyer: Flyer,
    wing: Wing,
    h: f64,
}

/// Return the wing's motion for a root at a place.
fn motion(root: &Placed) -> RigidMotion {
    let rotation = root.orientation.to_rotation_matrix();
    RigidMotion {
        displacement: root.position.into(),
        velocity: root.velocity.into(),
        rotation: std::array::from_fn(|i| std::array::from_fn(|j| rotation[(i, j)])),
        angular_velocity: root.omega.into(),
    }
}

impl Flight {
    /// A wing of mass 1 on a body whose mass is `ratio` times that, with the membrane's modulus.
    fn new(ratio: f64, youngs_modulus: f64, h: f64) -> Self {
        let mesh = rectangle(0.2, 0.1, 3);
        let nodes = mesh.chain("root").expect("a root").to_vec();
        let mut wing = Parameters {
            root: Root { nodes, ..Root::default() },
            scheme: Scheme::Bdf2,
            relaxation_time: 1e-4,
            ..Parameters::new(mesh, Membrane::plate(youngs_modulus, 0.3, 0.02, 2500.0))
        }
        .build()
        .expect("a wing");
        wing.carry();
        let body = Body::new(BodyParameters {
            mass: ratio,
            inertia: Matrix3::from_diagonal(&Vector::new(1.0, 1.4, 1.9)) * (ratio * 1e-2),
            centre: Vector::new(0.01, 0.02, -0.01),
            supports: [FREE; 6],
            gravity: Vector::zeros(),
            position: Vector::zeros(),
        });
        Self { flyer: Flyer::new(body, vec![Vector::new(0.05, 0.0, 0.02)]), wing, h }
    }

    /// Make the step that ends with the hinge turned by `angle` at a rate about x and y alike.
    fn step(&mut self, (angle, rate): (f64, f64)) {
        let about = Vector::new(0.6, 0.8, 0.0);
        let hinge = HingeTurn { turn: UnitQuaternion::from_scaled_axis(about * angle), rate: about * rate };
        let reference = self.flyer.body().reference(self.h);
        self.wing.base_motion = Some(motion(&self.flyer.root(0, &reference, &hinge)));
        let response = self.wing.root_response(self.h).expect("a response");
        let drive = self.wing.state().drive;
        let reaction: Freedoms = std::array::from_fn(|i| if i < 3 { -drive.force[i] } else { -drive.moment[i - 3] });
        self.flyer.step(self.h, &[response], &[reaction], &FluidLoad::default());
        self.wing.base_motion = Some(motion(&self.flyer.root(0, &self.flyer.body().state.now, &hinge)));
        self.wing.step(self.h).expect("a step");
    }

    /// Return momentum and angular momentum of both.
    fn momentum(&mut self) -> [Vector; 2] {
        let of_wing = self.wing.momentum().map(Vector::from);
        let of_body = self.flyer.body().momentum();
        [of_body[0] + of_wing[0], of_body[1] + of_wing[1]]
    }

    fn start(&mut self) {
        let still = HingeTurn { turn: UnitQuaternion::identity(), rate: Vector::zeros() };
        let root = self.flyer.root(0, &self.flyer.body().state.now, &still);
        self.wing.place(motion(&root)).expect("a pose");
    }
}

/// A stroke of one second that begins and ends at rest.
fn stroke(t: f64) -> (f64, f64) {
    use std::f64::consts::PI;
    if t >= 1.0 {
        return (0.0, 0.0);
    }
    let (sin, cos) = (PI * t).sin_cos();
    (1.2 * sin.powi(4), 4.8 * PI * sin.powi(3) * cos)
}

/// Of all that a step assumes of the wing, the defect alone has not reached the body yet; by backward differences,
/// `(3 P − P_before)/2 + (defect + defect_1/2) h` is the momentum. Newton's method leaves a billionth of the largest force.
#[test]
fn a_body_and_its_wing_keep_their_momentum() {
    for ratio in [0.1, 1.0, 10.0] {
        let h = 2.5e-3;
        let mut flight = Flight::new(ratio, 1.25e5, h);
        flight.start();
        let (mut most, mut largest, mut lost, mut first) = (0.0_f64, 0.0_f64, 0.0_f64, Vector::zeros());
        let mut before = Vector::zeros();
        for step in 1..=600 {
            flight.step(stroke(f64::from(step) * h));
            let [now, angular] = flight.momentum();
            // The wing has the mass 1.
            let of_wing = flight.wing.state().velocities.iter().map(|v| v.norm()).fold(0.0, f64::max);
            let assumed = flight.flyer.state().assumed;
            let defect = -flight.wing.state().drive.force - Vector::new(assumed[0], assumed[1], assumed[2]);
            if step == 1 {
                first = defect;
            } else {
                lost = lost.max((1.5 * now - 0.5 * before + h * (defect + 0.5 * first)).norm());
            }
            before = now;
            // Angular momentum by the length of the wing.
            (most, largest) = (most.max(of_wing), largest.max(now.norm()).max(angular.norm() / 0.2));
        }
        println!("M/m = {ratio}: {lost:e} kg m/s of {most}; {largest:e} on the way");
        assert!(lost < 1e-9 * most, "M/m = {ratio}: {lost:e} kg m/s of {most}");
        assert!(largest < 3e-3 * most, "M/m = {ratio}: on the way {largest:e} kg m/s of {most}");
    }
}

/// A free wing and body gain no energy at any ratio of their masses, whether the wing is soft or stiff and however heavy
/// the fluid is that an impedance stands for.
#[test]
fn a_body_and_its_wing_are_stable_at_every_ratio_of_masses() {
    for modulus in [1e3, 1e5, 1e11] {
        for ratio in [1e-3, 1e-2, 1.0, 1e2] {
            for fluid in [0.0, 1.0, 1e3] {
                let mut flight = Flight::new(ratio, modulus, 1e-2);
                let nodes = flight.wing.nodes();
                let mass = fluid / nodes as f64;
                flight.wing.loads.impedance = vec![mass / flight.h; nodes];
                let small = |k: usize| 1e-6 * ((k * 37 % 11) as f64 - 5.0);
                flight.start();
                let kick: Vec<_> = (0..nodes).map(|k| [small(k), small(k + 3), small(k + 5)]).collect();
                flight.wing.set_velocities(&kick).expect("velocities");
                let mut energy = || {
                    let of_fluid = flight.wing.state().velocities.iter().map(|v| 0.5 * mass * v.norm_squared());
                    let energy = of_fluid.sum::<f64>() + flight.flyer.body().energy()[0];
                    let energy = energy + flight.wing.energy().expect("an energy").total();
                    flight.step((0.0, 0.0));
                    energy
                };
                let energies: Vec<_> = (0..200).map(|_| energy()).collect();
                let most = energies[1..].iter().copied().fold(0.0, f64::max);
                let case = format!("E = {modulus:e} Pa, M/m = {ratio}, fluid {fluid} m");
                assert!(most <= energies[0], "{case}: {:e} J, then {most:e}", energies[0]);
            }
        }
    }
}

#[test]
fn the_impedance_at_a_hinge_is_positive() {
    let mut flight = Flight::new(1.0, 1e5, 1e-2);
    flight.start();
    flight.step((0.1, 1.0));
    let RootResponse { impedance, .. } = flight.wing.root_response(flight.h).expect("a response");
    let eigenvalues = Matrix6::from_fn(|i, j| impedance[i][j]).symmetric_eigenvalues();
    assert!(eigenvalues.min() > 0.0, "{eigenvalues:?}");
}
