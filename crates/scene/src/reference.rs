//! Published values for comparison.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::{Check, Faults};

/// Published values for comparison with a run; the units do not read them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// Source of the values: author, year, and table or page.
    #[schemars(regex(pattern = NOT_EMPTY))]
    pub source: String,
    /// Values by the name of the recorded series: `tip_ux`, `tip_uy`, `tip_uz`, `drag`, `lift`; of a body on springs
    /// `body_1_y`.
    #[serde(default)]
    pub quantities: BTreeMap<String, PublishedQuantity>,
    /// Published coefficients of one still cylinder in an inflow; absent for other scenes.
    #[serde(default)]
    pub coefficients: Option<PublishedCoefficients>,
    /// Range of several sources; absent where there is one.
    #[serde(default)]
    pub spread: Option<PublishedSpread>,
}

/// Published values of one series over whole periods of its final state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedQuantity {
    /// Unit of `mean` and `amplitude`, the same as of the series: `m`, of a force `N/m`.
    #[schemars(regex(pattern = NOT_EMPTY))]
    pub unit: String,
    /// Half the sum of the largest and the smallest value, in `unit`.
    #[serde(default)]
    pub mean: Option<f64>,
    /// Half the difference of the largest and the smallest value, in `unit`; 0 for a steady state.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub amplitude: Option<f64>,
    /// Frequency, Hz.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub frequency_hz: Option<f64>,
}

/// Published coefficients of one still cylinder in an inflow (Schäfer & Turek 1996): cD and cL are 2 F/(ρ Ū² D), St is
/// f D/Ū.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedCoefficients {
    /// Largest drag coefficient.
    #[serde(default)]
    pub cd_max: Option<f64>,
    /// Smallest drag coefficient.
    #[serde(default)]
    pub cd_min: Option<f64>,
    /// Half the sum of largest and smallest drag coefficient.
    #[serde(default)]
    pub cd_mean: Option<f64>,
    /// Largest lift coefficient.
    #[serde(default)]
    pub cl_max: Option<f64>,
    /// Smallest lift coefficient.
    #[serde(default)]
    pub cl_min: Option<f64>,
    /// Half the sum of largest and smallest lift coefficient.
    #[serde(default)]
    pub cl_mean: Option<f64>,
    /// Difference of largest and smallest lift coefficient.
    #[serde(default)]
    pub cl_peak_to_peak: Option<f64>,
    /// Strouhal number.
    #[serde(default)]
    pub st: Option<f64>,
    /// Pressure difference between front and back of the cylinder, Pa.
    #[serde(default)]
    pub dp_mean: Option<f64>,
}

/// Range of several sources.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedSpread {
    /// Sources of the values.
    #[schemars(regex(pattern = NOT_EMPTY))]
    pub source: String,
    /// Ranges by the name of the recorded series, as in `reference.quantities`.
    pub quantities: BTreeMap<String, PublishedRange>,
}

/// Smallest and largest published value of one series.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedRange {
    /// Unit of `mean` and `amplitude`, the same as of the series.
    #[schemars(regex(pattern = NOT_EMPTY))]
    pub unit: String,
    /// Range of the mean, in `unit`.
    #[serde(default)]
    pub mean: Option<[f64; 2]>,
    /// Range of the amplitude, in `unit`.
    #[serde(default)]
    pub amplitude: Option<[f64; 2]>,
    /// Range of the frequency, Hz.
    #[serde(default)]
    pub frequency_hz: Option<[f64; 2]>,
}

impl Check for Reference {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        require_text(&format!("{key}.source"), &self.source, faults);
        for (name, quantity) in &self.quantities {
            require_text(&format!("{key}.quantities.{name}.unit"), &quantity.unit, faults);
        }
        self.spread.check_at(&format!("{key}.spread"), faults);
    }
}

impl Check for PublishedSpread {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        require_text(&format!("{key}.source"), &self.source, faults);
        for (name, PublishedRange { unit, mean, amplitude, frequency_hz }) in &self.quantities {
            let key = format!("{key}.quantities.{name}");
            require_text(&format!("{key}.unit"), unit, faults);
            for (what, range) in [("mean", mean), ("amplitude", amplitude), ("frequency_hz", frequency_hz)] {
                let Some([low, high]) = range else { continue };
                faults.require(low <= high, &format!("{key}.{what}"), format!("[{low}, {high}]"), || {
                    "the first number must be the smaller".into()
                });
            }
        }
    }
}

/// Pattern of a text with at least one letter.
const NOT_EMPTY: &str = "\\S";

fn require_text(key: &str, text: &str, faults: &mut Faults) {
    faults.require(!text.trim().is_empty(), key, format!("{text:?}"), || "it must not be empty".into());
}
