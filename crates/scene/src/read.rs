//! From the text of a scene file to a checked scene, or to its faults.

use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::conform::{self, RENAMED};
use crate::fault::{Fault, FaultKind, Faults, SceneError, join};
use crate::json::{self, Content, Node};
use crate::relations;
use crate::scene::{FORMAT, Scene};

/// The scene of the last text whose scene was [kept]. A run asks a library for facts, a description, an instance and,
/// again and again, warnings of one text. What only makes instances keeps nothing, for a library that is unloaded would
/// lose it.
static LAST: Mutex<Option<Known>> = Mutex::new(None);

/// A scene without faults.
struct Known {
    text: String,
    scene: Scene,
    /// Its facts as JSON, once they were wanted.
    facts: Option<String>,
}

/// Return the last scene, if it is that of a text.
fn last<'a>(last: &'a mut MutexGuard<Option<Known>>, text: &str) -> Option<&'a mut Known> {
    last.as_mut().filter(|known| known.text == text)
}

fn lock() -> MutexGuard<'static, Option<Known>> {
    LAST.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Return the scene of a text without faults, and keep it.
pub(crate) fn kept(text: &str) -> Option<Scene> {
    let scene = read(text).ok()?;
    let mut kept = lock();
    if last(&mut kept, text).is_none() {
        *kept = Some(Known { text: text.into(), scene: scene.clone(), facts: None });
    }
    Some(scene)
}

impl Scene {
    /// Read and check a scene file.
    ///
    /// # Errors
    /// The file cannot be read, or the scene has faults.
    pub fn from_file(path: &Path) -> Result<Self, SceneError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| SceneError::Read { path: path.display().to_string(), source })?;
        Self::from_json(&text)
    }

    /// Parse and check the text of a scene file.
    ///
    /// # Errors
    /// The scene has faults. Unknown and missing keys, types and ranges are listed together; contradictions only where
    /// there are no such faults.
    pub fn from_json(text: &str) -> Result<Self, SceneError> {
        read(text).map_err(|(tree, faults)| SceneError::Faults(placed(text, tree.as_ref(), None, faults)))
    }

    /// Check every value again, after a change.
    ///
    /// # Errors
    /// The scene has faults.
    pub fn check(&self) -> Result<(), SceneError> {
        let text = serde_json::to_string(self).expect("a scene is plain JSON");
        read(&text).map(|_| ()).map_err(|(_, faults)| SceneError::Faults(faults.into_list()))
    }
}

/// Check the text of a scene and return its faults as a JSON list, empty for a scene that can be run.
///
/// `original` is the file before some of its values were changed, such as by options of a command. Places are those in
/// the original, and a fault of a changed value has none.
pub fn check_text(text: &str, original: Option<&str>) -> String {
    let faults = match read(text) {
        Ok(_) => Vec::new(),
        Err((tree, faults)) => placed(text, tree.as_ref(), original, faults),
    };
    serde_json::to_string(&faults).expect("faults are plain JSON")
}

/// Return the facts of a scene as a JSON object, or `null` for a scene with faults.
pub fn facts_text(text: &str) -> String {
    let Some(scene) = kept(text) else { return "null".into() };
    if let Some(facts) = last(&mut lock(), text).and_then(|known| known.facts.clone()) {
        return facts;
    }
    let facts = serde_json::to_string(&scene.facts()).expect("facts are plain JSON");
    if let Some(known) = last(&mut lock(), text) {
        known.facts = Some(facts.clone());
    }
    facts
}

/// Return the scene of a text, which is parsed and checked where it is not the kept one; the faults of a refused scene
/// come with its tree, if the text is JSON.
fn read(text: &str) -> Result<Scene, (Option<Node>, Faults)> {
    let known = last(&mut lock(), text).map(|known| known.scene.clone());
    known.map_or_else(|| parse(text), Ok)
}

fn parse(text: &str) -> Result<Scene, (Option<Node>, Faults)> {
    let mut faults = Faults::default();
    let Some(tree) = json::parse(text, &mut faults) else { return Err((None, faults)) };
    if faults.len() == 0 {
        check_tree(text, &tree, &mut faults);
    }
    if faults.len() > 0 {
        return Err((Some(tree), faults));
    }
    let mut scene: Scene = match serde_json::from_value(tree.into_value()) {
        Ok(scene) => scene,
        Err(error) => {
            faults.push(Fault::syntax("", format!("the scene cannot be read: {error}")));
            return Err((None, faults));
        }
    };
    scene.follow_flyer();
    relations::check(&scene, &mut faults);
    if faults.len() == 0 { Ok(scene) } else { Err((json::parse(text, &mut Faults::default()), faults)) }
}

/// Check format, keys, types and ranges of a tree.
fn check_tree(text: &str, tree: &Node, faults: &mut Faults) {
    let Content::Object(_) = tree.content else {
        let value = tree.shown(text);
        return faults.push(Fault::syntax("", format!("a scene is an object in braces, not {value}")));
    };
    let schema = schemars::schema_for!(Scene).to_value();
    let mut found = Faults::default();
    conform::check(text, tree, &schema, &mut found);
    let other_format = tree.get("format").and_then(|node| match &node.content {
        Content::Number(number) if number.as_f64() != Some(f64::from(FORMAT)) => number.as_f64(),
        _ => None,
    });
    let Some(format) = other_format else { return *faults = found };
    faults.push(format_fault(format));
    // Of a file of another format only the renamed keys are worth a word.
    let renamed = |fault: &Fault| {
        let name = fault.key.rsplit('.').next();
        fault.kind == FaultKind::Unknown && RENAMED.iter().any(|(old, _)| name == Some(*old))
    };
    found.into_list().into_iter().filter(renamed).for_each(|fault| faults.push(fault));
}

fn format_fault(format: f64) -> Fault {
    let remedy = if format < f64::from(FORMAT) {
        let renamed: Vec<_> = RENAMED.iter().map(|(old, new)| format!("`{old}` to `{new}`")).collect();
        format!("rename {}, and set `format` to {FORMAT}; CHANGELOG.md lists the changes", join(&renamed, "and"))
    } else {
        "install a newer nervure".into()
    };
    let text = format!("`format` is {format}, but this version reads format {FORMAT}: {remedy}");
    Fault::format(&format.to_string(), &FORMAT.to_string(), text)
}

/// Return the faults with their places in the text, or in the `original` of a changed text.
fn placed(text: &str, tree: Option<&Node>, original: Option<&str>, faults: Faults) -> Vec<Fault> {
    let mut list = faults.into_list();
    let before = original.and_then(|original| Some((original, json::parse(original, &mut Faults::default())?)));
    for fault in &mut list {
        let Some(tree) = tree else { continue };
        match &before {
            None if fault.line.is_none() => json::place(text, tree.find(&fault.key), fault),
            Some((original, before)) => {
                (fault.line, fault.column) = (None, None);
                if before.agrees_at(tree, &fault.key) {
                    json::place(original, before.find(&fault.key), fault);
                }
            }
            None => (),
        }
    }
    list
}
