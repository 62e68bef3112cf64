//! Variables with their value references: one numbering for all types, in the order of the list.
//!
//! In FMI 2.0 an array has consecutive references. In FMI 3.0 its first reference stands for the whole array.

use std::collections::HashMap;
use std::ops::Range;

use crate::access::{Access, UNBOUNDED, Value};
use crate::units::BaseUnit;
use crate::variable::{Causality, Variability, Variable};
use crate::version::Version;

/// Variables of a model with their value references.
pub(crate) struct Table<M> {
    pub version: Version,
    pub variables: Vec<Variable<M>>,
    /// Value reference of each variable's first element.
    first: Vec<u32>,
    /// Index of the variable of each value reference.
    owner: Vec<u32>,
}

/// Consecutive elements of one variable.
pub(crate) struct Run {
    /// Index of the variable.
    pub variable: usize,
    pub elements: Range<usize>,
    /// Position of the first element in the caller's array of values.
    pub position: usize,
}

impl<M> Table<M> {
    /// Number the variables and check the list.
    pub fn new(variables: Vec<Variable<M>>, version: Version) -> Result<Self, String> {
        let mut table = Table { version, first: Vec::with_capacity(variables.len()), owner: Vec::new(), variables };
        for (index, variable) in table.variables.iter().enumerate() {
            table.first.push(table.owner.len() as u32);
            table.owner.resize(table.owner.len() + variable.len(), index as u32);
        }
        table.check()?;
        Ok(table)
    }

    /// Refuse a list with contradictions.
    fn check(&self) -> Result<(), String> {
        let times = self.variables.iter().filter(|variable| variable.causality == Causality::Independent).count();
        if self.version == Version::Fmi3 && times != 1 {
            return Err(format!("FMI 3.0 requires Real::time() in the list once, not {times} times"));
        }
        let mut by_name = HashMap::new();
        for variable in &self.variables {
            if by_name.insert(variable.name.as_str(), variable).is_some() {
                return Err(format!("variable {} is listed twice", variable.name));
            }
        }
        let mut enumerations = HashMap::new();
        for variable in &self.variables {
            let Variable { name, causality, variability, .. } = variable;
            if let Some((kind, items)) = &variable.enumeration {
                if !matches!(variable.access, Access::Integer(_)) || items.is_empty() {
                    return Err(format!("variable {name}: an enumeration must be an Integer with at least one item"));
                }
                if enumerations.insert(kind, items).is_some_and(|known| known != items) {
                    return Err(format!("variable {name}: the enumeration {kind} has different items elsewhere"));
                }
            }
            if let Some(unit) = &variable.unit {
                let own = BaseUnit::parse(unit).map_err(|error| format!("variable {name}: {error}"))?;
                if let Some(shown) = &variable.display_unit {
                    let other = BaseUnit::parse(shown).map_err(|error| format!("variable {name}: {error}"))?;
                    if other.powers != own.powers {
                        return Err(format!(
                            "variable {name}: the display unit {shown:?} does not fit the unit {unit:?}"
                        ));
                    }
                }
            } else if variable.display_unit.is_some() || variable.nominal.is_some() {
                let type_name = variable.access.type_name();
                return Err(format!("variable {name}: a {type_name} has neither display unit nor nominal value"));
            }
            if variable.nominal.is_some_and(|nominal| !(nominal.is_finite() && nominal > 0.0)) {
                return Err(format!("variable {name}: the nominal value must be finite and > 0"));
            }
            let allowed = match variability {
                Variability::Tunable => matches!(causality, Causality::Parameter | Causality::CalculatedParameter),
                Variability::Constant => matches!(causality, Causality::Output | Causality::Local),
                Variability::Fixed | Variability::Continuous => true,
                Variability::Discrete => !matches!(causality, Causality::Parameter | Causality::CalculatedParameter),
            };
            if !allowed {
                let (causality, variability) = (causality.name(), variability.name());
                return Err(format!("variable {name}: a {causality} cannot be {variability}"));
            }
            if variable.bounds != UNBOUNDED && matches!(variable.access, Access::Boolean(_) | Access::Text(_)) {
                return Err(format!("variable {name}: a {} has no limits", variable.access.type_name()));
            }
            for dependency in variable.dependencies.iter().flatten() {
                match by_name.get(dependency.as_str()) {
                    Some(input) if input.causality == Causality::Input => {}
                    _ => return Err(format!("variable {name} depends on {dependency}, which is not an input")),
                }
            }
        }
        Ok(())
    }

