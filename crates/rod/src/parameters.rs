//! What a rod is made of and what acts on it.

use std::f64::consts::PI;

use scene::{Bending, Calibration, RodScheme, Section};
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::elastic::{Angles, Elastic, Joint, Vector};
use crate::hinge::Hinge;
use crate::shear::Shear;

/// Rounding of the ratios of a taper.
const RATIO_ROUNDING: f64 = 1e-14;

/// What a rod is made of and where it is clamped.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters<const D: usize> {
    /// Position of the root at rest, m.
    pub root: [f64; D],
    /// Direction of the rod at the root at rest; any length but 0.
    pub direction: [f64; D],
    /// Length, m.
    pub length: f64,
    /// Number of segments n, at least 2; there are n + 1 nodes.
    pub segments: usize,
    /// Direction of each segment at rest against that at the root, rad, positive to the left: `[n]`; empty for a straight
    /// rod. In two dimensions only: a curved rod in space needs a material frame and its twist.
    pub rest_angles: Vec<f64>,
    /// Mass and stiffness of the section at the root (per metre of depth in two dimensions).
    pub section: Section,
    /// Mass per length of the displaced fluid at the root, kg/m, that the loads account for. The rod itself carries the
    /// difference of `section.line_density` and this, which may be 0 but nowhere negative; gravity acts on it.
    pub displaced: f64,
    /// Both along the rod.
    pub taper: Taper,
    /// Strain by which the rod shrinks under pressure from all sides, 1/Pa: (1 + ν)(1 − 2ν)/E in plane strain. With 0
    /// the pressure of the loads has no effect.
    pub strain_per_pressure: f64,
    /// Gravity, m/s².
    pub gravity: [f64; D],
    /// Damping force per length and velocity, kg/(m s).
    pub damping: f64,
    /// Bending model.
    pub bending: Bending,
    /// How the section's numbers become springs and masses.
    pub calibration: Calibration,
    /// How the root is held.
    pub hold: Hold,
    /// Length by which the clamp lies behind the root, m: the clamp's spring is that of so much more of the rod.
    pub clamp_compliance_length: f64,
    /// Time scheme.
    pub scheme: RodScheme,
    /// Largest step taken inside [`Rod::step`](crate::Rod::step), s; `None`: the whole step.
    pub max_step: Option<f64>,
}

/// How the root is held. All but the clamped one want the invariant bending model and the second-order calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Hold {
    /// It neither moves nor turns by itself.
    #[default]
    Clamped,
    /// It turns without resistance.
    Pinned,
    /// It turns by the angle θ from the direction of the root, against the moment `stiffness (θ − rest_angle) + damping θ'`.
    TorsionSpring {
        /// Stiffness, N m/rad.
        stiffness: f64,
        /// Damping, N m s/rad; 0 in space, where θ has no axis.
        damping: f64,
        /// Angle of the spring at rest, rad, positive to the left; 0 in space.
        rest_angle: f64,
    },
    /// It moves as well, and [`Rod::towing`](crate::Rod::towing) acts on it.
    Free,
}

/// The section and the displaced fluid along the rod, relative to those at the root, at the nodes and the middles of the
/// segments in turn: `[2 n + 1]` each; empty where it is the same all along.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Taper {
    /// Mass per length.
    pub line_density: Vec<f64>,
    /// Mass per length of the displaced fluid.
    pub displaced: Vec<f64>,
    /// Bending stiffness.
    pub bending_stiffness: Vec<f64>,
    /// Axial stiffness.
    pub axial_stiffness: Vec<f64>,
    /// Shear stiffness.
    pub shear_stiffness: Vec<f64>,
}

