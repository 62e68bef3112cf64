//! The fluid of a scene, in the plane or in space.

use adapter::Dimensions;
use fluid::{Error, Fluid, Followed, Motion, Parameters, Pose, Solvable, State, Stations};
use fmi_export::require_memory;
use scene::Scene;

/// The fluid of a scene.
pub type Flow = Dimensions<FlowIn<2>, FlowIn<3>>;
/// A state of a fluid.
pub type FlowState = Dimensions<State<2>, State<3>>;

/// A fluid of D dimensions, with the inputs of its next step.
pub struct FlowIn<const D: usize>
where
    [f64; D]: Solvable<D>,
{
    parameters: Parameters<D>,
    /// Stations of each flexible body at the end of the step.
    pub stations: Vec<Stations<D>>,
    /// Displacement of each rigid body then; unused but for those that the master moves.
    pub displacements: Vec<Pose<D>>,
    /// Displacement of the fine box then, m; unused unless the master moves it.
    pub box_displacement: [f64; D],
    /// Velocity that the master adds to the stream at the end of the step, m/s; unused without a gust.
    pub gust: [f64; D],
    /// None in a description.
    solver: Option<Fluid<D>>,
}

/// The numbers of dimensions.
pub trait Counted<const D: usize>: Solvable<D> {
    /// Return the fluid, which is of this number.
    fn of(flow: &mut Flow) -> &mut FlowIn<D>
    where
        [f64; D]: Solvable<D>;
}

impl Counted<2> for [f64; 2] {
    fn of(flow: &mut Flow) -> &mut FlowIn<2> {
        if let Flow::Plane(flow) = flow { flow } else { panic!("the list is that of the dimensions of the fluid") }
    }
}

impl Counted<3> for [f64; 3] {
    fn of(flow: &mut Flow) -> &mut FlowIn<3> {
        if let Flow::Space(flow) = flow { flow } else { panic!("the list is that of the dimensions of the fluid") }
    }
}

/// Return the fluid of a scene without its solver; fails if there is no memory for that.
pub fn of_scene(scene: &Scene) -> Result<Flow, String> {
    let is_space = scene.fluid.as_ref().is_some_and(|fluid| fluid.is_space());
    Ok(if is_space { Flow::Space(FlowIn::new(scene)?) } else { Flow::Plane(FlowIn::new(scene)?) })
}

const BUILT: &str = "an instance has a solver";

impl<const D: usize> FlowIn<D>
where
    [f64; D]: Solvable<D>,
    Parameters<D>: for<'a> TryFrom<&'a Scene, Error = Error>,
{
    fn new(scene: &Scene) -> Result<Self, String> {
        let parameters = Parameters::<D>::try_from(scene).map_err(|e| e.to_string())?;
        require_memory(Fluid::bytes(&parameters))?;
        parameters.check().map_err(|e| e.to_string())?;
        Ok(Self {
            stations: parameters.flexible.iter().map(|body| Stations::at_rest(&body.nodes)).collect(),
            displacements: vec![Pose::default(); parameters.bodies.len()],
            box_displacement: [0.0; D],
            gust: [0.0; D],
            solver: None,
            parameters,
        })
    }

    /// Make the solver.
    pub fn build(&mut self) -> Result<(), String> {
        self.solver = Some(Fluid::new(&self.parameters).map_err(|e| e.to_string())?);
        Ok(())
    }

    /// Make the solver again, for a scene with other numbers; after an error it is as before.
    pub fn change(&mut self, scene: &Scene) -> Result<(), String> {
        let Self { stations, displacements, box_displacement, gust, .. } = self;
        let mut changed = Self::new(scene)?;
        changed.build()?;
        (changed.stations, changed.displacements) = (stations.clone(), displacements.clone());
        (changed.box_displacement, changed.gust) = (*box_displacement, *gust);
        *self = changed;
        Ok(())
    }
}

