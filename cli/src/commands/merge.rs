//! `feeler merge`.

use feeler_studies::sweep::{SweepTable, merge};

use crate::arguments::Merge;
use crate::numbers::count;
use crate::terminal;

pub(crate) fn run(arguments: &Merge) -> crate::Result<()> {
    let out = arguments.out.as_ref().or(arguments.folders.first()).cloned().unwrap_or_default();
    let path = merge(&arguments.folders, &out)?;
    let rows = SweepTable::count_rows(&path)?;
    terminal::print(&format!("{} in {}", count(rows, "variant", "variants"), path.display()))
}