    /// Return the number of value references.
    pub fn len(&self) -> usize {
        self.owner.len()
    }

    /// Return the value references of all elements of a variable.
    pub fn references(&self, variable: usize) -> Range<u32> {
        let first = self.first[variable];
        first..first + self.variables[variable].len() as u32
    }

    /// Return the value references of the variable with this name.
    pub fn references_of(&self, name: &str) -> Option<Range<u32>> {
        let variable = self.variables.iter().position(|variable| variable.name == name)?;
        Some(self.references(variable))
    }

    /// Split value references into runs: a whole array, the usual case, is one slice.
    pub fn runs(&self, references: &[u32]) -> impl Iterator<Item = Result<Run, String>> {
        let (mut rest, mut position) = (references, 0);
        std::iter::from_fn(move || {
            let &start = rest.first()?;
            let Some((variable, elements)) = self.locate(rest) else {
                rest = &[];
                return Some(Err(format!("value reference {start} does not exist")));
            };
            rest = &rest[if self.version == Version::Fmi2 { elements.len() } else { 1 }..];
            let run = Run { variable, elements, position };
            position += run.elements.len();
            Some(Ok(run))
        })
    }

    /// Return the variable of the first reference, and its elements.
    fn locate(&self, references: &[u32]) -> Option<(usize, Range<usize>)> {
        let variable = *self.owner.get(references[0] as usize)? as usize;
        let all = self.references(variable);
        let element = (references[0] - all.start) as usize;
        let length = match self.version {
            Version::Fmi2 => consecutive(&references[..references.len().min(all.len() - element)]),
            Version::Fmi3 if element == 0 => all.len(),
            Version::Fmi3 => return None,
        };
        Some((variable, element..element + length))
    }

    /// Return the name of the first element of a run, or in FMI 3.0 of the variable, for messages.
    pub fn name(&self, run: &Run) -> String {
        let variable = &self.variables[run.variable];
        match self.version {
            Version::Fmi2 => variable.element_name(run.elements.start),
            Version::Fmi3 => variable.name.clone(),
        }
    }

    /// Return the message about a variable of another type.
    pub fn wrong_type(&self, run: &Run, wanted: &str) -> String {
        let reference = self.first[run.variable] as usize + run.elements.start;
        let variable = &self.variables[run.variable];
        let type_name = match self.version {
            Version::Fmi2 => variable.access.type_name(),
            Version::Fmi3 => variable.type_name(Version::Fmi3),
        };
        format!("value reference {reference}, the {type_name} {}, is not of type {wanted}", self.name(run))
    }

    /// Pass all values of a variable, which is of type `T`, to `take`.
    pub fn read<T: Value, R>(
        &self,
        variable: usize,
        model: &mut M,
        time: f64,
        take: impl FnOnce(&[T]) -> Result<R, String>,
    ) -> Result<R, String> {
        let variable = &self.variables[variable];
        let take = |values: &[T]| {
            variable.check_length(values.len())?;
            take(values)
        };
        match T::field(&variable.access) {
            Some(field) => field.read(model, take),
            None => take(T::time(&[time]).unwrap_or_default()),
        }
    }
}

