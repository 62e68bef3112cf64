//! `fmi-master STEP STEPS UNIT.fmu …`: makes STEPS communication steps of STEP seconds from t = 0 and prints every Real
//! output of every unit, of FMI 2.0 or 3.0, as `index name value`.
//!
//! The units step in the order given, each with the newest outputs of the others: with the rod first, our explicit scheme.

use std::collections::HashMap;
use std::error::Error;

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation as CoSimulation2, Common as Common2, InstanceCS as Instance2};
use fmi::fmi2::schema::{Causality as Causality2, ScalarVariableElement};
use fmi::fmi3::import::Fmi3Import;
use fmi::fmi3::instance::InstanceCS as Instance3;
use fmi::fmi3::schema::{AbstractVariableTrait, ArrayableVariableTrait, Causality as Causality3};
use fmi::fmi3::{CoSimulation as CoSimulation3, Common as Common3, Fmi3Model, GetSet};
use fmi::schema::MajorVersion;
use fmi::schema::traits::FmiModelDescription;
use fmi::traits::FmiImport;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// The calls of the loop.
trait Calls {
    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Outcome<()>;
    fn set(&mut self, references: &[u32], values: &[f64]) -> Outcome<()>;
    fn start(&mut self) -> Outcome<()>;
    fn step(&mut self, time: f64, step: f64) -> Outcome<()>;
}

impl Calls for Instance2 {
    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Outcome<()> {
        self.get_real(references, values)?;
        Ok(())
    }

    fn set(&mut self, references: &[u32], values: &[f64]) -> Outcome<()> {
        self.set_real(references, values)?;
        Ok(())
    }

    fn start(&mut self) -> Outcome<()> {
        Common2::exit_initialization_mode(self)?;
        Ok(())
    }

    fn step(&mut self, time: f64, step: f64) -> Outcome<()> {
        CoSimulation2::do_step(self, time, step, true)?;
        Ok(())
    }
}

impl Calls for Instance3 {
    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Outcome<()> {
        self.get_float64(references, values)?;
        Ok(())
    }

    fn set(&mut self, references: &[u32], values: &[f64]) -> Outcome<()> {
        self.set_float64(references, values)?;
        Ok(())
    }

    fn start(&mut self) -> Outcome<()> {
        Common3::exit_initialization_mode(self)?;
        Ok(())
    }

    fn step(&mut self, time: f64, step: f64) -> Outcome<()> {
        let ([mut event, mut end, mut early], mut reached) = ([true; 3], 0.0);
        CoSimulation3::do_step(self, time, step, true, &mut event, &mut end, &mut early, &mut reached)?;
        match event || end || early || reached != time + step {
            true => Err(format!("the step from {time} ended at {reached}: {event} {end} {early}").into()),
            false => Ok(()),
        }
    }
}

/// A variable of an FMU, in FMI 3.0 with all values of an array.
struct Variable {
    name: String,
    reference: u32,
    size: usize,
}

struct Unit {
    instance: Box<dyn Calls>,
    inputs: Vec<Variable>,
    outputs: Vec<Variable>,
    /// The outputs' values, one variable after the other, as they were when last fetched.
    values: Vec<f64>,
    /// The unpacked FMU, which has to stay as long as the instance.
    _files: Box<dyn std::any::Any>,
}

impl Unit {
    /// The FMU at `path`, in initialization mode.
    fn new(path: &str) -> Outcome<Self> {
        match fmi::import::peek_descr_path(path)?.major_version()? {
            MajorVersion::FMI2 => Self::fmi2(path),
            MajorVersion::FMI3 => Self::fmi3(path),
            other => Err(format!("{path} is of FMI {other:?}").into()),
        }
    }

    fn fmi2(path: &str) -> Outcome<Self> {
        let files: Fmi2Import = fmi::import::from_path(path)?;
        let named = |causality: Causality2| -> Vec<Variable> {
            let variables = files.model_description().get_model_variables();
            variables
                .filter(|v| v.causality == causality && matches!(v.elem, ScalarVariableElement::Real(_)))
                .map(|v| Variable { name: v.name.clone(), reference: v.value_reference, size: 1 })
                .collect()
        };
        let (inputs, outputs) = (named(Causality2::Input), named(Causality2::Output));
        let mut instance = files.instantiate_cs("unit", false, false)?;
        instance.setup_experiment(None, 0.0, None)?;
        instance.enter_initialization_mode()?;
        Ok(Self::of(Box::new(instance), inputs, outputs, Box::new(files)))
    }

    fn fmi3(path: &str) -> Outcome<Self> {
        let files: Fmi3Import = fmi::import::from_path(path)?;
        let named = |causality: Causality3| -> Vec<Variable> {
            let variables = files.model_description().model_variables.float64().into_iter();
            variables
                .filter(|v| v.causality() == causality)
                .map(|v| {
                    let lengths = v.dimensions().iter().map(|d| d.as_fixed().expect("lengths are fixed") as usize);
                    Variable { name: v.name().to_string(), reference: v.value_reference(), size: lengths.product() }
                })
                .collect()
        };
        let (inputs, outputs) = (named(Causality3::Input), named(Causality3::Output));
        let mut instance = files.instantiate_cs("unit", false, false, false, false, &[])?;
        instance.enter_initialization_mode(None, 0.0, None)?;
        Ok(Self::of(Box::new(instance), inputs, outputs, Box::new(files)))
    }

    fn of(
        instance: Box<dyn Calls>,
        inputs: Vec<Variable>,
        outputs: Vec<Variable>,
        files: Box<dyn std::any::Any>,
    ) -> Self {
        let values = vec![0.0; outputs.iter().map(|variable| variable.size).sum()];
        Unit { instance, inputs, outputs, values, _files: files }
    }

    fn get(&mut self) -> Outcome<()> {
        let references: Vec<u32> = self.outputs.iter().map(|variable| variable.reference).collect();
        self.instance.get(&references, &mut self.values)
    }

    /// Outputs with their values.
    fn offered(&self) -> impl Iterator<Item = (&str, &[f64])> {
        let mut rest = &self.values[..];
        self.outputs.iter().map(move |variable| {
            let values = rest.split_off(..variable.size).expect("as many values as the outputs have");
            (variable.name.as_str(), values)
        })
    }
}

/// Hands unit `target` those inputs that another unit has as outputs.
fn set(units: &mut [Unit], target: usize) -> Outcome<()> {
    let others = units.iter().enumerate().filter(|(i, _)| *i != target).map(|(_, unit)| unit);
    let offered: HashMap<&str, &[f64]> = others.flat_map(Unit::offered).collect();
    let given = units[target].inputs.iter().filter_map(|v| Some((v.reference, *offered.get(v.name.as_str())?)));
    let (references, values): (Vec<u32>, Vec<&[f64]>) = given.unzip();
    let values = values.concat();
    units[target].instance.set(&references, &values)
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
        units[i].instance.start()?;
    }
    for k in 0..steps {
        for i in 0..units.len() {
            set(&mut units, i)?;
            units[i].instance.step(f64::from(k) * step, step)?;
            units[i].get()?;
        }
    }
    for (i, unit) in units.iter().enumerate() {
        for (name, values) in unit.offered() {
            for (k, value) in values.iter().enumerate() {
                match values.len() {
                    1 => println!("{i} {name} {value:e}"),
                    _ => println!("{i} {name}[{}] {value:e}", k + 1),
                }
            }
        }
    }
    Ok(())
}
