//! Model description of FMI 3.0: an array is one variable with a list of start values.

use std::collections::BTreeMap;
use std::io;
use std::ops::Range;

use quick_xml::Writer;

use super::elements::{Listed, begin, enumerations, with_bounds, with_unit, write_items, write_unknown};
use crate::access::Access;
use crate::table::Table;
use crate::variable::Variable;
use crate::version::Version;

/// Capabilities of a unit.
pub(super) const CAPABILITIES: &[(&str, &str)] = &[
    ("canGetAndSetFMUState", "true"),
    ("canSerializeFMUState", "true"),
    ("providesDirectionalDerivatives", "false"),
    ("providesAdjointDerivatives", "false"),
    ("canHandleVariableCommunicationStepSize", "true"),
    ("maxOutputDerivativeOrder", "0"),
];

/// Write the types. They carry the units, because some readers ignore the units of variables.
pub(super) fn write_types<M>(writer: &mut Writer<Vec<u8>>, table: &Table<M>) -> io::Result<()> {
    let variables = table.variables.iter();
    let reals: BTreeMap<_, _> = variables.filter_map(|variable| Some((real_type(variable)?, variable))).collect();
    let enumerations = enumerations(table);
    if reals.is_empty() && enumerations.is_empty() {
        return Ok(());
    }
    writer.create_element("TypeDefinitions").write_inner_content(|writer| {
        for (name, variable) in &reals {
            let element = writer.create_element("Float64Type").with_attribute(("name", name.as_str()));
            with_unit(element, variable).write_empty()?;
        }
        enumerations.iter().try_for_each(|(name, items)| {
            let element = writer.create_element("EnumerationType").with_attribute(("name", *name));
            element.write_inner_content(|writer| write_items(writer, items)).map(|_| ())
        })
    })?;
    Ok(())
}

/// Return the name of the type of a Real; its space keeps it apart from the names of variables.
fn real_type<M>(variable: &Variable<M>) -> Option<String> {
    let shown = variable.display_unit.as_ref().map_or(String::new(), |unit| format!(", shown in {unit}"));
    let about = variable.nominal.map_or(String::new(), |nominal| format!(", about {nominal}"));
    variable.unit.as_ref().map(|unit| format!("in {unit}{shown}{about}"))
}

/// Write one variable.
pub(super) fn write_variable<M>(
    writer: &mut Writer<Vec<u8>>,
    variable: &Variable<M>,
    references: Range<u32>,
    starts: &[Option<String>],
) -> io::Result<()> {
    if references.is_empty() {
        return Ok(());
    }
    let starts: Vec<&str> = references.clone().filter_map(|reference| starts[reference as usize].as_deref()).collect();
    let mut element = begin(writer, variable.type_name(Version::Fmi3), &variable.name, references.start, variable);
    let declared = real_type(variable).or_else(|| variable.enumeration.as_ref().map(|(name, _)| name.clone()));
    if let Some(name) = declared {
        element = element.with_attribute(("declaredType", name.as_str()));
    }
    element = with_bounds(element, variable);
    let texts = if matches!(variable.access, Access::Text(_)) { &starts[..] } else { &[] };
    if texts.is_empty() && !starts.is_empty() {
        element = element.with_attribute(("start", starts.join(" ").as_str()));
    }
    let dimension = variable.array.map(|length| length.to_string());
    if dimension.is_none() && texts.is_empty() {
        element.write_empty()?;
        return Ok(());
    }
    element.write_inner_content(|writer| {
        if let Some(length) = &dimension {
            writer.create_element("Dimension").with_attribute(("start", length.as_str())).write_empty()?;
        }
        texts.iter().try_for_each(|text| {
            writer.create_element("Start").with_attribute(("value", *text)).write_empty().map(|_| ())
        })
    })?;
    Ok(())
}

/// Write outputs and initial unknowns with their dependencies.
pub(super) fn write_structure<M>(
    writer: &mut Writer<Vec<u8>>,
    table: &Table<M>,
    outputs: &Listed<M>,
    unknowns: &Listed<M>,
) -> io::Result<()> {
    let dependencies = |variable: &Variable<M>| {
        let known = variable.dependencies.as_ref()?.iter().filter_map(|name| table.references_of(name));
        let known: Vec<_> = known.filter(|r| !r.is_empty()).map(|r| r.start.to_string()).collect();
        Some(known.join(" "))
    };
    writer.create_element("ModelStructure").write_inner_content(|writer| {
        outputs.iter().try_for_each(|(variable, r)| {
            write_unknown(writer, "Output", ("valueReference", r.start), dependencies(variable).as_deref())
        })?;
        unknowns
            .iter()
            .try_for_each(|(_, r)| write_unknown(writer, "InitialUnknown", ("valueReference", r.start), None))
    })?;
    Ok(())
}
