//! Contact as all that couples rods and wings.

use rigid::Kinematics;
use serde::{Deserialize, Serialize};
use serde_big_array::BigArray;

use crate::flexible::{FastMeeting, FlexibleBody, FlexibleContact};
use crate::law::Law;
use crate::stations::{Loads, Stations};

/// Rods and wings that nothing couples but their contact, which announces their loads as a fluid does.
pub struct ContactCoupling<const D: usize>
where
    [f64; D]: Kinematics<D>,
{
    /// None where no two touch.
    contact: Option<FlexibleContact<D>>,
    /// Stations at the end of the step, set from outside.
    pub target: Vec<Stations<D>>,
    present: CouplingState<D>,
    /// The state before the last step.
    before: CouplingState<D>,
    /// Loads of the coming step.
    loads: Vec<Loads<D>>,
}

/// State of a [`ContactCoupling`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CouplingState<const D: usize> {
    /// Length of the last step, s, for which the coming one is announced.
    step: f64,
    stations: Vec<Stations<D>>,
    /// Impulses that the next steps make up for, N s.
    owed: Vec<Loads<D>>,
    exchange: Vec<ContactExchange<D>>,
}

/// What contact exerted on a flexible body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactExchange<const D: usize> {
    /// Sum of the forces in the last step, N.
    #[serde(with = "BigArray")]
    pub force: [f64; D],
    /// Power at its end, W.
    pub power: f64,
    /// Work since the start, J: the sum of power times step.
    pub work: f64,
}

/// Reason why contact cannot couple.
#[derive(Clone, Copy, Debug, thiserror::Error)]
pub enum CouplingError {
    /// A station that is nowhere.
    #[error("station {station} of {body} of the rods and wings has a place or a velocity that is no finite number")]
    Station {
        /// Its number, from 1.
        station: usize,
        /// Number of its body among the rods, then the wings, from 1.
        body: usize,
    },
    /// A step after which no numbers would be left.
    #[error("places, velocities or the step are so large that what contact exerts is no finite number")]
    Large,
    /// A state of other parts.
    #[error("it is the state of the contact of other rods and wings")]
    State,
}

impl<const D: usize> CouplingState<D> {
    /// Return whether what contact exerted and owes is finite.
    fn is_finite(&self) -> bool {
        let numbers = |own: &ContactExchange<D>| own.force.iter().chain([&own.power, &own.work]).all(|x| x.is_finite());
        self.exchange.iter().all(numbers) && self.owed.iter().all(Loads::are_finite)
    }

    /// Become the state of the same bodies.
    fn copy_from(&mut self, other: &Self) {
        self.step = other.step;
        Stations::copy_all(&mut self.stations, &other.stations);
        self.owed.iter_mut().zip(&other.owed).for_each(|(own, other)| own.copy_from(other));
        self.exchange.copy_from_slice(&other.exchange);
    }
}

