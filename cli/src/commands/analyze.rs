//! `feeler analyze`.

use feeler_analysis::{
    AnalysisError, Band, Edge, MarginReport, Report, Request, StableRange, View, analyze, curves,
};
use feeler_engine::{EngineError, Scenario};
use feeler_files::{Document, Draft};
use feeler_lti::LtiError;
use feeler_problem::Remedy;
use feeler_studies::{ALL_PROCESSORS, doubts, signals};

use super::operating_point;
use crate::arguments::Analyze;
use crate::numbers::{plain, two_digits, with_unit};
use crate::terminal::failure::BadInput;
use crate::terminal::progress::Busy;
use crate::terminal::table;
use crate::{pages, terminal};

pub(crate) fn run(arguments: &Analyze) -> crate::Result<()> {
    let document = Draft::load_with(&arguments.file, &arguments.settings)?.build()?;
    terminal::warn(&doubts(&document.scenario).all);
    let (contact, note) = operating_point::contact_view(arguments, &document.scenario)?;
    let notes: Vec<String> = note.into_iter().collect();
    for note in &notes {
        terminal::complain(&format!("note: {note}"));
    }
    let request = Request {
        input: arguments
            .input
            .as_deref()
            .map(|name| signals::input(&document.scenario.machine, name))
            .transpose()?,
        output: arguments
            .output
            .as_deref()
            .map(|name| signals::named(&document.scenario.machine, name))
            .transpose()?,
        gain: arguments.gain.clone(),
        view: View { contact, ..View::default() },
        sensitivities: true,
        workers: ALL_PROCESSORS,
        ..Request::default()
    };
    let busy = Busy::new("analysing, with every mass, stiffness and damping a little more and less");
    let report =
        analyze(&document.scenario, &request).map_err(|error| refused(arguments, &document, error))?;
    let drawn = arguments.out.as_deref().map(|folder| {
        let curves = curves(&document.scenario, &request, &report);
        curves.map(|curves| (folder, curves)).map_err(|error| refused(arguments, &document, error))
    });
    let drawn = drawn.transpose()?;
    drop(busy);
    let mut written = String::new();
    if let Some((folder, curves)) = drawn {
        let page = pages::analyze::page(&document, &arguments.settings, &notes, &report, &curves);
        let json = terminal::json(&report)? + "\n";
        written = terminal::write_all(folder, &[("analyze.json", json), ("report.html", page)])?;
    }
    terminal::print(&if arguments.json { terminal::json(&report)? } else { text(&report) + &written })
}

/// Reports a failed computation as such; any other error is a mistake of the request or the file.
fn refused(arguments: &Analyze, document: &Document, error: AnalysisError) -> crate::Failure {
    match &error {
        AnalysisError::NoController { known, .. } => {
            let known: Vec<String> = known.iter().map(|name| format!("`{name}`")).collect();
            let remedy = if known.is_empty() {
                "this file has no controller: leave --gain out".to_owned()
            } else {
                format!("--gain CONTROLLER.GAIN, the controller being {}", known.join(" or "))
            };
            BadInput::error(format!("{}: {error}", arguments.file.display()), remedy)
        }
        AnalysisError::NoGain { known, .. } => BadInput::error(
            format!("{}: {error}", arguments.file.display()),
            format!("name one of {known} with --gain, as in --gain CONTROLLER.GAIN"),
        ),
        AnalysisError::Lti(LtiError::AtPole { .. }) => BadInput::error(
            format!("{}: {error}", arguments.file.display()),
            "nothing holds the machine at this operating point: try --clamped, or --preload with a force",
        ),
        AnalysisError::Rates { .. } => {
            // All digits are shown, because the periods may differ in the last ones only.
            let periods = document.scenario.periods().map(|(key, period_s)| format!("{key} = {period_s} s"));
            let remedy =
                format!("make one a multiple of the other: {}", periods.collect::<Vec<_>>().join(", "));
            BadInput::error(format!("{}: {error}", arguments.file.display()), remedy)
        }
        AnalysisError::LongDelay { .. } => BadInput::error(
            format!("{}: {error}{}", arguments.file.display(), delays(&document.scenario)),
            "shorten the delay, or lengthen the period: each sample of delay is a state of the loop. Only a \
             controller of one rate, its drive or its only sensor may be up to 2000 samples late",
        ),
        AnalysisError::Engine(EngineError::Problems { problems }) => {
            document.locate_problems(problems).into()
        }
        _ if error.is_of_caller() => error.into(),
        _ => BadInput::error(format!("{}: {error}", arguments.file.display()), error.remedy()),
    }
}

