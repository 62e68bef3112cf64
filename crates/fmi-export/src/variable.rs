//! One row of the list of variables, the source of XML, value references, access and start values.

use std::marker::PhantomData;
use std::ops::Bound;
use std::slice;

use crate::access::{Access, Bounds, Field, UNBOUNDED, Value, limits};
use crate::version::Version;

/// Variable of the model `M`; [`Real`], [`Integer`], [`Boolean`] and [`Text`] construct it.
pub struct Variable<M> {
    pub(crate) name: String,
    pub(crate) description: String,
    pub(crate) unit: Option<String>,
    pub(crate) display_unit: Option<String>,
    pub(crate) nominal: Option<f64>,
    /// Name and items of the enumeration of an Integer.
    pub(crate) enumeration: Option<(String, Vec<String>)>,
    pub(crate) causality: Causality,
    pub(crate) variability: Variability,
    /// Length of an array; `None` for a scalar.
    pub(crate) array: Option<usize>,
    pub(crate) bounds: Bounds,
    /// Names of the inputs on which an output depends directly; `None` if unknown.
    pub(crate) dependencies: Option<Vec<String>>,
    pub(crate) access: Access<M>,
}

/// Role of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Causality {
    Parameter,
    CalculatedParameter,
    Input,
    Output,
    Local,
    Independent,
}

/// Times at which a variable may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Variability {
    Constant,
    Fixed,
    Tunable,
    Discrete,
    Continuous,
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

    /// Make the variable an array of `n` elements, `name[1]` to `name[n]`, with consecutive value references.
    pub fn array(mut self, n: usize) -> Self {
        self.array = Some(n);
        self
    }

    /// Require values greater than `limit`.
    pub fn above(mut self, limit: impl Into<f64>) -> Self {
        self.bounds.0 = Bound::Excluded(limit.into());
        self
    }

    /// Require values of at least `limit`.
    pub fn at_least(mut self, limit: impl Into<f64>) -> Self {
        self.bounds.0 = Bound::Included(limit.into());
        self
    }

    /// Require values less than `limit`.
    pub fn below(mut self, limit: impl Into<f64>) -> Self {
        self.bounds.1 = Bound::Excluded(limit.into());
        self
    }

    /// Require values of at most `limit`.
    pub fn at_most(mut self, limit: impl Into<f64>) -> Self {
        self.bounds.1 = Bound::Included(limit.into());
        self
    }

    /// Let a parameter be set between steps, too.
    pub fn tunable(mut self) -> Self {
        self.variability = Variability::Tunable;
        self
    }

    /// Restrict an Integer to the named items, numbered from 1; variables with the same `name` here share the type.
    pub fn enumeration(mut self, name: &str, items: &[&str]) -> Self {
        self.enumeration = Some((name.to_string(), items.iter().map(ToString::to_string).collect()));
        self.at_least(1).at_most(items.len() as f64)
    }

    /// Display a Real in another unit of the same dimension, such as `mm` for `m` or `degC` for `K`.
    pub fn display_unit(mut self, unit: &str) -> Self {
        self.display_unit = Some(unit.to_string());
        self
    }

    /// Set the usual magnitude of a Real, in its unit.
    pub fn nominal(mut self, value: f64) -> Self {
        self.nominal = Some(value);
        self
    }

    /// Declare that a Real changes only at communication points.
    pub fn discrete(mut self) -> Self {
        self.variability = Variability::Discrete;
        self
    }

    /// Declare that an output or local follows from the parameters and is constant after initialisation.
    pub fn calculated_parameter(mut self) -> Self {
        (self.causality, self.variability) = (Causality::CalculatedParameter, Variability::Fixed);
        self
    }

    /// Declare that an output or local is constant after loading, such as a number of nodes.
    pub fn constant(mut self) -> Self {
        self.variability = Variability::Constant;
        self
    }

    /// Show an output in the master as a local variable, for display only.
    pub fn local(mut self) -> Self {
        self.causality = Causality::Local;
        self
    }

    /// Name the inputs, scalars or whole arrays, on which an output depends at the same instant.
    ///
    /// An output computed at the end of a step depends on no input: `&[]`. Without this call a master assumes a
    /// dependence on all inputs.
    pub fn depends_on(mut self, inputs: &[&str]) -> Self {
        self.dependencies = Some(inputs.iter().map(ToString::to_string).collect());
        self
    }

    /// Refuse values that are not finite or outside the limits; the first value belongs to `element`.
    pub(crate) fn check<T: Value>(&self, values: &[T], element: usize) -> Result<(), String> {
        if T::are_allowed(values, &self.bounds) {
            return Ok(());
        }
        let mut alone = values.iter().map(slice::from_ref);
        let at = alone.position(|value| !T::are_allowed(value, &self.bounds)).expect("one of them is not allowed");
        let name = self.element_name(element + at);
        Err(format!("{name} = {} must be {}", values[at].shown(), limits::<T>(&self.bounds)))
    }

    /// Refuse values that are not finite; the first value belongs to `element`.
    pub(crate) fn check_finite<T: Value>(&self, values: &[T], element: usize) -> Result<(), String> {
        if T::are_allowed(values, &UNBOUNDED) {
            return Ok(());
        }
        let is_finite = |value| T::are_allowed(slice::from_ref(value), &UNBOUNDED);
        let at = values.iter().position(|value| !is_finite(value)).expect("one of them is not finite");
        Err(format!("{} = {} is not finite", self.element_name(element + at), values[at].shown()))
    }

    /// Return the name of the type in the model description.
    pub(crate) fn type_name(&self, version: Version) -> &'static str {
        match (version, self.access.type_name()) {
            _ if self.enumeration.is_some() => "Enumeration",
            (Version::Fmi3, "Real") => "Float64",
            (Version::Fmi3, "Integer") => "Int32",
            (_, name) => name,
        }
    }

    /// Return the number of value references.
    pub(crate) fn len(&self) -> usize {
        self.array.unwrap_or(1)
    }

    /// Return the name of an element: `x` for a scalar, `x[1]` for the first element of an array.
    pub(crate) fn element_name(&self, element: usize) -> String {
        match self.array {
            None => self.name.clone(),
            Some(_) => format!("{}[{}]", self.name, element + 1),
        }
    }
    /// Whether the standard requires a start value.
    pub(crate) fn has_start(&self) -> bool {
        self.initial() == Some("exact") || self.causality == Causality::Input
    }

    /// Return the attribute `initial`.
    pub(crate) fn initial(&self) -> Option<&'static str> {
        match (self.causality, self.variability) {
            (Causality::Parameter, _) | (_, Variability::Constant) => Some("exact"),
            (Causality::Output | Causality::Local | Causality::CalculatedParameter, _) => Some("calculated"),
            (Causality::Input | Causality::Independent, _) => None,
        }
    }

    /// Refuse a number of values from the model that differs from the declared length.
    pub(crate) fn check_length(&self, length: usize) -> Result<(), String> {
        if length == self.len() {
            return Ok(());
        }
        Err(format!("variable {}: the model returns {length} values, the list declares {}", self.name, self.len()))
    }
}

