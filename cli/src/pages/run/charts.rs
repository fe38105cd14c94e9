//! The charts of a run.

use std::ops::Range;

use feeler_engine::ControllerUse;
use feeler_files::Document;
use feeler_plant::description::{ActuatorKind, Elements, Machine, Quantity, SignalName};
use feeler_studies::run::{ContactRun, RunResult};

use crate::numbers::{prefix, with_unit};
use crate::pages::parts::{Chart, ChartKind, Line, Mark, Page, Series, by_extremes, by_steps};
use crate::units::Units;

/// Rows of a chart over the whole run; ten charts of two curves are then a page of about 1.5 MB.
const MOST_ROWS: usize = 6_000;
/// Where there are more charts than this they have fewer rows each.
const CHARTS_AT_FULL_ROWS: usize = 10;
/// Points of the phase portrait.
const MOST_PATH_POINTS: usize = 6_000;
/// Harmonics of the strongest line that the spectrum goes up to at least.
const HARMONICS: f64 = 30.0;
/// Lines of this share of the strongest are shown whatever their frequency.
const TELLING_SHARE: f64 = 1e-3;
/// Points of the spectrum.
const MOST_LINES: usize = 3_000;
/// Cycles in the close-up.
const CYCLES: f64 = 6.0;
/// Contact spans that are shaded; beyond this they are narrower than a pixel.
const MOST_BANDS: usize = 4_000;
/// The horizontal axis of every chart over time.
const TIME: &str = "time (s)";

/// A signal as a chart shows it.
struct Curve {
    signal: String,
    unit: String,
    /// What one unit shown is in SI.
    scale: f64,
    dashed: bool,
}

impl Curve {
    fn new(signal: impl Into<String>, unit: &str) -> Self {
        Self { signal: signal.into(), unit: unit.to_owned(), scale: 1.0, dashed: false }
    }
}

/// A run as its charts see it.
pub(super) struct View<'a> {
    machine: &'a Machine,
    controllers: &'a Elements<ControllerUse>,
    result: &'a RunResult,
    units: Units,
    most_rows: usize,
}

impl<'a> View<'a> {
    pub(super) fn new(document: &'a Document, result: &'a RunResult, units: Units) -> Self {
        let charts = result.trace.names.len().max(CHARTS_AT_FULL_ROWS);
        let scenario = &document.scenario;
        Self {
            machine: &scenario.machine,
            controllers: &scenario.controllers,
            result,
            units,
            most_rows: MOST_ROWS * CHARTS_AT_FULL_ROWS / charts,
        }
    }

