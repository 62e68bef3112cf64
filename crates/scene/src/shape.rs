//! Shapes of rigid bodies: all that a scene knows of each. Their geometry is in `nervure-geometry`.

use geometry::plane::Outline;
use geometry::space::Solid;
use geometry::vector::{cross, dot, minus, norm};
use geometry::{lies_on, meets};
use method::Axis;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::{Check, Faults};
use crate::reference_scales::ACROSS;

/// Nodes, m, and the triangles between them.
type Triangles = (Vec<[f64; 3]>, Vec<[usize; 3]>);

/// Edges along the diameter of a disk: the area of its triangles is a thousandth smaller.
const DISK_EDGES: usize = 24;

/// Most triangles of a surface.
const MOST_TRIANGLES: usize = 100_000;

/// Outline of a body. The origin of its axes is its middle, except for a polygon or a polyline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// A circle.
    Circle {
        /// Radius, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        radius: f64,
    },
    /// An ellipse.
    Ellipse {
        /// Length of the axis along the body's x, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        length: f64,
        /// Length of the axis along the body's y, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        thickness: f64,
    },
    /// A rectangle.
    Rectangle {
        /// Length along the body's x, m, ends included.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        length: f64,
        /// Thickness along the body's y, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        thickness: f64,
        /// Form of the two ends along the body's x.
        #[serde(default)]
        ends: Ends,
    },
    /// A polygon.
    Polygon {
        /// Corners in order, either way round, m: 3 to 1000. The sides must not cross.
        #[schemars(length(min = 3, max = 1000))]
        corners: Vec<[f64; 2]>,
    },
    /// A flat plate of no thickness: markers drag the fluid, as at a beam with the surface `line`.
    Plate {
        /// Length along the body's x, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        length: f64,
        /// Width along the body's z, m; only in three dimensions.
        #[serde(default)]
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        width: Option<f64>,
    },
    /// An open line of no thickness, as a plate with corners.
    Polyline {
        /// Points in order, m: 2 to 1000. The sides must not cross.
        #[schemars(length(min = 2, max = 1000))]
        points: Vec<[f64; 2]>,
    },
    /// A sphere.
    Sphere {
        /// Radius, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        radius: f64,
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Lengths of the axes along the body's x, y and z, m.
        lengths: [f64; 3],
    },
    /// A cuboid; a plate is a thin one.
    Cuboid {
        /// Lengths along the body's x, y and z, m.
        lengths: [f64; 3],
    },
    /// A disk of no thickness across the body's y, as a plate.
    Disk {
        /// Radius, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        radius: f64,
    },
    /// Triangles of no thickness, as a plate. A closed surface encloses fluid.
    Triangulation {
        /// Positions of the nodes, m.
        #[serde(default)]
        nodes: Vec<[f64; 3]>,
        /// Nodes of each triangle, counted from 0.
        #[serde(default)]
        triangles: Vec<[usize; 3]>,
        /// STL, OBJ or PLY file beside the scene's. `nervure` puts its nodes and triangles in the place of this key.
        #[serde(default)]
        file: Option<String>,
        /// Length of the unit of the file, m; by default 1.
        #[serde(default)]
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        unit: Option<f64>,
    },
    /// A circular cylinder in space.
    CircularCylinder {
        /// Axis of the body along which it lies.
        #[serde(default)]
        axis: Axis,
        /// Radius, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        radius: f64,
        /// Length, m; absent for a cylinder through the whole box, whose axis must lie along the box.
        #[serde(default)]
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        length: Option<f64>,
    },
    /// A circular cylinder with half spheres at its ends, in three dimensions.
    Capsule {
        /// Axis of the body along which it lies.
        #[serde(default)]
        axis: Axis,
        /// Radius, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        radius: f64,
        /// Length from tip to tip, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        length: f64,
    },
}

/// Ends of a rectangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Ends {
    /// Flat.
    #[default]
    Square,
    /// Half circles whose diameter is the thickness.
    Round,
}

