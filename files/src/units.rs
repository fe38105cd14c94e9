//! Numbers with units, as in `"1.2 kN/mm"`.
//!
//! Factors are separated by a space, `*` or `·`; powers are written `m2`, `m^2` or `m²`. There is at most one
//! `/`. A denominator of several factors is in parentheses, so that `N/m s` is not ambiguous.

mod bases;
mod column;

use feeler_catalogue::{Dimension, same_exponent};
use thiserror::Error;

use bases::{Bases, describe, nearest, symbol_bases};
pub use column::{ColumnUnit, UnitKind, column_unit};

/// Why a text is not a quantity of the requested dimension.
#[derive(Clone, Debug, Error, PartialEq)]
pub(crate) enum UnitError {
    /// The text does not begin with a number.
    #[error("`{text}` does not begin with a number")]
    NoNumber { text: String },
    /// A number alone, where a unit is needed.
    #[error("`{text}` has no unit")]
    NoUnit { text: String },
    /// A comma instead of the decimal point.
    #[error("`{text}` has a decimal comma")]
    DecimalComma {
        text: String,
        /// The text with a decimal point.
        meant: String,
    },
    /// The symbol is not a unit.
    #[error("`{symbol}` is not a unit")]
    UnknownUnit {
        /// The text that was written.
        symbol: String,
        /// The most similar unit.
        nearest: Option<String>,
    },
    /// Two slashes, an unclosed parenthesis, a denominator of several factors.
    #[error("the unit `{unit}` {why}")]
    Malformed {
        /// The text that was written.
        unit: String,
        /// The mistake in words.
        why: &'static str,
    },
    /// The unit has another dimension.
    #[error("`{text}` is {given}")]
    WrongDimension {
        text: String,
        /// The dimension of the text.
        given: String,
    },
}

/// The value in SI of a text such as `"30 mm/s"`, which must have the dimension `dim`.
///
/// # Errors
/// [`UnitError`] if the text is not a quantity, or has another dimension.
pub(crate) fn parse(text: &str, dim: Dimension, rotational: bool) -> Result<f64, UnitError> {
    let (number, unit) = number_and_unit(text)?;
    if unit.is_empty() {
        return if dim.is(Dimension::NONE) {
            Ok(number)
        } else {
            Err(UnitError::NoUnit { text: text.into() })
        };
    }
    let (factor, bases) = unit_bases(unit)?;
    if bases.fit(dim, rotational) {
        return Ok(scaled(number, factor));
    }
    let given = bases.dim(rotational).map_or_else(|| describe(bases), |dim| dim.phrase(rotational));
    Err(UnitError::WrongDimension { text: text.into(), given })
}

/// Division by a power of ten is correctly rounded, multiplication by its inverse is not. With division `"5
/// mm"` is exactly 0.005.
fn scaled(number: f64, factor: f64) -> f64 {
    let inverse = (1.0 / factor).round();
    if factor < 1.0 && (inverse * factor - 1.0).abs() < 4.0 * f64::EPSILON {
        number / inverse
    } else {
        number * factor
    }
}

pub(crate) fn number_and_unit(text: &str) -> Result<(f64, &str), UnitError> {
    let (number, unit) = split(text).ok_or_else(|| UnitError::NoNumber { text: text.into() })?;
    if unit.strip_prefix(',').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit())) {
        return Err(UnitError::DecimalComma { text: text.into(), meant: text.replacen(',', ".", 1) });
    }
    Ok((number, unit))
}

/// Number and rest of a text.
fn split(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let bytes = text.as_bytes();
    let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit() || **b == b'_').count();
    let mut end = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let whole = digits(end);
    end += whole;
    let mut fraction = 0;
    if bytes.get(end) == Some(&b'.') {
        fraction = digits(end + 1);
        end += 1 + fraction;
    }
    if whole + fraction == 0 {
        return None;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = bytes.get(end + 1 + sign..).map_or(0, |_| digits(end + 1 + sign));
        if exponent > 0 {
            end += 1 + sign + exponent;
        }
    }
    let number = text[..end].replace('_', "").parse().ok()?;
    Some((number, text[end..].trim_start()))
}

