//! What the targets do to the unit that is linked in, through its C functions alone.
#![allow(dead_code, reason = "each target uses one half")]

use std::path::{Path, PathBuf};
use std::ptr::null_mut;
use std::sync::LazyLock;

use nervure_fmi_export::sys::fmi2FMUstate;
use scene::{Scene, WingMesh};

use super::KIND;
use master::description::references;
use master::{Fmu, OK, c_string, describe};

#[path = "../../../crates/fmi-export/tests/master/mod.rs"]
mod master;

/// Communication step of the scenes of the units, s: that of `tests/reliability/scene.json` and `wing.json`.
const STEP: f64 = 2e-4;

/// A panic inside the unit becomes an error there, and a finding here.
fn assert_no_panic(message: &str) {
    assert!(!message.contains("panic at"), "{message}");
}

/// An initialised instance at t = 0 with the references of its Real outputs.
struct Unit {
    fmu: Fmu,
    /// The header of its states up to the length of the payload (crates/fmi-export/src/snapshot.rs).
    header: Vec<u8>,
    outputs: Vec<u32>,
}

impl Unit {
    /// The unit of the scene in `folder`, unless it refuses that scene.
    fn new(folder: &Path) -> Option<Self> {
        let xml = describe(Some(&c_string(folder.display()))).inspect_err(|message| assert_no_panic(message)).ok()?;
        let fmu = Fmu::of(&xml, Some(folder));
        let ready = fmu.enter() == OK && fmu.exit() == OK;
        let unit = Unit { header: state_header(&fmu), fmu, outputs: references(&xml, "output") };
        unit.assert_no_panics();
        ready.then_some(unit)
    }

    /// The Real outputs, which have to be finite.
    fn outputs(&self) -> Vec<f64> {
        let mut values = vec![f64::NAN; self.outputs.len()];
        let status = self.fmu.read(&self.outputs, &mut values);
        self.assert_no_panics();
        assert!(status != OK || values.iter().all(|value| value.is_finite()), "{values:?}");
        values
    }

    /// Whether a step succeeds.
    fn step(&self, t: f64, h: f64) -> bool {
        let made = self.fmu.step(t, h) == OK;
        self.assert_no_panics();
        made
    }

    fn assert_no_panics(&self) {
        self.fmu.messages.borrow_mut().drain(..).for_each(|message| assert_no_panic(&message));
    }
}

/// The header of a state of an instance up to the length of its payload.
fn state_header(fmu: &Fmu) -> Vec<u8> {
    let mut state = null_mut();
    if fmu.save(&mut state) != OK {
        return Vec::new();
    }
    let mut bytes = fmu.serialize(state);
    assert_eq!(fmu.free(&mut state), OK);
    let name = usize::from(u16::from_le_bytes([bytes[12], bytes[13]]));
    bytes.truncate(14 + name + 38);
    bytes
}

/// `target/fuzz`, for files.
fn scratch() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/fuzz")
}

/// Any bytes as a scene file: refused, or a unit that makes two steps or says why not.
pub fn scene(data: &[u8]) {
    static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
        let folder = scratch().join(format!("scene-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("the folder can be made");
        folder
    });
    let Ok(text) = str::from_utf8(data) else { return };
    let Ok(scene) = Scene::from_json(text) else { return };
    // What is allowed and takes long is left out.
    let cells = scene.fluid.as_ref().map_or(0, |fluid| fluid.r#box.cells.iter().product());
    let threads = scene.fluid.as_ref().map_or(1, |fluid| fluid.threads);
    let along = match scene.wing.as_ref().map(|wing| &wing.mesh) {
        Some(
            WingMesh::Rectangular { along, .. } | WingMesh::Elliptical { along, .. } | WingMesh::Insect { along, .. },
        ) => *along,
        _ => 0,
    };
    let segments: usize = scene.beams().map(|beam| beam.segments).sum();
    if cells > 2048 || threads > 2 || along > 16 || segments > 24 {
        return;
    }
    let own = scene.fluid.as_ref().map(|fluid| fluid.time_stepping.max_step);
    let rods = scene.rod.iter().chain(scene.rods.iter().map(|own| &own.rod)).filter_map(|rod| rod.max_step);
    let h = own.into_iter().chain(rods).fold(scene.time.communication_step, f64::min);
    std::fs::write(FOLDER.join("scene.json"), text).expect("the scene can be written");
    let Some(unit) = Unit::new(&FOLDER) else { return };
    unit.outputs();
    for k in 0..2 {
        if !unit.step(f64::from(k) * h, h) {
            break;
        }
        unit.outputs();
    }
}

/// A unit, its state at t = 0, and its outputs after a step from there.
struct Good {
    unit: Unit,
    clean: fmi2FMUstate,
    expected: Vec<f64>,
}

impl Good {
    fn new() -> Self {
        let unit = Unit::new(&scratch().join(KIND)).expect("its scene is good");
        let mut clean = null_mut();
        assert_eq!(unit.fmu.save(&mut clean), OK);
        assert!(unit.step(0.0, STEP));
        Good { clean, expected: unit.outputs(), unit }
    }
}

thread_local! {
    static GOOD: Good = Good::new();
}

/// Any bytes as the payload of a serialized state, under a right header and checksum: refused, or a state from which
/// steps succeed with finite outputs or fail; after it a good state leads to the same bits as ever.
pub fn state(payload: &[u8]) {
    GOOD.with(|Good { unit, clean, expected }| {
        let bytes =
            [&unit.header[..], &(payload.len() as u64).to_le_bytes(), &crc32fast::hash(payload).to_le_bytes(), payload]
                .concat();
        let mut state = null_mut();
        if unit.fmu.deserialize(&bytes, &mut state) == OK {
            if unit.fmu.restore(state) == OK {
                unit.outputs();
                for k in 0..4 {
                    if unit.step(f64::from(k) * STEP, STEP) {
                        unit.outputs();
                    }
                }
            }
            assert_eq!(unit.fmu.free(&mut state), OK);
        }
        unit.assert_no_panics();
        assert_eq!(unit.fmu.restore(*clean), OK);
        assert!(unit.step(0.0, STEP), "a good state leads nowhere any more");
        assert!(unit.outputs().iter().zip(expected).all(|(a, b)| a.to_bits() == b.to_bits()), "{expected:?}");
    });
}
