//! The wall target: a weak correction of the velocity at a surface that removes displacement, flux and slip.

/// Depth in the solid at which the mirror image ends, cells.
pub const MIRROR_DEPTH: f64 = 2.0;

/// Distance outside the surface at which the second difference ends, cells.
const OUTER_DISTANCE: f64 = 1.0;

/// Largest difference of the distances of two surfaces that share a cell, cells.
const SHARING_DISTANCE: f64 = 1.0;

/// Drag that a flow through the surface adds, over the drag of the profile, per cell Reynolds number of that flow a
/// cell away.
///
/// The log-linear profile is made for a viscous layer, with nu/dx² as the only rate. Where the flow approaches or
/// leaves the wall, the fluid of the first cell changes in the time dx/u_n. If that time is shorter, the flow cuts into
/// the profile: by half a cell in plane stagnation flow (Hiemenz 1911) at a cell Reynolds number of 16, and as much at
/// the tip of a moving bar. With this value the bare profile keeps the wall of stagnation flow within 0.15 cells for
/// cell Reynolds numbers from 1 to 32. Beside a plane wall the wall target compensates for a part, so that 0.25 would
/// do; at corners it does not, and comparisons of a bar in prescribed motion with a moving mesh require the larger
/// value.
pub const INERTIA: f64 = 0.7;

/// The velocity to which a solid with the log-linear profile draws the fluid at its surface, instead of its own
/// velocity u_b:
///
/// `u_b − mirror w(D/2) (u(D) − u_b) + curvature v (u(2) − 2 u(1) + u_b)`
///
/// along the surface at the depth D, with lengths in cells. u(x) is the flow at the distance x outside; w decreases
/// smoothly from 1 to 0; so does v, over `depth` inside and over one cell outside. Across the surface the velocity is
/// the solid's own: a flow through the surface would be pumped against the drag. The drag is `1 + 0.7 |n·(u(1) − u_b)|
/// dx/nu` times the drag of the profile, with the velocity u_b before the step, so that the load is linear in the
/// velocity at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallTarget {
    /// Weight of the mirror image at the surface.
    pub mirror: f64,
    /// Weight of the second difference.
    pub curvature: f64,
    /// Depth in the solid at which the second difference ends, cells.
    pub depth: f64,
    /// Size of a cell, and arm of the second difference, m.
    pub cell: f64,
    /// Drag added per velocity through the surface, over the drag of the profile, s/m.
    pub inertia: f64,
    /// Largest penalization rate, 1/s.
    pub largest: f64,
}

/// A point at which a wall target samples the flow.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Distance from the surface into the fluid, m.
    pub off: f64,
    /// Weights of the velocity along and across the surface, and in the flow through it.
    pub weight: [f64; 3],
}

impl WallTarget {
    /// Return the samples for a cell at signed distance `d` (m).
    pub fn samples(&self, d: f64) -> [Sample; 3] {
        let depth = -d / self.cell;
        let (mirror, curvature) = self.weights(depth);
        let through = smoothstep_down((-depth / OUTER_DISTANCE).max(0.0));
        let across = if depth > 0.0 { -2.0 * self.mirror * mirrored_flux(depth) } else { 0.0 };
        [
            Sample { off: -d, weight: [-mirror, 0.0, 0.0] },
            Sample { off: self.cell, weight: [-2.0 * curvature, across, through] },
            Sample { off: 2.0 * self.cell, weight: [curvature, 0.0, 0.0] },
        ]
    }

    /// Return whether there are samples for a cell at signed distance `d` (m).
    pub fn reaches(&self, d: f64) -> bool {
        -MIRROR_DEPTH.max(self.depth) * self.cell < d && d < OUTER_DISTANCE * self.cell
    }

    /// Return the share of each surface in a cell, by the signed distances (m) of the cell from them. The nearest
    /// surface has all of it; surfaces that are nearly as near share it, so that no cell switches from one surface to
    /// another abruptly as a body moves.
    pub fn shares<const N: usize>(&self, distances: [f64; N]) -> [f64; N] {
        let nearest = distances.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let weights = distances.map(|distance| smoothstep_down((nearest - distance) / (SHARING_DISTANCE * self.cell)));
        let sum: f64 = weights.iter().sum();
        weights.map(|weight| weight / sum)
    }

    /// Return the weights of the mirror image and of the second difference at a depth (cells).
    pub fn weights(&self, depth: f64) -> (f64, f64) {
        if depth > 0.0 {
            (self.mirror * smoothstep_down(depth / MIRROR_DEPTH), self.curvature * smoothstep_down(depth / self.depth))
        } else {
            (0.0, self.curvature * smoothstep_down(-depth / OUTER_DISTANCE))
        }
    }
}

/// Decrease smoothly from 1 at 0 to 0 at 1 and beyond.
fn smoothstep_down(x: f64) -> f64 {
    if x < 1.0 { 1.0 + x * x * (2.0 * x - 3.0) } else { 0.0 }
}

/// Return `∫ x smoothstep_down(x/2) dx` from `depth` to 2 (cells): the flux of the mirror image of a shear of 1 below.
fn mirrored_flux(depth: f64) -> f64 {
    let s = (depth / MIRROR_DEPTH).min(1.0);
    MIRROR_DEPTH * MIRROR_DEPTH * (0.15 - s * s * (0.5 - s * s * (0.75 - 0.4 * s)))
}
