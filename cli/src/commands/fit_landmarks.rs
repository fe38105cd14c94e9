//! `feeler fit-landmarks`.

use std::path::Path;

use feeler_files::{Draft, machine_to_toml};
use feeler_plant::description::Engagement;
use feeler_problem::Remedy;
use feeler_validation::ValidationError;
use feeler_validation::landmarks::{Fit, LANDMARK_HZ, LandmarkChain, StartSearch, simulated_landmarks};

use crate::arguments::FitLandmarks;
use crate::numbers::{count, percent, plain};
use crate::terminal;
use crate::terminal::failure::BadInput;
use crate::terminal::table;

/// First comment of a written machine.
const NOT_THE_ROBOT: &str = "# A chain with the landmarks of the measured robot (Eppinger and Seering 1992, \
                             Figs. 15 to 17), made by `feeler fit-landmarks`.\n\
                             # These are not the robot's parameters, which were never published.\n";
/// Explanation of the shares.
const FREE: &str = "A share above zero means that the landmarks do not determine the parameter by itself. \
     They determine masses, stiffnesses and dampings only up to a common factor.";
/// Length of the simulated experiments for the landmarks, s.
const EXPERIMENT_S: f64 = 60.0;

pub(crate) fn run(arguments: &FitLandmarks) -> crate::Result<()> {
    let starts = match &arguments.start {
        Some(path) => vec![from_file(path)?],
        None => (0..arguments.starts).map(LandmarkChain::start).collect(),
    };
    let search = StartSearch::from_starts(&starts, arguments.iterations)?;
    let found = search.fit();
    let machine = found.chain.machine(Engagement::Free);
    if let Some(path) = &arguments.out {
        terminal::write_and_tell(path, &(NOT_THE_ROBOT.to_owned() + &machine_to_toml(&machine)))?;
    }
    if arguments.json {
        return terminal::print(&terminal::json(&search)?);
    }
    let measured = simulated_landmarks(&machine, EXPERIMENT_S)?.against_paper();
    let missed: Vec<String> = (measured.iter().filter(|(_, found, paper)| is_missed(*found, *paper)))
        .map(|(name, found, paper)| format!("{name} (at {} instead of {} Hz)", plain(*found), plain(*paper)))
        .collect();
    let missed = if missed.is_empty() {
        String::new()
    } else {
        format!(
            "\n\nMissed by more than {} Hz: {}. More --starts or --iterations may find them.",
            plain(LANDMARK_HZ),
            missed.join("; ")
        )
    };
    let landmarks = found.landmarks.against_paper().into_iter().zip(measured);
    let landmarks = landmarks.map(|((name, computed, paper), (_, measured, _))| {
        vec![name, plain(paper), plain(computed), plain(measured)]
    });
    let landmarks =
        table(&["landmark (Hz)", "paper", "linear theory", "simulated white noise"], &[1, 2, 3], landmarks);
    let written =
        arguments.out.as_ref().map_or_else(String::new, |path| format!("\n\nwrote\n  {}", path.display()));
    terminal::print(&format!(
        "A chain of masses with the paper's measured landmarks. These are not the robot's parameters, which \
         were never published.\n\n\
         {}\n\n{landmarks}{missed}\n\n{}\n\n{FREE}{written}",
        attempts(&search, arguments.start.as_deref()),
        parameters(&search),
    ))
}

fn from_file(path: &Path) -> crate::Result<LandmarkChain> {
    let document = Draft::load_with(path, &[])?.build()?;
    LandmarkChain::of_machine(&document.scenario.machine).map_err(|error| match error {
        ValidationError::Chain { .. } => {
            BadInput::error(format!("{}: {error}", path.display()), error.remedy())
        }
        other => other.into(),
    })
}

/// Whether a landmark is absent, or differs from the paper's by more than the tolerance.
fn is_missed(found: f64, paper: f64) -> bool {
    (found - paper).abs() > LANDMARK_HZ || found.is_nan()
}

fn attempts(search: &StartSearch, file: Option<&Path>) -> String {
    let farthest = |fit: &Fit| {
        let off = fit.landmarks.against_paper().into_iter().map(|(_, got, paper)| (got - paper).abs());
        off.fold(0.0, |farthest: f64, off| if off.is_nan() { off } else { farthest.max(off) })
    };
    let row = |(i, fit): (usize, &Fit)| {
        let name = file.map_or_else(|| i.to_string(), |file| file.display().to_string());
        let verdict = if fit.reached { "reached" } else { "missed" }.to_owned();
        let shown = if i == search.taken { "shown below" } else { "" }.to_owned();
        vec![name, fit.iterations.to_string(), plain(fit.rms), plain(farthest(fit)), verdict, shown]
    };
    let rows = table(
        &["start", "steps", "residual", "farthest (Hz)", "landmarks", ""],
        &[1, 2, 3],
        search.fits.iter().enumerate().map(row),
    );
    let what = if file.is_some() {
        String::new()
    } else {
        "Each start has the paper's four flexible resonances, its base at 12 Hz and a source that turns the \
         phase at 28 Hz. Start 0 takes the middle of the range of every other parameter; later starts draw \
         from it. No start depends on an earlier fit.\n"
            .to_owned()
    };
    let starts = count(search.fits.len(), "start reaches", "starts reach");
    format!(
        "{what}{} of {starts} every landmark, within {} Hz.\n\n{rows}",
        search.reached(),
        plain(LANDMARK_HZ)
    )
}

/// The chain, its undetermined parameters, and the spread of the fits.
fn parameters(search: &StartSearch) -> String {
    let found = search.fit();
    let rows = found.undetermined.iter().zip(found.chain.parameters()).zip(&search.ranges).map(
        |(((name, share), (value, unit)), range)| {
            let ends = range.map_or_else(|| ["-".to_owned(), "-".to_owned()], |range| range.map(plain));
            [name.clone(), plain(value), unit.to_owned(), percent(*share)].into_iter().chain(ends).collect()
        },
    );
    let header =
        ["parameter", "value", "unit", "share in free directions (%)", "least of all starts", "most"];
    let several = search.reached() > 1;
    let note = if several {
        "\nLeast and most: of the fits that reach every landmark, scaled to the base mass of the fit shown."
    } else {
        ""
    };
    let width = if several { 6 } else { 4 };
    table(&header[..width], &[1, 3, 4, 5][..width - 2], rows.map(|row: Vec<String>| row[..width].to_vec()))
        + note
}
