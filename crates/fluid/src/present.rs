//! The present time: the bodies as the fluid last saw them. All of it is in double precision.

use serde::{Deserialize, Serialize};
use serde_big_array::BigArray;

use crate::bodies::DisplacementHistory;
use crate::force::{BodyForce, Exchange};
use crate::grid::Grid;
use crate::space::{Freedoms, Space};
use contact::{Loads, Stations};

/// What a fluid of any precision and scheme has at the present time, without the flow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Present<const D: usize>
where
    [f64; D]: Space<D>,
{
    /// Time, s.
    pub time: f64,
    /// Last step, s; 0 before the first.
    pub step: f64,
    /// Largest `|u|/dx + |v|/dy + …`, 1/s.
    pub advection_rate: f64,
    /// Forces on the rigid bodies, then on the flexible ones.
    pub bodies: Vec<BodyForce<D>>,
    /// Displacements of the bodies that laws do not move.
    pub histories: Vec<DisplacementHistory<D>>,
    /// Velocity that the master adds to the stream, m/s; 0 without a gust.
    #[serde(with = "BigArray")]
    pub gust: [f64; D],
    /// The flexible bodies.
    pub flexible: Interfaces<D>,
}

/// What is exchanged with the flexible bodies, as the fluid last saw them; every list is empty without one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interfaces<const D: usize> {
    /// Stations.
    pub stations: Vec<Stations<D>>,
    /// Loads for the coming step; empty if no loads are predicted.
    pub loads: Vec<Loads<D>>,
    /// Forces, powers and works of the fluid on the bodies.
    pub exchange: Vec<Exchange<D>>,
    /// Impulse of force and moment about the origin, N s and N m s, that each is still owed; empty without a surface.
    pub owed: Vec<Freedoms>,
    /// Impulses that contact owes.
    pub contact: ContactOwed<D>,
    /// Pressure above less the pressure below the stations of each line in the plane and surface in space, Pa; empty for
    /// other bodies.
    pub jump: Vec<Vec<f64>>,
    /// Shear stress on both faces in the same places, Pa, by component: of a line towards its tip, of a surface along each
    /// axis.
    pub shear: Vec<Vec<Vec<f64>>>,
}

/// Impulses that the coming loads of contact add, so that both sides get the same; every list is empty without contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactOwed<const D: usize> {
    /// Length of the step in which they are paid, s.
    pub step: f64,
    /// Impulses on the flexible bodies, N s.
    pub flexible: Vec<Loads<D>>,
    /// Impulses of force and moment about the pivot on the rigid ones, N s and N m s.
    pub bodies: Vec<Freedoms>,
}

impl<const D: usize> Present<D>
where
    [f64; D]: Space<D>,
{
    /// A uniform flow (m/s) without a body.
    pub fn without_bodies(grid: &Grid<D>, velocity: [f64; D]) -> Self {
        let contact = ContactOwed { step: 0.0, flexible: vec![], bodies: vec![] };
        let (stations, loads, exchange, owed, jump, shear) = (vec![], vec![], vec![], vec![], vec![], vec![]);
        let flexible = Interfaces { stations, loads, exchange, owed, contact, jump, shear };
        let advection_rate = velocity.iter().zip(grid.spacing).map(|(u, spacing)| u.abs() / spacing).sum();
        Self { time: 0.0, step: 0.0, advection_rate, bodies: vec![], histories: vec![], gust: [0.0; D], flexible }
    }

    /// Return the CFL number of the last step, or of a step of another length (s) in the present flow.
    pub fn cfl(&self, step: f64) -> f64 {
        self.advection_rate * step
    }

    /// Copy `other`, which has the same shape; unlike `clone_from` this allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        (self.time, self.step, self.advection_rate) = (other.time, other.step, other.advection_rate);
        self.bodies.copy_from_slice(&other.bodies);
        self.histories.copy_from_slice(&other.histories);
        self.gust = other.gust;
        self.flexible.copy_from(&other.flexible);
    }

    /// Return the first part that differs in size from `own`, or is a number and not finite.
    pub fn misfit(&self, own: &Self) -> Option<&'static str> {
        let numbers = [self.time, self.step, self.advection_rate, self.flexible.contact.step];
        let parts = [
            ("the time or a step", numbers.iter().all(|number| number.is_finite())),
            (
                "the list of bodies",
                self.bodies.len() == own.bodies.len() && self.histories.len() == own.histories.len(),
            ),
            ("the place of a body", self.histories.iter().all(DisplacementHistory::is_finite)),
            ("the gust", self.gust.iter().all(|component| component.is_finite())),
            ("the list of stations", self.flexible.have_shape_of(&own.flexible)),
        ];
        parts.into_iter().find(|(_, fits)| !fits).map(|(part, _)| part)
    }
}

impl<const D: usize> Interfaces<D> {
    /// Copy `other`, which has the same shape; unlike `clone_from` this allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        Stations::copy_all(&mut self.stations, &other.stations);
        self.loads.iter_mut().zip(&other.loads).for_each(|(own, other)| own.copy_from(other));
        self.exchange.copy_from_slice(&other.exchange);
        self.owed.copy_from_slice(&other.owed);
        self.contact.step = other.contact.step;
        self.contact.flexible.iter_mut().zip(&other.contact.flexible).for_each(|(own, other)| own.copy_from(other));
        self.contact.bodies.copy_from_slice(&other.contact.bodies);
        let shear = self.shear.iter_mut().flatten().zip(other.shear.iter().flatten());
        self.jump.iter_mut().zip(&other.jump).chain(shear).for_each(|(own, other)| own.copy_from_slice(other));
    }

    /// Return whether `other` has as many bodies with as many stations.
    pub fn have_shape_of(&self, other: &Self) -> bool {
        let owed = |all: &Self| [all.owed.len(), all.contact.flexible.len(), all.contact.bodies.len()];
        let lengths = |all: &Self| ([all.stations.len(), all.loads.len(), all.exchange.len()], owed(all));
        let stresses = |all: &Self| {
            let shear = all.shear.iter().map(|of| of.iter().map(Vec::len).collect::<Vec<_>>());
            (all.jump.iter().map(Vec::len).collect::<Vec<_>>(), shear.collect::<Vec<_>>())
        };
        lengths(self) == lengths(other)
            && stresses(self) == stresses(other)
            && self.stations.iter().zip(&other.stations).all(|(a, b)| a.has_shape_of(b))
            && self.loads.iter().zip(&other.loads).all(|(a, b)| a.has_shape_of(b))
            && self.contact.flexible.iter().zip(&other.contact.flexible).all(|(a, b)| a.has_shape_of(b))
    }
}
