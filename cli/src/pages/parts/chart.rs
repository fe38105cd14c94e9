//! Charts as data; `assets/page.js` draws them.

use serde_json::{Value, json};

/// Significant digits of plotted values: ten times finer than a pixel of a large screen.
const DIGITS: usize = 6;
/// Of horizontal axes, which may be zoomed far into.
const AXIS_DIGITS: usize = 9;

/// What a chart's horizontal axis is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ChartKind {
    /// Increasing values, zoomed in one direction; charts may zoom together.
    Line,
    /// A path in a plane, zoomed in both.
    Path,
}

/// One curve.
pub(crate) struct Series {
    pub(crate) name: String,
    /// Unit of its values as shown under the pointer.
    pub(crate) unit: String,
    pub(crate) values: Vec<f64>,
    pub(crate) dashed: bool,
    /// Points that no line joins.
    pub(crate) dots: bool,
}

impl Series {
    pub(crate) fn new(name: impl Into<String>, unit: impl Into<String>, values: Vec<f64>) -> Self {
        Self { name: name.into(), unit: unit.into(), values, dashed: false, dots: false }
    }

    pub(crate) fn dashed(self) -> Self {
        Self { dashed: true, ..self }
    }

    pub(crate) fn dots(self) -> Self {
        Self { dots: true, ..self }
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

/// A chart.
pub(crate) struct Chart {
    pub(crate) kind: ChartKind,
    pub(crate) title: String,
    /// What to look at.
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
    pub(crate) lines: Vec<Line>,
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
            lines: Vec::new(),
            marks: Vec::new(),
        }
    }

    pub(super) fn to_json(&self) -> Value {
        let numbers =
            |values: &[f64], digits| values.iter().map(|&value| rounded(value, digits)).collect::<Vec<_>>();
        let series = |series: &Series| json!({ "name": series.name, "unit": series.unit, "dashed": series.dashed, "dots": series.dots, "values": numbers(&series.values, DIGITS) });
        json!({
            "kind": if self.kind == ChartKind::Line { "line" } else { "path" },
            "x": { "label": self.x_label, "log": self.x_log, "together": self.together, "values": numbers(&self.x, AXIS_DIGITS) },
            "y": { "label": self.y_label, "log": self.y_log },
            "series": self.series.iter().map(series).collect::<Vec<_>>(),
            "bands": self.bands.iter().map(|band| numbers(band, AXIS_DIGITS)).collect::<Vec<_>>(),
            "lines": self.lines.iter().map(|line| json!({ "y": line.y, "label": line.label })).collect::<Vec<_>>(),
            "marks": self.marks.iter().map(|mark| json!({ "x": mark.x, "y": mark.y, "label": mark.label })).collect::<Vec<_>>(),
        })
    }
}

/// A number with this many significant digits, which is shorter to write; none where it is no number.
pub(super) fn rounded(value: f64, digits: usize) -> Value {
    let short: f64 = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    // Whole numbers need no `.0`.
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
}
