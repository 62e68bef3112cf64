//! Several rods in one fluid, each a unit of its own.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::require;
use crate::{Beam, Rod, Scene, SceneError};

/// One of several rods in a fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NamedRod {
    /// Name of its unit, of at most 40 characters: a letter, then letters, digits and `_`; not `rod` or `fluid`.
    #[schemars(regex(pattern = NAME))]
    pub name: String,
    /// Geometry of the beam that the fluid sees and the rod moves.
    pub beam: Beam,
    /// Elastic model of the beam.
    pub rod: Rod,
}

/// What a name of a rod looks like.
const NAME: &str = "^[A-Za-z][A-Za-z0-9_]{0,39}$";

/// Most characters of such a name.
const NAME_LENGTH: usize = 40;

/// Names that units have by themselves.
const TAKEN: [&str; 2] = ["rod", "fluid"];

impl Scene {
    /// The beams, in the order in which the fluid counts them: `beam`, or those of `rods`.
    pub fn beams(&self) -> impl Iterator<Item = &Beam> {
        self.beam.iter().chain(self.rods.iter().map(|own| &own.beam))
    }

    /// The beams that have a rod, with it and with its name; a rod that is the only one has none.
    pub(crate) fn rods_by_name(&self) -> impl Iterator<Item = (Option<&str>, &Beam, &Rod)> {
        let only = self.beam.iter().zip(&self.rod).map(|(beam, rod)| (None, beam, rod));
        only.chain(self.rods.iter().map(|own| (Some(own.name.as_str()), &own.beam, &own.rod)))
    }

