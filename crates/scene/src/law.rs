//! Laws of time.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::{Check, Faults};
use crate::spline::{self, Ends};

/// Samples of a spline in an interval.
const SAMPLES: u32 = 32;

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
    /// `mean + g(t) Σ_k [cosines[k] cos(2 π k f t) + sines[k] sin(2 π k f t)]`, where f is the frequency, k counts from 1,
    /// and g is 1 or a cosine ramp from 0 at t = 0.
    Fourier {
        /// Mean value.
        #[serde(default)]
        mean: f64,
        /// Fundamental frequency, Hz.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        frequency: f64,
        /// Coefficients of the cosines, from the fundamental on.
        #[serde(default)]
        cosines: Vec<f64>,
        /// Coefficients of the sines, from the fundamental on.
        #[serde(default)]
        sines: Vec<f64>,
        /// Length of the ramp of g, s; without a ramp 0.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        ramp: f64,
    },
    /// Spline through points.
    Table(Table),
    /// Sum of several laws.
    Sum(#[schemars(length(min = 1))] Vec<TimeLaw>),
}

/// Cubic spline of class C² through points; constant before the first point and after the last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(from = "Points", into = "Points")]
pub struct Table {
    points: Points,
    /// Slopes at the points; none where the points do not fit together.
    slopes: Vec<f64>,
}

/// Cubic spline of class C² through points. Without `periodic` and `end_slopes` it reproduces cubics: three points give
/// their parabola, two their line. It is constant before the first point and after the last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Table")]
struct Points {
    /// Times of the points, s, increasing; at least two.
    #[schemars(length(min = 2))]
    times: Vec<f64>,
    /// Values at the points.
    #[schemars(length(min = 2))]
    values: Vec<f64>,
    /// Slopes at the first and the last point, per second; absent: those of the cubic through the points at the end.
    #[serde(default)]
    end_slopes: Option<[f64; 2]>,
    /// Whether the points are one period of a law that repeats itself at all times; the last value equals the first.
    #[serde(default)]
    periodic: bool,
}

impl From<Points> for Table {
    fn from(points: Points) -> Self {
        let Points { times, values, end_slopes, periodic } = &points;
        let ends = match end_slopes {
            _ if *periodic => Ends::Periodic,
            Some(slopes) => Ends::Slopes(*slopes),
            None => Ends::NotAKnot,
        };
        let fit = increase(times) && times.len() > 1 && values.len() == times.len();
        let slopes = if fit { spline::slopes(times, values, ends) } else { Vec::new() };
        Self { points, slopes }
    }
}

impl From<Table> for Points {
    fn from(table: Table) -> Self {
        table.points
    }
}

/// Share of a table's span by which a time may miss its ends by rounding.
const ROUNDING: f64 = 1e-9;

/// Return whether `times` increase.
fn increase(times: &[f64]) -> bool {
    times.windows(2).all(|pair| pair[0] < pair[1])
}

impl Table {
    /// Make the spline through `values` at increasing `times`.
    pub fn new(times: Vec<f64>, values: Vec<f64>) -> Self {
        Points { times, values, end_slopes: None, periodic: false }.into()
    }

    /// Return the value and its rate (per second) at time `t` (s).
    fn value_and_rate(&self, t: f64) -> (f64, f64) {
        let Points { times, values, periodic, .. } = &self.points;
        let (first, last) = (times[0], times[times.len() - 1]);
        if *periodic {
            let inside = first + (t - first).rem_euclid(last - first);
            return spline::value_and_rate(times, values, &self.slopes, inside);
        }
        if t < first || t > last {
            let end = if t < first { 0 } else { times.len() - 1 };
            // The times of steps are sums: one that misses an end by rounding still has the rate there.
            let is_end = (t - times[end]).abs() < ROUNDING * (last - first);
            return (values[end], if is_end { self.slopes[end] } else { 0.0 });
        }
        spline::value_and_rate(times, values, &self.slopes, t)
    }

