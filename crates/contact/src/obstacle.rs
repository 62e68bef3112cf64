//! Solids in the way, still or moved, with their closest points.

use geometry::plane::Outline;
use geometry::space::Solid;
use nalgebra::{SMatrix, SVector};

use crate::feature::Feature;

/// Arm of the friction of a disk that spins on a face, over its radius.
const MEAN_ARM: f64 = 2.0 / 3.0;

/// A solid at its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle<const D: usize> {
    solid: Body<D>,
    /// Its place.
    pub pose: Pose<D>,
}

/// A solid in its own axes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Body<const D: usize> {
    /// All points with a negative first component.
    HalfSpace,
    /// All points closer than `radius` to a block with these halves of its lengths, m, which may be 0 or infinite.
    Block { half: [f64; D], radius: f64 },
    /// All points closer than `round` to a circular cylinder with flat ends along an axis, m; only in space.
    Cylinder { axis: usize, radius: f64, half_length: f64, round: f64 },
}

/// Place of a solid: directions of its own axes and their origin, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<const D: usize> {
    /// Unit vectors along its own axes.
    pub axes: [SVector<f64, D>; D],
    /// Origin of its own axes, m.
    pub origin: SVector<f64, D>,
}

/// Closest point of a surface, by the Euclidean distance; its level lines round corners.
#[derive(Clone, Copy, Debug)]
pub struct Nearest<const D: usize> {
    /// Signed distance, m, positive outside.
    pub distance: f64,
    /// Gradient of the distance: the unit normal outwards.
    pub normal: SVector<f64, D>,
    /// Second derivative of the distance, 1/m.
    pub curvature: SMatrix<f64, D, D>,
}

impl<const D: usize> Pose<D> {
    /// Return the pose of a solid in the axes of the box.
    pub fn at(origin: [f64; D]) -> Self {
        Self { axes: std::array::from_fn(unit), origin: origin.into() }
    }

    /// Return a point of the solid's axes in those of the box.
    pub fn place(&self, own: SVector<f64, D>) -> SVector<f64, D> {
        self.origin + self.along(own)
    }

    /// Return a point of the box in the solid's axes.
    pub fn own(&self, p: SVector<f64, D>) -> SVector<f64, D> {
        self.across(p - self.origin)
    }

    /// Return a vector of the box in the solid's axes.
    pub(crate) fn across(&self, vector: SVector<f64, D>) -> SVector<f64, D> {
        SVector::from_fn(|d, _| self.axes[d].dot(&vector))
    }

    /// Return a vector of the solid's axes in those of the box.
    pub(crate) fn along(&self, own: SVector<f64, D>) -> SVector<f64, D> {
        self.axes.iter().zip(own.iter()).map(|(axis, part)| axis * *part).sum()
    }

    /// Return the pose with the same axes and a point of the solid's axes in a place, m.
    pub fn about(&self, place: SVector<f64, D>, own: SVector<f64, D>) -> Self {
        Self { axes: self.axes, origin: place - self.along(own) }
    }

    /// Return the pose after the fraction `share` of the way to another one, less than a right angle away.
    pub fn towards(&self, other: &Self, share: f64) -> Self {
        let axes = std::array::from_fn(|d| self.axes[d] * (1.0 - share) + other.axes[d] * share);
        Self { axes: orthonormal(axes), origin: self.origin * (1.0 - share) + other.origin * share }
    }
}

impl<const D: usize> Obstacle<D> {
    /// Return all points behind a plane through `point` (m) with this normal outwards, of any length.
    pub fn plane(point: [f64; D], normal: [f64; D]) -> Self {
        let normal = SVector::from(normal).normalize();
        let largest = normal.iamax();
        let others: [_; D] = std::array::from_fn(|d| if d == 0 { normal } else { unit((largest + d) % D) });
        Self { solid: Body::HalfSpace, pose: Pose { axes: orthonormal(others), origin: point.into() } }
    }

    /// Return all points closer than `radius` (m) to a block along the axes of the box: a ball, a capsule, a block.
    pub fn block(middle: [f64; D], half: [f64; D], radius: f64) -> Self {
        Self { solid: Body::Block { half, radius }, pose: Pose::at(middle) }
    }

    /// Return the closest point to `p` (m).
    pub fn nearest(&self, p: SVector<f64, D>) -> Nearest<D> {
        self.nearest_at(&self.pose, p)
    }

    /// Return the closest point to `p` (m) of the obstacle at another place.
    pub fn nearest_at(&self, pose: &Pose<D>, p: SVector<f64, D>) -> Nearest<D> {
        let Nearest { distance, normal, curvature } = self.nearest_own(pose.own(p));
        let axes = SMatrix::<f64, D, D>::from_columns(&pose.axes);
        Nearest { distance, normal: axes * normal, curvature: axes * curvature * axes.transpose() }
    }

