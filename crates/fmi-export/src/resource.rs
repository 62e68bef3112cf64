//! Resources of an FMU: their folder, and the files that define the model.
//!
//! The location in `fmi2Instantiate` is a file URI by the standard; some masters pass a plain path.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::memory::require_memory;

/// Maximum size of a file, bytes. A scene of 65536 segments with an angle each has two megabytes.
const LARGEST_FILE: u64 = 16 << 20;

/// Folder of the resources, and the texts of the files of [`Model::RESOURCES`](crate::Model::RESOURCES) at
/// instantiation.
#[derive(Clone, Debug, Default)]
pub struct Resources {
    folder: Option<PathBuf>,
    files: Vec<(&'static str, String)>,
}

impl Resources {
    /// Read the named files: regular files of at most 16 MB in UTF-8.
    pub fn read(folder: Option<&Path>, names: &[&'static str]) -> Result<Self, String> {
        let Some(folder) = folder else {
            return match names {
                [] => Ok(Self::default()),
                _ => Err(format!("the model needs a resources folder with {}", names.join(", "))),
            };
        };
        let files = names.iter().map(|name| Ok((*name, file(&folder.join(name))?))).collect::<Result<_, String>>()?;
        Ok(Self { folder: Some(folder.to_owned()), files })
    }

    /// Return the folder, if the master named one.
    pub fn folder(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// Return the text of a file of [`Model::RESOURCES`](crate::Model::RESOURCES).
    pub fn text(&self, name: &str) -> Result<&str, String> {
        let file = self.files.iter().find(|(known, _)| *known == name);
        file.map(|(_, text)| text.as_str()).ok_or_else(|| format!("{name} is not a resource of the model"))
    }

    /// Return the paths of the files, for messages.
    pub(crate) fn names(&self) -> String {
        let folder = self.folder.as_deref().unwrap_or(Path::new(""));
        let names: Vec<_> = self.files.iter().map(|(name, _)| folder.join(name).display().to_string()).collect();
        names.join(", ")
    }

    /// Return all files with their names and lengths as bytes.
    pub(crate) fn content(&self) -> Vec<u8> {
        let head = |name: &str, text: &str| format!("{name} {}\n", text.len());
        self.files.iter().flat_map(|(name, text)| [head(name, text).as_str(), text].concat().into_bytes()).collect()
    }
}

/// Return the text of a file; refuse to open pipes and devices, which could block.
fn file(path: &Path) -> Result<String, String> {
    let name = path.display();
    let unreadable = |error: std::io::Error| format!("the resource {name} cannot be read: {error}");
    let about = path.metadata().map_err(unreadable)?;
    if !about.is_file() {
        return Err(format!("the resource {name} is not a regular file"));
    }
    if about.len() > LARGEST_FILE {
        return Err(format!("the resource {name} has {} bytes, but at most {LARGEST_FILE} are allowed", about.len()));
    }
    require_memory(3 * about.len() as usize)?;
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(LARGEST_FILE + 1).read_to_end(&mut bytes)).map_err(unreadable)?;
    if bytes.len() as u64 > LARGEST_FILE {
        return Err(format!("the resource {name} has more than {LARGEST_FILE} bytes"));
    }
    String::from_utf8(bytes).map_err(|error| format!("the resource {name} is not UTF-8: {error}"))
}

/// Return the folder of a location: `file:///a`, `file:/a`, `file://localhost/a` (percent-decoded) or the plain path
/// `/a`.
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

/// Return the text after `file:`, in upper or lower case.
fn strip_scheme(location: &str) -> Option<&str> {
    let (scheme, rest) = location.split_once(':')?;
    scheme.eq_ignore_ascii_case("file").then_some(rest)
}

/// Decode `%20` and the like.
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

/// Return `C:/a` for `/C:/a`.
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
    fn a_resource_that_is_no_regular_file_or_too_large_is_refused_by_name() {
        let folder = std::env::temp_dir().join(format!("resources-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("folder")).unwrap();
        File::create(folder.join("large")).and_then(|file| file.set_len(LARGEST_FILE + 1)).unwrap();
        std::fs::write(folder.join("bytes"), b"\xff").unwrap();
        std::fs::write(folder.join("text"), "a scene").unwrap();
        let named = Resources::read(Some(&folder), &["text"]).unwrap();
        assert_eq!(named.text("text"), Ok("a scene"));
        for (name, part) in
            [("folder", "not a regular file"), ("large", "16777216"), ("bytes", "UTF-8"), ("nothing", "cannot be read")]
        {
            let message = Resources::read(Some(&folder), &[name]).unwrap_err();
            assert!(message.contains(part) && message.contains(name), "{message}");
        }
        #[cfg(unix)]
        {
            let endless = Resources::read(Some(Path::new("/dev")), &["zero"]).unwrap_err();
            assert!(endless.contains("/dev/zero is not a regular file"), "{endless}");
        }
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_location_that_names_no_local_folder_is_refused() {
        for location in ["file://server/a", "file:a", "file:///a%2", "file:///a%zz", "file:///a%ff", "file:///%+1"] {
            let message = folder(location).expect_err(location);
            assert!(message.contains(location), "{message}");
        }
    }
}
