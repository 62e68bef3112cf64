//! Cubic splines of class C² through points (de Boor, A Practical Guide to Splines, chapter IV).
//!
//! On the interval between two points the spline is the cubic Hermite polynomial of their values and slopes. The slopes
//! m make the second derivative continuous: with h the widths and δ the secants of the intervals,
//!
//! ```text
//! h_i m_(i−1) + 2 (h_(i−1) + h_i) m_i + h_(i−1) m_(i+1) = 3 (h_i δ_(i−1) + h_(i−1) δ_i).
//! ```

/// What closes the system of the slopes at the two ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ends {
    /// The third derivative is continuous across the second and the last but one point ("not a knot"): a cubic is
    /// reproduced, three points give their parabola, two their line.
    NotAKnot,
    /// The slopes at both ends are given.
    Slopes([f64; 2]),
    /// The last point is the first of the next period.
    Periodic,
}

/// Return the slopes at the points of the spline through `values` at increasing `times`, at least two, of equal number.
pub(crate) fn slopes(times: &[f64], values: &[f64], ends: Ends) -> Vec<f64> {
    let widths: Vec<_> = times.windows(2).map(|t| t[1] - t[0]).collect();
    let secants: Vec<_> = values.windows(2).zip(&widths).map(|(v, width)| (v[1] - v[0]) / width).collect();
    let (h, d, n) = (&widths, &secants, widths.len());
    let inner = |left: usize, right: usize| {
        [h[right], 2.0 * (h[left] + h[right]), h[left], 3.0 * (h[right] * d[left] + h[left] * d[right])]
    };
    match ends {
        Ends::Periodic => {
            let rows: Vec<_> = (0..n).map(|i| inner(if i == 0 { n - 1 } else { i - 1 }, i)).collect();
            let mut found = if n == 1 { vec![0.0] } else { solve_cyclic(rows) };
            found.push(found[0]);
            found
        }
        Ends::NotAKnot if n == 1 => vec![d[0]; 2],
        Ends::NotAKnot if n == 2 => {
            let bend = (d[1] - d[0]) / (h[0] + h[1]);
            vec![d[0] - bend * h[0], d[0] + bend * h[0], d[1] + bend * h[1]]
        }
        Ends::NotAKnot => {
            let end = |h0: f64, h1: f64, d0: f64, d1: f64| {
                let both = h0 + h1;
                [h1, both, ((h0 + 2.0 * both) * h1 * d0 + h0 * h0 * d1) / both]
            };
            let [diagonal, above, right] = end(h[0], h[1], d[0], d[1]);
            let mut rows = vec![[0.0, diagonal, above, right]];
            rows.extend((1..n).map(|i| inner(i - 1, i)));
            let [diagonal, below, right] = end(h[n - 1], h[n - 2], d[n - 1], d[n - 2]);
            rows.push([below, diagonal, 0.0, right]);
            solve(rows)
        }
        Ends::Slopes([first, last]) => {
            let mut rows = vec![[0.0, 1.0, 0.0, first]];
            rows.extend((1..n).map(|i| inner(i - 1, i)));
            rows.push([0.0, 1.0, 0.0, last]);
            solve(rows)
        }
    }
}

/// Return the solution of a tridiagonal system whose rows are [below, diagonal, above, right side].
fn solve(mut rows: Vec<[f64; 4]>) -> Vec<f64> {
    for i in 1..rows.len() {
        let [_, diagonal, above, right] = rows[i - 1];
        let factor = rows[i][0] / diagonal;
        rows[i][1] -= factor * above;
        rows[i][3] -= factor * right;
    }
    let mut found = vec![0.0; rows.len()];
    let mut next = 0.0;
    for (i, [_, diagonal, above, right]) in rows.iter().enumerate().rev() {
        next = (right - above * next) / diagonal;
        found[i] = next;
    }
    found
}

/// Solve the same where the first unknown follows the last, by the Sherman–Morrison formula.
fn solve_cyclic(mut rows: Vec<[f64; 4]>) -> Vec<f64> {
    let last = rows.len() - 1;
    let (corner_above, corner_below) = (rows[0][0], rows[last][2]);
    if last == 1 {
        // Each unknown is both neighbours of the other.
        rows[0][2] += corner_above;
        rows[1][0] += corner_below;
        return solve(rows);
    }
    let gamma = -rows[0][1];
    rows[0][1] -= gamma;
    rows[last][1] -= corner_above * corner_below / gamma;
    let mut update: Vec<_> = rows.iter().map(|[below, diagonal, above, _]| [*below, *diagonal, *above, 0.0]).collect();
    update[0][3] = gamma;
    update[last][3] = corner_below;
    let (found, update) = (solve(rows), solve(update));
    let share = |x: &[f64]| x[0] + corner_above / gamma * x[last];
    let factor = share(&found) / (1.0 + share(&update));
    found.iter().zip(&update).map(|(found, update)| found - factor * update).collect()
}

/// Return the value and rate at `t`, between the first and the last of `times`, of the spline with these `slopes`.
pub(crate) fn value_and_rate(times: &[f64], values: &[f64], slopes: &[f64], t: f64) -> (f64, f64) {
    let i = times.partition_point(|&time| time <= t).clamp(1, times.len() - 1) - 1;
    let width = times[i + 1] - times[i];
    let s = (t - times[i]) / width;
    let (p0, p1, m0, m1) = (values[i], values[i + 1], width * slopes[i], width * slopes[i + 1]);
    let value = p0 + s * (m0 + s * (3.0 * (p1 - p0) - 2.0 * m0 - m1 + s * (2.0 * (p0 - p1) + m0 + m1)));
    let rate = m0 + s * (2.0 * (3.0 * (p1 - p0) - 2.0 * m0 - m1) + s * 3.0 * (2.0 * (p0 - p1) + m0 + m1));
    (value, rate / width)
}

