//! A communication step that fails leaves the fluid as it was.

use nervure_fluid::{Body, Error, Fluid, Law, Motion, Outline, Parameters, Precision, Shape, Solid, Solvable};
use scene::{Mask, TimeScheme};

use crate::common::{fluid_of, run, scene};
use crate::measures::{BEAM, CYLINDER_IN_CHANNEL};

/// Set the tip's velocity (m/s) at the end of the coming step.
fn set_tip(fluid: &mut Fluid, velocity: f64) {
    let stations = &mut fluid.stations_mut()[0];
    *stations.velocity[1].last_mut().expect("it has stations") = velocity;
}

#[test]
fn a_failed_step_leaves_everything_as_it_was() {
    let h = 2e-3;
    for (scheme, max_step) in
        [(TimeScheme::Sbdf2, 1.0), (TimeScheme::Sbdf2, h / 3.0), (TimeScheme::Rk2, 1.0), (TimeScheme::Rk2, h / 3.0)]
    {
        let mut scene = scene(CYLINDER_IN_CHANNEL, BEAM);
        let fluid = scene.fluid.as_mut().expect("it has one");
        fluid.mask = Mask::Cosine { c_eta: 2e-3, half_width: 1.0, displacement_corrected: true };
        fluid.inflow.as_mut().expect("it has one").c_eta = 2e-3;
        (fluid.time_stepping.scheme, fluid.time_stepping.max_step) = (scheme, max_step);
        let [mut fluid, mut other] = [(); 2].map(|()| fluid_of(&scene));
        for fluid in [&mut fluid, &mut other] {
            run(fluid, 5, h);
            set_tip(fluid, 0.05);
            run(fluid, 1, h);
        }
        let slow = fluid.state();
        let usual = max_step.min(scene.time.communication_step);
        let time_stepping = &scene.fluid.as_ref().expect("it has one").time_stepping;
        let fastest = 100.0 * time_stepping.max_cfl / usual * fluid.grid().spacing[1];
        set_tip(&mut fluid, 1.001 * fastest);
        let result = fluid.advance(fluid.time(), h);
        assert!(matches!(result, Err(Error::FastStation { .. })), "{scheme:?}, {max_step} s: {result:?}");
        assert!(fluid.state() == slow, "{scheme:?}, {max_step} s: the refusal changed the state");
        // A flow near the fastest that there may be is too fast where it goes around the cylinder.
        set_tip(&mut fluid, 0.05);
        let speed = 0.999 * fastest / fluid.grid().spacing[1] * fluid.grid().spacing[0];
        fluid.set_velocity(|[_, _]| [speed, 0.0]);
        let (mut before, mut pressure) = (fluid.state(), fluid.pressure());
        let result = (0..10).find_map(|_| {
            (before, pressure) = (fluid.state(), fluid.pressure());
            fluid.advance(fluid.time(), h).err()
        });
        assert!(matches!(result, Some(Error::Diverged { .. })), "{scheme:?}, {max_step} s: {result:?}");
        assert!(fluid.state() == before, "{scheme:?}, {max_step} s: the state is another");
        assert!(fluid.pressure() == pressure, "{scheme:?}, {max_step} s: the pressure is another");
        // From a flow that goes on, it goes on as ever.
        fluid.restore(&slow).unwrap_or_else(|e| panic!("{e}"));
        for fluid in [&mut fluid, &mut other] {
            set_tip(fluid, 0.04);
            run(fluid, 2, h);
        }
        assert!(fluid.state() == other.state(), "{scheme:?}, {max_step} s: what follows has other bits");
        assert_eq!(fluid.pressure_jump(), other.pressure_jump(), "{scheme:?}, {max_step} s");
    }
}

/// A body that jumps to a speed for which the flow around it is too fast is refused in the only step of a communication
/// step, after the new flow has been found: flow, memory and bodies stay, and a step that is possible goes on from them.
fn a_refused_step_changes_nothing<const D: usize>(shape: impl Shape<D> + Clone + 'static, axis: nervure_fluid::Spin<D>)
where
    [f64; D]: Solvable<D>,
{
    for (precision, threads) in [(Precision::Double, 1), (Precision::Single, 2)] {
        let h = 1e-2;
        let with_jump = |speed: f64| {
            let mut parameters = Parameters::<D>::new([[0.0, 1.0]; D], [48; D], 1.0, 1e-2, h);
            (parameters.precision, parameters.threads) = (precision, threads);
            parameters.initial_velocity[0] = 0.1;
            let mut displacement = [(); D].map(|()| Law::constant(0.0));
            displacement[1] = Law::new(move |t| (0.0, if t < 5.5 * h { 0.2 } else { speed }));
            let motion = Some(Motion::laws(displacement, axis, Law::constant(0.0)));
            parameters.bodies = vec![Body { motion, ..Body::still("the ball", shape.clone(), [0.5; D]) }];
            Fluid::new(&parameters).unwrap_or_else(|e| panic!("{e}"))
        };
        let fastest = 100.0 * 0.4 / h / 48.0;
        let [mut fluid, mut slow] = [2.0 * fastest, 0.2].map(with_jump);
        for step in 0..5 {
            for own in [&mut fluid, &mut slow] {
                own.advance(h * f64::from(step), h).unwrap_or_else(|e| panic!("{e}"));
            }
        }
        let (before, pressure) = (fluid.state(), fluid.pressure());
        let refused = fluid.advance(5.0 * h, h);
        assert!(matches!(refused, Err(Error::Diverged { .. })), "{precision:?}: {refused:?}");
        assert!(fluid.state() == before, "{precision:?}: the state is another");
        assert!(fluid.pressure() == pressure, "{precision:?}: the pressure is another");
        let ahead = slow.advance(5.0 * h, h).map(|()| slow.state());
        slow.restore(&before).unwrap_or_else(|e| panic!("{e}"));
        let again = slow.advance(5.0 * h, h).map(|()| slow.state());
        assert!(
            ahead.is_ok_and(|ahead| again.is_ok_and(|again| again == ahead)),
            "{precision:?}: it goes on otherwise"
        );
    }
}

#[test]
fn a_refused_step_changes_nothing_in_the_plane_and_in_space() {
    a_refused_step_changes_nothing::<2>(Outline::Circle(0.15), 1.0);
    a_refused_step_changes_nothing::<3>(Solid::Sphere(0.15), [0.0, 0.0, 1.0].into());
}
