//! Scenarios of this folder, and their results.

use std::path::Path;

use feeler_files::{Document, Setting};
use feeler_studies::run::{RunResult, run};

pub(crate) fn file(name: &str, settings: &[(&str, Setting)]) -> Document {
    let document =
        Document::load(&Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")).join(name));
    document
        .and_then(|document| document.with(settings.iter().cloned()))
        .unwrap_or_else(|mistakes| panic!("{mistakes}"))
}

pub(crate) fn result_of(document: &Document) -> RunResult {
    run(&document.scenario, &mut |_| {}).unwrap_or_else(|error| panic!("{error}"))
}
