//! The C interface for the page. A function that fails returns null or a negative number, and `lab_message` the reason.
//! A panic ends the program in WebAssembly; its text is the message, too.
//!
//! The page reads fields, stations and pictures where they are: a pointer is good until the next call with its `Lab`.

use std::panic;
use std::sync::Mutex;

use crate::coupled::{Coupled, Pull};
use crate::paint::{Colours, Periodic, View, paint};

/// The last error, or a text that was asked for.
static MESSAGE: Mutex<String> = Mutex::new(String::new());

/// A simulation with room for what the page reads.
pub struct Lab {
    run: Coupled,
    /// A sample of each step of the last call.
    samples: Vec<f64>,
    field: Vec<f64>,
    colours: Colours,
    picture: Vec<u32>,
}

fn tell(text: String) {
    *MESSAGE.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = text;
}

/// Return the value, or `otherwise` with the error as the message.
fn or_tell<T>(result: Result<T, String>, otherwise: T) -> T {
    result.unwrap_or_else(|text| {
        tell(text);
        otherwise
    })
}

/// Return a text that the caller wrote.
///
/// # Safety
/// `text` must point to `length` bytes.
unsafe fn text<'a>(text: *const u8, length: usize) -> Result<&'a str, String> {
    // SAFETY: the caller's part of the contract.
    let bytes = unsafe { std::slice::from_raw_parts(text, length) };
    std::str::from_utf8(bytes).map_err(|e| e.to_string())
}

/// Return room for `length` bytes, to be given back to [`lab_free_room`].
#[unsafe(no_mangle)]
pub extern "C" fn lab_room(length: usize) -> *mut u8 {
    Box::into_raw(vec![0_u8; length].into_boxed_slice()).cast()
}

/// Free what [`lab_room`] gave.
///
/// # Safety
/// `text` must come from `lab_room` with the same length, and not be used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lab_free_room(text: *mut u8, length: usize) {
    // SAFETY: the caller's part of the contract.
    drop(unsafe { Box::from_raw(std::ptr::slice_from_raw_parts_mut(text, length)) });
}

/// Return the bytes of the message.
#[unsafe(no_mangle)]
pub extern "C" fn lab_message() -> *const u8 {
    MESSAGE.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).as_ptr()
}

/// Return the number of these bytes.
#[unsafe(no_mangle)]
pub extern "C" fn lab_message_length() -> usize {
    MESSAGE.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).len()
}

/// Start the simulation of a scene; null for a scene that cannot be run.
///
/// # Safety
/// `scene` must point to `length` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lab_new(scene: *const u8, length: usize) -> *mut Lab {
    panic::set_hook(Box::new(|info| tell(info.to_string())));
    // SAFETY: the caller's part of the contract.
    let run = unsafe { text(scene, length) }.and_then(Coupled::new);
    let made = run.map(|run| {
        let room = Lab { run, samples: vec![], field: vec![], colours: [0; 256], picture: vec![] };
        Box::into_raw(Box::new(room))
    });
    or_tell(made, std::ptr::null_mut())
}

/// End a simulation.
///
/// # Safety
/// `lab` must come from [`lab_new`], and not be used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lab_free(lab: *mut Lab) {
    // SAFETY: the caller's part of the contract.
    drop(unsafe { Box::from_raw(lab) });
}

/// Continue with another scene from the present state; return 0, or −1 where that cannot be.
///
/// # Safety
/// `lab` must come from [`lab_new`], and `scene` point to `length` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lab_change(lab: &mut Lab, scene: *const u8, length: usize) -> i32 {
    // SAFETY: the caller's part of the contract.
    let scene = unsafe { text(scene, length) };
    or_tell(scene.and_then(|scene| lab.run.change(scene)).map(|()| 0), -1)
}

/// Make the message a JSON object of the facts of a scene, `null` for a scene with faults.
///
/// # Safety
/// `scene` must point to `length` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lab_facts(scene: *const u8, length: usize) {
    // SAFETY: the caller's part of the contract.
    let scene = unsafe { text(scene, length) };
    tell(scene::facts_text(scene.unwrap_or_default()));
}

/// Make up to `steps` steps; return the steps made, or −1 after an error.
#[unsafe(no_mangle)]
pub extern "C" fn lab_step(lab: &mut Lab, steps: i32) -> i32 {
    lab.samples.clear();
    for _ in 0..steps {
        if let Err(text) = lab.run.step() {
            tell(text);
            return -1;
        }
        lab.samples.extend(lab.run.sample());
    }
    steps
}