impl<const D: usize> FlowIn<D>
where
    [f64; D]: Solvable<D>,
{
    pub fn solver(&self) -> &Fluid<D> {
        self.solver.as_ref().expect(BUILT)
    }

    pub fn solver_mut(&mut self) -> &mut Fluid<D> {
        self.solver.as_mut().expect(BUILT)
    }

    /// Return the number of cells along each axis.
    pub fn cells(&self) -> &[usize] {
        &self.parameters.cells
    }

    /// Return the number of stations and nodes of the flexible bodies.
    pub fn nodes(&self) -> usize {
        self.stations.iter().map(Stations::len).sum()
    }

    /// Start at a time (s), with the bodies where they are set.
    pub fn start_at(&mut self, start: f64) -> Result<(), Error> {
        self.give_displacements();
        let is_free = self.parameters.fine_box.is_some_and(|fine| fine.follows == Some(Followed::Master));
        if is_free || self.give_gust() || start != self.solver().time() {
            self.solver_mut().start_at(start);
        }
        self.solver_mut().announce_first()
    }

    /// Advance from `t` to `t + h` (s).
    pub fn advance(&mut self, t: f64, h: f64) -> Result<(), Error> {
        self.give_displacements();
        self.give_gust();
        let solver = self.solver.as_mut().expect(BUILT);
        solver.stations_mut().iter_mut().zip(&self.stations).for_each(|(to, from)| to.copy_from(from));
        solver.advance(t, h)
    }

    /// Return whether stations move in a step of `h` (s) that is longer than their announced loads hold, and which the
    /// solver takes all the same.
    pub fn outlives_loads(&self, h: f64) -> bool {
        let solver = self.solver();
        let moves = |own: &Stations<D>| own.velocity.iter().flatten().any(|velocity| *velocity != 0.0);
        D == 2 && solver.announces() && h > solver.longest_step() * (1.0 + 1e-9) && self.stations.iter().any(moves)
    }

    /// Give the stream what the master adds to it, and return whether there is such a gust.
    fn give_gust(&self) -> bool {
        self.parameters.gust.as_ref().inspect(|gust| gust.set(&self.gust)).is_some()
    }

    /// Give the solver the displacements of the bodies that the master moves, and of the fine box.
    fn give_displacements(&mut self) {
        let solver = self.solver.as_mut().expect(BUILT);
        *solver.box_displacement_mut() = self.box_displacement;
        for (k, (body, displacement)) in self.parameters.bodies.iter().zip(&self.displacements).enumerate() {
            if matches!(body.motion, Some(Motion::Master)) {
                *solver.displacement_mut(k) = *displacement;
            }
        }
    }

    /// Return the number of cells along each axis and the values of a field there, in SI units; none of an unknown name.
    /// With `fine.` in front of the name they are those of the fine box.
    pub fn field(&mut self, name: &str) -> Option<(Vec<usize>, Vec<f64>)> {
        let solver = self.solver_mut();
        let (name, is_fine) = name.strip_prefix("fine.").map_or((name, false), |name| (name, true));
        let about = ["vorticity_x", "vorticity_y", "vorticity"].iter().position(|known| *known == name);
        let about = about.and_then(|about| if D == 3 { Some(about) } else { about.checked_sub(2) });
        let along = ["u", "v", "w"].iter().position(|known| *known == name).filter(|axis| *axis < D);
        let values = match (is_fine, about, along) {
            (true, ..) if !solver.has_fine_box() => return None,
            (true, Some(about), _) => solver.fine_vorticity(about),
            (true, _, Some(axis)) => solver.fine_velocity(axis),
            (true, ..) if name == "p" => solver.fine_pressure(),
            (false, Some(about), _) => solver.vorticity(about).into_owned(),
            (false, _, Some(axis)) => solver.velocity(axis).into_owned(),
            (false, ..) if name == "p" => solver.pressure(),
            _ => return None,
        };
        let cells = if is_fine { solver.grid_of_bodies().cells } else { solver.grid().cells };
        Some((cells.to_vec(), values))
    }
}
