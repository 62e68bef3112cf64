//! What is wrong with a scene, as data: key, place, value, what is allowed, and a sentence.

use std::fmt;

use serde::Serialize;

/// Most faults that are listed for one scene.
const MOST_FAULTS: usize = 20;

/// Most characters of a number in a sentence: as many as 17 digits, a point and leading zeros of a thousandth need.
const MOST_DIGITS: usize = 21;

/// Most characters of a value that a fault shows.
const SHOWN: usize = 60;

/// The kind of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// The text is not JSON, is too long or too deeply nested, or is not an object.
    Syntax,
    /// A key appears twice in one object.
    Duplicate,
    /// The scene has another format than this version reads.
    Format,
    /// A key that no scene has at this place.
    Unknown,
    /// A required key that is absent.
    Missing,
    /// A value of the wrong type, or a word that is not one of the choices.
    Type,
    /// A number, or the length of a list, out of range.
    Range,
    /// A value that contradicts another part of the scene.
    Conflict,
}

/// One reason why a scene cannot be run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fault {
    /// Kind of the fault.
    pub kind: FaultKind,
    /// Path of the key, e.g. `fluid.cylinders[0].radius`; empty for the whole file.
    pub key: String,
    /// Line in the text, from 1; absent where the key is not in the text.
    pub line: Option<usize>,
    /// Column in the line, in characters from 1.
    pub column: Option<usize>,
    /// The value as the text has it, or a summary of it; absent where there is none.
    pub value: Option<String>,
    /// Values or keys that are allowed; absent where the sentence alone says what to do.
    pub allowed: Option<String>,
    /// The whole as a sentence without the place.
    pub text: String,
}

impl Fault {
    fn new(kind: FaultKind, key: &str, text: String) -> Self {
        Self { kind, key: key.into(), line: None, column: None, value: None, allowed: None, text }
    }

    fn with(mut self, value: Option<&str>, allowed: &str) -> Self {
        self.value = value.map(str::to_string);
        self.allowed = Some(allowed.into());
        self
    }

    /// Report that the text is not JSON that a scene could be; `text` is the sentence.
    pub(crate) fn syntax(key: &str, text: String) -> Self {
        Self::new(FaultKind::Syntax, key, text)
    }

    /// Report that the key `key` appears again after `line`.
    pub(crate) fn duplicate(key: &str, line: usize) -> Self {
        Self::new(FaultKind::Duplicate, key, format!("duplicate key `{key}`: line {line} has it already"))
    }

    /// Report that the scene has the format `value`; `text` is the sentence.
    pub(crate) fn format(value: &str, allowed: &str, text: String) -> Self {
        Self::new(FaultKind::Format, "format", text).with(Some(value), allowed)
    }

    /// Report that the key `key` is unknown; `hint` names a likely one, or else the known ones.
    pub(crate) fn unknown(key: &str, known: &str, hint: &str) -> Self {
        Self::new(FaultKind::Unknown, key, format!("unknown key `{key}`: {hint}")).with(None, known)
    }

    /// Report that the required key `key` is absent.
    pub(crate) fn missing(key: &str, allowed: &str) -> Self {
        Self::new(FaultKind::Missing, key, format!("missing required key `{key}` ({allowed})")).with(None, allowed)
    }

    /// Report that the value of `key` has the wrong type; `hint` follows the sentence.
    pub(crate) fn type_of(key: &str, value: &str, allowed: &str, hint: &str) -> Self {
        let text = format!("`{key}` must be {allowed}, not {value}{hint}");
        Self::new(FaultKind::Type, key, text).with(Some(value), allowed)
    }

    /// Report that the value of `key` is out of range.
    pub(crate) fn range(key: &str, value: &str, allowed: &str) -> Self {
        let text = format!("`{key}` is out of range: {value} is not {allowed}");
        Self::new(FaultKind::Range, key, text).with(Some(value), allowed)
    }

    /// Report that the list `key` has a wrong number of parts.
    pub(crate) fn length(key: &str, count: usize, allowed: &str) -> Self {
        let value = format!("a list of {count}");
        let text = format!("`{key}` must be {allowed}, not {value}");
        Self::new(FaultKind::Range, key, text).with(Some(&value), allowed)
    }

    /// Report that the value of `key` contradicts another part of the scene.
    pub(crate) fn conflict(key: &str, value: &str, reason: &str) -> Self {
        Self::new(FaultKind::Conflict, key, format!("`{key}` is {value}, but {reason}")).with(Some(value), reason)
    }

    /// Report that the value of `key` has an effect that is not allowed; `effect` and `reason` end the sentence.
    pub(crate) fn consequence(key: &str, effect: &str, reason: &str) -> Self {
        Self::new(FaultKind::Conflict, key, format!("`{key}` {effect}, {reason}")).with(None, reason)
    }

    /// Report that the key `key` contradicts another part of the scene by being present.
    pub(crate) fn superfluous(key: &str, reason: &str) -> Self {
        Self::new(FaultKind::Conflict, key, format!("`{key}` is not allowed here: {reason}")).with(None, reason)
    }

    /// Report that the key `key` is absent, and another part of the scene needs it.
    pub(crate) fn needed(key: &str, reason: &str) -> Self {
        Self::new(FaultKind::Conflict, key, format!("`{key}` is missing: {reason}")).with(None, reason)
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        if let (Some(line), Some(column)) = (self.line, self.column) {
            write!(formatter, "line {line}, column {column}: ")?;
        }
        formatter.write_str(&self.text)
    }
}

/// The faults of a scene in the order in which they were found.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    list: Vec<Fault>,
}

