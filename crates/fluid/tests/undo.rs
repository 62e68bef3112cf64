//! A communication step that fails leaves the fluid as it was.

mod common;
#[path = "common/measures.rs"]
#[allow(dead_code, reason = "only its scenes are wanted")]
mod measures;

use common::{fluid_of, run, scene};
use measures::{BEAM, CYLINDER_IN_CHANNEL};
use nervure_fluid::{Error, Fluid};
use scene::{Mask, TimeScheme};

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
        fluid.set_velocity(|_, _| [speed, 0.0]);
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
