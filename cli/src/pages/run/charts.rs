//! The charts of a run.

mod surface;

use std::ops::Range;

use feeler_engine::ControllerUse;
use feeler_files::Document;
use feeler_plant::description::{Actuator, ActuatorKind, Elements, Machine, Quantity, SignalName};
use feeler_studies::run::{ContactRun, RunResult};

use crate::numbers::{prefix, with_unit};
use crate::pages::parts::{Chart, ChartKind, Line, MOST_VALUES, Mark, Page, Series, by_extremes, by_steps};
use crate::units::Units;

/// Largest number of rows of a live chart.
const OVERVIEW_ROWS: usize = 2_000;
/// Points of the phase portrait.
const MOST_PATH_POINTS: usize = 6_000;
/// The spectrum extends at least to this harmonic of the strongest line.
const HARMONICS: f64 = 30.0;
/// Share of the strongest line above which a line is shown at any frequency.
const TELLING_SHARE: f64 = 1e-3;
/// Amplitudes below this share of the force are rounding errors. A spectrum with smaller amplitudes only is
/// not shown.
const ROUNDING_SHARE: f64 = 1e-9;
/// Points of the spectrum.
const MOST_LINES: usize = 3_000;
/// Number of cycles in the close-up.
const CYCLES: f64 = 6.0;
/// Largest number of shaded contact spans; more would be narrower than a pixel.
const MOST_BANDS: usize = 4_000;
/// The horizontal axis of every chart over time.
const TIME: &str = "time (s)";

/// A signal in a chart.
struct Curve {
    signal: String,
    unit: String,
    /// SI value of one displayed unit.
    scale: f64,
    dashed: bool,
}

impl Curve {
    fn new(signal: impl Into<String>, unit: &str) -> Self {
        Self { signal: signal.into(), unit: unit.to_owned(), scale: 1.0, dashed: false }
    }
}

/// The data of a run for its charts.
pub(super) struct View<'a> {
    machine: &'a Machine,
    controllers: &'a Elements<ControllerUse>,
    result: &'a RunResult,
    units: Units,
    most_rows: usize,
}

impl<'a> View<'a> {
    pub(super) fn new(document: &'a Document, result: &'a RunResult, units: Units) -> Self {
        let curves = result.record.names.len().max(1);
        let scenario = &document.scenario;
        Self {
            machine: &scenario.machine,
            controllers: &scenario.controllers,
            result,
            units,
            most_rows: MOST_VALUES / curves,
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
            "Drag across a chart to zoom; all charts over time follow. Double-click to see the whole run. \
             Shaded: in contact.",
        );
        let rows = 0..self.t_s().len();
        if rows.len() > self.most_rows {
            page.paragraph(&format!(
                "The page shows about {} of {} recorded rows, with every peak; trace.parquet has all.",
                self.most_rows,
                rows.len()
            ));
        }
        let bands = self.bands(&rows);
        for mut chart in self.forces(&rows).into_iter().chain(self.drives(&rows)) {
            chart.together = Some("run");
            chart.bands.clone_from(&bands);
            page.chart(&chart);
        }
    }

    /// Force and drive over the whole run, at the resolution of a screen.
    pub(super) fn overview(mut self) -> Vec<Chart> {
        self.most_rows = OVERVIEW_ROWS;
        let rows = 0..self.t_s().len();
        let bands = self.bands(&rows);
        let charts = self.forces(&rows).into_iter().chain(self.drives(&rows));
        charts.map(|chart| Chart { bands: bands.clone(), together: Some("run"), ..chart }).collect()
    }

    /// Positions of the bodies over the whole run.
    pub(super) fn motion(&self, page: &mut Page) {
        let rows = 0..self.t_s().len();
        let Some(mut chart) = self.positions(&rows) else { return };
        page.heading("Motion");
        chart.together = Some("run");
        chart.bands = self.bands(&rows);
        page.chart(&chart);
    }

    /// Signals requested by the file that no other chart shows.
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

    /// The last cycles of a sustained oscillation.
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

    /// Spans of time in which the main contact was closed.
    fn bands(&self, rows: &Range<usize>) -> Vec<[f64; 2]> {
        let Some([from_s, .., to_s]) = self.t_s().get(rows.clone()) else { return Vec::new() };
        let spans = self.main_contact().into_iter().flat_map(|contact| &contact.intervals);
        let shown = spans.filter(|span| span.end_s >= *from_s && span.start_s <= *to_s);
        shown.map(|span| [span.start_s.max(*from_s), span.end_s.min(*to_s)]).take(MOST_BANDS).collect()
    }

