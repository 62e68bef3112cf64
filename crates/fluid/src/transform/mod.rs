//! Real two-dimensional Fourier transforms.

mod fft;
mod lines;
mod quad;

pub use fft::{Fft2, Scratch};
pub use quad::{Complex4, Quad};
