//! The text of a scene as a tree, and the tree against the JSON Schema.
//!
//! Types and ranges stand once, in the attributes of the scene's types: the schema is made from them, and what is
//! checked here is that schema. What relates several keys to each other is checked by the types themselves.

use std::fmt;
use std::sync::LazyLock;

use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

use crate::check::require;
use crate::{Scene, SceneError};

/// Most characters of a value that a message shows.
const SHOWN: usize = 60;

/// The tree of a JSON text; a key that is there twice is an error, which [`Value`] itself does not see.
pub(crate) fn parse(text: &str) -> Result<Value, SceneError> {
    let mut deserializer = serde_json::Deserializer::from_str(text);
    let tree: Tree = serde_path_to_error::deserialize(&mut deserializer)
        .map_err(|e| SceneError::Parse { key: e.path().to_string(), source: e.into_inner() })?;
    deserializer.end().map_err(|source| SceneError::Parse { key: ".".into(), source })?;
    Ok(tree.0)
}

struct Tree(Value);

impl<'de> Deserialize<'de> for Tree {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TreeVisitor).map(Self)
    }
}

struct TreeVisitor;

impl<'de> Visitor<'de> for TreeVisitor {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_str<E>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut parts: A) -> Result<Value, A::Error> {
        let mut list = Vec::new();
        while let Some(Tree(part)) = parts.next_element()? {
            list.push(part);
        }
        Ok(list.into())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut parts: A) -> Result<Value, A::Error> {
        let mut object = Map::new();
        while let Some(name) = parts.next_key::<String>()? {
            if object.contains_key(&name) {
                return Err(A::Error::custom(format_args!(
                    "the key `{name}` is there twice, but it may be there once"
                )));
            }
            let Tree(part) = parts.next_value()?;
            object.insert(name, part);
        }
        Ok(object.into())
    }
}

/// Check types and ranges; the first value that the schema does not allow is the error.
pub(crate) fn check(tree: &Value) -> Result<(), SceneError> {
    static SCHEMA: LazyLock<Value> = LazyLock::new(|| schemars::schema_for!(Scene).to_value());
    Checker { definitions: &SCHEMA["$defs"] }.check("", tree, &SCHEMA)
}

struct Checker<'a> {
    definitions: &'a Value,
}

