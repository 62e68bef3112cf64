//! Force and moment on a rigid body, and how they fall with its motion.

use serde::{Deserialize, Serialize};

use crate::kinematics::{Freedoms, Kinematics, Spin, Vector, split};

/// Force and moment on a body, in the plane per metre of depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Force<const D: usize = 2>
where
    [f64; D]: Kinematics<D>,
{
    /// Force, N.
    pub force: Vector<D>,
    /// Moment about the pivot of a body or the root of a beam, N m.
    pub moment: Spin<D>,
}

impl<const D: usize> Default for Force<D>
where
    [f64; D]: Kinematics<D>,
{
    fn default() -> Self {
        Self { force: Vector::zeros(), moment: Default::default() }
    }
}

impl<const D: usize> Force<D>
where
    [f64; D]: Kinematics<D>,
{
    /// Add a force (N) that acts at `arm` (m) from the point about which the moment is taken.
    pub fn add(&mut self, force: &Vector<D>, arm: &Vector<D>) {
        self.force += force;
        self.moment += <[f64; D]>::cross(arm, force);
    }

    /// Return the difference from another force and moment about the same point.
    pub fn less(&self, other: &Self) -> Self {
        Self { force: self.force - other.force, moment: self.moment - other.moment }
    }

    /// Return the sum with another force and moment about the same point.
    pub fn plus(&self, other: &Self) -> Self {
        Self { force: self.force + other.force, moment: self.moment + other.moment }
    }
}

/// Force on a body, and how it falls with the velocities of the body.
#[derive(Clone, Copy, Debug)]
pub struct Drag<const D: usize>
where
    [f64; D]: Kinematics<D>,
{
    /// Force and moment about the pivot.
    pub force: Force<D>,
    /// Rate at which they fall with the velocities along the freedoms.
    pub impedance: [Freedoms; 6],
}

impl<const D: usize> Default for Drag<D>
where
    [f64; D]: Kinematics<D>,
{
    fn default() -> Self {
        Self { force: Force::default(), impedance: [[0.0; 6]; 6] }
    }
}

impl<const D: usize> Drag<D>
where
    [f64; D]: Kinematics<D>,
{
    /// Return the force after a change of the velocities.
    pub fn after(&self, change: &Freedoms) -> Force<D> {
        let falls = self.impedance.map(|row| -row.iter().zip(change).map(|(entry, v)| entry * v).sum::<f64>());
        let (force, moment) = split::<D>(&falls);
        self.force.plus(&Force { force, moment })
    }

    /// Add the `force` (N) on a cell at `arm` (m) from the pivot, which falls with the velocity there by `slope` (kg/s)
    /// along each axis.
    pub fn add(&mut self, force: Vector<D>, slope: Vector<D>, arm: &Vector<D>) {
        self.force.add(&force, arm);
        let along = <[f64; D]>::jacobian(1.0, (*arm).into());
        for (slope, along) in slope.iter().zip(along) {
            for (row, to) in self.impedance.iter_mut().zip(along).take(<[f64; D]>::FREEDOMS) {
                row.iter_mut().zip(along).for_each(|(entry, from)| *entry += to * slope * from);
            }
        }
    }
}
