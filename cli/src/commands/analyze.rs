//! `feeler analyze`.

use feeler_analysis::{AnalysisError, ContactView, Report, Request, StableRange, View, analyze};
use feeler_plant::description::SignalName;
use feeler_scenarios::format::Draft;

use crate::arguments::Analyze;
use crate::failure::BadInput;
use crate::numbers::plain;
use crate::table::table;
use crate::terminal;

pub(crate) fn run(arguments: &Analyze) -> anyhow::Result<()> {
    let mut draft = Draft::load(&arguments.file)?;
    for setting in &arguments.settings {
        draft.set(setting)?;
    }
    let document = draft.build()?;
    let contact = match arguments.preload {
        Some(preload_n) => ContactView::Pressed { preload_n },
        None if arguments.clamped => ContactView::Clamped,
        None if arguments.free => ContactView::Free,
        None => ContactView::AsDescribed,
    };
    let request = Request {
        input: signal(arguments.input.as_deref())?,
        output: signal(arguments.output.as_deref())?,
        gain: arguments.gain.clone(),
        view: View { contact, ..View::default() },
        sensitivities: arguments.sensitivities,
    };
    let report = analyze(&document.scenario, &request).map_err(|error| refused(arguments, error))?;
    terminal::print(&if arguments.json { serde_json::to_string_pretty(&report)? } else { text(&report) })
}

fn signal(name: Option<&str>) -> anyhow::Result<Option<SignalName>> {
    let parse = |name: &str| name.parse().map_err(|error| BadInput::error(format!("{error}"), "signals are listed in docs/format.md"));
    name.map(parse).transpose()
}

/// Everything but a failed computation is a matter of the request or the file.
fn refused(arguments: &Analyze, error: AnalysisError) -> anyhow::Error {
    match error {
        AnalysisError::Lti(_) => error.into(),
        _ => BadInput::error(format!("{}: {error}", arguments.file.display()), "see feeler analyze --help for what can be asked"),
    }
}

fn text(report: &Report) -> String {
    let mut parts = vec![format!("from {} to {}", report.input, report.output), roots(report)];
    if !report.modes.is_empty() {
        let rows = report.modes.iter().map(|mode| {
            let class = serde_json::to_value(mode.class).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default();
            vec![plain(mode.frequency_hz), plain(mode.damping_ratio), class, plain(mode.phase_change_deg), plain(mode.phase_dip_deg)]
        });
        parts.push(table(&["mode (Hz)", "damping ratio", "class", "phase change (deg)", "dip (deg)"], &[0, 1, 3, 4], rows));
    }
    if let Some(gain) = &report.gain {
        let range = |name: &str, range: &StableRange| {
            let end = |value: Option<f64>, open: &str| value.map_or_else(|| open.to_owned(), plain);
            let [from, to] = range.stable;
            vec![name.to_owned(), end(from, "unbounded"), end(to, "unbounded"), end(range.edge_hz, "-")]
        };
        let rows = gain.continuous.iter().map(|r| range("continuous", r)).chain([range("sampled", &gain.sampled)]);
        parts.push(format!("stable {}\n{}", gain.key, table(&["loop", "from", "to", "edge (Hz)"], &[1, 2, 3], rows)));
    }
    if let Some(margins) = &report.margins {
        let entry = |name: &str, value: Option<f64>, unit: &str| {
            vec![name.to_owned(), value.map_or_else(|| "-".to_owned(), plain), unit.to_owned()]
        };
        let rows = [
            entry("gain margin", margins.gain, ""),
            entry("phase margin", margins.phase_deg, "deg"),
            entry("delay margin", margins.delay_s, "s"),
            entry("crossover", margins.crossover_hz, "Hz"),
            entry("disk margin", Some(margins.disk), ""),
            entry("largest sensitivity", Some(margins.sensitivity_peak), ""),
        ];
        parts.push(table(&["margins of the sampled loop", "", ""], &[1], rows));
    }
    if let Some(waterfall) = &report.waterfall {
        let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), plain);
        let rows = waterfall.stages.iter().map(|stage| {
            let largest = stage.largest_gain.map_or_else(|| "unbounded".to_owned(), plain);
            vec![stage.added.clone(), largest, number(stage.edge_hz), number(stage.bandwidth_hz)]
        });
        parts.push(table(&["with", "largest gain", "edge (Hz)", "bandwidth at half of it (Hz)"], &[1, 2, 3], rows));
    }
    if let Some(limit) = report.limit.and_then(|limit| serde_json::to_value(limit).ok()) {
        parts.push(format!("limited by: {}", limit.as_str().unwrap_or_default()));
    }
    parts.join("\n\n")
}

fn roots(report: &Report) -> String {
    let root = |[re, im]: &[f64; 2]| format!("{} {} {}i", plain(*re), if *im < 0.0 { '-' } else { '+' }, plain(im.abs()));
    let at = |roots: &[[f64; 2]], i: usize| roots.get(i).map_or_else(String::new, root);
    let rows = (0..report.poles.len().max(report.zeros.len())).map(|i| vec![at(&report.poles, i), at(&report.zeros, i)]);
    table(&["poles (1/s)", "zeros (1/s)"], &[], rows)
}