impl<'a> Checker<'a> {
    /// What `schema` refers to; where it may be null as well, what it is else.
    fn resolve(&self, schema: &'a Value) -> &'a Value {
        if let Some(Value::String(reference)) = schema.get("$ref") {
            let name = reference.rsplit('/').next().expect("a split has a part");
            return &self.definitions[name];
        }
        match schema.get("anyOf") {
            Some(either) if may_be_null(schema) => self.resolve(&either[0]),
            _ => schema,
        }
    }

    /// What `schema` refers to for this value: of a number or an object that which it is.
    fn resolve_for(&self, value: &Value, schema: &'a Value) -> &'a Value {
        let schema = self.resolve(schema);
        let Some(Value::Array(either)) = schema.get("anyOf") else { return schema };
        let is_object = |part: &&Value| part.get("oneOf").is_some();
        let parts = || either.iter().map(|part| self.resolve(part));
        if value.is_object() { parts().find(is_object) } else { parts().find(|part| !is_object(part)) }
            .unwrap_or(schema)
    }

    fn check(&self, key: &str, value: &Value, schema: &'a Value) -> Result<(), SceneError> {
        if value.is_null() && may_be_null(schema) {
            return Ok(());
        }
        let whole = schema;
        let schema = self.resolve_for(value, schema);
        if let Some(Value::Array(variants)) = schema.get("oneOf") {
            return self.check_variant(key, value, schema, variants);
        }
        let fits = types(schema).any(|name| is_a(name, value)) && range(schema).includes(value);
        require(fits, key, shown(value), || format!("it must be {}", self.allowed(whole)))?;
        match value {
            Value::Array(parts) => {
                let wanted = range_of(schema, "minItems", "maxItems").includes(&parts.len().into());
                require(wanted, key, shown(value), || format!("it must be {}", self.allowed(schema)))?;
                let check = |(i, part)| self.check(&format!("{key}[{i}]"), part, &schema["items"]);
                parts.iter().enumerate().try_for_each(check)
            }
            Value::Object(parts) => self.check_object(key, parts, schema),
            _ => Ok(()),
        }
    }

    /// Unknown keys first: a key that is missing may be there under a wrong name.
    fn check_object(&self, key: &str, parts: &Map<String, Value>, schema: &'a Value) -> Result<(), SceneError> {
        let below = |name: &str| if key.is_empty() { name.to_string() } else { format!("{key}.{name}") };
        let Some(Value::Object(properties)) = schema.get("properties") else {
            let check = |(name, part): (&String, _)| self.check(&below(name), part, &schema["additionalProperties"]);
            return parts.iter().try_for_each(check);
        };
        for name in parts.keys() {
            require(properties.contains_key(name), &below(name), "not known", || {
                format!("the keys here are {}", list(properties.keys(), "and"))
            })?;
        }
        for name in required(schema) {
            require(parts.contains_key(name), &below(name), "missing", || {
                format!("it must be {}", self.allowed(&properties[name]))
            })?;
        }
        parts.iter().try_for_each(|(name, part)| self.check(&below(name), part, &properties[name]))
    }

    /// A word of several, or an object with one of several keys.
    fn check_variant(
        &self,
        key: &str,
        value: &Value,
        schema: &'a Value,
        variants: &'a [Value],
    ) -> Result<(), SceneError> {
        let content = |name: &str| variants.iter().find_map(|variant| variant.get("properties")?.get(name));
        if let Value::Object(parts) = value
            && let (1, Some((name, part))) = (parts.len(), parts.iter().next())
            && let Some(content) = content(name)
        {
            return self.check(&format!("{key}.{name}"), part, content);
        }
        let known = variants.iter().any(|variant| variant.get("const") == Some(value));
        require(known, key, shown(value), || {
            let numbers = variants.iter().filter_map(|variant| variant.get("properties")?.as_object()?.iter().next());
            let hint = numbers
                .filter(|(_, content)| value.is_number() && types(content).any(|name| name == "number"))
                .map(|(name, _)| format!(", here {{\"{name}\": {}}}", shown(value)));
            format!("it must be {}{}", self.allowed(schema), hint.collect::<String>())
        })
    }

    /// What `schema` allows, as the end of the sentence "it must be …".
    fn allowed(&self, schema: &'a Value) -> String {
        let schema = self.resolve(schema);
        if let Some(Value::Array(either)) = schema.get("anyOf") {
            return join(&either.iter().map(|part| self.allowed(part)).collect::<Vec<_>>(), "or");
        }
        if let Some(Value::Array(variants)) = schema.get("oneOf") {
            let words = variants.iter().filter_map(|variant| Some(variant.get("const")?.to_string()));
            let keys = variants.iter().filter_map(|variant| variant.get("properties")?.as_object()?.keys().next());
            let mut choices: Vec<_> = words.collect();
            match keys.collect::<Vec<_>>().as_slice() {
                [] => (),
                [key] => choices.push(format!("an object with the key `{key}`")),
                several => choices.push(format!("an object with just one of the keys {}", list(several, "and"))),
            }
            return join(&choices, "or");
        }
        let limits = range(schema);
        let names = types(schema).map(|name| match name {
            "number" => format!("a number{limits}"),
            "integer" => format!("a whole number{limits}"),
            "string" => "a text in quotes".into(),
            "boolean" => "true or false".into(),
            "array" => format!("a list of {}", self.elements(schema)),
            "object" => match required(schema).collect::<Vec<_>>().as_slice() {
                [] => "an object".into(),
                keys => format!("an object with {}", list(keys, "and")),
            },
            other => other.into(),
        });
        names.collect::<Vec<_>>().join(", or ")
    }

    /// How many of what a list has.
    fn elements(&self, schema: &'a Value) -> String {
        let part = self.resolve(&schema["items"]);
        let name = match types(part).next() {
            Some("number") => "numbers",
            Some("integer") => "whole numbers",
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
}

/// Limits of a number.
#[derive(Clone, Copy)]
struct Range {
    least: Option<f64>,
    most: Option<f64>,
    above: Option<f64>,
    below: Option<f64>,
}

fn range(schema: &Value) -> Range {
    let limit = |name: &str| schema.get(name).and_then(Value::as_f64);
    Range {
        above: limit("exclusiveMinimum"),
        below: limit("exclusiveMaximum"),
        ..range_of(schema, "minimum", "maximum")
    }
}

fn range_of(schema: &Value, least: &str, most: &str) -> Range {
    let limit = |name: &str| schema.get(name).and_then(Value::as_f64);
    Range { least: limit(least), most: limit(most), above: None, below: None }
}

impl Range {
    /// Whether `value` lies within, or is no number.
    fn includes(self, value: &Value) -> bool {
        let Some(number) = value.as_f64() else { return true };
        self.least.is_none_or(|limit| number >= limit)
            && self.most.is_none_or(|limit| number <= limit)
            && self.above.is_none_or(|limit| number > limit)
            && self.below.is_none_or(|limit| number < limit)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        if let (Some(least), Some(most)) = (self.least, self.most) {
            return write!(formatter, " between {least} and {most}");
        }
        let limits =
            [("above", self.above), ("of at least", self.least), ("below", self.below), ("at most", self.most)];
        let told = limits.into_iter().filter_map(|(word, limit)| Some(format!("{word} {}", limit?)));
        let told: Vec<_> = told.collect();
        if told.is_empty() { Ok(()) } else { write!(formatter, " {}", told.join(" and ")) }
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

/// Whether `value` is of the type that JSON Schema calls `name`; a whole number is written without a point.
fn is_a(name: &str, value: &Value) -> bool {
    match name {
        "number" => value.is_number(),
        "integer" => value.is_u64() || value.is_i64(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        "null" => value.is_null(),
        _ => false,
    }
}

/// A value as a message shows it.
fn shown(value: &Value) -> String {
    let text = match value {
        Value::Number(number) if number.is_f64() => format!("{:?}", number.as_f64().expect("it is one")),
        Value::Array(parts) => format!("[{}]", parts.iter().map(shown).collect::<Vec<_>>().join(", ")),
        Value::Object(parts) if parts.is_empty() => "an empty object".into(),
        Value::Object(parts) if parts.len() == 1 => format!("an object with the key {}", list(parts.keys(), "and")),
        Value::Object(parts) => format!("an object with the keys {}", list(parts.keys(), "and")),
        other => other.to_string(),
    };
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// Names of keys in a sentence.
fn list(names: impl IntoIterator<Item = impl fmt::Display>, word: &str) -> String {
    join(&names.into_iter().map(|name| format!("`{name}`")).collect::<Vec<_>>(), word)
}

/// `a, b and c`.
fn join(parts: &[String], word: &str) -> String {
    match parts {
        [] => String::new(),
        [only] => only.clone(),
        [parts @ .., last] => format!("{} {word} {last}", parts.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the checker enforces, what needs a look at several keys or words, and what only tells.
    const ENFORCED: &str = "$ref anyOf oneOf const type properties required additionalProperties items minItems maxItems \
                            minimum maximum exclusiveMinimum exclusiveMaximum";
    const ELSEWHERE: &str = "pattern if then else";
    const TELLING: &str = "$schema $defs title description default format";

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
                    _ => (),
                }
            }
        }
        let known: Vec<_> = [ENFORCED, ELSEWHERE, TELLING].iter().flat_map(|words| words.split_whitespace()).collect();
        visit(&schemars::schema_for!(Scene).to_value(), &known);
    }

    #[test]
    fn every_limit_of_a_number_is_in_the_sentence() {
        for (schema, expected) in [
            (r#"{"exclusiveMinimum": 0.0}"#, " above 0"),
            (r#"{"minimum": 2}"#, " of at least 2"),
            (r#"{"minimum": 8, "maximum": 65536}"#, " between 8 and 65536"),
            (r#"{"exclusiveMinimum": 0.0, "maximum": 0.6}"#, " above 0 and at most 0.6"),
            (r#"{"exclusiveMinimum": -1.0, "exclusiveMaximum": 0.5}"#, " above -1 and below 0.5"),
            ("{}", ""),
        ] {
            let schema: Value = serde_json::from_str(schema).unwrap();
            assert_eq!(range(&schema).to_string(), expected);
        }
    }

    #[test]
    fn a_key_that_is_there_twice_is_refused() {
        let refused = parse("{\"a\": {\"b\": 1,\n \"b\": 2}}").unwrap_err().to_string();
        assert!(
            refused.contains("`a`") && refused.contains("`b` is there twice") && refused.contains("line 2"),
            "{refused}"
        );
    }

    /// CSM1 with some of its text replaced, as it is refused.
    fn refused(old: &str, new: &str) -> String {
        let text = include_str!("../../../scenes/csm1.json");
        assert!(text.contains(old), "{old} is not in the scene");
        Scene::from_json(&text.replace(old, new)).unwrap_err().to_string()
    }

    #[test]
    fn wrong_values_are_told_in_words_of_people() {
        let end = r#""end": 4.0"#;
        for (old, new, expected) in [
            (end, r#""end": 0.0"#, "`time.end` is 0.0, but it must be a number above 0"),
            (end, r#""end": "late""#, "`time.end` is \"late\", but it must be a number above 0"),
            (end, r#""end": [1.0, -2.5e-9]"#, "`time.end` is [1.0, -2.5e-9], but it must be a number above 0"),
            (
                end,
                r#""finish": 4.0"#,
                "`time.finish` is not known, but the keys here are `end` and `communication_step`",
            ),
            (r#""segments": 64"#, r#""segments": 64.5"#, "is 64.5, but it must be a whole number between 2 and 65536"),
            (
                r#""segments": 64"#,
                r#""segments": 1e300"#,
                "is 1e300, but it must be a whole number between 2 and 65536",
            ),
            (
                r#""root": { "at": {"#,
                r#""root": { "on": {"#,
                "an object with just one of the keys `on_cylinder` and `at`",
            ),
            (r#""gravity": [0.0, -2.0]"#, r#""gravity": [0, 0, 0, 0]"#, "it must be a list of at most 3 numbers"),
            (
                r#"{ "end": 4.0, "communication_step": 5e-3 }"#,
                "[4.0, 5e-3]",
                "`time` is [4.0, 0.005], but it must be an object",
            ),
            (
                r#""poisson_ratio": 0.4, "#,
                "",
                "`rod.material.plane_strain.poisson_ratio` is missing, but it must be a number",
            ),
        ] {
            let message = refused(old, new);
            assert!(message.contains(expected), "{message}, but expected {expected}");
        }
    }
}