impl Causality {
    /// Return the name in the model description.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Causality::Parameter => "parameter",
            Causality::CalculatedParameter => "calculatedParameter",
            Causality::Input => "input",
            Causality::Output => "output",
            Causality::Local => "local",
            Causality::Independent => "independent",
        }
    }
}

impl Variability {
    /// Return the name in the model description.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Variability::Constant => "constant",
            Variability::Fixed => "fixed",
            Variability::Tunable => "tunable",
            Variability::Discrete => "discrete",
            Variability::Continuous => "continuous",
        }
    }
}

/// Define a constructor of variables, with `unit` of variables that have one.
macro_rules! constructor {
    (
        $(#[$doc:meta])*
        $name:ident($($unit:ident)?): $access:ident($field:ident, $values:ty), $causality:ident, $variability:ident
    ) => {
        $(#[$doc])*
        pub fn $name(
            name: impl Into<String>,
            $($unit: &str,)?
            description: impl Into<String>,
            values: impl Fn(&mut M) -> $values + Send + Sync + 'static,
        ) -> Variable<M> {
            let access = Access::$access(Field::$field(Box::new(values)));
            let variable = Variable::new(name, description, Causality::$causality, Variability::$variability, access);
            Variable { $(unit: Some($unit.to_string()),)? ..variable }
        }
    };
}

macro_rules! constructors {
    ($(#[$doc:meta])* $name:ident, $access:ident, $type:ty, $variability:ident, $unit:tt) => {
        $(#[$doc])*
        pub struct $name<M>(PhantomData<M>);

        impl<M> $name<M> {
            constructor! {
                /// Return a parameter, fixed after initialisation.
                parameter $unit: $access(Write, &mut [$type]), Parameter, Fixed
            }
            constructor! {
                /// Return an input.
                input $unit: $access(Write, &mut [$type]), Input, $variability
            }
            constructor! {
                /// Return an output.
                output $unit: $access(Read, &[$type]), Output, $variability
            }
            constructor! {
                /// Return a local variable, for display only.
                local $unit: $access(Read, &[$type]), Local, $variability
            }
            constructor! {
                /// Return a scalar output that is computed when it is read.
                computed $unit: $access(Compute, $type), Output, $variability
            }
        }
    };
}

constructors! {
    /// Constructor of Real variables of the model `M`: finite `f64` values with a unit.
    Real, Real, f64, Continuous, (unit)
}
constructors! {
    /// Constructor of Integer variables of the model `M`: `i32` values.
    Integer, Integer, i32, Discrete, ()
}
constructors! {
    /// Constructor of Boolean variables of the model `M`.
    Boolean, Boolean, bool, Discrete, ()
}
constructors! {
    /// Constructor of String variables of the model `M`.
    Text, Text, String, Discrete, ()
}

impl<M> Integer<M> {
    /// Return an output that counts, up to `i32::MAX`.
    pub fn count(
        name: impl Into<String>,
        description: impl Into<String>,
        count: impl Fn(&mut M) -> usize + Send + Sync + 'static,
    ) -> Variable<M> {
        Self::computed(name, description, move |model| i32::try_from(count(model)).unwrap_or(i32::MAX))
    }
}

impl<M> Real<M> {
    /// Return the independent variable `time`, in s, the time of the instance.
    pub fn time() -> Variable<M> {
        let (causality, variability) = (Causality::Independent, Variability::Continuous);
        let variable = Variable::new("time", "Simulation time", causality, variability, Access::Time);
        Variable { unit: Some("s".to_string()), ..variable }
    }
}