/// Loads on the nodes, root to tip, held over a step; an empty array is a load that does not exist. The components of
/// `force` are `force.chunks_exact_mut(n + 1)`.
///
/// What is given for the clamped node 0 has no effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Loads {
    /// Nodal forces, N, component after component: `[D, n + 1]`.
    pub force: Vec<f64>,
    /// Jump of the pressure across the rod, p_top − p_bottom, Pa: `[n + 1]`; in two dimensions only. Top is the side of
    /// the left-hand normal n when walking from root to tip, and the load per length is −\[p\] n. It follows the
    /// rod's shape at the beginning of the step, so its direction is a step late.
    pub pressure_jump: Vec<f64>,
    /// Impedance D of the nodal forces, kg/s, at least 0: `[n + 1]`. A node moving at v gets the force
    /// f − D (v − v_ref), v_ref being its velocity at the beginning of the step, where f was found. With D = 0 a load
    /// from a fluid as heavy as the rod makes the coupling unstable.
    pub impedance: Vec<f64>,
    /// Pressure around the rod, mean over the section, Pa: `[n + 1]`. It exerts no force: the nodal forces contain the
    /// differences of the pressure, and its level strains the rod by `strain_per_pressure` (docs/theory/coupling.md).
    /// The strain follows with a lag of the period of the first axial mode: faster changes meet no inertia but the
    /// fluid's.
    pub pressure: Vec<f64>,
}

