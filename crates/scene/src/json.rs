//! The text of a scene file as a tree of values that know their places in the text.
//!
//! The structure of JSON is read here, with bounds on length and depth; each string and number is left to `serde_json`.
//! Numbers that JSON lacks (`NaN`, `Infinity`, `1e999`) stay in the tree, so that they are refused under their keys.

use std::collections::HashMap;

use serde_json::{Map, Number, Value};

use crate::fault::{Fault, Faults, list, shorten};

/// Largest scene file, bytes: a rod of 65536 segments with an angle each takes two megabytes.
pub(crate) const MOST_BYTES: usize = 4 << 20;

/// Most lists and objects inside each other: the keys of a scene are ten deep.
const DEEPEST: usize = 64;

/// Most parts of a list that a fault shows.
const SHOWN_PARTS: usize = 32;

/// A value, and the bytes of the text from its first to its last character.
#[derive(Debug)]
pub(crate) struct Node {
    pub begin: u32,
    pub end: u32,
    pub content: Content,
}

#[derive(Debug)]
pub(crate) enum Content {
    Null,
    Bool(bool),
    Number(Number),
    /// A number that JSON lacks or a double cannot hold.
    Unusable,
    Text(String),
    List(Vec<Node>),
    Object(Vec<Member>),
}

/// A key of an object with its value; `begin` is the place of the key.
#[derive(Debug)]
pub(crate) struct Member {
    pub begin: u32,
    pub name: String,
    pub value: Node,
}

/// Parse a text; a text that is not JSON gives only faults, one with duplicate keys a tree and faults.
pub(crate) fn parse(text: &str, faults: &mut Faults) -> Option<Node> {
    if text.len() > MOST_BYTES {
        let most = MOST_BYTES >> 20;
        let size = text.len() as f64 / (1 << 20) as f64;
        faults.push(Fault::syntax("", format!("the scene has {size:.1} MB, but at most {most} MB are allowed")));
        return None;
    }
    let mut parser = Parser { text, at: 0, depth: 0, path: Vec::new(), faults };
    let tree = parser.document();
    match tree {
        Ok(tree) => Some(tree),
        Err(Stop { at, text: sentence }) => {
            let mut fault = Fault::syntax("", sentence);
            place(text, at, &mut fault);
            faults.push(fault);
            None
        }
    }
}

/// Set line and column of a fault to those of the byte `at`.
pub(crate) fn place(text: &str, at: usize, fault: &mut Fault) {
    let before = &text[..at];
    fault.line = Some(before.matches('\n').count() + 1);
    fault.column = Some(before.chars().rev().take_while(|&c| c != '\n').count() + 1);
}

/// Why and where the text cannot be parsed further.
struct Stop {
    at: usize,
    text: String,
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    /// Names of the open objects' keys, and indices of the open lists' parts.
    path: Vec<String>,
    faults: &'a mut Faults,
}

