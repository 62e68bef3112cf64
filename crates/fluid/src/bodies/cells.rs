//! A body as the cells in which it drags the fluid.

use super::measure::{Measure, Surface};
use crate::grid::Grid;
use crate::space::{Kinematics, Space, Spin, Vector};
use crate::wall::{DragProfile, Sample, WallTarget};

/// One cell of a body.
#[derive(Clone, Copy, Debug)]
pub struct Cell<const D: usize> {
    /// Index of the grid point.
    pub index: usize,
    /// Penalization rate a of this body, 1/s.
    pub rate: f64,
    /// Velocity to which the body draws the fluid, m/s.
    pub velocity: Vector<D>,
    /// Position from the point about which the body's moment is taken, m.
    pub arm: Vector<D>,
    /// Derivative of `velocity` with respect to the body's own velocity, per axis: 1, and more with a wall target.
    pub gain: Vector<D>,
}

/// A surface whose wall target acts on a cell: the body draws the fluid to `u_b + (t W_t t + n W_n n)·(u(point) −
/// u_b)`, summed over points, with t along the surface and n across. A cell between several surfaces has one of each,
/// next to one another.
///
/// A velocity u along the surface is kept as `n × u`, a number in the plane.
#[derive(Clone, Copy, Debug)]
struct Targeted<const D: usize>
where
    [f64; D]: Space<D>,
{
    /// Number of the cell.
    cell: usize,
    /// Share of the surface in the cell.
    share: f64,
    /// Penalization rate in still fluid, 1/s.
    rate: f64,
    /// Velocity of the body at the cell, m/s.
    body: Vector<D>,
    /// Velocity of the body across the surface before the step, m/s.
    across_before: f64,
    /// Velocity of the body along the surface at the points relative to that at the cell, times the weights, m/s: a
    /// body that turns is faster farther away.
    turned: Spin<D>,
    /// Unit normal n of the surface.
    normal: Vector<D>,
    /// Sums of the weights of the points along and across the surface, and in the flow through it.
    weight: [f64; 3],
    /// End of the samples; they begin at the end of the previous ones.
    samples_end: usize,
}

/// A sampled point: grid points with their weights in an interpolation, and the weights of a [`Sample`].
type Around<const D: usize> = (<[f64; D] as Space<D>>::Corners, [f64; 3]);

/// The cells of a body.
#[derive(Clone, Debug)]
pub struct Cells<const D: usize>
where
    [f64; D]: Space<D>,
{
    cells: Vec<Cell<D>>,
    targeted: Vec<Targeted<D>>,
    /// Samples of the targeted cells, in the same order.
    samples: Vec<Around<D>>,
    /// Drag per velocity through the surface, s/m, and the largest penalization rate, 1/s.
    inertia: f64,
    largest: f64,
}

impl<const D: usize> Default for Cells<D>
where
    [f64; D]: Space<D>,
{
    fn default() -> Self {
        Self { cells: Vec::new(), targeted: Vec::new(), samples: Vec::new(), inertia: 0.0, largest: 0.0 }
    }
}

impl<const D: usize> Cells<D>
where
    [f64; D]: Space<D>,
{
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
        arm: Vector<D>,
        measure: &Measure<D, N>,
        profile: &DragProfile,
        grid: &Grid<D>,
    ) -> bool {
        let distance = measure.distance();
        let rate = profile.rate(distance);
        if rate > 0.0 {
            let mut cell = Cell { index, rate, velocity: measure.velocity, arm, gain: Vector::repeat(1.0) };
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
        cell: &mut Cell<D>,
        measure: &Measure<D, N>,
        &Surface { distance, foot, normal }: &Surface<D>,
        share: f64,
        target: &WallTarget,
        grid: &Grid<D>,
    ) {
        let samples = target.samples(distance);
        let mut weight = [0.0; 3];
        for sample in samples.iter().filter(|sample| sample.weight != [0.0; 3]) {
            let around = grid.interpolation((foot + sample.off * normal).into());
            self.samples.push((around, sample.weight));
            weight = [0, 1, 2].map(|i| weight[i] + sample.weight[i]);
        }
        let squares_along = <[f64; D]>::squares_along(&normal);
        for axis in 0..D {
            let along = share * (weight[0] * squares_along[axis]);
            let across = share * (weight[1] * normal[axis].powi(2));
            cell.gain[axis] = cell.gain[axis] - along - across;
        }
        let farther = |sample: &Sample| sample.weight[0] * (sample.off - distance);
        let turned = match measure.spin {
            Some(spin) => <[f64; D]>::along(spin, &normal) * samples.iter().map(farther).sum::<f64>(),
            None => Spin::<D>::default(),
        };
        self.targeted.push(Targeted {
            cell: self.cells.len(),
            share,
            rate: cell.rate,
            body: measure.velocity,
            across_before: normal.dot(&measure.velocity_before),
            turned,
            normal,
            weight,
            samples_end: self.samples.len(),
        });
    }

    /// Sample the flow around the cells with a wall target; `velocity` gives it at a grid point, m/s.
    pub fn sample(&mut self, velocity: impl Fn(usize) -> [f64; D]) {
        let (mut begin, mut last, mut flow) = (0, usize::MAX, 0.0);
        for targeted in &self.targeted {
            let (&body, &normal, weight, share) = (&targeted.body, &targeted.normal, targeted.weight, targeted.share);
            let mut along = <[f64; D]>::cross(&normal, &body) * -weight[0] - targeted.turned;
            let (mut across, mut through) = (-weight[1] * normal.dot(&body), -weight[2] * targeted.across_before);
            for (around, weight) in &self.samples[begin..targeted.samples_end] {
                // Only one of three points has weights across.
                let crosses = weight[1] != 0.0 || weight[2] != 0.0;
                for &(point, share) in around.as_ref() {
                    let u = Vector::from(velocity(point));
                    along += <[f64; D]>::cross(&normal, &u) * (share * weight[0]);
                    if crosses {
                        let outward = normal.dot(&u);
                        across += share * weight[1] * outward;
                        through += share * weight[2] * outward;
                    }
                }
            }
            let cell = &mut self.cells[targeted.cell];
            if targeted.cell != last {
                (cell.velocity, last, flow) = (body, targeted.cell, 0.0);
            }
            let (along, across) = (along * share, share * across);
            cell.velocity = cell.velocity + <[f64; D]>::swing(along, &normal) + across * normal;
            flow += share * through.abs();
            cell.rate = (targeted.rate * (1.0 + self.inertia * flow)).min(self.largest);
            begin = targeted.samples_end;
        }
    }

    /// Return the cells, to be given other velocities.
    pub fn iter_mut(&mut self) -> std::slice::IterMut<'_, Cell<D>> {
        self.cells.iter_mut()
    }

    /// Return the cells in the order in which they were added.
    pub fn iter(&self) -> std::slice::Iter<'_, Cell<D>> {
        self.cells.iter()
    }

    /// Return whether some cells have a wall target.
    pub fn have_targets(&self) -> bool {
        !self.targeted.is_empty()
    }
}

/// Adds the cells of moving bodies to the penalization rate of the still ones, and removes them again.
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
    pub fn add<const D: usize>(&mut self, cells: &Cells<D>, rate: &mut [f64])
    where
        [f64; D]: Space<D>,
    {
        for cell in cells.iter() {
            self.before.push((cell.index, rate[cell.index]));
            rate[cell.index] += cell.rate;
        }
    }
}