    /// Return the least and the largest of the values.
    pub(crate) fn range(&self) -> [f64; 2] {
        let values = || self.points.values.iter().copied();
        [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
    }

    /// Return the place at which the spline is farthest from the middle of the values: time, s, and value.
    pub(crate) fn farthest(&self) -> (f64, f64) {
        let [low, high] = self.range();
        let off = |value: f64| (value - (low + high) / 2.0).abs();
        let intervals = self.points.times.windows(2);
        let times = intervals.flat_map(|pair| {
            (0..=SAMPLES).map(move |i| pair[0] + (pair[1] - pair[0]) * f64::from(i) / f64::from(SAMPLES))
        });
        let places = times.map(|t| (t, self.value_and_rate(t).0));
        places.reduce(|a, b| if off(b.1) > off(a.1) { b } else { a }).unwrap_or_default()
    }

    /// Return time (s), slope (per second) and interval (s) at both ends; nothing of a periodic table.
    pub(crate) fn ends(&self) -> Vec<(f64, f64, f64)> {
        let (times, last) = (&self.points.times, self.points.times.len() - 1);
        if self.points.periodic {
            return Vec::new();
        }
        vec![
            (times[0], self.slopes[0], times[1] - times[0]),
            (times[last], self.slopes[last], times[last] - times[last - 1]),
        ]
    }

    /// Return the largest magnitudes of the value and the rate.
    fn largest(&self) -> [f64; 2] {
        if self.slopes.is_empty() {
            return [0.0; 2];
        }
        spline::largest(&self.points.times, &self.points.values, &self.slopes)
    }
}

/// Return the values of laws along each axis at time `t` (s), and their rates.
pub(crate) fn values_and_rates(laws: [&TimeLaw; 3], t: f64) -> ([f64; 3], [f64; 3]) {
    let both = laws.map(|law| law.value_and_rate(t));
    (both.map(|(value, _)| value), both.map(|(_, rate)| rate))
}

impl Default for TimeLaw {
    /// Return 0 at all times.
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
            Self::Fourier { mean, frequency, cosines, sines, ramp } => {
                let (share, rise) = if *ramp > 0.0 { cosine_ramp(t, *ramp) } else { (1.0, 0.0) };
                let (mut sum, mut rate) = (0.0, 0.0);
                for (k, [a, b]) in harmonics(cosines, sines) {
                    let omega = 2.0 * PI * frequency * k;
                    let (sin, cos) = (omega * t).sin_cos();
                    sum += a * cos + b * sin;
                    rate += omega * (b * cos - a * sin);
                }
                (mean + share * sum, share * rate + rise * sum)
            }
            Self::Table(table) => table.value_and_rate(t),
            Self::Sum(laws) => laws.iter().fold((0.0, 0.0), |(value, rate), law| {
                let (own, own_rate) = law.value_and_rate(t);
                (value + own, rate + own_rate)
            }),
        }
    }
}

/// Return `(1 − cos(π t / duration)) / 2`, 0 before and 1 after, and its rate.
fn cosine_ramp(t: f64, duration: f64) -> (f64, f64) {
    let phase = PI * (t / duration).clamp(0.0, 1.0);
    (0.5 * (1.0 - phase.cos()), 0.5 * PI / duration * phase.sin())
}

/// Return the number of each harmonic, from 1, with the coefficients of its cosine and its sine.
fn harmonics(cosines: &[f64], sines: &[f64]) -> impl Iterator<Item = (f64, [f64; 2])> {
    let coefficient = |all: &[f64], k: usize| all.get(k).copied().unwrap_or(0.0);
    let count = cosines.len().max(sines.len());
    (0..count).map(move |k| ((k + 1) as f64, [coefficient(cosines, k), coefficient(sines, k)]))
}

