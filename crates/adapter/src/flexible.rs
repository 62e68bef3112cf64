//! What the rods and wings of a scene are called by what couples them.

use scene::Scene;

/// What a rod or a wing is called.
pub struct FlexibleNames {
    /// In outputs, e.g. `beam[2]`.
    pub name: String,
    /// In texts, e.g. `beam 2`.
    pub text: String,
    /// In front of the variables of its stations.
    pub prefix: String,
    /// The stations in texts.
    pub stations: &'static str,
    /// The point of the moments in texts.
    pub centre: &'static str,
}

impl FlexibleNames {
    /// Return the names of flexible body number `k`: one beam has the names without a number.
    pub fn of(scene: &Scene, k: usize) -> Self {
        let beams = scene.beams().count();
        let number = k + 1;
        let (name, text, prefix, stations, centre) = if k >= beams {
            let of = k + 1 - beams;
            let (name, text) = match scene.wings.is_empty() {
                true => ("wing".to_string(), "the wing".to_string()),
                false => (format!("wing[{of}]"), format!("wing {of}")),
            };
            let prefix = format!("{name}.");
            (name, text, prefix, "nodes", "the pivot of the wing")
        } else if beams == 1 {
            ("beam".into(), "the beam".into(), String::new(), "stations", "its root")
        } else {
            (format!("beam[{number}]"), format!("beam {number}"), format!("beam[{number}]."), "stations", "its root")
        };
        Self { name, text, prefix, stations, centre }
    }
}

/// Return the unit of a quantity in so many dimensions, in the plane per metre of depth.
pub fn per_depth(dimensions: usize, unit: &'static str) -> &'static str {
    match (dimensions, unit) {
        (2, "N") => "N/m",
        (2, "N.m") => "N.m/m",
        (2, "W") => "W/m",
        (2, "J") => "J/m",
        (2, "kg/s") => "kg/(m.s)",
        (2, "m3/s") => "m2/s",
        (2, "m3/s2") => "m2/s2",
        _ => unit,
    }
}
