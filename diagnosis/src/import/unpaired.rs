//! The note on logs of which no joint has both an input and a position.

use feeler_logs::{Column, Run, Table};
use feeler_problem::short;
use indexmap::IndexMap;

use super::follow::{Follow, follow};
use super::guess::Guess;
use super::role::ColumnRole;

/// Columns without names that are compared with each other, at most.
const MOST_COMPARED: usize = 6;

/// A column that follows another.
#[derive(Clone, Debug)]
pub(super) struct Lead {
    first: String,
    then: String,
    follow: Follow,
}

/// Of columns that have numbers for names, the two of which one follows the other best. Columns that move at
/// the same time do not count: two encoders do so.
pub(super) fn lead(run: &Run, guesses: &IndexMap<String, Guess>) -> Option<Lead> {
    let table = run.tables.first().filter(|table| guesses.is_empty() && is_nameless(table))?;
    let columns: Vec<&Column> = table.columns.iter().filter(|column| column.present() > 1).collect();
    if columns.len() > MOST_COMPARED {
        return None;
    }
    let pairs = columns.iter().flat_map(|a| columns.iter().map(move |b| (*a, *b)));
    let leads = pairs.filter(|(a, b)| a.number != b.number).filter_map(|(a, b)| {
        let follow = follow((table, a), (table, b)).filter(|follow| follow.is_of_one_motion())?;
        Some(Lead { first: a.name.clone(), then: b.name.clone(), follow })
    });
    leads
        .filter(|lead| lead.follow.lag_s > 0.0)
        .max_by(|a, b| a.follow.correlation.abs().total_cmp(&b.follow.correlation.abs()))
}

fn is_nameless(table: &Table) -> bool {
    table.columns.iter().all(|column| column.name == column.number.to_string())
}

/// A note on the options to state, if no joint of the logs has both an input and a position.
pub(super) fn note(joints: &IndexMap<String, Guess>, lead: Option<&Lead>) -> Option<String> {
    let has = |guess: &Guess, role: ColumnRole| guess.columns.contains_key(&role);
    let has_input = |guess: &Guess| has(guess, ColumnRole::Target) || has(guess, ColumnRole::Command);
    if joints.values().any(|guess| has_input(guess) && has(guess, ColumnRole::Position)) {
        return None;
    }
    let nothing = "no dataset can be written: no joint has both a target (or command) and a position";
    if let Some(Lead { first, then, follow }) = lead {
        return Some(format!(
            "{nothing}. The columns have no names, only numbers. `{then}` follows `{first}` {} ms later \
             (correlation {:.4}); if they are position and target: `--target {first} --position {then}`",
            short(1e3 * follow.lag_s),
            follow.correlation
        ));
    }
    let column = |role: ColumnRole| joints.values().find_map(|guess| guess.columns.get(&role));
    let input = column(ColumnRole::Target).or_else(|| column(ColumnRole::Command));
    Some(match (input, column(ColumnRole::Position)) {
        (Some(input), None) => format!(
            "{nothing}. `{}` is the input: name the position that it moves, by `--position COLUMN`",
            input.column
        ),
        (None, Some(position)) => format!(
            "{nothing}. `{}` is the position: name what was sent to its drive, a target by \
             `--target COLUMN`, a force, current, voltage or duty cycle by `--command COLUMN`",
            position.column
        ),
        _ => format!(
            "{nothing}; name them by `--target COLUMN --position COLUMN`, a force, current, voltage or duty \
             cycle by `--command COLUMN`"
        ),
    })
}
