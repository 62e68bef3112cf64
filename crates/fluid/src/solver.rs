//! The flow with its time scheme, in one precision behind an object: a communication step chooses no precision inside.

use std::borrow::Cow;
use std::marker::PhantomData;
use std::ops::Range;

use line_fft::Real;
use method::{Precision, TimeScheme};

use crate::error::Error;
use crate::filter::Damping;
use crate::flow::Flow;
use crate::parameters::Parameters;
use crate::present::Present;
use crate::problem::Problem;
use crate::space::Space;
use crate::spectral::{PlaneTransforms, Transforms, VolumeTransforms};
use crate::state::{ByPrecision, Fields, Stored};
use crate::step::{DomainReader, Rk2, Sbdf2, Scheme, StartVelocity, Substep, square, static_pressure};
use crate::two_grids::TwoGrids;

/// Reads the static pressure over the density, given at a grid point.
pub type PressureReader<'a, const D: usize> = dyn FnMut(&Problem<D>, &dyn Fn(usize) -> f64) + 'a;

/// A flow that can be stepped.
pub trait FluidSolver<const D: usize>: Send
where
    [f64; D]: Space<D>,
{
    /// Start from the divergence-free part of a velocity.
    fn start(&mut self, velocity: &StartVelocity<D>, present: &mut Present<D>, problem: &mut Problem<D>);

    /// Put the grids of boxes to where the bodies are, or by ways (m) from where they began, before the first step.
    fn place_grids(&mut self, ways: &[[f64; D]], present: &Present<D>, problem: &Problem<D>);

    /// Return the ways that the grids of boxes have moved, m, the finest first.
    fn ways(&self) -> Vec<[f64; D]>;

    /// Return the way that the bodies' grid has moved, m.
    fn way(&self) -> [f64; D];

    /// Return the same of fields that [`Self::check`] accepts.
    fn way_in(&self, fields: &ByPrecision<D>) -> [f64; D];

    /// Return the longest step that is stable with the bodies, s; none if there is no limit.
    fn longest_step(&self, problem: &Problem<D>) -> Option<f64>;

    /// Make a step; see [`Scheme::step`].
    fn step(&mut self, step: &Substep<D>, present: &mut Present<D>, problem: &mut Problem<D>) -> Result<(), Error>;

    /// Write the loads for the coming step of `dt` seconds to `present`; see [`Scheme::predict_loads`].
    fn predict_loads(&mut self, dt: f64, present: &mut Present<D>, problem: &mut Problem<D>);

    /// Call `read` with the problem and the static pressure over the density, `Pi − u²/2` (m²/s²), at a grid point.
    fn read_pressure(&mut self, present: &Present<D>, problem: &mut Problem<D>, read: &mut PressureReader<D>);

    /// Call `read` with the same at a point of the domain.
    fn read_in_domain(&mut self, present: &Present<D>, problem: &mut Problem<D>, read: &mut DomainReader);

    /// Return the largest divergence (1/s) and the largest speed (m/s).
    fn divergence(&mut self) -> [f64; 2];

    /// Return a velocity component, m/s; in single precision a copy.
    fn velocity(&self, axis: usize) -> Cow<'_, [f64]>;

    /// Return a velocity component on each grid at the present time, m/s, that of the bodies first.
    fn velocities(&self, axis: usize) -> Vec<Cow<'_, [f64]>>;

    /// Return a velocity component on the grid of the bodies, m/s.
    fn own_velocity(&self, axis: usize) -> Cow<'_, [f64]>;

    /// Return a vorticity component on the grid of the bodies, 1/s.
    fn own_vorticity(&self, component: usize) -> Cow<'_, [f64]>;

    /// Return a vorticity component, 1/s; in single precision a copy.
    fn vorticity(&self, component: usize) -> Cow<'_, [f64]>;

    /// Return the velocity interpolated by points of the bodies' grid and weights, m/s.
    fn velocity_by(&self, weights: &[(usize, f64)]) -> [f64; D];

    /// Return the same by points of the domain, of the coarse flow if there are two.
    fn coarse_velocity_by(&self, weights: &[(usize, f64)]) -> [f64; D];

    /// Return the sum of the velocity along x over some points of the domain, m/s.
    fn sum_of_u(&self, points: Range<usize>) -> f64;

    /// Return the sums over the domain of the squared velocity (m²/s²) and of the squared vorticity (1/s²).
    fn squares(&self) -> [f64; 2];

    /// Return the number of threads that share a step.
    fn threads(&self) -> usize;

    /// Return a copy of everything that the next step depends on, but what is in `present`.
    fn fields(&self) -> ByPrecision<D>;

    /// Overwrite such a copy; allocates nothing.
    fn save(&self, fields: &mut ByPrecision<D>);

    /// Refuse fields of another precision, scheme or size.
    fn check(&self, fields: &ByPrecision<D>) -> Result<(), Error>;

    /// Go to fields that [`Self::check`] accepts; fails, and changes nothing, if they are in another precision.
    fn restore(&mut self, fields: &ByPrecision<D>) -> Result<(), Error>;
}

