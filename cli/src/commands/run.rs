//! `feeler run`.

use std::path::{Path, PathBuf};
use std::time::Duration;

use feeler_engine::{EngineError, Integrator, RunSettings};
use feeler_files::{Document, Draft, EXACT_PAYS_UP_TO_BODIES, longest_step_s};
use feeler_studies::run::{self, Outcome, RunError, RunResult, Summary, write_csv, write_parquet};
use feeler_studies::{Doubts, doubts};

use super::run_arm;
use super::run_folder::{folder, settings};
use crate::arguments::Run;
use crate::numbers::{percent, plain, split, with_unit};
use crate::terminal::progress::Progress;
use crate::terminal::table;
use crate::units::Units;
use crate::watched::Watched;
use crate::{pages, terminal, words};

/// Interval between checks of a watched file.
const CHECK_INTERVAL: Duration = Duration::from_millis(300);
/// Time without a change after which a changed file is complete.
const SETTLING: Duration = Duration::from_millis(50);

pub(crate) fn run(arguments: &Run) -> crate::Result<()> {
    if !arguments.watch {
        return once(arguments);
    }
    let mut watched = Watched::file(&arguments.file);
    loop {
        watched = Document::load(&arguments.file).map_or(watched.now(), |document| Watched::of(&document));
        // The user sees the mistake and can correct the file.
        if let Err(failure) = once(arguments) {
            let _ = failure.report();
        }
        terminal::complain(&format!("watching {}; Ctrl-C ends it", arguments.file.display()));
        let mut now = watched.now();
        while now == watched {
            std::thread::sleep(CHECK_INTERVAL);
            now = watched.now();
        }
        // An editor that empties a file before it writes may not have finished.
        while now != watched {
            watched = now;
            std::thread::sleep(SETTLING);
            now = watched.now();
        }
    }
}

fn once(arguments: &Run) -> crate::Result<()> {
    let draft = read(arguments)?;
    if draft.has_arm() {
        return run_arm::run(arguments, draft);
    }
    let document = draft.build()?;
    let folder = folder(arguments, &document.scenario.machine.name);
    terminal::make_folder(&folder)?;
    let mut progress = Progress::new(document.scenario.machine.name.clone());
    let runs = if arguments.as_sweep { run::run_as_swept } else { run::run };
    let result = runs(&document.scenario, &mut |at| progress.at(at.t_s / at.duration_s));
    progress.done();
    let result = result.map_err(|error| match error {
        RunError::Engine(EngineError::Problems { problems }) => {
            crate::Failure::from(document.locate_problems(&problems))
        }
        other => other.into(),
    })?;
    let doubts = doubts(&document.scenario);
    terminal::warn(&doubts.all);
    let written = write(arguments, &document, &result, &doubts, &folder)?;
    if arguments.json {
        return terminal::print(&terminal::json(&result.summary)?);
    }
    let files = written.iter().map(|path| format!("  {}", path.display())).collect::<Vec<_>>().join("\n");
    let summary = &result.summary;
    let units = Units::of(&document.scenario.machine);
    let cost = word_on_cost(&document).unwrap_or_default();
    let energies = word_on_energies(arguments, summary);
    let account = words::account(&document.scenario, summary, units, &doubts);
    let said = format!("{}: {}", summary.name, account.sentences.join("\n"));
    let asides: String = [cost.as_str(), energies]
        .iter()
        .filter(|aside| !aside.is_empty())
        .map(|aside| terminal::wrapped(aside.trim_end()) + "\n")
        .collect();
    terminal::print(&format!(
        "{}\n\n{}\n{asides}\nwrote\n{files}\n\nnext: {}",
        terminal::wrapped(&said),
        figures(summary, units),
        next(arguments, summary.outcome)
    ))
}

/// The command that explains the outcome of the run.
fn next(arguments: &Run, outcome: Outcome) -> String {
    let settings = arguments.settings.iter().map(|setting| format!(" --set {}", terminal::quoted(setting)));
    let of_file = format!("{}{}", terminal::quoted_path(&arguments.file), settings.collect::<String>());
    if outcome.is_sustained() || outcome == Outcome::Unstable {
        return format!("feeler why {of_file}");
    }
    format!("feeler live {of_file}")
}

/// Reports the default integrator with the reason, if RK4 takes less time than the exact integrator.
fn word_on_cost(document: &Document) -> Option<String> {
    let (run, machine) = (&document.scenario.run, &document.scenario.machine);
    let bodies = machine.bodies.len();
    if bodies <= EXACT_PAYS_UP_TO_BODIES
        || document.place(&RunSettings::key(&RunSettings::INTEGRATOR)).is_some()
    {
        return None;
    }
    let less = "RK4 takes less time than the exact integrator";
    match (run.integrator, longest_step_s(machine)) {
        (Integrator::Rk4, _) => Some(format!(
            "\nWith {bodies} bodies {less}. This run has steps of {}; `--integrator exact` is accurate \
             to machine precision.\n",
            with_unit(run.step_s, "s")
        )),
        (Integrator::Exact, Some(longest)) => Some(format!(
            "\nWith {bodies} bodies {less}, but not with steps of {}: the fastest motion requires `run.step` \
             of {} or less.\n",
            with_unit(run.step_s, "s"),
            with_unit(longest, "s")
        )),
        _ => None,
    }
}

