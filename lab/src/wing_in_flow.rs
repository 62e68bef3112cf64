//! A wing in a flow of space.

use scene::{Scene, WingDrive};
use wing::{Loads, Wing};

use crate::coupled::{Coupled, Flexible};

#[path = "../../fmu-wing/src/from_scene.rs"] // the FMU exports a C interface, so nothing can depend on it
mod from_scene;

/// A flow of space with the wings in it.
pub type WingsInFlow = Coupled<3, WingInFlow>;

/// A wing with its part of the scene.
pub struct WingInFlow {
    wing: Wing,
    own: scene::Wing,
    /// Number of the node farthest from the pivot at rest, and its place.
    tip: (usize, [f64; 3]),
}

impl WingInFlow {
    /// A wing of a scene, with its root in the place of time 0.
    fn new(scene: &Scene, own: &scene::Wing) -> Result<Self, String> {
        if matches!(own.root_motion, Some(WingDrive::Master(_))) {
            return Err("`wing.root_motion` is left to a master, but here only laws of time can drive a root".into());
        }
        let parameters = from_scene::parameters(scene, own);
        let nodes = &parameters.mesh.nodes;
        let distance = |node: &[f64; 3]| node.iter().zip(own.pivot).map(|(x, o)| (x - o).powi(2)).sum::<f64>();
        let tip = nodes.iter().copied().enumerate().max_by(|a, b| distance(&a.1).total_cmp(&distance(&b.1)));
        let tip = tip.unwrap_or_default();
        let loads = Loads { force: vec![0.0; 3 * nodes.len()], impedance: vec![0.0; nodes.len()], ..Loads::default() };
        let mut wing = parameters.build().map_err(|e| e.to_string())?;
        wing.loads = loads;
        if let Some(laws) = own.laws() {
            wing.place(from_scene::pose(laws, 0.0)).map_err(|e| e.to_string())?;
        }
        Ok(Self { wing, own: own.clone(), tip })
    }
}

impl Flexible<3> for WingInFlow {
    fn all(scene: &Scene) -> Result<Vec<Self>, String> {
        let refused = [
            (scene.beams().next().is_some(), "rods in space"),
            (scene.flyer.is_some(), "a body that flies"),
            (scene.contact.is_some(), "contact of wings"),
        ];
        if let Some((_, what)) = refused.iter().find(|(is_there, _)| *is_there) {
            return Err(format!("the scene {:?} has {what}, which is not simulated here", scene.name));
        }
        scene.wings().map(|own| Self::new(scene, own.wing)).collect()
    }

    fn loads_mut(&mut self) -> &mut Loads {
        &mut self.wing.loads
    }

    fn step(&mut self, t: f64, h: f64) -> Result<(), String> {
        self.wing.base_motion = self.own.laws().map(|laws| from_scene::pose(laws, t + h));
        self.wing.step(h).map_err(|e| e.to_string())
    }

    fn positions(&self, axis: usize) -> &[f64] {
        self.wing.positions(axis)
    }

    fn velocities(&self, axis: usize) -> &[f64] {
        self.wing.velocities(axis)
    }

    fn continue_from(&mut self, other: &Self) -> Result<(), String> {
        self.wing.restore(other.wing.state()).map_err(|e| e.to_string())
    }

    /// Append the displacement of the tip, m, and the twist at three quarters of the span, rad, or 0 without a span.
    fn sample(&self, to: &mut Vec<f64>) {
        let (node, rest) = self.tip;
        to.extend((0..3).map(|axis| self.positions(axis)[node] - rest[axis]));
        to.push(self.wing.twist().unwrap_or_default());
    }
}
