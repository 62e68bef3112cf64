//! Shapes of all kinds in the box, and where they touch.

use crate::bounds::{Bounds, are_near, around, grown, shared};
use crate::chain::Chain;
use crate::placed::{Placed, share};
use crate::plane::Outline;
use crate::segment;
use crate::space::Solid;
use crate::surface::Surface;
use crate::triangle::{ROUNDING, reaches};
use crate::vector::{between, minus, norm};

/// Parts of an edge at whose ends it is sought in a body.
const PARTS: usize = 8;

/// A body, a beam or a wing at its place.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A body in the plane.
    Outline(Placed<Outline, 2>),
    /// A body in space.
    Solid(Placed<Solid, 3>),
    /// A surface in space.
    Surface(Surface),
    /// A beam, or a line of no thickness.
    Chain(Chain),
}

/// Where a shape touches another.
#[derive(Clone, Debug, PartialEq)]
pub enum Touch {
    /// Somewhere.
    Whole,
    /// At these edges or triangles.
    At(Vec<usize>),
}

impl Shape {
    /// Return the bounding box, m; along z 0 in the plane.
    pub fn bounds(&self) -> Bounds<3> {
        match self {
            Self::Outline(body) => [body.bounds[0], body.bounds[1], [0.0; 2]],
            Self::Solid(body) => body.bounds,
            Self::Surface(surface) => surface.bounds,
            Self::Chain(chain) => chain.bounds,
        }
    }

    /// Return the signed distance of a point from a body, m, positive outside; infinite for what has no inside.
    pub fn distance(&self, [x, y, z]: [f64; 3]) -> f64 {
        match self {
            Self::Outline(body) => body.distance([x, y]),
            Self::Solid(body) => body.distance([x, y, z]),
            Self::Surface(_) | Self::Chain(_) => f64::INFINITY,
        }
    }

    /// Return the diameter of the largest ball inside, m.
    pub fn thickness(&self) -> f64 {
        match self {
            Self::Outline(body) => body.thickness(),
            Self::Solid(body) => body.thickness(),
            Self::Surface(_) | Self::Chain(_) => 0.0,
        }
    }

    /// Return points by which two shapes of one kind and size are the same, m.
    fn marks(&self) -> Vec<[f64; 3]> {
        match self {
            Self::Outline(body) => body.corners().into_iter().map(|[x, y]| [x, y, 0.0]).collect(),
            Self::Solid(body) => body.marks(),
            Self::Surface(Surface { nodes: points, .. }) | Self::Chain(Chain { points, .. }) => points.clone(),
        }
    }

    /// Return the share of the shape whose points have `property`.
    pub fn share(&self, property: impl Fn([f64; 3]) -> bool) -> f64 {
        match self {
            Self::Outline(body) => body.share(|[x, y]| property([x, y, 0.0])),
            Self::Solid(body) => body.share(property),
            Self::Surface(surface) => surface.share(property),
            Self::Chain(chain) => {
                let parts = segment::sides(&chain.points)
                    .flat_map(|[a, b]| (0..=PARTS).map(move |i| between(a, b, i as f64 / PARTS as f64)));
                share(parts, property)
            }
        }
    }

    /// Return whether a point lies inside or on the shape.
    fn has(&self, p: [f64; 3]) -> bool {
        match self {
            Self::Surface(surface) => surface.has(p),
            Self::Chain(chain) => chain.distance_of(p) <= ROUNDING * chain.length(),
            _ => self.distance(p) <= 0.0,
        }
    }

    /// Return the larger of both shares of two shapes that lie inside or on each other.
    pub fn shared(&self, other: &Self) -> f64 {
        let part = |one: &Self, other: &Self| match (one, other) {
            (Self::Outline(_) | Self::Solid(_), Self::Surface(_) | Self::Chain(_)) => 0.0,
            _ => one.share(|p| other.has(p)),
        };
        let near = are_near(&self.bounds(), &other.bounds(), 0.0);
        if near { f64::max(part(self, other), part(other, self)) } else { 0.0 }
    }

    /// Return whether a straight line along `axis` meets the shape wherever it passes the section with these `ends` (m)
    /// that its bounding box covers.
    pub fn covers(&self, axis: usize, ends: &[[f64; 2]]) -> bool {
        match self {
            Self::Outline(_) => true,
            Self::Solid(body) => body.covers(axis, ends),
            Self::Surface(surface) => surface.covers(axis, ends),
            Self::Chain(_) => ends.len() == 2,
        }
    }

    /// Return whether the image of the shape in the plane across `axis` at `middle` is one of `all`, to `close`, m.
    pub fn is_mirrored(&self, all: &[Self], axis: usize, middle: f64, close: f64) -> bool {
        let image = |mut p: [f64; 3]| {
            p[axis] = 2.0 * middle - p[axis];
            p
        };
        let (points, others): (Vec<_>, Vec<_>) = (self.marks(), all.iter().map(Self::marks).collect());
        let is_near = |p: [f64; 3], other: &[[f64; 3]]| other.iter().any(|q| norm(minus(p, *q)) <= close);
        others.iter().any(|other: &Vec<_>| points.iter().all(|p| is_near(image(*p), other)))
    }

