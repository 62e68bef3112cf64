//! Quantities along the span of a beam, from root to tip.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::{Check, Faults};

/// A quantity along the span: a number > 0 where it is constant, otherwise a profile.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
#[schemars(inline)]
pub enum Spanwise {
    /// The same value from root to tip.
    Constant(#[schemars(extend("exclusiveMinimum" = 0.0))] f64),
    /// A profile along the span.
    Varying(SpanwiseProfile),
}

/// A quantity as a function of the place s along the span, 0 at the root and 1 at the tip, in the unit of its key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SpanwiseProfile {
    /// `((1 − s) root^(1/power) + s tip^(1/power))^power`: linear, or a power of a linear function. The bending
    /// stiffness of a plate of linear thickness has the power 3.
    Taper {
        /// Value at the root.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        root: f64,
        /// Value at the tip.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        tip: f64,
        /// Power of the linear function.
        #[serde(default = "linear")]
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        power: f64,
    },
    /// Straight lines between points.
    Points {
        /// Places of the points, increasing from 0 at the root to 1 at the tip.
        #[schemars(length(min = 2))]
        s: Vec<f64>,
        /// Values at the points, > 0.
        #[schemars(length(min = 2))]
        values: Vec<f64>,
    },
}

fn linear() -> f64 {
    1.0
}

impl From<f64> for Spanwise {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}

impl Spanwise {
    /// Return whether the quantity has a profile.
    pub fn varies(&self) -> bool {
        matches!(self, Self::Varying(_))
    }

    /// Return the value at the place `s`, 0 at the root and 1 at the tip.
    pub fn at(&self, s: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Varying(SpanwiseProfile::Taper { root, tip, power }) => {
                let [root, tip] = [root, tip].map(|end| end.powf(1.0 / power));
                ((1.0 - s) * root + s * tip).powf(*power)
            }
            Self::Varying(SpanwiseProfile::Points { s: places, values }) => {
                let i = places.partition_point(|&place| place <= s).clamp(1, places.len() - 1);
                let part = ((s - places[i - 1]) / (places[i] - places[i - 1])).clamp(0.0, 1.0);
                (1.0 - part) * values[i - 1] + part * values[i]
            }
        }
    }
}

impl Check for Spanwise {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        let Self::Varying(SpanwiseProfile::Points { s, values }) = self else { return };
        let covers = s.first() == Some(&0.0) && s.last() == Some(&1.0) && s.windows(2).all(|pair| pair[0] < pair[1]);
        faults.require(covers, &format!("{key}.points.s"), format!("{s:?}"), || {
            "the places must increase from 0 at the root to 1 at the tip".into()
        });
        let positive = values.iter().all(|&value| value > 0.0);
        let fits = positive && values.len() == s.len();
        faults.require(fits, &format!("{key}.points.values"), format!("{values:?}"), || {
            format!("it must be {} numbers > 0, one for each place", s.len())
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_have_their_values() {
        let taper = |power| Spanwise::Varying(SpanwiseProfile::Taper { root: 1.0, tip: 0.008, power });
        let table = Spanwise::Varying(SpanwiseProfile::Points { s: vec![0.0, 0.4, 1.0], values: vec![5.0, 3.0, 6.0] });
        for (law, s, expected) in [
            (&Spanwise::from(2.0), 0.3, 2.0),
            (&taper(1.0), 0.25, 0.752),
            (&taper(3.0), 0.5, 0.216),
            (&taper(3.0), 1.0, 0.008),
            (&table, 0.0, 5.0),
            (&table, 0.1, 4.5),
            (&table, 0.4, 3.0),
            (&table, 0.7, 4.5),
            (&table, 1.0, 6.0),
        ] {
            assert!((law.at(s) - expected).abs() < 1e-14, "{law:?} at {s}: {} in place of {expected}", law.at(s));
        }
    }
}