impl<const D: usize> Parameters<D> {
    pub(crate) fn check(&self) -> Result<(), Error> {
        let Section { line_density, bending_stiffness, axial_stiffness, shear_stiffness } = self.section;
        for (name, vector) in [("root", self.root), ("direction", self.direction), ("gravity", self.gravity)] {
            if vector.iter().any(|c| !c.is_finite()) {
                return Err(Error::value(name, &vector[..], "finite"));
            }
        }
        let direction = Vector::from(self.direction).norm();
        if !(direction.is_normal()) {
            return Err(Error::value("direction", &self.direction[..], "a vector of any length but 0"));
        }
        let k_e = match self.calibration {
            Calibration::SecondOrder => None,
            Calibration::Thesis { k_e } => Some(("calibration.thesis.k_e", k_e)),
        };
        for (name, value) in [
            ("length", self.length),
            ("section.line_density", line_density),
            ("section.bending_stiffness", bending_stiffness),
            ("section.axial_stiffness", axial_stiffness),
        ]
        .into_iter()
        .chain(k_e)
        .chain(shear_stiffness.map(|shear| ("section.shear_stiffness", shear)))
        .chain(self.max_step.map(|longest| ("max_step", longest)))
        {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::value(name, value, "a finite number above 0"));
            }
        }
        for (name, value) in [
            ("displaced", self.displaced),
            ("damping", self.damping),
            ("clamp_compliance_length", self.clamp_compliance_length),
            ("strain_per_pressure", self.strain_per_pressure),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(Error::value(name, value, "a finite number of at least 0"));
            }
        }
        if self.segments < 2 {
            return Err(Error::value("segments", self.segments, "at least 2"));
        }
        self.check_taper()?;
        self.check_hold()?;
        if let Some(shear) = shear_stiffness.filter(|_| D != 2 || self.bending != Bending::Invariant) {
            let only = "absent: shear is for a rod in the plane with invariant bending";
            return Err(Error::value("section.shear_stiffness", shear, only));
        }
        self.check_rest_shape()?;
        match self.scheme {
            RodScheme::GeneralisedAlpha { rho_inf } if !(0.0..=1.0).contains(&rho_inf) => {
                Err(Error::value("scheme.generalised_alpha.rho_inf", rho_inf, "between 0 and 1"))
            }
            _ => Ok(()),
        }
    }

    fn check_hold(&self) -> Result<(), Error> {
        if let Hold::TorsionSpring { stiffness, damping, rest_angle } = self.hold {
            if !(stiffness.is_finite() && stiffness > 0.0) {
                return Err(Error::value("hold.stiffness", stiffness, "a finite number above 0"));
            }
            if !(damping.is_finite() && damping >= 0.0 && (D == 2 || damping == 0.0)) {
                return Err(Error::value("hold.damping", damping, "a finite number of at least 0, and 0 in space"));
            }
            if !(rest_angle.abs() < PI && (D == 2 || rest_angle == 0.0)) {
                return Err(Error::value("hold.rest_angle", rest_angle, "between −π and π, and 0 in space"));
            }
        }
        let plain = self.bending == Bending::Invariant && self.calibration == Calibration::SecondOrder;
        if self.hold != Hold::Clamped && !plain {
            let found = format!("{:?}", self.hold);
            return Err(Error::value("hold", found, "Clamped with another bending model or calibration"));
        }
        Ok(())
    }

    fn check_taper(&self) -> Result<(), Error> {
        let Taper { line_density, displaced, bending_stiffness, axial_stiffness, shear_stiffness } = &self.taper;
        for (name, ratios) in [
            ("taper.line_density", line_density),
            ("taper.displaced", displaced),
            ("taper.bending_stiffness", bending_stiffness),
            ("taper.axial_stiffness", axial_stiffness),
            ("taper.shear_stiffness", shear_stiffness),
        ] {
            let expected = 2 * self.segments + 1;
            if !ratios.is_empty() && ratios.len() != expected {
                return Err(Error::Length { name: name.into(), length: ratios.len(), expected });
            }
            if let Some(i) = ratios.iter().position(|ratio| !(ratio.is_finite() && *ratio > 0.0)) {
                return Err(Error::value(format!("{name}[{i}]"), ratios[i], "a finite number above 0"));
            }
        }
        if self.calibration != Calibration::SecondOrder && self.taper != Taper::default() {
            return Err(Error::value(
                "taper",
                "given".to_string(),
                "empty: the thesis has a rod that is the same all along",
            ));
        }
        for i in 0..=2 * self.segments {
            let [line_density, displaced] = [(self.section.line_density, line_density), (self.displaced, displaced)]
                .map(|(root, along)| root * at(along, i));
            let rounding = if i == 0 { 0.0 } else { RATIO_ROUNDING * displaced };
            if displaced > line_density + rounding {
                return Err(Error::NegativeMass { line_density, displaced });
            }
        }
        Ok(())
    }

    fn check_rest_shape(&self) -> Result<(), Error> {
        let angles = &self.rest_angles;
        if angles.is_empty() {
            return Ok(());
        }
        if D != 2 {
            let found = format!("given for {} segments", angles.len());
            return Err(Error::value(
                "rest_angles",
                found,
                "empty in space: a curved rod needs a material frame there",
            ));
        }
        if angles.len() != self.segments {
            let name = "rest_angles".into();
            return Err(Error::Length { name, length: angles.len(), expected: self.segments });
        }
        match self.rest_turns().iter().position(|turn| !turn.is_finite() || turn.abs() >= PI) {
            Some(k) => Err(Error::value(
                format!("rest_angles[{k}]"),
                angles[k],
                "finite and less than π from that of the segment before",
            )),
            None => Ok(()),
        }
    }

    /// Turning angle at rest at the beginning of each segment, rad: `[n]`.
    fn rest_turns(&self) -> Vec<f64> {
        let angle = |k: usize| self.rest_angles.get(k).copied().unwrap_or(0.0);
        (0..self.segments).map(|k| if k == 0 { angle(0) } else { angle(k) - angle(k - 1) }).collect()
    }

    /// Length of a segment at rest, m.
    pub(crate) fn segment_length(&self) -> f64 {
        self.length / self.segments as f64
    }

    /// The rod at rest, clamped at `root` along the unit vector `direction`: `[n + 1]`.
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

    /// The springs, clamped along the unit vector `direction`.
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
        // A vertex bends with the section there, a segment is stretched and sheared with that in its middle.
        let bending = self.section.bending_stiffness / l0;
        let mut bending: Vec<_> = (0..self.segments).map(|v| bending * at(&taper.bending_stiffness, 2 * v)).collect();
        // A spring at the root is in series with half a segment.
        let beside = self.section.bending_stiffness / (clamp_length + self.clamp_compliance_length);
        let (clamp, joint) = match self.hold {
            Hold::Clamped => (beside, Joint::Clamped),
            Hold::Pinned | Hold::Free => (0.0, Joint::Loose),
            Hold::TorsionSpring { stiffness, rest_angle, .. } => {
                (1.0 / (1.0 / stiffness + 1.0 / beside), Joint::Spring { rest: rest_angle, stored: 0.0 })
            }
        };
        bending[0] = clamp;
        let first = usize::from(self.hold != Hold::Free);
        let axial = (0..self.segments).map(|j| axial * at(&taper.axial_stiffness, 2 * j + 1)).collect();
        let shear = self.section.shear_stiffness.map(|shear| {
            let stiffness = |j: usize| shear * at(&taper.shear_stiffness, 2 * j + 1);
            Shear::new(l0, &bending, stiffness)
        });
        let slack = vec![l0; self.segments];
        Elastic { segment_length: l0, slack, axial, bending, direction, joint, first, angles, shear }
    }

    /// Period of the first axial mode in vacuo, 4 L √(μ/EA), s.
    pub(crate) fn axial_period(&self) -> f64 {
        4.0 * self.length * (self.section.line_density / self.section.axial_stiffness).sqrt()
    }

    /// The hinge of a torsion spring at the root; in the plane only.
    pub(crate) fn hinge(&self) -> Option<Hinge> {
        let Hold::TorsionSpring { stiffness, damping, rest_angle } = self.hold else { return None };
        let beside = self.section.bending_stiffness / (0.5 * self.segment_length() + self.clamp_compliance_length);
        (D == 2).then_some(Hinge { stiffness, damping, rest_angle, beside })
    }

    /// Mass of each node less that of the fluid it displaces, kg: `[n + 1]`.
    ///
    /// Where the section changes, ∫ μ N ds with the hat function N of the node, by Simpson's rule in each segment: the sum and
    /// the centre of the masses are those of the rod.
    pub(crate) fn masses(&self) -> Vec<f64> {
        let Taper { line_density, displaced, .. } = &self.taper;
        let tributary = self.tributary();
        if line_density.is_empty() && displaced.is_empty() {
            let own = self.section.line_density - self.displaced;
            return tributary.into_iter().map(|length| own * length).collect();
        }
        // Of equal densities the difference of the ratios may round to below 0.
        let own =
            |i: usize| (self.section.line_density * at(line_density, i) - self.displaced * at(displaced, i)).max(0.0);
        let part = self.segment_length() / 6.0;
        let mut masses = vec![0.0; self.segments + 1];
        for j in 0..self.segments {
            let [start, middle, end] = [0, 1, 2].map(|i| own(2 * j + i));
            masses[j] += part * (start + 2.0 * middle);
            masses[j + 1] += part * (2.0 * middle + end);
        }
        masses
    }

    /// Length whose mass and damping belong to each node, m: `[n + 1]`.
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

