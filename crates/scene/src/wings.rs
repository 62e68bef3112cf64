//! One of several wings, a unit of its own.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::{Check, Faults};
use crate::rods::check_name;
use crate::scene::Scene;
use crate::wing::Wing;

/// One of several wings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NamedWing {
    /// Name of the unit, at most 40 characters: a letter, then letters, digits and `_`; not that of another unit.
    #[schemars(regex(pattern = crate::rods::NAME))]
    pub name: String,
    /// The wing.
    pub wing: Wing,
}

/// A wing of a scene.
#[derive(Clone, Debug)]
pub struct WingOfScene<'a> {
    /// Name of its unit: `wing`, or that among `wings`.
    pub name: &'a str,
    /// Number among `wings`, from 1; none for the only wing.
    pub number: Option<usize>,
    /// Key of the wing.
    pub key: String,
    /// The wing.
    pub wing: &'a Wing,
}

impl WingOfScene<'_> {
    /// Return the name of the fluid's forces on the wing: `wing`, or `wing_1` and so on.
    pub fn force_name(&self) -> String {
        self.number.map_or("wing".into(), |number| format!("wing_{number}"))
    }
}

impl Scene {
    /// Return the wings in the order in which the fluid counts them: `wing`, or those of `wings`.
    pub fn wings(&self) -> impl Iterator<Item = WingOfScene<'_>> {
        let only = self.wing.iter().map(|wing| WingOfScene { name: "wing", number: None, key: "wing".into(), wing });
        let several = (1..).zip(&self.wings).map(|(number, NamedWing { name, wing })| WingOfScene {
            name,
            number: Some(number),
            key: format!("wings[{}].wing", number - 1),
            wing,
        });
        only.chain(several)
    }

    /// Return the wing of the unit that carries this scene: `wing`, or that of `wings` which `this_wing` names.
    pub fn wing_of_unit(&self) -> Option<WingOfScene<'_>> {
        self.wings().find(|own| own.number.is_none() || self.this_wing.as_deref() == Some(own.name))
    }

    /// Return the nodes of a wing at rest, m: those of its mesh, or where the hinge of a flyer has them at the start.
    pub fn wing_nodes(&self, own: &WingOfScene) -> Vec<[f64; 3]> {
        let mut nodes = own.wing.mesh.build().nodes;
        if let Some(hinge) = self.hinge_of(own.name) {
            let place = self.place_of(hinge);
            for node in &mut nodes {
                let arm = hinge.at_start(std::array::from_fn(|d| node[d] - own.wing.pivot[d]));
                *node = std::array::from_fn(|d| place[d] + arm[d]);
            }
        }
        nodes
    }
}

impl Check for NamedWing {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        check_name(&self.name, &format!("{key}.name"), &["rod", "wing", "body", "fluid"], faults);
    }
}