impl Shape {
    /// Return whether the shape is one in space, where a plate needs a width, and its key.
    pub(crate) fn dimension(&self, is_space: bool) -> (bool, &'static str) {
        match self {
            Self::Circle { .. } => (false, "circle"),
            Self::Ellipse { .. } => (false, "ellipse"),
            Self::Rectangle { .. } => (false, "rectangle"),
            Self::Polygon { .. } => (false, "polygon"),
            Self::Plate { width, .. } => (is_space && width.is_some(), "plate"),
            Self::Polyline { .. } => (false, "polyline"),
            Self::Sphere { .. } => (true, "sphere"),
            Self::Ellipsoid { .. } => (true, "ellipsoid"),
            Self::Cuboid { .. } => (true, "cuboid"),
            Self::CircularCylinder { .. } => (true, "circular_cylinder"),
            Self::Capsule { .. } => (true, "capsule"),
            Self::Disk { .. } => (true, "disk"),
            Self::Triangulation { .. } => (true, "triangulation"),
        }
    }

    /// Return a closed shape in the plane in the body's own axes.
    pub fn outline(&self) -> Option<Outline> {
        Some(match self {
            Self::Circle { radius } => Outline::Circle(*radius),
            Self::Ellipse { length, thickness } => Outline::Ellipse([0.5 * length, 0.5 * thickness]),
            Self::Rectangle { length, thickness, ends: Ends::Square } => {
                Outline::Rectangle([0.5 * length, 0.5 * thickness])
            }
            Self::Rectangle { length, thickness, ends: Ends::Round } => {
                Outline::Capsule([0.5 * (length - thickness), 0.5 * thickness])
            }
            Self::Polygon { corners } => Outline::polygon(corners.clone()),
            _ => return None,
        })
    }

    /// Return whether it goes through the whole box, along which it lies.
    pub(crate) fn is_endless(&self) -> bool {
        matches!(self, Self::CircularCylinder { length: None, .. })
    }

    /// Return whether it is a circle or a sphere.
    pub(crate) fn is_round(&self) -> bool {
        matches!(self, Self::Circle { .. } | Self::Sphere { .. })
    }

    /// Return a solid in space in the body's own axes, in a box with these ends (m).
    pub fn solid(&self, ends: &[[f64; 2]]) -> Option<Solid> {
        Some(match self {
            Self::Sphere { radius } => Solid::Sphere(*radius),
            Self::Ellipsoid { lengths } => Solid::Ellipsoid(lengths.map(|length| 0.5 * length)),
            Self::Cuboid { lengths } => Solid::Cuboid(lengths.map(|length| 0.5 * length)),
            Self::CircularCylinder { axis, radius, length } => {
                let through = ends.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
                let half_length = length.map_or(through, |length| 0.5 * length);
                Solid::Cylinder { axis: *axis as usize, radius: *radius, half_length }
            }
            Self::Capsule { axis, radius, length } => {
                Solid::Capsule { axis: *axis as usize, radius: *radius, half_length: 0.5 * length - radius }
            }
            _ => return None,
        })
    }

    /// Return the points of a line of no thickness in the body's own axes, m.
    pub fn line(&self) -> Option<Vec<[f64; 2]>> {
        match self {
            Self::Plate { length, width: None } => Some(vec![[-length / 2.0, 0.0], [length / 2.0, 0.0]]),
            Self::Polyline { points } => Some(points.clone()),
            _ => None,
        }
    }

    /// Return nodes (m) and triangles of a surface of no thickness in space, in the body's own axes.
    pub fn surface(&self) -> Option<Triangles> {
        match self {
            Self::Plate { length, width: Some(width) } => {
                let (x, z) = (length / 2.0, width / 2.0);
                let nodes = vec![[-x, 0.0, -z], [x, 0.0, -z], [x, 0.0, z], [-x, 0.0, z]];
                Some((nodes, vec![[0, 1, 2], [0, 2, 3]]))
            }
            Self::Disk { radius } => {
                let disk = mesh::ellipse(2.0 * radius, 2.0 * radius, DISK_EDGES);
                Some((disk.nodes.iter().map(|[x, z, _]| [x - radius, 0.0, *z]).collect(), disk.triangles))
            }
            Self::Triangulation { nodes, triangles, .. } => Some((nodes.clone(), triangles.clone())),
            _ => None,
        }
    }

