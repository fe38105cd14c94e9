//! `feeler schema`.

use feeler_files::{cell_schema, dataset_schema, schema, sweep_schema};

use crate::arguments::{FileKind, Schema};
use crate::terminal;

pub(crate) fn run(arguments: &Schema) -> crate::Result<()> {
    let schema = match arguments.kind {
        FileKind::Machine => schema(),
        FileKind::Arm => cell_schema(),
        FileKind::Sweep => sweep_schema(),
        FileKind::Dataset => dataset_schema(),
    };
    terminal::print(&terminal::json(&schema)?)
}