/// Return the samples of the last [`lab_step`], a row of [`lab_columns`] numbers for each step.
#[unsafe(no_mangle)]
pub extern "C" fn lab_samples(lab: &Lab) -> *const f64 {
    lab.samples.as_ptr()
}

/// Return the numbers in a sample: time, drag, lift, two for each rod and two for each body.
#[unsafe(no_mangle)]
pub extern "C" fn lab_columns(lab: &Lab) -> usize {
    lab.run.sample().count()
}

/// Return the number of rods.
#[unsafe(no_mangle)]
pub extern "C" fn lab_rods(lab: &Lab) -> usize {
    lab.run.rods()
}

/// Return the number of stations of a rod.
#[unsafe(no_mangle)]
pub extern "C" fn lab_stations(lab: &Lab, rod: usize) -> usize {
    lab.run.positions(rod, 0).len()
}

/// Return the positions of the stations of a rod along an axis, m.
#[unsafe(no_mangle)]
pub extern "C" fn lab_positions(lab: &Lab, rod: usize, axis: usize) -> *const f64 {
    lab.run.positions(rod, axis).as_ptr()
}

/// Pull at a station of a rod towards a point with a spring, N/m per metre of depth; a stiffness of 0 lets go.
#[unsafe(no_mangle)]
pub extern "C" fn lab_pull(lab: &mut Lab, rod: usize, station: usize, x: f64, y: f64, stiffness: f64) {
    let pull = Pull { rod, station, to: [x, y], stiffness };
    lab.run.set_pull((stiffness > 0.0).then_some(pull));
}

/// Return the points of the grid along an axis.
#[unsafe(no_mangle)]
pub extern "C" fn lab_cells(lab: &mut Lab, axis: usize) -> usize {
    lab.run.fluid().grid().cells[axis]
}

/// Return a field at the points of the grid, `[nx, ny]`: 0 vorticity, 1 speed, 2 pressure, 3 u, 4 v, in SI units.
/// Vorticity and velocity in double precision are the solver's own memory.
#[unsafe(no_mangle)]
pub extern "C" fn lab_field(lab: &mut Lab, kind: u32) -> *const f64 {
    let (fluid, room) = (lab.run.fluid(), &mut lab.field);
    let own = match kind {
        1 => {
            let (u, v) = (fluid.velocity(0), fluid.velocity(1));
            room.clear();
            room.extend(u.iter().zip(&*v).map(|(u, v)| u.hypot(*v)));
            return room.as_ptr();
        }
        2 => {
            *room = fluid.pressure();
            return room.as_ptr();
        }
        3 | 4 => fluid.velocity(kind as usize - 3),
        _ => fluid.vorticity(0),
    };
    match own {
        std::borrow::Cow::Borrowed(own) => own.as_ptr(),
        std::borrow::Cow::Owned(copy) => {
            *room = copy;
            room.as_ptr()
        }
    }
}

/// Return the 256 colours of pictures, to be written.
#[unsafe(no_mangle)]
pub extern "C" fn lab_colours(lab: &mut Lab) -> *mut u32 {
    lab.colours.as_mut_ptr()
}

/// Return a picture of a field in a part of the plane, row by row from the top left.
#[unsafe(no_mangle)]
pub extern "C" fn lab_paint(
    lab: &mut Lab,
    kind: u32,
    low: f64,
    high: f64,
    left: f64,
    right: f64,
    bottom: f64,
    top: f64,
    width: usize,
    height: usize,
) -> *const u32 {
    let field = lab_field(lab, kind);
    let cells = lab.run.fluid().grid().cells;
    let part = lab.run.scene().fluid.as_ref().expect("a flow is refused without a fluid");
    let ends = [part.r#box.x, part.r#box.y];
    // SAFETY: `lab_field` returns as many numbers as there are points, and nothing below changes them.
    let values = unsafe { std::slice::from_raw_parts(field, cells[0] * cells[1]) };
    let view = View { ends: [[left, right], [bottom, top]], pixels: [width, height] };
    paint(&Periodic { values, cells, ends }, &view, [low, high], &lab.colours, &mut lab.picture);
    lab.picture.as_ptr()
}
