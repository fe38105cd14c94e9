//! Charts as data; `assets/page.js` draws them.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};

use crate::numbers::with_unit;

/// Significant digits of decimal numbers.
const DIGITS: usize = 9;
/// Largest length of a column that is written as a readable list.
const SHORT: usize = 32;
/// Share of the largest curve in a chart below which another curve is a rounding error.
const ROUNDING: f64 = 1e-9;
/// Values below these are rounding errors: levels in dB and angles in degrees, and numbers in any other unit.
const NO_LEVEL: f64 = 1e-6;
const NOTHING: f64 = 1e-12;
/// Steps of an axis are even if they differ by less than this, relative to a step.
const EVEN: f64 = 1e-6;

/// The kind of a chart's horizontal axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ChartKind {
    /// Increasing values, zoomed in one direction; charts may zoom together.
    Line,
    /// A path in a plane, zoomed in both directions.
    Path,
}

/// One curve.
#[expect(clippy::struct_excessive_bools, reason = "each is a style of its own")]
pub(crate) struct Series {
    pub(crate) name: String,
    /// Unit of its values as shown under the pointer.
    pub(crate) unit: String,
    pub(crate) values: Vec<f64>,
    pub(crate) dashed: bool,
    /// Points without a line between them.
    pub(crate) dots: bool,
    /// Whether the curve is thin and pale, as a reference for others.
    pub(crate) faint: bool,
    /// Whether the curve was measured: it is a wide grey line below those that are computed.
    pub(crate) measured: bool,
    /// Index in the palette; `None` for the index of the curve in the chart.
    pub(crate) colour: Option<usize>,
}

impl Series {
    pub(crate) fn new(name: impl Into<String>, unit: impl Into<String>, values: Vec<f64>) -> Self {
        Self {
            name: name.into(),
            unit: unit.into(),
            values,
            dashed: false,
            dots: false,
            faint: false,
            measured: false,
            colour: None,
        }
    }

    pub(crate) fn dashed(self) -> Self {
        Self { dashed: true, ..self }
    }

    pub(crate) fn dots(self) -> Self {
        Self { dots: true, ..self }
    }

    pub(crate) fn faint(self) -> Self {
        Self { faint: true, ..self }
    }

    pub(crate) fn measured(self) -> Self {
        Self { measured: true, ..self }
    }

    pub(crate) fn coloured(self, colour: usize) -> Self {
        Self { colour: Some(colour), ..self }
    }
}

/// A horizontal line with its name.
pub(crate) struct Line {
    pub(crate) y: f64,
    pub(crate) label: String,
}

/// A point with its name.
pub(crate) struct Mark {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) label: String,
}

/// A vertical span with its name, such as a margin.
pub(crate) struct Gauge {
    pub(crate) x: f64,
    /// Both ends of the span.
    pub(crate) y: [f64; 2],
    pub(crate) label: String,
}

pub(crate) struct Chart {
    pub(crate) kind: ChartKind,
    pub(crate) title: String,
    /// Explains the chart.
    pub(crate) caption: String,
    pub(crate) x_label: String,
    pub(crate) y_label: String,
    pub(crate) x_log: bool,
    pub(crate) y_log: bool,
    /// Charts that share this name zoom together.
    pub(crate) together: Option<&'static str>,
    pub(crate) x: Vec<f64>,
    pub(crate) series: Vec<Series>,
    /// Spans of the horizontal axis that are shaded.
    pub(crate) bands: Vec<[f64; 2]>,
    /// Pairs of series, upper and lower, with the area between them shaded. For dots a bar joins each pair.
    pub(crate) between: Vec<[usize; 2]>,
    pub(crate) lines: Vec<Line>,
    pub(crate) gauges: Vec<Gauge>,
    pub(crate) marks: Vec<Mark>,
}

impl Chart {
    pub(crate) fn new(
        kind: ChartKind,
        title: impl Into<String>,
        x_label: &str,
        y_label: impl Into<String>,
    ) -> Self {
        Self {
            kind,
            title: title.into(),
            caption: String::new(),
            x_label: x_label.to_owned(),
            y_label: y_label.into(),
            x_log: false,
            y_log: false,
            together: None,
            x: Vec::new(),
            series: Vec::new(),
            bands: Vec::new(),
            between: Vec::new(),
            lines: Vec::new(),
            gauges: Vec::new(),
            marks: Vec::new(),
        }
    }

