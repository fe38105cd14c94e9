//! Numbers for people: four digits and a unit of suitable size.

/// Digits shown.
const DIGITS: i32 = 4;

/// Units that take a prefix, and the prefixes.
const PREFIXABLE: &[&str] = &["m", "s", "N", "J", "Hz", "m/s", "N m", "rad", "rad/s"];
/// Prefixes of units, factor and name, falling.
pub const PREFIXES: &[(f64, &str)] =
    &[(1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"), (1e-12, "p")];

/// A number in its most readable unit, such as `("1.25", "mm")`.
pub fn split(value: f64, unit: &str) -> (String, String) {
    if value == 0.0 || !value.is_finite() || !PREFIXABLE.contains(&unit) {
        return (plain(value), unit.to_owned());
    }
    if value.abs() < 1e-12 {
        return (plain(value), unit.to_owned());
    }
    let (scale, prefix) = prefix(value);
    (plain(value / scale), format!("{prefix}{unit}"))
}

/// A number in its most readable unit, as one text.
pub fn with_unit(value: f64, unit: &str) -> String {
    let (number, unit) = split(value, unit);
    if unit.is_empty() { number } else { format!("{number} {unit}") }
}

/// The most readable prefix for a magnitude, as factor and name. Values up to ten thousand have none.
pub fn prefix(value: f64) -> (f64, &'static str) {
    let size = value.abs();
    if (1.0..1e4).contains(&size) {
        return (1.0, "");
    }
    // A size that rounds up to the next prefix belongs to it.
    let rounded = size * (1.0 + 0.5 * 10_f64.powi(-DIGITS));
    PREFIXES.iter().copied().find(|(scale, _)| rounded >= *scale).unwrap_or((1e-12, "p"))
}

/// Four digits, with an exponent only where the number is very large or small.
pub fn plain(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return if value.is_nan() { "-".into() } else { "∞".into() };
    }
    let exponent = value.abs().log10().floor() as i32;
    if !(-4..7).contains(&exponent) {
        return format!("{value:.2e}");
    }
    let decimals = (DIGITS - 1 - exponent).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Significant digits of a double, and the number of decades shown below a tolerance.
const ALL_DIGITS: i32 = 15;
const BELOW_TOLERANCE: i32 = 2;

/// A number with enough digits to show a hundredth of the tolerance; all of them without a tolerance.
pub fn to_tolerance(value: f64, tolerance: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return plain(value);
    }
    let leading = value.abs().log10().floor() as i32;
    let last =
        if tolerance > 0.0 { tolerance.log10().floor() as i32 - BELOW_TOLERANCE } else { -i32::MAX / 2 };
    let digits = (leading - last + 1).clamp(DIGITS, ALL_DIGITS);
    if (-4..7).contains(&leading) {
        let decimals = (digits - 1 - leading).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.*e}", digits as usize - 1)
    }
}

/// Percentages beyond this are not meaningful and are not reported as numbers.
const MOST_PERCENT: f64 = 10_000.0;

/// A share as a percentage.
pub fn percent(share: f64) -> String {
    // Zero has no sign here.
    let percent = 100.0 * share + 0.0;
    if percent.abs() > MOST_PERCENT {
        return format!("{} {MOST_PERCENT}", if percent > 0.0 { "more than" } else { "less than minus" });
    }
    if percent != 0.0 && percent.abs() < 0.05 { "< 0.1".into() } else { format!("{percent:.1}") }
}

/// A share as a percentage with two digits, however small.
pub fn fine_percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent == 0.0 || !percent.is_finite() || percent.abs() >= 1.0 {
        return self::percent(share);
    }
    plain(two_digits(percent))
}

/// A number rounded to two digits.
pub fn two_digits(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let step = 10_f64.powf(value.abs().log10().floor() - 1.0);
    (value / step).round() * step
}

/// A count with its noun.
pub fn count(count: usize, one: &str, many: &str) -> String {
    if count == 1 { format!("1 {one}") } else { format!("{count} {many}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_numbers_read_well() {
        assert_eq!(with_unit(0.001_25, "m"), "1.25 mm");
        assert_eq!(with_unit(131.234_5, "N"), "131.2 N");
        assert_eq!(with_unit(0.999_99, "s"), "1 s");
        assert_eq!(with_unit(23_456.0, "Hz"), "23.46 kHz");
        assert_eq!(with_unit(0.0, "N"), "0 N");
        assert_eq!(with_unit(-0.02, "s"), "-20 ms");
        assert_eq!(with_unit(3e-15, "J"), "3.00e-15 J");
        assert_eq!(to_tolerance(20.546_813_9, 5e-4), "20.546814");
        assert_eq!(to_tolerance(1.0, 1e-12), "1.00000000000000");
        assert_eq!(to_tolerance(44.63, 1.0), "44.63");
        assert_eq!(to_tolerance(1.234_567e-9, 1e-15), "1.23456700e-9");
        assert_eq!(plain(1234.5), "1234");
        assert_eq!(plain(1.0e-9), "1.00e-9");
        assert_eq!(percent(0.1234), "12.3");
        assert_eq!(percent(1e-5), "< 0.1");
        assert_eq!(percent(-0.0), "0.0");
        assert_eq!(fine_percent(4.96e-3), "0.5");
        assert_eq!(fine_percent(1.234e-6), "0.00012");
        assert_eq!(fine_percent(0.123_4), "12.3");
        assert_eq!(fine_percent(-0.0), "0.0");
        assert_eq!(fine_percent(1e24), "more than 10000");
        assert_eq!(percent(-1e24), "less than minus 10000");
    }
}
