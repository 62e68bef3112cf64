//! The tree of a scene against the JSON Schema: unknown and missing keys, types and ranges, all in one pass.
//!
//! Types and ranges stand once, in the attributes of the scene's types, from which the schema is made. Contradictions
//! between keys are left to [`relations`](crate::relations).

use std::fmt;

use serde_json::Value;

use crate::fault::{Fault, Faults, join, list};
use crate::json::{Content, Member, Node};

/// Keys of format 1 that have other names in format 2, old and new.
pub(crate) const RENAMED: [(&str, &str); 6] = [
    ("e_fold", "decay_length_cells"),
    ("target", "wall_correction"),
    ("clamp_setback", "clamp_compliance_length"),
    ("pressure_level", "axial_pressure_strain"),
    ("steady", "constant"),
    ("quiet_power", "min_power"),
];

/// Add what the schema does not allow in `tree`, the tree of `text`.
pub(crate) fn check(text: &str, tree: &Node, schema: &Value, faults: &mut Faults) {
    Checker { text, definitions: &schema["$defs"], faults }.check("", tree, schema);
}

struct Checker<'a> {
    text: &'a str,
    definitions: &'a Value,
    faults: &'a mut Faults,
}

impl<'a> Checker<'a> {
    fn check(&mut self, key: &str, node: &Node, schema: &'a Value) {
        if matches!(node.content, Content::Null) && may_be_null(schema) || self.faults.are_full() {
            return;
        }
        let whole = schema;
        let schema = resolve_for(self.definitions, node, schema);
        if let Some(Value::Array(variants)) = schema.get("oneOf") {
            return self.check_variant(key, node, whole, variants);
        }
        if !types(schema).any(|name| is_a(name, node)) {
            let allowed = allowed(self.definitions, whole);
            return self.faults.push(Fault::type_of(key, &node.shown(self.text), &allowed, ""));
        }
        match &node.content {
            Content::Number(number) => {
                let limits = range(schema);
                if !number.as_f64().is_some_and(|number| limits.includes(number)) {
                    self.faults.push(Fault::range(key, &node.shown(self.text), limits.to_string().trim_start()));
                }
            }
            Content::List(parts) => {
                let limits = range_of(schema, "minItems", "maxItems");
                if !limits.includes(parts.len() as f64) {
                    let allowed = allowed(self.definitions, whole);
                    return self.faults.push(Fault::length(key, parts.len(), &allowed));
                }
                for (i, part) in parts.iter().enumerate() {
                    if self.faults.are_full() {
                        return;
                    }
                    self.check(&format!("{key}[{i}]"), part, &schema["items"]);
                }
            }
            Content::Object(members) => self.check_object(key, members, schema),
            _ => (),
        }
    }

    fn check_object(&mut self, key: &str, members: &[Member], schema: &'a Value) {
        let below = |name: &str| if key.is_empty() { name.to_string() } else { format!("{key}.{name}") };
        let Some(Value::Object(properties)) = schema.get("properties") else {
            for Member { name, value, .. } in members {
                self.check(&below(name), value, &schema["additionalProperties"]);
            }
            return;
        };
        let known: Vec<_> = properties.keys().map(String::as_str).collect();
        for name in required(schema) {
            if !members.iter().any(|member| member.name == name) {
                let allowed = allowed(self.definitions, &properties[name]);
                self.faults.push(Fault::missing(&below(name), &allowed));
            }
        }
        for Member { name, value, .. } in members {
            if self.faults.are_full() {
                return;
            }
            match properties.get(name) {
                Some(schema) => self.check(&below(name), value, schema),
                None => self.faults.push(unknown(&below(name), name, &known)),
            }
        }
    }

