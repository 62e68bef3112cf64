//! The slip of markers along a rigid thin body or a wing, and of a rod thinner than its line.
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
//!
//! A rod in space has no plane. In slow flow a force f on a length, over the density, slows the fluid at the distance r by
//! `f ln(R/r)/(2 pi nu)` along the rod, and by half of that across. A marker feels this at [`ROD_RADIUS_CELLS`], so for a rod
//! of the radius a it slips by `f ln(ROD_RADIUS_CELLS h/a)/(2 pi nu)`, or half of that. In a faster flow the layer and the
//! wake are thinner than the kernel, which then slows the stream little. With `Re = 2 a U/nu` of the flow U past the marker
//! across the rod, both together are
//!
//! ```text
//! f = nu (2 pi/ln(ROD_RADIUS_CELLS h/a) + FRICTION √Re) U_along
//! f = nu (4 pi/ln(ROD_RADIUS_CELLS h/a) + FRICTION/2 √Re + FORM/2 Re) U_across
//! ```

use std::f64::consts::PI;

use method::ROD_RADIUS_CELLS;

/// Share of a cell that halves the slip at that distance from an edge in slow flow. A disk along a slow stream has its drag
/// with 0.5 to 1; a plate at 30° and Re 20 its lift with 0 to 0.3.
const EDGE: f64 = 0.4;

/// Weight of the square of a cell over that of the layer: that with which a plate at 0 to 90° and Reynolds numbers of 20
/// to 300 comes nearest to its forces on fine grids.
const THINNING: f64 = 0.35;

/// Length by which the free ends of a line are drawn in, cells. With it the forces on a plate in a stream change least with
/// the grid.
pub const DRAWN_IN: f64 = 0.43;

/// Drag of a rod by its diameter and the pressure of a fast stream across it: of a cylinder at Reynolds numbers of 1e3 to
/// 1e5.
const FORM: f64 = 1.2;

/// Friction of a stream along a rod over the root of the Reynolds number across it. With it and its half across, lines on a
/// quarter to a whole cell a diameter have the drag of resolved cylinders at 1 to 100 within 15 % across, 40 % along.
const FRICTION: f64 = 1.0;

/// Slip of a marker; the default has none.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slip {
    law: Law,
    /// Speed of the flow past the marker, on a rod across it, m/s.
    speed: f64,
}

#[derive(Clone, Copy, Debug, Default)]
enum Law {
    #[default]
    None,
    /// Slip over the tangential force on an area and over the density in slow flow, s/m, and the inverse of the speed that
    /// halves it, s/m.
    Layer { slow: f64, thinning: f64 },
    /// Viscosity, m²/s, logarithm of the radius of the line over that of the rod, and diameter of the rod, m.
    Rod { viscosity: f64, thinner: f64, diameter: f64 },
}

impl Slip {
    /// The slip along a body in a fluid of a viscosity (m²/s) on cells of a size (m), at a distance from the edge (m) of a
    /// body for which its kernel stands for a plate of a thickness, m.
    pub fn along(viscosity: f64, cell: f64, edge: f64, thickness: f64) -> Self {
        let reach = edge + EDGE * cell;
        let slow = 0.25 * thickness / viscosity * edge / reach;
        let law = Law::Layer { slow, thinning: THINNING * cell * cell / (viscosity * reach) };
        Self { law, speed: 0.0 }
    }

    /// The slip of a rod with a diameter (m); none of one that is as thick as its line.
    pub fn of_rod(viscosity: f64, cell: f64, diameter: f64) -> Self {
        let thinner = (2.0 * ROD_RADIUS_CELLS * cell / diameter).ln();
        let law = if thinner > 0.0 { Law::Rod { viscosity, thinner, diameter } } else { Law::None };
        Self { law, speed: 0.0 }
    }

    /// Set the speed of a flow past the marker, m/s, from the mean of its velocity across the body and the root mean
    /// square of all of it.
    pub fn pass(&mut self, across: f64, all: f64) {
        self.speed = if let Law::Rod { .. } = self.law { across } else { all };
    }

    /// Return the slip along and across over the force on an area, s/m, or on the length of a rod, s/m², and over the
    /// density.
    pub fn resistances(&self) -> [f64; 2] {
        match self.law {
            Law::None => [0.0; 2],
            Law::Layer { slow, thinning } => [slow / (1.0 + thinning * self.speed), 0.0],
            Law::Rod { viscosity, thinner, diameter } => {
                let reynolds = diameter * self.speed / viscosity;
                let (slow, friction) = (2.0 * PI / thinner, FRICTION * reynolds.sqrt());
                let across = 2.0 * slow + 0.5 * (friction + FORM * reynolds);
                [slow + friction, across].map(|drag| 1.0 / (viscosity * drag))
            }
        }
    }
}