    /// Return where `other` touches the shape: closed shapes that overlap by more than `depth` (m), surfaces that are
    /// closer than it, edges of a chain by its thickness.
    pub fn touched_by(&self, other: &Self, depth: f64) -> Option<Touch> {
        let whole = |touched: bool| touched.then_some(Touch::Whole);
        if !are_near(&self.bounds(), &other.bounds(), depth) {
            return None;
        }
        match (self, other) {
            (Self::Outline(a), Self::Outline(b)) => whole(a.overlaps(b, depth)),
            (Self::Solid(a), Self::Solid(b)) => whole(a.overlaps(b, depth)),
            (Self::Surface(a), Self::Surface(b)) => whole(a.meets(b, depth) || b.meets(a, depth)),
            (Self::Surface(a), Self::Solid(b)) => whole(a.share(|p| b.distance(p) <= 0.0) > 0.0),
            (_, Self::Chain(chain)) => at(chain.edges().map(|(edge, half)| self.reaches(edge, half))),
            (Self::Chain(chain), Self::Surface(surface)) => {
                let meets = |k| chain.edges().any(|(edge, half)| reaches(edge, surface.triangle(k), half));
                let near = |k| are_near(&chain.bounds, &around(&surface.triangle(k)), 0.0);
                at((0..surface.triangles.len()).map(|k| near(k) && meets(k)))
            }
            (Self::Solid(body), Self::Surface(surface)) => {
                let near = |k| are_near(&body.bounds, &around(&surface.triangle(k)), 0.0);
                let inside = |k| surface.points_of(k).any(|p| body.distance(p) <= 0.0);
                at((0..surface.triangles.len()).map(|k| near(k) && inside(k)))
            }
            (Self::Chain(_), Self::Outline(_) | Self::Solid(_)) => whole(other.touched_by(self, depth).is_some()),
            (Self::Outline(_), _) | (_, Self::Outline(_)) => None,
        }
    }

    /// Return whether an edge with half its thickness (m) touches the shape.
    fn reaches(&self, edge: [[f64; 3]; 2], half: f64) -> bool {
        let bounds = grown(around(&edge), half);
        if !are_near(&self.bounds(), &bounds, 0.0) {
            return false;
        }
        match self {
            Self::Outline(_) | Self::Solid(_) => {
                (0..=PARTS).any(|i| self.distance(between(edge[0], edge[1], i as f64 / PARTS as f64)) < half)
            }
            Self::Surface(surface) => surface.near(&bounds, 0.0).iter().any(|own| reaches(edge, *own, half)),
            Self::Chain(chain) => chain.edges().any(|(own, thick)| {
                let crossing = ROUNDING * norm(minus(edge[1], edge[0]));
                segment::distance(own, edge) < f64::max(half + thick, crossing)
            }),
        }
    }

    /// Return the middle of what touches `other` there and the bounding box of `other` have in common, m.
    pub fn place(&self, touch: &Touch, other: &Self) -> [f64; 3] {
        let bounds = match (self, touch) {
            (_, Touch::Whole) => self.bounds(),
            (_, Touch::At(elements)) => {
                elements.iter().map(|k| self.element(*k)).reduce(joined).unwrap_or(self.bounds())
            }
        };
        shared(&bounds, &other.bounds()).map(|[low, high]| (low + high) / 2.0)
    }

    /// Return a chain or a surface whose points are elsewhere; a body stays.
    pub fn moved(&self, to: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        let all = |points: &[[f64; 3]]| points.iter().map(|p| to(*p)).collect();
        match self {
            Self::Chain(chain) => Self::Chain(chain.through(all(&chain.points))),
            Self::Surface(own) => Self::Surface(Surface::new(all(&own.nodes), own.triangles.clone())),
            _ => self.clone(),
        }
    }

    /// Return the number of edges of a chain or of triangles of a surface; of a body 1.
    pub fn elements(&self) -> usize {
        match self {
            Self::Chain(chain) => chain.half.len(),
            Self::Surface(surface) => surface.triangles.len(),
            _ => 1,
        }
    }

    /// Return the bounding box of an edge or a triangle, m; of a body its own.
    fn element(&self, k: usize) -> Bounds<3> {
        match self {
            Self::Chain(chain) => grown(around(&chain.points[k..k + 2]), chain.half[k]),
            Self::Surface(surface) => around(&surface.triangle(k)),
            _ => self.bounds(),
        }
    }

    /// Return the middle of an element, m.
    pub fn middle(&self, k: usize) -> [f64; 3] {
        self.element(k).map(|[low, high]| (low + high) / 2.0)
    }

    /// Return the size of an element, m: the length of an edge and half its thickness, or the diagonal.
    pub fn size(&self, k: usize) -> f64 {
        match self {
            Self::Chain(chain) => norm(minus(chain.points[k + 1], chain.points[k])) + chain.half[k],
            _ => norm(self.element(k).map(|[low, high]| high - low)),
        }
    }
}

/// Return the bounding box around two.
fn joined(a: Bounds<3>, b: Bounds<3>) -> Bounds<3> {
    std::array::from_fn(|d| [a[d][0].min(b[d][0]), a[d][1].max(b[d][1])])
}

/// Return the elements that touch; none where no one does.
fn at(touched: impl Iterator<Item = bool>) -> Option<Touch> {
    let elements: Vec<_> = touched.enumerate().filter_map(|(k, touched)| touched.then_some(k)).collect();
    (!elements.is_empty()).then_some(Touch::At(elements))
}