    fn t_s(&self) -> &'a [f64] {
        &self.result.record.t_s
    }

    fn main_contact(&self) -> Option<&'a ContactRun> {
        self.result.summary.main_contact.map(|i| &self.result.contacts[i])
    }

    /// Charts over the whole run.
    pub(super) fn whole_run(&self, page: &mut Page) {
        page.heading("The run");
        page.paragraph(
            "Drag across a chart to zoom, all charts over time follow; double-click to see the whole again. Shaded: in contact.",
        );
        let rows = 0..self.t_s().len();
        let bands = self.bands(&rows);
        for mut chart in self.forces(&rows).into_iter().chain(self.drives(&rows)) {
            chart.together = Some("run");
            chart.bands.clone_from(&bands);
            page.chart(&chart);
        }
    }

    /// Where the bodies are over the whole run.
    pub(super) fn motion(&self, page: &mut Page) {
        let rows = 0..self.t_s().len();
        let Some(mut chart) = self.positions(&rows) else { return };
        page.heading("Motion");
        chart.together = Some("run");
        chart.bands = self.bands(&rows);
        page.chart(&chart);
    }

    /// What the file asks for and no other chart shows.
    pub(super) fn others(&self, page: &mut Page) {
        let others = self.other_charts(&(0..self.t_s().len()));
        if others.is_empty() {
            return;
        }
        page.heading("Other recorded signals");
        for mut chart in others {
            chart.together = Some("run");
            page.chart(&chart);
        }
    }

    /// The last cycles of an oscillation that lasts.
    pub(super) fn close_up(&self, page: &mut Page) {
        let Some(oscillation) =
            self.result.summary.oscillation.filter(|oscillation| oscillation.frequency_hz > 0.0)
        else {
            return;
        };
        let end_s = self.t_s().last().copied().unwrap_or(0.0);
        let from_s = end_s - CYCLES / oscillation.frequency_hz;
        let rows = self.t_s().partition_point(|&t| t < from_s)..self.t_s().len();
        page.heading("The last cycles");
        let bands = self.bands(&rows);
        for mut chart in self.forces(&rows).into_iter().chain(self.drives(&rows)) {
            chart.together = Some("end");
            chart.bands.clone_from(&bands);
            page.chart(&chart);
        }
    }

    /// When the main contact pushed.
    fn bands(&self, rows: &Range<usize>) -> Vec<[f64; 2]> {
        let Some([from_s, .., to_s]) = self.t_s().get(rows.clone()) else { return Vec::new() };
        let spans = self.main_contact().into_iter().flat_map(|contact| &contact.intervals);
        let shown = spans.filter(|span| span.end_s >= *from_s && span.start_s <= *to_s);
        shown.map(|span| [span.start_s.max(*from_s), span.end_s.min(*to_s)]).take(MOST_BANDS).collect()
    }

    /// A chart of some signals over some rows; none where none of them was recorded.
    fn over_time(
        &self,
        title: &str,
        y_label: String,
        rows: &Range<usize>,
        curves: Vec<Curve>,
    ) -> Option<Chart> {
        let curves: Vec<(Curve, &[f64])> = curves
            .into_iter()
            .filter_map(|curve| Some((self.result.record.column(&curve.signal)?, curve)))
            .map(|(c, curve)| (curve, &c[rows.clone()]))
            .collect();
        let columns: Vec<&[f64]> = curves.iter().map(|(_, column)| *column).collect();
        let kept = by_extremes(&columns, rows.len(), self.most_rows);
        let mut chart = Chart::new(ChartKind::Line, title, TIME, y_label);
        chart.x = kept.iter().map(|&row| self.t_s()[rows.start + row]).collect();
        chart.series = (curves.into_iter())
            .map(|(curve, column)| {
                let series = Series::new(
                    curve.signal,
                    curve.unit,
                    kept.iter().map(|&row| column[row] / curve.scale).collect(),
                );
                if curve.dashed { series.dashed() } else { series }
            })
            .collect();
        (!chart.series.is_empty()).then_some(chart)
    }

    fn forces(&self, rows: &Range<usize>) -> Option<Chart> {
        let force = self.units.force;
        let mut curves: Vec<Curve> =
            self.result.contacts.iter().map(|contact| Curve::new(contact.force_signal(), force)).collect();
        if curves.is_empty() {
            return None;
        }
        let reference = self
            .result
            .force_loop
            .as_ref()
            .map(|found| Curve { dashed: true, ..Curve::new(found.reference_signal(), force) });
        let caption = if reference.is_some() {
            "What the tool feels, and what the controller wants."
        } else {
            "What the tool feels."
        };
        curves.extend(reference);
        let chart = self.over_time("Contact force.", format!("force ({force})"), rows, curves)?;
        Some(Chart { caption: caption.into(), ..chart })
    }

    /// Commands and forces; of velocity sources the commands, which have another unit, apart.
    fn drives(&self, rows: &Range<usize>) -> Vec<Chart> {
        let force = self.units.force;
        let (mut forces, mut velocities, mut lines) = (Vec::new(), Vec::new(), Vec::new());
        for (name, actuator) in &self.machine.actuators {
            let command = format!("{name}.command");
            forces.push(Curve::new(format!("{name}.force"), force));
            // Above the force, and dashed: of a quick drive the two are one line.
            if matches!(actuator.kind, ActuatorKind::Force { .. }) {
                forces.push(Curve { dashed: true, ..Curve::new(command, force) });
            } else {
                velocities.push(Curve::new(command, self.units.velocity));
            }
            if let Some(limit) = actuator.limit_n.filter(|_| self.result.saturated.iter().any(|&flag| flag)) {
                lines.extend(
                    [limit, -limit].map(|y| Line { y, label: format!("limit {}", with_unit(y, force)) }),
                );
            }
        }
        let velocity =
            self.over_time("Command.", format!("command ({})", self.units.velocity), rows, velocities);
        let velocity =
            velocity.map(|chart| Chart { caption: "The velocity asked of the drive.".into(), ..chart });
        let caption = "The command as the controller issues it, and the force that the drive makes of it.";
        let force = self.over_time("Drive.", format!("command, force ({force})"), rows, forces);
        let force = force.map(|chart| Chart { caption: caption.into(), lines, ..chart });
        velocity.into_iter().chain(force).collect()
    }

    fn positions(&self, rows: &Range<usize>) -> Option<Chart> {
        let signals: Vec<String> = self
            .machine
            .bodies
            .keys()
            .map(|name| SignalName::new(name, Quantity::Position).to_string())
            .collect();
        let columns = signals.iter().filter_map(|signal| self.result.record.column(signal));
        let (scale, name) = prefix(columns.flatten().fold(0.0, |largest: f64, x| largest.max(x.abs())));
        let unit = format!("{name}{}", self.units.position);
        let curves = signals.into_iter().map(|signal| Curve { scale, ..Curve::new(signal, &unit) }).collect();
        self.over_time("Positions.", format!("position ({unit})"), rows, curves)
    }

    /// One chart for each quantity, and for each sensor.
    fn other_charts(&self, rows: &Range<usize>) -> Vec<Chart> {
        use Quantity::{Acceleration, Output, Reading, SpringForce, Velocity};
        let names = self.result.trace.names.iter().filter_map(|name| name.parse::<SignalName>().ok());
        let mut groups: Vec<(String, String, Vec<Curve>)> = Vec::new();
        for signal in names.filter(|signal| {
            matches!(signal.quantity, SpringForce | Velocity | Acceleration | Reading | Output)
        }) {
            let sensor = self.machine.sensors.get(&signal.element).filter(|_| signal.quantity == Reading);
            let unit = match signal.quantity {
                Output => self.output_unit(&signal.element),
                quantity => self.units.unit(sensor.map_or(quantity, |sensor| sensor.reads.quantity)),
            };
            let quantity = signal.quantity.name().replace('_', " ");
            let title =
                if sensor.is_some() { format!("Reading of {}.", signal.element) } else { capital(&quantity) };
            let label = if unit.is_empty() { quantity } else { format!("{quantity} ({unit})") };
            let curve = Curve::new(signal.to_string(), unit);
            match groups.iter_mut().find(|(known, ..)| *known == title) {
                Some((.., curves)) => curves.push(curve),
                None => groups.push((title, label, vec![curve])),
            }
        }
        groups
            .into_iter()
            .filter_map(|(title, label, curves)| self.over_time(&title, label, rows, curves))
            .collect()
    }

    /// Unit of what a controller puts out: that of its drive's command.
    fn output_unit(&self, controller: &str) -> &'static str {
        let drive =
            self.controllers.get(controller).and_then(|used| self.machine.actuators.get(&used.drives));
        match drive.map(|drive| drive.kind) {
            Some(ActuatorKind::Force { .. }) => self.units.force,
            Some(ActuatorKind::VelocitySource { .. }) => self.units.velocity,
            _ => "",
        }
    }

    /// Compression against its rate.
    pub(super) fn phase_portrait(&self, page: &mut Page) {
        let Some(contact) = self.main_contact() else { return };
        let Some(compression) =
            self.result.record.column(&SignalName::new(&contact.name, Quantity::Compression).to_string())
        else {
            return;
        };
        let t_s = self.t_s();
        let since_touch =
            t_s.partition_point(|&t| contact.first_contact_s().is_some_and(|first| t < first))..t_s.len();
        let lasts = self.result.summary.oscillation.is_some();
        let (rows, span) = if lasts {
            (self.result.tail_rows(), self.tail())
        } else {
            (since_touch, "from the first touch to the end".to_owned())
        };
        // Central differences: rows are close to each other, and the velocities of two bodies need not both
        // be recorded.
        let inner = rows.start.max(1)..rows.end.min(t_s.len().saturating_sub(1));
        let rate = |row: usize| (compression[row + 1] - compression[row - 1]) / (t_s[row + 1] - t_s[row - 1]);
        let (x, y): (Vec<f64>, Vec<f64>) = inner.map(|row| (compression[row], rate(row))).unzip();
        let largest = |values: &[f64]| values.iter().fold(0.0, |largest: f64, v| largest.max(v.abs()));
        let ((x_scale, x_prefix), (y_scale, y_prefix)) = (prefix(largest(&x)), prefix(largest(&y)));
        let kept = by_steps(&x, &y, MOST_PATH_POINTS);
        if kept.len() < 2 {
            return;
        }
        page.heading("Phase portrait");
        let (x_unit, y_unit) =
            (format!("{x_prefix}{}", self.units.position), format!("{y_prefix}{}", self.units.velocity));
        let x_label = format!("compression ({x_unit})");
        let mut chart = Chart::new(
            ChartKind::Path,
            "Compression against its rate,",
            &x_label,
            format!("rate of compression ({y_unit})"),
        );
        chart.caption = format!(
            "{span}. Left of zero the tool is off the workpiece; a closed loop is an oscillation that lasts."
        );
        chart.x = kept.iter().map(|&i| x[i] / x_scale).collect();
        let y = kept.iter().map(|&i| y[i] / y_scale).collect();
        chart.series = vec![Series::new(contact.name.clone(), format!("{x_unit}, {y_unit}"), y)];
        page.chart(&chart);
    }

    /// The spectrum of the force, its strongest line marked.
    pub(super) fn spectrum(&self, page: &mut Page) {
        let Some(spectrum) = self.result.tail_spectrum() else { return };
        let positive = |i: &usize| spectrum.frequencies_hz[*i] > 0.0 && spectrum.amplitudes[*i] > 0.0;
        let lines = 0..spectrum.amplitudes.len();
        let largest = lines
            .clone()
            .filter(positive)
            .max_by(|&i, &j| spectrum.amplitudes[i].total_cmp(&spectrum.amplitudes[j]));
        let Some(largest) = largest else { return };
        // Beyond both there is the floor alone.
        let least = TELLING_SHARE * spectrum.amplitudes[largest];
        let highest = lines.clone().rev().find(|&i| spectrum.amplitudes[i] >= least).unwrap_or(largest);
        let highest_hz = spectrum.frequencies_hz[highest].max(HARMONICS * spectrum.frequencies_hz[largest]);
        let shown: Vec<usize> =
            lines.filter(positive).filter(|&i| spectrum.frequencies_hz[i] <= highest_hz).collect();
        let amplitudes: Vec<f64> = shown.iter().map(|&i| spectrum.amplitudes[i]).collect();
        let strongest = shown.iter().position(|&i| i == largest).unwrap_or(0);
        let kept = by_extremes(&[&amplitudes], amplitudes.len(), MOST_LINES);
        let force = self.units.force;
        page.heading("Spectrum");
        let mut chart = Chart::new(
            ChartKind::Line,
            "Amplitude of the contact force,",
            "frequency (Hz)",
            format!("amplitude ({force})"),
        );
        chart.caption = format!("{} (Hann window).", self.tail());
        (chart.x_log, chart.y_log) = (true, true);
        chart.x = kept.iter().map(|&i| spectrum.frequencies_hz[shown[i]]).collect();
        chart.series = vec![Series::new("amplitude", force, kept.iter().map(|&i| amplitudes[i]).collect())];
        let (x, y) = (spectrum.frequencies_hz[shown[strongest]], amplitudes[strongest]);
        // The summary's figures, found between the lines of the transform, where it has them.
        let oscillation = self.result.summary.oscillation;
        let frequency_hz = oscillation.and_then(|oscillation| oscillation.spectral_hz).unwrap_or(x);
        let amplitude = oscillation.and_then(|oscillation| oscillation.spectral_amplitude_n).unwrap_or(y);
        chart.marks.push(Mark {
            x,
            y,
            label: format!("{}, {}", with_unit(frequency_hz, "Hz"), with_unit(amplitude, force)),
        });
        page.chart(&chart);
    }

    fn tail(&self) -> String {
        let [from, to] = self.result.summary.verdict.tail_s;
        format!("over the tail of the run, {} to {}", with_unit(from, "s"), with_unit(to, "s"))
    }
}

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or_else(String::new, |first| format!("{}{}.", first.to_uppercase(), letters.as_str()))
}
