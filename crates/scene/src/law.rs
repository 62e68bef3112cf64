//! Laws of time.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::{Check, Faults};

/// A quantity as a function of time, in the unit of its key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum TimeLaw {
    /// The same value at all times.
    Constant(f64),
    /// `value · (1 − cos(π t / duration)) / 2` up to `duration`, then `value`.
    CosineRamp {
        /// Value after the ramp.
        value: f64,
        /// Length of the ramp, s.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        duration: f64,
    },
    /// `mean + amplitude · g(t) · sin(2 π frequency t + phase)`, where g is 1 or a cosine ramp from 0 at t = 0.
    Sine {
        /// Mean value.
        #[serde(default)]
        mean: f64,
        /// Amplitude.
        amplitude: f64,
        /// Frequency, Hz.
        #[schemars(range(min = 0.0))]
        frequency: f64,
        /// Phase at t = 0, rad.
        #[serde(default)]
        phase: f64,
        /// Length of the ramp of g, s; without a ramp 0.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        ramp: f64,
    },
    /// Cubic Hermite interpolation between points, with slopes by central differences; constant before the first point
    /// and after the last.
    Table {
        /// Times of the points, s, increasing; at least two.
        #[schemars(length(min = 2))]
        times: Vec<f64>,
        /// Values at the points.
        #[schemars(length(min = 2))]
        values: Vec<f64>,
    },
}

impl Default for TimeLaw {
    /// 0 at all times.
    fn default() -> Self {
        Self::Constant(0.0)
    }
}

impl TimeLaw {
    /// Return the value at time `t` (s).
    pub fn value(&self, t: f64) -> f64 {
        self.value_and_rate(t).0
    }

    /// Return the value and its rate (per second) at time `t` (s).
    pub fn value_and_rate(&self, t: f64) -> (f64, f64) {
        match self {
            Self::Constant(value) => (*value, 0.0),
            Self::CosineRamp { value, duration } => {
                let (share, rate) = cosine_ramp(t, *duration);
                (value * share, value * rate)
            }
            Self::Sine { mean, amplitude, frequency, phase, ramp } => {
                let omega = 2.0 * PI * frequency;
                let (sin, cos) = (omega * t + phase).sin_cos();
                let (share, rate) = if *ramp > 0.0 { cosine_ramp(t, *ramp) } else { (1.0, 0.0) };
                (mean + amplitude * share * sin, amplitude * (share * omega * cos + rate * sin))
            }
            Self::Table { times, values } => hermite(times, values, t),
        }
    }
}

/// Return `(1 − cos(π t / duration)) / 2`, 0 before and 1 after, and its rate.
fn cosine_ramp(t: f64, duration: f64) -> (f64, f64) {
    let phase = PI * (t / duration).clamp(0.0, 1.0);
    (0.5 * (1.0 - phase.cos()), 0.5 * PI / duration * phase.sin())
}

/// Return value and rate of piecewise cubic Hermite interpolation. The slope at an inner point is the secant of its two
/// neighbours, at the ends 0.
fn hermite(times: &[f64], values: &[f64], t: f64) -> (f64, f64) {
    let last = times.len() - 1;
    if t <= times[0] {
        return (values[0], 0.0);
    }
    if t >= times[last] {
        return (values[last], 0.0);
    }
    let slope = |i: usize| {
        if i == 0 || i == last { 0.0 } else { (values[i + 1] - values[i - 1]) / (times[i + 1] - times[i - 1]) }
    };
    let i = times.partition_point(|&time| time <= t) - 1;
    let width = times[i + 1] - times[i];
    let s = (t - times[i]) / width;
    let (p0, p1, m0, m1) = (values[i], values[i + 1], width * slope(i), width * slope(i + 1));
    let value = p0 + s * (m0 + s * (3.0 * (p1 - p0) - 2.0 * m0 - m1 + s * (2.0 * (p0 - p1) + m0 + m1)));
    let rate = m0 + s * (2.0 * (3.0 * (p1 - p0) - 2.0 * m0 - m1) + s * 3.0 * (2.0 * (p0 - p1) + m0 + m1));
    (value, rate / width)
}

impl TimeLaw {
    /// Return a bound of the magnitude: the largest value, of a sine the sum of mean and amplitude.
    pub(crate) fn largest(&self) -> f64 {
        match self {
            Self::Constant(value) | Self::CosineRamp { value, .. } => value.abs(),
            Self::Sine { mean, amplitude, .. } => mean.abs() + amplitude.abs(),
            Self::Table { values, .. } => values.iter().fold(0.0, |largest, value| f64::max(largest, value.abs())),
        }
    }

    /// Return the largest magnitude of the rate, per second; of a sine without its ramp, of a table by its secants.
    pub(crate) fn largest_rate(&self) -> f64 {
        match self {
            Self::Constant(_) => 0.0,
            Self::CosineRamp { value, duration } => value.abs() * PI / 2.0 / duration,
            Self::Sine { amplitude, frequency, .. } => amplitude.abs() * 2.0 * PI * frequency,
            Self::Table { times, values } => {
                let secants =
                    times.windows(2).zip(values.windows(2)).map(|(t, v)| ((v[1] - v[0]) / (t[1] - t[0])).abs());
                secants.fold(0.0, f64::max)
            }
        }
    }

    /// Return the frequency of a sine, Hz; none where nothing oscillates.
    pub(crate) fn frequency(&self) -> Option<f64> {
        match self {
            Self::Sine { amplitude, frequency, .. } if *amplitude != 0.0 && *frequency != 0.0 => Some(*frequency),
            _ => None,
        }
    }

    /// Return the time from which the value stays constant, s, and that value; only of a constant and a ramp.
    pub(crate) fn settles(&self) -> Option<(f64, f64)> {
        match self {
            Self::Constant(value) => Some((0.0, *value)),
            Self::CosineRamp { value, duration } => Some((*duration, *value)),
            _ => None,
        }
    }
}

impl Check for TimeLaw {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        let Self::Table { times, values } = self else { return };
        let increasing = times.windows(2).all(|pair| pair[0] < pair[1]);
        faults
            .require(increasing, &format!("{key}.table.times"), format!("{times:?}"), || "times must increase".into());
        faults.require(values.len() == times.len(), &format!("{key}.table.values"), format!("{values:?}"), || {
            format!("it must be {} numbers, one for each time", times.len())
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rate_is_the_derivative_of_the_value() {
        let sine = |ramp| TimeLaw::Sine { mean: 0.3, amplitude: 2.0, frequency: 1.5, phase: 0.4, ramp };
        let laws = [
            TimeLaw::CosineRamp { value: 3.0, duration: 0.7 },
            sine(0.0),
            sine(0.8),
            TimeLaw::Table { times: vec![0.0, 0.3, 0.5, 1.0], values: vec![1.0, 2.0, -1.0, 0.0] },
        ];
        let step = 1e-5;
        for law in laws {
            for t in [0.05, 0.2, 0.45, 0.77, 1.3] {
                let (_, rate) = law.value_and_rate(t);
                let difference = (law.value(t + step) - law.value(t - step)) / (2.0 * step);
                assert!((rate - difference).abs() < 1e-7 * (1.0 + rate.abs()), "{law:?} at {t}: {rate}, {difference}");
            }
        }
    }

    #[test]
    fn ramped_sine_starts_smoothly() {
        let law = TimeLaw::Sine { mean: 0.0, amplitude: 2.0, frequency: 1.5, phase: 0.4, ramp: 0.5 };
        assert_eq!(law.value_and_rate(0.0), (0.0, 0.0));
    }
}