impl TimeLaw {
    /// Return a bound of the magnitude; of oscillations the sum of mean and amplitudes.
    pub(crate) fn largest(&self) -> f64 {
        match self {
            Self::Constant(value) | Self::CosineRamp { value, .. } => value.abs(),
            Self::Sine { mean, amplitude, .. } => mean.abs() + amplitude.abs(),
            Self::Fourier { mean, cosines, sines, .. } => {
                mean.abs() + harmonics(cosines, sines).map(|(_, [a, b])| a.hypot(b)).sum::<f64>()
            }
            Self::Table(table) => table.largest()[0],
            Self::Sum(laws) => laws.iter().map(Self::largest).sum(),
        }
    }

    /// Return a bound of the magnitude of the rate, per second; of oscillations without their ramps.
    pub(crate) fn largest_rate(&self) -> f64 {
        match self {
            Self::Constant(_) => 0.0,
            Self::CosineRamp { value, duration } => value.abs() * PI / 2.0 / duration,
            Self::Sine { amplitude, frequency, .. } => amplitude.abs() * 2.0 * PI * frequency,
            Self::Fourier { frequency, cosines, sines, .. } => {
                harmonics(cosines, sines).map(|(k, [a, b])| 2.0 * PI * frequency * k * a.hypot(b)).sum()
            }
            Self::Table(table) => table.largest()[1],
            Self::Sum(laws) => laws.iter().map(Self::largest_rate).sum(),
        }
    }

    /// Return the frequency of the first oscillation, Hz; none where nothing oscillates.
    pub(crate) fn frequency(&self) -> Option<f64> {
        match self {
            Self::Sine { amplitude, frequency, .. } if *amplitude != 0.0 && *frequency != 0.0 => Some(*frequency),
            Self::Fourier { frequency, cosines, sines, .. } => {
                cosines.iter().chain(sines).any(|c| *c != 0.0).then_some(*frequency)
            }
            Self::Table(Table { points, .. }) if points.periodic => {
                Some(1.0 / (points.times[points.times.len() - 1] - points.times[0]))
            }
            Self::Sum(laws) => laws.iter().find_map(Self::frequency),
            _ => None,
        }
    }

    /// Call `see` with this law, or with each of a sum, and its key.
    pub(crate) fn visit(&self, key: &str, see: &mut dyn FnMut(&str, &TimeLaw)) {
        match self {
            Self::Sum(laws) => {
                laws.iter().enumerate().for_each(|(i, law)| law.visit(&format!("{key}.sum[{i}]"), see));
            }
            _ => see(key, self),
        }
    }

    /// Return the highest frequency of a sine or a Fourier series, Hz; none where it has none.
    pub(crate) fn highest_frequency(&self) -> Option<f64> {
        match self {
            Self::Fourier { frequency, cosines, sines, .. } => {
                let highest =
                    [cosines, sines].into_iter().filter_map(|all| all.iter().rposition(|c| *c != 0.0)).max()?;
                Some((highest + 1) as f64 * frequency)
            }
            Self::Sine { .. } => self.frequency(),
            _ => None,
        }
    }

    /// Return the time from which the value stays constant, s, and that value; none of an oscillation.
    pub(crate) fn settles(&self) -> Option<(f64, f64)> {
        match self {
            Self::Constant(value) => Some((0.0, *value)),
            Self::CosineRamp { value, duration } => Some((*duration, *value)),
            Self::Sine { .. } | Self::Fourier { .. } => None,
            Self::Table(Table { points, .. }) if points.periodic => None,
            Self::Table(Table { points, .. }) => Some((*points.times.last()?, *points.values.last()?)),
            Self::Sum(laws) => laws.iter().try_fold((0.0, 0.0), |(time, sum), law| {
                let (settled, value) = law.settles()?;
                Some((f64::max(time, settled), sum + value))
            }),
        }
    }
}

