//! foreign-master STEP STEPS ROD FLUID LIBRARIES: steps two unpacked FMUs, the rod first, and prints all Real outputs.
//!
//! `LIBRARIES` is the folder of the system under `binaries/`. It runs where the libraries are for: under wine, or under
//! qemu. What it prints is exact, so that another system's can be compared with it.

use std::env::args;
use std::error::Error;
use std::ffi::CString;
use std::fs::{read_dir, read_to_string};
use std::path::Path;

use libloading::Library;
use nervure_fmi_export::sys::*;

use description::{attribute, reals};
use logger::{Messages, callbacks};

#[allow(dead_code, reason = "a program that loads libraries uses a part")]
#[path = "../../../crates/fmi-export/tests/master/description.rs"]
mod description;
#[path = "../../../crates/fmi-export/tests/master/logger.rs"]
mod logger;

/// Types of the functions, under their names.
mod functions {
    #![allow(dead_code, non_camel_case_types)]

    use super::*;

    macro_rules! types {
        ($($name:ident($($argument:ident: $type:ty),*) -> $result:ty;)*) => {
            $(pub type $name = unsafe extern "C" fn($($type),*) -> $result;)*
        };
    }

    nervure_fmi_export::__functions! { types, }
}

type Result<T> = std::result::Result<T, Box<dyn Error>>;

struct Unit {
    library: Library,
    c: fmi2Component,
    messages: Box<Messages>,
    /// Names and references of the Real variables, by causality.
    inputs: Vec<(String, u32)>,
    outputs: Vec<(String, u32)>,
}

impl Unit {
    fn new(folder: &Path, libraries: &str) -> Result<Self> {
        let xml = read_to_string(folder.join("modelDescription.xml"))?;
        let file = read_dir(folder.join("binaries").join(libraries))?.next().ok_or("no library")??;
        // SAFETY: the library is an FMU's, which does nothing when it is loaded.
        let library = unsafe { Library::new(file.path()) }?;
        let resources = folder.join("resources").canonicalize()?.display().to_string();
        // Windows: `\\?\Z:\a` is `/Z:/a`.
        let path = resources.trim_start_matches(r"\\?\").replace('\\', "/");
        let location = CString::new(format!("file://{}{path}", if path.starts_with('/') { "" } else { "/" }))?;
        let guid = CString::new(attribute(&xml, "guid"))?;
        let messages = Box::<Messages>::default();
        // SAFETY: the types are those of the standard's header, the pointers are valid.
        let c = unsafe {
            let instantiate = library.get::<functions::fmi2Instantiate>(b"fmi2Instantiate\0")?;
            let (kind, callbacks) = (fmi2Type::fmi2CoSimulation, callbacks(&messages));
            instantiate(c"unit".as_ptr(), kind, guid.as_ptr(), location.as_ptr(), &callbacks, 0, 0)
        };
        if c.is_null() {
            return Err(format!("no instance: {messages:?}").into());
        }
        let unit = Self { library, c, messages, inputs: reals(&xml, "input"), outputs: reals(&xml, "output") };
        for name in ["fmi2EnterInitializationMode", "fmi2ExitInitializationMode"] {
            // SAFETY: as above; both functions have this type.
            unit.ok(unsafe { unit.library.get::<functions::fmi2ExitInitializationMode>(name.as_bytes())?(c) }, name)?;
        }
        Ok(unit)
    }

    fn ok(&self, status: fmi2Status, what: &str) -> Result<()> {
        match status {
            fmi2Status::fmi2OK => Ok(()),
            _ => Err(format!("{what}: {status:?}, {:?}", self.messages).into()),
        }
    }

    /// The Real outputs by name.
    fn get(&self) -> Result<Vec<(&str, f64)>> {
        let references: Vec<u32> = self.outputs.iter().map(|(_, reference)| *reference).collect();
        let mut values = vec![0.0; references.len()];
        // SAFETY: as above; both arrays have the length that is passed.
        let status = unsafe {
            let get = self.library.get::<functions::fmi2GetReal>(b"fmi2GetReal\0")?;
            get(self.c, references.as_ptr(), references.len(), values.as_mut_ptr())
        };
        self.ok(status, "fmi2GetReal")?;
        Ok(self.outputs.iter().map(|(name, _)| name.as_str()).zip(values).collect())
    }

    /// Set the inputs that have the name of an output of the other unit, and step.
    fn step(&self, given: &[(&str, f64)], t: f64, h: f64) -> Result<()> {
        let taken = given.iter().filter_map(|(name, value)| {
            let (_, reference) = self.inputs.iter().find(|(known, _)| known == name)?;
            Some((*reference, *value))
        });
        let (references, values): (Vec<u32>, Vec<f64>) = taken.unzip();
        // SAFETY: as above.
        let statuses = unsafe {
            let set = self.library.get::<functions::fmi2SetReal>(b"fmi2SetReal\0")?;
            let step = self.library.get::<functions::fmi2DoStep>(b"fmi2DoStep\0")?;
            [set(self.c, references.as_ptr(), references.len(), values.as_ptr()), step(self.c, t, h, 1)]
        };
        statuses.into_iter().try_for_each(|status| self.ok(status, "fmi2DoStep"))
    }
}

fn main() -> Result<()> {
    let arguments: Vec<String> = args().skip(1).collect();
    let [h, steps, rod, fluid, libraries] = &arguments[..] else {
        return Err("usage: foreign-master STEP STEPS ROD FLUID LIBRARIES".into());
    };
    let (h, steps): (f64, u32) = (h.parse()?, steps.parse()?);
    let [rod, fluid] = [rod, fluid].map(|folder| Unit::new(Path::new(folder), libraries));
    let (rod, fluid) = (rod?, fluid?);
    for k in 0..steps {
        let t = f64::from(k) * h;
        rod.step(&fluid.get()?, t, h)?;
        fluid.step(&rod.get()?, t, h)?;
    }
    for (kind, unit) in [("rod", &rod), ("fluid", &fluid)] {
        for (name, value) in unit.get()? {
            println!("{kind}.{name} {value:e}");
        }
    }
    Ok(())
}