    /// The chart with zeros in place of curves that are rounding errors beside the largest.
    #[must_use]
    pub(crate) fn without_rounding(mut self) -> Self {
        let size = |series: &Series| {
            series.values.iter().filter(|value| value.is_finite()).fold(0.0, |most: f64, v| most.max(v.abs()))
        };
        let largest = self.series.iter().map(size).fold(0.0, f64::max);
        for series in &mut self.series {
            if size(series) < ROUNDING * largest {
                for value in series.values.iter_mut().filter(|value| value.is_finite()) {
                    *value = 0.0;
                }
            }
        }
        self
    }

    /// A sentence in place of a chart without values, or whose curves change by no more than rounding errors.
    pub(super) fn instead(&self) -> Option<String> {
        let ranges: Vec<(&Series, [f64; 2])> =
            self.series.iter().filter_map(|series| Some((series, range(&series.values)?))).collect();
        if ranges.is_empty() {
            return Some("There are no values to draw.".to_owned());
        }
        let is_level = ["(dB)", "(°)"].iter().any(|unit| self.y_label.ends_with(unit));
        let floor = match (is_level, self.y_log) {
            (true, _) => NO_LEVEL,
            (_, false) => NOTHING,
            _ => 0.0,
        };
        let size = |[low, high]: [f64; 2]| low.abs().max(high.abs());
        let drawn = ranges.iter().map(|(_, range)| size(*range));
        let largest = drawn.chain(self.lines.iter().map(|line| line.y.abs())).fold(0.0, f64::max);
        let least = floor.max(ROUNDING * largest);
        if largest == 0.0 {
            return Some("Zero throughout.".to_owned());
        }
        if largest <= floor {
            return Some("Zero throughout, except for rounding errors.".to_owned());
        }
        let rests = |[low, high]: [f64; 2]| high - low <= least;
        if !self.marks.is_empty() || !self.gauges.is_empty() || !ranges.iter().all(|(_, r)| rests(*r)) {
            return None;
        }
        let value = |(series, [low, high]): &(&Series, [f64; 2])| {
            let mean = 0.5 * (low + high);
            let mean = if mean.abs() <= least { 0.0 } else { mean };
            format!("{} {}", series.name, with_unit(mean, &series.unit))
        };
        let values = ranges.iter().map(value).collect::<Vec<_>>().join(", ");
        Some(format!("Constant: {values}."))
    }

    pub(crate) fn to_json(&self) -> Value {
        let series = |series: &Series| {
            json!({
                "name": series.name, "unit": series.unit, "dashed": series.dashed, "dots": series.dots,
                "faint": series.faint, "measured": series.measured, "colour": series.colour,
                "values": column(&series.values),
            })
        };
        let band = |band: &[f64; 2]| band.map(|at| rounded(at, DIGITS));
        let line = |line: &Line| json!({ "y": line.y, "label": line.label });
        let gauge = |gauge: &Gauge| {
            let [from, to] = gauge.y;
            json!({ "x": gauge.x, "from": from, "to": to, "label": gauge.label })
        };
        let mark = |mark: &Mark| json!({ "x": mark.x, "y": mark.y, "label": mark.label });
        json!({
            "kind": if self.kind == ChartKind::Line { "line" } else { "path" },
            "x": {
                "label": self.x_label,
                "log": self.x_log,
                "together": self.together,
                "values": axis(&self.x),
            },
            "y": { "label": self.y_label, "log": self.y_log },
            "series": self.series.iter().map(series).collect::<Vec<_>>(),
            "bands": self.bands.iter().map(band).collect::<Vec<_>>(),
            "between": self.between,
            "lines": self.lines.iter().map(line).collect::<Vec<_>>(),
            "gauges": self.gauges.iter().map(gauge).collect::<Vec<_>>(),
            "marks": self.marks.iter().map(mark).collect::<Vec<_>>(),
            "instead": self.instead(),
        })
    }
}

/// The smallest and the largest finite value.
fn range(values: &[f64]) -> Option<[f64; 2]> {
    let finite = values.iter().filter(|value| value.is_finite());
    finite.map(|&value| [value; 2]).reduce(|[low, high], [value, _]| [low.min(value), high.max(value)])
}

fn decimals(values: &[f64]) -> Value {
    values.iter().map(|&value| rounded(value, DIGITS)).collect()
}

/// Values in single precision. Their seven digits need less space than decimals.
pub(super) fn column(values: &[f64]) -> Value {
    if values.len() <= SHORT {
        return decimals(values);
    }
    let bytes: Vec<u8> = values.iter().flat_map(|&value| (value as f32).to_le_bytes()).collect();
    json!({ "f32": BASE64_STANDARD.encode(bytes) })
}

