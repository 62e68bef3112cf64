//! `modelDescription.xml` and its GUID, made from the list of variables.

mod fmi2;
mod fmi3;

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::ops::{Bound, Range};

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use quick_xml::writer::ElementWriter;

use crate::identity;
use crate::log;
use crate::memory::require_memory;
use crate::model::Model;
use crate::resource::Resources;
use crate::table::Table;
use crate::units::{BaseUnit, NAMES};
use crate::variable::{Access, Bounds, Causality, Value, Variability, Variable};
use crate::version::Version;

/// What a master shows of a model before it runs it.
#[derive(Clone, Debug)]
pub struct Description {
    /// Name of the model.
    pub model_name: String,
    /// One sentence on what it is.
    pub text: String,
    /// Who made it; empty: not said.
    pub author: String,
    /// Who holds the rights; empty: not said.
    pub copyright: String,
    /// Its licence; empty: not said.
    pub license: String,
    /// Default start time, s.
    pub start: f64,
    /// Default stop time, s.
    pub stop: f64,
    /// Default communication step, s.
    pub step: f64,
    /// Default relative tolerance.
    pub tolerance: f64,
}

impl Default for Description {
    /// From 0 to 1 s in steps of 0.1 s, and nothing said.
    fn default() -> Self {
        let [model_name, text, author, copyright, license] = [const { String::new() }; 5];
        Self { model_name, text, author, copyright, license, start: 0.0, stop: 1.0, step: 0.1, tolerance: 1e-6 }
    }
}

/// A model description and its GUID.
pub(crate) struct Document {
    /// `{8-4-4-4-12}`
    pub guid: String,
    pub xml: String,
}

/// Bytes that the description of a value reference takes while it is made, about: twice its text, and its start value.
const BYTES_PER_REFERENCE: usize = 1000;

/// Writes the model description. Its GUID tells an FMU whose library, resources and XML do not belong together.
pub(crate) fn document<M: Model>(table: &Table<M>, model: &mut M, resources: &Resources) -> Result<Document, String> {
    require_memory(BYTES_PER_REFERENCE * table.len())?;
    let description = model.description();
    let write = |guid: &str, starts: &[Option<String>]| {
        let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
        write_document(&mut writer, &description, table, starts, guid).expect("writing to memory does not fail");
        String::from_utf8(writer.into_inner()).expect("the writer was given UTF-8")
    };
    // The last digits of a start value depend on the system's sine and cosine, but one GUID is for all systems.
    let rounded = start_values(table, model, |value| format!("{value:.8e}"))?;
    let guid = identity::guid::<M>(resources, write("", &rounded).as_bytes());
    let xml = write(&guid, &start_values(table, model, |value| real(*value))?);
    Ok(Document { guid, xml })
}

/// Start values as text, one per value reference; `None` where the standard wants none.
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

fn append<M: Model, T: Value>(
    starts: &mut Vec<Option<String>>,
    table: &Table<M>,
    model: &mut M,
    index: usize,
    text: fn(&T) -> String,
) -> Result<(), String> {
    let variable = &table.variables[index];
    let values = table.read::<T>(index, model, &[0.0])?.unwrap_or_default();
    if !variable.has_start() {
        starts.resize(starts.len() + values.len(), None);
        return Ok(());
    }
    variable.check(values, 0).map_err(|error| format!("start value {error}"))?;
    starts.extend(values.iter().map(|value| Some(text(value))));
    Ok(())
}