/// A number of dimensions for which there are solvers.
pub trait Solvable<const D: usize>: Space<D> {
    /// Make the solver of the wanted scheme and precision for a problem at t = 0; space has one scheme.
    fn new_solver(parameters: &Parameters<D>, problem: &Problem<D>) -> Box<dyn FluidSolver<D>>
    where
        [f64; D]: Space<D>;
}

impl Solvable<2> for [f64; 2] {
    fn new_solver(parameters: &Parameters, problem: &Problem<2>) -> Box<dyn FluidSolver<2>> {
        match (parameters.scheme, parameters.precision) {
            (TimeScheme::Sbdf2, Precision::Double) => sbdf2::<f64, PlaneTransforms<f64>, 2>(parameters, problem),
            (TimeScheme::Sbdf2, Precision::Single) => sbdf2::<f32, PlaneTransforms<f32>, 2>(parameters, problem),
            (TimeScheme::Rk2, Precision::Double) => rk2::<f64>(parameters),
            (TimeScheme::Rk2, Precision::Single) => rk2::<f32>(parameters),
        }
    }
}

impl Solvable<3> for [f64; 3] {
    fn new_solver(parameters: &Parameters<3>, problem: &Problem<3>) -> Box<dyn FluidSolver<3>> {
        match parameters.precision {
            Precision::Double => sbdf2::<f64, VolumeTransforms<f64>, 3>(parameters, problem),
            Precision::Single => sbdf2::<f32, VolumeTransforms<f32>, 3>(parameters, problem),
        }
    }
}

fn transforms<R: Real, T: Transforms<R, D>, const D: usize>(parameters: &Parameters<D>) -> T
where
    [f64; D]: Space<D>,
{
    T::new(&parameters.grid(), parameters.filter.into(), parameters.threads)
}

fn sbdf2<R: Stored, T: Transforms<R, D> + 'static, const D: usize>(
    parameters: &Parameters<D>,
    problem: &Problem<D>,
) -> Box<dyn FluidSolver<D>>
where
    [f64; D]: Space<D>,
{
    let points = parameters.grid_of_bodies().len();
    let flow = Flow::uniform(parameters.initial_velocity, points);
    let Some(fine) = &parameters.fine_box else {
        let scheme = Sbdf2::new(transforms::<R, T, D>(parameters), points);
        return Box::new(Solver { flow, scheme, precision: PhantomData });
    };
    let grid = parameters.grid();
    let of_domain = Sbdf2::<R, T, D>::new(T::new(&grid, Damping::EachAxis, parameters.threads), grid.len());
    let of_domain = of_domain.with_source();
    let range = parameters.range_of_fine_box(fine);
    if let Some(middle) = parameters.middle() {
        let within = parameters.within(&middle);
        let around = Problem::new(&within.without_bodies());
        let most = parameters.range_of_fine_box(&middle);
        let of_middle = TwoGrids::<R, T, _, D>::new(parameters, &middle, most, &around, of_domain).below();
        let (fine, range) = (fine.within(&middle), fine.range_within(&middle, most, range));
        let scheme = TwoGrids::<R, T, _, D>::new(&within, &fine, range, problem, of_middle);
        return Box::new(Solver { flow, scheme, precision: PhantomData });
    }
    let scheme = TwoGrids::<R, T, _, D>::new(parameters, fine, range, problem, of_domain);
    Box::new(Solver { flow, scheme, precision: PhantomData })
}

fn rk2<R: Stored>(parameters: &Parameters) -> Box<dyn FluidSolver<2>> {
    let (grid, velocity) = (parameters.grid(), parameters.initial_velocity);
    let scheme = Rk2::new(transforms::<R, _, 2>(parameters), velocity, &grid);
    Box::new(Solver { flow: Flow::uniform(velocity, grid.len()), scheme, precision: PhantomData })
}

/// The flow of a precision with its scheme.
struct Solver<R: Real, S, const D: usize> {
    flow: Flow<R, D>,
    scheme: S,
    precision: PhantomData<R>,
}

