//! The columns that the user states, and those that complete them.

use feeler_logs::Run;
use indexmap::IndexMap;

use super::guess::{Chosen, Guess};
use super::role::ColumnRole;
use super::roles::unit;
use crate::error::DiagnosisError;

/// The joint of the stated columns. A position that is not stated is the only one by its name.
pub(super) fn joint(
    run: &Run,
    stated: &[(ColumnRole, String)],
    guesses: &IndexMap<String, Guess>,
) -> Result<Guess, DiagnosisError> {
    let mut joint = Guess::default();
    for (role, column) in stated {
        if let Some((table, numbers)) = run.find(column) {
            let (column, why) = (column.clone(), "it is stated".to_owned());
            joint.columns.insert(*role, Chosen { column, why, unit: unit(*role, table, numbers)? });
        }
    }
    let is_stated = |chosen: &Chosen| stated.iter().any(|(_, column)| *column == chosen.column);
    let positions = guesses.values().filter_map(|guess| guess.columns.get(&ColumnRole::Position));
    let mut free = positions.filter(|chosen| !is_stated(chosen));
    if !joint.columns.contains_key(&ColumnRole::Position)
        && let (Some(only), None) = (free.next(), free.next())
    {
        let why = format!("the only position: {}", only.why);
        joint.columns.insert(ColumnRole::Position, Chosen { why, ..only.clone() });
    }
    Ok(joint)
}
