//! The JSON Schema of scene files, from which classes in other languages can be made.
//!
//! The title of a definition or a variant is the name of a class. A variant with fields is an object with one key, its
//! tag: the title of that object joins enum and variant, `TimeLawSine`; the title of its content is the variant,
//! `Sine`.

use schemars::Schema;
use schemars::transform::{RecursiveTransform, Transform};
use serde_json::{Map, Value};

use crate::scene::Scene;

impl Scene {
    /// Return the JSON Schema of scene files, made from these types.
    pub fn json_schema() -> String {
        let mut schema = schemars::schema_for!(Self);
        RecursiveTransform(join_lines).transform(&mut schema);
        if let Some(Value::Object(definitions)) = schema.get_mut("$defs") {
            definitions.iter_mut().for_each(|(name, definition)| add_titles(name, definition));
        }
        serde_json::to_string_pretty(&schema).expect("a schema is plain JSON") + "\n"
    }
}

/// Join the lines of a description, which are lines of the source.
fn join_lines(schema: &mut Schema) {
    if let Some(Value::String(description)) = schema.get_mut("description") {
        *description = description.replace('\n', " ");
    }
}

/// Add titles to the definition `name` and its variants.
fn add_titles(name: &str, definition: &mut Value) {
    set_title(definition, name.into());
    let Some(Value::Array(variants)) = definition.get_mut("oneOf") else { return };
    for variant in variants {
        let tag = match (variant.get("const"), variant.get("properties")) {
            (Some(Value::String(value)), _) => value.clone(),
            (_, Some(Value::Object(properties))) => properties.keys().next().expect("a variant has a tag").clone(),
            _ => unreachable!("scenes have no other variants"),
        };
        let class = class_name(&tag);
        set_title(variant, format!("{name}{class}"));
        let content = variant.pointer_mut(&format!("/properties/{tag}"));
        if let Some(content) = content.filter(|content| content.get("properties").is_some()) {
            set_title(content, class);
        }
    }
}

/// Put a title in front.
fn set_title(schema: &mut Value, title: String) {
    if let Value::Object(entries) = schema {
        let mut titled = Map::from_iter([("title".into(), title.into())]);
        titled.append(entries);
        *entries = titled;
    }
}

/// Return `LogLinear` for `log_linear`.
fn class_name(tag: &str) -> String {
    let capitalised = |word: &str| word[..1].to_uppercase() + &word[1..];
    tag.split('_').map(capitalised).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// `visit` every object that has properties, with its place in the schema; conditions are about those of others.
    fn objects(place: &str, schema: &Value, visit: &mut impl FnMut(&str, &Map<String, Value>)) {
        match schema {
            Value::Object(entries) => {
                if entries.contains_key("properties") {
                    visit(place, entries);
                }
                let parts = entries.iter().filter(|(key, _)| !["if", "then", "else"].contains(&key.as_str()));
                parts.for_each(|(key, part)| objects(&format!("{place}/{key}"), part, visit));
            }
            Value::Array(parts) => {
                parts.iter().enumerate().for_each(|(i, part)| objects(&format!("{place}/{i}"), part, visit));
            }
            _ => (),
        }
    }

    fn schema() -> Value {
        serde_json::from_str(&Scene::json_schema()).unwrap()
    }

    #[test]
    fn every_field_has_a_description_and_is_required_or_has_a_default() {
        objects("#", &schema(), &mut |place, object| {
            let required = |name: &str| object["required"].as_array().unwrap().iter().any(|entry| entry == name);
            let properties = object["properties"].as_object().unwrap();
            for (name, field) in properties {
                let is_tag = place.contains("/oneOf/") && !place.contains("/properties/");
                assert!(is_tag || field.get("description").is_some(), "{place}: `{name}` has no description");
                let optional = object.get("required").is_none() || !required(name);
                assert!(optional == field.get("default").is_some(), "{place}: `{name}` is required or has a default");
            }
        });
    }

    #[test]
    fn every_class_has_a_name_of_its_own() {
        let mut names = BTreeSet::new();
        objects("#", &schema(), &mut |place, object| {
            let title = object.get("title").and_then(Value::as_str).unwrap_or_else(|| panic!("{place} has no title"));
            let usable =
                title.starts_with(|c: char| c.is_ascii_uppercase()) && title.chars().all(char::is_alphanumeric);
            assert!(usable, "{place}: {title} is no name of a class");
            assert!(names.insert(title.to_string()), "{place}: {title} is the name of another class too");
        });
        assert!(names.contains("TimeLawSine") && names.contains("Sine") && names.contains("Reference"), "{names:?}");
    }

    #[test]
    fn defaults_of_the_schema_are_those_of_the_parser() {
        let text = r#"{ "x": { "sine": { "amplitude": 1.0, "frequency": 1.0 } } }"#;
        let parsed: crate::root::RootLaws = serde_json::from_str(text).unwrap();
        let written = serde_json::to_value(&parsed).unwrap();
        let schema = schema();
        let sine = schema["$defs"]["TimeLaw"]["oneOf"]
            .as_array()
            .unwrap()
            .iter()
            .find_map(|variant| variant["properties"].get("sine"))
            .unwrap();
        for name in ["mean", "phase", "ramp"] {
            assert_eq!(sine["properties"][name]["default"], written["x"]["sine"][name], "{name}");
        }
        assert_eq!(schema["$defs"]["RootLaws"]["properties"]["z"]["default"], written["z"]);
    }
}
