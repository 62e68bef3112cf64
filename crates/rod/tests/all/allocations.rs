//! A step allocates nothing.

use nervure_rod::{Contact, Law, Obstacle, Parameters, Rod};

use crate::common::{SCHEMES, turek_hron_bar};

#[test]
fn step_allocates_nothing() {
    for scheme in SCHEMES {
        let mut rod = Rod::new(Parameters { scheme, max_step: Some(1e-3), ..turek_hron_bar(5.6e6, 2.0, 42) }).unwrap();
        rod.loads.force = vec![0.0; 2 * 43];
        rod.loads.pressure_jump = vec![100.0; 43];
        for impedance in [5.0, 0.0] {
            rod.loads.impedance = vec![impedance; 43];
            rod.loads.pressure_jump.fill(20.0 * impedance);
            let counted = allocation_counter::measure(|| {
                for _ in 0..3 {
                    rod.step(2e-3).unwrap();
                }
            });
            assert_eq!(counted.count_total, 0, "{scheme:?}");
        }
    }
}

#[test]
fn halved_and_failed_steps_allocate_nothing() {
    let mut rod = Rod::new(turek_hron_bar(5.6e6, 2.0, 42)).unwrap();
    rod.loads.force = vec![1e300; 2 * 43];
    let counted = allocation_counter::measure(|| assert!(rod.step(1e-3).is_err()));
    assert_eq!(counted.count_total, 0);
}

#[test]
fn contact_allocates_nothing() {
    let law = Law { range: 0.02, stiffness: 1e5, depth: 0.01, damping: 1.0, friction: 0.3, film: None };
    let bar = turek_hron_bar(5.6e6, 2.0, 42);
    let [x, y] = bar.attachment;
    let obstacles =
        vec![Obstacle::plane([x, y - 0.025], [0.0, 1.0]), Obstacle::block([x + 0.3, y - 0.08], [0.0; 2], 0.06)];
    let contact = Some(Contact { law, radius: vec![0.01; 43], with_itself: true, obstacles });
    let mut rod = Rod::new(Parameters { contact, ..bar }).unwrap();
    let counted = allocation_counter::measure(|| (0..5).for_each(|_| rod.step(1e-3).unwrap()));
    assert!(rod.contact_forces().iter().any(|force| force[1] > 0.0), "the rod touches");
    assert_eq!(counted.count_total, 0);
}
