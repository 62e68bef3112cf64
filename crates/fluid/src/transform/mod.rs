//! Real two-dimensional Fourier transforms.

mod fft;
mod lines;
mod pack;

pub use fft::{Fft2, Scratch};
pub use pack::Pack;