    /// Return the same for a point in the solid's axes, also in these.
    pub(crate) fn nearest_own(&self, own: SVector<f64, D>) -> Nearest<D> {
        let (distance, normal, curvature) = match &self.solid {
            Body::HalfSpace => (own[0], unit(0), SMatrix::zeros()),
            Body::Block { half, radius } => nearest_of_block(own, half, *radius),
            Body::Cylinder { axis, radius, half_length, round } => {
                let (distance, normal, curvature) = nearest_of_cylinder(own, *axis, *radius, *half_length);
                (distance - round, normal, curvature)
            }
        };
        Nearest { distance, normal, curvature }
    }
}

/// What contact of two solids needs of each.
impl<const D: usize> Obstacle<D> {
    /// Return whether the contact of two solids is known: not that of two half spaces, nor of a cylinder without ends with
    /// a half space or another one.
    pub fn can_touch(&self, other: &Self) -> bool {
        let is_ball = |of: &Self| of.ball_radius().is_some();
        let is_endless = |of: &Self| of.is_half_space() || of.reach() == f64::INFINITY;
        is_ball(self) || is_ball(other) || !(is_endless(self) && is_endless(other))
    }

    /// Return the radius of a ball, m; none of another solid.
    pub(crate) fn ball_radius(&self) -> Option<f64> {
        if let Body::Block { half, radius } = self.solid { (half == [0.0; D]).then_some(radius) } else { None }
    }

    /// Return the ends of the axis of a capsule, m; none of another solid.
    pub(crate) fn line(&self) -> Option<[SVector<f64, D>; 2]> {
        let Body::Block { half, .. } = self.solid else { return None };
        let lengths = half.iter().filter(|half| **half > 0.0).count();
        (lengths == 1).then(|| [-SVector::from(half), SVector::from(half)])
    }

    /// Return whether it is all that lies behind a plane.
    pub fn is_half_space(&self) -> bool {
        self.solid == Body::HalfSpace
    }

    /// Return the points by which it touches, each with [`Self::radius`]: the corners of its block, m.
    pub(crate) fn points(&self) -> Vec<SVector<f64, D>> {
        if let Body::Block { half, .. } = self.solid { corners(&half) } else { Vec::new() }
    }

    /// Return the edges and faces that find all contacts with another solid, and that lie steady on it: of a cuboid its
    /// edges, of a capsule its line and ends, of a cylinder its ends and points on them where friction acts on the mean, for
    /// another cylinder also itself. There are none of a solid without ends.
    pub(crate) fn features(&self, other: &Self) -> Vec<Feature<D>> {
        let none = SVector::<f64, D>::zeros();
        match self.solid {
            _ if self.reach() == f64::INFINITY => Vec::new(),
            Body::HalfSpace => Vec::new(),
            Body::Block { half, .. } => {
                let along = |axis: usize| {
                    let flat = std::array::from_fn(|d| if d == axis { 0.0 } else { half[d] });
                    let ways = [none, none, unit::<D>(axis) * half[axis]];
                    corners(&flat).into_iter().map(move |middle| Feature { middle, ways })
                };
                let ends = self.line().into_iter().flatten().map(Feature::point);
                (0..D).filter(|axis| half[*axis] > 0.0).flat_map(along).chain(ends).collect()
            }
            Body::Cylinder { axis, radius, half_length, .. } => {
                let [one, two] = [1, 2].map(|by| unit::<D>((axis + by) % D) * radius);
                let line = unit::<D>(axis) * half_length;
                let whole = Feature { middle: none, ways: [one, two, line] };
                let faces = [line, -line].map(|middle| Feature { middle, ways: [one, two, none] });
                let on_face = |face: &Feature<D>| {
                    let middle = face.middle;
                    [one, -one, two, -two].map(|way| Feature::point(middle + way * MEAN_ARM))
                };
                let points: Vec<_> = faces.iter().flat_map(on_face).collect();
                let crosses = matches!(other.solid, Body::Cylinder { .. });
                crosses.then_some(whole).into_iter().chain(faces).chain(points).collect()
            }
        }
    }

    /// Return the solid with edges rounded by a radius (m) of at most half its thickness; a solid that is round stays.
    pub(crate) fn rounded(&self, by: f64) -> Self {
        let solid = match self.solid {
            Body::Block { half, radius: 0.0 } => {
                Body::Block { half: half.map(|half| (half - by).max(0.0)), radius: by }
            }
            Body::Cylinder { axis, radius, half_length, .. } => {
                Body::Cylinder { axis, radius: radius - by, half_length: half_length - by, round: by }
            }
            ref same => *same,
        };
        Self { solid, pose: self.pose }
    }

