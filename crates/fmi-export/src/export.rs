//! C functions, generic over the model, and the macro that exports them under their names.
//!
//! The functions share a precondition of the standard. An instance pointer is null or comes from `fmi2Instantiate` or
//! `fmi3InstantiateCoSimulation` of the same model, has not been freed and is not used by two threads at once. Arrays
//! have the passed length, and strings are null-terminated.
#![allow(non_snake_case, reason = "the functions have the names of the standard")]
#![allow(clippy::too_many_arguments, reason = "the functions have the arguments of the standard")]
#![allow(clippy::missing_safety_doc, reason = "the module states the precondition")]
#![allow(missing_docs, reason = "the standard describes the functions")]

mod call;
mod fmi2;
mod fmi3;
mod names;
mod own;

pub use fmi2::*;
pub use fmi3::*;
pub use own::{fmu_field, fmu_model_description, fmu_model_description_3};
