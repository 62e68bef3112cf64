//! A field of the flow, and its place in memory.

use std::hint::black_box;
use std::ops::{Deref, DerefMut};
use std::sync::atomic::{AtomicUsize, Ordering};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use line_fft::Real;

/// Size of a way of the first cache, bytes: addresses at this distance share a set. A page has the same size, and large
/// arrays begin a page. The local solve reads eleven fields at once, more than a set can hold, and takes twice as long
/// on 325 x 72 points if all begin in the same set.
const CACHE_WAY: usize = 4096;

/// Size of a cache line, bytes.
const CACHE_LINE: usize = 64;

/// Number of places in a way at which fields begin in turn: at least as many as are read together.
const PLACES: usize = 12;

/// Numbers at the points of the grid, `[nx, ny]`. A serialized field is a plain list.
#[derive(Clone, Debug, Default)]
pub struct Field<R> {
    numbers: Vec<R>,
    start: usize,
}

impl<R: Real> Field<R> {
    /// The same number at `n` points. Fields that are made in sequence begin in different sets of the first cache.
    pub fn uniform(value: R, n: usize) -> Self {
        static TURN: AtomicUsize = AtomicUsize::new(0);
        Self::at(TURN.fetch_add(1, Ordering::Relaxed) % PLACES, value, n)
    }

    fn at(place: usize, value: R, n: usize) -> Self {
        let place = place * (CACHE_WAY / PLACES / CACHE_LINE * CACHE_LINE);
        let mut numbers = vec![value; n + CACHE_WAY / size_of::<R>()];
        let start = (CACHE_WAY + place - numbers.as_ptr().addr() % CACHE_WAY) % CACHE_WAY / size_of::<R>();
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

/// Return whether the system gives memory of a size: Rust ends the process if it does not.
pub fn is_available(bytes: usize) -> bool {
    let mut probe = Vec::<u8>::new();
    let found = probe.try_reserve_exact(bytes).is_ok();
    drop(black_box(probe));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fields_begin_apart<R: Real>() {
        let mut begins: Vec<_> = (0..PLACES)
            .map(|place| {
                let field = Field::at(place, R::one(), 1000);
                assert!(field.len() == 1000 && field.iter().all(|number| *number == R::one()), "place {place}");
                field.as_ptr().addr() % CACHE_WAY
            })
            .collect();
        assert!(begins.iter().all(|begin| begin % CACHE_LINE == 0), "{begins:?}");
        begins.sort_unstable();
        assert!(begins.windows(2).all(|pair| pair[1] - pair[0] >= CACHE_LINE), "{begins:?}");
    }

    #[test]
    fn fields_begin_in_different_sets_of_the_first_cache() {
        fields_begin_apart::<f64>();
        fields_begin_apart::<f32>();
    }
}