    /// What the rod's unit sees of a scene: one of several rods, that of the name `this_rod`, as the only one, under the load that
    /// was chosen for all. A scene with one rod stays as it is. None where `this_rod` does not say which.
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
            ..self.clone()
        })
    }

    /// Check the list of several rods: how many there are, their names, and that no two lie on each other.
    pub(crate) fn check_rods(&self) -> Result<(), SceneError> {
        let names = || self.rods.iter().map(|own| format!("`{}`", own.name)).collect::<Vec<_>>().join(", ");
        if let Some(name) = &self.this_rod {
            require(!self.rods.is_empty(), "this_rod", format!("{name:?}"), || {
                "it may be there only when the scene has several rods: `rods`".into()
            })?;
            let known = self.rods.iter().any(|own| own.name == *name);
            require(known, "this_rod", format!("{name:?}"), || format!("the names in `rods` are {}", names()))?;
        }
        if self.rods.is_empty() {
            return Ok(());
        }
        for (key, present) in [("beam", self.beam.is_some()), ("rod", self.rod.is_some())] {
            require(!present, key, "present", || {
                "the scene has `rods`: leave one of the two out, or make this one of them".into()
            })?;
        }
        require(self.rods.len() > 1, "rods", "a list of one", || {
            "it must have at least two: a single rod is `beam` and `rod` of the scene".into()
        })?;
        for (i, own) in self.rods.iter().enumerate() {
            let key = format!("rods[{i}].name");
            let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
            let begins = own.name.starts_with(|c: char| c.is_ascii_alphabetic());
            let good = begins && own.name.len() <= NAME_LENGTH && own.name.chars().all(word);
            require(good, &key, format!("{:?}", own.name), || {
                format!("it must be a letter, then letters a-z, A-Z, digits and _, at most {NAME_LENGTH} together")
            })?;
            // Names become those of files, which some systems do not tell apart by case.
            let same = |other: &str| other.eq_ignore_ascii_case(&own.name);
            require(!TAKEN.into_iter().any(same), &key, format!("{:?}", own.name), || {
                "`rod` and `fluid` are names of units already".into()
            })?;
            let twice = self.rods[..i].iter().any(|other| same(&other.name));
            require(!twice, &key, format!("{:?}", own.name), || {
                "another rod has that name; large and small letters are the same here".into()
            })?;
        }
        Ok(())
    }

    /// Check that no two of several rods lie on each other at rest; every beam is checked before.
    pub(crate) fn check_places(&self) -> Result<(), SceneError> {
        let ends = |own: &NamedRod| {
            let stations = self.beam_stations(&own.beam);
            [stations[0], stations[stations.len() - 1]]
        };
        for (i, own) in self.rods.iter().enumerate() {
            let on = self.rods[..i].iter().find(|other| ends(other) == ends(own));
            require(on.is_none(), &format!("rods[{i}].beam.root"), "the root of a beam that has a twin", || {
                let other = on.map_or("", |other| &other.name);
                format!("no two beams may lie on each other: root and tip are those of `{other}`")
            })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::{Load, Scene};

    /// FSI3 with two rods in the place of one, with some of its text replaced.
    fn two(replaced: &[(&str, &str)]) -> Result<Scene, String> {
        let text = include_str!("../../../scenes/fsi3-325x72.json");
        let mut scene: serde_json::Value = serde_json::from_str(text).unwrap();
        let parts = scene.as_object_mut().unwrap();
        let (beam, rod) = (parts.remove("beam").unwrap(), parts.remove("rod").unwrap());
        parts.remove("coupling");
        let mut list = Vec::new();
        for (name, angle) in [("front", 0.0), ("back", 3.0)] {
            let mut beam = beam.clone();
            beam["length"] = 0.1.into();
            beam["root"] = serde_json::json!({ "on_cylinder": { "cylinder": 0, "angle": angle } });
            list.push(serde_json::json!({ "name": name, "beam": beam, "rod": rod }));
        }
        parts.insert("rods".into(), list.into());
        let mut text = scene.to_string();
        for (old, new) in replaced {
            assert!(text.contains(old), "{old} is not in {text}");
            text = text.replacen(old, new, 1);
        }
        Scene::from_json(&text).map_err(|error| error.to_string())
    }

    #[test]
    fn momentum_is_chosen_where_every_rod_may_take_it() {
        let (load, reason) = two(&[]).unwrap().chosen_load().unwrap();
        assert_eq!(load, Load::Momentum, "{reason}");
        // The first density of a rod: keys of an object are sorted, so that of `front`.
        let lighter = two(&[(r#""plane_strain":{"density":1000.0"#, r#""plane_strain":{"density":900.0"#)]).unwrap();
        let (load, reason) = lighter.chosen_load().unwrap();
        assert_eq!(load, Load::PressureJump);
        assert!(reason.contains("the rod `front` weighs 0.9000"), "{reason}");
        // The other rod's unit takes the same.
        let back = Scene { this_rod: Some("back".into()), ..lighter }.of_unit().unwrap();
        assert_eq!((back.load(), back.displaced_line_density()), (Some(Load::PressureJump), 0.0));
    }

    #[test]
    fn unit_sees_one_rod() {
        let scene = two(&[]).unwrap();
        assert!(scene.of_unit().is_none(), "which one?");
        for (i, name) in ["front", "back"].into_iter().enumerate() {
            let own = Scene { this_rod: Some(name.into()), ..scene.clone() }.of_unit().unwrap();
            assert_eq!(own.beam.as_ref(), Some(&scene.rods[i].beam));
            assert_eq!(own.name, format!("fsi3-325x72.{name}"));
            assert_eq!(own.displaced_line_density(), 20.0);
            own.check().unwrap();
        }
    }

    #[test]
    fn lists_that_make_no_sense_are_refused_by_key() {
        for (replaced, expected) in [
            ((r#""name":"back""#, r#""name":"Front""#), "`rods[1].name` is \"Front\", but another rod has that name"),
            ((r#""name":"back""#, r#""name":"fluid""#), "`rods[1].name` is \"fluid\", but `rod` and `fluid` are names"),
            ((r#""name":"back""#, r#""name":"b-1""#), "`rods[1].name` is \"b-1\", but it must be a letter, then"),
            ((r#""angle":3.0"#, r#""angle":0.0"#), "`rods[1].beam.root` is the root of a beam that has a twin"),
            ((r#""cylinder":0"#, r#""cylinder":1"#), "`rods[0].beam.root.on_cylinder.cylinder` is 1, but"),
            (
                (r#""rods":"#, r#""this_rod":"side","rods":"#),
                "`this_rod` is \"side\", but the names in `rods` are `front`, `back`",
            ),
        ] {
            let refused = two(&[replaced]).map(|_| ()).unwrap_err();
            assert!(refused.contains(expected), "{refused}, but expected {expected}");
        }
        let both = |key: &str, value: &str| two(&[(r#""rods":"#, &format!(r#""{key}":{value},"rods":"#))]).unwrap_err();
        let beam = r#"{"root":{"on_cylinder":{"cylinder":0}},"length":0.1,"thickness":0.02,"segments":4}"#;
        assert!(both("beam", beam).contains("`beam` is present, but the scene has `rods`"), "{}", both("beam", beam));
        let mut one = two(&[]).unwrap();
        let back = one.rods.pop().unwrap();
        assert!(
            one.check().unwrap_err().to_string().contains("`rods` is a list of one, but it must have at least two")
        );
        one.rods.push(back);
        one.fluid = None;
        assert!(one.check().unwrap_err().to_string().contains("`fluid` is missing, but several rods need a fluid"));
    }
}
