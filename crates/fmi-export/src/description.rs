//! `modelDescription.xml` and its GUID, from the list of variables.

mod elements;
mod fmi2;
mod fmi3;

use std::io;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};

use elements::{Listed, real, write_log_categories, write_units};

use crate::access::{Access, Value};
use crate::identity;
use crate::memory::require_memory;
use crate::model::{Description, Model};
use crate::resource::Resources;
use crate::table::Table;
use crate::variable::{Causality, Variability, Variable};
use crate::version::Version;

/// Model description and its GUID.
pub(crate) struct Document {
    /// GUID of the form `{8-4-4-4-12}`.
    pub guid: String,
    pub xml: String,
}

/// Approximate memory for the description of a value reference: twice its text and its start value, bytes.
const BYTES_PER_REFERENCE: usize = 1000;

/// Return the model description. Its GUID binds library, resources and XML of an FMU to each other.
pub(crate) fn document<M: Model>(table: &Table<M>, model: &mut M, resources: &Resources) -> Result<Document, String> {
    require_memory(BYTES_PER_REFERENCE * table.len())?;
    let description = model.description();
    let write = |guid: &str, starts: &[Option<String>]| {
        let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
        write_document(&mut writer, &description, table, starts, guid).expect("writing to memory does not fail");
        String::from_utf8(writer.into_inner()).expect("the writer was given UTF-8")
    };
    // The last digits of a start value depend on the sine and cosine of the system; the GUID does not.
    let rounded = start_values(table, model, |value| format!("{value:.8e}"))?;
    let guid = identity::guid::<M>(resources, write("", &rounded).as_bytes());
    let xml = write(&guid, &start_values(table, model, |value| real(*value))?);
    Ok(Document { guid, xml })
}

/// Return the start values as text, one per value reference; `None` for a variable without a start value.
fn start_values<M: Model>(
    table: &Table<M>,
    model: &mut M,
    real: fn(&f64) -> String,
) -> Result<Vec<Option<String>>, String> {
    let mut starts = Vec::new();
    for (index, variable) in table.variables.iter().enumerate() {
        match &variable.access {
            Access::Time => starts.push(None),
            Access::Real(_) => append::<M, f64>(&mut starts, table, model, index, real)?,
            Access::Integer(_) => append::<M, i32>(&mut starts, table, model, index, i32::to_string)?,
            Access::Boolean(_) => append::<M, bool>(&mut starts, table, model, index, bool::to_string)?,
            Access::Text(_) => append::<M, String>(&mut starts, table, model, index, String::clone)?,
        }
    }
    Ok(starts)
}

/// Append the start values of a variable.
fn append<M: Model, T: Value>(
    starts: &mut Vec<Option<String>>,
    table: &Table<M>,
    model: &mut M,
    index: usize,
    text: fn(&T) -> String,
) -> Result<(), String> {
    let variable = &table.variables[index];
    if !variable.has_start() {
        starts.resize(starts.len() + variable.len(), None);
        return Ok(());
    }
    table.read::<T, _>(index, model, 0.0, |values| {
        variable.check(values, 0).map_err(|error| format!("start value {error}"))?;
        starts.extend(values.iter().map(|value| Some(text(value))));
        Ok(())
    })
}

fn write_document<M: Model>(
    writer: &mut Writer<Vec<u8>>,
    description: &Description,
    table: &Table<M>,
    starts: &[Option<String>],
    guid: &str,
) -> io::Result<()> {
    writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let (number, token, capabilities) = match table.version {
        Version::Fmi2 => ("2.0", "guid", fmi2::CAPABILITIES),
        Version::Fmi3 => ("3.0", "instantiationToken", fmi3::CAPABILITIES),
    };
    writer
        .create_element("fmiModelDescription")
        .with_attributes(
            [
                ("fmiVersion", number),
                ("modelName", &description.model_name),
                (token, guid),
                ("description", &description.text),
                ("author", &description.author),
                ("version", M::VERSION),
                ("copyright", &description.copyright),
                ("license", &description.license),
                ("generationTool", concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION"))),
                ("variableNamingConvention", "structured"),
            ]
            .into_iter()
            .filter(|(_, value)| !value.is_empty()),
        )
        .write_inner_content(|writer| {
            writer
                .create_element("CoSimulation")
                .with_attribute(("modelIdentifier", M::IDENTIFIER))
                .with_attributes(capabilities.iter().copied())
                .write_empty()?;
            write_units(writer, table)?;
            match table.version {
                Version::Fmi2 => fmi2::write_types(writer, table)?,
                Version::Fmi3 => fmi3::write_types(writer, table)?,
            }
            write_log_categories(writer, table.version)?;
            writer
                .create_element("DefaultExperiment")
                .with_attribute(("startTime", real(description.start).as_str()))
                .with_attribute(("stopTime", real(description.stop).as_str()))
                .with_attribute(("tolerance", real(description.tolerance).as_str()))
                .with_attribute(("stepSize", real(description.step).as_str()))
                .write_empty()?;
            writer.create_element("ModelVariables").write_inner_content(|writer| {
                table.variables.iter().enumerate().try_for_each(|(index, variable)| {
                    let references = table.references(index);
                    match table.version {
                        Version::Fmi2 => fmi2::write_variable(writer, variable, references, starts),
                        Version::Fmi3 => fmi3::write_variable(writer, variable, references, starts),
                    }
                })
            })?;
            let (outputs, unknowns) = (of_kind(table, is_output), of_kind(table, is_initial_unknown));
            match table.version {
                Version::Fmi2 => fmi2::write_structure(writer, table, &outputs, &unknowns),
                Version::Fmi3 => fmi3::write_structure(writer, table, &outputs, &unknowns),
            }
        })?;
    Ok(())
}

/// Return the variables of a kind.
fn of_kind<M>(table: &Table<M>, kind: fn(&Variable<M>) -> bool) -> Listed<'_, M> {
    let variables = table.variables.iter().enumerate();
    variables
        .filter(|(_, variable)| kind(variable))
        .map(|(index, variable)| (variable, table.references(index)))
        .filter(|(_, references)| !references.is_empty())
        .collect()
}

fn is_output<M>(variable: &Variable<M>) -> bool {
    variable.causality == Causality::Output
}

fn is_initial_unknown<M>(variable: &Variable<M>) -> bool {
    let calculated = matches!(variable.causality, Causality::Output | Causality::CalculatedParameter);
    calculated && variable.variability != Variability::Constant
}

#[cfg(test)]
mod tests;