    /// Return the area of a shape of two dimensions, m²; of others 0.
    pub fn area(&self) -> f64 {
        self.outline().map_or(0.0, |outline| outline.section().area)
    }

    /// Return the length and thickness, m; of a cylinder in space diameter and thickness; of a polygon the largest
    /// distance of two corners, and its area by that; of a line the largest distance of two points, and 0; of a surface
    /// the largest side of the frame around it, and 0.
    pub fn size(&self) -> [f64; 2] {
        match self {
            Self::Circle { radius } | Self::Sphere { radius } => [2.0 * radius; 2],
            Self::Ellipsoid { lengths } | Self::Cuboid { lengths } => {
                [lengths.iter().copied().fold(0.0, f64::max), lengths.iter().copied().fold(f64::INFINITY, f64::min)]
            }
            Self::CircularCylinder { radius, length, .. } => {
                [2.0 * radius, length.map_or(2.0 * radius, |l| l.min(2.0 * radius))]
            }
            Self::Capsule { radius, length, .. } => [*length, 2.0 * radius],
            Self::Ellipse { length, thickness } | Self::Rectangle { length, thickness, .. } => [*length, *thickness],
            Self::Plate { length, width } => [width.map_or(*length, |width| width.max(*length)), 0.0],
            Self::Disk { radius } => [2.0 * radius, 0.0],
            Self::Triangulation { nodes, .. } => [extents(nodes).into_iter().fold(0.0, f64::max), 0.0],
            Self::Polygon { corners } | Self::Polyline { points: corners } => {
                let distances =
                    corners.iter().flat_map(|a| corners.iter().map(|b| f64::hypot(a[0] - b[0], a[1] - b[1])));
                let length = distances.fold(0.0, f64::max);
                [length, self.area() / length]
            }
        }
    }

    /// Return the sides of a body in space along its own axes, m, and its largest projection along one of them or, of a
    /// surface, along its mean normal, m²; of a body in the plane zeros. A cylinder may go through a box with the
    /// `ends`.
    pub(crate) fn sides(&self, ends: &[[f64; 2]]) -> ([f64; 3], f64) {
        let largest = |[x, y, z]: [f64; 3]| f64::max(f64::max(x * y, y * z), z * x);
        let quarter = std::f64::consts::FRAC_PI_4;
        match self {
            Self::Sphere { radius } => ([2.0 * radius; 3], quarter * 4.0 * radius * radius),
            Self::Ellipsoid { lengths } => (*lengths, quarter * largest(*lengths)),
            Self::Cuboid { lengths } => (*lengths, largest(*lengths)),
            Self::CircularCylinder { axis, radius, length } => {
                let through = ends.get(*axis as usize).map_or(0.0, |[low, high]| high - low);
                let (d, length) = (2.0 * radius, length.unwrap_or(through));
                let sides = std::array::from_fn(|i| if i == *axis as usize { length } else { d });
                (sides, f64::max(d * length, quarter * d * d))
            }
            Self::Capsule { axis, radius, length } => {
                let d = 2.0 * radius;
                let sides = std::array::from_fn(|i| if i == *axis as usize { *length } else { d });
                (sides, d * (length - d) + quarter * d * d)
            }
            Self::Disk { radius } => ([2.0 * radius, 0.0, 2.0 * radius], quarter * 4.0 * radius * radius),
            _ => self
                .surface()
                .map_or(([0.0; 3], 0.0), |(nodes, triangles)| (extents(&nodes), projection(&nodes, &triangles))),
        }
    }

    /// Return nodes, corners or ends of the own axes of a shape in space in its own axes, m.
    pub(crate) fn points(&self, ends: &[[f64; 2]]) -> Vec<[f64; 3]> {
        let half = self.sides(ends).0.map(|side| 0.5 * side);
        match self {
            Self::Cuboid { .. } => {
                (0..8).map(|i| [0, 1, 2].map(|d| if i >> d & 1 == 0 { half[d] } else { -half[d] })).collect()
            }
            shape => shape.surface().map_or_else(
                || {
                    (0..6)
                        .map(|i| {
                            [0, 1, 2]
                                .map(|d| if i / 2 == d { half[d] * if i % 2 == 0 { 1.0 } else { -1.0 } } else { 0.0 })
                        })
                        .collect()
                },
                |(nodes, _)| nodes,
            ),
        }
    }

