//! Model description of FMI 2.0: each element of an array is a variable.

use std::io;
use std::ops::Range;

use quick_xml::Writer;

use super::elements::{Listed, begin, enumerations, with_bounds, with_unit, write_items, write_unknown};
use crate::table::Table;
use crate::variable::Variable;
use crate::version::Version;

/// Capabilities of a unit.
pub(super) const CAPABILITIES: &[(&str, &str)] = &[
    ("canHandleVariableCommunicationStepSize", "true"),
    ("canInterpolateInputs", "false"),
    ("maxOutputDerivativeOrder", "0"),
    ("canBeInstantiatedOnlyOncePerProcess", "false"),
    ("canNotUseMemoryManagementFunctions", "true"),
    ("canGetAndSetFMUstate", "true"),
    ("canSerializeFMUstate", "true"),
    ("providesDirectionalDerivative", "false"),
];

/// Write the enumerations.
pub(super) fn write_types<M>(writer: &mut Writer<Vec<u8>>, table: &Table<M>) -> io::Result<()> {
    let enumerations = enumerations(table);
    if enumerations.is_empty() {
        return Ok(());
    }
    writer.create_element("TypeDefinitions").write_inner_content(|writer| {
        enumerations.iter().try_for_each(|(name, items)| {
            writer.create_element("SimpleType").with_attribute(("name", *name)).write_inner_content(|writer| {
                writer.create_element("Enumeration").write_inner_content(|writer| write_items(writer, items))?;
                Ok(())
            })?;
            Ok(())
        })
    })?;
    Ok(())
}

/// Write one variable for each element.
pub(super) fn write_variable<M>(
    writer: &mut Writer<Vec<u8>>,
    variable: &Variable<M>,
    references: Range<u32>,
    starts: &[Option<String>],
) -> io::Result<()> {
    for (element, reference) in references.enumerate() {
        let name = variable.element_name(element);
        begin(writer, "ScalarVariable", &name, reference, variable).write_inner_content(|writer| {
            let mut value = writer.create_element(variable.type_name(Version::Fmi2));
            if let Some((name, _)) = &variable.enumeration {
                value = value.with_attribute(("declaredType", name.as_str()));
            }
            value = with_bounds(with_unit(value, variable), variable);
            if let Some(start) = &starts[reference as usize] {
                value = value.with_attribute(("start", start.as_str()));
            }
            value.write_empty()?;
            Ok(())
        })?;
    }
    Ok(())
}

/// Write outputs and initial unknowns. The standard numbers `ScalarVariable` elements from 1, value references from 0.
pub(super) fn write_structure<M>(
    writer: &mut Writer<Vec<u8>>,
    table: &Table<M>,
    outputs: &Listed<M>,
    unknowns: &Listed<M>,
) -> io::Result<()> {
    let dependencies = |variable: &Variable<M>| {
        let known = variable.dependencies.as_ref()?.iter().filter_map(|name| table.references_of(name)).flatten();
        Some(known.map(|reference| (reference + 1).to_string()).collect::<Vec<_>>().join(" "))
    };
    writer.create_element("ModelStructure").write_inner_content(|writer| {
        if !outputs.is_empty() {
            writer.create_element("Outputs").write_inner_content(|writer| {
                outputs.iter().try_for_each(|(variable, references)| {
                    write_unknowns(writer, references.clone(), dependencies(variable).as_deref())
                })
            })?;
        }
        if !unknowns.is_empty() {
            writer.create_element("InitialUnknowns").write_inner_content(|writer| {
                unknowns.iter().try_for_each(|(_, references)| write_unknowns(writer, references.clone(), None))
            })?;
        }
        Ok(())
    })?;
    Ok(())
}

/// Write the unknowns of one variable.
fn write_unknowns(
    writer: &mut Writer<Vec<u8>>,
    mut references: Range<u32>,
    dependencies: Option<&str>,
) -> io::Result<()> {
    references.try_for_each(|reference| write_unknown(writer, "Unknown", ("index", reference + 1), dependencies))
}
