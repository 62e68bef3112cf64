//! Closed shapes at their places in the box.

use crate::bounds::{Bounds, are_near, grid, shared};
use crate::plane::Outline;
use crate::region::Region;
use crate::segment::crosses;
use crate::space::Solid;
use crate::vector::{dot, minus};

/// Samples along each side of the bounding box of a body, by which its area or volume is measured.
const SAMPLES: [usize; 2] = [24, 16];

/// Samples along each side of what the bounding boxes of two solids share.
const SHARED: usize = 8;

/// Crossings of two outlines that overlap without a corner of one in the other.
const CROSSINGS: usize = 4;

/// A closed shape at its place.
#[derive(Clone, Debug)]
pub struct Placed<R, const D: usize> {
    region: R,
    /// Its own axes in those of the box.
    axes: [[f64; D]; D],
    /// Origin of its own axes, m.
    origin: [f64; D],
    pub(crate) bounds: Bounds<D>,
}

impl<R: Region<D>, const D: usize> Placed<R, D> {
    /// Place a shape whose own axes have these directions and this origin (m).
    pub fn new(region: R, axes: [[f64; D]; D], origin: [f64; D]) -> Self {
        let bounds = std::array::from_fn(|d| {
            let along = axes.map(|axis| axis[d]);
            [origin[d] - region.extent(along.map(|part| -part)), origin[d] + region.extent(along)]
        });
        Self { region, axes, origin, bounds }
    }

    /// Cut the bounding box of a shape without ends at the `ends` of the box, m.
    pub fn clamped(mut self, ends: &[[f64; 2]]) -> Self {
        for (own, [low, high]) in self.bounds.iter_mut().zip(ends) {
            *own = own.map(|at| at.clamp(*low, *high));
        }
        self
    }

    /// Return the signed distance of a point from the surface, m, positive outside.
    pub fn distance(&self, point: [f64; D]) -> f64 {
        let from = minus(point, self.origin);
        self.region.nearest(self.axes.map(|axis| dot(axis, from))).distance
    }

    /// Return the diameter of the largest ball inside, m.
    pub fn thickness(&self) -> f64 {
        self.region.thickness()
    }

    /// Return the corners, or points of a round outline, m.
    pub fn corners(&self) -> Vec<[f64; D]> {
        let placed = |own: &[f64; D]| {
            std::array::from_fn(|d| self.origin[d] + (0..D).map(|k| own[k] * self.axes[k][d]).sum::<f64>())
        };
        self.region.corners().iter().map(placed).collect()
    }

    /// Return the share of the area or volume whose points have `property`.
    pub(crate) fn share(&self, property: impl Fn([f64; D]) -> bool) -> f64 {
        let inside: Vec<_> = grid(self.bounds, SAMPLES[D - 2]).filter(|p| self.distance(*p) <= 0.0).collect();
        share(if inside.is_empty() { vec![self.origin] } else { inside }, property)
    }

    /// Return whether the shape has points in the share of both bounding boxes that the other has too.
    fn has_common_points(&self, other: &Self, depth: f64) -> bool {
        let bounds = shared(&self.bounds, &other.bounds);
        bounds.iter().all(|[low, high]| high - low > depth)
            && grid(bounds, SHARED).any(|p| self.distance(p) <= 0.0 && other.distance(p) <= 0.0)
    }
}

/// Return the share of points with a property.
pub(crate) fn share<T>(points: impl IntoIterator<Item = T>, property: impl Fn(T) -> bool) -> f64 {
    let (all, some) = points.into_iter().fold((0, 0), |(all, some), p| (all + 1, some + i32::from(property(p))));
    f64::from(some) / f64::from(all.max(1))
}

impl Placed<Outline, 2> {
    /// Return whether two outlines overlap by more than `depth` (m) at a corner, or cross.
    pub(crate) fn overlaps(&self, other: &Self, depth: f64) -> bool {
        if !are_near(&self.bounds, &other.bounds, 0.0) {
            return false;
        }
        let (own, others) = (self.corners(), other.corners());
        let sides = |of: &[[f64; 2]]| (0..of.len()).map(|i| [of[i], of[(i + 1) % of.len()]]).collect::<Vec<_>>();
        let enters = |corners: &[[f64; 2]], of: &Self| corners.iter().any(|p| of.distance(*p) < -depth);
        let (one, two) = (sides(&own), sides(&others));
        let crossings = one.iter().flat_map(|a| two.iter().filter(|b| crosses(*a, **b)));
        enters(&own, other) || enters(&others, self) || crossings.take(CROSSINGS).count() == CROSSINGS
    }
}