/// Factor to SI and bases of a unit.
fn unit_bases(unit: &str) -> Result<(f64, Bases), UnitError> {
    let malformed = |why| UnitError::Malformed { unit: unit.into(), why };
    let mut sides = unit.split('/');
    let (above, below) = (sides.next().unwrap_or_default(), sides.next());
    if sides.next().is_some() {
        return Err(malformed("has two `/`; write the denominator in parentheses, as in N/(m s)"));
    }
    let mut factor = 1.0;
    let mut bases = Bases::default();
    if factors(above).next().is_none() {
        return Err(malformed("has nothing before the `/`; write 1/s"));
    }
    for part in factors(above) {
        apply(part, 1.0, &mut factor, &mut bases)?;
    }
    if let Some(below) = below {
        let below = below.trim();
        let inner = below.strip_prefix('(').and_then(|rest| rest.strip_suffix(')'));
        let parts: Vec<&str> = factors(inner.unwrap_or(below)).collect();
        match parts.len() {
            0 => return Err(malformed("has nothing after the `/`")),
            1 => {}
            _ if inner.is_some() => {}
            _ => return Err(malformed("is ambiguous; write N s/m or N/(m s)")),
        }
        for part in parts {
            apply(part, -1.0, &mut factor, &mut bases)?;
        }
    }
    Ok((factor, bases))
}

fn factors(side: &str) -> impl Iterator<Item = &str> {
    side.split(|c: char| c.is_whitespace() || c == '*' || c == '·').filter(|part| !part.is_empty())
}

/// One factor such as `mm2`, on one side of the slash.
fn apply(part: &str, side: f64, factor: &mut f64, bases: &mut Bases) -> Result<(), UnitError> {
    let unknown = || UnitError::UnknownUnit { symbol: part.into(), nearest: nearest(part) };
    let (symbol, power) = power(part).ok_or_else(unknown)?;
    let (scale, base) = symbol_bases(symbol).ok_or_else(unknown)?;
    let power = side * power;
    // `powf` is not correctly rounded; `powi` of a power of ten nearly always is.
    *factor *= if same_exponent(power, power.round()) {
        scale.powi(power.round() as i32)
    } else {
        scale.powf(power)
    };
    bases.add(base, power);
    Ok(())
}

/// Symbol and power of a factor; powers stay below 10, so that factors stay finite.
fn power(part: &str) -> Option<(&str, f64)> {
    let superscripts = [("²", 2.0), ("³", 3.0), ("⁴", 4.0)];
    if let Some((symbol, power)) =
        superscripts.iter().find_map(|(mark, power)| Some((part.strip_suffix(mark)?, *power)))
    {
        return Some((symbol, power));
    }
    let (symbol, digits) = match part.split_once('^') {
        Some((symbol, digits)) => (symbol, digits),
        None if part == "1" => (part, ""),
        None => part.split_at(part.find(|c: char| c.is_ascii_digit() || c == '-').unwrap_or(part.len())),
    };
    let power =
        if digits.is_empty() { 1.0 } else { digits.parse().ok().filter(|power: &f64| power.abs() < 10.0)? };
    Some((symbol, power))
}

/// The value in SI of a text with any unit.
///
/// # Errors
/// [`UnitError`] if the text is not a quantity.
pub(crate) fn parse_any(text: &str) -> Result<f64, UnitError> {
    let (number, unit) = number_and_unit(text)?;
    if unit.is_empty() { Ok(number) } else { unit_bases(unit).map(|(factor, _)| scaled(number, factor)) }
}

