//! `feeler merge`.

use feeler_studies::sweep::{SweepTable, merge};

use super::swept::Swept;
use crate::arguments::Merge;
use crate::numbers::count;
use crate::pages::sweep::Tally;
use crate::terminal;

pub(crate) fn run(arguments: &Merge) -> crate::Result<()> {
    let out = arguments.out.as_ref().or(arguments.folders.first()).cloned().unwrap_or_default();
    let path = merge(&arguments.folders, &out)?;
    if arguments.json {
        return terminal::print(&terminal::json(&Swept::new(&path, Tally::of(&path)?))?);
    }
    let rows = SweepTable::count_rows(&path)?;
    terminal::print(&format!("{} in {}", count(rows, "variant", "variants"), path.display()))
}
