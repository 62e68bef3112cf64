//! Parameters of a rod and their checks.

use std::f64::consts::PI;

use structure::{Scheme, Vector, check_scheme, not_negative, positive};

use crate::contact::Contact;
use crate::model::{Bending, Calibration, RootSupport, Section, Slide, Taper};
use crate::{Error, RodError};

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
    /// Mass per length of the fluid that carries the rod by its weight alone, kg/m: `[2 n + 1]` as in a [`Taper`], and
    /// empty where `displaced` has it.
    pub buoyant: Vec<f64>,
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
    /// What the rod touches; `None` lets it pass through everything.
    pub contact: Option<Contact<D>>,
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
            buoyant: Vec::new(),
            taper: Taper::default(),
            strain_per_pressure: 0.0,
            gravity: [0.0; D],
            damping: 0.0,
            bending: Bending::default(),
            calibration: Calibration::default(),
            support: RootSupport::default(),
            slide: None,
            clamp_compliance_length: 0.0,
            contact: None,
            scheme: Scheme::default(),
            max_step: None,
        }
    }

    /// Refuse values outside their ranges and combinations that the model does not have.
    ///
    /// # Errors
    /// The value is named.
    pub fn check(&self) -> Result<(), Error> {
        structure::finite("attachment", &self.attachment)?;
        structure::finite("direction", &self.direction)?;
        structure::finite("gravity", &self.gravity)?;
        let direction = Vector::from(self.direction).norm();
        if !(direction.is_normal()) {
            return Err(Error::value("direction", &self.direction[..], "a vector of any length but 0"));
        }
        positive("length", self.length)?;
        positive("section.line_density", self.section.line_density)?;
        positive("section.bending_stiffness", self.section.bending_stiffness)?;
        positive("section.axial_stiffness", self.section.axial_stiffness)?;
        if let Calibration::Thesis { k_e } = self.calibration {
            positive("calibration.thesis.k_e", k_e)?;
        }
        self.section.shear_stiffness.map_or(Ok(()), |shear| positive("section.shear_stiffness", shear))?;
        self.max_step.map_or(Ok(()), |longest| positive("max_step", longest))?;
        not_negative("displaced", self.displaced)?;
        not_negative("damping", self.damping)?;
        not_negative("clamp_compliance_length", self.clamp_compliance_length)?;
        not_negative("strain_per_pressure", self.strain_per_pressure)?;
        if self.segments < 2 {
            return Err(Error::value("segments", self.segments, "at least 2"));
        }
        self.contact.as_ref().map_or(Ok(()), |contact| contact.check(self.segments + 1))?;
        structure::finite("buoyant", &self.buoyant)?;
        if !(self.buoyant.is_empty() || self.buoyant.len() == 2 * self.segments + 1) {
            return Err(Error::value("buoyant", self.buoyant.len(), "empty or of 2 n + 1 numbers"));
        }
        self.check_taper()?;
        self.check_support()?;
        if let Some(shear) = self.section.shear_stiffness.filter(|_| D != 2 || self.bending != Bending::Invariant) {
            let only = "absent: only a rod in the plane with invariant bending has shear";
            return Err(Error::value("section.shear_stiffness", shear, only));
        }
        self.check_rest_shape()?;
        check_scheme(self.scheme)
    }

    fn check_support(&self) -> Result<(), Error> {
        if let RootSupport::TorsionSpring { stiffness, damping, rest_angle } = self.support {
            positive("support.stiffness", stiffness)?;
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
        not_negative("slide.mass", mass)
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
            if !ratios.is_empty() {
                Error::check_length(name, ratios.len(), expected)?;
            }
            ratios.iter().enumerate().try_for_each(|(i, &ratio)| positive(format!("{name}[{i}]"), ratio))?;
        }
        if self.calibration != Calibration::SecondOrder && self.taper != Taper::default() {
            let allowed = "empty with the calibration of the thesis, which has a uniform rod";
            return Err(Error::value("taper", "given", allowed));
        }
        for i in 0..=2 * self.segments {
            let [line_density, displaced] = [(self.section.line_density, line_density), (self.displaced, displaced)]
                .map(|(root, profile)| root * Taper::at(profile, i));
            let rounding = if i == 0 { 0.0 } else { RATIO_ROUNDING * displaced };
            if displaced > line_density + rounding {
                return Err(RodError::NegativeMass { line_density, displaced }.into());
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
        Error::check_length("rest_angles", angles.len(), self.segments)?;
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