/// Values of a horizontal axis. Even steps are written as start and step. Others are written in double
/// precision, because the axis may be zoomed far.
fn axis(values: &[f64]) -> Value {
    if values.len() <= SHORT {
        return decimals(values);
    }
    let (from, last) = (values[0], values[values.len() - 1]);
    let step = (last - from) / (values.len() - 1) as f64;
    let even = |(i, value): (usize, &f64)| (from + i as f64 * step - value).abs() <= EVEN * step;
    if values.iter().enumerate().all(even) {
        return json!({ "from": from, "step": step, "count": values.len() });
    }
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    json!({ "f64": BASE64_STANDARD.encode(bytes) })
}

/// A number with this many significant digits, to save space; `null` if it is not finite.
fn rounded(value: f64, digits: usize) -> Value {
    let short: f64 = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    // Integers need no `.0`.
    if short.fract() == 0.0 && short.abs() < 1e9 { Value::from(short as i64) } else { Value::from(short) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_numbers_are_short_and_undefined_ones_are_null() {
        let text = |value| rounded(value, 6).to_string();
        assert_eq!(text(0.1 + 0.2), "0.3");
        assert_eq!(text(1_234_567.8), "1234570");
        assert_eq!(text(f64::NAN), "null");
        assert_eq!(text(f64::INFINITY), "null");
        assert_eq!(text(-3.0), "-3");
    }

    #[test]
    fn regress_a_torque_of_rounding_is_no_signal() {
        let mut chart = Chart::new(ChartKind::Line, "Torques.", "time (s)", "torque (N m)");
        let curve = |name: &str, values: &[f64]| Series::new(name, "N m", values.to_vec());
        chart.series = vec![curve("lift", &[0.0, 14.1]), curve("roll", &[f64::NAN, -6.9e-14])];
        let shown = chart.without_rounding();
        assert_eq!(shown.series[0].values[1].to_bits(), 14.1_f64.to_bits());
        assert!(shown.series[1].values[0].is_nan() && shown.series[1].values[1].abs() < f64::MIN_POSITIVE);
        let mut alone = Chart::new(ChartKind::Line, "Torques.", "time (s)", "torque (N m)");
        alone.series = vec![curve("roll", &[1e-14])];
        assert!(alone.without_rounding().series[0].values[0] > 0.0, "there is nothing larger beside it");
    }

    #[test]
    fn regress_a_chart_of_rounding_says_so() {
        let instead = |label: &str, values: &[f64], line: Option<f64>| {
            let mut chart = Chart::new(ChartKind::Line, "Difference.", "frequency (Hz)", label);
            chart.series = vec![Series::new("measured", "dB", values.to_vec())];
            chart.lines.extend(line.map(|y| Line { y, label: String::new() }));
            chart.instead()
        };
        let zero = Some("Zero throughout, except for rounding errors.".to_owned());
        assert_eq!(instead("difference (dB)", &[-1.5e-9, 1.8e-9, f64::NAN], Some(0.0)), zero);
        assert_eq!(instead("force (N)", &[0.0, 1e-14], None), zero);
        assert_eq!(instead("difference (dB)", &[-0.01, 0.02], Some(0.0)), None);
        assert_eq!(instead("force (N)", &[0.0, 1e-9], None), None);
        let constant = Some("Constant: measured 20 dB.".to_owned());
        assert_eq!(instead("level (dB)", &[20.0, 20.0 + 1e-9], None), constant);
        assert_eq!(instead("level (dB)", &[f64::NAN], None).unwrap(), "There are no values to draw.");
    }

    /// A page reads recorded values back in single precision, and times exactly.
    #[test]
    fn truth_columns_are_whole_and_even_axes_are_rules() {
        let values: Vec<f64> = (0..1000).map(|i| (0.1 * f64::from(i)).sin()).collect();
        let encoded = column(&values);
        let bytes = BASE64_STANDARD.decode(encoded["f32"].as_str().unwrap()).unwrap();
        let read: Vec<f32> = bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        assert!(
            read.len() == 1000 && read.iter().zip(&values).all(|(r, v)| (f64::from(*r) - v).abs() < 1e-7)
        );
        let even: Vec<f64> = (0..100_000).map(|i| f64::from(i) * 2.5e-4).collect();
        assert_eq!(axis(&even), json!({ "from": 0.0, "step": 2.5e-4, "count": 100_000 }));
        let uneven: Vec<f64> = (0..100).map(|i| f64::from(i * i)).collect();
        assert!(axis(&uneven)["f64"].is_string());
    }
}
