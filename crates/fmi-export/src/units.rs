//! Units by name: `kg/(m.s)`, `m2/s`, `N.s/m2`, `s-1`, `W/(m.K)`.
//!
//! A unit is a product of symbols with exponents, and at most one `/` with a symbol or a product in parentheses. The
//! symbols are the SI base units and coherent derived units, and g, L, min, h, d, deg, bar and degC. Prefixes reach
//! from nano to giga (`mm`, `kPa`, `MHz`). `degC` has an offset and stands alone.

/// Unit in base units: value in base units = factor · value + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BaseUnit {
    /// Powers of kg, m, s, A, K, mol, cd and rad; FMI treats the radian as a base unit.
    pub powers: [i32; 8],
    pub factor: f64,
    pub offset: f64,
}

/// Names of the base units in the model description.
pub(crate) const NAMES: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

/// Symbols with prefixes, with their powers and factors.
const PREFIXED: &[(&str, [i32; 8], f64)] = &[
    ("g", [1, 0, 0, 0, 0, 0, 0, 0], 1e-3),
    ("m", [0, 1, 0, 0, 0, 0, 0, 0], 1.0),
    ("s", [0, 0, 1, 0, 0, 0, 0, 0], 1.0),
    ("A", [0, 0, 0, 1, 0, 0, 0, 0], 1.0),
    ("K", [0, 0, 0, 0, 1, 0, 0, 0], 1.0),
    ("mol", [0, 0, 0, 0, 0, 1, 0, 0], 1.0),
    ("cd", [0, 0, 0, 0, 0, 0, 1, 0], 1.0),
    ("rad", [0, 0, 0, 0, 0, 0, 0, 1], 1.0),
    ("Hz", [0, 0, -1, 0, 0, 0, 0, 0], 1.0),
    ("N", [1, 1, -2, 0, 0, 0, 0, 0], 1.0),
    ("Pa", [1, -1, -2, 0, 0, 0, 0, 0], 1.0),
    ("bar", [1, -1, -2, 0, 0, 0, 0, 0], 1e5),
    ("J", [1, 2, -2, 0, 0, 0, 0, 0], 1.0),
    ("W", [1, 2, -3, 0, 0, 0, 0, 0], 1.0),
    ("C", [0, 0, 1, 1, 0, 0, 0, 0], 1.0),
    ("V", [1, 2, -3, -1, 0, 0, 0, 0], 1.0),
    ("F", [-1, -2, 4, 2, 0, 0, 0, 0], 1.0),
    ("Ohm", [1, 2, -3, -2, 0, 0, 0, 0], 1.0),
    ("S", [-1, -2, 3, 2, 0, 0, 0, 0], 1.0),
    ("Wb", [1, 2, -2, -1, 0, 0, 0, 0], 1.0),
    ("T", [1, 0, -2, -1, 0, 0, 0, 0], 1.0),
    ("H", [1, 2, -2, -2, 0, 0, 0, 0], 1.0),
    ("lm", [0, 0, 0, 0, 0, 0, 1, 0], 1.0),
    ("lx", [0, -2, 0, 0, 0, 0, 1, 0], 1.0),
    ("Bq", [0, 0, -1, 0, 0, 0, 0, 0], 1.0),
    ("Gy", [0, 2, -2, 0, 0, 0, 0, 0], 1.0),
    ("Sv", [0, 2, -2, 0, 0, 0, 0, 0], 1.0),
    ("kat", [0, 0, -1, 0, 0, 1, 0, 0], 1.0),
    ("L", [0, 3, 0, 0, 0, 0, 0, 0], 1e-3),
];

/// Symbols without prefixes.
const WHOLE: &[(&str, [i32; 8], f64)] = &[
    ("1", [0; 8], 1.0),
    ("%", [0; 8], 1e-2),
    ("min", [0, 0, 1, 0, 0, 0, 0, 0], 60.0),
    ("h", [0, 0, 1, 0, 0, 0, 0, 0], 3600.0),
    ("d", [0, 0, 1, 0, 0, 0, 0, 0], 86400.0),
    ("deg", [0, 0, 0, 0, 0, 0, 0, 1], std::f64::consts::PI / 180.0),
];

const PREFIXES: &[(&str, f64)] =
    &[("n", 1e-9), ("u", 1e-6), ("m", 1e-3), ("c", 1e-2), ("h", 1e2), ("k", 1e3), ("M", 1e6), ("G", 1e9)];

/// 0 °C, K.
const ICE_POINT: f64 = 273.15;

impl BaseUnit {
    const ONE: Self = BaseUnit { powers: [0; 8], factor: 1.0, offset: 0.0 };

    fn multiply(&mut self, (powers, factor): ([i32; 8], f64), power: i32) {
        self.powers.iter_mut().zip(powers).for_each(|(sum, own)| *sum += power * own);
        self.factor *= factor.powi(power);
    }

