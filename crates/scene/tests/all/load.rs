//! The choice of the load, and what the coupling needs.

use nervure_scene::{Acceleration, CouplingScheme, Guards, Load, Scene};

/// FSI3 with some of its text replaced.
fn fsi3(replaced: &[(&str, &str)]) -> Result<Scene, String> {
    let mut text = include_str!("../../../../scenes/fsi3-325x72.json").to_string();
    for (old, new) in replaced {
        assert!(text.contains(old), "{old} is not in the scene");
        text = text.replace(old, new);
    }
    Scene::from_json(&text).map_err(|error| error.to_string())
}

const GIVEN: &str = r#""coupling": { "load": "momentum", "scheme": "explicit" }"#;
const OPEN: (&str, &str) = (GIVEN, r#""coupling": {}"#);
const ROD: &str = r#""plane_strain": { "density": 1000.0"#;

#[test]
fn load_follows_from_density_ratio_and_step() {
    let light = (ROD, r#""plane_strain": { "density": 999.0"#);
    let long = (r#""communication_step": 4e-4"#, r#""communication_step": 5e-4"#);
    let rk2 = (r#""max_step": 4e-4"#, r#""max_step": 4e-4, "scheme": "rk2""#);
    for (replaced, load, reason) in [
        (vec![], Load::Momentum, "the scene says so"),
        (vec![OPEN], Load::Momentum, "weighs 1.0000 of the fluid"),
        (vec![OPEN, light], Load::PressureJump, "weighs 0.9990 of the fluid"),
        (vec![OPEN, long], Load::PressureJump, "the step of 0.0005 s is above 0.0004 s"),
        (vec![OPEN, rk2], Load::PressureJump, "the step of 0.0004 s is above 0.000001 s"),
    ] {
        let (found, why) = fsi3(&replaced).unwrap().chosen_load().unwrap();
        assert_eq!(found, load, "{replaced:?}: {why}");
        assert!(why.contains(reason), "{why}");
    }
}

#[test]
fn coupling_may_be_left_out_altogether() {
    let scene = fsi3(&[(&format!(",\n  {GIVEN}"), "")]).unwrap();
    let (beam, rod) = (scene.beam.as_ref().unwrap(), scene.rod.as_ref().unwrap());
    assert_eq!((scene.load(), scene.displaced_line_density(beam, rod)[0]), (Some(Load::Momentum), 20.0));
}

#[test]
fn momentum_load_on_a_light_rod_is_refused() {
    let error = fsi3(&[(ROD, r#""plane_strain": { "density": 990.0"#)]).unwrap_err();
    assert!(error.contains("`coupling.load` is momentum") && error.contains("weighs 0.9900"), "{error}");
}

#[test]
fn level_of_the_pressure_needs_what_it_is_made_of() {
    let (given, wanted) = (GIVEN, r#""coupling": { "axial_pressure_strain": true }"#);
    assert_eq!(fsi3(&[]).unwrap().strain_per_pressure(), None);
    let strain = fsi3(&[(given, wanted)]).unwrap().strain_per_pressure().unwrap();
    assert!((strain / (1.4 * 0.2 / 5.6e6) - 1.0).abs() < 1e-14, "{strain}");
    let section = r#""section": { "line_density": 20.0, "bending_stiffness": 4.0, "axial_stiffness": 1e5 }"#;
    let rest = r#", "youngs_modulus": 5.6e6, "poisson_ratio": 0.4, "shear_factor": 0.862 }"#;
    let material = &format!("{ROD}{rest}");
    for (replaced, reason) in [
        (vec![(given, wanted), (ROD, r#""plane_strain": { "density": 900.0"#)], "it needs the load momentum"),
        (vec![(given, wanted), (material, section)], "it needs a material in plane_strain"),
        (vec![(given, wanted), (r#""inflow": {"#, r#""sponge": {"#)], "it needs an inflow"),
    ] {
        let error = fsi3(&replaced).unwrap_err();
        assert!(error.contains("`coupling.axial_pressure_strain` is true") && error.contains(reason), "{error}");
    }
}

#[test]
fn guards_have_defaults_and_each_can_be_off() {
    let guards = |text: &str| {
        let coupling = format!(r#""coupling": {{ "load": "momentum", "guards": {text} }}"#);
        fsi3(&[(GIVEN, &coupling)]).map(|scene| scene.coupling.unwrap().guards.unwrap())
    };
    let whole = Guards { window_steps: 500, largest_imbalance: Some(0.5), largest_noise: Some(1.5), min_power: 1e-9 };
    assert_eq!(guards("{}").unwrap(), whole);
    let off = guards(r#"{ "largest_imbalance": null }"#).unwrap();
    assert_eq!(off, Guards { largest_imbalance: None, ..whole });
    for (wrong, expected) in [
        (r#"{ "window_steps": 0 }"#, "`coupling.guards.window_steps` is out of range: 0 is not from 1 to 4294967295"),
        (r#"{ "largest_imbalance": 0.0 }"#, "`coupling.guards.largest_imbalance` is out of range: 0.0 is not > 0"),
        (r#"{ "largest_noise": -1.5 }"#, "`coupling.guards.largest_noise` is out of range: -1.5 is not > 0"),
        (r#"{ "min_power": -1e-9 }"#, "`coupling.guards.min_power` is out of range: -1e-9 is not >= 0"),
    ] {
        let refused = guards(wrong).unwrap_err();
        assert!(refused.contains(expected), "{refused}, but expected {expected}");
    }
}

#[test]
fn iteration_has_defaults() {
    let iterated = (GIVEN, r#""coupling": { "load": "pressure_jump", "scheme": { "iterated": {} } }"#);
    let acceleration = Acceleration::IqnIls;
    let expected = CouplingScheme::Iterated { tolerance: 1e-4, max_iterations: 50, acceleration };
    assert_eq!(fsi3(&[iterated]).unwrap().coupling.unwrap().scheme, Some(expected));
}

/// A line takes a layer of 1.5 cells of fluid along, of which a light rod accounts for no more than its own mass.
#[test]
fn rod_on_a_line_accounts_for_the_layer_that_moves_with_it() {
    let on_line = |density: &str, given: &str| {
        let light = format!(r#""plane_strain": {{ "density": {density}"#);
        fsi3(&[(ROD, &light), (r#""thickness": 0.02"#, r#""thickness": 0.02, "surface": "line""#), (GIVEN, given)])
    };
    for density in [1000.0, 0.001] {
        let scene = on_line(&density.to_string(), GIVEN).unwrap();
        let (beam, rod, fluid) =
            (scene.beam.as_ref().unwrap(), scene.rod.as_ref().unwrap(), scene.fluid.as_ref().unwrap());
        let ([low, high], cells) = (fluid.r#box.x, fluid.r#box.cells[0]);
        let layer = fluid.density * nervure_scene::LINE_THICKNESS_CELLS * (high - low) / cells as f64;
        let found = scene.displaced_line_density(beam, rod)[0];
        assert!((found - layer.min(density * 0.02)).abs() < 1e-12 * layer, "{density}: {found}");
        assert_eq!(scene.load(), Some(Load::Momentum));
    }
}
