//! Order of the unknowns of a sparse matrix by nested dissection (George 1973, SIAM J. Numer. Anal. 10, 345).
//!
//! A part of the wing is cut across its longer side where the fewest unknowns couple with what lies beyond. These come
//! last, after both parts that they leave, which are cut in the same way. In a plane mesh of n nodes the factors then
//! have O(n log n) entries.

use crate::geometry::Vector;

/// Unknowns of one place count as one vertex; parts of so few vertices stay whole.
const LEAF: usize = 8;
/// Share of the vertices on one side of a cut.
const SHARE: f64 = 0.3;

/// Vertices of a matrix with their neighbours.
struct Graph<'a> {
    /// Ends of the edge of the mesh to which each vertex belongs, m; of a node twice the same.
    places: Vec<&'a [Vector; 2]>,
    /// Unknowns of each vertex, from `first[v]` on.
    first: Vec<usize>,
    /// Neighbours of vertex v from `begins[v]` on.
    begins: Vec<usize>,
    neighbours: Vec<u32>,
    /// Place of each vertex in its part.
    ranks: Vec<u32>,
    /// Vertices from the last one to the first.
    backwards: Vec<u32>,
}

/// Return the unknowns in their new order, by the pattern (column, row) of one triangle and the ends of the edge to which
/// each unknown belongs, m: `[order]`.
pub(crate) fn dissect(pattern: &[(u32, u32)], places: &[[Vector; 2]]) -> Vec<usize> {
    let mut vertices = Vec::with_capacity(places.len());
    let (mut first, mut own) = (Vec::new(), Vec::new());
    for (i, place) in places.iter().enumerate() {
        if i == 0 || *place != places[i - 1] {
            first.push(i);
            own.push(place);
        }
        vertices.push(first.len() as u32 - 1);
    }
    let pairs = pattern.iter().map(|&(i, j)| (vertices[i as usize], vertices[j as usize])).filter(|(v, w)| v != w);
    let mut pairs: Vec<_> = pairs.flat_map(|(v, w)| [(v, w), (w, v)]).collect();
    pairs.sort_unstable();
    pairs.dedup();
    let mut begins = vec![0; own.len() + 1];
    pairs.iter().for_each(|&(v, _)| begins[v as usize + 1] += 1);
    (0..own.len()).for_each(|v| begins[v + 1] += begins[v]);
    let mut all: Vec<_> = (0..own.len() as u32).collect();
    first.push(places.len());
    let mut graph = Graph {
        ranks: vec![0; own.len()],
        backwards: Vec::with_capacity(own.len()),
        places: own,
        first,
        begins,
        neighbours: pairs.iter().map(|&(_, w)| w).collect(),
    };
    graph.split(&mut all);
    let Graph { backwards, first, .. } = graph;
    backwards.iter().rev().flat_map(|&v| first[v as usize]..first[v as usize + 1]).collect()
}

impl Graph<'_> {
    /// Sort the vertices along their longest extent.
    fn sort(&self, part: &mut [u32]) {
        let ends = |v: u32| self.places[v as usize];
        let start = ends(part[0])[0];
        let bounds = |(low, high): (Vector, Vector), &v: &u32| (low.inf(&ends(v)[0]), high.sup(&ends(v)[0]));
        let (low, high) = part.iter().fold((start, start), bounds);
        let axis = (high - low).imax();
        // Of a triangle with one corner before a cut no edge lies there.
        let key = |v: u32| ends(v)[0][axis].max(ends(v)[1][axis]);
        part.sort_unstable_by(|&v, &w| key(v).total_cmp(&key(w)).then(v.cmp(&w)));
    }

    /// Append the order of a part.
    fn split(&mut self, part: &mut [u32]) {
        let count = part.len();
        if count <= LEAF {
            self.backwards.extend(part.iter().rev());
            return;
        }
        self.sort(part);
        (0..count).for_each(|i| self.ranks[part[i] as usize] = i as u32);
        // Last neighbour of each vertex, and the unknowns that couple with what lies beyond each cut.
        let mut last = vec![0; count];
        let mut change = vec![0_isize; count + 1];
        for (i, &v) in part.iter().enumerate() {
            let v = v as usize;
            let neighbours = &self.neighbours[self.begins[v]..self.begins[v + 1]];
            let ranks = neighbours.iter().map(|&w| (w, self.ranks[w as usize] as usize));
            last[i] = ranks.filter(|&(w, rank)| part.get(rank) == Some(&w)).map(|(_, rank)| rank).fold(i, usize::max);
            let unknowns = (self.first[v + 1] - self.first[v]) as isize;
            change[i + 1] += unknowns;
            change[last[i] + 1] -= unknowns;
        }
        let least = ((count as f64 * SHARE) as usize).max(1);
        let (mut size, mut best, mut cut) = (0, isize::MAX, count / 2);
        for (place, change) in change.iter().enumerate().take(count) {
            size += change;
            let nearer = place.abs_diff(count / 2) < cut.abs_diff(count / 2);
            if (least..=count - least).contains(&place) && (size < best || size == best && nearer) {
                (best, cut) = (size, place);
            }
        }
        let (before, after) = part.split_at_mut(cut);
        let (mut kept, mut separator) = (0, Vec::new());
        for i in 0..cut {
            if last[i] >= cut {
                separator.push(before[i]);
            } else {
                before[kept] = before[i];
                kept += 1;
            }
        }
        if !separator.is_empty() {
            self.sort(&mut separator);
        }
        self.backwards.extend(separator.iter().rev());
        self.split(after);
        if kept > 0 {
            self.split(&mut before[..kept]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_unknown_comes_once_and_the_last_ones_part_a_grid() {
        let (side, mut pattern) = (15, Vec::new());
        let number = |x: usize, y: usize| (y * side + x) as u32;
        for (x, y) in (0..side * side).map(|k| (k % side, k / side)) {
            pattern.extend((x + 1 < side).then(|| (number(x, y), number(x + 1, y))));
            pattern.extend((y + 1 < side).then(|| (number(x, y), number(x, y + 1))));
        }
        let place = |k: usize| [Vector::new((k % side) as f64, (k / side) as f64, 0.0); 2];
        let order = dissect(&pattern, &(0..side * side).map(place).collect::<Vec<_>>());
        let mut all = order.clone();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..side * side));
        // From the first unknown nothing reaches the one before the separator without it.
        let (parts, separator) = order.split_at(side * side - side);
        let mut reached = vec![parts[0]];
        let mut k = 0;
        while k < reached.len() {
            let own = reached[k] as u32;
            let pairs = pattern.iter().flat_map(|&(i, j)| [(i, j), (j, i)]);
            let next = pairs.filter(|(i, _)| *i == own).map(|(_, j)| j as usize);
            let new: Vec<_> = next.filter(|j| !separator.contains(j) && !reached.contains(j)).collect();
            reached.extend(new);
            k += 1;
        }
        assert!(!reached.contains(&parts[parts.len() - 1]), "{} of {}", reached.len(), parts.len());
    }
}
