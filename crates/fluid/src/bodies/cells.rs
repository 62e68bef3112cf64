//! A body as the cells in which it drags the fluid.

use crate::grid::Grid;
use crate::wall::{Sample, WallTarget};

/// One cell of a body.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Index of the grid point.
    pub index: usize,
    /// Drag rate a of this body there, 1/s.
    pub rate: f64,
    /// Velocity that the body draws the fluid to, m/s.
    pub velocity: [f64; 2],
    /// Its position from the point that the body's moment is taken about, m.
    pub arm: [f64; 2],
    /// How fast that velocity changes with the body's own there, per axis: 1, and more where it follows a wall target.
    pub gain: [f64; 2],
}

/// A cell with a wall target: its body draws the fluid to `u_b + (t W_t t + n W_n n)·(u(point) − u_b)`, summed over
/// points, with t along the surface and n across. A cell between two surfaces has one of each, next to one another.
#[derive(Clone, Copy, Debug)]
struct Targeted {
    /// Which of the cells.
    cell: usize,
    /// Part that this surface has in the cell.
    share: f64,
    /// Drag rate in still fluid, 1/s.
    rate: f64,
    /// Velocity of the body there, m/s.
    body: [f64; 2],
    /// The same before the step, across the surface, m/s.
    across_before: f64,
    /// What the body's velocity along the surface is at the points beyond that at the cell, times their weights, m/s: a body
    /// that turns is faster farther off.
    turned: f64,
    /// Unit normal n of the surface.
    normal: [f64; 2],
    /// Sums of the weights of its points, along, across and in the flow through the surface.
    weight: [f64; 3],
    /// End of its samples; they begin where those of the one before end.
    samples_end: usize,
}

/// Where the flow is sampled: four grid points with their shares in an interpolation, and the weights of what they give.
type Around = ([(usize, f64); 4], [f64; 3]);

/// A surface near a cell.
#[derive(Clone, Copy, Debug)]
pub struct Near {
    /// Signed distance of the cell, m, positive in the fluid.
    pub distance: f64,
    /// The nearest point, m.
    pub surface: [f64; 2],
    /// Unit normal out of the body there.
    pub normal: [f64; 2],
    /// Part of the cell that is the surface's; 1 but for cells between two.
    pub share: f64,
}

/// The cells of a body.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    cells: Vec<Cell>,
    targeted: Vec<Targeted>,
    /// Where those cells sample the flow, in the same order.
    samples: Vec<Around>,
    /// What the flow through the surface adds to the drag, s/m, and the largest drag rate, 1/s.
    inertia: f64,
    largest: f64,
}

impl Cells {
    /// Forget all.
    pub fn clear(&mut self) {
        self.cells.clear();
        self.targeted.clear();
        self.samples.clear();
    }

    /// Add a cell that moves with the body.
    pub fn push(&mut self, index: usize, rate: f64, velocity: [f64; 2], arm: [f64; 2]) {
        self.cells.push(Cell { index, rate, velocity, arm, gain: [1.0; 2] });
    }

    /// Let the cell added last follow, with a `share`, a wall target that reaches it: the cell is `distance` (m, positive
    /// in the fluid) off the point `surface` (m), where the unit normal out of the body is `normal`. Before the step the
    /// body had the velocity `before` (m/s) there.
    pub fn follow_last(
        &mut self,
        target: &WallTarget,
        Near { distance, surface, normal, share }: Near,
        before: [f64; 2],
        grid: &Grid,
    ) {
        let number = self.cells.len().wrapping_sub(1);
        let Some(cell) = self.cells.last_mut() else { return };
        (self.inertia, self.largest) = (target.inertia, target.largest);
        let mut sum = [0.0; 3];
        for Sample { off, weight } in target.samples(distance) {
            if weight == [0.0; 3] {
                continue;
            }
            let around = grid.interpolation([surface[0] + off * normal[0], surface[1] + off * normal[1]]);
            self.samples.push((around, weight));
            sum = [0, 1, 2].map(|i| sum[i] + weight[i]);
        }
        for axis in 0..2 {
            let along = share * (sum[0] * normal[1 - axis].powi(2));
            let across = share * (sum[1] * normal[axis].powi(2));
            cell.gain[axis] = cell.gain[axis] - along - across;
        }
        let (rate, body) = (cell.rate, cell.velocity);
        let across_before = normal[0] * before[0] + normal[1] * before[1];
        let samples_end = self.samples.len();
        let (cell, weight, turned) = (number, sum, 0.0);
        self.targeted.push(Targeted { cell, share, rate, body, across_before, turned, normal, weight, samples_end });
    }

    /// Let the body of the cell that has just been told to follow, at a `distance` (m) off the surface, turn at a rate
    /// (rad/s): the flow that its wall target samples is that beyond the body's own velocity at those points.
    pub fn turn_last(&mut self, target: &WallTarget, distance: f64, omega: f64) {
        let Some(targeted) = self.targeted.last_mut() else { return };
        let samples = target.samples(distance).into_iter();
        targeted.turned = omega * samples.map(|sample| sample.weight[0] * (sample.off - distance)).sum::<f64>();
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
                // One point of three has weights across.
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

    /// The cells, in the order in which they were added.
    pub fn iter(&self) -> std::slice::Iter<'_, Cell> {
        self.cells.iter()
    }

    /// Whether some cells have a wall target.
    pub fn have_targets(&self) -> bool {
        !self.targeted.is_empty()
    }
}

/// Adds the cells of moving bodies to the drag rate of the still ones, and takes them out again.
///
/// What was there is kept and put back in reverse order, so that painting leaves no rounding behind.
#[derive(Clone, Debug, Default)]
pub struct Painted {
    before: Vec<(usize, f64)>,
}

impl Painted {
    /// Take everything out of `rate` that was added since.
    pub fn erase(&mut self, rate: &mut [f64]) {
        while let Some((index, before)) = self.before.pop() {
            rate[index] = before;
        }
    }

    /// Where something was added.
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