fn write_document<M: Model>(
    writer: &mut Writer<Vec<u8>>,
    description: &Description,
    table: &Table<M>,
    starts: &[Option<String>],
    guid: &str,
) -> io::Result<()> {
    writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let (number, token) = match table.version {
        Version::Fmi2 => ("2.0", "guid"),
        Version::Fmi3 => ("3.0", "instantiationToken"),
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
            match table.version {
                Version::Fmi2 => fmi2::write_co_simulation::<M>(writer)?,
                Version::Fmi3 => fmi3::write_co_simulation::<M>(writer)?,
            }
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

/// Variables that are there, with their value references.
type Listed<'a, M> = Vec<(&'a Variable<M>, Range<u32>)>;

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

fn write_units<M>(writer: &mut Writer<Vec<u8>>, table: &Table<M>) -> io::Result<()> {
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
                    // displayed = factor · value + offset, with both in base units the same.
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

/// `factor` and `offset` where they are not the default ones.
fn with_conversion(mut element: ElementWriter<'_, Vec<u8>>, factor: f64, offset: f64) -> ElementWriter<'_, Vec<u8>> {
    if factor != 1.0 {
        element = element.with_attribute(("factor", real(factor).as_str()));
    }
    if offset != 0.0 {
        element = element.with_attribute(("offset", real(offset).as_str()));
    }
    element
}

/// The enumerations with their items, by name.
fn enumerations<M>(table: &Table<M>) -> BTreeMap<&str, &[String]> {
    let named = table.variables.iter().filter_map(|variable| variable.enumeration.as_ref());
    named.map(|(name, items)| (name.as_str(), items.as_slice())).collect()
}

/// The items of an enumeration, counted from 1.
fn write_items(writer: &mut Writer<Vec<u8>>, items: &[String]) -> io::Result<()> {
    items.iter().zip(1..).try_for_each(|(item, value): (_, i32)| {
        let element = writer.create_element("Item").with_attribute(("name", item.as_str()));
        element.with_attribute(("value", value.to_string().as_str())).write_empty().map(|_| ())
    })
}

fn write_log_categories(writer: &mut Writer<Vec<u8>>, version: Version) -> io::Result<()> {
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

/// Unit, display unit and nominal value of a Real.
fn with_unit<'a, M>(mut element: ElementWriter<'a, Vec<u8>>, variable: &Variable<M>) -> ElementWriter<'a, Vec<u8>> {
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

/// `min` and `max` where a limit is inclusive; FMI has no words for an exclusive one.
fn with_bounds<'a, M>(mut value: ElementWriter<'a, Vec<u8>>, variable: &Variable<M>) -> ElementWriter<'a, Vec<u8>> {
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

/// The shortest text that reads back to the same number.
fn real(value: f64) -> String {
    format!("{value:?}")
}

fn boolean(value: bool) -> &'static str {
    if value { "true" } else { "false" }
}

impl<M> Variable<M> {
    /// Whether the standard wants a start value.
    fn has_start(&self) -> bool {
        self.initial() == Some("exact") || self.causality == Causality::Input
    }

    fn initial(&self) -> Option<&'static str> {
        match (self.causality, self.variability) {
            (Causality::Parameter, _) | (_, Variability::Constant) => Some("exact"),
            (Causality::Output | Causality::Local | Causality::CalculatedParameter, _) => Some("calculated"),
            (Causality::Input | Causality::Independent, _) => None,
        }
    }
}

impl Causality {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Causality::Parameter => "parameter",
            Causality::CalculatedParameter => "calculatedParameter",
            Causality::Input => "input",
            Causality::Output => "output",
            Causality::Local => "local",
            Causality::Independent => "independent",
        }
    }
}

impl Variability {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Variability::Constant => "constant",
            Variability::Fixed => "fixed",
            Variability::Tunable => "tunable",
            Variability::Discrete => "discrete",
            Variability::Continuous => "continuous",
        }
    }
}

#[cfg(test)]
mod tests {
    use std::slice::from_mut;

    use super::*;
    use crate::log::Log;

    /// A model whose only parameter starts at `start`, in `unit`, and whose output is one value short if `short`.
    struct Probe {
        unit: &'static str,
        start: f64,
        short: bool,
        u: [f64; 2],
        words: [String; 2],
    }

    impl Model for Probe {
        const IDENTIFIER: &'static str = "probe";
        const VERSION: &'static str = "0.1";
        type State = ();

        fn load(_: &Resources) -> Result<Self, String> {
            Ok(PROBE)
        }

        fn description(&self) -> Description {
            Description { model_name: "A & B".into(), text: "<\"probe\">".into(), step: 1e-7, ..Description::default() }
        }

        fn variables(&self) -> Vec<Variable<Self>> {
            type Real = crate::Real<Probe>;
            vec![
                Real::input("u", "m", "", |probe| &mut probe.u).array(2),
                Real::parameter("p", self.unit, "", |probe| from_mut(&mut probe.start)).at_least(0.0).below(9.0),
                crate::Integer::local("mode", "", |_| &[2]).enumeration("Mode", &["off", "on"]).constant(),
                Real::local("T", "degC", "", |_| &[0.0]).display_unit("K").nominal(300.0).discrete(),
                Real::local("area", "m2", "", |_| &[1.0]).display_unit("mm2").calculated_parameter(),
                Real::output("y", "m", "", |probe| if probe.short { &[0.0] } else { &[0.0; 2] })
                    .array(2)
                    .depends_on(&["u"]),
                crate::Text::parameter("words", "", |probe: &mut Probe| &mut probe.words).array(2),
                Real::time(),
            ]
        }

        fn initialise(&mut self, _: f64, _: &Log) -> Result<(), String> {
            Ok(())
        }

        fn step(&mut self, _: f64, _: f64, _: &Log) -> Result<(), String> {
            Ok(())
        }

        fn save(&self) {}

        fn restore(&mut self, (): &()) -> Result<(), String> {
            Ok(())
        }
    }

    const PROBE: Probe =
        Probe { unit: "N/m", start: 1e-7, short: false, u: [0.0, 2.5], words: [const { String::new() }; 2] };