impl<const D: usize> ContactCoupling<D>
where
    [f64; D]: Kinematics<D>,
{
    /// Return the contact of flexible bodies at rest for a coming step of `dt` seconds; `law` as in
    /// [`FlexibleContact::new`].
    pub fn new(bodies: &[FlexibleBody<D>], law: &Law, dt: f64) -> Self {
        let target: Vec<_> = bodies.iter().map(|body| Stations::at_rest(body.nodes)).collect();
        let none: Vec<_> = bodies.iter().map(|body| Loads::none(body.nodes.len())).collect();
        let exchange = vec![ContactExchange { force: [0.0; D], power: 0.0, work: 0.0 }; bodies.len()];
        let contact = FlexibleContact::new(bodies, vec![], law, [f64::INFINITY; D]);
        let present = CouplingState { step: dt, stations: target.clone(), owed: none.clone(), exchange };
        let mut made = Self { contact, target, before: present.clone(), present, loads: none };
        made.announce();
        made
    }

    /// Begin at the stations that are set.
    ///
    /// # Errors
    /// [`CouplingError::Station`].
    pub fn start(&mut self) -> Result<(), CouplingError> {
        self.check(&self.target)?;
        Stations::copy_all(&mut self.present.stations, &self.target);
        self.announce();
        Ok(())
    }

    /// Make a step of `h` seconds to the stations that are set.
    ///
    /// # Errors
    /// [`CouplingError::Station`] and [`CouplingError::Large`]; then nothing has changed.
    pub fn advance(&mut self, h: f64) -> Result<(), CouplingError> {
        self.check(&self.target)?;
        self.before.copy_from(&self.present);
        let Self { contact, target, present: CouplingState { step, stations, owed, exchange }, loads, .. } = self;
        for (((own, before), now), to) in loads.iter().zip(&*stations).zip(&*target).zip(exchange) {
            to.force = own.force_in_step(before, now);
            to.power = own.power(before, now);
            to.work += h * to.power;
        }
        // A step of another length pays another part.
        let unpaid = 1.0 - h / *step;
        owed.iter_mut().flat_map(|own| &mut own.force).flatten().for_each(|impulse| *impulse *= unpaid);
        if let Some(contact) = contact {
            contact.add_owed_impulses(h, [stations, target], |_, _, change| change, |_| [0.0; 6], (owed, &mut []));
        }
        *step = h;
        Stations::copy_all(stations, target);
        self.announce();
        if self.present.is_finite() && self.loads.iter().all(Loads::are_finite) {
            return Ok(());
        }
        self.present.copy_from(&self.before);
        self.announce();
        Err(CouplingError::Large)
    }

    /// Announce the loads of the coming step.
    fn announce(&mut self) {
        let Self { contact: Some(contact), present: CouplingState { step, stations, owed, .. }, loads, .. } = self
        else {
            return;
        };
        contact.find(stations, |_| None, *step);
        contact.pay(*step, owed, &[]);
        loads.iter_mut().zip(contact.loads()).for_each(|(own, found)| own.copy_from(found));
    }

    fn check(&self, stations: &[Stations<D>]) -> Result<(), CouplingError> {
        for (k, own) in stations.iter().enumerate() {
            let lists = || own.position.iter().chain(&own.velocity);
            if let Some(at) = (0..own.len()).find(|i| !lists().all(|list| list[*i].is_finite())) {
                return Err(CouplingError::Station { station: at + 1, body: k + 1 });
            }
        }
        Ok(())
    }

    /// Return the loads of the coming step.
    pub fn loads(&self) -> &[Loads<D>] {
        &self.loads
    }

    /// Return what contact exerted in the last step.
    pub fn exchange(&self) -> &[ContactExchange<D>] {
        &self.present.exchange
    }

    /// Return the energy of the contact between the present stations, J.
    pub fn energy(&self) -> f64 {
        self.contact.as_ref().map_or(0.0, FlexibleContact::energy)
    }

    /// Return who met faster than contact surely stops, each pair once.
    pub fn fast(&self) -> &[FastMeeting] {
        self.contact.as_ref().map_or(&[], FlexibleContact::fast)
    }

    /// Return everything that the next step depends on.
    pub fn state(&self) -> &CouplingState<D> {
        &self.present
    }

    /// Go to a state.
    ///
    /// # Errors
    /// [`CouplingError::State`] of other bodies, and [`CouplingError::Station`]; then nothing has changed.
    pub fn restore(&mut self, state: &CouplingState<D>) -> Result<(), CouplingError> {
        let own = &self.present;
        let fit = state.stations.len() == own.stations.len()
            && state.owed.len() == own.owed.len()
            && state.exchange.len() == own.exchange.len()
            && state.stations.iter().zip(&own.stations).all(|(other, own)| own.has_shape_of(other))
            && state.step.is_finite()
            && state.step > 0.0
            && state.owed.iter().zip(&own.owed).all(|(other, own)| own.has_shape_of(other))
            && state.is_finite();
        if !fit {
            return Err(CouplingError::State);
        }
        self.check(&state.stations)?;
        self.present.clone_from(state);
        Stations::copy_all(&mut self.target, &state.stations);
        self.announce();
        Ok(())
    }
}
