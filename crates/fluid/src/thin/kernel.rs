//! The kernel of a marker along an axis: the cubic B-spline.

/// Thickness of the plate that a line of markers stands for, cells: twice the mean of |Y|, where Y is the difference of
/// two independent variables whose density is the kernel.
///
/// In a shear flow along the line the plane of no slip lies the mean of |Y| off the line on both sides, exactly. Across
/// the line a wave of the wavenumber k, interpolated and spread, loses the factor `1 − |k| mean|Y|` to first order, as
/// the potential flow between two vortex sheets at that distance. Y has the density of the B-spline of degree 7.
pub const LINE_THICKNESS_CELLS: f64 = 1487.0 / 1134.0;

/// Cross-section of the rod that a line of markers in space stands for, cells²: the inverse of the density at 0 of the
/// difference of two points of the kernel in the plane across the line.
///
/// A force on the line gives its markers the velocity ½ p(0) f t/rho in a fluid without viscosity, and f t/(2 rho A) to
/// a cylinder of the section A with the fluid in it. Its radius is 1.18 cells. In slow viscous flow, across and along,
/// the line drags like a cylinder of exp(mean ln|Y|) = 0.87 cells, Y being that difference.
pub const ROD_SECTION_CELLS: f64 = (315.0 / 151.0) * (315.0 / 151.0);

/// Return the values of the cubic B-spline, whose integral is 1, at the four points around a place that is `share` of a
/// spacing beyond the second of them.
pub fn weights(share: f64) -> [f64; 4] {
    let (s, rest) = (share, 1.0 - share);
    let near = |s: f64| 2.0 / 3.0 - s * s + 0.5 * s * s * s;
    [rest * rest * rest / 6.0, near(s), near(rest), s * s * s / 6.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Return the cubic B-spline at a distance in spacings.
    fn value(distance: f64) -> f64 {
        match distance.abs() {
            r if r < 1.0 => weights(r)[1],
            r if r < 2.0 => weights(r - 1.0)[0],
            _ => 0.0,
        }
    }

    #[test]
    fn thickness_of_a_line_is_twice_the_mean_distance_of_two_points_of_the_kernel() {
        let n = 400;
        let points: Vec<_> = (0..n).map(|i| 4.0 * (f64::from(i) + 0.5) / f64::from(n) - 2.0).collect();
        let mut mean = 0.0;
        for a in &points {
            mean += points.iter().map(|b| value(*a) * value(*b) * (a - b).abs()).sum::<f64>();
        }
        mean *= (4.0 / f64::from(n)).powi(2);
        assert!((2.0 * mean - LINE_THICKNESS_CELLS).abs() < 1e-4, "{}", 2.0 * mean);
        // The rod of a scene leaves the fluid of that layer out of its mass.
        assert_eq!(LINE_THICKNESS_CELLS, scene::LINE_THICKNESS_CELLS);
    }

    #[test]
    fn section_and_radius_of_a_line_in_space_are_means_over_two_points_of_the_kernel() {
        // The density of the difference of two points, along an axis.
        let n = 400;
        let points: Vec<_> = (0..n).map(|i| 4.0 * (f64::from(i) + 0.5) / f64::from(n) - 2.0).collect();
        let density = |y: f64| points.iter().map(|x| value(*x) * value(x + y)).sum::<f64>() * 4.0 / f64::from(n);
        assert!((1.0 / density(0.0).powi(2) - ROD_SECTION_CELLS).abs() < 1e-6);
        assert_eq!(ROD_SECTION_CELLS, scene::ROD_SECTION_CELLS);
        let ys: Vec<_> = (0..n).map(|i| 4.0 * (f64::from(i) + 0.5) / f64::from(n)).map(|y| (y, density(y))).collect();
        let pairs = ys.iter().flat_map(|a| ys.iter().map(move |b| a.1 * b.1 * a.0.hypot(b.0).ln()));
        let mean = pairs.sum::<f64>() * 4.0 * (4.0 / f64::from(n)).powi(2);
        assert!((mean.exp() - 0.87).abs() < 0.005, "{}", mean.exp());
    }
}
