//! Fourier transforms of the lines of a grid along an axis.
//!
//! A vector holds one number of each of several lines ([`Pack`]), so a transform needs no shuffles ([`Lines`]). Real
//! lines along the contiguous axis are transformed in pairs, as real and imaginary parts ([`RealLines`]); a spectrum is
//! `[rows, lines]` of packs, a row for as many modes as a vector has lanes. [`Fft2`] joins both for two axes, [`Fft3`]
//! for three. [`ThreadTeam`] shares the work of a phase among threads.

mod lines;
mod pack;
mod plane;
mod real_lines;
mod simd;
mod team;
#[cfg(target_arch = "x86_64")]
mod transpose;
mod volume;

pub use lines::Lines;
pub use pack::{Complexes, Pack};
pub use plane::{Fft2, Scratch};
pub use real_lines::{Block, RealLines};
pub use rustfft::num_complex::Complex;
pub use simd::{Arithmetic, F64_LANES, Kernel, Real, from_f64s, run, to_f64s};
pub use team::{ThreadTeam, nothing};
pub use volume::{Fft3, VolumeScratch};

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
