//! The flow in three dimensions: exact solutions, invariants, symmetries, and the agreement with two dimensions.

use std::f64::consts::TAU;

use nervure_fluid::{Error, Filter, Law, Precision};

type Fluid = nervure_fluid::Fluid<3>;
type Parameters = nervure_fluid::Parameters<3>;

fn parameters(cells: [usize; 3], nu: f64) -> Parameters {
    let mut parameters = Parameters::new([[0.0, TAU]; 3], cells, 2.0, nu, 0.1);
    parameters.max_cfl = 2.0;
    parameters
}

fn made(parameters: &Parameters, velocity: impl Fn([f64; 3]) -> [f64; 3]) -> Fluid {
    let mut fluid = Fluid::new(parameters).unwrap_or_else(|e| panic!("{e}"));
    fluid.set_velocity(velocity);
    fluid
}

/// Make steps of lengths in turn (s).
fn run(fluid: &mut Fluid, steps: usize, lengths: &[f64]) {
    for step in 0..steps {
        let t = fluid.time();
        fluid.advance(t, lengths[step % lengths.len()]).unwrap_or_else(|e| panic!("step {step}: {e}"));
    }
}

/// Waves along many directions, without a symmetry.
fn waves([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        (y + 2.0 * z).sin() + 0.3 * (x - 3.0 * y).cos(),
        0.7 * (z - x).cos() - 0.4 * (2.0 * x + y + z).sin(),
        0.5 * (x + y).sin() + 0.2 * (3.0 * y - z).cos(),
    ]
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Largest error of a flow of Arnold, Beltrami and Childress, whose vorticity is its velocity: it decays as exp(−nu t)
/// in a frame that moves with a mean flow, over a time of 1 s in unequal steps.
fn beltrami_error(steps: usize) -> f64 {
    let (nu, mean) = (0.3, [0.9, -0.5, 0.7]);
    let abc = |[x, y, z]: [f64; 3]| [z.sin() + 0.6 * y.cos(), 0.8 * x.sin() + z.cos(), 0.6 * y.sin() + 0.8 * x.cos()];
    let exact = |t: f64, point: [f64; 3]| {
        let moved = [0, 1, 2].map(|a| point[a] - mean[a] * t);
        let flow = abc(moved);
        [0, 1, 2].map(|a| mean[a] + (-nu * t).exp() * flow[a])
    };
    let mut parameters = parameters([12, 16, 20], nu);
    parameters.initial_velocity = mean;
    parameters.mean_flow = Some(mean.map(Law::constant));
    let mut fluid = made(&parameters, |point| exact(0.0, point));
    let unit = 1.0 / steps as f64;
    run(&mut fluid, steps, &[0.5 * unit, 0.5 * unit, 2.0 * unit]);
    let velocity = [0, 1, 2].map(|axis| fluid.velocity(axis));
    let error = |index: usize| {
        let expected = exact(fluid.time(), fluid.grid().point(index));
        (0..3).map(|a| (velocity[a][index] - expected[a]).abs()).fold(0.0, f64::max)
    };
    (0..fluid.grid().len()).map(error).fold(0.0, f64::max)
}

#[test]
fn a_beltrami_flow_decays_and_moves_with_second_order_in_time() {
    let [coarse, fine] = [60, 120].map(beltrami_error);
    let order = (coarse / fine).log2();
    assert!(fine < 5e-4, "error {fine} with 120 steps");
    assert!((order - 2.0).abs() < 0.1, "order {order}: errors {coarse} and {fine}");
}

/// With the x axis of one flow as the y axis of the next and so on, a flow without a symmetry does the same. With a sign
/// or a component of a cross product that is wrong along one axis it would not.
#[test]
fn axes_are_treated_alike() {
    let shape = [16, 18, 20];
    let flows = [0, 1, 2].map(|turn| {
        let axis = |own: usize| (own + turn) % 3;
        let mut cells = [0; 3];
        (0..3).for_each(|own| cells[axis(own)] = shape[own]);
        let mut fluid = made(&parameters(cells, 0.02), |point| {
            let own = waves([0, 1, 2].map(|own| point[axis(own)]));
            let mut velocity = [0.0; 3];
            (0..3).for_each(|of| velocity[axis(of)] = own[of]);
            velocity
        });
        run(&mut fluid, 10, &[0.02]);
        // The components and points of the first flow, in its order.
        let index = |c: usize| {
            let own = [c / (shape[1] * shape[2]), c / shape[2] % shape[1], c % shape[2]];
            let mut place = [0; 3];
            (0..3).for_each(|of| place[axis(of)] = own[of]);
            (place[0] * cells[1] + place[1]) * cells[2] + place[2]
        };
        let pressure = fluid.pressure();
        let mut values: Vec<f64> = (0..pressure.len()).map(|c| pressure[index(c)]).collect();
        for of in 0..3 {
            let (velocity, vorticity) = (fluid.velocity(axis(of)), fluid.vorticity(axis(of)));
            values.extend((0..pressure.len()).flat_map(|c| [velocity[index(c)], vorticity[index(c)]]));
        }
        values
    });
    for turn in [1, 2] {
        let difference = largest_difference(&flows[0], &flows[turn]);
        assert!(difference < 1e-12, "turned {turn} times: {difference}");
    }
}

/// A flow of two dimensions, extruded along z, is the flow of the other solver, with its pressure and vorticity.
#[test]
fn a_flow_without_z_is_that_of_two_dimensions() {
    let plane = |x: f64, y: f64| [(x + 2.0 * y).sin() + 0.4, (2.0 * x - y).cos() + 0.5 * (3.0 * x).sin()];
    let [nx, ny, nz] = [24, 20, 8];
    for filter in [Filter::TwoThirds, Filter::None] {
        let mut space = parameters([nx, ny, nz], 0.02);
        space.filter = filter;
        let mut two = nervure_fluid::Parameters::new([[0.0, TAU]; 2], [nx, ny], 2.0, 0.02, 0.1);
        (two.filter, two.max_cfl) = (filter, 2.0);
        let mut space = made(&space, |[x, y, _]| [plane(x, y)[0], plane(x, y)[1], 0.0]);
        let mut flat = nervure_fluid::Fluid::new(&two).unwrap_or_else(|e| panic!("{e}"));
        flat.set_velocity(|[x, y]| plane(x, y));
        for (step, h) in [0.02, 0.01, 0.02, 0.03, 0.02, 0.02].into_iter().enumerate() {
            let t = flat.time();
            flat.advance(t, h).and_then(|()| space.advance(t, h)).unwrap_or_else(|e| panic!("{step}: {e}"));
        }
        let extruded = |field: &[f64]| field.iter().flat_map(|value| [*value; 8]).collect::<Vec<_>>();
        let fields = [
            (flat.velocity(0), space.velocity(0)),
            (flat.velocity(1), space.velocity(1)),
            (flat.vorticity(0), space.vorticity(2)),
        ];
        for (k, (flat, space)) in fields.iter().enumerate() {
            let difference = largest_difference(&extruded(flat), space);
            assert!(difference < 1e-12, "{filter:?}, field {k}: {difference}");
        }
        let difference = largest_difference(&extruded(&flat.pressure()), &space.pressure());
        assert!(difference < 1e-10, "{filter:?}, pressure: {difference}");
        let [energy, expected] = [space.kinetic_energy(), TAU * flat.kinetic_energy()];
        assert!((energy / expected - 1.0).abs() < 1e-12, "{energy} J against {expected}");
    }
}

/// Advection keeps the energy; viscosity takes 2 nu times the enstrophy, and the density.
#[test]
fn energy_falls_by_the_enstrophy() {
    let vortex = |[x, y, z]: [f64; 3]| [x.sin() * y.cos() * z.cos(), -x.cos() * y.sin() * z.cos(), 0.0];
    let mut parameters = parameters([16; 3], 0.01);
    parameters.filter = Filter::TwoThirds;
    let (mut fluid, h) = (made(&parameters, vortex), 0.02);
    // One of eight cells of the vortex has the mean square 1/8 of each component.
    let energy = 0.5 * 2.0 * 0.25 * TAU.powi(3);
    assert!((fluid.kinetic_energy() / energy - 1.0).abs() < 1e-12, "{} J", fluid.kinetic_energy());
    let mut rates = vec![fluid.enstrophy()];
    for _ in 0..60 {
        run(&mut fluid, 1, &[h]);
        rates.push(fluid.enstrophy());
    }
    assert!(rates[60] > 1.05 * rates[0], "vortices are stretched: {} then {}", rates[0], rates[60]);
    let work = h * (rates.iter().sum::<f64>() - 0.5 * (rates[0] + rates[60])) * 2.0 * 2.0 * 0.01;
    let lost = energy - fluid.kinetic_energy();
    assert!((lost / work - 1.0).abs() < 2e-3, "{lost} J lost, {work} J by viscosity");
    // The vortex keeps its mirror symmetries.
    let (u, w) = (fluid.velocity(0), fluid.velocity(2));
    let mirrored = |c: usize| c / 16 * 16 + (16 - c % 16) % 16;
    let uneven = (0..u.len()).map(|c| (u[c] - u[mirrored(c)]).abs().max((w[c] + w[mirrored(c)]).abs()));
    let uneven = uneven.fold(0.0, f64::max);
    assert!(uneven < 1e-13, "{uneven} m/s");
    assert!(fluid.divergence() < 1e-13, "{}", fluid.divergence());
}

#[test]
fn threads_and_states_have_the_same_bits() {
    for precision in [Precision::Double, Precision::Single] {
        let mut one = parameters([45, 48, 50], 0.02);
        one.precision = precision;
        let mut three = one.clone();
        three.threads = 3;
        let mut fluids = [&one, &three].map(|parameters| made(parameters, waves));
        fluids.iter_mut().for_each(|fluid| run(fluid, 2, &[0.02]));
        let state = fluids[0].state();
        assert!(state == fluids[1].state(), "{precision:?}: three threads have other bits");
        run(&mut fluids[0], 1, &[0.03]);
        let mut other = Fluid::new(&one).unwrap_or_else(|e| panic!("{e}"));
        other.restore(&state).unwrap_or_else(|e| panic!("{e}"));
        run(&mut other, 1, &[0.03]);
        assert!(other.state() == fluids[0].state(), "{precision:?}: the restored state has other bits");
    }
}

#[test]
fn single_precision_is_as_exact_as_seven_digits() {
    let fluids = [Precision::Double, Precision::Single].map(|precision| {
        let mut parameters = parameters([16; 3], 0.02);
        parameters.precision = precision;
        let mut fluid = made(&parameters, waves);
        run(&mut fluid, 20, &[0.02]);
        fluid
    });
    let [double, single] = fluids.each_ref().map(|fluid| fluid.velocity(1));
    let difference = largest_difference(&double, &single);
    assert!(difference < 5e-6 && difference > 0.0, "{difference} m/s");
    let error = fluids[1].state();
    let [mut double, _] = fluids;
    assert!(matches!(double.restore(&error), Err(Error::Precision { .. })));
}

/// A flow that becomes too fast within several steps of the fluid's own leaves everything as it was.
#[test]
fn a_flow_that_diverges_is_undone() {
    let mut parameters = parameters([16; 3], 1e-6);
    (parameters.max_step, parameters.max_cfl) = (0.05, 40.0);
    let mut fluid = made(&parameters, |point| waves(point).map(|u| 40.0 * u));
    let state = fluid.state();
    let error = fluid.advance(0.0, 5.0).expect_err("CFL numbers of 20 are unstable");
    assert!(matches!(error, Error::Diverged { .. }), "{error}");
    assert!(fluid.state() == state, "the state has changed");
    assert!(fluid.advance(0.0, 1e9).is_err());
}

#[test]
fn parameters_without_a_step_are_refused() {
    let good = parameters([16; 3], 0.1);
    let refused = |change: &dyn Fn(&mut Parameters)| {
        let mut parameters = good.clone();
        change(&mut parameters);
        Fluid::new(&parameters).err().map(|e| e.to_string()).unwrap_or_default()
    };
    assert!(refused(&|p| p.cells[1] = 7).contains("number of cells along y is 7"));
    assert!(refused(&|p| p.domain[2][1] = 0.0).contains("width of the domain along z is 0"));
    assert!(refused(&|p| p.kinematic_viscosity = f64::NAN).contains("kinematic viscosity is NaN"));
}

/// Each component of a disturbed start is a wave along the next axis beside the uniform velocity: there is no divergence
/// and no mean. The box of unequal cells has their flow rate, energy and enstrophy.
#[test]
fn a_disturbance_is_a_wave_of_each_component_along_the_next_axis() {
    let ends = [[-0.5, 1.0], [0.25, 1.25], [0.0, 2.0]];
    let mut parameters = Parameters::new(ends, [12, 16, 20], 1.0, 0.01, 0.01);
    (parameters.initial_velocity, parameters.disturbance) = ([0.7, -0.2, 0.4], Some(0.05));
    let mut fluid = Fluid::new(&parameters).unwrap_or_else(|e| panic!("{e}"));
    for axis in 0..3 {
        let next = (axis + 1) % 3;
        let [low, high] = ends[next];
        for (index, u) in fluid.velocity(axis).iter().enumerate() {
            let wave = 0.05 * (TAU * (fluid.grid().point(index)[next] - low) / (high - low)).sin();
            let expected = parameters.initial_velocity[axis] + wave;
            assert!((u - expected).abs() < 1e-14, "{axis}, {index}: {u} against {expected}");
        }
    }
    assert!(fluid.divergence() < 1e-13, "{}", fluid.divergence());
    let (u, waves) = (parameters.initial_velocity, 3.0 * 0.5 * 0.05_f64.powi(2));
    // Waves of the lengths 1, 2 and 1.5 m.
    let curl = [1.0, 2.0, 1.5].map(|length: f64| 0.5 * (0.05 * TAU / length).powi(2)).iter().sum::<f64>();
    for (what, found, expected) in [
        ("flow rate", fluid.flow_rate(), u[0] * 1.0 * 2.0),
        ("energy", fluid.kinetic_energy(), 0.5 * 1.0 * 3.0 * (u.iter().map(|u| u * u).sum::<f64>() + waves)),
        ("enstrophy", fluid.enstrophy(), 0.5 * 3.0 * curl),
    ] {
        assert!((found / expected - 1.0).abs() < 1e-12, "the {what} is {found}, not {expected}");
    }
}
