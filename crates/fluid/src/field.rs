//! A field of the flow, and where it is in memory.

use std::ops::{Deref, DerefMut};
use std::sync::atomic::{AtomicUsize, Ordering};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use line_fft::Real;

/// What one way of the first cache holds, bytes: addresses so far apart share a set. A page is as large, and large arrays
/// begin a page. The local solve goes through eleven fields at once, more than a set has room for, and takes twice as long
/// on 325 x 72 points if all begin in the same.
const WAY: usize = 4096;

/// What a cache fetches at once, bytes.
const LINE: usize = 64;

/// Places in a way where fields begin, one after the other: at least as many as are read together.
const PLACES: usize = 12;

/// Numbers at the points of the grid, `[nx, ny]`. In a state they are a list like any other.
#[derive(Clone, Debug, Default)]
pub struct Field<R> {
    numbers: Vec<R>,
    start: usize,
}

impl<R: Real> Field<R> {
    /// The same number at `n` points. Fields that are made one after the other begin in different sets of the first cache.
    pub fn uniform(value: R, n: usize) -> Self {
        static TURN: AtomicUsize = AtomicUsize::new(0);
        Self::at(TURN.fetch_add(1, Ordering::Relaxed) % PLACES, value, n)
    }

    fn at(place: usize, value: R, n: usize) -> Self {
        let place = place * (WAY / PLACES / LINE * LINE);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn fields_begin_apart<R: Real>() {
        let mut begins: Vec<_> = (0..PLACES)
            .map(|place| {
                let field = Field::at(place, R::one(), 1000);
                assert!(field.len() == 1000 && field.iter().all(|number| *number == R::one()), "place {place}");
                field.as_ptr().addr() % WAY
            })
            .collect();
        assert!(begins.iter().all(|begin| begin % LINE == 0), "{begins:?}");
        begins.sort_unstable();
        assert!(begins.windows(2).all(|pair| pair[1] - pair[0] >= LINE), "{begins:?}");
    }

    #[test]
    fn fields_begin_in_different_sets_of_the_first_cache() {
        fields_begin_apart::<f64>();
        fields_begin_apart::<f32>();
    }
}
