//! The page of one run.

use feeler_scenarios::format::Document;
use feeler_scenarios::run::{EnergyItem, RunResult, Summary};

use crate::numbers::{count, percent, plain, prefix, split, with_unit};
use crate::page::{Chart, ChartKind, Line, Mark, Page, Series, Tile, by_extremes, by_steps};
use crate::words;

/// Rows of the charts over the whole run; with a dozen curves that is a page of about 1 MB.
const MOST_ROWS: usize = 6_000;
/// Curves beyond this many take rows from each other.
const CURVES_AT_FULL_ROWS: usize = 16;
/// Points of the phase portrait.
const MOST_PATH_POINTS: usize = 6_000;
/// Points of the spectrum.
const MOST_LINES: usize = 3_000;
/// Cycles in the close-up.
const CYCLES: f64 = 6.0;
/// Events listed; more are in the summary.
const MOST_EVENTS: usize = 400;
/// Contact spans that are shaded; beyond this they are narrower than a pixel.
const MOST_BANDS: usize = 4_000;

/// The page of a run.
pub(crate) fn page(document: &Document, settings: &[String], result: &RunResult) -> anyhow::Result<String> {
    let summary = &result.summary;
    let machine = &document.scenario.machine;
    let mut page = Page::new(&machine.name, &machine.about);
    page.lead(&words::outcome(summary));
    page.tiles(&tiles(summary));
    let view = View::new(document, result);
    view.whole_run(&mut page);
    view.close_up(&mut page);
    view.phase_portrait(&mut page);
    view.spectrum(&mut page);
    energy(&mut page, summary);
    events(&mut page, summary);
    page.heading("Scenario");
    if !settings.is_empty() {
        page.paragraph(&format!("Set on the command line: {}", settings.join("; ")));
    }
    page.verbatim("the file as it was run", document.text());
    Ok(page.render())
}

fn tiles(summary: &Summary) -> Vec<Tile> {
    let tile = |name, value: String, remark: String| Tile { name, value, remark };
    let mut tiles = vec![tile("outcome", words::outcome_label(summary.outcome).into(), String::new())];
    let hardest = summary.contacts.iter().max_by(|a, b| a.peak_force_n.total_cmp(&b.peak_force_n));
    if let Some(contact) = hardest {
        tiles.push(tile("peak force", with_unit(contact.peak_force_n, "N"), format!("at {}", with_unit(contact.peak_at_s, "s"))));
    }
    if let Some(response) = summary.response {
        let of = response.final_reference_n.map_or_else(String::new, |reference| format!("of {}", with_unit(reference, "N")));
        tiles.push(tile("overshoot", response.overshoot.map_or("-".into(), |share| format!("{} %", percent(share))), of));
        let band = format!("to within {}", with_unit(response.band_n, "N"));
        let time = response.settling_time_s.map_or("not settled".into(), |time| with_unit(time, "s"));
        tiles.push(tile("settling time", time, band));
    }
    if !summary.contacts.is_empty() {
        tiles.push(tile("bounces", summary.bounces.to_string(), "times the tool left the workpiece".into()));
        let share = format!("{} % of the run", percent(summary.contact_share));
        tiles.push(tile("time in contact", with_unit(summary.contact_time_s, "s"), share));
    }
    if let Some(oscillation) = &summary.oscillation {
        let impacts = format!("{} impacts per second", plain(oscillation.impacts_per_s));
        tiles.push(tile("frequency", with_unit(oscillation.frequency_hz, "Hz"), impacts));
        tiles.push(tile("amplitude", with_unit(oscillation.amplitude_n, "N"), "half of peak to peak".into()));
    }
    tiles.push(tile("at a limit", format!("{} %", percent(summary.saturation_share)), "of the controller samples".into()));
    tiles.push(tile("energy balance", plain(summary.energy.relative_residual), "residual over energy exchanged".into()));
    tiles
}

/// A run as its charts see it.
struct View<'a> {
    document: &'a Document,
    result: &'a RunResult,
    /// Rows of the record that are shown over the whole run.
    rows: Vec<usize>,
}

impl<'a> View<'a> {
    fn new(document: &'a Document, result: &'a RunResult) -> Self {
        let columns: Vec<&[f64]> = result.record.columns.iter().map(Vec::as_slice).collect();
        let most = MOST_ROWS * CURVES_AT_FULL_ROWS / columns.len().max(CURVES_AT_FULL_ROWS);
        Self { document, result, rows: by_extremes(&columns, result.record.t_s.len(), most) }
    }

