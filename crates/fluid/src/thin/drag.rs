//! The drag of markers, solved exactly within a local solve.

use line_fft::Real;

use super::markers::Markers;
use super::system::System;
use crate::field::Field;
use crate::grid::Grid;
use crate::space::Vector;

/// Markers with the forces of the last solve.
pub struct MarkerDrag<const D: usize> {
    /// The markers.
    pub markers: Markers<D>,
    system: System<D>,
    /// Force on each marker over the density: m³/s² in two dimensions, m⁴/s² in space.
    pub force: Vec<Vector<D>>,
    /// Decrease of that force, across where markers slip, if all become faster, m²/s or m³/s.
    pub slope: Vec<f64>,
    /// Force on a flexible body at each marker over the density by the layer that slides along it, m³/s² or m⁴/s².
    gliding: Vec<Vector<D>>,
    right_side: Vec<Vector<D>>,
    response: Vec<Vector<D>>,
}

/// Grid points around the markers with the drag of a mask, in ascending order.
pub struct Dragged<const D: usize> {
    /// The points.
    pub points: Vec<usize>,
    /// `Σ a u_b` there, m/s².
    pub sums: Vec<[f64; D]>,
}

impl<const D: usize> Default for Dragged<D> {
    fn default() -> Self {
        Self { points: Vec::new(), sums: Vec::new() }
    }
}

impl<const D: usize> Dragged<D> {
    /// List those of some points where the penalization rate of the masks (1/s) is not 0, with sums of 0.
    pub fn list(&mut self, points: &[usize], rate: Option<&[f64]>) {
        self.points.clear();
        if let Some(rate) = rate {
            self.points.extend(points.iter().filter(|point| rate[**point] > 0.0));
            self.points.sort_unstable();
        }
        self.sums.clear();
        self.sums.resize(self.points.len(), [0.0; D]);
    }
}

impl<const D: usize> MarkerDrag<D> {
    /// The drag of markers that are not yet at a place.
    pub fn new(markers: Markers<D>) -> Self {
        let count = markers.len();
        let zeros = || vec![Vector::zeros(); count];
        let [force, gliding, right_side, response] = [(); 4].map(|()| zeros());
        Self { markers, system: System::new(count), force, slope: vec![0.0; count], gliding, right_side, response }
    }

    /// Solve for the forces. `first` gives the velocity of the local solve without the thin bodies at a grid point,
    /// and `rate` the penalization rate of the masks (1/s); `c_0` is the coefficient of the difference in time (1/s).
    /// Return whether the solution was found.
    pub fn solve(&mut self, c_0: f64, rate: Option<&[f64]>, first: impl Fn(usize) -> [f64; D], grid: &Grid<D>) -> bool {
        self.markers.weigh(|point| 1.0 / (c_0 + rate.map_or(0.0, |rate| rate[point])));
        self.markers.pass(first, &mut self.right_side);
        self.system.assemble(&self.markers, grid);
        self.system.solve(&self.right_side, &mut self.force)
    }

    /// Let the layers slide along the flexible bodies with the forces of the last solve, but not beside a mask, where these
    /// forces have little to do with a layer.
    pub fn glide(&mut self) {
        self.gliding.fill(Vector::zeros());
        for k in (0..self.markers.len()).filter(|k| self.markers.glides(*k)) {
            let marker = self.markers.get(k);
            let slip = marker.along * (self.markers.inverse_drag(k) * self.force[k]);
            self.gliding[k] = self.markers.sliding(k, &slip) * marker.layer;
        }
    }

    /// Return the force on a body at a marker over the density, with that of the layer which slides along it.
    pub fn on_body(&self, k: usize) -> Vector<D> {
        self.force[k] + self.gliding[k]
    }

    /// Write −∂f/∂U, the decrease of the forces on all markers with a motion of which `velocity` gives that of a marker,
    /// after [`Self::solve`]. Return whether it was found.
    pub fn respond(&mut self, velocity: impl Fn(usize, &Markers<D>) -> Vector<D>, response: &mut [Vector<D>]) -> bool {
        self.right_side.iter_mut().enumerate().for_each(|(k, own)| *own = velocity(k, &self.markers));
        self.system.solve(&self.right_side, response)
    }

    /// Take the forces off `w`.
    pub fn spread<R: Real>(&mut self, w: &mut [Field<R>; D], grid: &Grid<D>) {
        let scale = 1.0 / grid.cell_volume();
        self.markers.spread(&self.force, |point, sum| {
            for (w, sum) in w.iter_mut().zip(sum) {
                w[point] = R::rounded(w[point].to_f64() - scale * *sum);
            }
        });
    }

    /// Call `add` with each grid point and the force on the fluid there, m/s², after [`Self::spread`].
    pub fn for_each_force(&self, grid: &Grid<D>, mut add: impl FnMut(usize, Vector<D>)) {
        let scale = -1.0 / grid.cell_volume();
        self.markers.spread_sums().for_each(|(point, sum)| add(point, sum * scale));
    }

    /// Solve for forces and slopes in a local solve with `right_side` at a grid point. The slopes are not finite if no
    /// solution was found.
    pub fn predict(
        &mut self,
        c_0: f64,
        rate: Option<&[f64]>,
        right_side: impl Fn(usize) -> [f64; D],
        dragged: &Dragged<D>,
        grid: &Grid<D>,
    ) {
        let first = |point: usize| match dragged.points.binary_search(&point) {
            Ok(k) => {
                let (right_side, rate) = (right_side(point), rate.map_or(0.0, |rate| rate[point]));
                std::array::from_fn(|axis| (right_side[axis] + dragged.sums[k][axis]) / (c_0 + rate))
            }
            Err(_) => right_side(point).map(|r| r / c_0),
        };
        let mut found = self.solve(c_0, rate, first, grid);
        self.slope.fill(0.0);
        let Self { markers, system, slope, right_side, response, .. } = self;
        for axis in 0..D {
            right_side.fill(Vector::from_fn(|own, _| if own == axis { 1.0 } else { 0.0 }));
            found &= system.solve(right_side, response);
            for (k, (slope, response)) in slope.iter_mut().zip(&*response).enumerate() {
                // The mean over the directions across the body, in which nothing slips.
                let along = &markers.get(k).along;
                *slope += (response[axis] - along.column(axis).dot(response)) / (D as f64 - along.trace());
            }
        }
        if !found {
            slope.fill(f64::NAN);
        }
        // Where markers of two bodies or of a folded one crowd, the sum of a row may be negative; an impedance may not.
        self.slope.iter_mut().filter(|slope| **slope < 0.0).for_each(|slope| *slope = 0.0);
        self.glide();
    }
}