impl TimeLaw {
    /// Return a bound of the magnitude of the second rate, per second squared; of oscillations without their ramps.
    pub(crate) fn largest_acceleration(&self) -> f64 {
        let square = |omega: f64| omega * omega;
        match self {
            Self::Constant(_) => 0.0,
            Self::CosineRamp { value, duration } => value.abs() * square(PI / duration) / 2.0,
            Self::Sine { amplitude, frequency, .. } => amplitude.abs() * square(2.0 * PI * frequency),
            Self::Fourier { frequency, cosines, sines, .. } => {
                harmonics(cosines, sines).map(|(k, [a, b])| square(2.0 * PI * frequency * k) * a.hypot(b)).sum()
            }
            // The second derivative of a spline is linear between its points.
            Self::Table(Table { points, .. }) => {
                let between = points.times.windows(2).flat_map(|pair| {
                    let h = (pair[1] - pair[0]) / f64::from(SAMPLES);
                    let second = |a: f64, b: f64| (self.value_and_rate(b).1 - self.value_and_rate(a).1).abs() / (b - a);
                    [second(pair[0], pair[0] + h), second(pair[1] - h, pair[1] - 1e-9 * h)]
                });
                between.fold(0.0, f64::max)
            }
            Self::Sum(laws) => laws.iter().map(Self::largest_acceleration).sum(),
        }
    }

    /// Return whether rate or second rate jump at the start by more than a `part` of their largest values.
    pub(crate) fn starts_at_once(&self, part: f64) -> bool {
        let (rate, acceleration) = (self.largest_rate(), self.largest_acceleration());
        let begin = match self {
            Self::Table(Table { points, .. }) if !points.periodic => points.times[0].max(0.0),
            _ => 0.0,
        };
        let h = 1e-4 * rate / acceleration;
        let [first, second] = [begin + 1e-3 * h, begin + h].map(|t| self.value_and_rate(t).1);
        first.abs() > part * rate || (second - first).abs() / h > part * acceleration
    }

    /// Return the value that the law keeps in the end, or about which it oscillates.
    pub(crate) fn kept(&self) -> f64 {
        match self {
            Self::Sine { mean, .. } | Self::Fourier { mean, .. } => *mean,
            Self::Table(Table { points, .. }) if points.periodic => {
                let (begin, end) = (points.times[0], points.times[points.times.len() - 1]);
                let count = SAMPLES * points.times.len() as u32;
                let times = (0..count).map(|i| begin + (end - begin) * f64::from(i) / f64::from(count));
                times.map(|t| self.value(t)).sum::<f64>() / f64::from(count)
            }
            Self::Sum(laws) => laws.iter().map(Self::kept).sum(),
            _ => self.settles().map_or(0.0, |(_, value)| value),
        }
    }
}

impl Check for TimeLaw {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        match self {
            Self::Table(table) => table.points.check_at(&format!("{key}.table"), faults),
            Self::Sum(laws) => {
                laws.iter().enumerate().for_each(|(i, law)| law.check_at(&format!("{key}.sum[{i}]"), faults));
            }
            _ => {}
        }
    }
}

impl Check for Points {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        let Self { times, values, end_slopes, periodic } = self;
        faults.require(increase(times), &format!("{key}.times"), format!("{times:?}"), || "times must increase".into());
        let (key, shown) = (&format!("{key}.values"), format!("{values:?}"));
        let ends = [values.first(), values.last()];
        faults.require(values.len() == times.len(), key, &shown, || {
            format!("it must be {} numbers, one for each time", times.len())
        });
        faults.require(!periodic || ends[0] == ends[1], key, &shown, || {
            "the last value of a period must equal the first".into()
        });
        let key = &key.replace(".values", ".end_slopes");
        faults.forbid(*periodic && end_slopes.is_some(), key, || "a periodic table has no ends".into());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn periodic(times: Vec<f64>, values: Vec<f64>) -> TimeLaw {
        TimeLaw::Table(Points { times, values, end_slopes: None, periodic: true }.into())
    }

    fn fourier(ramp: f64) -> TimeLaw {
        TimeLaw::Fourier { mean: 0.2, frequency: 1.3, cosines: vec![0.5, 0.0, -0.1], sines: vec![0.3, 0.7], ramp }
    }

