//! Axes and bounding boxes.

/// Names of the axes.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// Least and largest place along each axis, m.
pub type Bounds<const D: usize> = [[f64; 2]; D];

/// Return how far `at` lies outside `[low, high]`, m.
pub fn beyond(at: f64, [low, high]: [f64; 2]) -> f64 {
    (low - at).max(at - high).max(0.0)
}

/// Return the bounding box of points.
pub(crate) fn around<'a, const D: usize>(points: impl IntoIterator<Item = &'a [f64; D]>) -> Bounds<D> {
    points.into_iter().fold([[f64::INFINITY, f64::NEG_INFINITY]; D], |bounds, p| {
        std::array::from_fn(|d| [bounds[d][0].min(p[d]), bounds[d][1].max(p[d])])
    })
}

/// Return a bounding box that is larger by `by` (m) on each side.
pub(crate) fn grown<const D: usize>(bounds: Bounds<D>, by: f64) -> Bounds<D> {
    bounds.map(|[low, high]| [low - by, high + by])
}

/// Return whether two bounding boxes are at most `gap` (m) apart along each axis.
pub(crate) fn are_near<const D: usize>(a: &Bounds<D>, b: &Bounds<D>, gap: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| a[0] <= b[1] + gap && b[0] <= a[1] + gap)
}

/// Return the pairs `[i, j]` with i < j of bounding boxes at most `gap` (m) apart along each axis, in the order of j and
/// i.
pub fn near_pairs(all: &[Bounds<3>], gap: f64) -> Vec<[usize; 2]> {
    let (mut order, mut found) = ((0..all.len()).collect::<Vec<_>>(), Vec::new());
    visit_near(all, &mut order, gap, |i, j| found.push([i.min(j), i.max(j)]));
    found.sort_unstable_by_key(|[i, j]| [*j, *i]);
    found
}

/// Visit each pair of bounding boxes at most `gap` (m) apart, in a search along x; `order` has all their numbers.
pub(crate) fn visit_near(all: &[Bounds<3>], order: &mut [usize], gap: f64, mut visit: impl FnMut(usize, usize)) {
    order.sort_unstable_by(|&i, &j| all[i][0][0].total_cmp(&all[j][0][0]));
    for (place, &i) in order.iter().enumerate() {
        let later = order[place + 1..].iter().take_while(|&&j| all[j][0][0] <= all[i][0][1] + gap);
        later.filter(|&&j| are_near(&all[i], &all[j], gap)).for_each(|&j| visit(i, j));
    }
}

/// Return what two bounding boxes share; where they are apart along an axis, the place between them there.
pub(crate) fn shared<const D: usize>(a: &Bounds<D>, b: &Bounds<D>) -> Bounds<D> {
    std::array::from_fn(|d| [a[d][0].max(b[d][0]), a[d][1].min(b[d][1])])
}

/// Return the middles of `n` parts of a bounding box along each axis.
pub(crate) fn grid<const D: usize>(bounds: Bounds<D>, n: usize) -> impl Iterator<Item = [f64; D]> {
    let at = move |[low, high]: [f64; 2], i: usize| low + (high - low) * (i as f64 + 0.5) / n as f64;
    (0..n.pow(D as u32)).map(move |k| std::array::from_fn(|d| at(bounds[d], k / n.pow((D - 1 - d) as u32) % n)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_pairs_are_those_of_all_pairs_in_their_order() {
        let part = |k: usize, d: usize| (((k * (d + 7) + 3) * 37) % 101) as f64 / 101.0;
        let all: Vec<Bounds<3>> =
            (0..60).map(|k| [0, 1, 2].map(|d| [part(k, d), part(k, d) + 0.6 * part(d, k)])).collect();
        for gap in [0.0, 0.1] {
            let pairs = (0..all.len()).flat_map(|j| (0..j).map(move |i| [i, j]));
            let expected: Vec<_> = pairs.filter(|[i, j]| are_near(&all[*i], &all[*j], gap)).collect();
            assert!(expected.len() > 20 && near_pairs(&all, gap) == expected, "{} pairs", expected.len());
        }
    }
}
