//! `feeler analyze`.

use feeler_analysis::{AnalysisError, Band, ContactView, Report, Request, StableRange, View, analyze, curves};
use feeler_control::{Law, Reference};
use feeler_engine::Scenario;
use feeler_lti::LtiError;
use feeler_plant::assembly::assemble;
use feeler_plant::description::Engagement;
use feeler_scenarios::format::Draft;

use crate::arguments::Analyze;
use crate::failure::BadInput;
use crate::numbers::{plain, with_unit};
use crate::table::table;
use crate::units::Units;
use crate::{reports, signals, terminal};

pub(crate) fn run(arguments: &Analyze) -> anyhow::Result<()> {
    let document = Draft::load_with(&arguments.file, &arguments.settings)?.build()?;
    if let Some(preload_n) = arguments.preload.filter(|force| !(force.is_finite() && *force > 0.0)) {
        return Err(BadInput::error(format!("--preload {preload_n} presses nothing"), "give a force above zero, in N"));
    }
    let contact = match arguments.preload {
        Some(preload_n) => ContactView::Pressed { preload_n },
        None if arguments.clamped => ContactView::Clamped,
        None if arguments.free => ContactView::Free,
        None => pressed(&document.scenario).map_or(ContactView::AsDescribed, |preload_n| {
            let unit = Units::of(&document.scenario.machine).force;
            terminal::complain(&format!(
                "note: the contact's stiffness depends on its force; linearised at the last reference, {} (--preload chooses another)",
                with_unit(preload_n, unit)
            ));
            ContactView::Pressed { preload_n }
        }),
    };
    let request = Request {
        input: arguments.input.as_deref().map(|name| signals::input(&document.scenario.machine, name)).transpose()?,
        output: arguments.output.as_deref().map(|name| signals::named(&document.scenario.machine, name)).transpose()?,
        gain: arguments.gain.clone(),
        view: View { contact, ..View::default() },
        // A page says what to change first.
        sensitivities: arguments.sensitivities || arguments.out.is_some(),
    };
    let report = analyze(&document.scenario, &request).map_err(|error| refused(arguments, error))?;
    let mut written = String::new();
    if let Some(folder) = &arguments.out {
        let curves = curves(&document.scenario, &request, &report).map_err(|error| refused(arguments, error))?;
        let page = reports::analyze::page(&document, &arguments.settings, &report, &curves);
        let json = serde_json::to_string_pretty(&report)? + "\n";
        written = terminal::write_all(folder, &[("analyze.json", json), ("report.html", page)])?;
    }
    terminal::print(&if arguments.json { serde_json::to_string_pretty(&report)? } else { text(&report) + &written })
}

/// The force at which a contact of a nonlinear law is taken: what the first force controller asks for in the end. Without force it has no stiffness.
fn pressed(scenario: &Scenario) -> Option<f64> {
    // As assembled: an effect may replace the law.
    let assembly = assemble(&scenario.machine).ok()?;
    if !assembly.contacts.iter().any(|contact| contact.engagement != Engagement::Free && contact.law.exponent > 1.0) {
        return None;
    }
    let asks = scenario.controllers.values().find(|control| matches!(control.spec.law, Law::ExplicitForce(_)))?;
    let last = Reference::new(&asks.spec.reference, 0, "").ok()?.value(f64::MAX);
    Some(last).filter(|force| *force > 0.0)
}

/// Everything but a failed computation is a matter of the request or the file.
fn refused(arguments: &Analyze, error: AnalysisError) -> anyhow::Error {
    match error {
        AnalysisError::Lti(LtiError::AtPole { .. }) => BadInput::error(
            format!("{}: {error}", arguments.file.display()),
            "nothing holds the machine about this operating point: try --clamped, or --preload with a force",
        ),
        AnalysisError::Lti(_) => error.into(),
        _ => BadInput::error(format!("{}: {error}", arguments.file.display()), "see feeler analyze --help for what can be asked"),
    }
}

