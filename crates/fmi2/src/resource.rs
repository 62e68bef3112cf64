//! The resource location of `fmi2Instantiate`: a file URI, by the standard, or a plain path, in practice.

use std::path::PathBuf;

/// The folder that `location` names: `file:///a`, `file:/a`, `file://localhost/a` (percent-decoded) or `/a` as it is.
pub(crate) fn folder(location: &str) -> Result<PathBuf, String> {
    let Some(rest) = strip_scheme(location) else {
        return Ok(PathBuf::from(location));
    };
    let path = match rest.strip_prefix("//") {
        None => rest,
        Some(after) => after.strip_prefix("localhost").unwrap_or(after),
    };
    if !path.starts_with('/') {
        return Err(format!("resource location {location:?} must name an absolute path on this host"));
    }
    let path = percent_decode(path).ok_or_else(|| format!("resource location {location:?} is not a valid URI"))?;
    Ok(PathBuf::from(without_root_before_drive(&path)))
}

/// What follows `file:`, in any case.
fn strip_scheme(location: &str) -> Option<&str> {
    let (scheme, rest) = location.split_once(':')?;
    scheme.eq_ignore_ascii_case("file").then_some(rest)
}

fn percent_decode(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut pieces = text.split('%');
    bytes.extend(pieces.next()?.bytes());
    for piece in pieces {
        let hex = piece.get(..2).filter(|hex| hex.bytes().all(|b| b.is_ascii_hexdigit()))?;
        bytes.push(u8::from_str_radix(hex, 16).ok()?);
        bytes.extend(piece[2..].bytes());
    }
    String::from_utf8(bytes).ok()
}

/// `/C:/a` is `C:/a`.
fn without_root_before_drive(path: &str) -> &str {
    match path.as_bytes() {
        [b'/', drive, b':', ..] if drive.is_ascii_alphabetic() => &path[1..],
        _ => path,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling_of_a_folder_is_understood() {
        for (location, expected) in [
            ("file:///a/resources", "/a/resources"),
            ("file:/a/resources", "/a/resources"),
            ("file://localhost/a/resources", "/a/resources"),
            ("FILE:///a", "/a"),
            ("file:///a%20b/%C3%A9%25/", "/a b/é%/"),
            ("file:///C:/a", "C:/a"),
            ("/a b%20c", "/a b%20c"),
            ("C:\\a", "C:\\a"),
        ] {
            assert_eq!(folder(location), Ok(PathBuf::from(expected)), "{location}");
        }
    }

    #[test]
    fn a_location_that_names_no_local_folder_is_refused() {
        for location in ["file://server/a", "file:a", "file:///a%2", "file:///a%zz", "file:///a%ff", "file:///%+1"] {
            let message = folder(location).expect_err(location);
            assert!(message.contains(location), "{message}");
        }
    }
}
