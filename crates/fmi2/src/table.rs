//! The list of variables with its value references: one numbering for all types, arrays in a row, in list order.

use std::collections::HashMap;
use std::ops::Range;

use crate::model::Span;
use crate::units::BaseUnit;
use crate::variable::{Access, Causality, UNBOUNDED, Value, Variability, Variable};

pub(crate) struct Table<M> {
    pub variables: Vec<Variable<M>>,
    /// Value reference of each variable's first element.
    first: Vec<u32>,
    /// Index of the variable that each value reference belongs to.
    owner: Vec<u32>,
}

/// Value references in a row that belong to one variable.
pub(crate) struct Run {
    /// Index of the variable.
    pub variable: usize,
    pub elements: Range<usize>,
    /// Where the caller's arrays hold the first of them.
    pub position: usize,
}

impl<M> Table<M> {
    /// Numbers the variables and checks what can be checked without the model's values.
    pub fn new(variables: Vec<Variable<M>>) -> Result<Self, String> {
        let mut table = Table { first: Vec::with_capacity(variables.len()), owner: Vec::new(), variables };
        for (index, variable) in table.variables.iter().enumerate() {
            table.first.push(table.owner.len() as u32);
            table.owner.resize(table.owner.len() + variable.len(), index as u32);
        }
        table.check()?;
        Ok(table)
    }

    fn check(&self) -> Result<(), String> {
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
                    return Err(format!("variable {name}: an enumeration is an Integer with at least one item"));
                }
                if enumerations.insert(kind, items).is_some_and(|known| known != items) {
                    return Err(format!("variable {name}: the enumeration {kind} has other items elsewhere"));
                }
            }
            if let Some(unit) = &variable.unit {
                let own = BaseUnit::parse(unit).map_err(|error| format!("variable {name}: {error}"))?;
                if let Some(shown) = &variable.display_unit {
                    let other = BaseUnit::parse(shown).map_err(|error| format!("variable {name}: {error}"))?;
                    if other.powers != own.powers {
                        return Err(format!("variable {name}: {shown:?} cannot show what is in {unit:?}"));
                    }
                }
            } else if variable.display_unit.is_some() || variable.nominal.is_some() {
                let type_name = variable.access.type_name();
                return Err(format!("variable {name}: a {type_name} has neither display unit nor nominal value"));
            }
            if variable.nominal.is_some_and(|nominal| !(nominal.is_finite() && nominal > 0.0)) {
                return Err(format!("variable {name}: its nominal value must be finite and > 0"));
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

    /// Number of value references.
    pub fn len(&self) -> usize {
        self.owner.len()
    }

    /// Value references of all elements of a variable.
    pub fn references(&self, variable: usize) -> Range<u32> {
        let first = self.first[variable];
        first..first + self.variables[variable].len() as u32
    }

    /// Value references of the variable of that name.
    pub fn references_of(&self, name: &str) -> Option<Range<u32>> {
        let variable = self.variables.iter().position(|variable| variable.name == name)?;
        Some(self.references(variable))
    }

    /// Splits value references into runs, so that the common case, a whole array, is one slice.
    pub fn runs(&self, references: &[u32]) -> impl Iterator<Item = Result<Run, String>> {
        let mut position = 0;
        std::iter::from_fn(move || {
            let rest = &references[position..];
            let &start = rest.first()?;
            let Some(&variable) = self.owner.get(start as usize) else {
                position = references.len();
                return Some(Err(format!("value reference {start} does not exist")));
            };
            let variable = variable as usize;
            let end = self.references(variable).end;
            let length = consecutive(&rest[..rest.len().min((end - start) as usize)]);
            let element = (start - self.first[variable]) as usize;
            let run = Run { variable, elements: element..element + length, position };
            position += length;
            Some(Ok(run))
        })
    }

    /// The references as spans of Real variables of one causality.
    pub fn spans(&self, references: &[u32], causality: Causality) -> Result<Vec<Span<'_>>, String> {
        self.runs(references)
            .map(|run| {
                let run = run?;
                let variable = &self.variables[run.variable];
                if variable.access.type_name() != f64::TYPE {
                    return Err(self.wrong_type::<f64>(&run));
                }
                if variable.causality != causality {
                    return Err(format!("{} is not an {}", self.name(&run), causality.name()));
                }
                Ok(Span { name: &variable.name, elements: run.elements })
            })
            .collect()
    }

    /// Name of a run's first element, for messages.
    pub fn name(&self, run: &Run) -> String {
        self.variables[run.variable].element_name(run.elements.start)
    }

    /// What a call about type `T` says of a variable of another type.
    pub fn wrong_type<T: Value>(&self, run: &Run) -> String {
        let reference = self.first[run.variable] as usize + run.elements.start;
        let type_name = self.variables[run.variable].access.type_name();
        format!("value reference {reference}, the {type_name} {}, is not of type {}", self.name(run), T::TYPE)
    }

    /// All values of a variable.
    pub fn read<'a, T: Value>(
        &self,
        variable: usize,
        model: &'a mut M,
        clock: &'a [f64; 1],
    ) -> Result<Option<&'a [T]>, String> {
        let variable = &self.variables[variable];
        let values = match &variable.access {
            Access::Time => T::clock(clock),
            access => T::field(access).map(|field| field.read(model)),
        };
        values.map(|values| variable.checked_length(values.len()).map(|()| values)).transpose()
    }
}