    /// Return the distance from a pivot to the farthest point of a shape in the plane, m; of an outline with an axis, to
    /// an end of the axis.
    pub(crate) fn reach(&self, pivot: [f64; 2]) -> f64 {
        let from_pivot = |[x, y]: [f64; 2]| f64::hypot(x - pivot[0], y - pivot[1]);
        match self {
            Self::Polygon { corners: points } | Self::Polyline { points } => {
                points.iter().copied().map(from_pivot).fold(0.0, f64::max)
            }
            shape => {
                let [length, _] = shape.size();
                f64::max(from_pivot([-length / 2.0, 0.0]), from_pivot([length / 2.0, 0.0]))
            }
        }
    }

    /// Return the strain rate at the front in a stream, by U and the length: 4 for a circle, 2 for a plate.
    pub(crate) fn strain_factor(&self) -> f64 {
        match self {
            Self::Circle { .. } | Self::Sphere { .. } | Self::CircularCylinder { .. } | Self::Capsule { .. } => 4.0,
            _ => 2.0,
        }
    }
}

impl Check for Shape {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        match self {
            Self::Circle { .. }
            | Self::Ellipse { .. }
            | Self::Plate { .. }
            | Self::Sphere { .. }
            | Self::Disk { .. }
            | Self::CircularCylinder { .. } => (),
            Self::Triangulation { nodes, triangles, file, unit } => {
                check_surface(nodes, triangles, file.as_ref(), *unit, &format!("{key}.triangulation"), faults);
            }
            Self::Ellipsoid { lengths } | Self::Cuboid { lengths } => {
                let name = if matches!(self, Self::Cuboid { .. }) { "cuboid" } else { "ellipsoid" };
                let fits = lengths.iter().all(|length| *length > 0.0);
                faults.require(fits, &format!("{key}.{name}.lengths"), format!("{lengths:?}"), || {
                    "each length must be > 0".into()
                });
            }
            Self::Rectangle { length, thickness, ends } => {
                let fits = *ends == Ends::Square || thickness <= length;
                faults.require(fits, &format!("{key}.rectangle.thickness"), thickness, || {
                    format!("with round ends it must be at most the length, {length}")
                });
            }
            Self::Capsule { radius, length, .. } => {
                faults.require(*length >= 2.0 * radius, &format!("{key}.capsule.length"), length, || {
                    format!("from tip to tip it is at least the diameter, {}", 2.0 * radius)
                });
            }
            Self::Polygon { corners } => check_corners(corners, true, &format!("{key}.polygon.corners"), faults),
            Self::Polyline { points } => check_corners(points, false, &format!("{key}.polyline.points"), faults),
        }
    }
}

/// Check that triangles have nodes and areas; the first fault of each kind is added.
fn check_surface(
    nodes: &[[f64; 3]],
    triangles: &[[usize; 3]],
    file: Option<&String>,
    unit: Option<f64>,
    key: &str,
    faults: &mut Faults,
) {
    if let Some(file) = file {
        let key = format!("{key}.file");
        let alone = nodes.is_empty() && triangles.is_empty();
        if faults.forbid(!alone, &key, || "the surface has `nodes` and `triangles`; remove one of the two".into()) {
            faults.refuse_file(&key, file);
        }
        return;
    }
    faults.forbid(unit.is_some(), &format!("{key}.unit"), || "it is of a `file`".into());
    let (name, count) = (format!("{key}.triangles"), triangles.len());
    faults.require((1..=MOST_TRIANGLES).contains(&count), &name, format!("a list of {count}"), || {
        format!("a surface has 1 to {MOST_TRIANGLES} triangles")
    });
    if let Some(i) = triangles.iter().position(|corners| corners.iter().any(|node| *node >= nodes.len())) {
        faults.require(false, &format!("{name}[{i}]"), format!("{:?}", triangles[i]), || {
            format!("the surface has {} nodes, counted from 0", nodes.len())
        });
    } else if let Some(i) =
        triangles.iter().position(|corners| !mesh::triangle_area(&corners.map(|node| nodes[node])).is_normal())
    {
        faults.require(false, &format!("{name}[{i}]"), format!("{:?}", triangles[i]), || {
            "these nodes lie on a line, or too far apart: the triangle has no area".into()
        });
    }
}

