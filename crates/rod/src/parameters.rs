//! Parameters of a rod and their checks.

use std::f64::consts::PI;

use crate::Error;
use crate::model::{Bending, Calibration, RootSupport, Scheme, Section, Slide, Taper};
use crate::vector::Vector;

/// Tolerance of the ratios of a taper, for rounding.
const RATIO_ROUNDING: f64 = 1e-14;

/// Geometry, section, support and numerics of a rod.
///
/// ```
/// use nervure_rod::{Parameters, Section};
///
/// let section = Section { line_density: 20.0, bending_stiffness: 1.1, axial_stiffness: 3.3e4, shear_stiffness: None };
/// let bar = Parameters { gravity: [0.0, -2.0], ..Parameters::<2>::new(0.35, 32, section) };
/// assert_eq!(bar.direction, [1.0, 0.0]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters<const D: usize> {
    /// Position of the root at rest, m.
    pub attachment: [f64; D],
    /// Direction of the rod at the root at rest, of any length but 0.
    pub direction: [f64; D],
    /// Length, m.
    pub length: f64,
    /// Number of segments n, at least 2; there are n + 1 nodes.
    pub segments: usize,
    /// Angle between each segment and the direction at the root, at rest, rad, positive to the left: `[n]`; empty for a
    /// straight rod, the only kind in space.
    pub rest_angles: Vec<f64>,
    /// Section at the root.
    pub section: Section,
    /// Mass per length of the displaced fluid at the root, kg/m, if the loads account for its inertia.
    ///
    /// The rod carries the difference of `section.line_density` and `displaced`, which is nowhere negative.
    pub displaced: f64,
    /// Whether gravity acts on the displaced mass too: on a line, which displaces no fluid, it is a mass of the rod.
    pub displaced_weighs: bool,
    /// Profiles of section and displaced fluid along the rod.
    pub taper: Taper,
    /// Axial strain under a pressure from all sides, 1/Pa: (1 + ν)(1 − 2ν)/E in plane strain; 0 ignores the pressure.
    pub strain_per_pressure: f64,
    /// Gravity, m/s².
    pub gravity: [f64; D],
    /// Damping force per length and velocity, kg/(m s).
    pub damping: f64,
    /// Bending model.
    pub bending: Bending,
    /// Rule that turns the section into springs and masses.
    pub calibration: Calibration,
    /// Support of the root.
    pub support: RootSupport,
    /// Guide of the root; `None` holds the root in all directions, unless it is free.
    pub slide: Option<Slide>,
    /// Length of rod whose bending compliance is added to the clamp, m.
    pub clamp_compliance_length: f64,
    /// Time scheme.
    pub scheme: Scheme,
    /// Largest sub-step of [`Rod::step`](crate::Rod::step), s; `None` for no limit.
    pub max_step: Option<f64>,
}

impl<const D: usize> Parameters<D> {
    /// Return a straight rod along x, clamped at the origin, without gravity, damping or fluid.
    pub fn new(length: f64, segments: usize, section: Section) -> Self {
        Self {
            attachment: [0.0; D],
            direction: std::array::from_fn(|d| f64::from(d == 0)),
            length,
            segments,
            rest_angles: Vec::new(),
            section,
            displaced: 0.0,
            displaced_weighs: false,
            taper: Taper::default(),
            strain_per_pressure: 0.0,
            gravity: [0.0; D],
            damping: 0.0,
            bending: Bending::default(),
            calibration: Calibration::default(),
            support: RootSupport::default(),
            slide: None,
            clamp_compliance_length: 0.0,
            scheme: Scheme::default(),
            max_step: None,
        }
    }

    /// Refuse values outside their ranges and combinations that the model does not have.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let Section { line_density, bending_stiffness, axial_stiffness, shear_stiffness } = self.section;
        for (name, vector) in
            [("attachment", self.attachment), ("direction", self.direction), ("gravity", self.gravity)]
        {
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
        self.check_support()?;
        if let Some(shear) = shear_stiffness.filter(|_| D != 2 || self.bending != Bending::Invariant) {
            let only = "absent: only a rod in the plane with invariant bending has shear";
            return Err(Error::value("section.shear_stiffness", shear, only));
        }
        self.check_rest_shape()?;
        match self.scheme {
            Scheme::GeneralisedAlpha { rho_inf } if !(0.0..=1.0).contains(&rho_inf) => {
                Err(Error::value("scheme.generalised_alpha.rho_inf", rho_inf, "between 0 and 1"))
            }
            _ => Ok(()),
        }
    }

    fn check_support(&self) -> Result<(), Error> {
        if let RootSupport::TorsionSpring { stiffness, damping, rest_angle } = self.support {
            if !(stiffness.is_finite() && stiffness > 0.0) {
                return Err(Error::value("support.stiffness", stiffness, "a finite number above 0"));
            }
            if !(damping.is_finite() && damping >= 0.0 && (D == 2 || damping == 0.0)) {
                return Err(Error::value("support.damping", damping, "a finite number of at least 0, and 0 in space"));
            }
            if !(rest_angle.abs() < PI && (D == 2 || rest_angle == 0.0)) {
                return Err(Error::value("support.rest_angle", rest_angle, "between −π and π, and 0 in space"));
            }
        }
        let plain = self.bending == Bending::Invariant && self.calibration == Calibration::SecondOrder;
        if self.support != RootSupport::Clamped && !plain {
            let found = format!("{:?}", self.support);
            let allowed = "Clamped with projected bending or the calibration of the thesis";
            return Err(Error::value("support", found, allowed));
        }
        let Some(Slide { axis, mass }) = self.slide else { return Ok(()) };
        if axis >= D || self.support == RootSupport::Free || !plain {
            let found = format!("{:?}", self.slide);
            let allowed = "an axis of the rod's space, and absent with a free root, projected bending or the \
                           calibration of the thesis";
            return Err(Error::value("slide", found, allowed));
        }
        if !(mass.is_finite() && mass >= 0.0) {
            return Err(Error::value("slide.mass", mass, "a finite number of at least 0"));
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
            let allowed = "empty with the calibration of the thesis, which has a uniform rod";
            return Err(Error::value("taper", "given".to_string(), allowed));
        }
        for i in 0..=2 * self.segments {
            let [line_density, displaced] = [(self.section.line_density, line_density), (self.displaced, displaced)]
                .map(|(root, profile)| root * Taper::at(profile, i));
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
            let allowed = "empty in space, where a curved rod needs a material frame";
            return Err(Error::value("rest_angles", found, allowed));
        }
        if angles.len() != self.segments {
            let name = "rest_angles".into();
            return Err(Error::Length { name, length: angles.len(), expected: self.segments });
        }
        match self.rest_turns().iter().position(|turn| !turn.is_finite() || turn.abs() >= PI) {
            Some(k) => Err(Error::value(
                format!("rest_angles[{k}]"),
                angles[k],
                "finite and less than π from the angle of the segment before",
            )),
            None => Ok(()),
        }
    }

    /// Return the turning angle at rest at the beginning of each segment, rad: `[n]`.
    pub(crate) fn rest_turns(&self) -> Vec<f64> {
        let angle = |k: usize| self.rest_angles.get(k).copied().unwrap_or(0.0);
        (0..self.segments).map(|k| if k == 0 { angle(0) } else { angle(k) - angle(k - 1) }).collect()
    }
}
