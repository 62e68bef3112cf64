//! A velocity that a master adds to the stream.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::law::Law;

/// Velocity added to the laws of inflow, sponge and mean flow, m/s: the same for all copies of it and all laws with it.
/// It holds from one [`Gust::set`] to the next.
#[derive(Clone, Debug, Default)]
pub struct Gust(Arc<[AtomicU64; 3]>);

impl Gust {
    /// Set the components, m/s.
    pub fn set(&self, velocity: &[f64]) {
        for (own, component) in self.0.iter().zip(velocity) {
            own.store(component.to_bits(), Ordering::Relaxed);
        }
    }

    /// Return a law with the component along an axis added.
    pub fn added_to(&self, law: Law, axis: usize) -> Law {
        let gust = self.clone();
        Law::new(move |t| {
            let (value, rate) = law.value_and_rate(t);
            (value + f64::from_bits(gust.0[axis].load(Ordering::Relaxed)), rate)
        })
    }
}
