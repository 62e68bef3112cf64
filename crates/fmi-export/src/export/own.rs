//! Functions beyond the standard: model descriptions for packagers, and fields.

use std::path::Path;
use std::ptr;

use super::call::{call, text};
use crate::guard;
use crate::instance::{self, Instance};
use crate::model::Model;
use crate::resource::Resources;
use crate::state_machine::Function;
use crate::sys::{fmi2Char, fmi2Component, fmi2Integer, fmi2Real, fmi2Status, fmi2String};
use crate::text::write;
use crate::version::Version;

/// See [`export_fmu!`](crate::export_fmu).
///
/// # Safety
/// `resources` is null or a null-terminated string, `buffer` has room for `capacity` bytes, `needed` is null or valid.
pub unsafe fn fmu_model_description<M: Model>(
    resources: fmi2String,
    buffer: *mut fmi2Char,
    capacity: usize,
    needed: *mut usize,
) -> fmi2Integer {
    // SAFETY: the caller keeps the same precondition.
    unsafe { describe::<M>(Version::Fmi2, resources, (buffer, capacity), needed) }
}

/// See [`export_fmu!`](crate::export_fmu).
///
/// # Safety
/// The precondition of [`fmu_model_description`].
pub unsafe fn fmu_model_description_3<M: Model>(
    resources: fmi2String,
    buffer: *mut fmi2Char,
    capacity: usize,
    needed: *mut usize,
) -> fmi2Integer {
    // SAFETY: the caller keeps the same precondition.
    unsafe { describe::<M>(Version::Fmi3, resources, (buffer, capacity), needed) }
}

/// Write the model description of one version.
///
/// # Safety
/// The precondition of [`fmu_model_description`].
unsafe fn describe<M: Model>(
    version: Version,
    resources: fmi2String,
    (buffer, capacity): (*mut fmi2Char, usize),
    needed: *mut usize,
) -> fmi2Integer {
    let described = guard::catch(|| {
        // SAFETY: the function's precondition on strings.
        let resources = (!resources.is_null()).then(|| unsafe { text("resources", resources) }).transpose()?;
        let resources = Resources::read(resources.map(Path::new), M::RESOURCES)?;
        let (_, _, document) = instance::load::<M>(&resources, version)?;
        Ok(document.xml)
    });
    // SAFETY: the caller keeps the precondition on the buffer.
    unsafe { write(described.and_then(|result| result), (buffer.cast(), capacity), needed) }
}

/// Most axes of a field.
const MOST_AXES: usize = 3;

/// See [`export_fmu!`](crate::export_fmu).
///
/// # Safety
/// The module's precondition on `c`; `name` is null or a null-terminated string, `buffer` has room for `capacity`
/// values, `shape` is null or has room for three.
pub unsafe fn fmu_field<M: Model>(
    c: fmi2Component,
    name: fmi2String,
    buffer: *mut fmi2Real,
    capacity: usize,
    shape: *mut usize,
) -> fmi2Integer {
    let mut found = false;
    let copy = |instance: &mut Instance<M>| {
        // SAFETY: the function's precondition on the name.
        let name = unsafe { text("name", name) }?;
        let Some((lengths, values)) = instance.field(name)? else { return Ok(()) };
        // SAFETY: null pointers are skipped, and the values fit into the buffer.
        unsafe {
            if !shape.is_null() {
                ptr::copy_nonoverlapping(lengths.as_ptr(), shape, lengths.len().min(MOST_AXES));
            }
            if !buffer.is_null() && values.len() <= capacity {
                ptr::copy_nonoverlapping(values.as_ptr(), buffer, values.len());
            }
        }
        found = true;
        Ok(())
    };
    // SAFETY: the module's precondition.
    let status: fmi2Status = unsafe { call::<M, _>(c, Function::fmi2GetReal, copy) };
    fmi2Integer::from(!(found && status == fmi2Status::fmi2OK))
}
