//! Access to the values of a variable, and the types of values.

use std::fmt::Debug;
use std::ops::{Bound, RangeBounds};

/// Lower and upper limit of a value.
pub(crate) type Bounds = (Bound<f64>, Bound<f64>);

/// No limits.
pub(crate) const UNBOUNDED: Bounds = (Bound::Unbounded, Bound::Unbounded);

/// Access to the values of a variable; a scalar is a slice of one value.
pub(crate) enum Access<M> {
    /// Time of the instance.
    Time,
    Real(Field<M, f64>),
    Integer(Field<M, i32>),
    Boolean(Field<M, bool>),
    Text(Field<M, String>),
}

/// Access to values of one type in a model.
pub(crate) enum Field<M, T> {
    Read(Getter<M, T>),
    Write(GetterMut<M, T>),
    /// Scalar that is computed when it is read.
    Compute(Computation<M, T>),
}

/// Closure that returns values of a model.
type Getter<M, T> = Box<dyn Fn(&mut M) -> &[T] + Send + Sync>;
/// Closure that returns values of a model for writing.
type GetterMut<M, T> = Box<dyn Fn(&mut M) -> &mut [T] + Send + Sync>;
/// Closure that computes a value of a model.
type Computation<M, T> = Box<dyn Fn(&mut M) -> T + Send + Sync>;

impl<M, T> Field<M, T> {
    /// Pass the values to `take`.
    pub(crate) fn read<R>(&self, model: &mut M, take: impl FnOnce(&[T]) -> R) -> R {
        match self {
            Field::Read(get) => take(get(model)),
            Field::Write(get_mut) => take(get_mut(model)),
            Field::Compute(compute) => take(&[compute(model)]),
        }
    }

    /// Return the values for writing; `None` if they are read-only.
    pub(crate) fn write<'a>(&self, model: &'a mut M) -> Option<&'a mut [T]> {
        match self {
            Field::Write(get_mut) => Some(get_mut(model)),
            Field::Read(_) | Field::Compute(_) => None,
        }
    }
}

impl<M> Access<M> {
    /// Return the name of the type in FMI 2.0.
    pub(crate) fn type_name(&self) -> &'static str {
        match self {
            Access::Time | Access::Real(_) => "Real",
            Access::Integer(_) => "Integer",
            Access::Boolean(_) => "Boolean",
            Access::Text(_) => "String",
        }
    }
}

/// Rust type of an FMI variable.
pub(crate) trait Value: Debug + Sized + 'static {
    /// Name of the type in FMI 2.0.
    const TYPE: &'static str;

    /// Return the access to values of this type.
    fn field<M>(access: &Access<M>) -> Option<&Field<M, Self>>;

    /// Return the time, if it is of this type.
    fn time(_time: &[f64; 1]) -> Option<&[Self]> {
        None
    }

    /// Return the value as text for messages.
    fn shown(&self) -> String {
        format!("{self:?}")
    }

    /// Whether all values are finite and within the limits.
    fn are_allowed(_values: &[Self], _bounds: &Bounds) -> bool {
        true
    }
}

impl Value for f64 {
    const TYPE: &'static str = "Real";

    fn field<M>(access: &Access<M>) -> Option<&Field<M, Self>> {
        match access {
            Access::Real(field) => Some(field),
            _ => None,
        }
    }

    fn time(time: &[f64; 1]) -> Option<&[Self]> {
        Some(time)
    }

    fn shown(&self) -> String {
        format!("{self:.3e}")
    }

    fn are_allowed(values: &[Self], bounds: &Bounds) -> bool {
        // The compiler vectorises a loop without an early exit.
        values.iter().fold(true, |all, value| all & value.is_finite())
            && (*bounds == UNBOUNDED || values.iter().all(|value| bounds.contains(value)))
    }
}

impl Value for i32 {
    const TYPE: &'static str = "Integer";

    fn field<M>(access: &Access<M>) -> Option<&Field<M, Self>> {
        match access {
            Access::Integer(field) => Some(field),
            _ => None,
        }
    }

    fn are_allowed(values: &[Self], bounds: &Bounds) -> bool {
        values.iter().all(|value| bounds.contains(&f64::from(*value)))
    }
}

impl Value for bool {
    const TYPE: &'static str = "Boolean";

    fn field<M>(access: &Access<M>) -> Option<&Field<M, Self>> {
        match access {
            Access::Boolean(field) => Some(field),
            _ => None,
        }
    }
}

impl Value for String {
    const TYPE: &'static str = "String";

    fn field<M>(access: &Access<M>) -> Option<&Field<M, Self>> {
        match access {
            Access::Text(field) => Some(field),
            _ => None,
        }
    }
}

/// Return the limits as the end of a sentence: `finite and > 0`.
pub(crate) fn limits<T: Value>(bounds: &Bounds) -> String {
    let lower = match bounds.0 {
        Bound::Included(limit) => Some(format!(">= {limit}")),
        Bound::Excluded(limit) => Some(format!("> {limit}")),
        Bound::Unbounded => None,
    };
    let upper = match bounds.1 {
        Bound::Included(limit) => Some(format!("<= {limit}")),
        Bound::Excluded(limit) => Some(format!("< {limit}")),
        Bound::Unbounded => None,
    };
    let finite = (T::TYPE == f64::TYPE).then(|| "finite".to_string());
    let limits: Vec<_> = [finite, lower, upper].into_iter().flatten().collect();
    limits.join(" and ")
}