    /// Return the radius of these points, m.
    pub(crate) fn radius(&self) -> f64 {
        if let Body::Block { radius, .. } = self.solid { radius } else { 0.0 }
    }

    /// Return half the thickness, m.
    pub fn half_thickness(&self) -> f64 {
        match self.solid {
            Body::HalfSpace => f64::INFINITY,
            Body::Block { half, radius } => half.into_iter().fold(f64::INFINITY, f64::min) + radius,
            Body::Cylinder { radius, half_length, round, .. } => radius.min(half_length) + round,
        }
    }

    /// Return the distance of its farthest point from the origin of its axes, m.
    pub(crate) fn reach(&self) -> f64 {
        match self.solid {
            Body::HalfSpace => f64::INFINITY,
            Body::Block { half, radius } => SVector::from(half).norm() + radius,
            Body::Cylinder { radius, half_length, round, .. } => radius.hypot(half_length) + round,
        }
    }
}

impl Obstacle<2> {
    /// Return the obstacle of an outline at a place; `None` for an ellipse and a polygon.
    pub fn of_outline(outline: &Outline, pose: Pose<2>) -> Option<Self> {
        let (half, radius) = match *outline {
            Outline::Circle(radius) => ([0.0; 2], radius),
            Outline::Rectangle(half) => (half, 0.0),
            Outline::Capsule([half, radius]) => ([half, 0.0], radius),
            Outline::Ellipse(_) | Outline::Polygon(_) => return None,
        };
        Some(Self { solid: Body::Block { half, radius }, pose })
    }
}

impl Obstacle<3> {
    /// Return the obstacle of a solid at a place; `None` for an ellipsoid.
    pub fn of_solid(solid: &Solid, pose: Pose<3>) -> Option<Self> {
        let along = |axis: usize, half: f64| std::array::from_fn(|d| if d == axis { half } else { 0.0 });
        let solid = match *solid {
            Solid::Sphere(radius) => Body::Block { half: [0.0; 3], radius },
            Solid::Cuboid(half) => Body::Block { half, radius: 0.0 },
            Solid::Capsule { axis, radius, half_length } => Body::Block { half: along(axis, half_length), radius },
            Solid::Cylinder { axis, radius, half_length } => Body::Cylinder { axis, radius, half_length, round: 0.0 },
            Solid::Ellipsoid(_) => return None,
        };
        Some(Self { solid, pose })
    }
}

/// Return the corners of a block, m, which has fewer where halves of its lengths are 0.
fn corners<const D: usize>(half: &[f64; D]) -> Vec<SVector<f64, D>> {
    half.iter().enumerate().filter(|(_, half)| **half > 0.0).fold(vec![SVector::zeros()], |points, (d, half)| {
        let shifted = |point: &SVector<f64, D>, to: f64| SVector::from_fn(|e, _| if e == d { to } else { point[e] });
        points.iter().flat_map(|point| [-half, *half].map(|to| shifted(point, to))).collect()
    })
}

/// Distance, normal and curvature.
type Local<const D: usize> = (f64, SVector<f64, D>, SMatrix<f64, D, D>);

fn unit<const D: usize>(axis: usize) -> SVector<f64, D> {
    SVector::from_fn(|d, _| f64::from(u8::from(d == axis)))
}

/// Return axes at right angles and of length 1 that follow the given ones (Gram and Schmidt).
fn orthonormal<const D: usize>(mut axes: [SVector<f64, D>; D]) -> [SVector<f64, D>; D] {
    for d in 0..D {
        let before: SVector<f64, D> = axes[..d].iter().map(|axis| axis * axis.dot(&axes[d])).sum();
        axes[d] = (axes[d] - before).normalize();
    }
    axes
}

fn nearest_of_block<const D: usize>(p: SVector<f64, D>, half: &[f64; D], radius: f64) -> Local<D> {
    let beyond = SVector::<f64, D>::from_fn(|d, _| p[d].abs() - half[d]);
    let off = SVector::<f64, D>::from_fn(|d, _| if beyond[d] > 0.0 { beyond[d].copysign(p[d]) } else { 0.0 });
    let distance = off.norm();
    if distance == 0.0 {
        let face = beyond.imax();
        return (beyond[face] - radius, unit::<D>(face) * 1_f64.copysign(p[face]), SMatrix::zeros());
    }
    let normal = off / distance;
    // Beyond an edge or a corner the distance is that of a circle or a ball, across the axes beyond.
    let mut curvature = normal * -normal.transpose();
    (0..D).filter(|&d| off[d] != 0.0).for_each(|d| curvature[(d, d)] += 1.0);
    (distance - radius, normal, curvature / distance)
}

