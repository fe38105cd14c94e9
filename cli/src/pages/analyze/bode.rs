//! Bode's diagrams of loop and plant.

use feeler_analysis::{Curves, Report};
use feeler_lti::C64;

use crate::numbers::plain;
use crate::pages::parts::{Chart, ChartKind, Gauge, Line, Mark, Series};

/// Name shared by charts over frequency, which zoom together.
const TOGETHER: &str = "frequency";

type Response = (&'static str, Option<Vec<C64>>, bool);

/// Magnitude and phase of the open loop, with its margins.
pub(crate) fn open(report: &Report, curves: &Curves) -> Vec<Chart> {
    let open = [("continuous", curves.open.clone(), true), ("sampled", curves.open_sampled.clone(), false)];
    let mut loops = pair(curves, "Open loop,", "broken at the controller, gains as in the file.", &open);
    if let [magnitude, phase] = loops.as_mut_slice() {
        magnitude.lines.push(Line { y: 0.0, label: "0 dB".into() });
        phase.lines.push(Line { y: -180.0, label: "−180°".into() });
        margins(report, magnitude, phase);
    }
    loops
}

/// Magnitude and phase of the closed loop and the plant.
pub(super) fn charts(report: &Report, curves: &Curves) -> Vec<Chart> {
    let closed =
        |open: &Option<Vec<C64>>| open.as_ref().map(|l| l.iter().map(|l| l / (l + 1.0)).collect::<Vec<_>>());
    let both = [("continuous", closed(&curves.open), true), ("sampled", closed(&curves.open_sampled), false)];
    let mut charts = pair(curves, "Closed loop,", "complementary sensitivity, L / (1 + L).", &both);
    let plant = [
        ("continuous, delays exact", Some(curves.plant.clone()), true),
        ("held and sampled", curves.plant_sampled.clone(), false),
    ];
    charts.append(&mut pair(
        curves,
        "Plant,",
        &format!("from {} to {}.", report.input, report.output),
        &plant,
    ));
    charts
}

/// The margins at their frequencies: the gain margin below 0 dB, the phase margin above -180°.
fn margins(report: &Report, magnitude: &mut Chart, phase: &mut Chart) {
    let Some(margins) = report.margins() else { return };
    let within = |f: &f64| magnitude.x.last().is_some_and(|last| f <= last);
    let crossover = margins.crossover_hz.filter(within);
    if let Some((factor, f)) = margins.gain.zip(margins.gain_hz.filter(within)) {
        let label = format!("gain margin {}", plain(factor));
        magnitude.gauges.push(Gauge { x: f, y: [-20.0 * factor.log10(), 0.0], label });
    }
    if let Some(f) = crossover {
        magnitude.marks.push(Mark { x: f, y: 0.0, label: "crossover".into() });
    }
    let sampled = phase.series.iter().find(|series| !series.dashed);
    let at =
        |f: f64| sampled.and_then(|series| series.values.get(phase.x.partition_point(|x| *x < f)).copied());
    if let Some((margin, f)) = margins.phase_deg.zip(crossover)
        && let Some(there) = at(f).filter(|there| there.is_finite())
    {
        // The nearest odd multiple of 180°.
        let half_turn = 360.0 * ((there - 180.0) / 360.0).round() + 180.0;
        let label = format!("phase margin {}°", plain(margin));
        phase.gauges.push(Gauge { x: f, y: [there, half_turn], label });
    }
}

/// The response to a step of the reference.
pub(crate) fn step(curves: &Curves) -> Option<Chart> {
    let step = curves.step.as_ref()?;
    let mut chart = Chart::new(ChartKind::Line, "Step response,", "time (s)", "reading over reference");
    chart.caption =
        "the reading after a step of the reference by one, as the loop is set: linear, sampled.".into();
    chart.x = (0..step.values.len()).map(|k| k as f64 * step.period_s).collect();
    chart.series = vec![Series::new("reading", "", step.values.clone())];
    chart.lines.push(Line { y: 1.0, label: "reference".into() });
    Some(chart)
}

fn pair(curves: &Curves, title: &str, caption: &str, responses: &[Response]) -> Vec<Chart> {
    let present: Vec<(&str, &Vec<C64>, bool)> = responses
        .iter()
        .filter_map(|(name, values, dashed)| Some((*name, values.as_ref()?, *dashed)))
        .collect();
    if present.is_empty() {
        return Vec::new();
    }
    let chart = |label: &str, text: String, of: &dyn Fn(&[C64]) -> Vec<f64>, unit: &str| {
        let mut chart = Chart::new(ChartKind::Line, title, "frequency (Hz)", label);
        chart.caption = text;
        chart.x_log = true;
        chart.together = Some(TOGETHER);
        chart.x.clone_from(&curves.frequencies_hz);
        chart.series = present
            .iter()
            .map(|(name, values, dashed)| {
                let series = Series::new(*name, unit, of(values));
                if *dashed { series.dashed() } else { series }
            })
            .collect();
        chart
    };
    vec![
        chart("magnitude (dB)", format!("magnitude: {caption}"), &decibels, "dB"),
        chart("phase (°)", "phase.".to_owned(), &degrees, "°"),
    ]
}

fn decibels(values: &[C64]) -> Vec<f64> {
    values.iter().map(|g| 20.0 * g.norm().log10()).collect()
}

/// Phase, continuous over frequency. Gaps remain; zeros have no phase.
pub(crate) fn degrees(values: &[C64]) -> Vec<f64> {
    let mut last: Option<f64> = None;
    let continued = values.iter().map(|g| {
        let own = g.arg();
        if !own.is_finite() {
            return f64::NAN;
        }
        let phase = last
            .map_or(own, |last| own - ((own - last) / std::f64::consts::TAU).round() * std::f64::consts::TAU);
        last = Some(phase);
        phase.to_degrees()
    });
    continued.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_phase_goes_on_across_a_gap() {
        let turn = |degrees: f64| C64::from_polar(1.0, degrees.to_radians());
        let found = degrees(&[turn(-150.0), C64::new(f64::NAN, 0.0), turn(-210.0), turn(-330.0)]);
        assert!((found[0] + 150.0).abs() < 1e-9 && found[1].is_nan());
        assert!((found[2] + 210.0).abs() < 1e-9 && (found[3] + 330.0).abs() < 1e-9);
    }
}
