//! Rods that several studies use.

use nervure_rod::{Banded, Parameters, Rod, Scheme, Section};

use crate::common::{turek_hron_bar, unit_rod};

/// Schemes by name.
pub const SCHEMES: [(&str, Scheme); 5] = [
    ("trapezoid", Scheme::Trapezoid),
    ("generalised-alpha 0.5", Scheme::GeneralisedAlpha { rho_inf: 0.5 }),
    ("generalised-alpha 0.8", Scheme::GeneralisedAlpha { rho_inf: 0.8 }),
    ("TR-BDF2", Scheme::TrBdf2),
    ("BDF2", Scheme::Bdf2),
];

/// The beam of the thesis, section 2.4.1, in units of its length: mu = 0.0571, EI = 0.0259, g = 0.7 along the last axis,
/// with the EA of the bar of thickness 2/35.
pub fn thesis_beam<const D: usize>(segments: usize) -> Parameters<D> {
    let straight = unit_rod(segments, 12.0 * 0.0259 * 17.5 * 17.5, Scheme::default());
    let section = Section { line_density: 0.0571, bending_stiffness: 0.0259, ..straight.section };
    Parameters { section, gravity: std::array::from_fn(|d| if d == D - 1 { -0.7 } else { 0.0 }), ..straight }
}

/// The bar of CSM3 (Turek & Hron 2006).
pub fn csm3(segments: usize, scheme: Scheme) -> Parameters<2> {
    Parameters { attachment: [0.0; 2], scheme, ..turek_hron_bar(1.4e6, 2.0, segments) }
}

pub fn build<const D: usize>(parameters: Parameters<D>) -> Rod<D> {
    Rod::new(parameters).expect("these parameters are good")
}

/// The rod at rest under its weight.
pub fn settled<const D: usize>(mut rod: Rod<D>) -> Rod<D> {
    rod.solve_static().expect("a beam under its weight has an equilibrium");
    rod
}

/// Angle of the last segment from the x axis, degrees.
pub fn tip_angle(rod: &Rod<3>) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|d| rod.positions(d)).map(|at| at[at.len() - 1] - at[at.len() - 2]);
    y.hypot(z).atan2(x).to_degrees()
}

/// Of the full matrix.
pub fn entry(matrix: &Banded, i: usize, j: usize) -> f64 {
    matrix.column(i.min(j)).get(i.abs_diff(j)).copied().unwrap_or(0.0)
}