impl<R: Stored, S: Scheme<R, D>, const D: usize> FluidSolver<D> for Solver<R, S, D>
where
    [f64; D]: Space<D>,
{
    fn start(&mut self, velocity: &StartVelocity<D>, present: &mut Present<D>, problem: &mut Problem<D>) {
        present.step = 0.0;
        self.scheme.start(velocity, &mut self.flow, present, problem);
    }

    fn place_grids(&mut self, ways: &[[f64; D]], present: &Present<D>, problem: &Problem<D>) {
        self.scheme.place_grids(ways, &mut self.flow, present, problem);
    }

    fn ways(&self) -> Vec<[f64; D]> {
        self.scheme.ways()
    }

    fn way(&self) -> [f64; D] {
        self.scheme.way(None)
    }

    fn way_in(&self, fields: &ByPrecision<D>) -> [f64; D] {
        self.scheme.way(R::of(fields).ok().map(|fields| &fields.memory))
    }

    fn longest_step(&self, problem: &Problem<D>) -> Option<f64> {
        self.scheme.longest_step(problem)
    }

    fn step(&mut self, step: &Substep<D>, present: &mut Present<D>, problem: &mut Problem<D>) -> Result<(), Error> {
        self.scheme.step(step, &mut self.flow, present, problem)
    }

    fn predict_loads(&mut self, dt: f64, present: &mut Present<D>, problem: &mut Problem<D>) {
        self.scheme.predict_loads(dt, &self.flow, present, problem);
    }

    fn read_pressure(&mut self, present: &Present<D>, problem: &mut Problem<D>, read: &mut PressureReader<D>) {
        let Self { flow, scheme, .. } = self;
        let pi = scheme.total_pressure(flow, present, problem);
        read(problem, &|point| static_pressure(pi, flow, point));
    }

    fn read_in_domain(&mut self, present: &Present<D>, problem: &mut Problem<D>, read: &mut DomainReader) {
        self.scheme.read_in_domain(&self.flow, present, problem, read);
    }

    fn divergence(&mut self) -> [f64; 2] {
        let Self { flow, scheme, .. } = self;
        let divergence = scheme.divergence(&flow.velocity);
        let largest = divergence.iter().fold(0.0_f64, |most, divergence| most.max(divergence.to_f64().abs()));
        let speed = |point| flow.velocity_at(point).iter().fold(0.0_f64, |speed, u| speed.hypot(*u));
        [largest, (0..divergence.len()).map(speed).fold(0.0, f64::max)]
    }

    fn velocity(&self, axis: usize) -> Cow<'_, [f64]> {
        self.scheme.over_domain(&self.flow, |flow| &flow.velocity[axis])
    }

    fn velocities(&self, axis: usize) -> Vec<Cow<'_, [f64]>> {
        self.scheme.velocities(&self.flow, axis, 0.0, 0.0)
    }

    fn own_velocity(&self, axis: usize) -> Cow<'_, [f64]> {
        R::field_to_f64(&self.flow.velocity[axis])
    }

    fn own_vorticity(&self, component: usize) -> Cow<'_, [f64]> {
        R::field_to_f64(&self.flow.vorticity[component])
    }

    fn vorticity(&self, component: usize) -> Cow<'_, [f64]> {
        self.scheme.over_domain(&self.flow, |flow| &flow.vorticity[component])
    }

    fn velocity_by(&self, weights: &[(usize, f64)]) -> [f64; D] {
        self.flow.velocity_by(weights)
    }

    fn coarse_velocity_by(&self, weights: &[(usize, f64)]) -> [f64; D] {
        let mut sums = [0.0; D];
        for &(point, weight) in weights {
            self.scheme.for_each_in_coarse(&self.flow, point..point + 1, |flow, own| {
                let at = flow.velocity_at(own);
                sums.iter_mut().zip(at).for_each(|(sum, u)| *sum += weight * u);
            });
        }
        sums
    }

    fn sum_of_u(&self, points: Range<usize>) -> f64 {
        let mut sum = 0.0;
        self.scheme.for_each_in_domain(&self.flow, points, |flow, own| sum += flow.velocity[0][own].to_f64());
        sum
    }

    fn squares(&self) -> [f64; 2] {
        let (mut sums, all) = ([0.0; 2], 0..self.scheme.of_domain(&self.flow).velocity[0].len());
        let visit = |flow: &Flow<R, D>, own: usize| sums[0] += square(flow.velocity_at(own));
        self.scheme.for_each_in_domain(&self.flow, all.clone(), visit);
        for component in 0..<[f64; D]>::VORTICITY {
            let visit = |flow: &Flow<R, D>, own: usize| sums[1] += flow.vorticity[component][own].to_f64().powi(2);
            self.scheme.for_each_in_domain(&self.flow, all.clone(), visit);
        }
        sums
    }

    fn threads(&self) -> usize {
        self.scheme.threads()
    }

    fn fields(&self) -> ByPrecision<D> {
        R::wrap(Fields { flow: self.flow.clone(), memory: self.scheme.memory() })
    }

    fn save(&self, fields: &mut ByPrecision<D>) {
        if let Ok(fields) = R::of_mut(fields) {
            fields.flow.copy_from(&self.flow);
            self.scheme.save(&mut fields.memory);
        }
    }

    fn check(&self, fields: &ByPrecision<D>) -> Result<(), Error> {
        let fields = R::of(fields)?;
        let fits = self.flow.has_shape_of(&fields.flow) && self.scheme.fits(&fields.memory);
        if fits { Ok(()) } else { Err(Error::State("a field")) }
    }

    fn restore(&mut self, fields: &ByPrecision<D>) -> Result<(), Error> {
        let fields = R::of(fields)?;
        self.flow.copy_from(&fields.flow);
        self.scheme.restore(&fields.memory);
        Ok(())
    }
}
