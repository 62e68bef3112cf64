//! One row of the list of variables: what XML, value references, dispatch and start values are made from.

use std::fmt::Debug;
use std::marker::PhantomData;
use std::ops::{Bound, RangeBounds};
use std::slice;

use crate::version::Version;

/// A variable of the model `M`, made by [`Real`], [`Integer`], [`Boolean`] or [`Text`].
pub struct Variable<M> {
    pub(crate) name: String,
    pub(crate) description: String,
    pub(crate) unit: Option<String>,
    pub(crate) display_unit: Option<String>,
    pub(crate) nominal: Option<f64>,
    /// Name and items of the enumeration that an Integer counts.
    pub(crate) enumeration: Option<(String, Vec<String>)>,
    pub(crate) causality: Causality,
    pub(crate) variability: Variability,
    /// Length of an array; `None` is a scalar.
    pub(crate) array: Option<usize>,
    pub(crate) bounds: Bounds,
    /// Names of the inputs that an output depends on directly; `None` is unknown, so all of them.
    pub(crate) dependencies: Option<Vec<String>>,
    pub(crate) access: Access<M>,
}

/// Lower and upper limit.
pub(crate) type Bounds = (Bound<f64>, Bound<f64>);

pub(crate) const UNBOUNDED: Bounds = (Bound::Unbounded, Bound::Unbounded);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Causality {
    Parameter,
    CalculatedParameter,
    Input,
    Output,
    Local,
    Independent,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Variability {
    Constant,
    Fixed,
    Tunable,
    Discrete,
    Continuous,
}

/// How to reach the values of a variable. A scalar is a slice of one.
pub(crate) enum Access<M> {
    /// The glue's own clock.
    Time,
    Real(Field<M, f64>),
    Integer(Field<M, i32>),
    Boolean(Field<M, bool>),
    Text(Field<M, String>),
}

pub(crate) enum Field<M, T> {
    Read(Getter<M, T>),
    Write(GetterMut<M, T>),
}

/// A closure, so that variables of a list of like parts can share one that knows its part.
type Getter<M, T> = Box<dyn Fn(&mut M) -> &[T] + Send + Sync>;
type GetterMut<M, T> = Box<dyn Fn(&mut M) -> &mut [T] + Send + Sync>;

impl<M, T> Field<M, T> {
    pub(crate) fn read<'a>(&self, model: &'a mut M) -> &'a [T] {
        match self {
            Field::Read(get) => get(model),
            Field::Write(get_mut) => get_mut(model),
        }
    }

    /// `None` if the values are read-only.
    pub(crate) fn write<'a>(&self, model: &'a mut M) -> Option<&'a mut [T]> {
        match self {
            Field::Read(_) => None,
            Field::Write(get_mut) => Some(get_mut(model)),
        }
    }
}

impl<M> Access<M> {
    pub(crate) fn type_name(&self) -> &'static str {
        match self {
            Access::Time | Access::Real(_) => "Real",
            Access::Integer(_) => "Integer",
            Access::Boolean(_) => "Boolean",
            Access::Text(_) => "String",
        }
    }
}