fn text(report: &Report) -> String {
    let mut parts = vec![format!("from {} to {}", report.input, report.output), roots(report)];
    if !report.modes.is_empty() {
        let rows = report.modes.iter().map(|mode| {
            let class = if mode.rigid_body { "rigid body" } else { reports::analyze::class_name(mode.class) }.to_owned();
            let cost = mode.margin_cost_deg.map_or_else(|| "-".to_owned(), plain);
            vec![plain(mode.frequency_hz), plain(mode.damping_ratio), class, plain(mode.phase_change_deg), plain(mode.phase_dip_deg), cost]
        });
        let header = ["mode (Hz)", "damping ratio", "class", "phase change (deg)", "dip (deg)", "taken at crossover (deg)"];
        parts.push(table(&header, &[0, 1, 3, 4, 5], rows));
    }
    if let Some(gain) = &report.gain {
        let rows =
            gain.continuous.iter().flat_map(|range| bands(report, "continuous", range)).chain(bands(report, "sampled", &gain.sampled));
        let header = ["loop", "from", "to", "there it swings (Hz)", "like the mode (Hz)"];
        parts.push(format!("stable {}\n{}", gain.key, table(&header, &[1, 2, 3, 4], rows)));
    }
    if let Some(margins) = &report.margins {
        let entry = |name: &str, value: Option<f64>, unit: &str| {
            vec![name.to_owned(), value.map_or_else(|| "-".to_owned(), plain), unit.to_owned()]
        };
        if margins.unstable_poles > 0 {
            let lower = margins.gain_decrease.map_or_else(String::new, |f| format!(" Its whole gain times {} is at the limit.", plain(f)));
            parts.push(format!("The sampled loop is unstable as it is, so that it has no margins.{lower}"));
        } else {
            let rows = [
                entry("gain margin", margins.gain, ""),
                entry("gain may fall to", margins.gain_decrease, ""),
                entry("phase margin", margins.phase_deg, "deg"),
                entry("delay margin", margins.delay_s, "s"),
                entry("crossover", margins.crossover_hz, "Hz"),
                entry("disk margin", Some(margins.disk), ""),
                entry("largest sensitivity", Some(margins.sensitivity_peak), ""),
            ];
            parts.push(table(&["margins of the sampled loop", "", ""], &[1], rows));
        }
    }
    if let Some(waterfall) = &report.waterfall {
        let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), plain);
        let rows = waterfall.stages.iter().map(|stage| {
            let Some(largest) = stage.largest_gain else {
                return vec![stage.added.clone(), "unbounded".into(), "none".into(), "no limit".into()];
            };
            vec![stage.added.clone(), plain(largest), number(stage.edge_hz), number(stage.bandwidth_hz)]
        });
        parts.push(table(&["with", "largest gain", "edge (Hz)", "bandwidth at half of it (Hz)"], &[1, 2, 3], rows));
    }
    if !report.sensitivities.is_empty() {
        let rows = report.sensitivities.iter().map(|s| {
            vec![s.key.clone(), plain(s.value), plain(s.bandwidth_relative), plain(s.largest_gain_relative), plain(s.bandwidth_hz_per_unit)]
        });
        let header = ["1 % more of", "value (SI)", "bandwidth (%)", "largest gain (%)", "bandwidth (Hz per unit)"];
        parts.push(table(&header, &[1, 2, 3, 4], rows));
    }
    if !report.limit_cycles.is_empty() {
        let rows = reports::analyze::cycles::rows(report);
        parts.push(table(&reports::analyze::cycles::HEADER, &reports::analyze::cycles::NUMBERS, rows));
    }
    if let Some(limit) = report.limit.and_then(|limit| serde_json::to_value(limit).ok()) {
        parts.push(format!("limited by: {}", limit.as_str().unwrap_or_default()));
    }
    parts.push(reports::analyze::sentences(report).join("\n"));
    parts.join("\n\n")
}

/// Parts of poles and zeros below this share of the largest are zero up to rounding.
const ROUNDING: f64 = 1e-15;

fn roots(report: &Report) -> String {
    let all = || report.poles.iter().chain(&report.zeros).flatten();
    let rounding = ROUNDING * all().fold(0.0_f64, |largest, v| largest.max(v.abs()));
    let plain = |value: f64| plain(if value.abs() < rounding { 0.0 } else { value });
    let root = |[re, im]: &[f64; 2]| format!("{} {} {}i", plain(*re), if *im < 0.0 { '-' } else { '+' }, plain(im.abs()));
    let at = |roots: &[[f64; 2]], i: usize| roots.get(i).map_or_else(String::new, root);
    let rows = (0..report.poles.len().max(report.zeros.len())).map(|i| vec![at(&report.poles, i), at(&report.zeros, i)]);
    table(&["poles (1/s)", "zeros (1/s)"], &[], rows)
}

/// A row for each interval of stable gains; one that says so where there is none.
fn bands(report: &Report, name: &str, range: &StableRange) -> Vec<Vec<String>> {
    let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), plain);
    if range.all.bands.is_empty() {
        return vec![vec![name.to_owned(), "none".to_owned(), "none".to_owned(), "-".to_owned(), "-".to_owned()]];
    }
    let row = |band: &Band| {
        let edge = band.upper.as_ref().or(band.lower.as_ref());
        let mode_hz = edge.and_then(|edge| edge.mode).and_then(|i| report.modes.get(i)).map(|mode| mode.frequency_hz);
        let from = band.lower.as_ref().map_or(0.0, |edge| edge.gain);
        let to = band.upper.as_ref().map_or_else(|| "unbounded".to_owned(), |edge| plain(edge.gain));
        vec![name.to_owned(), plain(from), to, number(edge.map(|edge| edge.frequency_hz)), number(mode_hz)]
    };
    range.all.bands.iter().map(row).collect()
}