impl Parser<'_> {
    fn document(&mut self) -> Result<Node, Stop> {
        let tree = self.value()?;
        self.skip_space();
        if self.at < self.text.len() {
            return self.stop("nothing may follow the end of the scene");
        }
        Ok(tree)
    }

    fn stop<T>(&self, text: impl Into<String>) -> Result<T, Stop> {
        Err(Stop { at: self.at, text: format!("not JSON: {}", text.into()) })
    }

    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn skip_space(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\n' | b'\r')) {
            self.at += 1;
        }
    }

    fn value(&mut self) -> Result<Node, Stop> {
        self.skip_space();
        let begin = self.at;
        let content = match self.peek() {
            None => return self.stop("the text ends where a value is expected"),
            Some(b'{') => self.nested(Self::object)?,
            Some(b'[') => self.nested(Self::list)?,
            Some(b'"') => Content::Text(self.string()?),
            Some(b'/' | b'#') => return self.stop("comments are not allowed"),
            Some(b'\'') => return self.stop("texts stand in double quotes"),
            Some(_) => self.word()?,
        };
        Ok(Node { begin: begin as u32, end: self.at as u32, content })
    }

    fn nested(&mut self, parse: fn(&mut Self) -> Result<Content, Stop>) -> Result<Content, Stop> {
        if self.depth == DEEPEST {
            let text = format!("lists and objects are nested more than {DEEPEST} deep");
            return Err(Stop { at: self.at, text });
        }
        self.depth += 1;
        self.at += 1;
        let content = parse(self)?;
        self.depth -= 1;
        Ok(content)
    }

    /// Return whether another part of a list or an object follows.
    fn another(&mut self, close: char) -> Result<bool, Stop> {
        self.skip_space();
        match self.peek().map(char::from) {
            Some(',') => {
                self.at += 1;
                self.skip_space();
                if self.peek().map(char::from) == Some(close) {
                    return self.stop(format!("there is a comma before `{close}`"));
                }
                Ok(true)
            }
            Some(found) if found == close => {
                self.at += 1;
                Ok(false)
            }
            Some(b) if b == '/' || b == '#' => self.stop("comments are not allowed"),
            Some(_) => self.stop(format!("`,` or `{close}` is expected")),
            None => self.stop(format!("the text ends before `{close}`")),
        }
    }

    fn is_closed_by(&mut self, close: u8) -> bool {
        self.skip_space();
        let closed = self.peek() == Some(close);
        self.at += usize::from(closed);
        closed
    }

    fn list(&mut self) -> Result<Content, Stop> {
        let mut parts = Vec::new();
        if self.is_closed_by(b']') {
            return Ok(Content::List(parts));
        }
        loop {
            self.path.push(format!("[{}]", parts.len()));
            parts.push(self.value()?);
            self.path.pop();
            if !self.another(']')? {
                return Ok(Content::List(parts));
            }
        }
    }

    fn object(&mut self) -> Result<Content, Stop> {
        let mut members: Vec<Member> = Vec::new();
        let mut known: HashMap<String, usize> = HashMap::new();
        if self.is_closed_by(b'}') {
            return Ok(Content::Object(members));
        }
        loop {
            self.skip_space();
            let begin = self.at;
            match self.peek() {
                Some(b'"') => (),
                Some(b'/' | b'#') => return self.stop("comments are not allowed"),
                _ => return self.stop("a key in double quotes is expected"),
            }
            let name = self.string()?;
            self.skip_space();
            if self.peek() != Some(b':') {
                return self.stop("`:` is expected after a key");
            }
            self.at += 1;
            self.path.push(if self.path.is_empty() { name.clone() } else { format!(".{name}") });
            let value = self.value()?;
            match known.get(&name) {
                Some(&first) => {
                    let line = self.text[..first].matches('\n').count() + 1;
                    let mut fault = Fault::duplicate(&self.path.concat(), line);
                    place(self.text, begin, &mut fault);
                    self.faults.push(fault);
                }
                None => {
                    known.insert(name.clone(), begin);
                    members.push(Member { begin: begin as u32, name, value });
                }
            }
            self.path.pop();
            if !self.another('}')? {
                return Ok(Content::Object(members));
            }
        }
    }

    fn string(&mut self) -> Result<String, Stop> {
        let bytes = self.rest().as_bytes();
        let mut end = 1;
        while let Some(&byte) = bytes.get(end) {
            match byte {
                b'"' => break,
                b'\\' => end += 2,
                _ => end += 1,
            }
        }
        let Some(token) = self.rest().get(..=end) else {
            return self.stop("a text has no closing quote");
        };
        match serde_json::from_str(token) {
            Ok(text) => {
                self.at += token.len();
                Ok(text)
            }
            Err(_) => self.stop("a text holds an unescaped control character or an invalid escape"),
        }
    }

    /// Read `null`, `true`, `false`, or a number.
    fn word(&mut self) -> Result<Content, Stop> {
        let part_of_word = |c: char| c.is_alphanumeric() || "+-._".contains(c);
        let token = self.rest().split(|c| !part_of_word(c)).next().unwrap_or_default();
        let content = match token {
            "null" => Content::Null,
            "true" => Content::Bool(true),
            "false" => Content::Bool(false),
            "NaN" | "Infinity" | "-Infinity" => Content::Unusable,
            _ => match serde_json::from_str(token) {
                Ok(number) => Content::Number(number),
                Err(_) if is_too_large(token) => Content::Unusable,
                Err(_) if token.is_empty() => return self.stop("a value is expected"),
                Err(_) => return self.stop(format!("`{}` is not a value", shorten(token))),
            },
        };
        self.at += token.len();
        Ok(content)
    }
}