    #[test]
    fn rate_is_the_derivative_of_the_value() {
        let sine = |ramp| TimeLaw::Sine { mean: 0.3, amplitude: 2.0, frequency: 1.5, phase: 0.4, ramp };
        let laws = [
            TimeLaw::CosineRamp { value: 3.0, duration: 0.7 },
            sine(0.0),
            sine(0.8),
            TimeLaw::Table(Table::new(vec![0.0, 0.3, 0.5, 1.0], vec![1.0, 2.0, -1.0, 0.0])),
            periodic(vec![0.0, 0.3, 0.4, 0.6], vec![1.0, 2.0, -1.0, 1.0]),
            fourier(0.0),
            fourier(0.8),
            TimeLaw::Sum(vec![sine(0.8), TimeLaw::CosineRamp { value: 3.0, duration: 0.7 }, fourier(0.0)]),
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

    #[test]
    fn a_table_of_two_points_has_one_rate() {
        let law = TimeLaw::Table(Table::new(vec![-10.0, 100.0], vec![-2.0, 20.0]));
        for t in [-9.0, 0.0, 31.0, 99.0] {
            let (value, rate) = law.value_and_rate(t);
            assert!((value - 0.2 * t).abs() < 1e-12 && (rate - 0.2).abs() < 1e-13, "t = {t}: {value}, {rate}");
        }
        assert_eq!([law.value_and_rate(-11.0), law.value_and_rate(101.0)], [(-2.0, 0.0), (20.0, 0.0)]);
    }

    #[test]
    fn a_table_ends_where_a_step_misses_its_end_by_rounding() {
        let law = TimeLaw::Table(Table::new(vec![0.0, 2.4], vec![0.0, 1.2]));
        for t in [2.4_f64.next_up(), (0.0_f64).next_down()] {
            assert!((law.value_and_rate(t).1 - 0.5).abs() < 1e-15, "t = {t:e}");
        }
        assert_eq!([law.value_and_rate(2.4 + 1e-6), law.value_and_rate(-1e-6)], [(1.2, 0.0), (0.0, 0.0)]);
    }

    #[test]
    fn a_periodic_table_repeats_itself() {
        let law = periodic(vec![0.0, 0.3, 0.4, 0.6], vec![1.0, 2.0, -1.0, 1.0]);
        for t in [0.0, 0.1, 0.35, 0.59] {
            let ((value, rate), (later, later_rate)) = (law.value_and_rate(t), law.value_and_rate(t + 6.0));
            assert!((value - later).abs() < 1e-12 && (rate - later_rate).abs() < 1e-10, "t = {t}");
        }
        assert_eq!(law.frequency(), Some(1.0 / 0.6));
    }

    #[test]
    fn a_fourier_series_of_one_sine_is_that_sine() {
        let (amplitude, phase, frequency) = (0.7, 0.4_f64, 1.5);
        let sine = TimeLaw::Sine { mean: 0.1, amplitude, frequency, phase, ramp: 0.5 };
        let (cosines, sines) = (vec![amplitude * phase.sin()], vec![amplitude * phase.cos()]);
        let series = TimeLaw::Fourier { mean: 0.1, frequency, cosines, sines, ramp: 0.5 };
        for t in [0.0, 0.2, 0.7, 3.1] {
            let ((a, b), (c, d)) = (sine.value_and_rate(t), series.value_and_rate(t));
            assert!((a - c).abs() < 1e-14 && (b - d).abs() < 1e-13, "t = {t}: {a}, {b} against {c}, {d}");
        }
        assert!((sine.largest() - series.largest()).abs() < 1e-15);
        assert!((sine.largest_rate() - series.largest_rate()).abs() < 1e-14);
    }

    #[test]
    fn a_law_is_written_as_it_was_read() {
        for text in [
            r#"{"table":{"times":[0.0,1.0],"values":[0.0,1.0],"end_slopes":[0.0,0.0],"periodic":false}}"#,
            r#"{"sum":[{"constant":1.0},{"sum":[{"constant":2.0}]}]}"#,
        ] {
            let law: TimeLaw = serde_json::from_str(text).unwrap();
            assert_eq!(serde_json::to_string(&law).unwrap(), text);
        }
    }
}
