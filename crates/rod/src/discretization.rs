//! Springs, masses and rest shape of the chain of nodes.

use structure::Vector;

use crate::elastic::{Angles, Elastic, Joint};
use crate::hinge::Hinge;
use crate::model::{Bending, Calibration, RootSupport, Taper};
use crate::parameters::Parameters;
use crate::shear::Shear;

impl<const D: usize> Parameters<D> {
    /// Return the first node that moves freely: 1, or 0 with a free or sliding root.
    pub(crate) fn first_node(&self) -> usize {
        usize::from(self.support != RootSupport::Free && self.slide.is_none())
    }

    /// Return the length l0 of a segment at rest, m.
    pub(crate) fn segment_length(&self) -> f64 {
        self.length / self.segments as f64
    }

    /// Return the nodes of the rod at rest, with its root at `root` along the unit vector `direction`, m: `[n + 1]`.
    pub(crate) fn rest_shape(&self, root: Vector<D>, direction: Vector<D>) -> Vec<Vector<D>> {
        let mut shape = Vec::with_capacity(self.segments + 1);
        if self.rest_angles.is_empty() {
            let along = |k: usize| self.length * k as f64 / self.segments as f64;
            shape.extend((0..=self.segments).map(|k| root + direction * along(k)));
            return shape;
        }
        shape.push(root);
        let mut left = Vector::zeros();
        (left[0], left[1]) = (-direction[1], direction[0]);
        for (k, (sin, cos)) in self.rest_angles.iter().map(|angle| angle.sin_cos()).enumerate() {
            shape.push(shape[k] + (direction * cos + left * sin) * self.segment_length());
        }
        shape
    }

    /// Return the springs, with the root along the unit vector `direction`.
    pub(crate) fn elastic(&self, direction: Vector<D>) -> Elastic<D> {
        let l0 = self.segment_length();
        let (axial, clamp_length) = match self.calibration {
            Calibration::SecondOrder => (self.section.axial_stiffness / l0, 0.5 * l0),
            Calibration::Thesis { k_e } => (k_e, l0),
        };
        let angles = match self.bending {
            Bending::Projected => Angles::Projected(self.rest_turns()),
            Bending::Invariant if self.rest_angles.is_empty() => Angles::Straight,
            Bending::Invariant => Angles::curved(self.rest_turns()),
        };
        let taper = &self.taper;
        // Bending uses the section at the vertex, stretching and shear the section at the middle of the segment.
        let bending = self.section.bending_stiffness / l0;
        let mut bending: Vec<_> =
            (0..self.segments).map(|v| bending * Taper::at(&taper.bending_stiffness, 2 * v)).collect();
        // A spring at the root is in series with half a segment.
        let half_segment = self.section.bending_stiffness / (clamp_length + self.clamp_compliance_length);
        let (clamp, joint) = match self.support {
            RootSupport::Clamped => (half_segment, Joint::Clamped),
            RootSupport::Pinned | RootSupport::Free => (0.0, Joint::Loose),
            RootSupport::TorsionSpring { stiffness, rest_angle, .. } => {
                (1.0 / (1.0 / stiffness + 1.0 / half_segment), Joint::Spring { rest: rest_angle, stored: 0.0 })
            }
        };
        bending[0] = clamp;
        let first = self.first_node();
        let axial = (0..self.segments).map(|j| axial * Taper::at(&taper.axial_stiffness, 2 * j + 1)).collect();
        let shear = self.section.shear_stiffness.map(|shear| {
            let stiffness = |j: usize| shear * Taper::at(&taper.shear_stiffness, 2 * j + 1);
            Shear::new(l0, &bending, stiffness)
        });
        let slack = vec![l0; self.segments];
        Elastic { segment_length: l0, slack, axial, bending, direction, joint, first, angles, shear }
    }

    /// Return the period of the first axial mode in vacuo, 4 L √(μ/EA), s.
    pub(crate) fn axial_period(&self) -> f64 {
        4.0 * self.length * (self.section.line_density / self.section.axial_stiffness).sqrt()
    }

    /// Return the torsion spring at the root, in the plane only.
    pub(crate) fn hinge(&self) -> Option<Hinge> {
        let RootSupport::TorsionSpring { stiffness, damping, rest_angle } = self.support else { return None };
        let half_segment =
            self.section.bending_stiffness / (0.5 * self.segment_length() + self.clamp_compliance_length);
        (D == 2).then_some(Hinge { stiffness, damping, rest_angle, half_segment })
    }

    /// Return the mass of each node on which gravity acts, kg: `[n + 1]`.
    pub(crate) fn weights(&self) -> Vec<f64> {
        let mut weights = if self.displaced_weighs {
            let taper = Taper { displaced: Vec::new(), ..self.taper.clone() };
            Self { displaced: 0.0, taper, ..self.clone() }.masses()
        } else {
            self.masses()
        };
        if !self.buoyant.is_empty() {
            let buoyant = self.integrals(|i| self.buoyant[i]);
            weights.iter_mut().zip(buoyant).for_each(|(weight, fluid)| *weight -= fluid);
        }
        weights
    }

    /// Return the mass of each node, with the mass of a slide, less the mass of the fluid it displaces, kg: `[n + 1]`.
    ///
    /// On a tapered rod it is ∫ μ N ds with the hat function N of the node, by Simpson's rule in each segment. Sum and
    /// centre of the masses are exact.
    pub(crate) fn masses(&self) -> Vec<f64> {
        let mut masses = self.rod_masses();
        if let Some(slide) = self.slide {
            masses[0] += slide.mass;
        }
        masses
    }

    fn rod_masses(&self) -> Vec<f64> {
        let Taper { line_density, displaced, .. } = &self.taper;
        let tributary = self.tributary();
        if line_density.is_empty() && displaced.is_empty() {
            let own = self.section.line_density - self.displaced;
            return tributary.into_iter().map(|length| own * length).collect();
        }
        // The difference of equal densities may round to a number below 0.
        let own = |i: usize| {
            (self.section.line_density * Taper::at(line_density, i) - self.displaced * Taper::at(displaced, i)).max(0.0)
        };
        self.integrals(own)
    }

    /// Return the integrals of a profile, by the place from 0 to 2 n, times the hat function of each node: `[n + 1]`.
    fn integrals(&self, profile: impl Fn(usize) -> f64) -> Vec<f64> {
        let part = self.segment_length() / 6.0;
        let mut integrals = vec![0.0; self.segments + 1];
        for j in 0..self.segments {
            let [start, middle, end] = [0, 1, 2].map(|i| profile(2 * j + i));
            integrals[j] += part * (start + 2.0 * middle);
            integrals[j + 1] += part * (2.0 * middle + end);
        }
        integrals
    }

    /// Return the length of rod that belongs to each node, m: `[n + 1]`.
    pub(crate) fn tributary(&self) -> Vec<f64> {
        let l0 = self.segment_length();
        let mut tributary = vec![l0; self.segments + 1];
        tributary[0] = 0.5 * l0;
        if self.calibration == Calibration::SecondOrder {
            tributary[self.segments] = 0.5 * l0;
        }
        tributary
    }
}
