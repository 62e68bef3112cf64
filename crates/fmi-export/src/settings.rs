//! Settings of an instance: its parameters or inputs, which a stored state holds beside the state of the model.

use serde::{Deserialize, Serialize};

use crate::access::{Access, Field, Value};
use crate::table::Table;
use crate::variable::{Causality, Variable};

/// Values of all parameters or of all inputs, in the order of the list.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Settings {
    reals: Vec<f64>,
    integers: Vec<i32>,
    booleans: Vec<bool>,
    texts: Vec<String>,
}

impl Settings {
    /// Return the parameters or the inputs of a model.
    pub fn of<M>(table: &Table<M>, model: &mut M, causality: Causality) -> Self {
        let mut settings = Self::default();
        for variable in table.variables.iter().filter(|variable| variable.causality == causality) {
            match &variable.access {
                Access::Real(Field::Write(get)) => settings.reals.extend_from_slice(get(model)),
                Access::Integer(Field::Write(get)) => settings.integers.extend_from_slice(get(model)),
                Access::Boolean(Field::Write(get)) => settings.booleans.extend_from_slice(get(model)),
                Access::Text(Field::Write(get)) => settings.texts.extend_from_slice(get(model)),
                _ => {}
            }
        }
        settings
    }

    /// Set the parameters or the inputs of a model; refuse another number of values, and values outside their limits.
    pub fn apply<M>(&self, table: &Table<M>, model: &mut M, causality: Causality) -> Result<(), String> {
        let (mut reals, mut integers) = (&self.reals[..], &self.integers[..]);
        let (mut booleans, mut texts) = (&self.booleans[..], &self.texts[..]);
        for variable in table.variables.iter().filter(|variable| variable.causality == causality) {
            match &variable.access {
                Access::Real(Field::Write(get)) => fill(variable, get(model), &mut reals)?,
                Access::Integer(Field::Write(get)) => fill(variable, get(model), &mut integers)?,
                Access::Boolean(Field::Write(get)) => fill(variable, get(model), &mut booleans)?,
                Access::Text(Field::Write(get)) => fill(variable, get(model), &mut texts)?,
                _ => {}
            }
        }
        match reals.len() + integers.len() + booleans.len() + texts.len() {
            0 => Ok(()),
            more => Err(format!("it has {more} values more than the model has {}s", causality.name())),
        }
    }
}

/// Fill a variable with the first of the remaining values.
fn fill<M, T: Value + Clone>(variable: &Variable<M>, target: &mut [T], rest: &mut &[T]) -> Result<(), String> {
    let Some((values, after)) = rest.split_at_checked(target.len()) else {
        return Err(format!("{} has {} elements, but {} values are left", variable.name, target.len(), rest.len()));
    };
    variable.check(values, 0)?;
    target.clone_from_slice(values);
    *rest = after;
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::slice::from_mut;

    use super::*;
    use crate::variable::{Boolean, Real, Text};
    use crate::version::Version;

    type Model = ([f64; 2], bool, String);

    fn table() -> Table<Model> {
        let list = vec![
            Real::parameter("p", "m", "", |m: &mut Model| &mut m.0).at_least(0.0).array(2),
            Boolean::input("on", "", |m: &mut Model| from_mut(&mut m.1)),
            Text::parameter("label", "", |m: &mut Model| from_mut(&mut m.2)),
            Real::output("y", "m", "", |_| &[1.0]),
        ];
        Table::new(list, Version::Fmi2).unwrap()
    }

    #[test]
    fn parameters_and_inputs_of_one_model_become_those_of_another() {
        let (mut one, mut other) = (([0.1, 2.0], true, "fin".to_string()), Model::default());
        Settings::of(&table(), &mut one, Causality::Parameter)
            .apply(&table(), &mut other, Causality::Parameter)
            .unwrap();
        assert_eq!(other, ([0.1, 2.0], false, "fin".to_string()));
        Settings::of(&table(), &mut one, Causality::Input).apply(&table(), &mut other, Causality::Input).unwrap();
        assert_eq!(other, one);
    }

    #[test]
    fn values_of_another_number_or_outside_the_limits_are_refused_by_name() {
        let settings = || Settings::of(&table(), &mut Model::default(), Causality::Parameter);
        for (wrong, part) in [
            (Settings { reals: vec![0.0], ..settings() }, "p has 2 elements, but 1 values are left"),
            (Settings { reals: vec![0.0, -1.0], ..settings() }, "p[2] = -1.000e0 must be finite and >= 0"),
            (Settings { booleans: vec![true], ..settings() }, "it has 1 values more than the model has parameters"),
        ] {
            let message = wrong.apply(&table(), &mut Model::default(), Causality::Parameter).unwrap_err();
            assert!(message.contains(part), "{message}");
        }
    }
}
