//! Tests of the text of model descriptions and of their GUIDs.

use std::slice::from_mut;

use super::*;
use crate::instance::{load, load_described};
use crate::log::Log;

/// A model whose only parameter starts at `start`, in `unit`, and whose input is one value short if `short`.
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

    fn build(&mut self) -> Result<(), String> {
        Err("there is no solver".into())
    }

    fn description(&self) -> Description {
        Description { model_name: "A & B".into(), text: "<\"probe\">".into(), step: 1e-7, ..Description::default() }
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        type Real = crate::Real<Probe>;
        vec![
            Real::input("u", "m", "", |probe| &mut probe.u[..if probe.short { 1 } else { 2 }]).array(2),
            Real::parameter("p", self.unit, "", |probe| from_mut(&mut probe.start)).at_least(0.0).below(9.0),
            crate::Integer::local("mode", "", |_| &[2]).enumeration("Mode", &["off", "on"]).constant(),
            Real::local("T", "degC", "", |_| &[0.0]).display_unit("K").nominal(300.0).discrete(),
            Real::local("area", "m2", "", |_| &[1.0]).display_unit("mm2").calculated_parameter(),
            Real::output("y", "m", "", |_| &[0.0; 2]).array(2).depends_on(&["u"]),
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
    assert!(message.contains("u: the model returns 1 values, the list declares 2"), "{message}");
}

#[test]
fn a_start_value_outside_its_limits_is_refused() {
    for start in [-1.0, 9.0, f64::NAN] {
        let message = describe(Probe { start, ..PROBE }).err().unwrap();
        assert!(message.contains("start value p = "), "{message}");
    }
}

#[test]
fn a_description_needs_no_solver_and_an_instance_does() {
    let (_, _, Document { guid, .. }) = load::<Probe>(&Resources::default(), Version::Fmi2).unwrap();
    let message = load_described::<Probe>(None, &guid, Version::Fmi2).err().unwrap();
    assert_eq!(message, "there is no solver");
}