/// An FMI type as Rust has it.
pub(crate) trait Value: Debug + Sized + 'static {
    const TYPE: &'static str;

    /// How to reach the values, if they are of this type.
    fn field<M>(access: &Access<M>) -> Option<&Field<M, Self>>;

    /// The clock's value, if it is of this type.
    fn clock(_clock: &[f64; 1]) -> Option<&[Self]> {
        None
    }

    /// A value as messages show it.
    fn shown(&self) -> String {
        format!("{self:?}")
    }

    /// Whether all the values may be set.
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

    fn clock(clock: &[f64; 1]) -> Option<&[Self]> {
        Some(clock)
    }

    fn shown(&self) -> String {
        format!("{self:.3e}")
    }

    fn are_allowed(values: &[Self], bounds: &Bounds) -> bool {
        // Without an early exit the compiler vectorises this loop.
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

/// The limits, as the end of a sentence: `finite and > 0`.
fn limits<T: Value>(bounds: &Bounds) -> String {
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

impl<M> Variable<M> {
    fn new(
        name: impl Into<String>,
        description: impl Into<String>,
        causality: Causality,
        variability: Variability,
        access: Access<M>,
    ) -> Self {
        Variable {
            name: name.into(),
            description: description.into(),
            unit: None,
            display_unit: None,
            nominal: None,
            enumeration: None,
            causality,
            variability,
            array: None,
            bounds: UNBOUNDED,
            dependencies: None,
            access,
        }
    }

    /// Makes it an array of `n` elements, `name[1]` to `name[n]`, with value references in a row.
    pub fn array(mut self, n: usize) -> Self {
        self.array = Some(n);
        self
    }

    /// Every value set must be greater than `limit`.
    pub fn above(mut self, limit: impl Into<f64>) -> Self {
        self.bounds.0 = Bound::Excluded(limit.into());
        self
    }

    /// Every value set must be at least `limit`.
    pub fn at_least(mut self, limit: impl Into<f64>) -> Self {
        self.bounds.0 = Bound::Included(limit.into());
        self
    }

    /// Every value set must be less than `limit`.
    pub fn below(mut self, limit: impl Into<f64>) -> Self {
        self.bounds.1 = Bound::Excluded(limit.into());
        self
    }

    /// Every value set must be at most `limit`.
    pub fn at_most(mut self, limit: impl Into<f64>) -> Self {
        self.bounds.1 = Bound::Included(limit.into());
        self
    }

    /// A parameter that may also be set between steps.
    pub fn tunable(mut self) -> Self {
        self.variability = Variability::Tunable;
        self
    }

    /// An Integer that is one of the named items, counted from 1. Variables of the same name of the type share it.
    pub fn enumeration(mut self, name: &str, items: &[&str]) -> Self {
        self.enumeration = Some((name.to_string(), items.iter().map(ToString::to_string).collect()));
        self.at_least(1).at_most(items.len() as f64)
    }

    /// A Real that is shown in another unit of the same kind, such as `mm` for `m` or `degC` for `K`.
    pub fn display_unit(mut self, unit: &str) -> Self {
        self.display_unit = Some(unit.to_string());
        self
    }

    /// The size that a Real usually has, in its unit.
    pub fn nominal(mut self, value: f64) -> Self {
        self.nominal = Some(value);
        self
    }

    /// A Real that changes only at communication points.
    pub fn discrete(mut self) -> Self {
        self.variability = Variability::Discrete;
        self
    }

    /// An output or local that follows from the parameters when initialisation ends, and does not change any more.
    pub fn calculated_parameter(mut self) -> Self {
        (self.causality, self.variability) = (Causality::CalculatedParameter, Variability::Fixed);
        self
    }

    /// An output or local that never changes after loading, such as a number of nodes.
    pub fn constant(mut self) -> Self {
        self.variability = Variability::Constant;
        self
    }

    /// The inputs (scalars or whole arrays) that this output depends on at the same instant. An output that is
    /// computed only at the end of a step depends on none: `&[]`. Without this call a master must assume all.
    pub fn depends_on(mut self, inputs: &[&str]) -> Self {
        self.dependencies = Some(inputs.iter().map(ToString::to_string).collect());
        self
    }

    /// Refuses values, the first of which belongs to `element`, if one is not finite or outside the limits.
    pub(crate) fn check<T: Value>(&self, values: &[T], element: usize) -> Result<(), String> {
        if T::are_allowed(values, &self.bounds) {
            return Ok(());
        }
        let mut alone = values.iter().map(slice::from_ref);
        let at = alone.position(|value| !T::are_allowed(value, &self.bounds)).expect("one of them is not allowed");
        let name = self.element_name(element + at);
        Err(format!("{name} = {} must be {}", values[at].shown(), limits::<T>(&self.bounds)))
    }

    /// Refuses values to be read, the first of which belongs to `element`, if one is not finite.
    pub(crate) fn check_finite<T: Value>(&self, values: &[T], element: usize) -> Result<(), String> {
        if T::are_allowed(values, &UNBOUNDED) {
            return Ok(());
        }
        let is_finite = |value| T::are_allowed(slice::from_ref(value), &UNBOUNDED);
        let at = values.iter().position(|value| !is_finite(value)).expect("one of them is not finite");
        Err(format!("{} = {} is not finite", self.element_name(element + at), values[at].shown()))
    }

    /// Name of the type in the model description.
    pub(crate) fn type_name(&self, version: Version) -> &'static str {
        match (version, self.access.type_name()) {
            _ if self.enumeration.is_some() => "Enumeration",
            (Version::Fmi3, "Real") => "Float64",
            (Version::Fmi3, "Integer") => "Int32",
            (_, name) => name,
        }
    }

    /// Number of value references.
    pub(crate) fn len(&self) -> usize {
        self.array.unwrap_or(1)
    }

    /// `x` for a scalar, `x[1]` for the first element of an array.
    pub(crate) fn element_name(&self, element: usize) -> String {
        match self.array {
            None => self.name.clone(),
            Some(_) => format!("{}[{}]", self.name, element + 1),
        }
    }
}

/// Makes Real variables of the model `M`: `f64`, with a unit. Every value set must be finite.
pub struct Real<M>(PhantomData<M>);

impl<M> Real<M> {
    fn row(
        name: impl Into<String>,
        unit: &str,
        description: impl Into<String>,
        causality: Causality,
        variability: Variability,
        access: Access<M>,
    ) -> Variable<M> {
        Variable { unit: Some(unit.to_string()), ..Variable::new(name, description, causality, variability, access) }
    }

    /// A parameter, fixed when initialisation ends.
    pub fn parameter(
        name: impl Into<String>,
        unit: &str,
        description: impl Into<String>,
        values: impl Fn(&mut M) -> &mut [f64] + Send + Sync + 'static,
    ) -> Variable<M> {
        let access = Access::Real(Field::Write(Box::new(values)));
        Self::row(name, unit, description, Causality::Parameter, Variability::Fixed, access)
    }

    /// An input.
    pub fn input(
        name: impl Into<String>,
        unit: &str,
        description: impl Into<String>,
        values: impl Fn(&mut M) -> &mut [f64] + Send + Sync + 'static,
    ) -> Variable<M> {
        let access = Access::Real(Field::Write(Box::new(values)));
        Self::row(name, unit, description, Causality::Input, Variability::Continuous, access)
    }

    /// An output.
    pub fn output(
        name: impl Into<String>,
        unit: &str,
        description: impl Into<String>,
        values: impl Fn(&mut M) -> &[f64] + Send + Sync + 'static,
    ) -> Variable<M> {
        let access = Access::Real(Field::Read(Box::new(values)));
        Self::row(name, unit, description, Causality::Output, Variability::Continuous, access)
    }

    /// A value to look at, not to be connected.
    pub fn local(
        name: impl Into<String>,
        unit: &str,
        description: impl Into<String>,
        values: impl Fn(&mut M) -> &[f64] + Send + Sync + 'static,
    ) -> Variable<M> {
        let access = Access::Real(Field::Read(Box::new(values)));
        Self::row(name, unit, description, Causality::Local, Variability::Continuous, access)
    }

    /// The independent variable `time`, in s, which the glue itself keeps.
    pub fn time() -> Variable<M> {
        let (causality, variability) = (Causality::Independent, Variability::Continuous);
        Self::row("time", "s", "Simulation time", causality, variability, Access::Time)
    }
}

macro_rules! unitless {
    ($(#[$doc:meta])* $name:ident, $access:ident, $type:ty) => {
        $(#[$doc])*
        pub struct $name<M>(PhantomData<M>);

        impl<M> $name<M> {
            /// A parameter, fixed when initialisation ends.
            pub fn parameter(
                name: impl Into<String>,
                description: impl Into<String>,
                values: impl Fn(&mut M) -> &mut [$type] + Send + Sync + 'static,
            ) -> Variable<M> {
                let access = Access::$access(Field::Write(Box::new(values)));
                Variable::new(name, description, Causality::Parameter, Variability::Fixed, access)
            }

            /// An input.
            pub fn input(
                name: impl Into<String>,
                description: impl Into<String>,
                values: impl Fn(&mut M) -> &mut [$type] + Send + Sync + 'static,
            ) -> Variable<M> {
                let access = Access::$access(Field::Write(Box::new(values)));
                Variable::new(name, description, Causality::Input, Variability::Discrete, access)
            }

            /// An output.
            pub fn output(
                name: impl Into<String>,
                description: impl Into<String>,
                values: impl Fn(&mut M) -> &[$type] + Send + Sync + 'static,
            ) -> Variable<M> {
                let access = Access::$access(Field::Read(Box::new(values)));
                Variable::new(name, description, Causality::Output, Variability::Discrete, access)
            }

            /// A value to look at, not to be connected.
            pub fn local(
                name: impl Into<String>,
                description: impl Into<String>,
                values: impl Fn(&mut M) -> &[$type] + Send + Sync + 'static,
            ) -> Variable<M> {
                let access = Access::$access(Field::Read(Box::new(values)));
                Variable::new(name, description, Causality::Local, Variability::Discrete, access)
            }
        }
    };
}

unitless!(
    /// Makes Integer variables of the model `M`: `i32`.
    Integer, Integer, i32
);
unitless!(
    /// Makes Boolean variables of the model `M`.
    Boolean, Boolean, bool
);
unitless!(
    /// Makes String variables of the model `M`.
    Text, Text, String
);