impl Placed<Solid, 3> {
    /// Return whether the bounding boxes of two solids share more than `depth` (m) along each axis, and points of both.
    pub(crate) fn overlaps(&self, other: &Self, depth: f64) -> bool {
        self.has_common_points(other, depth)
    }

    /// Return whether a straight line along `axis` meets the solid wherever it passes the section with these `ends`, m.
    pub(crate) fn covers(&self, axis: usize, ends: &[[f64; 2]]) -> bool {
        let mut section: Bounds<3> = [ends[0], ends[1], ends[2]];
        section[axis] = [self.origin[axis]; 2];
        let ([low, high], n) = (self.bounds[axis], SAMPLES[1]);
        grid(section, n).all(|mut p| {
            (0..=n).any(|i| {
                p[axis] = low + (high - low) * i as f64 / n as f64;
                self.distance(p) <= 0.0
            })
        })
    }

    /// Return points by which two solids of one kind and size are the same; a ball has no directions.
    pub(crate) fn marks(&self) -> Vec<[f64; 3]> {
        let [a, b, c] = self.region.half_lengths();
        let mut own = self.clone();
        if !matches!(self.region, Solid::Cuboid(_)) && a == b && b == c {
            own.axes = std::array::from_fn(|d| std::array::from_fn(|e| f64::from(u8::from(d == e))));
        }
        own.corners()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bar(x: f64, y: f64, at: [f64; 2]) -> Placed<Outline, 2> {
        Placed::new(Outline::Rectangle([x, y]), [[1.0, 0.0], [0.0, 1.0]], at)
    }

    #[test]
    fn an_outline_knows_its_inside_its_depth_and_its_overlaps() {
        let (long, high) = (bar(2.0, 0.25, [0.0; 2]), bar(0.25, 2.0, [0.0; 2]));
        let is_inside = |p| long.distance(p) <= 0.0;
        assert!(is_inside([1.9, 0.2]) && !is_inside([1.9, 0.3]) && !is_inside([-2.1, 0.0]));
        assert!((long.distance([1.9, 0.0]) + 0.1).abs() < 1e-15 && long.distance([3.0, 0.0]) == 1.0);
        assert!(long.overlaps(&high, 0.1), "no corner lies inside the other bar");
        let share = long.share(|p| high.distance(p) <= 0.0);
        assert!((share - 0.125).abs() < 0.05, "{share}");
        let end = |y: f64| long.overlaps(&bar(2.0, 0.25, [3.8, y]), 0.05);
        assert!(end(0.1) && !end(0.46));
    }

    #[test]
    fn a_solid_knows_its_bounds_its_volume_and_its_overlaps() {
        // Its length lies along z and its width along x; the origin is below the end of its length.
        let axes = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let plate = Placed::new(Solid::Cuboid([1.0, 0.5, 0.1]), axes, [0.5, 0.0, -1.0]);
        assert_eq!(plate.bounds, [[0.0, 1.0], [-0.1, 0.1], [-2.0, 0.0]]);
        let straight = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let ball = |x: f64, radius| Placed::new(Solid::Sphere(radius), straight, [x, 0.0, 0.0]);
        assert!((ball(0.0, 0.5).share(|p| p[0] > 0.25) - 5.0 / 32.0).abs() < 0.02);
        assert!(ball(0.0, 0.5).overlaps(&ball(0.9, 0.5), 0.05) && !ball(0.0, 0.5).overlaps(&ball(1.01, 0.5), 0.0));
        let tube = Solid::Cylinder { axis: 1, radius: 0.5, half_length: f64::INFINITY };
        let tube = Placed::new(tube, straight, [0.0; 3]).clamped(&[[-2.0, 2.0]; 3]);
        assert_eq!(tube.bounds[1], [-2.0, 2.0]);
        assert!(!tube.covers(0, &[[-2.0, 2.0]; 3]) && tube.covers(0, &[[-2.0, 2.0], [-2.0, 2.0], [-0.4, 0.4]]));
    }
}
