//! The fluid of a scene, in the plane or in space.

use std::any::Any;

use fluid::{Error, Fluid, Parameters, Pose, Solvable, State, Stations};
use fmi_export::require_memory;
use scene::Scene;
use serde::{Deserialize, Serialize};

/// A fluid of any number of dimensions.
pub trait Flow: Any + Send {
    /// Return the number of cells along each axis.
    fn cells(&self) -> &[usize];

    /// Return the number of stations and nodes of the flexible bodies.
    fn stations(&self) -> usize;

    /// Start at another time than the present one, s.
    fn start_at(&mut self, start: f64);

    /// Advance from `t` to `t + h` (s).
    fn advance(&mut self, t: f64, h: f64) -> Result<(), Error>;

    /// Return the approximate memory of a state, bytes.
    fn state_bytes(&self) -> usize;

    /// Return a copy of everything that the next step depends on, with the inputs.
    fn save(&self) -> FlowState;

    /// Go to a state.
    fn restore(&mut self, state: &FlowState) -> Result<(), String>;

    /// Copy the inputs of another fluid of the same bodies.
    fn copy_inputs(&mut self, other: &dyn Any);

    /// Return the values of a field at the points of the grid, in SI units; none of an unknown name.
    fn field(&mut self, name: &str) -> Option<Vec<f64>>;
}

/// A state with the inputs.
#[derive(Clone, Serialize, Deserialize)]
pub enum FlowState {
    Plane(Saved<2>),
    Space(Saved<3>),
}

/// A state of a fluid of D dimensions with its inputs.
#[derive(Clone, Serialize, Deserialize)]
pub struct Saved<const D: usize>
where
    [f64; D]: Solvable<D>,
{
    state: State<D>,
    stations: Vec<Stations<D>>,
    displacements: Vec<Pose<D>>,
}

/// The numbers of dimensions.
pub trait Dimensions<const D: usize>: Solvable<D> {
    fn wrap(saved: Saved<D>) -> FlowState
    where
        [f64; D]: Solvable<D>;
    fn unwrap(state: &FlowState) -> Option<&Saved<D>>
    where
        [f64; D]: Solvable<D>;
}

impl Dimensions<2> for [f64; 2] {
    fn wrap(saved: Saved<2>) -> FlowState {
        FlowState::Plane(saved)
    }

    fn unwrap(state: &FlowState) -> Option<&Saved<2>> {
        if let FlowState::Plane(saved) = state { Some(saved) } else { None }
    }
}

impl Dimensions<3> for [f64; 3] {
    fn wrap(saved: Saved<3>) -> FlowState {
        FlowState::Space(saved)
    }

    fn unwrap(state: &FlowState) -> Option<&Saved<3>> {
        if let FlowState::Space(saved) = state { Some(saved) } else { None }
    }
}

/// Make the fluid of a scene; fails if there is no memory for it.
pub fn new(scene: &Scene) -> Result<Box<dyn Flow>, String> {
    if scene.fluid.as_ref().is_some_and(|fluid| fluid.is_space()) { make::<3>(scene) } else { make::<2>(scene) }
}

fn make<const D: usize>(scene: &Scene) -> Result<Box<dyn Flow>, String>
where
    [f64; D]: Dimensions<D>,
    Parameters<D>: for<'a> TryFrom<&'a Scene, Error = Error>,
{
    let text = |error: Error| error.to_string();
    let parameters = Parameters::<D>::try_from(scene).map_err(text)?;
    require_memory(Fluid::bytes(&parameters))?;
    Ok(Box::new(Fluid::new(&parameters).map_err(text)?))
}

impl<const D: usize> Flow for Fluid<D>
where
    [f64; D]: Dimensions<D>,
{
    fn cells(&self) -> &[usize] {
        &self.grid().cells
    }

    fn stations(&self) -> usize {
        Fluid::stations(self).iter().map(Stations::len).sum()
    }

    fn start_at(&mut self, start: f64) {
        if start != self.time() {
            Fluid::start_at(self, start);
        }
    }

    fn advance(&mut self, t: f64, h: f64) -> Result<(), Error> {
        Fluid::advance(self, t, h)
    }

    fn state_bytes(&self) -> usize {
        Fluid::state_bytes(self)
    }

    fn save(&self) -> FlowState {
        let (stations, displacements) = (Fluid::stations(self).to_vec(), self.displacements().to_vec());
        <[f64; D]>::wrap(Saved { state: self.state(), stations, displacements })
    }

    fn restore(&mut self, state: &FlowState) -> Result<(), String> {
        let Some(saved) = <[f64; D]>::unwrap(state) else {
            return Err("it is the state of a fluid with another number of dimensions".into());
        };
        let own = Fluid::stations(self);
        if own.len() != saved.stations.len() || own.iter().zip(&saved.stations).any(|(a, b)| !a.has_shape_of(b)) {
            return Err("its stations are not as many as those of this beam".into());
        }
        if self.displacements().len() != saved.displacements.len() {
            return Err("its bodies are not as many as those of this fluid".into());
        }
        Fluid::restore(self, &saved.state).map_err(|e| e.to_string())?;
        self.stations_mut().iter_mut().zip(&saved.stations).for_each(|(own, saved)| own.copy_from(saved));
        self.displacements_mut().copy_from_slice(&saved.displacements);
        Ok(())
    }

    fn copy_inputs(&mut self, other: &dyn Any) {
        if let Some(other) = other.downcast_ref::<Self>() {
            let stations = Fluid::stations(other);
            self.stations_mut().iter_mut().zip(stations).for_each(|(own, set)| own.copy_from(set));
            self.displacements_mut().copy_from_slice(other.displacements());
        }
    }

    fn field(&mut self, name: &str) -> Option<Vec<f64>> {
        let about = ["vorticity_x", "vorticity_y", "vorticity"].iter().position(|known| *known == name);
        let along = ["u", "v", "w"].iter().position(|known| *known == name).filter(|axis| *axis < D);
        match (name, about, along) {
            ("p", ..) => Some(self.pressure()),
            (_, Some(about), _) if D == 3 => Some(self.vorticity(about).into_owned()),
            (_, Some(2), _) => Some(self.vorticity(0).into_owned()),
            (_, _, Some(axis)) => Some(self.velocity(axis).into_owned()),
            _ => None,
        }
    }
}