    fn times(&self, rows: &[usize]) -> Vec<f64> {
        rows.iter().map(|&row| self.result.record.t_s[row]).collect()
    }

    /// A signal at some rows, scaled.
    fn series(&self, signal: &str, rows: &[usize], scale: f64, unit: &str) -> Option<Series> {
        let column = self.result.record.column(signal)?;
        Some(Series::new(signal, unit, rows.iter().map(|&row| column[row] / scale).collect()))
    }

    fn bands(&self, from_s: f64, to_s: f64) -> Vec<[f64; 2]> {
        let main = self.result.summary.main_contact.map(|i| &self.result.contacts[i]);
        let spans = main.into_iter().flat_map(|contact| &contact.intervals);
        spans.filter(|span| span.end_s >= from_s && span.start_s <= to_s).map(|span| [span.start_s, span.end_s]).take(MOST_BANDS).collect()
    }

    fn whole_run(&self, page: &mut Page) {
        page.heading("The run");
        page.paragraph(
            "Drag across a chart to zoom, all charts over time follow; double-click to see the whole again. Shaded: in contact.",
        );
        page.axis("run", &self.times(&self.rows));
        let end_s = self.result.record.t_s.last().copied().unwrap_or(0.0);
        let bands = self.bands(0.0, end_s);
        for mut chart in [self.force_chart(&self.rows), self.drive_chart(&self.rows), self.position_chart(&self.rows)].into_iter().flatten()
        {
            chart.x_axis = Some("run");
            chart.bands.clone_from(&bands);
            page.chart(&chart);
        }
        let others = self.other_charts(&self.rows);
        if !others.is_empty() {
            page.heading("Other recorded signals");
        }
        for mut chart in others {
            chart.x_axis = Some("run");
            page.chart(&chart);
        }
    }

    fn force_chart(&self, rows: &[usize]) -> Option<Chart> {
        let mut chart = Chart::new(ChartKind::Line, "Contact force.", "time (s)", "force (N)");
        let signals = self.result.contacts.iter().map(feeler_scenarios::run::ContactRun::force_signal);
        chart.series.extend(signals.filter_map(|signal| self.series(&signal, rows, 1.0, "N")));
        if let Some(reference) = self.result.force_loop.as_ref().and_then(|found| self.series(&found.reference_signal(), rows, 1.0, "N")) {
            chart.series.push(reference.dashed());
            chart.caption = "What the tool feels, and what the controller wants.".into();
        }
        (!self.result.contacts.is_empty()).then_some(chart)
    }

    fn drive_chart(&self, rows: &[usize]) -> Option<Chart> {
        let actuators = &self.document.scenario.machine.actuators;
        let mut chart = Chart::new(ChartKind::Line, "Drive.", "time (s)", "command, force (N)");
        for (name, actuator) in actuators {
            let is_force = matches!(actuator.kind, feeler_plant::description::ActuatorKind::Force { .. });
            let unit = if is_force { "N" } else { "m/s" };
            chart.series.extend(self.series(&format!("{name}.command"), rows, 1.0, unit));
            chart.series.extend(self.series(&format!("{name}.force"), rows, 1.0, "N"));
            if !is_force {
                chart.y_label = "command (m/s), force (N)".into();
            }
            if let Some(limit) = actuator.limit_n.filter(|_| self.result.saturated.iter().any(|&flag| flag)) {
                chart.lines.push(Line { y: limit, label: format!("limit {}", with_unit(limit, "N")) });
                chart.lines.push(Line { y: -limit, label: format!("limit {}", with_unit(-limit, "N")) });
            }
        }
        chart.caption = "The command as the controller issues it, and the force that the drive makes of it.".into();
        (!actuators.is_empty()).then_some(chart)
    }

    fn position_chart(&self, rows: &[usize]) -> Option<Chart> {
        let signals: Vec<String> = self.document.scenario.machine.bodies.keys().map(|name| format!("{name}.position")).collect();
        let columns = signals.iter().filter_map(|signal| self.result.record.column(signal));
        let largest = columns.flatten().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        let (scale, name) = prefix(largest);
        let unit = format!("{name}m");
        let mut chart = Chart::new(ChartKind::Line, "Positions.", "time (s)", format!("position ({unit})"));
        chart.series.extend(signals.iter().filter_map(|signal| self.series(signal, rows, scale, &unit)));
        (!chart.series.is_empty()).then_some(chart)
    }

