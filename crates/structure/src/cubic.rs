//! Interpolation of a prescribed motion.

use nalgebra::SMatrix;

/// Return value, rate and second rate, at the fraction `s` of `duration`, s, of the cubic that has these values and
/// rates at its ends; at s = 1 value and rate are exact.
pub fn cubic<const R: usize, const C: usize>(
    (p_0, v_0): (SMatrix<f64, R, C>, SMatrix<f64, R, C>),
    (p_1, v_1): (SMatrix<f64, R, C>, SMatrix<f64, R, C>),
    s: f64,
    duration: f64,
) -> [SMatrix<f64, R, C>; 3] {
    let (m_0, m_1) = (v_0 * duration, v_1 * duration);
    let (square, cube) = ((p_1 - p_0) * 3.0 - m_0 * 2.0 - m_1, (p_0 - p_1) * 2.0 + m_0 + m_1);
    let second_rate = (square * 2.0 + cube * (6.0 * s)) / (duration * duration);
    if s == 1.0 {
        return [p_1, v_1, second_rate];
    }
    let value = p_0 + (m_0 + (square + cube * s) * s) * s;
    [value, (m_0 + (square * 2.0 + cube * (3.0 * s)) * s) / duration, second_rate]
}
