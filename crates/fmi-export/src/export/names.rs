//! Export of the functions under their C names.

/// Export a [`Model`] as a library for co-simulation: the functions of FMI 2.0 and 3.0, functions for packagers, and
/// fields.
///
/// Call the macro once in a crate of type `cdylib`, the library of one FMU.
///
/// `int fmu_model_description(const char *resources, char *buffer, size_t capacity, size_t *needed)` writes
/// `modelDescription.xml` of FMI 2.0 for the resources in a folder (a plain path, or NULL). `fmu_model_description_3`
/// has the same arguments and writes the file of FMI 3.0. They return 0 for a model description and 1 for an error
/// message. `*needed` is the size of the text with its final NUL. The text is written only if the capacity suffices.
///
/// `int fmu_field(void *instance, const char *name, double *buffer, size_t capacity, size_t *shape)` copies a field of
/// [`Model::field`](crate::Model::field). It returns 0, or 1 without a field of this name or without a readable
/// instance. `shape` receives the lengths, up to three. The values are written only if the capacity suffices.
#[macro_export]
macro_rules! export_fmu {
    ($model:ty) => {
        $crate::__functions! { $crate::__export, $model => }
    };
}

/// Pass the functions of the standards, and those beyond, to the macro `with`, after what is `given`.
#[doc(hidden)]
#[macro_export]
macro_rules! __functions {
    ($with:path, $($given:tt)*) => {
        $crate::__standard_functions! { $with, $($given)* }
        $with! { $($given)*
            fmu_model_description(resources: fmi2String, buffer: *mut fmi2Char, capacity: usize, needed: *mut usize)
                -> fmi2Integer;
            fmu_model_description_3(resources: fmi2String, buffer: *mut fmi2Char, capacity: usize, needed: *mut usize)
                -> fmi2Integer;
            fmu_field(c: fmi2Component, name: fmi2String, buffer: *mut fmi2Real, capacity: usize, shape: *mut usize)
                -> fmi2Integer;
        }
    };
}

/// Export each function under its C name.
#[doc(hidden)]
#[macro_export]
macro_rules! __export {
    ($model:ty => $($name:ident($($argument:ident: $type:ty),*) -> $result:ty;)*) => {
        const _: () = {
            use $crate::sys::*;
            $(
                // SAFETY: the names belong to the standard; a library exports one model.
                #[unsafe(no_mangle)]
                unsafe extern "C" fn $name($($argument: $type),*) -> $result {
                    // SAFETY: the caller keeps the precondition of the standard, the precondition of `export`.
                    unsafe { $crate::export::$name::<$model>($($argument),*) }
                }
            )*
        };
    };
}