    /// What the file asks for and no chart shows yet, one chart per quantity.
    fn other_charts(&self, rows: &[usize]) -> Vec<Chart> {
        let shown = ["force", "command", "position", "contact", "reference", "compression", "velocity"];
        let mut charts: Vec<(String, Chart)> = Vec::new();
        for signal in &self.result.trace.names {
            let quantity = signal.rsplit('.').next().unwrap_or_default().to_owned();
            if shown.contains(&quantity.as_str()) {
                continue;
            }
            let Some(series) = self.series(signal, rows, 1.0, "") else { continue };
            // Readings of different sensors have different units, so each has a chart of its own.
            let key = if quantity == "reading" { signal.clone() } else { quantity.clone() };
            let place = charts.iter().position(|(known, _)| *known == key).unwrap_or_else(|| {
                let chart = Chart::new(ChartKind::Line, format!("{key}."), "time (s)", format!("{} (SI)", quantity.replace('_', " ")));
                charts.push((key, chart));
                charts.len() - 1
            });
            charts[place].1.series.push(series);
        }
        charts.into_iter().map(|(_, chart)| chart).collect()
    }

    /// The last cycles of an oscillation that lasts, row by row.
    fn close_up(&self, page: &mut Page) {
        let Some(oscillation) = self.result.summary.oscillation.filter(|oscillation| oscillation.frequency_hz > 0.0) else { return };
        let t_s = &self.result.record.t_s;
        let end_s = t_s.last().copied().unwrap_or(0.0);
        let from_s = end_s - CYCLES / oscillation.frequency_hz;
        let first = t_s.partition_point(|&t| t < from_s);
        let columns: Vec<&[f64]> = self.result.record.columns.iter().map(|column| &column[first..]).collect();
        let rows: Vec<usize> = by_extremes(&columns, t_s.len() - first, MOST_LINES).into_iter().map(|row| first + row).collect();
        page.heading("The last cycles");
        page.axis("end", &self.times(&rows));
        let bands = self.bands(from_s, end_s);
        for mut chart in [self.force_chart(&rows), self.drive_chart(&rows)].into_iter().flatten() {
            chart.x_axis = Some("end");
            chart.bands.clone_from(&bands);
            page.chart(&chart);
        }
    }

    fn phase_portrait(&self, page: &mut Page) {
        let Some(contact) = self.result.summary.main_contact.map(|i| &self.result.contacts[i]) else { return };
        let Some(compression) = self.result.record.column(&format!("{}.compression", contact.name)) else { return };
        let rows = self.result.tail_rows();
        let t_s = &self.result.record.t_s;
        // Central differences: rows are close to each other, and the velocities of two bodies need not both be recorded.
        let inner = rows.start.max(1)..rows.end.min(t_s.len().saturating_sub(1));
        let rate = |row: usize| (compression[row + 1] - compression[row - 1]) / (t_s[row + 1] - t_s[row - 1]);
        let (x, y): (Vec<f64>, Vec<f64>) = inner.map(|row| (compression[row], rate(row))).unzip();
        let largest = |values: &[f64]| values.iter().fold(0.0, |largest: f64, v| largest.max(v.abs()));
        let ((x_scale, x_unit), (y_scale, y_unit)) = (prefix(largest(&x)), prefix(largest(&y)));
        let kept = by_steps(&x, &y, MOST_PATH_POINTS);
        if kept.len() < 2 {
            return;
        }
        page.heading("Phase portrait");
        let (x_label, y_label) = (format!("compression ({x_unit}m)"), format!("rate of compression ({y_unit}m/s)"));
        let mut chart = Chart::new(ChartKind::Path, "Compression against its rate,", &x_label, y_label);
        chart.caption = format!(
            "over the tail of the run, {}. Left of zero the tool is off the workpiece; a closed loop is an oscillation that lasts.",
            self.tail()
        );
        chart.x = kept.iter().map(|&i| x[i] / x_scale).collect();
        chart.series =
            vec![Series::new(contact.name.clone(), format!("{x_unit}m, {y_unit}m/s"), kept.iter().map(|&i| y[i] / y_scale).collect())];
        page.chart(&chart);
    }