/// A ratio of [`Taper`] at one of its places.
fn at(ratios: &[f64], i: usize) -> f64 {
    ratios.get(i).copied().unwrap_or(1.0)
}

impl Taper {
    /// Of a scene's beam with this rod.
    pub(crate) fn of(beam: &scene::Beam, material: &scene::Material) -> Self {
        let relative = |value: &dyn Fn(f64) -> f64| {
            let root = value(0.0);
            let ratios: Vec<_> = beam.places().map(|s| value(s) / root).collect();
            if ratios.iter().all(|&ratio| ratio == 1.0) { Vec::new() } else { ratios }
        };
        let section = |s: f64| material.section(&beam.thickness, s);
        Self {
            line_density: relative(&|s| section(s).line_density),
            displaced: relative(&|s| beam.thickness.at(s)),
            bending_stiffness: relative(&|s| section(s).bending_stiffness),
            axial_stiffness: relative(&|s| section(s).axial_stiffness),
            shear_stiffness: relative(&|s| section(s).shear_stiffness.unwrap_or(1.0)),
        }
    }
}

impl Loads {
    /// As `check_numbers`, and the impedance is not negative.
    pub(crate) fn check<const D: usize>(&self, nodes: usize) -> Result<(), Error> {
        self.check_numbers::<D>(nodes)?;
        match self.impedance.iter().position(|&d| d < 0.0) {
            Some(k) => Err(Error::value(format!("loads.impedance[{k}]"), self.impedance[k], "at least 0 kg/s")),
            None => Ok(()),
        }
    }

    /// Each array is empty or has its number of entries, all finite.
    pub(crate) fn check_numbers<const D: usize>(&self, nodes: usize) -> Result<(), Error> {
        for (name, array, expected) in [
            ("force", &self.force, D * nodes),
            ("pressure_jump", &self.pressure_jump, if D == 2 { nodes } else { 0 }),
            ("impedance", &self.impedance, nodes),
            ("pressure", &self.pressure, nodes),
        ] {
            if !array.is_empty() && array.len() != expected {
                return Err(Error::Length { name: format!("loads.{name}"), length: array.len(), expected });
            }
            if let Some(k) = array.iter().position(|value| !value.is_finite()) {
                return Err(Error::value(format!("loads.{name}[{k}]"), array[k], "finite"));
            }
        }
        Ok(())
    }
}
