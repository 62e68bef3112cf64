//! Elements that the model descriptions of FMI 2.0 and 3.0 share.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::ops::{Bound, Range};

use quick_xml::Writer;
use quick_xml::writer::ElementWriter;

use crate::access::{Access, Bounds};
use crate::log;
use crate::table::Table;
use crate::units::{BaseUnit, NAMES};
use crate::variable::Variable;
use crate::version::Version;

/// Variables with their value references, without empty arrays.
pub(super) type Listed<'a, M> = Vec<(&'a Variable<M>, Range<u32>)>;

/// Write the definitions of all units and display units.
pub(super) fn write_units<M>(writer: &mut Writer<Vec<u8>>, table: &Table<M>) -> io::Result<()> {
    let parse = |unit: &str| BaseUnit::parse(unit).expect("the table's units are known");
    let mut units = BTreeMap::<&str, BTreeSet<&str>>::new();
    for variable in &table.variables {
        if let Some(unit) = &variable.unit {
            units.entry(unit).or_default().extend(variable.display_unit.as_deref());
        }
    }
    if units.is_empty() {
        return Ok(());
    }
    writer.create_element("UnitDefinitions").write_inner_content(|writer| {
        units.iter().try_for_each(|(name, shown)| {
            let own = parse(name);
            writer.create_element("Unit").with_attribute(("name", *name)).write_inner_content(|writer| {
                let powers = NAMES.iter().zip(own.powers).filter(|(_, power)| *power != 0);
                let element = powers.fold(writer.create_element("BaseUnit"), |element, (symbol, power)| {
                    element.with_attribute((*symbol, power.to_string().as_str()))
                });
                with_conversion(element, own.factor, own.offset).write_empty()?;
                shown.iter().try_for_each(|name| {
                    // displayed = factor · value + offset; both are the same in base units.
                    let other = parse(name);
                    let (factor, offset) = (own.factor / other.factor, (own.offset - other.offset) / other.factor);
                    let element = writer.create_element("DisplayUnit").with_attribute(("name", *name));
                    with_conversion(element, factor, offset).write_empty().map(|_| ())
                })
            })?;
            Ok(())
        })
    })?;
    Ok(())
}

/// Add `factor` and `offset` unless they have their default values.
fn with_conversion(mut element: ElementWriter<'_, Vec<u8>>, factor: f64, offset: f64) -> ElementWriter<'_, Vec<u8>> {
    if factor != 1.0 {
        element = element.with_attribute(("factor", real(factor).as_str()));
    }
    if offset != 0.0 {
        element = element.with_attribute(("offset", real(offset).as_str()));
    }
    element
}

/// Return the enumerations with their items, by name.
pub(super) fn enumerations<M>(table: &Table<M>) -> BTreeMap<&str, &[String]> {
    let named = table.variables.iter().filter_map(|variable| variable.enumeration.as_ref());
    named.map(|(name, items)| (name.as_str(), items.as_slice())).collect()
}

/// Write the items of an enumeration, numbered from 1.
pub(super) fn write_items(writer: &mut Writer<Vec<u8>>, items: &[String]) -> io::Result<()> {
    items.iter().zip(1..).try_for_each(|(item, value): (_, i32)| {
        let element = writer.create_element("Item").with_attribute(("name", item.as_str()));
        element.with_attribute(("value", value.to_string().as_str())).write_empty().map(|_| ())
    })
}

/// Write the log categories with their descriptions.
pub(super) fn write_log_categories(writer: &mut Writer<Vec<u8>>, version: Version) -> io::Result<()> {
    writer.create_element("LogCategories").write_inner_content(|writer| {
        log::categories(version).iter().try_for_each(|(name, description)| {
            writer
                .create_element("Category")
                .with_attribute(("name", name.to_str().expect("the categories are ASCII")))
                .with_attribute(("description", *description))
                .write_empty()?;
            Ok(())
        })
    })?;
    Ok(())
}

/// Begin the element of a variable: name, value reference, description and role.
pub(super) fn begin<'a, M>(
    writer: &'a mut Writer<Vec<u8>>,
    element: &'static str,
    name: &str,
    reference: u32,
    variable: &Variable<M>,
) -> ElementWriter<'a, Vec<u8>> {
    let element = writer
        .create_element(element)
        .with_attribute(("name", name))
        .with_attribute(("valueReference", reference.to_string().as_str()))
        .with_attribute(("description", variable.description.as_str()))
        .with_attribute(("causality", variable.causality.name()))
        .with_attribute(("variability", variable.variability.name()));
    match variable.initial() {
        Some(initial) => element.with_attribute(("initial", initial)),
        None => element,
    }
}

/// Write an unknown, whose `key` is an index or a value reference, with its dependencies if they are known.
pub(super) fn write_unknown(
    writer: &mut Writer<Vec<u8>>,
    element: &'static str,
    (key, reference): (&str, u32),
    dependencies: Option<&str>,
) -> io::Result<()> {
    let element = writer.create_element(element).with_attribute((key, reference.to_string().as_str()));
    match dependencies {
        Some(dependencies) => element.with_attribute(("dependencies", dependencies)),
        None => element,
    }
    .write_empty()?;
    Ok(())
}

/// Add unit, display unit and nominal value of a Real.
pub(super) fn with_unit<'a, M>(
    mut element: ElementWriter<'a, Vec<u8>>,
    variable: &Variable<M>,
) -> ElementWriter<'a, Vec<u8>> {
    if let Some(unit) = &variable.unit {
        element = element.with_attribute(("unit", unit.as_str()));
    }
    if let Some(unit) = &variable.display_unit {
        element = element.with_attribute(("displayUnit", unit.as_str()));
    }
    if let Some(nominal) = variable.nominal {
        element = element.with_attribute(("nominal", real(nominal).as_str()));
    }
    element
}

/// Add `min` and `max` of inclusive limits; FMI has no attribute for an exclusive limit.
pub(super) fn with_bounds<'a, M>(
    mut value: ElementWriter<'a, Vec<u8>>,
    variable: &Variable<M>,
) -> ElementWriter<'a, Vec<u8>> {
    let text = |limit: f64| match variable.access {
        Access::Integer(_) => limit.to_string(),
        _ => real(limit),
    };
    let (lower, upper): Bounds = variable.bounds;
    for (name, bound) in [("min", lower), ("max", upper)] {
        if let Bound::Included(limit) = bound {
            value = value.with_attribute((name, text(limit).as_str()));
        }
    }
    value
}

/// Return the shortest text that reads back as the same number.
pub(super) fn real(value: f64) -> String {
    format!("{value:?}")
}