fn nearest_of_cylinder<const D: usize>(p: SVector<f64, D>, axis: usize, radius: f64, half_length: f64) -> Local<D> {
    let (along, mut outwards) = (unit::<D>(axis) * 1_f64.copysign(p[axis]), p);
    outwards[axis] = 0.0;
    let from_axis = outwards.norm().max(f64::MIN_POSITIVE);
    outwards /= from_axis;
    // In the half plane of axis and point the cylinder is a rectangle.
    let beyond = [from_axis - radius, p[axis].abs() - half_length];
    let rim = beyond[0].max(0.0).hypot(beyond[1].max(0.0));
    let (distance, parts, bend) = if beyond[0] > 0.0 && beyond[1] > 0.0 {
        (rim, beyond.map(|own| own / rim), 1.0 / rim)
    } else if beyond[0] > beyond[1] {
        (beyond[0], [1.0, 0.0], 0.0)
    } else {
        (beyond[1], [0.0, 1.0], 0.0)
    };
    let (normal, tangent) = (outwards * parts[0] + along * parts[1], outwards * parts[1] - along * parts[0]);
    let around = SMatrix::<f64, D, D>::identity() - along * along.transpose() - outwards * outwards.transpose();
    (distance, normal, tangent * tangent.transpose() * bend + around * (parts[0] / from_axis))
}

#[cfg(test)]
mod tests {
    use super::*;

    type V = SVector<f64, 3>;

    /// A plate, a ball, a capsule, a cylinder and a half space, all turned and shifted.
    fn obstacles() -> Vec<Obstacle<3>> {
        let pose = Pose {
            axes: orthonormal([V::new(0.6, 0.7, -0.2), V::new(-0.3, 0.5, 0.9), V::new(0.4, -0.5, 0.3)]),
            origin: V::new(0.3, -0.2, 0.1),
        };
        let solids = [
            Solid::Cuboid([0.5, 0.3, 0.1]),
            Solid::Sphere(0.4),
            Solid::Capsule { axis: 1, radius: 0.2, half_length: 0.4 },
            Solid::Cylinder { axis: 2, radius: 0.3, half_length: 0.2 },
            Solid::Cylinder { axis: 0, radius: 0.3, half_length: f64::INFINITY },
        ];
        let solids = solids.iter().map(|solid| Obstacle::of_solid(solid, pose).expect("no ellipsoid"));
        solids.chain([Obstacle::plane([0.1, 0.2, 0.3], [1.0, -2.0, 0.5])]).collect()
    }

    #[test]
    fn normal_and_curvature_are_derivatives_of_the_distance() {
        for (i, obstacle) in obstacles().iter().enumerate() {
            for k in 0..200 {
                let part = |d: u32| f64::from((k * (7 + 6 * d) + 3 * d) % 97) / 97.0 * 2.4 - 1.2;
                let (p, step) = (V::new(part(0), part(1), part(2)), 1e-5);
                let found = obstacle.nearest(p);
                if found.distance < 0.02 {
                    continue; // inside a solid the nearest face may change
                }
                for d in 0..3 {
                    let [low, high] = [-step, step].map(|step| obstacle.nearest(p + unit::<3>(d) * step));
                    let slope = (high.distance - low.distance) / (2.0 * step);
                    let column = (high.normal - low.normal) / (2.0 * step);
                    let kink = (found.curvature.column(d) - column).norm();
                    assert!((slope - found.normal[d]).abs() < 1e-4, "{i}, {k}, {d}: {slope} for {found:?}");
                    // A ball's part begins where a face ends.
                    assert!(kink < 1e-3 || (high.curvature - low.curvature).norm() > 1e-2, "{i}, {k}, {d}: {column}");
                }
            }
        }
    }

    #[test]
    fn closest_points_of_simple_solids_are_known() {
        let cuboid = Obstacle::block([0.0; 3], [0.5, 0.3, 0.1], 0.0);
        let distances =
            [[0.8, 0.7, 0.1], [0.8, 0.0, 0.0], [0.1, -0.2, 0.05]].map(|p| cuboid.nearest(p.into()).distance);
        for (found, expected) in distances.into_iter().zip([0.5, 0.3, -0.05]) {
            assert!((found - expected).abs() < 1e-15, "{found}, not {expected}");
        }
        let plane = Obstacle::plane([0.0, 1.0], [3.0, 4.0]);
        assert!((plane.nearest([3.0, 5.0].into()).distance - 5.0).abs() < 1e-15);
        let quarter = Pose { axes: [SVector::from([0.0, 1.0]), SVector::from([-1.0, 0.0])], origin: SVector::zeros() };
        let half = Pose::at([0.0; 2]).towards(&quarter, 0.5);
        assert!((half.axes[0] - SVector::from([0.5_f64.sqrt(); 2])).norm() < 1e-15, "{half:?}");
        assert_eq!(Pose::at([0.0; 2]).towards(&quarter, 1.0), quarter);
    }
}
