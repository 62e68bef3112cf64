//! The scene of one rod's unit among several.

use crate::scene::Scene;

impl Scene {
    /// Return the scene as the unit of a rod sees it: of several rods the one called `this_rod` as the only one, with
    /// the load that was chosen for all. None where `this_rod` does not name one.
    pub fn of_unit(&self) -> Option<Self> {
        if self.rods.is_empty() {
            return Some(self.clone());
        }
        let name = self.this_rod.as_ref()?;
        let own = self.rods.iter().find(|own| own.name == *name)?.clone();
        let mut coupling = self.coupling.clone().unwrap_or_default();
        coupling.load = self.load();
        Some(Self {
            name: format!("{}.{name}", self.name),
            beam: Some(own.beam),
            rod: Some(own.rod),
            rods: Vec::new(),
            this_rod: None,
            coupling: Some(coupling),
            reference: None,
            ..self.clone()
        })
    }
}
