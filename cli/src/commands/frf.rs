//! `feeler frf`.

use clap::ValueEnum as _;
use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::measured_response;
use feeler_files::{DatasetFile, Draft};
use feeler_problem::Remedy;
use feeler_studies::frf::{FrequencyResponse, FrfError, csv, json, row, simulate};

use crate::arguments::{ExcitationKind, Frf};
use crate::numbers::plain;
use crate::pages::frf::words;
use crate::terminal::failure::BadInput;
use crate::terminal::table;
use crate::{pages, terminal};

/// Number of rows of the printed table; files have all rows.
const MOST_ROWS: usize = 24;

pub(crate) fn run(arguments: &Frf) -> crate::Result<()> {
    let named_dataset = arguments.source.file_name().is_some_and(|name| name == "dataset.toml");
    let response =
        if arguments.source.is_dir() || named_dataset { measured(arguments)? } else { simulated(arguments)? };
    let mut written = String::new();
    if let Some(folder) = &arguments.out {
        let files = [
            ("frf.csv", csv(&response)),
            ("frf.json", terminal::json(&json(&response))? + "\n"),
            ("report.html", pages::frf::page(&response)),
        ];
        written = terminal::write_all(folder, &files)?;
    }
    terminal::print(&if arguments.json {
        terminal::json(&json(&response))?
    } else {
        text(&response) + &written
    })
}

fn text(response: &FrequencyResponse) -> String {
    let estimate = &response.estimate;
    let lines = estimate.frequencies_hz.len();
    // Evenly spaced on a logarithmic scale.
    let (first, last) = (estimate.frequencies_hz[0], estimate.frequencies_hz[lines - 1]);
    let mut shown: Vec<usize> = (0..MOST_ROWS)
        .map(|i| first * (last / first).powf(i as f64 / (MOST_ROWS - 1) as f64))
        .map(|f| estimate.frequencies_hz.partition_point(|g| *g < f * (1.0 - 1e-9)).min(lines - 1))
        .collect();
    shown.dedup();
    let rows = shown.iter().map(|&i| {
        let row = row(response, i);
        let number = |value: f64| if value.is_finite() { plain(value) } else { "-".to_owned() };
        // The lower end of a band that includes zero is infinite in decibels.
        let span = |low: f64, high: f64| match (low.is_finite(), high.is_finite()) {
            (true, true) => format!("{low:.2} to {high:.2}"),
            (false, true) => format!("below {high:.2}"),
            _ => "-".to_owned(),
        };
        vec![
            plain(row.frequency_hz),
            format!("{:.2}", row.magnitude_db),
            span(row.low_db, row.high_db),
            format!("{:.1}", row.phase_deg),
            number(row.phase_half_width_deg),
            number(row.coherence),
            format!("{:.2}", row.linear_db),
            format!("{:.1}", row.linear_deg),
        ]
    });
    let band = format!("{} % band (dB)", plain(100.0 * response.confidence));
    let header = [
        "f (Hz)",
        "measured (dB)",
        &band,
        "phase (deg)",
        "± (deg)",
        "coherence",
        "linear (dB)",
        "linear (deg)",
    ];
    let about = format!("{}\n\n{}\n{}", words::headline(response), words::path(response), response.how);
    let mut parts = vec![terminal::wrapped(&about)];
    let notes: Vec<String> = response.notes.iter().map(|note| format!("note: {note}")).collect();
    parts.extend((!notes.is_empty()).then(|| terminal::wrapped(&notes.join("\n"))));
    parts.push(table(&header, &[0, 1, 2, 3, 4, 5, 6, 7], rows));
    parts.push(terminal::wrapped(&words::sentences(response).join("\n")));
    parts.join("\n\n")
}

/// The response of a machine, excited in simulation.
fn simulated(arguments: &Frf) -> crate::Result<FrequencyResponse> {
    require(
        arguments.experiments.is_empty(),
        || "--experiment names a record of a dataset, and this is a scenario".to_owned(),
        "name a dataset's folder, or leave --experiment out",
    )?;
    let document = Draft::load_with(&arguments.source, &arguments.settings)?.build()?;
    let request = arguments.request().excited_as(&document.scenario);
    refuse_others(arguments, request.excitation.map_or(ExcitationKind::WhiteNoise, ExcitationKind::from))?;
    simulate(&document.scenario, &request).map_err(|error| refused(arguments, &error))
}

/// The response from the records of a dataset.
fn measured(arguments: &Frf) -> crate::Result<FrequencyResponse> {
    refuse_experiment(arguments)?;
    let file = DatasetFile::load(&arguments.source)?;
    let data = Dataset::load(&arguments.source)?;
    measured_response(&file, &data, &arguments.request()).map_err(|error| refused(arguments, &error))
}

/// Rejects options of another excitation.
fn refuse_others(arguments: &Frf, kind: ExcitationKind) -> crate::Result<()> {
    use ExcitationKind::{Chirp, Multisine, SteppedSine, WhiteNoise};
    let given: [(&str, bool, &[ExcitationKind]); 6] = [
        ("--estimator", arguments.estimator.is_some(), &[WhiteNoise]),
        ("--duration", arguments.duration.is_some(), &[WhiteNoise, Chirp]),
        ("--period", arguments.period.is_some(), &[Multisine]),
        ("--periods", arguments.periods.is_some(), &[Multisine]),
        ("--realisations", arguments.realisations.is_some(), &[Multisine]),
        ("--points", arguments.points.is_some(), &[SteppedSine]),
    ];
    let name = |kind: &ExcitationKind| {
        kind.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    };
    for (option, given, kinds) in given {
        require(
            !given || kinds.contains(&kind),
            || format!("{option} has no meaning for --excitation {}", name(&kind)),
            &format!(
                "leave it out, or add --excitation {}",
                kinds.iter().map(name).collect::<Vec<_>>().join(" or ")
            ),
        )?;
    }
    Ok(())
}

/// Rejects options of a simulated experiment for a recorded one.
fn refuse_experiment(arguments: &Frf) -> crate::Result<()> {
    let given = [
        ("--set", !arguments.settings.is_empty()),
        ("--rms", arguments.rms.is_some()),
        ("--offset", arguments.offset.is_some()),
        ("--periods", arguments.periods.is_some()),
        ("--realisations", arguments.realisations.is_some()),
        ("--points", arguments.points.is_some()),
        ("--duration", arguments.duration.is_some()),
        ("--hold", arguments.hold.is_some()),
        ("--seed", arguments.seed.is_some()),
        ("--clamped", arguments.clamped),
        ("--free", arguments.free),
    ];
    let Some((name, _)) = given.into_iter().find(|(_, given)| *given) else { return Ok(()) };
    Err(BadInput::error(
        format!("{name} applies to a simulated experiment, and this is a dataset"),
        "leave it out, or name a machine file",
    ))
}

fn require(holds: bool, message: impl FnOnce() -> String, remedy: &str) -> crate::Result<()> {
    if holds { Ok(()) } else { Err(BadInput::error(message(), remedy)) }
}

/// An error with the name of the file, unless only the request is wrong.
fn refused(arguments: &Frf, error: &FrfError) -> crate::Failure {
    let message = match error {
        FrfError::Request(refusal) => refusal.message.clone(),
        FrfError::Source(_) | FrfError::Analysis(_) => format!("{}: {error}", arguments.source.display()),
    };
    BadInput::error(message, error.remedy())
}