/// Check that the sides of a polygon, or of a line that is not `closed`, have a length and neither cross nor touch one
/// another; the first fault is added.
pub(crate) fn check_corners(corners: &[[f64; 2]], closed: bool, key: &str, faults: &mut Faults) {
    let n = corners.len();
    let count = if closed { n } else { n.saturating_sub(1) };
    let side = |i: usize| [corners[i], corners[(i + 1) % n]];
    if let Some(i) = (0..count).find(|&i| side(i)[0] == side(i)[1]) {
        faults.require(false, &format!("{key}[{i}]"), format!("{:?}", corners[i]), || {
            "the next corner is the same".into()
        });
        return;
    }
    let touch = |i: usize, j: usize| {
        let (one, other) = (side(i), side(j));
        // Neighbours share a corner, and nothing else.
        if j == i + 1 {
            lies_on(other[1], one) || lies_on(one[0], other)
        } else if closed && i == 0 && j == n - 1 {
            lies_on(other[0], one) || lies_on(one[1], other)
        } else {
            meets(one, other)
        }
    };
    let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j)));
    if let Some((i, j)) = pairs.into_iter().find(|&(i, j)| touch(i, j)) {
        faults.require(false, &format!("{key}[{i}]"), format!("{:?}", corners[i]), || {
            format!("the side that begins there meets the side that begins at corner {j}, {:?}", corners[j])
        });
    }
}

/// Return the lengths of points along the axes, m.
pub(crate) fn extents(nodes: &[[f64; 3]]) -> [f64; 3] {
    [0, 1, 2].map(|axis| {
        let along = nodes.iter().map(|node| node[axis]);
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    })
}

/// Return the largest projection of triangles along a coordinate axis or their mean normal, m²; each line meets a closed
/// surface twice.
fn projection(nodes: &[[f64; 3]], triangles: &[[usize; 3]]) -> f64 {
    let areas = areas(nodes, triangles);
    let along = |axis: [f64; 3]| areas.iter().map(|area| dot(*area, axis).abs()).sum::<f64>();
    let sum = areas.iter().fold([0.0; 3], |sum, area| std::array::from_fn(|d| sum[d] + area[d]));
    let mut axes = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let total = areas.iter().map(|area| norm(*area)).sum::<f64>();
    let is_closed = is_closed(nodes, triangles);
    if !is_closed && norm(sum) > ACROSS * total {
        axes.push(sum.map(|part| part / norm(sum)));
    }
    let largest = axes.into_iter().map(along).fold(0.0, f64::max);
    if is_closed { 0.5 * largest } else { largest }
}

/// Return the areas of triangles along their normals, m².
pub(crate) fn areas(nodes: &[[f64; 3]], triangles: &[[usize; 3]]) -> Vec<[f64; 3]> {
    let area = |corners: &[usize; 3]| {
        let [a, b, c] = corners.map(|node| nodes[node]);
        cross(minus(b, a), minus(c, a)).map(|part| 0.5 * part)
    };
    triangles.iter().map(area).collect()
}

/// Return whether two triangles meet at each edge; nodes in one place are one.
fn is_closed(nodes: &[[f64; 3]], triangles: &[[usize; 3]]) -> bool {
    let place = |node: usize| nodes[node].map(|part| (part + 0.0).to_bits());
    let mut edges: Vec<_> = triangles
        .iter()
        .flat_map(|corners| [0, 1, 2].map(|i| [place(corners[i]), place(corners[(i + 1) % 3])]))
        .map(|[a, b]| if a < b { [a, b] } else { [b, a] })
        .collect();
    edges.sort_unstable();
    edges.chunk_by(|a, b| a == b).all(|same| same.len() == 2)
}
