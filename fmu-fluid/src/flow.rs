//! The fluid of a scene, in two or three dimensions.

use fluid::{Error, Fluid, Pose, Stations, space};
use fmi_export::require_memory;
use scene::Scene;
use serde::{Deserialize, Serialize};

/// A fluid of two or three dimensions.
pub enum Flow {
    Plane(Box<Fluid>),
    Space(Box<space::Fluid>),
}

/// A state of it.
#[derive(Clone, Serialize, Deserialize)]
pub enum FlowState {
    Plane(fluid::State),
    Space(space::State),
}

impl Flow {
    /// Make the fluid of a scene; fails if there is no memory for it.
    pub fn new(scene: &Scene) -> Result<Self, String> {
        let text = |error: Error| error.to_string();
        if scene.fluid.as_ref().is_some_and(|fluid| fluid.is_space()) {
            let parameters = space::Parameters::try_from(scene).map_err(text)?;
            require_memory(space::Fluid::bytes(&parameters))?;
            return space::Fluid::new(&parameters).map(|fluid| Self::Space(Box::new(fluid))).map_err(text);
        }
        let parameters = fluid::Parameters::try_from(scene).map_err(text)?;
        require_memory(Fluid::bytes(&parameters))?;
        Fluid::new(&parameters).map(|fluid| Self::Plane(Box::new(fluid))).map_err(text)
    }

    /// Return the fluid that has two dimensions.
    pub fn plane(&mut self) -> &mut Fluid {
        match self {
            Self::Plane(fluid) => fluid,
            Self::Space(_) => unreachable!("its variables are those of three dimensions"),
        }
    }

    /// Return the fluid that has three dimensions.
    pub fn space(&mut self) -> &mut space::Fluid {
        match self {
            Self::Space(fluid) => fluid,
            Self::Plane(_) => unreachable!("its variables are those of two dimensions"),
        }
    }

    /// Return the stations of the beams at the end of the coming step; none in three dimensions.
    pub fn stations(&self) -> &[Stations] {
        match self {
            Self::Plane(fluid) => fluid.stations(),
            Self::Space(_) => &[],
        }
    }

    /// Return the stations of the beams, to be set.
    pub fn stations_mut(&mut self) -> &mut [Stations] {
        match self {
            Self::Plane(fluid) => fluid.stations_mut(),
            Self::Space(_) => &mut [],
        }
    }

    /// Return the nodes of thin bodies in space at the end of the coming step; none in two dimensions.
    pub fn nodes(&self) -> &[Stations<3>] {
        match self {
            Self::Plane(_) => &[],
            Self::Space(fluid) => fluid.nodes(),
        }
    }

    /// Return the same, to be set.
    pub fn nodes_mut(&mut self) -> &mut [Stations<3>] {
        match self {
            Self::Plane(_) => &mut [],
            Self::Space(fluid) => fluid.nodes_mut(),
        }
    }

    /// Return the displacements of the bodies that the master moves; none in three dimensions.
    pub fn displacements(&self) -> &[Pose] {
        match self {
            Self::Plane(fluid) => fluid.displacements(),
            Self::Space(_) => &[],
        }
    }

    /// Return the same, to be set.
    pub fn displacements_mut(&mut self) -> &mut [Pose] {
        match self {
            Self::Plane(fluid) => fluid.displacements_mut(),
            Self::Space(_) => &mut [],
        }
    }

    /// Return the numbers of cells as a text.
    pub fn cells(&self) -> String {
        let cells = match self {
            Self::Plane(fluid) => fluid.grid().cells.to_vec(),
            Self::Space(fluid) => fluid.grid().cells.to_vec(),
        };
        cells.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ")
    }

    /// Start at another time than the present one, s.
    pub fn start_at(&mut self, start: f64) {
        match self {
            Self::Plane(fluid) if start != fluid.time() => fluid.start_at(start),
            Self::Space(fluid) if start != fluid.time() => fluid.start_at(start),
            _ => {}
        }
    }

    /// Advance from `t` to `t + h` (s).
    pub fn advance(&mut self, t: f64, h: f64) -> Result<(), Error> {
        match self {
            Self::Plane(fluid) => fluid.advance(t, h),
            Self::Space(fluid) => fluid.advance(t, h),
        }
    }

    /// Return the approximate memory of a state, bytes.
    pub fn state_bytes(&self) -> usize {
        match self {
            Self::Plane(fluid) => fluid.state_bytes(),
            Self::Space(fluid) => fluid.state_bytes(),
        }
    }

    /// Return a copy of everything that the next step depends on.
    pub fn state(&self) -> FlowState {
        match self {
            Self::Plane(fluid) => FlowState::Plane(fluid.state()),
            Self::Space(fluid) => FlowState::Space(fluid.state()),
        }
    }

    /// Go to a state.
    pub fn restore(&mut self, state: &FlowState) -> Result<(), String> {
        match (self, state) {
            (Self::Plane(fluid), FlowState::Plane(state)) => fluid.restore(state).map_err(|e| e.to_string()),
            (Self::Space(fluid), FlowState::Space(state)) => fluid.restore(state).map_err(|e| e.to_string()),
            _ => Err("it is the state of a fluid with another number of dimensions".into()),
        }
    }

    /// Return shape and values of a field, in SI units; none of an unknown name.
    pub fn field(&mut self, name: &str) -> Option<(Vec<usize>, Vec<f64>)> {
        let axis = ["u", "v", "w"].iter().position(|known| *known == name);
        let values = match self {
            Self::Plane(fluid) => match (name, axis) {
                ("vorticity", _) => fluid.vorticity().into_owned(),
                ("p", _) => fluid.pressure(),
                (_, Some(axis @ (0 | 1))) => fluid.velocity(axis).into_owned(),
                _ => return None,
            },
            Self::Space(fluid) => match (name, axis) {
                ("vorticity_x", _) => fluid.vorticity(0).into_owned(),
                ("vorticity_y", _) => fluid.vorticity(1).into_owned(),
                ("vorticity", _) => fluid.vorticity(2).into_owned(),
                ("p", _) => fluid.pressure(),
                (_, Some(axis)) => fluid.velocity(axis).into_owned(),
                _ => return None,
            },
        };
        let cells = match self {
            Self::Plane(fluid) => fluid.grid().cells.to_vec(),
            Self::Space(fluid) => fluid.grid().cells.to_vec(),
        };
        Some((cells, values))
    }
}
