//! `feeler validate`.

mod engines;

use std::fs;
use std::path::{Path, PathBuf};

use feeler_problem::Remedy;
use feeler_validation::convergence::{convergence, default_steps_s, markdown};
use feeler_validation::{CheckRow, CheckTable, RowKind, ValidateOptions, ValidationError, validate};

use crate::arguments::{Checks, DEFAULT_SCENARIOS, Validate};
use crate::numbers::{count, plain, to_tolerance};
use crate::terminal;
use crate::terminal::failure::{BadInput, Failure};
use crate::terminal::table;

pub(crate) fn run(arguments: &Validate) -> crate::Result<()> {
    match arguments.checks {
        Checks::All => all(arguments),
        Checks::Convergence => print_convergence(arguments),
        Checks::Engines => engines::run(scenarios(arguments)?.as_deref(), arguments.json),
    }
}

/// The folder of scenario files, if it contains the paper's machines.
fn scenarios(arguments: &Validate) -> crate::Result<Option<PathBuf>> {
    let folder = Some(arguments.scenarios.clone()).filter(|folder| folder.join("paper/machines").is_dir());
    if folder.is_none() {
        if arguments.scenarios != Path::new(DEFAULT_SCENARIOS) {
            let message = format!("no paper/machines in {}", arguments.scenarios.display());
            return Err(BadInput::error(message, "name the folder of the scenario files with --scenarios"));
        }
        let what = "checks of scenario files are skipped";
        terminal::complain(&format!("note: no paper/machines in {}; {what}", arguments.scenarios.display()));
    }
    Ok(folder)
}

fn all(arguments: &Validate) -> crate::Result<()> {
    let read = |path: &PathBuf| {
        fs::read_to_string(path).map_err(|error| {
            BadInput::error(
                format!("cannot read {}: {error}", path.display()),
                "name the file with --critical-gains, or leave it out",
            )
        })
    };
    let critical_gains_json = arguments.critical_gains.as_ref().map(read).transpose()?;
    let options =
        ValidateOptions { critical_gains_json, scenarios: scenarios(arguments)?, quick: arguments.quick };
    let found =
        validate(&options, |group| terminal::complain(&format!("checking {group}"))).map_err(|error| {
            match error {
                ValidationError::Reference { .. } => BadInput::error(
                    arguments
                        .critical_gains
                        .as_ref()
                        .map_or_else(|| error.to_string(), |path| format!("{}: {error}", path.display())),
                    error.remedy(),
                ),
                other => other.into(),
            }
        })?;
    let left_out = if arguments.critical_gains.is_none() {
        "\nnot checked: independent critical gains (name their file with --critical-gains)"
    } else {
        ""
    };
    terminal::print(&if arguments.json { terminal::json(&found)? } else { text(&found) + left_out })?;
    if found.passed() { Ok(()) } else { Err(Failure::CheckFailed) }
}

fn text(found: &CheckTable) -> String {
    let row = |row: &CheckRow| {
        let verdict = if row.pass { "pass" } else { "FAIL" };
        let [expected, got, difference, tolerance] = words(row);
        vec![verdict.to_owned(), row.name.clone(), expected, got, difference, tolerance, row.claim.clone()]
    };
    let header = ["", "check", "expected", "got", "difference", "tolerance", "claim"];
    let rows = table(&header, &[2, 3, 4, 5], found.rows.iter().map(row));
    let failed = found.failures().count();
    format!("{rows}\n\n{}, {failed} failed", count(found.rows.len(), "check", "checks"))
}

/// Expected and actual value with enough digits to separate them, their difference, and its tolerance.
fn words(row: &CheckRow) -> [String; 4] {
    let yes = |value: f64| if value > 0.5 { "yes".to_owned() } else { "no".to_owned() };
    let none = || "-".to_owned();
    match row.kind {
        RowKind::Holds => [yes(row.expected), yes(row.got), none(), none()],
        RowKind::Above => [format!("> {}", plain(row.expected)), plain(row.got), none(), none()],
        RowKind::AtMost => [format!("<= {}", plain(row.tolerance)), plain(row.got), none(), none()],
        RowKind::Close => {
            let difference = row.got - row.expected;
            let difference = if difference.is_finite() { format!("{difference:+.1e}") } else { none() };
            let expected =
                if row.expected.is_nan() { none() } else { to_tolerance(row.expected, row.tolerance) };
            [expected, to_tolerance(row.got, row.tolerance), difference, plain(row.tolerance)]
        }
    }
}

fn print_convergence(arguments: &Validate) -> crate::Result<()> {
    if !arguments.scenarios.join("reference").is_dir() {
        let message = format!("no reference machines in {}", arguments.scenarios.display());
        return Err(BadInput::error(message, "name the folder of the scenario files with --scenarios"));
    }
    let study = convergence(&arguments.scenarios, &default_steps_s())?;
    terminal::print(&if arguments.json { terminal::json(&study)? } else { markdown(&study) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_a_row_shows_the_digits_and_the_difference_that_it_is_about() {
        let row = CheckRow::relative("gain", "", 3.825_132_1, 3.825_131_9, 1e-6);
        let [expected, got, difference, tolerance] = words(&row);
        assert_eq!((expected.as_str(), got.as_str()), ("3.82513190", "3.82513210"));
        assert_eq!((difference.as_str(), tolerance.as_str()), ("+2.0e-7", "3.83e-6"));
        let unbounded = words(&CheckRow::close("gain", "", f64::INFINITY, f64::INFINITY, 1e-6));
        assert_eq!((unbounded[1].as_str(), unbounded[2].as_str()), ("∞", "-"));
    }
}