/// How many references, from the first on, count up by one. Compared in blocks, which the compiler vectorises.
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

impl<M> Variable<M> {
    /// The model must give as many values as the list declares.
    pub(crate) fn checked_length(&self, length: usize) -> Result<(), String> {
        if length == self.len() {
            return Ok(());
        }
        Err(format!("variable {}: the model gives {length} values, the list declares {}", self.name, self.len()))
    }
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
        Table::new(variables).err().expect("the list is wrong")
    }

    fn runs(table: &Table<()>, references: &[u32]) -> Vec<(usize, Range<usize>, usize)> {
        let runs = table.runs(references).map(Result::unwrap);
        runs.map(|run| (run.variable, run.elements, run.position)).collect()
    }

    #[test]
    fn references_in_a_row_are_one_run_per_variable() {
        let list = vec![input("a").array(3), input("b"), input("none").array(0), input("c").array(2)];
        let table = Table::new(list).unwrap();
        assert_eq!(runs(&table, &[0, 1, 2]), [(0, 0..3, 0)]);
        assert_eq!(runs(&table, &[1, 2, 3, 4, 5]), [(0, 1..3, 0), (1, 0..1, 2), (3, 0..2, 3)]);
        assert_eq!(runs(&table, &[5, 4, 4]), [(3, 1..2, 0), (3, 0..1, 1), (3, 0..1, 2)]);
        assert_eq!(runs(&table, &[]), []);
    }

    #[test]
    fn an_unknown_reference_is_named() {
        let table = Table::new(vec![input("a").array(3)]).unwrap();
        let message = table.runs(&[2, 3]).find_map(Result::err).unwrap();
        assert!(message.contains("value reference 3"), "{message}");
    }

    #[test]
    fn a_wrong_list_is_refused_with_the_name_of_the_variable() {
        for (list, parts) in [
            (vec![input("a"), input("a")], ["a", "twice"]),
            (vec![output("drag", "furlong")], ["drag", "furlong"]),
            (vec![output("drag", "N").display_unit("kPa")], ["drag", "kPa\" cannot show what is in \"N"]),
            (vec![output("drag", "N").enumeration("Mode", &["on"])], ["drag", "an enumeration is an Integer"]),
            (
                vec![
                    Integer::input("a", "", |_| &mut []).enumeration("Mode", &["on"]),
                    Integer::input("b", "", |_| &mut []).enumeration("Mode", &["off"]),
                ],
                ["b", "the enumeration Mode has other items"],
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
