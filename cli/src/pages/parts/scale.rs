//! The axes of plots: positions of values, ticks, and the format of their numbers, with a common factor in
//! the title.

use feeler_studies::sweep::share_between;

use crate::numbers::{PREFIXES, plain};

/// Approximate number of pixels between ticks of a linear axis.
const TICK_EVERY: f64 = 70.0;
/// Magnitudes that are written without a factor.
const PLAIN: [f64; 2] = [1e-3, 1e4];
/// The largest number at a tick of a logarithmic axis.
const LARGEST: f64 = 1e5;
/// Ends and ticks with a smaller relative difference are equal.
const ROUNDING: f64 = 1e-3;

/// An axis of a plot.
#[derive(Clone, Debug)]
pub(crate) struct Scale {
    /// Quantity of the axis, without the unit.
    pub(crate) label: String,
    /// Unit of the quantity; empty for a pure number.
    pub(crate) unit: String,
    /// Values at the two ends.
    pub(crate) range: [f64; 2],
    pub(crate) log: bool,
}

/// The format of the numbers of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Style {
    /// In units of this power of ten, a multiple of three.
    Factor(i32),
    /// Each as a power of ten.
    Powers,
}

impl Scale {
    /// Position of a value between the ends, 0 to 1.
    pub(crate) fn share(&self, value: f64) -> f64 {
        share_between(self.range, self.log, value)
    }

    /// Quantity of the axis with the unit of its numbers; a dash for a pure number.
    pub(crate) fn title(&self) -> String {
        let unit = match self.style() {
            Style::Factor(power) if power != 0 => scaled(power, &self.unit),
            _ if self.unit.is_empty() => "-".to_owned(),
            _ => self.unit.clone(),
        };
        if self.label.is_empty() { String::new() } else { format!("{} ({unit})", self.label) }
    }

    /// Whether the ticks are at decades. The axis must span at least one decade.
    fn has_decades(&self) -> bool {
        let [low, high] = self.ends();
        self.log && low > 0.0 && high > 10.0 * low
    }

    fn ends(&self) -> [f64; 2] {
        let [from, to] = self.range;
        [from.min(to), from.max(to)]
    }

    fn style(&self) -> Style {
        let [low, high] = self.ends();
        let largest = low.abs().max(high.abs());
        if largest <= 0.0 || !largest.is_finite() {
            return Style::Factor(0);
        }
        let smallest = if self.has_decades() { low * (1.0 + ROUNDING) } else { (high - low) / 10.0 };
        if smallest >= PLAIN[0] && largest <= PLAIN[1] * (1.0 + ROUNDING) {
            return Style::Factor(0);
        }
        let thousands = |value: f64| 3 * (value.log10() / 3.0).floor() as i32;
        if !self.has_decades() {
            return Style::Factor(thousands(largest));
        }
        let mut power = thousands(smallest);
        while largest > LARGEST * (1.0 + ROUNDING) * 10_f64.powi(power) {
            power += 3;
        }
        if smallest < PLAIN[0] * 10_f64.powi(power) { Style::Powers } else { Style::Factor(power) }
    }

    /// Ratio of values to the numbers at their ticks.
    pub(crate) fn factor(&self) -> f64 {
        if let Style::Factor(power) = self.style() { 10_f64.powi(power) } else { 1.0 }
    }

    /// Tick values, with their text if they have one.
    pub(crate) fn ticks(&self, pixels: f64) -> Vec<(f64, String)> {
        let [low, high] = self.ends();
        // An axis with equal ends has no ticks.
        if !(high - low).is_finite() || high <= low {
            return Vec::new();
        }
        let style = self.style();
        if self.has_decades() {
            let text = |value: f64| match style {
                Style::Factor(power) => plain(value / 10_f64.powi(power)),
                Style::Powers => format!("{value:e}"),
            };
            let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
            let few = (high / low).log10() < 2.5;
            let of_decade = |decade: i32| {
                (1..10).map(move |m| {
                    let value = f64::from(m) * 10_f64.powi(decade);
                    (value, m == 1 || (few && (m == 2 || m == 5)))
                })
            };
            let within = |value: f64| (low * (1.0 - ROUNDING)..=high * (1.0 + ROUNDING)).contains(&value);
            let marked = decades.flat_map(of_decade).filter(|(value, _)| within(*value));
            return marked
                .map(|(value, named)| (value, if named { text(value) } else { String::new() }))
                .collect();
        }
        let factor = self.factor();
        let rough = (high - low) / (pixels / TICK_EVERY).max(1.0);
        let decade = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|m| m * decade)
            .find(|step| *step >= rough)
            .unwrap_or(rough);
        let first = (low / step).ceil() as i64;
        let last = (high / step).floor() as i64;
        // Ticks have as many decimals as their spacing.
        let decimals = (-(step / factor * (1.0 + ROUNDING)).log10().floor()).max(0.0) as usize;
        // Removes the sign of a zero.
        let text = |value: f64| format!("{:.decimals$}", value / factor + 0.0);
        (first..=last).map(|i| i as f64 * step).map(|value| (value, text(value))).collect()
    }
}

/// A power of ten of a unit, with a prefix if possible.
fn scaled(power: i32, unit: &str) -> String {
    let prefix = PREFIXES
        .iter()
        .find(|(factor, _)| (factor.log10() - f64::from(power)).abs() < 0.5)
        .map(|(_, name)| name);
    let first = unit.split([' ', '/']).next().unwrap_or_default();
    let takes_prefix = first.starts_with(char::is_alphabetic) && first != "kg" && !first.contains('^');
    match prefix.filter(|_| takes_prefix) {
        Some(prefix) => format!("{prefix}{unit}"),
        None => format!("10{} {unit}", raised(power)).trim_end().to_owned(),
    }
}

/// A whole number as an exponent.
fn raised(power: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let of = |c: char| c.to_digit(10).map_or('⁻', |digit| DIGITS[digit as usize]);
    power.to_string().chars().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(range: [f64; 2], unit: &str, log: bool) -> (String, Vec<String>) {
        let scale = Scale { label: "x".into(), unit: unit.into(), range, log };
        let named = scale.ticks(400.0).into_iter().map(|(_, text)| text).filter(|text| !text.is_empty());
        (scale.title(), named.collect())
    }

    #[test]
    fn regress_ticks_of_an_axis_are_written_alike() {
        let (title, ticks) = scale([0.0, 1e-3], "s", false);
        assert_eq!((title.as_str(), ticks.join(" ").as_str()), ("x (ms)", "0.0 0.2 0.4 0.6 0.8 1.0"));
        let (title, ticks) = scale([1e4, 1e7], "N/m", true);
        assert_eq!((title.as_str(), ticks.join(" ").as_str()), ("x (kN/m)", "10 100 1000 10000"));
        let (title, ticks) = scale([0.1, 2.0], "", false);
        assert_eq!((title.as_str(), ticks.join(" ").as_str()), ("x (-)", "0.5 1.0 1.5 2.0"));
        let (title, ticks) = scale([1e-4, 5e-3], "(m/s)/N", false);
        assert_eq!((title.as_str(), ticks.join(" ").as_str()), ("x (10⁻³ (m/s)/N)", "1 2 3 4 5"));
        let (title, ticks) = scale([1e-6, 1e6], "kg", true);
        assert_eq!((title.as_str(), ticks[0].as_str(), ticks[12].as_str()), ("x (kg)", "1e-6", "1e6"));
        assert_eq!(scale([2e4, 8e4], "kg", false).0, "x (10³ kg)");
        assert_eq!(scale([0.0, 0.0], "N", false).0, "x (N)");
    }
}