    /// Check a word of several, or an object with one of several keys.
    fn check_variant(&mut self, key: &str, node: &Node, whole: &'a Value, variants: &'a [Value]) {
        let contents = || variants.iter().filter_map(|variant| variant.get("properties")?.as_object()?.iter().next());
        if let Content::Object(members) = &node.content
            && let [Member { name, value, .. }] = members.as_slice()
        {
            let key = format!("{key}.{name}");
            let content = contents().find(|(known, _)| *known == name);
            let known: Vec<_> = contents().map(|(name, _)| name.as_str()).collect();
            match content {
                Some((_, content)) => return self.check(&key, value, content),
                None if !known.is_empty() => return self.faults.push(unknown(&key, name, &known)),
                None => (),
            }
        }
        // A variant with more keys than its tag.
        let untagged = variants.iter().find(|variant| {
            let properties = variant.get("properties").and_then(Value::as_object);
            let tag = properties.filter(|properties| properties.len() > 1).and_then(|found| found.keys().next());
            matches!(&node.content, Content::Object(members) if members.iter().any(|own| Some(&own.name) == tag))
        });
        if let (Some(variant), Content::Object(members)) = (untagged, &node.content) {
            return self.check_object(key, members, variant);
        }
        let words: Vec<_> = variants.iter().filter_map(|variant| variant.get("const")?.as_str()).collect();
        let text = if let Content::Text(text) = &node.content { text.as_str() } else { "" };
        if words.contains(&text) {
            return;
        }
        let (is_number, shown) = (matches!(node.content, Content::Number(_)), node.shown(self.text));
        let number = contents().find(|(_, content)| is_number && types(content).any(|name| name == "number"));
        let hint = match (number, similar(text, &words)) {
            (Some((name, _)), _) => format!("; write {{\"{name}\": {shown}}}"),
            (_, Some(word)) => format!("; did you mean \"{word}\"?"),
            _ => String::new(),
        };
        self.faults.push(Fault::type_of(key, &shown, &allowed(self.definitions, whole), &hint));
    }
}

/// Return the fault of the unknown key `name`, whose path is `key`, among `known` ones.
fn unknown(key: &str, name: &str, known: &[&str]) -> Fault {
    let all = list(known, "and");
    let hint = match (successor(name, known), similar(name, known)) {
        (Some(new), _) => format!("it is called `{new}` since format 2"),
        (_, Some(near)) => format!("did you mean `{near}`?"),
        _ if known.len() == 1 => format!("the only key here is {all}"),
        _ => format!("the keys here are {all}"),
    };
    Fault::unknown(key, &all, &hint)
}

/// Return the new name of a renamed key, if it is `known`.
fn successor(name: &str, known: &[&str]) -> Option<&'static str> {
    RENAMED.into_iter().find(|(old, new)| *old == name && known.contains(new)).map(|(_, new)| new)
}

/// Return the known name that `name` most probably means: at most a third of its letters differ.
fn similar<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let (distance, near) = known.iter().map(|near| (edit_distance(name, near), *near)).min()?;
    (3 * distance <= name.chars().count().max(3)).then_some(near)
}

