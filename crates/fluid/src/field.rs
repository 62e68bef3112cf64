//! A field of the flow, and where it is in memory.

use std::ops::{Deref, DerefMut};
use std::sync::atomic::{AtomicUsize, Ordering};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::simd::Real;

/// What one way of the first cache holds, bytes: addresses so far apart share a set. A system gives large arrays at whole
/// pages, which are as large. The local solve goes through eleven fields at once, more than a set has room for, and on a
/// grid that the second cache holds it takes twice as long if all begin in the same.
const WAY: usize = 4096;

/// What a cache fetches at once, bytes.
const LINE: usize = 64;

/// Places in a way where fields begin, one after the other: at least as many as are read together.
const PLACES: usize = 12;

/// Numbers at the points of the grid, `[nx, ny]`; written to a file they are no more than that.
#[derive(Clone, Debug, Default)]
pub struct Field<R> {
    numbers: Vec<R>,
    start: usize,
}

impl<R: Real> Field<R> {
    /// The same number at `n` points. Fields that are made one after the other begin in different sets of the first cache.
    pub fn uniform(value: R, n: usize) -> Self {
        static TURN: AtomicUsize = AtomicUsize::new(0);
        let place = TURN.fetch_add(1, Ordering::Relaxed) % PLACES * (WAY / PLACES / LINE * LINE);
        let mut numbers = vec![value; n + WAY / size_of::<R>()];
        let start = (WAY + place - numbers.as_ptr().addr() % WAY) % WAY / size_of::<R>();
        numbers.truncate(start + n);
        Self { numbers, start }
    }
}

impl<R> Deref for Field<R> {
    type Target = [R];

    fn deref(&self) -> &[R] {
        &self.numbers[self.start..]
    }
}

impl<R> DerefMut for Field<R> {
    fn deref_mut(&mut self) -> &mut [R] {
        &mut self.numbers[self.start..]
    }
}

impl<R: PartialEq> PartialEq for Field<R> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<R: Real> Serialize for Field<R> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (**self).serialize(serializer)
    }
}

impl<'de, R: Real> Deserialize<'de> for Field<R> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Self { numbers: Vec::deserialize(deserializer)?, start: 0 })
    }
}