impl Faults {
    /// Add a fault; beyond the most that are listed, none is added.
    pub fn push(&mut self, fault: Fault) {
        if self.list.len() < MOST_FAULTS {
            let Fault { value, allowed, text, .. } = &fault;
            let [value, allowed] = [value, allowed].map(|part| part.as_deref().map(legible));
            self.list.push(Fault { value, allowed, text: legible(text), ..fault });
        }
    }

    /// Add [`Fault::conflict`] unless `holds`, and return `holds`.
    pub fn require(
        &mut self,
        holds: bool,
        key: &str,
        value: impl fmt::Display,
        reason: impl FnOnce() -> String,
    ) -> bool {
        if !holds {
            self.push(Fault::conflict(key, &shorten(&value.to_string()), &reason()));
        }
        holds
    }

    /// Add [`Fault::superfluous`] if the key is `present`, and return whether it is not.
    pub fn forbid(&mut self, present: bool, key: &str, reason: impl FnOnce() -> String) -> bool {
        if present {
            self.push(Fault::superfluous(key, &reason()));
        }
        !present
    }

    /// Refuse a file of nodes and triangles, which no unit reads.
    pub fn refuse_file(&mut self, key: &str, file: &str) {
        self.require(false, key, format!("{file:?}"), || {
            "only `nervure` reads files: the units need `nodes` and `triangles`".into()
        });
    }

    /// Check that a vector has a direction: the square of its length is a normal number.
    pub fn direction(&mut self, key: &str, vector: &[f64]) -> bool {
        let squared: f64 = vector.iter().map(|part| part * part).sum();
        self.require(squared.is_normal(), key, format!("{vector:?}"), || {
            "it must have a length from 1e-150 to 1e150".into()
        })
    }

    /// Check that an interval has a positive length.
    pub fn interval(&mut self, key: &str, [low, high]: [f64; 2]) -> bool {
        self.require(low < high, key, format!("[{low}, {high}]"), || "the first number must be the smaller".into())
    }

    /// Return whether as many faults were found as are listed.
    pub fn are_full(&self) -> bool {
        self.list.len() == MOST_FAULTS
    }

    /// Return the number of faults.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Return the list.
    pub fn into_list(self) -> Vec<Fault> {
        self.list
    }
}

/// A part of a scene whose values are checked against each other; types and ranges were checked before.
pub(crate) trait Check {
    /// Add what is wrong with the part, which is the value of `key`.
    fn check_at(&self, key: &str, faults: &mut Faults);
}

impl<T: Check> Check for Option<T> {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        if let Some(part) = self {
            part.check_at(key, faults);
        }
    }
}

impl<T: Check> Check for Vec<T> {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        for (i, part) in self.iter().enumerate() {
            part.check_at(&format!("{key}[{i}]"), faults);
        }
    }
}

/// Why a scene was refused.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file could not be read.
    #[error("cannot read the scene file {path}: {source}")]
    Read {
        /// Path of the file.
        path: String,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The scene has faults, at least one.
    #[error("{}", sentences(.0))]
    Faults(Vec<Fault>),
}

/// Return the faults as one text.
fn sentences(faults: &[Fault]) -> String {
    let each: Vec<_> = faults.iter().map(|fault| format!("scene: {fault}")).collect();
    each.join("\n")
}

/// Return the text with powers of ten in place of numbers of many digits; names and quoted texts stay.
pub(crate) fn legible(text: &str) -> String {
    let is_part = |letter: char| letter.is_alphanumeric() || matches!(letter, '.' | '_' | '"' | '…');
    let mut rest = text;
    let mut result = String::with_capacity(text.len());
    while let Some(begin) = rest.find(is_part) {
        let (before, from) = rest.split_at(begin);
        let (word, behind) = from.split_at(from.find(|letter| !is_part(letter)).unwrap_or(from.len()));
        let digits = word.trim_end_matches('.');
        let is_long = digits.len() > MOST_DIGITS && digits.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
        result.push_str(before);
        match digits.parse::<f64>().ok().filter(|number| is_long && number.is_finite()) {
            Some(number) => result.extend([&format!("{number:e}"), &word[digits.len()..]]),
            None => result.push_str(word),
        }
        rest = behind;
    }
    result + rest
}

/// Return at most the first characters of `text`.
pub(crate) fn shorten(text: &str) -> String {
    let text = &legible(text);
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.into(),
    }
}

/// Return the names of keys in a sentence, `` `a`, `b` and `c` ``.
pub(crate) fn list(names: impl IntoIterator<Item = impl fmt::Display>, word: &str) -> String {
    join(&names.into_iter().map(|name| format!("`{name}`")).collect::<Vec<_>>(), word)
}

/// Return `a, b and c`.
pub(crate) fn join(parts: &[String], word: &str) -> String {
    match parts {
        [] => String::new(),
        [only] => only.clone(),
        [parts @ .., last] => format!("{} {word} {last}", parts.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::legible;

    #[test]
    fn numbers_of_many_digits_are_powers_of_ten_and_names_stay() {
        for (number, sentence) in [(1e300, "x is [-1e300, 3]."), (1e-300, "x is [-1e-300, 3].")] {
            assert_eq!(legible(&format!("x is [-{number}, 3].")), sentence);
        }
        assert_eq!(legible(&format!("it ends at {}.", 1e30)), "it ends at 1e30.");
        for same in
            ["0.0012345678901234567", "`a_123456789012345678901234`", "\"123456789012345678901234\"", "1.5e-7, é"]
        {
            assert_eq!(legible(same), same);
        }
    }
}