/// Return the number of consecutive references at the beginning. The compiler vectorises the comparison of blocks.
fn consecutive(references: &[u32]) -> usize {
    const BLOCK: usize = 32;
    let counts_up = |from: usize, block: &[u32]| {
        let expected = references[0] + from as u32..;
        block.iter().zip(expected).fold(true, |all, (reference, expected)| all & (*reference == expected))
    };
    let blocks = references.chunks_exact(BLOCK).enumerate();
    let compared = BLOCK * blocks.take_while(|(index, block)| counts_up(index * BLOCK, block)).count();
    let rest = references[compared..].iter().zip(references[0] + compared as u32..);
    compared + rest.take_while(|(reference, expected)| **reference == *expected).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variable::{Boolean, Integer};

    type Real = crate::variable::Real<()>;

    fn input(name: &str) -> Variable<()> {
        Real::input(name, "m", "", |_| &mut [])
    }

    fn output(name: &str, unit: &str) -> Variable<()> {
        Real::output(name, unit, "", |_| &[])
    }

    fn error(variables: Vec<Variable<()>>) -> String {
        Table::new(variables, Version::Fmi2).err().expect("the list is wrong")
    }

    fn runs(table: &Table<()>, references: &[u32]) -> Vec<(usize, Range<usize>, usize)> {
        let runs = table.runs(references).map(Result::unwrap);
        runs.map(|run| (run.variable, run.elements, run.position)).collect()
    }

    #[test]
    fn references_in_a_row_are_one_run_per_variable() {
        let list = vec![input("a").array(3), input("b"), input("none").array(0), input("c").array(2)];
        let table = Table::new(list, Version::Fmi2).unwrap();
        assert_eq!(runs(&table, &[0, 1, 2]), [(0, 0..3, 0)]);
        assert_eq!(runs(&table, &[1, 2, 3, 4, 5]), [(0, 1..3, 0), (1, 0..1, 2), (3, 0..2, 3)]);
        assert_eq!(runs(&table, &[5, 4, 4]), [(3, 1..2, 0), (3, 0..1, 1), (3, 0..1, 2)]);
        assert_eq!(runs(&table, &[]), []);
    }

    #[test]
    fn an_unknown_reference_is_named() {
        let table = Table::new(vec![input("a").array(3)], Version::Fmi2).unwrap();
        let message = table.runs(&[2, 3]).find_map(Result::err).unwrap();
        assert!(message.contains("value reference 3"), "{message}");
    }

    #[test]
    fn in_fmi_3_the_first_reference_of_an_array_is_the_whole_of_it() {
        let list = vec![input("a").array(3), input("none").array(0), input("b"), Real::time()];
        let table = Table::new(list, Version::Fmi3).unwrap();
        assert_eq!(runs(&table, &[0, 3, 0]), [(0, 0..3, 0), (2, 0..1, 3), (0, 0..3, 4)]);
        for reference in [1, 2, 5] {
            let message = table.runs(&[0, reference]).find_map(Result::err).unwrap();
            assert!(message.contains(&format!("value reference {reference} does not exist")), "{message}");
        }
    }

    #[test]
    fn fmi_3_wants_the_time_once() {
        for times in [0, 2] {
            let list = (0..times).map(|_| Real::time()).collect();
            let message = Table::new(list, Version::Fmi3).err().unwrap();
            assert!(message.contains(&format!("Real::time() in the list once, not {times}")), "{message}");
        }
    }

    #[test]
    fn a_wrong_list_is_refused_with_the_name_of_the_variable() {
        for (list, parts) in [
            (vec![input("a"), input("a")], ["a", "twice"]),
            (vec![output("drag", "furlong")], ["drag", "furlong"]),
            (vec![output("drag", "N").display_unit("kPa")], ["drag", "kPa\" does not fit the unit \"N"]),
            (vec![output("drag", "N").enumeration("Mode", &["on"])], ["drag", "an enumeration must be an Integer"]),
            (
                vec![
                    Integer::input("a", "", |_| &mut []).enumeration("Mode", &["on"]),
                    Integer::input("b", "", |_| &mut []).enumeration("Mode", &["off"]),
                ],
                ["b", "the enumeration Mode has different items"],
            ),
            (vec![output("drag", "N").nominal(0.0)], ["drag", "nominal value must be finite and > 0"]),
            (vec![Boolean::input("on", "", |_| &mut []).nominal(1.0)], ["on", "neither display unit nor nominal"]),
            (vec![output("drag", "N").depends_on(&["u"])], ["drag", "u, which is not an input"]),
            (vec![output("drag", "N").depends_on(&["drag"])], ["drag", "not an input"]),
            (vec![output("drag", "N").tunable()], ["drag", "output cannot be tunable"]),
            (vec![input("u").constant()], ["u", "input cannot be constant"]),
            (vec![Boolean::input("on", "", |_| &mut []).above(0.0)], ["on", "no limits"]),
            (vec![Integer::input("n", "", |_| &mut []).tunable()], ["n", "input cannot be tunable"]),
        ] {
            let message = error(list);
            assert!(parts.iter().all(|part| message.contains(part)), "{message}");
        }
    }
}