    fn spectrum(&self, page: &mut Page) {
        let Some(spectrum) = self.result.tail_spectrum() else { return };
        let positive = |i: &usize| spectrum.frequencies_hz[*i] > 0.0 && spectrum.amplitudes[*i] > 0.0;
        let shown: Vec<usize> = (0..spectrum.amplitudes.len()).filter(positive).collect();
        let amplitudes: Vec<f64> = shown.iter().map(|&i| spectrum.amplitudes[i]).collect();
        let Some(strongest) = (0..amplitudes.len()).max_by(|&i, &j| amplitudes[i].total_cmp(&amplitudes[j])) else { return };
        let kept = by_extremes(&[&amplitudes], amplitudes.len(), MOST_LINES);
        page.heading("Spectrum");
        let mut chart = Chart::new(ChartKind::Line, "Amplitude of the contact force,", "frequency (Hz)", "amplitude (N)");
        chart.caption = format!("over the tail of the run, {} (Hann window).", self.tail());
        (chart.x_log, chart.y_log) = (true, true);
        chart.x = kept.iter().map(|&i| spectrum.frequencies_hz[shown[i]]).collect();
        chart.series = vec![Series::new("amplitude", "N", kept.iter().map(|&i| amplitudes[i]).collect())];
        let frequency = self.result.summary.oscillation.and_then(|oscillation| oscillation.spectral_hz);
        let frequency = frequency.unwrap_or(spectrum.frequencies_hz[shown[strongest]]);
        let (x, y) = (spectrum.frequencies_hz[shown[strongest]], amplitudes[strongest]);
        chart.marks.push(Mark { x, y, label: format!("{}, {}", with_unit(frequency, "Hz"), with_unit(y, "N")) });
        page.chart(&chart);
    }

    fn tail(&self) -> String {
        let [from, to] = self.result.summary.verdict.tail_s;
        format!("{} to {}", with_unit(from, "s"), with_unit(to, "s"))
    }
}

fn energy(page: &mut Page, summary: &Summary) {
    let energy = &summary.energy;
    page.heading("Energy");
    page.paragraph("What each element put in (blue) and took out (orange), and what is stored more at the end than at the start.");
    let bar = |sign: f64| {
        move |item: &EnergyItem| {
            (format!("{}, {}", item.what.replace('-', " "), item.on), sign * item.joule, with_unit(sign * item.joule, "J"))
        }
    };
    let growth = |name: &str, [first, last]: [f64; 2]| (name.to_owned(), first - last, with_unit(last - first, "J"));
    let bars: Vec<_> = (energy.supplied.iter().map(bar(1.0)))
        .chain(energy.dissipated.iter().map(bar(-1.0)))
        .chain([growth("kinetic energy gained", energy.kinetic), growth("elastic energy gained", energy.elastic)])
        .collect();
    page.bars(&bars);
    let row = |item: &EnergyItem| vec![item.what.replace('-', " "), item.on.clone(), split(item.joule, "J").0, split(item.joule, "J").1];
    let controllers: Vec<Vec<String>> = energy.controllers.iter().map(row).collect();
    if !controllers.is_empty() {
        page.table(&["part of it", "by", "energy", "unit"], &[2], &controllers);
    }
    page.paragraph(&format!(
        "The books close to {} of {} exchanged, a share of {}.",
        with_unit(energy.residual.abs(), "J"),
        with_unit(energy.exchanged, "J"),
        plain(energy.relative_residual)
    ));
}

fn events(page: &mut Page, summary: &Summary) {
    page.heading("Events");
    if summary.events.is_empty() {
        page.paragraph("Nothing touched, lifted, stuck, slipped or met a limit.");
        return;
    }
    let shown = summary.events.len().min(MOST_EVENTS);
    if shown < summary.events.len() {
        page.paragraph(&format!("The first {shown} of {}; summary.json has all.", count(summary.events.len(), "event", "events")));
    }
    let row = |event: &feeler_scenarios::run::EventRecord| vec![format!("{:.9}", event.t_s), event.what.to_owned(), event.on.clone()];
    page.table(&["time (s)", "what", "on"], &[0], &summary.events[..shown].iter().map(row).collect::<Vec<_>>());
}
