//! foreign-master STEP STEPS ROD FLUID LIBRARIES: steps two unpacked FMUs, the rod first, and prints all Real outputs.
//!
//! `LIBRARIES` is the folder of the system under `binaries/`. It runs where the libraries are for: under wine, or under
//! qemu. What it prints is exact, so that another system's can be compared with it.

use std::env::args;
use std::error::Error;
use std::ffi::{CString, c_char};
use std::fs::{read_dir, read_to_string};
use std::path::Path;
use std::ptr::null_mut;

use fmi_export::sys::*;
use libloading::Library;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

struct Unit {
    library: Library,
    c: fmi2Component,
    /// Names and references of the Real variables, by causality.
    inputs: Vec<(String, u32)>,
    outputs: Vec<(String, u32)>,
}

type Log = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String);
type VariadicLog = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);

unsafe extern "C" fn log(
    _: fmi2ComponentEnvironment,
    _: fmi2String,
    _: fmi2Status,
    _: fmi2String,
    message: *const c_char,
) {
    // SAFETY: the message is a string by the standard.
    eprintln!("{}", unsafe { std::ffi::CStr::from_ptr(message) }.to_string_lossy());
}

fn attribute(text: &str, name: &str) -> Option<String> {
    let (_, rest) = text.split_once(&format!(" {name}=\""))?;
    Some(rest.split_once('"')?.0.to_owned())
}

fn ok(status: fmi2Status, what: &str) -> Result<()> {
    if status == fmi2Status::fmi2OK { Ok(()) } else { Err(format!("{what}: {status:?}").into()) }
}

impl Unit {
    fn new(folder: &Path, libraries: &str) -> Result<Self> {
        let text = read_to_string(folder.join("modelDescription.xml"))?;
        let variables = text.split("<ScalarVariable").skip(1).filter(|text| text.contains("<Real"));
        let of = |causality: &str| {
            let chosen = variables.clone().filter(|text| attribute(text, "causality").as_deref() == Some(causality));
            let pairs =
                chosen.map(|text| Some((attribute(text, "name")?, attribute(text, "valueReference")?.parse().ok()?)));
            pairs.collect::<Option<Vec<_>>>().ok_or("a variable without name or reference")
        };
        let (inputs, outputs) = (of("input")?, of("output")?);
        let file = read_dir(folder.join("binaries").join(libraries))?.next().ok_or("no library")??;
        // SAFETY: the library is an FMU's, which does nothing when it is loaded.
        let library = unsafe { Library::new(file.path()) }?;
        let resources = folder.join("resources").canonicalize()?.display().to_string();
        // Windows: `\\?\Z:\a` is `/Z:/a`.
        let path = resources.trim_start_matches(r"\\?\").replace('\\', "/");
        let location = CString::new(format!("file://{}{path}", if path.starts_with('/') { "" } else { "/" }))?;
        let guid = CString::new(attribute(&text, "guid").ok_or("no GUID")?)?;
        let callbacks = fmi2CallbackFunctions {
            // SAFETY: as in `crates/fmi-export/tests/c_interface.rs`: no variadic argument is ever passed.
            logger: Some(unsafe { std::mem::transmute::<Log, VariadicLog>(log) }),
            allocateMemory: None,
            freeMemory: None,
            stepFinished: None,
            componentEnvironment: null_mut(),
        };
        let callbacks = Box::leak(Box::new(callbacks));
        // SAFETY: the types are those of the standard's header, the pointers are valid.
        let c = unsafe {
            let instantiate = library.get::<fmi2InstantiateTYPE>(b"fmi2Instantiate\0")?.ok_or("no function")?;
            let kind = fmi2Type::fmi2CoSimulation;
            instantiate(c"unit".as_ptr(), kind, guid.as_ptr(), location.as_ptr(), callbacks, 0, 0)
        };
        if c.is_null() {
            return Err("no instance".into());
        }
        let unit = Self { library, c, inputs, outputs };
        for name in ["fmi2EnterInitializationMode", "fmi2ExitInitializationMode"] {
            // SAFETY: as above.
            let status = unsafe {
                let function = unit.library.get::<fmi2EnterInitializationModeTYPE>(name.as_bytes())?.ok_or(name)?;
                function(c)
            };
            ok(status, name)?;
        }
        Ok(unit)
    }

    /// The Real outputs by name.
    fn get(&self) -> Result<Vec<(&str, f64)>> {
        let references: Vec<u32> = self.outputs.iter().map(|(_, reference)| *reference).collect();
        let mut values = vec![0.0; references.len()];
        // SAFETY: as above; both arrays have the length that is passed.
        let status = unsafe {
            let get = self.library.get::<fmi2GetRealTYPE>(b"fmi2GetReal\0")?.ok_or("no function")?;
            get(self.c, references.as_ptr(), references.len(), values.as_mut_ptr())
        };
        ok(status, "fmi2GetReal")?;
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
            let set = self.library.get::<fmi2SetRealTYPE>(b"fmi2SetReal\0")?.ok_or("no function")?;
            let step = self.library.get::<fmi2DoStepTYPE>(b"fmi2DoStep\0")?.ok_or("no function")?;
            [set(self.c, references.as_ptr(), references.len(), values.as_ptr()), step(self.c, t, h, 1)]
        };
        statuses.into_iter().try_for_each(|status| ok(status, "fmi2DoStep"))
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
