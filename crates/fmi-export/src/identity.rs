//! GUID, or instantiation token in FMI 3.0, which binds library, resources and model description to each other.
//!
//! | bytes | digest of |
//! |---|---|
//! | 0 – 3 | identifier, version and state layout of the library |
//! | 4 – 11 | resources that define the model (less the six fixed bits of a UUID) |
//! | 12 – 15 | the model description |
//!
//! Library and resources are known before a model is loaded, so a foreign description is refused early, with the
//! reason.

use uuid::Uuid;

use crate::model::Model;
use crate::resource::Resources;

/// Length of a GUID as text, `{8-4-4-4-12}`.
pub(crate) const LENGTH: usize = 38;

/// Hexadecimal digits of the three parts.
const PARTS: [std::ops::Range<usize>; 3] = [0..8, 8..24, 24..32];

/// Return the GUID of a model description, written without a GUID.
pub(crate) fn guid<M: Model>(resources: &Resources, description: &[u8]) -> String {
    let mut bytes = [0; 16];
    bytes[..4].copy_from_slice(&digest(maker::<M>().as_bytes())[..4]);
    bytes[4..12].copy_from_slice(&digest(&resources.content())[..8]);
    bytes[12..].copy_from_slice(&digest(description)[..4]);
    Uuid::new_v8(bytes).braced().to_string()
}

/// Return identifier, version and state layout of the library.
pub(crate) fn maker<M: Model>() -> String {
    format!("{} {} (state layout {})", M::IDENTIFIER, M::VERSION, M::STATE_LAYOUT)
}

/// Refuse the GUID of another library or of other resources, before a model is loaded.
pub(crate) fn check_origin<M: Model>(theirs: &str, resources: &Resources) -> Result<(), String> {
    let own = guid::<M>(resources, &[]);
    match difference(theirs, &own) {
        Some(Difference::Form) => Err(format!("the GUID {theirs:?} does not have the form {own}")),
        Some(Difference::Library) => Err(format!("the GUID {theirs} belongs to another library than {}", maker::<M>())),
        Some(Difference::Resources) => Err(format!(
            "the GUID {theirs} belongs to other resources: {} changed after the FMU was packed",
            resources.names()
        )),
        Some(Difference::Description) | None => Ok(()),
    }
}

/// First part in which two GUIDs differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Difference {
    /// The text is not a GUID.
    Form,
    Library,
    Resources,
    Description,
}

/// Return the first difference between `theirs` and a GUID of this library.
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