    /// Return `unit` in base units; refuse an unknown unit with the reason.
    pub fn parse(unit: &str) -> Result<Self, String> {
        if unit == "degC" {
            return Ok(BaseUnit { powers: [0, 0, 0, 0, 1, 0, 0, 0], offset: ICE_POINT, ..Self::ONE });
        }
        let (numerator, denominator) = match unit.split_once('/') {
            None => (unit, None),
            Some((numerator, denominator)) => (numerator, Some(denominator)),
        };
        let mut base = Self::ONE;
        let mut multiply = |product: &str, sign: i32| {
            product.split('.').try_for_each(|factor| {
                let (symbol, power) = split_power(factor);
                let of_symbol = find(symbol).ok_or_else(|| format!("unit {unit:?} is unknown at {factor:?}"))?;
                let power = power.ok_or_else(|| format!("unit {unit:?} has a bad exponent at {factor:?}"))?;
                base.multiply(of_symbol, sign * power);
                Ok::<_, String>(())
            })
        };
        multiply(numerator, 1)?;
        if let Some(denominator) = denominator {
            let in_parentheses = denominator.strip_prefix('(').and_then(|rest| rest.strip_suffix(')'));
            match in_parentheses {
                Some(product) => multiply(product, -1)?,
                None if denominator.contains('.') => {
                    return Err(format!("unit {unit:?} needs parentheses around {denominator:?}"));
                }
                None => multiply(denominator, -1)?,
            }
        }
        Ok(base)
    }
}

/// Return powers and factor of a symbol, with or without a prefix: `min` is a minute, not a milli-inch.
fn find(symbol: &str) -> Option<([i32; 8], f64)> {
    let whole = WHOLE.iter().chain(PREFIXED).find(|(name, ..)| *name == symbol);
    if let Some((_, powers, factor)) = whole {
        return Some((*powers, *factor));
    }
    if symbol == "kg" {
        return Some((PREFIXED[0].1, 1.0)); // a thousand thousandths, exactly
    }
    PREFIXES.iter().find_map(|(prefix, scale)| {
        let rest = symbol.strip_prefix(prefix)?;
        let (_, powers, factor) = PREFIXED.iter().find(|(name, ..)| *name == rest)?;
        Some((*powers, scale * factor))
    })
}

/// Return symbol and power: `m2` is `("m", Some(2))`, and a power that is not an integer is `None`.
fn split_power(factor: &str) -> (&str, Option<i32>) {
    match factor.find(|c: char| c == '-' || c.is_ascii_digit()) {
        None | Some(0) => (factor, Some(1)),
        Some(at) => (&factor[..at], factor[at..].parse().ok()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derived_units_have_their_powers_of_the_base_units() {
        for (unit, expected) in [
            ("1", [0; 8]),
            ("rad/s", [0, 0, -1, 0, 0, 0, 0, 1]),
            ("Hz", [0, 0, -1, 0, 0, 0, 0, 0]),
            ("1/s", [0, 0, -1, 0, 0, 0, 0, 0]),
            ("s-1", [0, 0, -1, 0, 0, 0, 0, 0]),
            ("N/m", [1, 0, -2, 0, 0, 0, 0, 0]),
            ("kg/m3", [1, -3, 0, 0, 0, 0, 0, 0]),
            ("kg/(m.s)", [1, -1, -1, 0, 0, 0, 0, 0]),
            ("kg/(m2.s)", [1, -2, -1, 0, 0, 0, 0, 0]),
            ("m2/s", [0, 2, -1, 0, 0, 0, 0, 0]),
            ("N.s/m2", [1, -1, -1, 0, 0, 0, 0, 0]),
            ("N.m2", [1, 3, -2, 0, 0, 0, 0, 0]),
            ("J/m", [1, 1, -2, 0, 0, 0, 0, 0]),
            ("W/(m.K)", [1, 1, -3, 0, -1, 0, 0, 0]),
            ("J/(mol.K)", [1, 2, -2, 0, -1, -1, 0, 0]),
            ("V/A", [1, 2, -3, -2, 0, 0, 0, 0]),
            ("Ohm", [1, 2, -3, -2, 0, 0, 0, 0]),
            ("lx", [0, -2, 0, 0, 0, 0, 1, 0]),
        ] {
            let BaseUnit { powers, factor, offset } = BaseUnit::parse(unit).unwrap();
            assert_eq!((powers, factor, offset), (expected, 1.0, 0.0), "{unit}");
        }
    }

    #[test]
    fn other_units_have_factor_and_offset() {
        for (unit, factor, offset) in [
            ("mm", 1e-3, 0.0),
            ("km/h", 1e3 / 3600.0, 0.0),
            ("min", 60.0, 0.0),
            ("bar", 1e5, 0.0),
            ("kPa", 1e3, 0.0),
            ("g", 1e-3, 0.0),
            ("mol/L", 1e3, 0.0),
            ("deg", std::f64::consts::PI / 180.0, 0.0),
            ("degC", 1.0, 273.15),
            ("kW.h", 3.6e6, 0.0),
        ] {
            let found = BaseUnit::parse(unit).unwrap();
            let close = (found.factor / factor - 1.0).abs() < 1e-15;
            assert!(close && found.offset == offset, "{unit}: {found:?}");
        }
    }

    #[test]
    fn a_malformed_unit_is_refused_by_name() {
        for unit in
            ["", "furlong", "m/", "m/s/s", "kg/m.s", "kg/(m.s", "m2x", "m--2", "m/(s)/kg", ".m", "2m", "kmin", "J/degC"]
        {
            let message = BaseUnit::parse(unit).expect_err(unit);
            assert!(message.contains(&format!("{unit:?}")), "{message}");
        }
    }
}
