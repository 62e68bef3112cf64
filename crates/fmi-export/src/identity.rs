//! The GUID, in FMI 3.0 the instantiation token: what library, resources and model description belong together.
//!
//! | bytes | digest of |
//! |---|---|
//! | 0 – 3 | the library: identifier, version and layout of its state |
//! | 4 – 11 | the files in the resources that decide what the model is (less six bits that every UUID has) |
//! | 12 – 15 | the model description |
//!
//! The first two are known before a model is loaded, so that a foreign description is refused before that, by name.

use uuid::Uuid;

use crate::model::Model;
use crate::resource::Resources;

/// Length of a GUID as text, `{8-4-4-4-12}`.
pub(crate) const LENGTH: usize = 38;

/// Hexadecimal digits of the parts.
const PARTS: [std::ops::Range<usize>; 3] = [0..8, 8..24, 24..32];

/// The GUID of a model description, which was written without one.
pub(crate) fn guid<M: Model>(resources: &Resources, description: &[u8]) -> String {
    let mut bytes = [0; 16];
    bytes[..4].copy_from_slice(&digest(maker::<M>().as_bytes())[..4]);
    bytes[4..12].copy_from_slice(&digest(&resources.content())[..8]);
    bytes[12..].copy_from_slice(&digest(description)[..4]);
    Uuid::new_v8(bytes).braced().to_string()
}

/// Identifier, version and state layout of the library.
pub(crate) fn maker<M: Model>() -> String {
    format!("{} {} (layout {} of its state)", M::IDENTIFIER, M::VERSION, M::STATE_LAYOUT)
}

/// Refuses the GUID of another library or of other resources, before a model is loaded.
pub(crate) fn check_origin<M: Model>(theirs: &str, resources: &Resources) -> Result<(), String> {
    let own = guid::<M>(resources, &[]);
    match difference(theirs, &own) {
        Some(Difference::Form) => Err(format!("the GUID {theirs:?} is not of the form {own}")),
        Some(Difference::Library) => Err(format!("the GUID {theirs} is not one of this library, {}", maker::<M>())),
        Some(Difference::Resources) => Err(format!(
            "the GUID {theirs} belongs to other resources: {} is not what the FMU was made with",
            resources.names()
        )),
        Some(Difference::Description) | None => Ok(()),
    }
}

/// The first part in which two GUIDs differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Difference {
    /// It is none at all.
    Form,
    Library,
    Resources,
    Description,
}

/// In what `theirs` differs first from a GUID of ours.
pub(crate) fn difference(theirs: &str, own: &str) -> Option<Difference> {
    let digits = |guid: &str| {
        let text = guid.strip_prefix('{')?.strip_suffix('}')?;
        Uuid::try_parse(text).ok().filter(|_| guid.len() == LENGTH).map(|uuid| uuid.simple().to_string())
    };
    let Some((theirs, own)) = digits(theirs).zip(digits(own)) else { return Some(Difference::Form) };
    let differences = [Difference::Library, Difference::Resources, Difference::Description];
    PARTS
        .into_iter()
        .zip(differences)
        .find_map(|(part, difference)| (theirs[part.clone()] != own[part]).then_some(difference))
}

fn digest(content: &[u8]) -> [u8; 16] {
    Uuid::new_v5(&Uuid::NAMESPACE_OID, content).into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: &str = "{01234567-89ab-8def-8123-456789abcdef}";

    #[test]
    fn the_first_part_that_differs_is_named() {
        for (theirs, expected) in [
            (OWN, None),
            ("{91234567-89ab-8def-8123-456789abcde0}", Some(Difference::Library)),
            ("{01234567-89ab-8def-8123-556789abcde0}", Some(Difference::Resources)),
            ("{01234567-79ab-8def-8123-456789abcdef}", Some(Difference::Resources)),
            ("{01234567-89ab-8def-8123-456789abcdee}", Some(Difference::Description)),
            ("01234567-89ab-8def-8123-456789abcdef", Some(Difference::Form)),
            ("", Some(Difference::Form)),
        ] {
            assert_eq!(difference(theirs, OWN), expected, "{theirs}");
        }
    }
}
