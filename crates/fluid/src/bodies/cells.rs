//! A body as the cells in which it drags the fluid.

use super::measure::{Measure, Surface};
use crate::grid::Grid;
use crate::wall::{DragProfile, Sample, WallTarget};

/// One cell of a body.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Index of the grid point.
    pub index: usize,
    /// Drag rate a of this body, 1/s.
    pub rate: f64,
    /// Velocity to which the body draws the fluid, m/s.
    pub velocity: [f64; 2],
    /// Position from the point about which the body's moment is taken, m.
    pub arm: [f64; 2],
    /// Derivative of `velocity` with respect to the body's own velocity, per axis: 1, and more with a wall target.
    pub gain: [f64; 2],
}

/// A surface whose wall target acts on a cell: the body draws the fluid to `u_b + (t W_t t + n W_n n)·(u(point) −
/// u_b)`, summed over points, with t along the surface and n across. A cell between several surfaces has one of each,
/// next to one another.
#[derive(Clone, Copy, Debug)]
struct Targeted {
    /// Number of the cell.
    cell: usize,
    /// Share of the surface in the cell.
    share: f64,
    /// Drag rate in still fluid, 1/s.
    rate: f64,
    /// Velocity of the body at the cell, m/s.
    body: [f64; 2],
    /// Velocity of the body across the surface before the step, m/s.
    across_before: f64,
    /// Velocity of the body along the surface at the points relative to that at the cell, times the weights, m/s: a
    /// body that turns is faster farther away.
    turned: f64,
    /// Unit normal n of the surface.
    normal: [f64; 2],
    /// Sums of the weights of the points along and across the surface, and in the flow through it.
    weight: [f64; 3],
    /// End of the samples; they begin at the end of the previous ones.
    samples_end: usize,
}

/// A sampled point: four grid points with their weights in an interpolation, and the weights of a [`Sample`].
type Around = ([(usize, f64); 4], [f64; 3]);

/// The cells of a body.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    cells: Vec<Cell>,
    targeted: Vec<Targeted>,
    /// Samples of the targeted cells, in the same order.
    samples: Vec<Around>,
    /// Drag per velocity through the surface, s/m, and the largest drag rate, 1/s.
    inertia: f64,
    largest: f64,
}

impl Cells {
    /// Remove all cells.
    pub fn clear(&mut self) {
        self.cells.clear();
        self.targeted.clear();
        self.samples.clear();
    }

    /// Add the cell of a body that is measured at a grid point, and return whether it drags the fluid there.
    ///
    /// `arm` is the position from the point about which the body's moment is taken, m.
    #[inline(always)]
    pub fn add<const N: usize>(
        &mut self,
        index: usize,
        arm: [f64; 2],
        measure: &Measure<N>,
        profile: &DragProfile,
        grid: &Grid,
    ) -> bool {
        let distance = measure.distance();
        let rate = profile.rate(distance);
        if rate > 0.0 {
            let mut cell = Cell { index, rate, velocity: measure.velocity, arm, gain: [1.0; 2] };
            if let Some(target) = profile.target(distance) {
                (self.inertia, self.largest) = (target.inertia, target.largest);
                let shares = target.shares(measure.surfaces.map(|surface| surface.distance));
                for (surface, share) in measure.surfaces.iter().zip(shares) {
                    if share > 0.0 && target.reaches(surface.distance) {
                        self.add_target(&mut cell, measure, surface, share, target, grid);
                    }
                }
            }
            self.cells.push(cell);
        }
        rate > 0.0
    }