/// Return whether `token` is a number that is too large for a double.
fn is_too_large(token: &str) -> bool {
    token.starts_with(|c: char| c == '-' || c.is_ascii_digit()) && token.parse().is_ok_and(f64::is_infinite)
}

impl Node {
    /// Return the place of the key `key`; of an absent key, the place of the innermost part that should hold it.
    pub fn find(&self, key: &str) -> usize {
        let (mut node, mut begin, mut rest) = (self, self.begin, key);
        while let Some((place, part, after)) = node.step(rest) {
            (begin, node, rest) = (place, part, after);
        }
        begin as usize
    }

    /// Return whether this tree and another agree at `key`: in its value, or in its absence from the same part.
    pub fn agrees_at(&self, other: &Self, key: &str) -> bool {
        let (mut own, mut others, mut rest) = (self, other, key);
        loop {
            match (own.step(rest), others.step(rest)) {
                (Some((_, own_part, after)), Some((_, others_part, _))) => {
                    (own, others, rest) = (own_part, others_part, after)
                }
                (None, None) => return !rest.is_empty() || own.same(others),
                _ => return false,
            }
        }
    }

    /// Follow the first part of a path; return the place and the value there and the rest of the path.
    fn step<'a>(&self, path: &'a str) -> Option<(u32, &Self, &'a str)> {
        match &self.content {
            Content::Object(members) => {
                let path = path.strip_prefix('.').unwrap_or(path);
                let named = |member: &&Member| {
                    let after = path.strip_prefix(member.name.as_str());
                    after.is_some_and(|after| after.is_empty() || after.starts_with(['.', '[']))
                };
                let longest = members.iter().filter(named).max_by_key(|member| member.name.len())?;
                Some((longest.begin, &longest.value, &path[longest.name.len()..]))
            }
            Content::List(parts) => {
                let (index, after) = path.strip_prefix('[')?.split_once(']')?;
                let part = parts.get(index.parse::<usize>().ok()?)?;
                Some((part.begin, part, after))
            }
            _ => None,
        }
    }

    /// Return the value of a key of an object.
    pub fn get(&self, key: &str) -> Option<&Self> {
        let Content::Object(members) = &self.content else { return None };
        members.iter().find(|member| member.name == key).map(|member| &member.value)
    }

    /// Return whether two values are equal, wherever they stand.
    fn same(&self, other: &Self) -> bool {
        match (&self.content, &other.content) {
            (Content::Null, Content::Null) | (Content::Unusable, Content::Unusable) => true,
            (Content::Bool(a), Content::Bool(b)) => a == b,
            (Content::Number(a), Content::Number(b)) => a == b,
            (Content::Text(a), Content::Text(b)) => a == b,
            (Content::List(a), Content::List(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.same(b)),
            (Content::Object(a), Content::Object(b)) => {
                let same = |member: &Member| other.get(&member.name).is_some_and(|value| member.value.same(value));
                a.len() == b.len() && a.iter().all(same)
            }
            _ => false,
        }
    }

    /// Return the value for a sentence: as the text has it, or the keys of an object.
    pub fn shown(&self, text: &str) -> String {
        match &self.content {
            Content::Object(members) if members.is_empty() => "an empty object".into(),
            Content::Object(members) => {
                let keys = if members.len() == 1 { "the key" } else { "the keys" };
                shorten(&format!("an object with {keys} {}", list(members.iter().map(|member| &member.name), "and")))
            }
            Content::List(parts) => {
                let parts: Vec<_> = parts.iter().take(SHOWN_PARTS).map(|part| part.shown(text)).collect();
                shorten(&format!("[{}]", parts.join(", ")))
            }
            _ => shorten(&text[self.begin as usize..self.end as usize]),
        }
    }

    /// Return the tree without places, for the deserialiser.
    pub fn into_value(self) -> Value {
        match self.content {
            Content::Null | Content::Unusable => Value::Null,
            Content::Bool(value) => value.into(),
            Content::Number(number) => number.into(),
            Content::Text(text) => text.into(),
            Content::List(parts) => parts.into_iter().map(Self::into_value).collect(),
            Content::Object(members) => {
                members.into_iter().map(|member| (member.name, member.value.into_value())).collect::<Map<_, _>>().into()
            }
        }
    }
}