/// Reports that a motion was too fast for an energy balance.
fn word_on_energies(arguments: &Run, summary: &Summary) -> &'static str {
    if arguments.as_sweep || summary.energy.is_some() {
        return "";
    }
    "\nThe energies are left out: powers would have to be followed through every oscillation of the \
     fastest motion.\n"
}

fn read(arguments: &Run) -> crate::Result<Draft> {
    Ok(Draft::load_with(&arguments.file, &settings(arguments))?)
}

/// Writes all results, in parallel if there are several threads, and returns their paths.
fn write(
    arguments: &Run,
    document: &Document,
    result: &RunResult,
    doubts: &Doubts,
    folder: &Path,
) -> crate::Result<Vec<PathBuf>> {
    let [trace, csv, summary, report] =
        ["trace.parquet", "trace.csv", "summary.json", "report.html"].map(|name| folder.join(name));
    let write_trace = || write_parquet(&result.trace, &about(document), &trace);
    let write_text = || if arguments.csv { write_csv(&result.trace, &csv) } else { Ok(()) };
    let write_summary = || -> crate::Result<()> {
        terminal::write(&summary, (terminal::json(&result.summary)? + "\n").as_bytes())
    };
    let write_report = || {
        terminal::write(&report, pages::run::page(document, &arguments.settings, result, doubts).as_bytes())
    };
    let threads = arguments.threads.map_or(0, usize::from);
    let pool = terminal::failure::pool(threads)?;
    let ((traced, texted), (summed, reported)) = pool.install(|| {
        rayon::join(|| rayon::join(write_trace, write_text), || rayon::join(write_summary, write_report))
    });
    traced?;
    texted?;
    summed?;
    reported?;
    let csv = arguments.csv.then_some(csv);
    Ok([Some(trace), csv, Some(summary), Some(report)].into_iter().flatten().collect())
}

/// Metadata key of the resolved scenario in a trace: command line settings are applied, and no other file is
/// needed.
pub(super) const RESOLVED: &str = "feeler.resolved";

/// Metadata of a trace.
fn about(document: &Document) -> Vec<(&'static str, String)> {
    let run = &document.scenario.run;
    vec![
        ("feeler.version", env!("CARGO_PKG_VERSION").to_owned()),
        ("feeler.scenario", document.text().to_owned()),
        (RESOLVED, document.to_toml()),
        ("feeler.seed", run.seed.to_string()),
        ("feeler.integrator", moved_by(run.integrator).to_owned()),
    ]
}

/// Name of the engine that moves the bodies.
fn moved_by(integrator: Integrator) -> &'static str {
    if integrator == Integrator::External { "rapier" } else { integrator.name() }
}

/// The summary as a table: measure, number, unit, remark.
fn figures(summary: &Summary, units: Units) -> String {
    let mut rows: Vec<Vec<String>> = Vec::new();
    let mut row = |name: &str, (number, unit): (String, String), remark: String| {
        rows.push(vec![name.to_owned(), number, unit, remark]);
    };
    let none = || ("-".to_owned(), String::new());
    row("outcome", (String::new(), String::new()), words::label(summary).to_owned());
    for contact in &summary.contacts {
        let name = if summary.contacts.len() > 1 {
            format!("peak force, {}", contact.name)
        } else {
            "peak force".to_owned()
        };
        row(&name, split(contact.peak_force_n, units.force), words::when(contact));
    }
    if let Some(response) = summary.response {
        row(
            "overshoot",
            response.overshoot.map_or_else(none, |share| (percent(share), "%".into())),
            words::overshoot_of(summary, units),
        );
        if let Some((largest, remark)) = words::tracking(summary, units) {
            row("tracking error", split(largest, units.force), remark);
        } else {
            let within = || format!("to within {} until the end", with_unit(response.band_n, units.force));
            let band = words::rests_outside(summary, units).unwrap_or_else(within);
            row("settling time", response.settling_time_s.map_or_else(none, |time| split(time, "s")), band);
        }
    }
    row("bounces", (summary.bounces.to_string(), String::new()), String::new());
    row(
        "contact time",
        split(summary.contact_time_s, "s"),
        format!("{} % of the run", percent(summary.contact_share)),
    );
    if let Some(oscillation) = &summary.oscillation {
        // Without impacts a motion is not chatter.
        let [frequency, amplitude, impacts] = if oscillation.impacts_per_s > 0.0 {
            let impacts = format!("{} impacts per second", plain(oscillation.impacts_per_s));
            ["chatter frequency", "chatter amplitude", &impacts].map(str::to_owned)
        } else {
            ["oscillation", "amplitude", ""].map(str::to_owned)
        };
        row(&frequency, split(oscillation.frequency_hz, "Hz"), impacts);
        row(
            &amplitude,
            split(oscillation.amplitude_n, words::judged_unit(summary.controlled.as_deref(), units)),
            "half of peak to peak".into(),
        );
    }
    row("saturation", (percent(summary.saturation_share), "%".into()), "of the controller samples".into());
    if let Some(energy) = &summary.energy {
        let sum = |items: &[run::EnergyItem]| items.iter().map(|item| item.joule).sum::<f64>();
        row("energy supplied", split(sum(&energy.supplied), "J"), String::new());
        row("energy dissipated", split(sum(&energy.dissipated), "J"), String::new());
        row(
            "energy balance",
            (plain(energy.relative_residual), String::new()),
            "residual over energy exchanged".into(),
        );
    }
    row(
        "simulated",
        split(summary.simulated_s, "s"),
        format!("{} steps in {}", summary.steps, with_unit(summary.wall_s, "s")),
    );
    table(&[], &[1], rows)
}
