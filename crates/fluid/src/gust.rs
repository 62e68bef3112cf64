//! A velocity that a master adds to the stream.

use std::array::from_fn;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::law::Law;

/// Share of a communication step by which a time may miss its end by rounding.
const ROUNDING: f64 = 1e-9;

/// Velocity added to the laws of inflow, sponge and mean flow, m/s: the same for all copies of it and all laws with it.
/// Within a communication step it goes linearly to what was [set](Gust::set) before it, and stays there until the next.
#[derive(Clone, Debug, Default)]
pub struct Gust(Arc<Blown>);

#[derive(Debug, Default)]
struct Blown {
    /// Components at the beginning and at the end of the communication step, m/s.
    from: [Number; 3],
    to: [Number; 3],
    /// Its beginning and its length, s; 0 before the first.
    start: Number,
    length: Number,
}

/// A number that all copies share.
#[derive(Debug, Default)]
struct Number(AtomicU64);

impl Number {
    fn set(&self, value: f64) {
        self.0.store(value.to_bits(), Ordering::Relaxed);
    }

    fn get(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }
}

impl Gust {
    /// Set the components at the end of the coming communication step, m/s.
    pub fn set(&self, velocity: &[f64]) {
        self.0.to.iter().zip(velocity).for_each(|(own, component)| own.set(*component));
    }

    /// Return the components that were set, m/s.
    pub(crate) fn target<const D: usize>(&self) -> [f64; D] {
        from_fn(|axis| self.0.to[axis].get())
    }

    /// Begin a communication step from `t` to `t + h` (s) with the components at its beginning, m/s.
    pub(crate) fn begin(&self, t: f64, h: f64, from: &[f64]) {
        self.0.from.iter().zip(from).for_each(|(own, component)| own.set(*component));
        self.0.start.set(t);
        self.0.length.set(h);
    }

    /// Return a law with the component along an axis added.
    pub fn added_to(&self, law: Law, axis: usize) -> Law {
        let gust = self.clone();
        Law::new(move |t| {
            let (value, rate) = law.value_and_rate(t);
            (value + gust.at(t, axis), rate)
        })
    }

    fn at(&self, t: f64, axis: usize) -> f64 {
        let Blown { from, to, start, length } = &*self.0;
        let (from, to) = (from[axis].get(), to[axis].get());
        let left = start.get() + length.get() - t;
        if left > ROUNDING * length.get() { to - (to - from) * (left / length.get()).min(1.0) } else { to }
    }
}
