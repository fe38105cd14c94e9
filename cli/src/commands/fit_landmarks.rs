//! `feeler fit-landmarks`.

use feeler_plant::description::Engagement;
use feeler_scenarios::format::machine_to_toml;
use feeler_validation::landmarks::{Chain, LANDMARK_HZ, fit, simulated_landmarks};

use crate::arguments::FitLandmarks;
use crate::failure::BadInput;
use crate::numbers::{percent, plain};
use crate::table::table;
use crate::terminal;

/// What a written machine says of itself first.
const NOT_THE_ROBOT: &str = "# A chain with the landmarks of the measured robot (Eppinger and Seering 1992, Figs. 15 to 17), made by `feeler fit-landmarks`.\n\
                             # These are not the robot's parameters, which were never published.\n";
/// What the shares mean.
const FREE: &str = "A share above zero says that the landmarks do not tell the parameter by itself. None of the masses, stiffnesses and dampings is told in \
                    its size: all of them together, times any factor, have the same landmarks.";
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
    let missed: Vec<String> = (measured.iter().filter(|(_, found, paper)| (found - paper).abs() > LANDMARK_HZ))
        .map(|(name, found, paper)| format!("{name} (at {} instead of {} Hz)", plain(*found), plain(*paper)))
        .collect();
    let missed = if missed.is_empty() {
        String::new()
    } else {
        format!("\n\nMissed by more than {} Hz: {}. More --iterations may find them.", plain(LANDMARK_HZ), missed.join("; "))
    };
    let landmarks = found.landmarks.against_paper().into_iter().zip(measured);
    let landmarks = landmarks.map(|((name, computed, paper), (_, measured, _))| vec![name, plain(paper), plain(computed), plain(measured)]);
    let landmarks = table(&["landmark (Hz)", "paper", "linear theory", "simulated white noise"], &[1, 2, 3], landmarks);
    let parameters = found.undetermined.iter().zip(found.chain.parameters());
    let parameters = parameters.map(|((name, share), (value, unit))| vec![name.clone(), plain(value), unit.to_owned(), percent(*share)]);
    let parameters = table(&["parameter", "value", "unit", "left free by the landmarks (%)"], &[1, 3], parameters);
    terminal::print(&format!(
        "A chain of masses with the paper's measured landmarks. These are not the robot's parameters, which were never published.\n\n\
         {landmarks}{missed}\n\n{parameters}\n\n{FREE}"
    ))
}
