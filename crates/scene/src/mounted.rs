//! What a mount makes of a body with its shape: its freedoms, and its weight in a fluid.

use crate::body::Body;
use crate::fault::Faults;
use crate::mount::Freedom;

impl Body {
    /// Return the directions in which its mount may let it move, in the order of the fluid; none without a mount.
    pub fn freedoms(&self, is_space: bool) -> Vec<Freedom> {
        let Some(mount) = &self.mount else { return Vec::new() };
        let own = mount.inertias();
        let about = |axis: usize| if is_space { self.about_axis(&own, axis) } else { own[axis] };
        let freedom = |(i, (name, support)): (usize, (&'static str, _))| {
            let turns = name.starts_with("angle");
            let axis = if turns && !is_space { 2 } else { i % 3 };
            Freedom { name, axis, turns, inertia: if turns { about(axis) } else { mount.mass }, support }
        };
        mount.supports(is_space).enumerate().map(freedom).collect()
    }

    /// Return the mass of the fluid of a density (kg/m³) that it displaces in a box with these ends (m), kg, and the
    /// moments of inertia of that fluid about the axes of the body through the pivot, kg m².
    pub(crate) fn displaced_by(&self, density: f64, ends: &[[f64; 2]]) -> (f64, [f64; 3]) {
        let (volume, about) = self.displaced(ends);
        (density * volume, about.map(|about| density * about))
    }

    /// Return the weight less that of the fluid that carries it, N, along the axes on which no spring holds it: it falls
    /// or rises there.
    pub(crate) fn free_weight(&self, density: f64, ends: &[[f64; 2]]) -> [f64; 3] {
        let mut weight = [0.0; 3];
        let Some(mount) = &self.mount else { return weight };
        let net = mount.mass - self.displaced_by(density, ends).0;
        let is_free = |own: &Freedom| own.support.is_some_and(|support| support.stiffness == 0.0);
        for own in self.freedoms(ends.len() == 3).iter().filter(|own| !own.turns && is_free(own)) {
            weight[own.axis] = net * mount.gravity.get(own.axis).copied().unwrap_or(0.0);
        }
        weight
    }

    /// Check that a body on springs that is not round is as heavy as the fluid it displaces; `key` is the path of the
    /// mount.
    pub(crate) fn check_mass(&self, key: &str, density: f64, ends: &[[f64; 2]], faults: &mut Faults) {
        let Some(mount) = self.mount.as_ref().filter(|_| !self.shape.is_round()) else { return };
        let (is_space, (displaced, about)) = (ends.len() == 3, self.displaced_by(density, ends));
        let (freedoms, round) = (self.freedoms(is_space), if is_space { "sphere" } else { "circle" });
        let is_free = |turns| freedoms.iter().any(|own| own.turns == turns && own.support.is_some());
        let fits = !is_free(false) || mount.mass >= displaced;
        faults.require(fits, &format!("{key}.mass"), mount.mass, || {
            format!(
                "a body on springs that is no {round} must weigh at least as much as the fluid it displaces, \
                 {displaced:.6}"
            )
        });
        let Some(inertia) = mount.inertia else { return };
        let mut turning = freedoms.iter().filter(|own| own.turns && own.support.is_some());
        let moments: Vec<_> = match (turning.next(), turning.next()) {
            (None, _) => Vec::new(),
            // About a single axis only that moment counts, and it stays.
            (Some(one), None) if is_space => vec![(one.inertia, self.about_axis(&about, one.axis))],
            _ => mount.inertias().into_iter().zip(about).collect(),
        };
        let fits = moments.iter().all(|(own, about)| own >= about);
        let least = moments.iter().filter(|(_, about)| *about > 0.0).map(|(_, about)| format!("{about:.6}"));
        let least: Vec<_> = least.collect();
        faults.require(fits, &format!("{key}.inertia"), inertia, || {
            format!(
                "a body on springs that is no {round} must have at least the moment of inertia of the fluid it \
                 displaces, {}",
                least.join(", ")
            )
        });
    }

    /// Return the moment about an axis of the box at rest for those about the axes of the body, which are principal.
    fn about_axis(&self, own: &[f64; 3], axis: usize) -> f64 {
        let axes = self.axes_at_rest();
        (0..3).map(|e| own[e] * axes[e][axis].powi(2)).sum()
    }
}