/// The delays of a scenario with their keys, for the end of a message.
fn delays(scenario: &Scenario) -> String {
    let there = scenario.delays().filter(|(_, delay_s)| *delay_s > 0.0);
    let listed: Vec<String> =
        there.map(|(key, delay_s)| format!("{key} = {}", with_unit(delay_s, "s"))).collect();
    if listed.is_empty() { String::new() } else { format!("; {}", listed.join(", ")) }
}

fn text(report: &Report) -> String {
    let mut parts: Vec<String> =
        pages::analyze::as_set(report).map(|sentence| terminal::wrapped(&sentence)).into_iter().collect();
    parts.extend([
        terminal::wrapped(&pages::analyze::sentences(report).join("\n")),
        pages::analyze::subject(report),
        roots(report),
    ]);
    if !report.modes.is_empty() {
        parts.push(modes(report));
    }
    if let Some(gain) = report.gain() {
        let rows = gain.continuous.iter().flat_map(|range| bands(report, "continuous", range)).chain(bands(
            report,
            "sampled",
            &gain.sampled,
        ));
        let header = [
            "loop",
            "from",
            "oscillation at from (Hz)",
            "mode near from (Hz)",
            "to",
            "oscillation at to (Hz)",
            "mode near to (Hz)",
        ];
        let of = report
            .pair()
            .map_or_else(String::new, |of| format!(" (loop from {} to {})", of.input, of.output));
        parts.push(format!("stable {}{of}\n{}", gain.key, table(&header, &[1, 2, 3, 4, 5, 6], rows)));
    }
    if let Some(margins) = report.margins() {
        parts.extend(margin_tables(margins));
    }
    if let Some(waterfall) = report.waterfall() {
        let rows = pages::analyze::waterfall::rows(waterfall);
        parts.push(table(&pages::analyze::waterfall::HEADER, &pages::analyze::waterfall::NUMBERS, rows));
    }
    if !report.sensitivities().is_empty() {
        parts.push(sensitivities(report));
    }
    if !report.limit_cycles.is_empty() {
        let rows = pages::analyze::cycles::rows(report);
        parts.push(table(&pages::analyze::cycles::HEADER, &pages::analyze::cycles::NUMBERS, rows));
    }
    if !report.assumptions.is_empty() {
        parts.push(table(&pages::analyze::ASSUMPTIONS, &[], pages::analyze::assumption_rows(report)));
    }
    if let Some(limit) = report.limit().and_then(|limit| serde_json::to_value(limit).ok()) {
        parts.push(format!("limited by: {}", limit.as_str().unwrap_or_default()));
    }
    parts.join("\n\n")
}

/// The modes, with the cost of each to the loop.
fn modes(report: &Report) -> String {
    let rows = report.modes.iter().map(|mode| {
        let class =
            if mode.rigid_body { "rigid body" } else { pages::analyze::class_name(mode.class) }.to_owned();
        let cost = mode.margin_cost_deg.map_or_else(|| "-".to_owned(), plain);
        let damping_ratio = plain(pages::analyze::damping_ratio(mode));
        vec![
            plain(mode.frequency_hz),
            damping_ratio,
            class,
            plain(0.0 - mode.phase_change_deg),
            plain(0.0 - mode.phase_dip_deg),
            cost,
        ]
    });
    let header = [
        "mode (Hz)",
        "damping ratio",
        "class",
        "lost beyond it (deg)",
        "largest lag (deg)",
        "lost at crossover (deg)",
    ];
    table(&header, &[0, 1, 3, 4, 5], rows)
}

/// Effect of a small change of each number. The JSON has all digits.
fn sensitivities(report: &Report) -> String {
    let rows = report.sensitivities().iter().map(|s| {
        let trade = if report.ranked_by().is_some_and(|by| s.is_trade(by)) { "trade-off" } else { "" };
        let or_none = |value: f64, text: String| if value.is_finite() { text } else { "-".to_owned() };
        // Removes the sign of a zero.
        let share = |value: f64| or_none(value, format!("{:.2}", (100.0 * value).round() / 100.0 + 0.0));
        let number = |value: f64, digits: f64| or_none(value, plain(digits));
        vec![
            s.key.clone(),
            number(s.value, s.value),
            share(s.bandwidth_relative),
            share(s.largest_gain_relative),
            number(s.bandwidth_hz_per_unit, two_digits(s.bandwidth_hz_per_unit)),
            trade.to_owned(),
        ]
    });
    let achieved = pages::analyze::achieved_name(report);
    let header = ["1 % more of", "value (SI)", &format!("{achieved} (%)"), "limit (%)", "Hz per unit", ""];
    table(&header, &[1, 2, 3, 4], rows)
}

