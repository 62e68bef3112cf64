//! Search for neighbours in cells of equal size.

use std::iter::successors;

/// Most parts that a station may touch; more are an error of the scene.
pub const MOST_PARTNERS: usize = 32;

/// No point.
const NONE: u32 = u32::MAX;

/// Points sorted into cells by a hash of their place.
#[derive(Clone, Debug)]
pub struct Cells<const D: usize> {
    /// Length of a cell, m.
    size: f64,
    /// First point of each hash.
    first: Vec<u32>,
    /// Next point with the same hash.
    next: Vec<u32>,
    /// Cell of each point.
    cell: Vec<[i64; D]>,
}

impl<const D: usize> Cells<D> {
    /// Make room for so many points.
    pub fn new(points: usize) -> Self {
        let hashes = (2 * points).next_power_of_two();
        Self { size: 1.0, first: vec![NONE; hashes], next: vec![NONE; points], cell: vec![[0; D]; points] }
    }

    /// Sort the points (m) into cells of this size, m; allocate nothing.
    pub fn sort(&mut self, size: f64, points: impl Iterator<Item = [f64; D]>) {
        self.size = size;
        self.first.fill(NONE);
        for (k, p) in points.enumerate() {
            self.cell[k] = self.cell_of(p);
            let hash = self.hash(self.cell[k]);
            self.next[k] = std::mem::replace(&mut self.first[hash], k as u32);
        }
    }

    /// Visit all points at most one size from `p` (m), and some that are farther.
    pub fn visit(&self, p: [f64; D], mut visit: impl FnMut(usize)) {
        let middle = self.cell_of(p);
        for k in 0..3_usize.pow(D as u32) {
            let cell = std::array::from_fn(|d| middle[d] + (k / 3_usize.pow(d as u32) % 3) as i64 - 1);
            let next = |k: u32| (k != NONE).then_some(k);
            let all = successors(next(self.first[self.hash(cell)]), |&k| next(self.next[k as usize]));
            all.map(|k| k as usize).filter(|&k| self.cell[k] == cell).for_each(&mut visit);
        }
    }

    fn cell_of(&self, p: [f64; D]) -> [i64; D] {
        p.map(|at| (at / self.size).floor() as i64)
    }

    fn hash(&self, cell: [i64; D]) -> usize {
        // Large odd factors, as of Teschner et al. (2003).
        const FACTORS: [i64; 3] = [73_856_093, 19_349_663, 83_492_791];
        let mixed = cell.iter().zip(FACTORS).fold(0, |hash: i64, (at, factor)| hash ^ at.wrapping_mul(factor));
        mixed as usize & (self.first.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_those_of_all_pairs_and_come_once() {
        let part = |k: usize, d: usize| (((k * (d + 7) + 3) * 37) % 101) as f64 / 101.0 - 0.5;
        let points: Vec<_> = (0..200).map(|k| [0, 1, 2].map(|d| part(k, d))).collect();
        let (mut cells, size) = (Cells::new(points.len()), 0.2);
        for _ in 0..2 {
            cells.sort(size, points.iter().copied());
        }
        let mut pairs = 0;
        for p in &points {
            let near = |q: &[f64; 3]| (0..3).map(|d| (p[d] - q[d]).powi(2)).sum::<f64>() <= size * size;
            let mut found = Vec::new();
            cells.visit(*p, |k| found.push(k));
            found.sort_unstable();
            assert!(found.windows(2).all(|pair| pair[0] < pair[1]), "{found:?}");
            found.retain(|k| near(&points[*k]));
            let expected: Vec<_> = (0..points.len()).filter(|k| near(&points[*k])).collect();
            assert_eq!(found, expected);
            pairs += found.len();
        }
        assert!(pairs > 2 * points.len(), "{pairs} pairs");
    }
}
