//! Diagrams over one axis: the force of each impact, and the force once per cycle.

use std::fmt::Write as _;

use feeler_studies::run::Outcome;
use feeler_studies::sweep::{DrawnAxis, SweepTable};

use super::palette::of_outcome;
use crate::pages::parts::svg::{Frame, INK, Place, Scale, image, swatch, text_at};

const WIDTH: f64 = 860.0;
const PLOT: Place = Place { x: 92.0, y: 84.0, width: 740.0, height: 360.0 };
/// Diameter of a point: a share of the distance between variants, within these bounds.
const POINT_SHARE: f64 = 0.6;
const POINT: [f64; 2] = [2.4, 5.0];
/// Height of the band of outcomes above the plot.
const BAND: f64 = 10.0;
/// Last line of the legend of the band, and the distance between two: three lines hold all outcomes.
const LEGEND_Y: f64 = 58.0;
const LEGEND_ROW: f64 = 20.0;
/// Width of a swatch with its space, of a letter, and of the space after a name.
const ENTRY: f64 = 30.0;
const LETTER: f64 = 7.0;
const GAP: f64 = 14.0;

/// A predicted line, in values of the axis and of the plot; dashed for an unstable cycle.
pub(super) struct Prediction {
    pub(super) line: Vec<[f64; 2]>,
    pub(super) dashed: bool,
}

/// Lists of numbers of some rows over an axis, with a band of the rows' outcomes above.
pub(super) struct Diagram<'a> {
    pub(super) axis: &'a DrawnAxis,
    pub(super) rows: Vec<usize>,
    /// Values of the axis, by row.
    pub(super) at: Vec<Option<f64>>,
}

impl<'a> Diagram<'a> {
    pub(super) fn new(axis: &'a DrawnAxis, table: &SweepTable, rows: Vec<usize>) -> Self {
        Self { axis, at: table.reals(&axis.key).unwrap_or_default(), rows }
    }

    fn margin(&self) -> f64 {
        self.axis.points.map_or(0.0, |points| 0.5 / (points - 1) as f64)
    }

    /// Columns of the plot, as input of the page's script.
    pub(super) fn places(&self) -> Vec<[f64; 5]> {
        let mut sorted: Vec<(f64, usize)> =
            self.rows.iter().filter_map(|&row| Some((self.share(self.at[row]?), row))).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let edge = |i: usize| match (i.checked_sub(1).and_then(|i| sorted.get(i)), sorted.get(i)) {
            (Some(a), Some(b)) => 0.5 * (a.0 + b.0),
            (None, _) => 0.0,
            (_, None) => 1.0,
        };
        let place = |(i, (_, row)): (usize, &(f64, usize))| {
            let (left, right) = (PLOT.x + edge(i) * PLOT.width, PLOT.x + edge(i + 1) * PLOT.width);
            [left, PLOT.y - BAND - 6.0, right - left, PLOT.height + BAND + 6.0, *row as f64]
        };
        sorted.iter().enumerate().map(place).collect()
    }

    fn share(&self, value: f64) -> f64 {
        let margin = self.margin();
        (self.axis.share(value) + margin) / (1.0 + 2.0 * margin)
    }

    /// Points of `lists`, and predictions over them.
    pub(super) fn svg(
        &self,
        lists: &[Vec<f64>],
        outcomes: &[String],
        [what, unit_of_y]: [&str; 2],
        predictions: &[Prediction],
    ) -> String {
        let mut body = String::new();
        let values = self
            .rows
            .iter()
            .flat_map(|&row| &lists[row])
            .chain(predictions.iter().flat_map(|p| &p.line).map(|point| &point[1]));
        let high = values.copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
        let margin = self.margin();
        let (label, unit) = (self.axis.key.clone(), self.axis.unit.clone());
        let x = Scale {
            label,
            unit,
            range: [self.axis.value(-margin), self.axis.value(1.0 + margin)],
            log: self.axis.log,
        };
        let frame = Frame {
            place: PLOT,
            x,
            y: Scale {
                label: what.into(),
                unit: unit_of_y.into(),
                range: [0.0, if high > 0.0 { 1.06 * high } else { 1.0 }],
                log: false,
            },
        };
        let mut points = String::new();
        for &row in &self.rows {
            let Some(at) = self.at[row] else { continue };
            for &value in &lists[row] {
                let [x, y] = frame.at([at, value]);
                let _ = write!(points, "M{x:.1} {y:.1}h.01");
            }
        }
        let diameter = (POINT_SHARE * PLOT.width / self.rows.len().max(1) as f64).clamp(POINT[0], POINT[1]);
        let _ = write!(
            body,
            "<path d=\"{points}\" stroke=\"#0072b2\" stroke-width=\"{diameter:.1}\" \
             stroke-linecap=\"round\" stroke-opacity=\"0.75\"/>"
        );
        frame.clip(&mut body, "plot");
        for prediction in predictions {
            frame.line(&mut body, "plot", &prediction.line, prediction.dashed);
        }
        for [x, y, width, _, row] in self.places() {
            let colour = of_outcome(&outcomes[row as usize]);
            let _ = write!(
                body,
                "<rect x=\"{x:.2}\" y=\"{y:.1}\" width=\"{:.2}\" height=\"{BAND}\" fill=\"{colour}\"/>",
                width + 0.15
            );
        }
        self.legend(&mut body, outcomes);
        frame.draw(&mut body, "");
        image(WIDTH, PLOT.y + PLOT.height + 56.0, &body)
    }

    /// Names the colours of the band, in lines above it.
    fn legend(&self, body: &mut String, outcomes: &[String]) {
        for (x, y, colour, label) in self.entries(outcomes) {
            let _ = write!(body, "<g transform=\"translate({x:.1} {:.1})\">{}</g>", y - 11.0, swatch(colour));
            text_at(body, [x + ENTRY, y], "start", 12, INK, label);
        }
    }

    /// Places of the swatches of the outcomes that occur, with colours and names.
    fn entries(&self, outcomes: &[String]) -> Vec<(f64, f64, &'static str, &'static str)> {
        let known = Outcome::ALL.map(|(outcome, name)| (name, outcome.words()));
        let known = known.into_iter().chain([("error", "failed")]);
        let met = known.filter(|(name, _)| self.rows.iter().any(|&row| outcomes[row] == *name));
        let (mut x, mut y) = (PLOT.x, 0.0);
        let mut found = Vec::new();
        for (name, label) in met {
            let width = ENTRY + LETTER * label.chars().count() as f64 + GAP;
            if x > PLOT.x && x + width > WIDTH {
                (x, y) = (PLOT.x, y + LEGEND_ROW);
            }
            found.push((x, y, of_outcome(name), label));
            x += width;
        }
        for (_, line, ..) in &mut found {
            *line += LEGEND_Y - y;
        }
        found
    }
}
