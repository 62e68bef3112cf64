//! `fmi-master STEP STEPS UNIT.fmu …`: makes STEPS communication steps of STEP seconds from t = 0 and prints every Real output
//! of every unit as `index name value`.
//!
//! The units step in the order given, each with the newest outputs of the others: with the rod first, our explicit scheme.

use std::collections::HashMap;
use std::error::Error;

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, InstanceCS};
use fmi::fmi2::schema::{Causality, ScalarVariableElement};
use fmi::traits::FmiImport;

type Outcome<T> = Result<T, Box<dyn Error>>;

struct Unit {
    instance: InstanceCS,
    /// Names and value references of the Real inputs.
    inputs: Vec<(String, u32)>,
    /// Names of the Real outputs, their value references, and what they were when last fetched.
    outputs: Vec<String>,
    references: Vec<u32>,
    values: Vec<f64>,
    /// The unpacked FMU, which has to stay as long as the instance.
    _files: Fmi2Import,
}

impl Unit {
    /// The FMU at `path`, in initialization mode.
    fn new(path: &str) -> Outcome<Self> {
        let files: Fmi2Import = fmi::import::from_path(path)?;
        let named = |causality: Causality| -> Vec<(String, u32)> {
            let variables = files.model_description().get_model_variables();
            variables
                .filter(|v| v.causality == causality && matches!(v.elem, ScalarVariableElement::Real(_)))
                .map(|v| (v.name.clone(), v.value_reference))
                .collect()
        };
        let inputs = named(Causality::Input);
        let (outputs, references): (Vec<_>, Vec<_>) = named(Causality::Output).into_iter().unzip();
        let mut instance = files.instantiate_cs("unit", false, false)?;
        instance.setup_experiment(None, 0.0, None)?;
        instance.enter_initialization_mode()?;
        Ok(Unit { instance, inputs, values: vec![0.0; references.len()], outputs, references, _files: files })
    }

    fn get(&mut self) -> Outcome<()> {
        self.instance.get_real(&self.references, &mut self.values)?;
        Ok(())
    }
}

/// Hands unit `target` those inputs that another unit has as outputs.
fn set(units: &mut [Unit], target: usize) -> Outcome<()> {
    let others = units.iter().enumerate().filter(|(i, _)| *i != target).map(|(_, unit)| unit);
    let offered: HashMap<&str, f64> =
        others.flat_map(|unit| unit.outputs.iter().map(String::as_str).zip(unit.values.iter().copied())).collect();
    let given = units[target].inputs.iter().filter_map(|(name, vr)| Some((*vr, *offered.get(name.as_str())?)));
    let (references, values): (Vec<u32>, Vec<f64>) = given.unzip();
    units[target].instance.set_real(&references, &values)?;
    Ok(())
}

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [step, steps, paths @ ..] = &arguments[..] else {
        return Err("usage: fmi-master STEP STEPS UNIT.fmu …".into());
    };
    let (step, steps): (f64, u32) = (step.parse()?, steps.parse()?);
    let mut units = paths.iter().map(|path| Unit::new(path)).collect::<Outcome<Vec<_>>>()?;
    units.iter_mut().try_for_each(Unit::get)?;
    for i in 0..units.len() {
        set(&mut units, i)?;
        units[i].instance.exit_initialization_mode()?;
    }
    for k in 0..steps {
        for i in 0..units.len() {
            set(&mut units, i)?;
            units[i].instance.do_step(f64::from(k) * step, step, true)?;
            units[i].get()?;
        }
    }
    for (i, unit) in units.iter().enumerate() {
        for (name, value) in unit.outputs.iter().zip(&unit.values) {
            println!("{i} {name} {value:e}");
        }
    }
    Ok(())
}