/// Return the largest magnitudes of the spline and of its rate.
pub(crate) fn largest(times: &[f64], values: &[f64], slopes: &[f64]) -> [f64; 2] {
    let mut found = [0.0, 0.0];
    let mut see = |t: f64| {
        let (value, rate) = value_and_rate(times, values, slopes, t);
        found = [f64::max(found[0], value.abs()), f64::max(found[1], rate.abs())];
    };
    for i in 0..times.len() - 1 {
        let width = times[i + 1] - times[i];
        let (rise, m0, m1) = (values[i + 1] - values[i], width * slopes[i], width * slopes[i + 1]);
        // The rate is m0 + 2 b s + 3 c s² in the share s of the interval.
        let (b, c) = (3.0 * rise - 2.0 * m0 - m1, m0 + m1 - 2.0 * rise);
        let root = (b * b - 3.0 * c * m0).max(0.0).sqrt();
        let extremes = [0.0, 1.0, -b / (3.0 * c), (-b - root) / (3.0 * c), (-b + root) / (3.0 * c), -m0 / (2.0 * b)];
        extremes.into_iter().filter(|s| (0.0..=1.0).contains(s)).for_each(|s| see(times[i] + s * width));
    }
    found
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn at(times: &[f64], values: &[f64], ends: Ends, t: f64) -> (f64, f64) {
        value_and_rate(times, values, &slopes(times, values, ends), t)
    }

    #[test]
    fn polynomials_that_the_points_determine_come_out() {
        let times = [0.0, 0.3, 0.5, 1.0, 1.2, 2.0];
        for (count, degree) in [(2, 1), (3, 2), (4, 3), (6, 3)] {
            let polynomial = |t: f64| (0..=degree).map(|k| (1.0 + k as f64) * t.powi(k)).sum::<f64>();
            let rate = |t: f64| (1..=degree).map(|k| (1.0 + k as f64) * k as f64 * t.powi(k - 1)).sum::<f64>();
            let values: Vec<_> = times[..count].iter().map(|&t| polynomial(t)).collect();
            for t in [0.0, 0.1, 0.25, times[count - 1]] {
                let found = at(&times[..count], &values, Ends::NotAKnot, t);
                assert!((found.0 - polynomial(t)).abs() < 1e-13 * polynomial(t), "{count} points, t = {t}: {found:?}");
                assert!((found.1 - rate(t)).abs() < 1e-12 * rate(t), "{count} points, t = {t}: {found:?}");
            }
        }
    }

    #[test]
    fn the_second_derivative_is_continuous() {
        let (times, values) = ([0.0, 0.3, 0.5, 1.0, 1.7], [1.0, 2.0, -1.0, 0.0, 1.0]);
        for ends in [Ends::NotAKnot, Ends::Slopes([2.0, -1.0]), Ends::Periodic] {
            let slopes = slopes(&times, &values, ends);
            let bend = |i: usize, s: f64| {
                let width = times[i + 1] - times[i];
                let secant = (values[i + 1] - values[i]) / width;
                (6.0 * secant * (1.0 - 2.0 * s) - slopes[i] * (4.0 - 6.0 * s) - slopes[i + 1] * (2.0 - 6.0 * s)) / width
            };
            for i in 0..3 {
                let (before, after) = (bend(i, 1.0), bend(i + 1, 0.0));
                assert!((before - after).abs() < 1e-11, "{ends:?}, point {}: {before} against {after}", i + 1);
            }
            match ends {
                Ends::Periodic => assert!((bend(3, 1.0) - bend(0, 0.0)).abs() < 1e-11 && slopes[0] == slopes[4]),
                Ends::Slopes(given) => assert_eq!([slopes[0], slopes[4]], given),
                Ends::NotAKnot => {
                    let third = |i: usize| (bend(i, 1.0) - bend(i, 0.0)) / (times[i + 1] - times[i]);
                    assert!((third(0) - third(1)).abs() < 1e-10 && (third(2) - third(3)).abs() < 1e-10);
                }
            }
        }
    }

    #[test]
    fn a_period_of_a_sine_converges_with_the_fourth_order() {
        let error = |n: usize| {
            let times: Vec<_> = (0..=n).map(|i| i as f64 / n as f64).collect();
            let values: Vec<_> = times.iter().map(|t| (2.0 * PI * t).sin()).collect();
            let off = |t: f64| (at(&times, &values, Ends::Periodic, t).0 - (2.0 * PI * t).sin()).abs();
            (0..1000).map(|k| off(k as f64 / 1000.0)).fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(10), error(20));
        assert!(coarse < 4.5e-4 && (coarse / fine).log2() > 3.9, "errors {coarse:.2e}, {fine:.2e}");
    }

    #[test]
    fn extremes_between_the_points_are_seen() {
        let (times, values) = ([0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 1.0, 0.0, 1.0, 0.0]);
        for ends in [Ends::NotAKnot, Ends::Slopes([0.0, 5.0]), Ends::Periodic] {
            let slopes = slopes(&times, &values, ends);
            let samples = (0..=40_000).map(|k| value_and_rate(&times, &values, &slopes, k as f64 * 1e-4));
            let seen = samples.fold([0.0, 0.0], |[a, b], (v, r)| [f64::max(a, v.abs()), f64::max(b, r.abs())]);
            let found = largest(&times, &values, &slopes);
            for k in 0..2 {
                assert!((found[k] - seen[k]).abs() < 1e-7, "{ends:?}: {found:?} against {seen:?}");
            }
        }
    }
}
