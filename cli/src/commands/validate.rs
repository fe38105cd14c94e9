//! `feeler validate`.

mod engines;

use std::fs;
use std::path::PathBuf;

use feeler_validation::convergence::{Convergence, convergence, default_steps_s};
use feeler_validation::{Options, Row, Table, validate};

use crate::arguments::{Checks, Validate};
use crate::failure::{BadInput, CheckFailed};
use crate::numbers::{count, plain};
use crate::table::table;
use crate::terminal;

pub(crate) fn run(arguments: &Validate) -> anyhow::Result<()> {
    match arguments.checks {
        Checks::All => all(arguments),
        Checks::Convergence => print_convergence(arguments),
        Checks::Engines => engines::run(arguments),
    }
}

/// The folder of scenario files, where it holds the paper's machines.
fn scenarios(arguments: &Validate) -> Option<PathBuf> {
    let folder = Some(arguments.scenarios.clone()).filter(|folder| folder.join("paper/machines").is_dir());
    if folder.is_none() {
        let what = "the checks from scenario files are left out";
        terminal::complain(&format!("note: no paper/machines in {}; {what}", arguments.scenarios.display()));
    }
    folder
}

fn all(arguments: &Validate) -> anyhow::Result<()> {
    let read = |path: &PathBuf| {
        fs::read_to_string(path).map_err(|error| {
            BadInput::error(format!("cannot read {}: {error}", path.display()), "name the file with --critical-gains, or leave it out")
        })
    };
    let critical_gains_json = arguments.critical_gains.as_ref().map(read).transpose()?;
    let options = Options { critical_gains_json, scenarios: scenarios(arguments), quick: arguments.quick };
    let found = validate(&options, |group| terminal::complain(&format!("checking {group}")))?;
    terminal::print(&if arguments.json { serde_json::to_string_pretty(&found)? } else { text(&found) })?;
    if found.passed() { Ok(()) } else { Err(CheckFailed.into()) }
}

fn text(found: &Table) -> String {
    let row = |row: &Row| {
        let verdict = if row.pass { "pass" } else { "FAIL" };
        let expected = if row.expected.is_nan() { "-".to_owned() } else { plain(row.expected) };
        vec![verdict.to_owned(), row.name.clone(), expected, plain(row.got), plain(row.tolerance), row.claim.clone()]
    };
    let rows = table(&["", "check", "expected", "got", "tolerance", "claim"], &[2, 3, 4], found.rows.iter().map(row));
    let failed = found.failures().count();
    format!("{rows}\n\n{}, {failed} failed", count(found.rows.len(), "check", "checks"))
}

fn print_convergence(arguments: &Validate) -> anyhow::Result<()> {
    let steps_s = default_steps_s();
    let found = convergence(&steps_s)?;
    if arguments.json {
        return terminal::print(&serde_json::to_string_pretty(&found)?);
    }
    let mut header = vec!["step (s)"];
    header.extend(found.iter().map(|c| c.integrator.as_str()));
    let error = |c: &Convergence, i: usize| c.points.get(i).map_or_else(String::new, |point| format!("{:.2e}", point.relative_error));
    let rows = steps_s.iter().enumerate().map(|(i, step)| std::iter::once(plain(*step)).chain(found.iter().map(|c| error(c, i))).collect());
    let slope = |c: &Convergence| if c.slope.is_nan() { "rounding".to_owned() } else { format!("{:.2}", c.slope) };
    let slopes = std::iter::once("order".to_owned()).chain(found.iter().map(slope)).collect();
    let columns: Vec<usize> = (0..header.len()).collect();
    let lines = table(&header, &columns, rows.chain([slopes]).collect::<Vec<Vec<String>>>());
    terminal::print(&format!(
        "Relative error of the peak force of an impact against its closed form; order by regression.\n\n{lines}\n\n\
         The peak is that of the parabola through the three highest samples of a record at the step, which is all that the exact column shows."
    ))
}
