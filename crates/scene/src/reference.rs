//! Published values that a scene is compared with.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::SceneError;
use crate::check::{Check, require};

/// Published values that a run of the scene is compared with; the units do not read them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// Where the values come from: author, year, and table or page.
    #[schemars(regex(pattern = NOT_EMPTY))]
    pub source: String,
    /// Values by the name of the recorded series: `tip_ux`, `tip_uy`, `tip_uz`, `drag`, `lift`.
    #[serde(default)]
    pub quantities: BTreeMap<String, PublishedQuantity>,
    /// PublishedCoefficients of one still cylinder in an inflow; absent for other scenes.
    #[serde(default)]
    pub coefficients: Option<PublishedCoefficients>,
    /// What several sources span; absent where there is one.
    #[serde(default)]
    pub spread: Option<PublishedSpread>,
}

/// Published values of one series over whole periods of its final state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedQuantity {
    /// Unit of `mean` and `amplitude`: that of the series, e.g. `m` or `N/m`.
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

/// Published coefficients of one still cylinder in an inflow (Schäfer & Turek 1996): cD and cL are 2 F/(ρ Ū² D), St is f D/Ū.
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
    /// Largest less smallest lift coefficient.
    #[serde(default)]
    pub cl_peak_to_peak: Option<f64>,
    /// Strouhal number.
    #[serde(default)]
    pub st: Option<f64>,
    /// Pressure at the front of the cylinder less that at its back, Pa.
    #[serde(default)]
    pub dp_mean: Option<f64>,
}

/// What several sources span.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedSpread {
    /// Where the values come from.
    #[schemars(regex(pattern = NOT_EMPTY))]
    pub source: String,
    /// Ranges by the name of the recorded series, as in `reference.quantities`.
    pub quantities: BTreeMap<String, PublishedRange>,
}

/// Smallest and largest published value of one series.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedRange {
    /// Unit of `mean` and `amplitude`: that of the series.
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
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        named(&format!("{key}.source"), &self.source)?;
        for (name, quantity) in &self.quantities {
            quantity.check_at(&format!("{key}.quantities.{name}"))?;
        }
        self.spread.check_at(&format!("{key}.spread"))
    }
}

impl Check for PublishedQuantity {
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        named(&format!("{key}.unit"), &self.unit)
    }
}

impl Check for PublishedSpread {
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        named(&format!("{key}.source"), &self.source)?;
        for (name, range) in &self.quantities {
            let key = format!("{key}.quantities.{name}");
            named(&format!("{key}.unit"), &range.unit)?;
            for (what, range) in
                [("mean", range.mean), ("amplitude", range.amplitude), ("frequency_hz", range.frequency_hz)]
            {
                let Some([low, high]) = range else { continue };
                require(low <= high, &format!("{key}.{what}"), format!("[{low}, {high}]"), || {
                    "it must be two numbers, the smaller first".into()
                })?;
            }
        }
        Ok(())
    }
}

/// What a text that says something has.
const NOT_EMPTY: &str = "\\S";

/// A text that says something.
fn named(key: &str, text: &str) -> Result<(), SceneError> {
    require(!text.trim().is_empty(), key, format!("{text:?}"), || "it must not be empty".into())
}

#[cfg(test)]
mod tests {
    use crate::Scene;

    /// CSM1 with some of its text replaced.
    fn csm1(old: &str, new: &str) -> String {
        let text = include_str!("../../../scenes/csm1.json");
        assert!(text.contains(old), "{old} is not in the scene");
        Scene::from_json(&text.replace(old, new)).map_or_else(|error| error.to_string(), |_| "accepted".into())
    }

    #[test]
    fn reference_needs_source_and_units() {
        let unit = r#""tip_ux": { "unit": "m","#;
        for (old, new, expected) in [
            ("Turek & Hron 2006, CSM1", " ", "`reference.source` is \" \", but it must not be empty"),
            (unit, r#""tip_ux": {"#, "`reference.quantities.tip_ux.unit` is missing, but it must be a text"),
            (
                unit,
                r#""tip_ux": { "unit": "","#,
                "`reference.quantities.tip_ux.unit` is \"\", but it must not be empty",
            ),
            (
                unit,
                r#""tip_ux": { "unit": "m", "frequency_hz": 0.0,"#,
                "`reference.quantities.tip_ux.frequency_hz` is 0",
            ),
            (unit, r#""tip_ux": { "unit": "m", "frequency_hz": null,"#, "accepted"),
        ] {
            let found = csm1(old, new);
            assert!(found.contains(expected), "{found}, but expected {expected}");
        }
    }

    #[test]
    fn ranges_of_the_spread_begin_with_the_smaller_value() {
        let spread = |range: &str| {
            let quantities = format!(r#"{{ "tip_ux": {{ "unit": "m", "mean": {range} }} }}"#);
            csm1(
                r#""quantities""#,
                &format!(r#""spread": {{ "source": "x", "quantities": {quantities} }}, "quantities""#),
            )
        };
        assert_eq!(spread("[-2.0, -1.0]"), "accepted");
        let refused = spread("[-1.0, -2.0]");
        assert!(refused.contains("`reference.spread.quantities.tip_ux.mean` is [-1, -2]"), "{refused}");
    }
}
