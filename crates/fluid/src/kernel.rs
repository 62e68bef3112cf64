//! The kernel of a marker along an axis: a sharpened quintic B-spline in the plane, the cubic one in space.
//!
//! A kernel spreads a wave of the wavenumber k also as waves of `k ± 2π` a cell, and their part changes as a line
//! crosses cells: the noise of its forces. They fall with the degree of a B-spline, but its width grows. The quintic
//! one less a 24th of its second derivative has the width of the quartic one, and a third of the noise of the cubic
//! one. In space it would weigh 216 points for each marker in place of 64.

use method::{LINE_THICKNESS_CELLS, SURFACE_THICKNESS_CELLS, marker_reach};

/// The kernel of a number of dimensions, and what was found by measurement for it.
pub struct Kernel {
    /// Grid points on each side of a marker.
    pub reach: usize,
    /// Distance of neighbouring markers of a line, cells. Closer markers make a matrix of useless condition, whose
    /// solutions alternate; those farther apart leak.
    pub spacing: f64,
    /// Length by which a free end of a line is drawn in, cells, because the kernel reaches beyond the last marker. With
    /// it a line has the added mass of a plate of its length and the kernel's thickness.
    pub drawn_in: f64,
}

impl Kernel {
    const IN_PLANE: Self = Self { reach: marker_reach(2), spacing: 1.75, drawn_in: 0.4 };
    const IN_SPACE: Self = Self { reach: marker_reach(3), spacing: 1.5, drawn_in: 0.4 };

    /// Return the kernel of a number of dimensions.
    pub const fn of(dimensions: usize) -> Self {
        if dimensions == 2 { Self::IN_PLANE } else { Self::IN_SPACE }
    }

    /// Add its values, whose sum is 1, at the `2 reach` points around a place that is `share` of a spacing beyond the
    /// last point before it.
    pub fn add_weights(&self, share: f64, weights: &mut Vec<f64>) {
        if self.reach == 3 { weights.extend(quintic(share)) } else { weights.extend(cubic(share)) }
    }
}

/// Return the thickness of the plate that markers represent, cells, in a number of dimensions.
pub fn layer_thickness(dimensions: usize) -> f64 {
    if dimensions == 2 { LINE_THICKNESS_CELLS } else { SURFACE_THICKNESS_CELLS }
}

/// Return the values of the cubic B-spline at the four points around a place that is `share` of a spacing beyond the second.
pub fn cubic(share: f64) -> [f64; 4] {
    let (s, rest) = (share, 1.0 - share);
    let near = |s: f64| 2.0 / 3.0 - s * s + 0.5 * s * s * s;
    [rest * rest * rest / 6.0, near(s), near(rest), s * s * s / 6.0]
}

fn quintic(share: f64) -> [f64; 6] {
    let (s, rest) = (share, 1.0 - share);
    let far = |r: f64| r.powi(5) / 120.0;
    let middle = |r: f64| (1.0 + r * (5.0 + r * (10.0 + r * (10.0 + r * (5.0 - 5.0 * r))))) / 120.0;
    let near = |s: f64| 0.55 + s * s * (-0.5 + s * s * (0.25 - s / 12.0));
    let [a, b, c, d] = cubic(share);
    let curvature = [a, b - 2.0 * a, a - 2.0 * b + c, b - 2.0 * c + d, c - 2.0 * d, d];
    let smooth = [far(rest), middle(rest), near(s), near(rest), middle(s), far(s)];
    std::array::from_fn(|i| smooth[i] - curvature[i] / 24.0)
}

#[cfg(test)]
mod tests {
    use method::{ROD_RADIUS_CELLS, ROD_SECTION_CELLS};

    use super::*;

    /// Return the kernel of a number of dimensions at a distance in spacings.
    fn value(dimensions: usize, distance: f64) -> f64 {
        let (kernel, mut weights, r) = (Kernel::of(dimensions), Vec::new(), distance.abs());
        kernel.add_weights(r.fract(), &mut weights);
        if r < kernel.reach as f64 { weights[kernel.reach - 1 - r as usize] } else { 0.0 }
    }

    /// Return places over the whole kernel, and the distance of two neighbours.
    fn places(dimensions: usize) -> (Vec<f64>, f64) {
        let (reach, n) = (Kernel::of(dimensions).reach as f64, 400);
        let step = 2.0 * reach / f64::from(n);
        ((0..n).map(|i| (f64::from(i) + 0.5) * step - reach).collect(), step)
    }

    #[test]
    fn thickness_is_twice_the_mean_distance_of_two_points_of_the_kernel() {
        for (dimensions, thickness) in [(2, LINE_THICKNESS_CELLS), (3, SURFACE_THICKNESS_CELLS)] {
            let (points, step) = places(dimensions);
            let value = |x: f64| value(dimensions, x);
            let pairs = points.iter().flat_map(|a| points.iter().map(move |b| value(*a) * value(*b) * (a - b).abs()));
            let mean = pairs.sum::<f64>() * step * step;
            assert!((2.0 * mean - thickness).abs() < 2e-4, "{dimensions}: {}", 2.0 * mean);
        }
    }

    #[test]
    fn section_and_radius_of_a_line_in_space_are_means_over_two_points_of_the_kernel() {
        // The density of the difference of two points, along an axis.
        let (points, step) = places(3);
        let density = |y: f64| points.iter().map(|x| value(3, *x) * value(3, x + y)).sum::<f64>() * step;
        assert!((1.0 / density(0.0).powi(2) - ROD_SECTION_CELLS).abs() < 1e-6);
        let ys: Vec<_> = (0..400).map(|i| (f64::from(i) + 0.5) * step).map(|y| (y, density(y))).collect();
        let pairs = ys.iter().flat_map(|a| ys.iter().map(move |b| a.1 * b.1 * a.0.hypot(b.0).ln()));
        let mean = pairs.sum::<f64>() * 4.0 * step.powi(2);
        assert!((mean.exp() - ROD_RADIUS_CELLS).abs() < 1e-3, "{}", mean.exp());
    }
}
