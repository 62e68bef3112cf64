//! A rod in the flow of a plane.

use rod::{BaseMotion, Loads, Rod};
use scene::{Beam, RootMotion, Scene};

use crate::coupled::{Coupled, Flexible};

#[path = "../../fmu-rod/src/from_scene.rs"] // the FMU exports a C interface, so nothing can depend on it
mod from_scene;

/// A flow of a plane with the rods in it.
pub type RodsInFlow = Coupled<2, RodInFlow>;

/// A rod with its part of the scene.
pub struct RodInFlow {
    rod: Rod<2>,
    beam: Beam,
    model: scene::Rod,
    scene: Scene,
    pull: Option<Pull>,
}

/// A spring from a station of a rod to a point of the plane.
#[derive(Clone, Copy, Debug)]
pub struct Pull {
    /// Number of the rod, from 0.
    pub rod: usize,
    /// Number of the station, from 0 at the root.
    pub station: usize,
    /// The other end of the spring, m.
    pub to: [f64; 2],
    /// Stiffness, N/m per metre of depth.
    pub stiffness: f64,
}

impl RodInFlow {
    /// The rod of a scene with a single rod, with its root in the place of time 0.
    fn new(scene: Scene) -> Result<Self, String> {
        let (Some(beam), Some(model)) = (scene.beam.clone(), scene.rod.clone()) else {
            return Err(format!("the scene {:?} has no beam with a rod", scene.name));
        };
        if scene.dimension(&beam) != 2 {
            return Err("a rod in space cannot be in this flow, which has two dimensions".into());
        }
        if matches!(model.root_motion, Some(RootMotion::Master)) {
            return Err("`rod.root_motion` is left to a master, but here only laws of time can drive a root".into());
        }
        let mut rod = Rod::new(from_scene::parameters(&scene, &beam, &model)).map_err(|e| e.to_string())?;
        rod.loads = from_scene::loads(&scene, 2, beam.segments + 1);
        let mut own = Self { rod, beam, model, scene, pull: None };
        if let Some(base) = own.base_at(0.0) {
            own.rod.place(base).map_err(|e| e.to_string())?;
        }
        Ok(own)
    }

    /// Return the motion of a driven root at `t` (s).
    fn base_at(&self, t: f64) -> Option<BaseMotion<2>> {
        let Some(RootMotion::Laws(laws)) = &self.model.root_motion else { return None };
        let (rest, direction) = self.scene.beam_root(&self.beam);
        let (displacement, velocity) = laws.displacement(t);
        let (direction, rate) = laws.direction(t, direction);
        let plane = |[x, y, _]: [f64; 3]| [x, y];
        let position = std::array::from_fn(|d| rest[d] + displacement[d]);
        Some(BaseMotion {
            position,
            velocity: plane(velocity),
            direction: plane(direction),
            direction_rate: plane(rate),
        })
    }

    /// Add the force of a spring to the loads: that for a station that keeps its velocity, with the impedance by which
    /// the stretch counts that the step ends with.
    fn pull(&mut self, pull: &Pull, h: f64) {
        let n = self.beam.segments + 1;
        let station = pull.station.min(n - 1);
        let ahead = |axis| self.rod.positions(axis)[station] + h * self.rod.velocities(axis)[station];
        let stretch = [0, 1].map(|axis| pull.to[axis] - ahead(axis));
        let Loads { force, impedance, .. } = &mut self.rod.loads;
        force.resize(2 * n, 0.0);
        impedance.resize(n, 0.0);
        for (force, stretch) in force.chunks_exact_mut(n).zip(stretch) {
            force[station] += pull.stiffness * stretch;
        }
        impedance[station] += pull.stiffness * h;
    }
}

impl Flexible<2> for RodInFlow {
    fn all(scene: &Scene) -> Result<Vec<Self>, String> {
        let of_rod = |name: Option<String>| Scene { this_rod: name, ..scene.clone() }.of_unit();
        if scene.rods.is_empty() {
            return scene.rod.iter().filter_map(|_| of_rod(None)).map(Self::new).collect();
        }
        scene.rods.iter().filter_map(|rod| of_rod(Some(rod.name.clone()))).map(Self::new).collect()
    }

    fn loads_mut(&mut self) -> &mut Loads {
        &mut self.rod.loads
    }

    fn step(&mut self, t: f64, h: f64) -> Result<(), String> {
        if let Some(pull) = self.pull {
            self.pull(&pull, h);
        }
        if let Some(base) = self.base_at(t + h) {
            self.rod.base_motion = Some(base);
        }
        if let Some([x, y, _]) = self.model.root.towing_force(t + h) {
            self.rod.towing = [x, y];
        }
        self.rod.step(h).map_err(|e| e.to_string())
    }

    fn positions(&self, axis: usize) -> &[f64] {
        self.rod.positions(axis)
    }

    fn velocities(&self, axis: usize) -> &[f64] {
        self.rod.velocities(axis)
    }

    fn continue_from(&mut self, other: &Self) -> Result<(), String> {
        self.pull = other.pull;
        self.rod.restore(other.rod.state()).map_err(|e| e.to_string())
    }

    fn sample(&self, to: &mut Vec<f64>) {
        to.extend(self.rod.tip_displacement());
    }
}

impl RodsInFlow {
    /// Pull at a station from now on, or let go.
    pub fn set_pull(&mut self, pull: Option<Pull>) {
        for (i, own) in self.flexible.iter_mut().enumerate() {
            own.pull = pull.filter(|pull| pull.rod == i);
        }
    }
}
