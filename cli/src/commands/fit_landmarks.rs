//! `feeler fit-landmarks`.

use feeler_validation::landmarks::{Chain, fit};

use crate::arguments::FitLandmarks;
use crate::numbers::{percent, plain};
use crate::table::table;
use crate::terminal;

pub(crate) fn run(arguments: &FitLandmarks) -> anyhow::Result<()> {
    let found = fit(&Chain::START, arguments.iterations)?;
    if arguments.json {
        return terminal::print(&serde_json::to_string_pretty(&found)?);
    }
    let landmarks = found.landmarks.against_paper().into_iter().map(|(name, got, paper)| vec![name, plain(paper), plain(got)]);
    let landmarks = table(&["landmark (Hz)", "paper", "chain"], &[1, 2], landmarks);
    let loose = found.undetermined.iter().map(|(name, share)| vec![name.clone(), percent(*share)]);
    let loose = table(&["parameter", "not told by the landmarks"], &[1], loose);
    terminal::print(&format!(
        "A chain of masses with the paper's measured landmarks. These are not the robot's parameters, which were never published.\n\n\
         {landmarks}\n\n{:#?}\n\n{loose}",
        found.chain
    ))
}
