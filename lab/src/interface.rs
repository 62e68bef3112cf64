//! The C interface for the page. A function that fails returns null or a negative number, and `lab_message` the
//! reason. A panic ends the program in WebAssembly; its text is the message, too.
//!
//! The page reads fields, stations and pictures where they are: a pointer is good until the next call with its `Lab`.

use std::panic;
use std::sync::Mutex;

use adapter::{Dimensions, either};
use fluid::{Fluid, Solvable};
use scene::Scene;

use crate::paint::{Colours, Periodic, View, paint};
use crate::project::{Camera, Volume, project};
use crate::rod_in_flow::{Pull, RodsInFlow};
use crate::wing_in_flow::WingsInFlow;

/// The last error, or a text that was asked for.
static MESSAGE: Mutex<String> = Mutex::new(String::new());

/// A simulation with room for what the page reads.
pub struct Lab {
    run: Run,
    camera: Camera,
    /// A sample of each step of the last call.
    samples: Vec<f64>,
    field: Vec<f64>,
    colours: Colours,
    picture: Vec<u32>,
}

/// What is simulated, in the plane or in space.
type Run = Dimensions<RodsInFlow, WingsInFlow>;

/// Return the simulation of a scene.
fn start(text: &str) -> Result<Run, String> {
    let scene = Scene::from_json(text).map_err(|e| e.to_string())?;
    let is_space = scene.fluid.as_ref().is_some_and(|fluid| fluid.is_space());
    Ok(if is_space { Run::Space(WingsInFlow::of(scene)?) } else { Run::Plane(RodsInFlow::of(scene)?) })
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
    let run = unsafe { text(scene, length) }.and_then(start);
    let made = run.map(|run| {
        let room = Lab {
            run,
            camera: Camera::new(0.0, 0.0),
            samples: vec![],
            field: vec![],
            colours: [0; 256],
            picture: vec![],
        };
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
    or_tell(scene.and_then(|scene| either!(&mut lab.run, run => run.change(scene))).map(|()| 0), -1)
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
        if let Err(text) = either!(&mut lab.run, run => run.step()) {
            tell(text);
            return -1;
        }
        lab.samples.extend(either!(&lab.run, run => run.sample()));
    }
    steps
}

/// Return the samples of the last [`lab_step`], a row of [`lab_columns`] numbers for each step.
#[unsafe(no_mangle)]
pub extern "C" fn lab_samples(lab: &Lab) -> *const f64 {
    lab.samples.as_ptr()
}

/// Return the numbers in a sample: time, force along each axis, those of each rod or wing, and the place of each body.
/// A rod has the displacement of its tip; a wing has this, and its twist.
#[unsafe(no_mangle)]
pub extern "C" fn lab_columns(lab: &Lab) -> usize {
    either!(&lab.run, run => run.sample()).len()
}

/// Return the number of dimensions.
#[unsafe(no_mangle)]
pub extern "C" fn lab_dimensions(lab: &Lab) -> usize {
    lab.run.count()
}

/// Return the number of rods or wings.
#[unsafe(no_mangle)]
pub extern "C" fn lab_flexible(lab: &Lab) -> usize {
    either!(&lab.run, run => run.flexible())
}

/// Return the number of stations of a rod or nodes of a wing.
#[unsafe(no_mangle)]
pub extern "C" fn lab_stations(lab: &Lab, number: usize) -> usize {
    either!(&lab.run, run => run.positions(number, 0)).len()
}

/// Return their positions along an axis, m.
#[unsafe(no_mangle)]
pub extern "C" fn lab_positions(lab: &Lab, number: usize, axis: usize) -> *const f64 {
    either!(&lab.run, run => run.positions(number, axis)).as_ptr()
}

/// Pull at a station of a rod towards a point with a spring, N/m per metre of depth; a stiffness of 0 lets go. Nothing
/// pulls at a wing.
#[unsafe(no_mangle)]
pub extern "C" fn lab_pull(lab: &mut Lab, rod: usize, station: usize, x: f64, y: f64, stiffness: f64) {
    let pull = Pull { rod, station, to: [x, y], stiffness };
    if let Run::Plane(run) = &mut lab.run {
        run.set_pull((stiffness > 0.0).then_some(pull));
    }
}

/// Return the points of the grid along an axis.
#[unsafe(no_mangle)]
pub extern "C" fn lab_cells(lab: &mut Lab, axis: usize) -> usize {
    either!(&mut lab.run, run => run.fluid().grid().cells[axis])
}

/// Look at space from another side, of angles as of [`Camera::new`]; return the directions to the right, to the top
/// and to the viewer, unit vectors.
#[unsafe(no_mangle)]
pub extern "C" fn lab_camera(lab: &mut Lab, turned: f64, raised: f64) -> *const f64 {
    lab.camera = Camera::new(turned, raised);
    lab.camera.right.as_ptr()
}

/// Return a field at the points of the grid, `[nx, ny]`: 0 vorticity, 1 speed, 2 pressure, 3 u, 4 v, in SI units; in
/// space the magnitude of the vorticity, and speed otherwise. Vorticity and velocity of a plane in double precision
/// are the solver's own memory.
#[unsafe(no_mangle)]
pub extern "C" fn lab_field(lab: &mut Lab, kind: u32) -> *const f64 {
    let room = &mut lab.field;
    let fluid = match &mut lab.run {
        Run::Plane(run) => run.fluid(),
        Run::Space(run) => {
            let fluid = run.fluid();
            let of = |axis| if kind == 0 { fluid.vorticity(axis) } else { fluid.velocity(axis) };
            let [x, y, z] = [of(0), of(1), of(2)];
            room.clear();
            room.extend(x.iter().zip(&*y).zip(&*z).map(|((x, y), z)| (x * x + y * y + z * z).sqrt()));
            return room.as_ptr();
        }
    };
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

/// Return a picture of a field in a part of the plane, row by row from the top left; of a field of space that of its
/// largest values along the lines of sight, where the ends are along the axes of the picture.
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
    let Lab { run, camera, colours, picture, .. } = lab;
    let points = either!(&mut *run, run => run.fluid().grid().len());
    // SAFETY: `lab_field` returns as many numbers as there are points, and nothing below changes them.
    let values = unsafe { std::slice::from_raw_parts(field, points) };
    let (view, range) = (View { ends: [[left, right], [bottom, top]], pixels: [width, height] }, [low, high]);
    match run {
        Run::Plane(run) => {
            let (cells, ends) = grid_of(run.fluid());
            paint(&Periodic { values, cells, ends }, &view, range, colours, picture);
        }
        Run::Space(run) => {
            let (cells, ends) = grid_of(run.fluid());
            project(&Volume { values, cells, ends }, camera, &view, range, colours, picture);
        }
    }
    picture.as_ptr()
}

/// Return the points and the ends (m) of the domain along each axis.
fn grid_of<const D: usize>(fluid: &Fluid<D>) -> ([usize; D], [[f64; 2]; D])
where
    [f64; D]: Solvable<D>,
{
    let grid = fluid.grid();
    let low = grid.low();
    (grid.cells, std::array::from_fn(|d| [low[d], low[d] + grid.size[d]]))
}