    fn describe(probe: Probe) -> Result<Document, String> {
        describe_for(Version::Fmi2, probe)
    }

    fn describe_for(version: Version, mut probe: Probe) -> Result<Document, String> {
        document(&Table::new(probe.variables(), version)?, &mut probe, &Resources::default())
    }

    #[test]
    fn the_guid_changes_with_units_and_start_values_only() {
        let guid = |probe| describe(probe).unwrap().guid;
        assert_eq!(guid(PROBE), guid(PROBE));
        assert_ne!(guid(PROBE), guid(Probe { unit: "Pa", ..PROBE }));
        assert_ne!(guid(PROBE), guid(Probe { start: 2e-7, ..PROBE }));
        assert_eq!(guid(PROBE), guid(Probe { start: 1e-7 * (1.0 + f64::EPSILON), ..PROBE }), "another sine");
    }

    #[test]
    fn the_guid_is_in_the_text_and_in_braces() {
        let document = describe(PROBE).unwrap();
        assert_eq!(document.guid.len(), 38, "{}", document.guid);
        assert!(document.xml.contains(&format!("guid=\"{}\"", document.guid)), "{}", document.xml);
    }

    #[test]
    fn the_text_holds_what_the_list_says() {
        let xml = describe(PROBE).unwrap().xml;
        for part in [
            "modelName=\"A &amp; B\" ",
            "name=\"u[1]\" valueReference=\"0\"",
            "name=\"y[2]\" valueReference=\"7\"",
            "<Item name=\"on\" value=\"2\"/>",
            "<Enumeration declaredType=\"Mode\" min=\"1\" max=\"2\" start=\"2\"/>",
            "causality=\"calculatedParameter\" variability=\"fixed\" initial=\"calculated\"",
            "<BaseUnit K=\"1\" offset=\"273.15\"/>",
            "<DisplayUnit name=\"K\" offset=\"273.15\"/>",
            "<Real unit=\"degC\" displayUnit=\"K\" nominal=\"300.0\"/>",
            "variability=\"discrete\"",
            "<Real unit=\"N/m\" min=\"0.0\" start=\"1e-7\"/>",
            "<BaseUnit kg=\"1\" s=\"-2\"/>",
            "<Unknown index=\"7\" dependencies=\"1 2\"/>",
            "stepSize=\"1e-7\"",
        ] {
            assert!(xml.contains(part), "no {part} in\n{xml}");
        }
        assert!(!xml.contains("max=\"9"), "an exclusive limit has no place in\n{xml}");
    }

    #[test]
    fn in_fmi_3_an_array_is_one_variable_with_a_dimension() {
        let Document { guid, xml } = describe_for(Version::Fmi3, PROBE).unwrap();
        for part in [
            &format!("fmiVersion=\"3.0\" modelName=\"A &amp; B\" instantiationToken=\"{guid}\""),
            "<Float64 name=\"u\" valueReference=\"0\" description=\"\" causality=\"input\" variability=\"continuous\" \
             declaredType=\"in m\" start=\"0.0 2.5\">\n      <Dimension start=\"2\"/>\n    </Float64>",
            "<Float64Type name=\"in m\" unit=\"m\"/>",
            "<Float64Type name=\"in degC, shown in K, about 300\" unit=\"degC\" displayUnit=\"K\" nominal=\"300.0\"/>",
            "<EnumerationType name=\"Mode\">\n      <Item name=\"off\" value=\"1\"/>",
            "initial=\"exact\" declaredType=\"Mode\" min=\"1\" max=\"2\" start=\"2\"/>",
            "<Dimension start=\"2\"/>\n      <Start value=\"\"/>\n      <Start value=\"\"/>\n    </String>",
            "<BaseUnit K=\"1\" offset=\"273.15\"/>",
            "<Output valueReference=\"6\" dependencies=\"0\"/>",
            "<InitialUnknown valueReference=\"5\"/>",
            "<Float64 name=\"time\" valueReference=\"10\"",
        ] {
            assert!(xml.contains(part), "no {part} in\n{xml}");
        }
        assert_ne!(guid, describe(PROBE).unwrap().guid, "it is another description");
    }

    #[test]
    fn a_wrong_length_is_refused_with_both_numbers() {
        let message = describe(Probe { short: true, ..PROBE }).err().unwrap();
        assert!(message.contains("y: the model gives 1 values, the list declares 2"), "{message}");
    }

    #[test]
    fn a_start_value_outside_its_limits_is_refused() {
        for start in [-1.0, 9.0, f64::NAN] {
            let message = describe(Probe { start, ..PROBE }).err().unwrap();
            assert!(message.contains("start value p = "), "{message}");
        }
    }
}