/// Whether the units of two texts have the same bases. A text that is not a quantity matches any other; its
/// mistake is reported elsewhere.
pub(crate) fn are_alike(one: &str, other: &str) -> bool {
    let bases = |text| match split(text)? {
        (_, "") => Some(Bases::default()),
        (_, unit) => unit_bases(unit).ok().map(|(_, bases)| bases),
    };
    bases(one).zip(bases(other)).is_none_or(|(one, other)| one.is_like(other))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// A unit is a product of at most four factors, each correctly rounded.
    const ROUNDING: f64 = 1e-15;

    fn si(text: &str, dimension: Dimension, rotational: bool) -> Result<f64, UnitError> {
        parse(text, dimension, rotational)
    }

    #[test]
    fn truth_texts_are_read_in_si() {
        let cases = [
            ("400 kN/m", Dimension::STIFFNESS, false, 4e5),
            ("1.2 kN/mm", Dimension::STIFFNESS, false, 1.2e6),
            ("30 mm/s", Dimension::VELOCITY, false, 0.03),
            ("1 kHz", Dimension::FREQUENCY, false, 1e3),
            ("0.4 ms", Dimension::TIME, false, 4e-4),
            ("5kg", Dimension::MASS, false, 5.0),
            ("250 g", Dimension::MASS, false, 0.25),
            ("12 N s/m", Dimension::DAMPING, false, 12.0),
            ("3 N*s/m", Dimension::DAMPING, false, 3.0),
            ("3 N·s/mm", Dimension::DAMPING, false, 3e3),
            ("1e3 N/(m/s)", Dimension::DAMPING, false, f64::NAN),
            ("10 %", Dimension::NONE, false, 0.1),
            ("9.81 m/s^2", Dimension::ACCELERATION, false, 9.81),
            ("9.81 m/s2", Dimension::ACCELERATION, false, 9.81),
            ("9.81 m s^-2", Dimension::ACCELERATION, false, 9.81),
            ("1 m/s²", Dimension::ACCELERATION, false, 1.0),
            ("2e12 N/m3", Dimension::CUBIC_STIFFNESS, false, 2e12),
            ("1e8 N/m^1.5", Dimension::POWER_STIFFNESS, false, 1e8),
            ("1 1/s", Dimension::FREQUENCY, false, 1.0),
            ("60 1/min", Dimension::FREQUENCY, false, 1.0),
            ("-5 µm", Dimension::LENGTH, false, -5e-6),
            ("180 deg", Dimension::NONE, false, PI),
            ("2 deg", Dimension::LENGTH, true, PI / 90.0),
            ("60 rpm", Dimension::VELOCITY, true, 2.0 * PI),
            ("1 N m/rad", Dimension::STIFFNESS, true, 1.0),
            ("1 N m", Dimension::FORCE, true, 1.0),
            ("0.1 kg m2", Dimension::MASS, true, 0.1),
            ("1 mN m s/rad", Dimension::DAMPING, true, 1e-3),
            ("12 V", Dimension::VOLTAGE, false, 12.0),
            ("500 mohm", Dimension::RESISTANCE, true, 0.5),
            ("2 mH", Dimension::INDUCTANCE, true, 2e-3),
            ("30 mN m/A", Dimension::FORCE_PER_CURRENT, true, 0.03),
            ("0.03 V s/rad", Dimension::FORCE_PER_CURRENT, true, 0.03),
            ("5 N/A", Dimension::FORCE_PER_CURRENT, false, 5.0),
        ];
        for (text, dimension, rotational, expected) in cases {
            match si(text, dimension, rotational) {
                Ok(value) => assert!(
                    (value - expected).abs() <= ROUNDING * expected.abs(),
                    "{text}: {value}, not {expected}"
                ),
                Err(error) => assert!(expected.is_nan(), "{text}: {error}"),
            }
        }
    }

    #[test]
    fn truth_what_is_written_is_the_nearest_float() {
        for (text, dimension, expected) in [
            ("5 mm", Dimension::LENGTH, 0.005_f64),
            ("0.4 ms", Dimension::TIME, 0.0004),
            ("30 mm/s", Dimension::VELOCITY, 0.03),
            ("1 um", Dimension::LENGTH, 1e-6),
            ("7 kg", Dimension::MASS, 7.0),
        ] {
            assert_eq!(si(text, dimension, false).unwrap().to_bits(), expected.to_bits(), "{text}");
        }
    }

    #[test]
    fn truth_another_dimension_is_named() {
        for (text, dimension, rotational, expected) in [
            ("5 mm", Dimension::STIFFNESS, false, "`5 mm` is a length (m)"),
            ("5 N", Dimension::FORCE, true, "in kg m s^-2"),
            ("5 rad/s", Dimension::FREQUENCY, false, "in s^-1 rad"),
            ("5 Hz", Dimension::VELOCITY, true, "`5 Hz` is a frequency (Hz)"),
            ("5", Dimension::TIME, false, "`5` has no unit"),
            ("5 khz", Dimension::FREQUENCY, false, "`khz` is not a unit"),
            ("5 N/m s", Dimension::DAMPING, false, "ambiguous"),
            ("5 N/m/s", Dimension::DAMPING, false, "two `/`"),
            ("fast", Dimension::TIME, false, "does not begin with a number"),
            ("5 m^99", Dimension::LENGTH, false, "is not a unit"),
            ("", Dimension::LENGTH, false, "does not begin with a number"),
            ("5 /", Dimension::LENGTH, false, "nothing before"),
        ] {
            let error = si(text, dimension, rotational).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
