//! The slip of markers along a rigid thin body or a wing.
//!
//! A marker feels the mean velocity over two points of the kernel. In a shear flow along the body that is not the
//! velocity at the surface but that plus `delta [∂u/∂n]/2`, with delta the mean distance of the two points. The jump of
//! the shear is the tangential force f_t on an area over the viscosity, so a marker slips by `delta f_t/(2 nu)`.
//!
//! Near an edge the flow is no plain shear, and where the layer is thinner than the kernel, a marker feels little of it.
//! The layer grows from an edge as `d² ~ nu s/U`, with the distance s and the speed U, so the slip has the share
//!
//! ```text
//! w = s/(s + EDGE h + THINNING h² U/nu)
//! ```

/// Share of a cell that halves the slip at that distance from an edge in slow flow. A disk along a slow stream has its drag
/// with 0.5 to 1; a plate at 30° and Re 20 its lift with 0 to 0.3.
const EDGE: f64 = 0.4;

/// Weight of the square of a cell over that of the layer: that with which a plate at 0 to 90° and Reynolds numbers of 20
/// to 300 comes nearest to its forces on fine grids.
const THINNING: f64 = 0.35;

/// Length by which the free ends of a line are drawn in, cells. With it the forces on a plate in a stream change least with
/// the grid.
pub const DRAWN_IN: f64 = 0.43;

/// Slip of a marker; the default has none.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slip {
    /// Slip over the tangential force on an area and over the density in slow flow, s/m.
    slow: f64,
    /// Inverse of the speed that halves it, s/m.
    thinning: f64,
    /// Speed of the flow past the marker, m/s.
    pub speed: f64,
}

impl Slip {
    /// The slip in a fluid of a viscosity (m²/s) on cells of a size (m), at a distance from the edge (m) of a body for which
    /// its kernel stands for a plate of a thickness, m.
    pub fn new(viscosity: f64, cell: f64, edge: f64, thickness: f64) -> Self {
        let reach = edge + EDGE * cell;
        Self {
            slow: 0.25 * thickness / viscosity * edge / reach,
            thinning: THINNING * cell * cell / (viscosity * reach),
            speed: 0.0,
        }
    }

    /// Return the slip over the tangential force on an area and over the density, s/m.
    pub fn resistance(&self) -> f64 {
        self.slow / (1.0 + self.thinning * self.speed)
    }
}