/// Return the least number of letters to insert, remove, replace or swap with their neighbours (Damerau 1964).
fn edit_distance(a: &str, b: &str) -> usize {
    let [a, b] = [a, b].map(|text| text.chars().take(64).collect::<Vec<_>>());
    let mut rows = vec![(0..=b.len()).collect::<Vec<_>>()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let replaced = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = replaced.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(rows[i - 2][j - 2] + 1);
            }
            row.push(least);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

/// Return the schema that `schema` refers to; where null is allowed too, the other one.
fn resolve<'a>(definitions: &'a Value, schema: &'a Value) -> &'a Value {
    if let Some(Value::String(reference)) = schema.get("$ref") {
        let name = reference.rsplit('/').next().expect("a split has a part");
        return &definitions[name];
    }
    match schema.get("anyOf") {
        Some(either) if may_be_null(schema) => resolve(definitions, &either[0]),
        _ => schema,
    }
}

/// Return the schema that `schema` refers to for this value: that of objects, of lists, or that of numbers or words.
fn resolve_for<'a>(definitions: &'a Value, node: &Node, schema: &'a Value) -> &'a Value {
    let schema = resolve(definitions, schema);
    let Some(Value::Array(either)) = schema.get("anyOf") else { return schema };
    let (is_object, is_list) = (matches!(node.content, Content::Object(_)), matches!(node.content, Content::List(_)));
    let mut parts = either.iter().map(|part| resolve(definitions, part));
    let takes_lists = |part: &Value| types(part).any(|name| name == "array");
    parts.find(|part| takes_objects(part) == is_object && takes_lists(part) == is_list).unwrap_or(schema)
}

/// Return whether a value of `schema` is an object: with properties, or with one of several keys.
fn takes_objects(schema: &Value) -> bool {
    let variants = schema.get("oneOf").and_then(Value::as_array).into_iter().flatten();
    variants.chain([schema]).any(|part| part.get("properties").is_some())
}

/// Return the values that `schema` allows, for "must be …".
fn allowed(definitions: &Value, schema: &Value) -> String {
    let schema = resolve(definitions, schema);
    if let Some(Value::Array(either)) = schema.get("anyOf") {
        return join(&either.iter().map(|part| allowed(definitions, part)).collect::<Vec<_>>(), "or");
    }
    if let Some(Value::Array(variants)) = schema.get("oneOf") {
        let words = variants.iter().filter_map(|variant| Some(variant.get("const")?.to_string()));
        let keys = variants.iter().filter_map(|variant| variant.get("properties")?.as_object()?.keys().next());
        let mut choices: Vec<_> = words.collect();
        match keys.collect::<Vec<_>>().as_slice() {
            [] => (),
            [key] => choices.push(format!("an object with the key `{key}`")),
            several => choices.push(format!("an object with one of the keys {}", list(several, "and"))),
        }
        return join(&choices, "or");
    }
    let limits = range(schema);
    let names = types(schema).map(|name| match name {
        "integer" if limits.is_one_number() => limits.least.unwrap_or_default().to_string(),
        "number" => format!("a number{limits}"),
        "integer" => format!("a whole number{limits}"),
        "string" => "a text in quotes".into(),
        "boolean" => "true or false".into(),
        "array" => format!("a list of {}", elements(definitions, schema)),
        "object" => match required(schema).collect::<Vec<_>>().as_slice() {
            [] => "an object".into(),
            keys => format!("an object with {}", list(keys, "and")),
        },
        other => other.into(),
    });
    names.collect::<Vec<_>>().join(" or ")
}

/// Return the number and kind of the elements of a list.
fn elements(definitions: &Value, schema: &Value) -> String {
    let part = resolve(definitions, &schema["items"]);
    let name = match types(part).next() {
        Some("number") => "numbers",
        Some("integer") => "whole numbers",
        Some("array") => "lists",
        _ => "objects",
    };
    match (schema.get("minItems"), schema.get("maxItems")) {
        (Some(least), Some(most)) if least == most => format!("{least} {name}{}", range(part)),
        (Some(least), Some(most)) => format!("{least} to {most} {name}"),
        (Some(least), None) => format!("at least {least} {name}"),
        (None, Some(most)) => format!("at most {most} {name}"),
        (None, None) => name.into(),
    }
}

/// Limits of a number.
#[derive(Clone, Copy, Default)]
struct Range {
    least: Option<f64>,
    most: Option<f64>,
    above: Option<f64>,
    below: Option<f64>,
}

fn range(schema: &Value) -> Range {
    let limit = |name: &str| schema.get(name).and_then(Value::as_f64);
    let mut range = Range {
        above: limit("exclusiveMinimum"),
        below: limit("exclusiveMaximum"),
        ..range_of(schema, "minimum", "maximum")
    };
    if range.most.is_none() && schema.get("format").is_some_and(|format| format == "uint32") {
        range.most = Some(u32::MAX.into());
    }
    range
}

fn range_of(schema: &Value, least: &str, most: &str) -> Range {
    let limit = |name: &str| schema.get(name).and_then(Value::as_f64);
    Range { least: limit(least), most: limit(most), ..Range::default() }
}

impl Range {
    fn is_one_number(self) -> bool {
        self.least.is_some() && self.least == self.most
    }

    fn includes(self, number: f64) -> bool {
        self.least.is_none_or(|limit| number >= limit)
            && self.most.is_none_or(|limit| number <= limit)
            && self.above.is_none_or(|limit| number > limit)
            && self.below.is_none_or(|limit| number < limit)
    }
}

/// As the end of "a number …", with a space in front; empty without limits.
impl fmt::Display for Range {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        if let (Some(least), Some(most)) = (self.least, self.most) {
            return write!(formatter, " from {least} to {most}");
        }
        let limits = [(">", self.above), (">=", self.least), ("<", self.below), ("<=", self.most)];
        let texts: Vec<_> = limits.into_iter().filter_map(|(sign, limit)| Some(format!("{sign} {}", limit?))).collect();
        if texts.is_empty() { Ok(()) } else { write!(formatter, " {}", texts.join(" and ")) }
    }
}