    /// A chart of some signals over some rows; `None` if none of them was recorded.
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
        (!chart.series.is_empty()).then(|| chart.without_rounding())
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
            "The contact force and its reference."
        } else {
            "The force on the tool."
        };
        curves.extend(reference);
        let chart = self.over_time("Contact force.", format!("force ({force})"), rows, curves)?;
        Some(Chart { caption: caption.into(), ..chart })
    }

    /// Commands and forces. Commands that are not forces have their own charts.
    fn drives(&self, rows: &Range<usize>) -> Vec<Chart> {
        let force = self.units.force;
        let (mut forces, mut commands, mut lines) = (Vec::new(), Vec::new(), Vec::new());
        for (name, actuator) in &self.machine.actuators {
            let command = format!("{name}.command");
            if !actuator.kind.feeds_servo() {
                forces.push(Curve::new(format!("{name}.force"), force));
            }
            // Dashed and above the force, because the two coincide for a fast drive.
            if matches!(actuator.kind, ActuatorKind::Force { .. }) {
                forces.push(Curve { dashed: true, ..Curve::new(command, force) });
            } else {
                commands.extend(self.command(name, actuator, rows));
            }
            if let Some(limit) = actuator.limit_n.filter(|_| self.result.saturated.iter().any(|&flag| flag)) {
                lines.extend(
                    [limit, -limit].map(|y| Line { y, label: format!("limit {}", with_unit(y, force)) }),
                );
            }
        }
        let (quantity, caption) = if forces.iter().any(|curve| curve.dashed) {
            ("command, force", "The controller's command and the drive's force.")
        } else {
            ("force", "The drive's force.")
        };
        let force = self.over_time("Drive.", format!("{quantity} ({force})"), rows, forces);
        let force = force.map(|chart| Chart { caption: caption.into(), lines, ..chart });
        commands.into_iter().chain(force).collect()
    }

    /// The command of a drive, if it is not a force. A position command is shown with the motion.
    fn command(&self, name: &str, actuator: &Actuator, rows: &Range<usize>) -> Option<Chart> {
        let unit = self.units.command(actuator);
        let is_target = matches!(actuator.kind, ActuatorKind::PositionServo(_) | ActuatorKind::Imposed);
        let position = SignalName::new(&actuator.on, Quantity::Position).to_string();
        let moved = Some(Curve::new(position, unit)).filter(|_| is_target);
        let asked = Curve { dashed: is_target, ..Curve::new(format!("{name}.command"), unit) };
        let label = if unit.is_empty() { "command".into() } else { format!("command ({unit})") };
        let chart = self.over_time(
            &format!("Command of {name}."),
            label,
            rows,
            moved.into_iter().chain([asked]).collect(),
        );
        let caption =
            if is_target { "The commanded position, and the motion." } else { "The command of the drive." };
        chart.map(|chart| Chart { caption: caption.into(), ..chart })
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
        let names = self.result.trace.names.iter().filter(|name| !self.is_drawn(name));
        let names = names.filter_map(|name| name.parse::<SignalName>().ok());
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

    /// Whether another chart shows the same numbers under another name. This holds for readings of ideal
    /// sensors, and for outputs of controllers.
    fn is_drawn(&self, signal: &str) -> bool {
        let record = &self.result.record;
        let commands = self.machine.actuators.keys().map(|name| format!("{name}.command"));
        let forces = self.result.contacts.iter().map(ContactRun::force_signal);
        let same = |other: &[f64]| record.column(signal).is_some_and(|own| own == other);
        commands.chain(forces).any(|drawn| drawn != signal && record.column(&drawn).is_some_and(same))
    }

    /// Unit of a controller's output: that of its drive's command.
    fn output_unit(&self, controller: &str) -> &'static str {
        let drive =
            self.controllers.get(controller).and_then(|used| self.machine.actuators.get(&used.drives));
        drive.map_or("", |drive| self.units.command(drive))
    }

    /// Compression over its rate.
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
        // The rate follows from central differences, because velocities may not be recorded.
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
            "{span}. Left of zero the tool is off the workpiece. A closed loop is a sustained oscillation."
        );
        chart.x = kept.iter().map(|&i| x[i] / x_scale).collect();
        let y = kept.iter().map(|&i| y[i] / y_scale).collect();
        chart.series = vec![Series::new(contact.name.clone(), format!("{x_unit}, {y_unit}"), y)];
        page.chart(&chart);
    }

    /// The spectrum of the force, with its strongest line marked.
    pub(super) fn spectrum(&self, page: &mut Page) {
        let Some(spectrum) = self.result.tail_spectrum() else { return };
        let positive = |i: &usize| spectrum.frequencies_hz[*i] > 0.0 && spectrum.amplitudes[*i] > 0.0;
        let lines = 0..spectrum.amplitudes.len();
        let largest = lines
            .clone()
            .filter(positive)
            .max_by(|&i, &j| spectrum.amplitudes[i].total_cmp(&spectrum.amplitudes[j]));
        let Some(largest) = largest else { return };
        let floor = ROUNDING_SHARE * self.tail_force();
        if spectrum.amplitudes[largest] <= floor {
            page.heading("Spectrum");
            page.paragraph(&format!(
                "The force is at rest {}, so there is no spectrum. Its strongest line is below 1e-9 of the \
                 force, which is rounding.",
                self.tail()
            ));
            return;
        }
        // Above both frequencies the spectrum is only noise.
        let least = TELLING_SHARE * spectrum.amplitudes[largest];
        let highest = lines.clone().rev().find(|&i| spectrum.amplitudes[i] >= least).unwrap_or(largest);
        let highest_hz = spectrum.frequencies_hz[highest].max(HARMONICS * spectrum.frequencies_hz[largest]);
        let shown: Vec<usize> =
            lines.filter(positive).filter(|&i| spectrum.frequencies_hz[i] <= highest_hz).collect();
        let amplitudes: Vec<f64> = shown.iter().map(|&i| spectrum.amplitudes[i].max(floor)).collect();
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
        // The summary has more accurate values, interpolated between the lines of the transform.
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

    /// Largest force of the main contact in the tail of the run.
    fn tail_force(&self) -> f64 {
        let force =
            self.main_contact().and_then(|contact| self.result.record.column(&contact.force_signal()));
        let tail = force.and_then(|force| force.get(self.result.tail_rows())).unwrap_or_default();
        tail.iter().fold(0.0, |largest: f64, f| largest.max(f.abs()))
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
