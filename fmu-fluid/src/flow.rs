//! The fluid of a scene, in the plane or in space.

use std::any::Any;

use fluid::{Error, Fluid, Parameters, Solvable, State, Stations};
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

    /// Return a copy of everything that the next step depends on, but the inputs.
    fn save(&self) -> FlowState;

    /// Go to a state.
    fn restore(&mut self, state: &FlowState) -> Result<(), String>;

    /// Copy the inputs of another fluid of the same bodies.
    fn copy_inputs(&mut self, other: &dyn Any);

    /// Return the values of a field at the points of the grid, in SI units; none of an unknown name.
    fn field(&mut self, name: &str) -> Option<Vec<f64>>;
}

/// A state of a fluid of two or three dimensions.
#[derive(Clone, Serialize, Deserialize)]
pub enum FlowState {
    Plane(State<2>),
    Space(State<3>),
}

/// The numbers of dimensions.
pub trait Dimensions<const D: usize>: Solvable<D> {
    fn wrap(state: State<D>) -> FlowState
    where
        [f64; D]: Solvable<D>;
    fn unwrap(state: &FlowState) -> Option<&State<D>>
    where
        [f64; D]: Solvable<D>;
}

impl Dimensions<2> for [f64; 2] {
    fn wrap(state: State<2>) -> FlowState {
        FlowState::Plane(state)
    }

    fn unwrap(state: &FlowState) -> Option<&State<2>> {
        if let FlowState::Plane(state) = state { Some(state) } else { None }
    }
}

impl Dimensions<3> for [f64; 3] {
    fn wrap(state: State<3>) -> FlowState {
        FlowState::Space(state)
    }

    fn unwrap(state: &FlowState) -> Option<&State<3>> {
        if let FlowState::Space(state) = state { Some(state) } else { None }
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
        <[f64; D]>::wrap(self.state())
    }

    fn restore(&mut self, state: &FlowState) -> Result<(), String> {
        let own = <[f64; D]>::unwrap(state).ok_or("it is the state of a fluid with another number of dimensions")?;
        Fluid::restore(self, own).map_err(|e| e.to_string())
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