fn types(schema: &Value) -> impl Iterator<Item = &str> {
    let (one, several) = match schema.get("type") {
        Some(Value::Array(names)) => (None, names.as_slice()),
        Some(name) => (name.as_str(), [].as_slice()),
        None => (None, [].as_slice()),
    };
    one.into_iter().chain(several.iter().filter_map(Value::as_str))
}

fn required(schema: &Value) -> impl Iterator<Item = &str> {
    schema.get("required").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str)
}

fn may_be_null(schema: &Value) -> bool {
    let either = schema.get("anyOf").and_then(Value::as_array).into_iter().flatten();
    either.chain([schema]).any(|part| types(part).any(|name| name == "null"))
}

/// Return whether a value has the type that JSON Schema calls `name`; a whole number is written without a point.
fn is_a(name: &str, node: &Node) -> bool {
    match (name, &node.content) {
        ("integer", Content::Number(number)) => number.is_u64() || number.is_i64(),
        ("number", Content::Number(_))
        | ("string", Content::Text(_))
        | ("boolean", Content::Bool(_))
        | ("array", Content::List(_))
        | ("object", Content::Object(_))
        | ("null", Content::Null) => true,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Keywords that the checker enforces, that are left to the types, and that only describe.
    const ENFORCED: &str = "$ref anyOf oneOf const type properties required additionalProperties items minItems \
                            maxItems minimum maximum exclusiveMinimum exclusiveMaximum format";
    const ELSEWHERE: &str = "pattern if then else";
    const DESCRIBING: &str = "$schema $defs title description default";

    #[test]
    fn no_keyword_of_the_schema_goes_unchecked() {
        fn visit(schema: &Value, known: &[&str]) {
            let Value::Object(entries) = schema else { return };
            for (word, part) in entries {
                assert!(known.contains(&word.as_str()), "the checker does not know `{word}`");
                match word.as_str() {
                    "properties" | "$defs" => part.as_object().unwrap().values().for_each(|part| visit(part, known)),
                    "oneOf" | "anyOf" => part.as_array().unwrap().iter().for_each(|part| visit(part, known)),
                    "items" | "additionalProperties" => visit(part, known),
                    "format" => assert!(["double", "uint", "uint32"].contains(&part.as_str().unwrap()), "{part}"),
                    _ => (),
                }
            }
        }
        let known: Vec<_> =
            [ENFORCED, ELSEWHERE, DESCRIBING].iter().flat_map(|words| words.split_whitespace()).collect();
        visit(&schemars::schema_for!(crate::scene::Scene).to_value(), &known);
    }

    #[test]
    fn every_limit_of_a_number_is_in_the_sentence() {
        for (schema, expected) in [
            (r#"{"exclusiveMinimum": 0.0}"#, " > 0"),
            (r#"{"minimum": 2}"#, " >= 2"),
            (r#"{"minimum": 8, "maximum": 65536}"#, " from 8 to 65536"),
            (r#"{"exclusiveMinimum": 0.0, "maximum": 0.6}"#, " > 0 and <= 0.6"),
            (r#"{"exclusiveMinimum": -1.0, "exclusiveMaximum": 0.5}"#, " > -1 and < 0.5"),
            ("{}", ""),
        ] {
            let schema: Value = serde_json::from_str(schema).unwrap();
            assert_eq!(range(&schema).to_string(), expected);
        }
    }

    #[test]
    fn a_name_is_similar_to_what_was_probably_meant() {
        let known = ["density", "kinematic_viscosity", "box", "x"];
        for (name, expected) in [
            ("densty", Some("density")),
            ("dnesity", Some("density")),
            ("kinematic viscosity", Some("kinematic_viscosity")),
            ("bocks", None),
            ("colour", None),
        ] {
            assert_eq!(similar(name, &known), expected, "{name}");
        }
    }
}