/// Parts of poles and zeros below this share of the largest one are rounding errors.
const ROUNDING: f64 = 1e-15;

fn roots(report: &Report) -> String {
    let at = |roots: &[[f64; 2]], i: usize| {
        let rounding = ROUNDING * roots.iter().flatten().fold(0.0_f64, |largest, v| largest.max(v.abs()));
        let plain = |value: f64| plain(if value.abs() < rounding { 0.0 } else { value });
        roots.get(i).map_or_else(String::new, |[re, im]| {
            if report.lost_below_per_s().is_some_and(|lost| re.hypot(*im) <= lost) {
                return "not determined".to_owned();
            }
            format!("{} {} {}i", plain(*re), if *im < 0.0 { '-' } else { '+' }, plain(im.abs()))
        })
    };
    let rows = (0..report.poles.len().max(report.zeros.len()))
        .map(|i| vec![at(&report.poles, i), at(&report.zeros, i)]);
    let gain = report.zero_pole_gain.map_or_else(String::new, |gain| {
        let late = if report.delay_s > 0.0 {
            format!(", {} later", with_unit(report.delay_s, "s"))
        } else {
            String::new()
        };
        format!("\n{} times the product of (s - zero) over that of (s - pole){late}", plain(gain))
    });
    table(&["poles (1/s)", "zeros (1/s)"], &[], rows) + &gain
}

/// A row for each interval of stable gains, or the row `none`.
fn bands(report: &Report, name: &str, range: &StableRange) -> Vec<Vec<String>> {
    let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), plain);
    if range.intervals.is_empty() {
        let nothing = ["none", "-", "-", "none", "-", "-"].map(str::to_owned);
        return vec![[name.to_owned()].into_iter().chain(nothing).collect()];
    }
    let end = |edge: &Option<Edge>| {
        let mode_hz = edge
            .as_ref()
            .and_then(|edge| edge.mode)
            .and_then(|i| report.modes.get(i))
            .map(|mode| mode.frequency_hz);
        let gain = edge.as_ref().map_or_else(|| "unbounded".to_owned(), |edge| plain(edge.gain));
        [gain, number(edge.as_ref().map(|edge| edge.frequency_hz)), number(mode_hz)]
    };
    let row =
        |band: &Band| [name.to_owned()].into_iter().chain(end(&band.lower)).chain(end(&band.upper)).collect();
    range.intervals.iter().map(row).collect()
}

/// Margins and peaks of a stable loop, and the terms of Nyquist's count.
fn margin_tables(margins: &MarginReport) -> Vec<String> {
    let entry = |name: &str, value: Option<f64>, unit: &str, at_hz: Option<f64>| {
        let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), plain);
        let at = at_hz.map_or_else(String::new, |f| {
            if f > 0.0 { plain(f) } else { "zero frequency: no resonance peak".to_owned() }
        });
        vec![name.to_owned(), number(value), unit.to_owned(), at]
    };
    let mut tables = Vec::new();
    if margins.unstable_poles > 0 {
        let never = || " It is unstable at every lower gain too.".to_owned();
        let fall = |f| {
            let times = plain(f);
            format!(
                " Its controller's whole output, all gains together, must fall to {times} times its value."
            )
        };
        let lower = margins.gain_decrease.map_or_else(never, fall);
        tables.push(format!("The sampled loop is unstable, so it has no margins.{lower}"));
    } else {
        let rows = [
            entry("gain margin", margins.gain, "", None),
            entry("gain may fall to", margins.gain_decrease, "", None),
            entry("phase margin", margins.phase_deg, "deg", margins.crossover_hz),
            entry("delay margin", margins.delay_s, "s", None),
            entry("disk margin", Some(margins.disk), "", None),
            entry(
                "largest sensitivity |S|",
                Some(margins.sensitivity_peak),
                "",
                Some(margins.sensitivity_peak_hz),
            ),
            entry(
                "largest complementary |T|",
                Some(margins.complementary_sensitivity_peak),
                "",
                Some(margins.complementary_sensitivity_peak_hz),
            ),
        ];
        tables.push(table(&["margins of the sampled loop", "", "", "at (Hz)"], &[1, 3], rows));
    }
    let rows = [
        ["unstable poles of the open loop".to_owned(), margins.open_unstable_poles.to_string()],
        ["clockwise turns about -1".to_owned(), margins.encirclements.to_string()],
        ["unstable poles of the closed loop".to_owned(), margins.unstable_poles.to_string()],
    ];
    tables.push(table(&["Nyquist's count, sampled loop", ""], &[1], rows.map(Vec::from)));
    tables
}
