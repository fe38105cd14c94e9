//! `feeler fit-landmarks`.

use feeler_plant::description::Engagement;
use feeler_scenarios::format::machine_to_toml;
use feeler_validation::landmarks::{Chain, fit, simulated_landmarks};

use crate::arguments::FitLandmarks;
use crate::failure::BadInput;
use crate::numbers::{percent, plain};
use crate::table::table;
use crate::terminal;

/// What a written machine says of itself first.
const NOT_THE_ROBOT: &str = "# A chain with the landmarks of the measured robot (Eppinger and Seering 1992, Figs. 15 to 17), made by `feeler fit-landmarks`.\n\
                             # These are not the robot's parameters, which were never published.\n";
/// Length of the simulated experiments that look for the landmarks, s.
const EXPERIMENT_S: f64 = 60.0;

pub(crate) fn run(arguments: &FitLandmarks) -> anyhow::Result<()> {
    let found = fit(&Chain::START, arguments.iterations)?;
    let machine = found.chain.machine(Engagement::Free);
    if let Some(path) = &arguments.out {
        std::fs::write(path, NOT_THE_ROBOT.to_owned() + &machine_to_toml(&machine)).map_err(|error| BadInput::unwritable(path, &error))?;
    }
    if arguments.json {
        return terminal::print(&serde_json::to_string_pretty(&found)?);
    }
    let measured = simulated_landmarks(&machine, EXPERIMENT_S)?.against_paper();
    let landmarks = found.landmarks.against_paper().into_iter().zip(measured);
    let landmarks = landmarks.map(|((name, computed, paper), (_, measured, _))| vec![name, plain(paper), plain(computed), plain(measured)]);
    let landmarks = table(&["landmark (Hz)", "paper", "linear theory", "simulated white noise"], &[1, 2, 3], landmarks);
    let loose = found.undetermined.iter().map(|(name, share)| vec![name.clone(), percent(*share)]);
    let loose = table(&["parameter", "not told by the landmarks (%)"], &[1], loose);
    terminal::print(&format!(
        "A chain of masses with the paper's measured landmarks. These are not the robot's parameters, which were never published.\n\n\
         {landmarks}\n\n{:#?}\n\n{loose}",
        found.chain
    ))
}