    /// Add the wall target of a surface that has a `share` of the cell to be added next.
    fn add_target<const N: usize>(
        &mut self,
        cell: &mut Cell,
        measure: &Measure<N>,
        &Surface { distance, foot, normal }: &Surface,
        share: f64,
        target: &WallTarget,
        grid: &Grid,
    ) {
        let samples = target.samples(distance);
        let mut weight = [0.0; 3];
        for sample in samples.iter().filter(|sample| sample.weight != [0.0; 3]) {
            let around = grid.interpolation([foot[0] + sample.off * normal[0], foot[1] + sample.off * normal[1]]);
            self.samples.push((around, sample.weight));
            weight = [0, 1, 2].map(|i| weight[i] + sample.weight[i]);
        }
        for axis in 0..2 {
            let along = share * (weight[0] * normal[1 - axis].powi(2));
            let across = share * (weight[1] * normal[axis].powi(2));
            cell.gain[axis] = cell.gain[axis] - along - across;
        }
        let farther = |sample: &Sample| sample.weight[0] * (sample.off - distance);
        let turned = if measure.spin == 0.0 { 0.0 } else { measure.spin * samples.iter().map(farther).sum::<f64>() };
        let [u, v] = measure.velocity_before;
        self.targeted.push(Targeted {
            cell: self.cells.len(),
            share,
            rate: cell.rate,
            body: measure.velocity,
            across_before: normal[0] * u + normal[1] * v,
            turned,
            normal,
            weight,
            samples_end: self.samples.len(),
        });
    }

    /// Sample the flow around the cells with a wall target; `velocity` gives it at a grid point, m/s.
    pub fn sample(&mut self, velocity: impl Fn(usize) -> [f64; 2]) {
        let (mut begin, mut last, mut flow) = (0, usize::MAX, 0.0);
        for targeted in &self.targeted {
            let ([u, v], [nx, ny], weight, share) = (targeted.body, targeted.normal, targeted.weight, targeted.share);
            let (body_along, body_across) = (nx * v - ny * u, nx * u + ny * v);
            let mut along = -weight[0] * body_along - targeted.turned;
            let (mut across, mut through) = (-weight[1] * body_across, -weight[2] * targeted.across_before);
            for (around, weight) in &self.samples[begin..targeted.samples_end] {
                // Only one of three points has weights across.
                let crosses = weight[1] != 0.0 || weight[2] != 0.0;
                for &(point, share) in around {
                    let [u, v] = velocity(point);
                    along += share * weight[0] * (nx * v - ny * u);
                    if crosses {
                        across += share * weight[1] * (nx * u + ny * v);
                        through += share * weight[2] * (nx * u + ny * v);
                    }
                }
            }
            let cell = &mut self.cells[targeted.cell];
            if targeted.cell != last {
                (cell.velocity, last, flow) = ([u, v], targeted.cell, 0.0);
            }
            let (along, across) = (share * along, share * across);
            cell.velocity[0] = cell.velocity[0] - along * ny + across * nx;
            cell.velocity[1] = cell.velocity[1] + along * nx + across * ny;
            flow += share * through.abs();
            cell.rate = (targeted.rate * (1.0 + self.inertia * flow)).min(self.largest);
            begin = targeted.samples_end;
        }
    }

    /// Return the cells, to be given other velocities.
    pub fn iter_mut(&mut self) -> std::slice::IterMut<'_, Cell> {
        self.cells.iter_mut()
    }

    /// Return the cells in the order in which they were added.
    pub fn iter(&self) -> std::slice::Iter<'_, Cell> {
        self.cells.iter()
    }

    /// Return whether some cells have a wall target.
    pub fn have_targets(&self) -> bool {
        !self.targeted.is_empty()
    }
}

/// Adds the cells of moving bodies to the drag rate of the still ones, and removes them again.
///
/// The previous values are kept and restored in reverse order, so that painting leaves no rounding behind.
#[derive(Clone, Debug, Default)]
pub struct Painted {
    before: Vec<(usize, f64)>,
}

impl Painted {
    /// Remove everything that was added to `rate`.
    pub fn erase(&mut self, rate: &mut [f64]) {
        while let Some((index, before)) = self.before.pop() {
            rate[index] = before;
        }
    }

    /// Return the points to which something was added.
    pub fn points(&self) -> impl Iterator<Item = usize> {
        self.before.iter().map(|(index, _)| *index)
    }

    /// Add the cells of a body to `rate`.
    pub fn add(&mut self, cells: &Cells, rate: &mut [f64]) {
        for cell in cells.iter() {
            self.before.push((cell.index, rate[cell.index]));
            rate[cell.index] += cell.rate;
        }
    }
}
