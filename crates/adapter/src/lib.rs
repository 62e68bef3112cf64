//! What the units of rod, wing, body and fluid share: the scene in their resources, the texts of their descriptions, the
//! choice between plane and space, names, what they touch, and what they announce to a body that carries them.

mod announced;
mod dimensions;
mod flexible;
mod obstacles;

use fmi_export::{Description, Resources, Variable};
use scene::Scene;

pub use crate::announced::{Announced, Carried, UNKNOWN, response};
pub use crate::dimensions::Dimensions;
pub use crate::flexible::{FlexibleNames, per_depth};
pub use crate::obstacles::{obstacles, obstacles_in_space, solid_of};

pub use scene::AXES;
#[doc(hidden)]
pub use {fmi_export, scene};

/// Resources of a unit.
pub const RESOURCES: &[&str] = &["scene.json"];

/// Return the scene of a unit.
///
/// # Errors
/// The resource may be no scene.
pub fn scene_of(resources: &Resources) -> Result<Scene, String> {
    Scene::from_json(resources.text(RESOURCES[0])?).map_err(|e| e.to_string())
}

/// Return the step from `t` of `h` seconds in words.
pub fn span(t: f64, h: f64) -> String {
    format!("in the step from t = {t:?} s to {:?} s", t + h)
}

/// Return the description of a unit of a scene.
pub fn description(scene: &Scene, model_name: String, text: impl Into<String>) -> Description {
    Description {
        model_name,
        text: text.into(),
        author: "The nervure developers".into(),
        copyright: "Copyright (c) 2026 The nervure developers".into(),
        license: env!("CARGO_PKG_LICENSE").into(),
        stop: scene.time.end,
        step: scene.time.communication_step,
        ..Description::default()
    }
}

/// Return a variable for each axis of a number of dimensions, made from its number and name.
pub fn along_axes<M>(
    dimensions: usize,
    make: impl Fn(usize, &str) -> Variable<M>,
) -> impl Iterator<Item = Variable<M>> {
    AXES[..dimensions].iter().enumerate().map(move |(d, axis)| make(d, axis))
}

/// Export a unit as an FMU that also answers questions about scenes.
#[macro_export]
macro_rules! export_unit {
    ($unit:ty) => {
        $crate::fmi_export::export_fmu!($unit);
        $crate::fmi_export::export_text!(fmu_scene_check = $crate::scene::check_text);
        $crate::fmi_export::export_text!(fmu_scene_facts = |text, _| $crate::scene::facts_text(text));
        $crate::fmi_export::export_text!(fmu_scene_monitor = $crate::scene::monitor_text);
    };
}
