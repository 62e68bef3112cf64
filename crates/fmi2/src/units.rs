//! SI units by name: a product of symbols with exponents, then at most one `/` and a factor or a product in
//! parentheses, as in `kg/(m.s)`, `m2/s`, `N.s/m2`, `s-1`.

/// Exponents of the SI base units, and of the radian, which FMI counts as one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Exponents {
    pub kg: i32,
    pub m: i32,
    pub s: i32,
    pub rad: i32,
}

impl Exponents {
    const fn new(kg: i32, m: i32, s: i32, rad: i32) -> Self {
        Exponents { kg, m, s, rad }
    }

    fn add(&mut self, factor: Exponents, power: i32) {
        self.kg += power * factor.kg;
        self.m += power * factor.m;
        self.s += power * factor.s;
        self.rad += power * factor.rad;
    }

    /// The exponents of `unit`, or what is wrong with it.
    pub fn parse(unit: &str) -> Result<Self, String> {
        let (numerator, denominator) = match unit.split_once('/') {
            None => (unit, None),
            Some((numerator, denominator)) => (numerator, Some(denominator)),
        };
        let mut exponents = Exponents::default();
        let mut add_product = |product: &str, sign: i32| {
            product.split('.').try_for_each(|factor| {
                let (symbol, power) = split_power(factor);
                let base = symbol_exponents(symbol).ok_or_else(|| format!("unit {unit:?} is unknown at {factor:?}"))?;
                let power = power.ok_or_else(|| format!("unit {unit:?} has a bad exponent at {factor:?}"))?;
                exponents.add(base, sign * power);
                Ok::<_, String>(())
            })
        };
        add_product(numerator, 1)?;
        if let Some(denominator) = denominator {
            let in_parentheses = denominator.strip_prefix('(').and_then(|rest| rest.strip_suffix(')'));
            match in_parentheses {
                Some(product) => add_product(product, -1)?,
                None if denominator.contains('.') => {
                    return Err(format!("unit {unit:?} needs parentheses around {denominator:?}"));
                }
                None => add_product(denominator, -1)?,
            }
        }
        Ok(exponents)
    }
}

fn symbol_exponents(symbol: &str) -> Option<Exponents> {
    Some(match symbol {
        "1" => Exponents::new(0, 0, 0, 0),
        "kg" => Exponents::new(1, 0, 0, 0),
        "m" => Exponents::new(0, 1, 0, 0),
        "s" => Exponents::new(0, 0, 1, 0),
        "rad" => Exponents::new(0, 0, 0, 1),
        "Hz" => Exponents::new(0, 0, -1, 0),
        "N" => Exponents::new(1, 1, -2, 0),
        "Pa" => Exponents::new(1, -1, -2, 0),
        "J" => Exponents::new(1, 2, -2, 0),
        "W" => Exponents::new(1, 2, -3, 0),
        _ => return None,
    })
}

/// `m2` is `("m", Some(2))`; the power is `None` if it is not an integer.
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
    fn derived_units_have_their_si_exponents() {
        for (unit, expected) in [
            ("1", Exponents::new(0, 0, 0, 0)),
            ("rad/s", Exponents::new(0, 0, -1, 1)),
            ("Hz", Exponents::new(0, 0, -1, 0)),
            ("1/s", Exponents::new(0, 0, -1, 0)),
            ("s-1", Exponents::new(0, 0, -1, 0)),
            ("N/m", Exponents::new(1, 0, -2, 0)),
            ("kg/m3", Exponents::new(1, -3, 0, 0)),
            ("kg/(m.s)", Exponents::new(1, -1, -1, 0)),
            ("kg/(m2.s)", Exponents::new(1, -2, -1, 0)),
            ("m2/s", Exponents::new(0, 2, -1, 0)),
            ("N.s/m2", Exponents::new(1, -1, -1, 0)),
            ("Pa", Exponents::new(1, -1, -2, 0)),
            ("N.m2", Exponents::new(1, 3, -2, 0)),
            ("J/m", Exponents::new(1, 1, -2, 0)),
            ("W/m", Exponents::new(1, 1, -3, 0)),
        ] {
            assert_eq!(Exponents::parse(unit), Ok(expected), "{unit}");
        }
    }

    #[test]
    fn a_malformed_unit_is_refused_by_name() {
        for unit in ["", "furlong", "m/", "m/s/s", "kg/m.s", "kg/(m.s", "m2x", "m--2", "m/(s)/kg", ".m", "2m"] {
            let message = Exponents::parse(unit).expect_err(unit);
            assert!(message.contains(&format!("{unit:?}")), "{message}");
        }
    }
}
