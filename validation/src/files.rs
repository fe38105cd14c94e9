//! The paper's machines from their scenario files, against the equations of motion written by hand.

use std::f64::consts::TAU;
use std::path::Path;

use feeler_analysis::{LinearMachine, View};
use feeler_files::Document;
use feeler_lti::C64;
use feeler_plant::description::{ActuatorKind, Machine, Quantity, SignalName};

use crate::error::ValidationError;
use crate::paper::{IDEAL, PaperAxis, PaperModel, SOURCE};
use crate::table::CheckRow;
use crate::truths::axis_response;

/// The files give the base's damper to seven digits. Near its lightly damped zero the error is amplified by
/// the inverse of a damping ratio of 3 %.
const SEVEN_DIGITS: f64 = 1e-6;

/// A model's machine with this drive, from `paper/machines` in the folder of scenario files.
///
/// # Errors
/// [`ValidationError::Reference`] if the file is absent or has mistakes.
fn machine_of_file(
    folder: &Path,
    model: PaperModel,
    drive: ActuatorKind,
) -> Result<Machine, ValidationError> {
    let name = match (model, drive) {
        (PaperModel::Rigid, ActuatorKind::VelocitySource { .. }) => "rigid-source".to_owned(),
        _ => model.name().replace(' ', "-"),
    };
    let path = folder.join("paper/machines").join(name + ".toml");
    let mut machine = Document::load(&path)
        .map_err(|error| ValidationError::Reference { what: error.to_string() })?
        .scenario
        .machine;
    if model != PaperModel::Rigid {
        machine.actuators.values_mut().for_each(|actuator| actuator.kind = drive);
    }
    Ok(machine)
}

/// Every machine of the paper from its file: response, poles and zeros against the equations written by hand
/// and the machine built from parts.
///
/// # Errors
/// [`ValidationError::Reference`] for the files; [`ValidationError::Analysis`].
pub fn file_rows(folder: &Path) -> Result<Vec<CheckRow>, ValidationError> {
    let claim = "three routes agree: equations of motion by hand, state space from the scenario file";
    let (input, output) =
        (SignalName::new("drive", Quantity::Command), SignalName::new("tool", Quantity::SpringForce));
    let frequencies: Vec<f64> = (0..400).map(|i| 0.1 * 10_f64.powf(f64::from(i) / 100.0)).collect();
    let mut rows = Vec::new();
    for model in PaperModel::ALL {
        for (drive_name, drive) in [("ideal", IDEAL), ("source", SOURCE)] {
            let axis = PaperAxis::reference(model, drive);
            let channel =
                |machine: &Machine| LinearMachine::new(machine, &View::CLAMPED)?.channel(&input, &output);
            let (of_file, built) =
                (channel(&machine_of_file(folder, model, drive)?)?, channel(&axis.machine("axis"))?);
            let worst = frequencies.iter().zip(of_file.frequency_response(&frequencies)?).map(|(f, g)| {
                let expected = axis_response(&axis, C64::new(0.0, TAU * f));
                (g - expected).norm() / expected.norm()
            });
            let name = format!("{}, {drive_name}", model.name());
            rows.push(CheckRow::at_most(
                format!("{name}: response of the file, relative difference"),
                claim,
                worst.fold(0.0, f64::max),
                SEVEN_DIGITS,
            ));
            let roots = [(of_file.poles()?, built.poles()?), (of_file.zeros()?, built.zeros()?)];
            let apart = roots.iter().map(|(a, b)| farthest(a, b)).fold(0.0, f64::max);
            rows.push(CheckRow::at_most(
                format!("{name}: poles and zeros of the file, relative difference"),
                claim,
                apart,
                SEVEN_DIGITS,
            ));
        }
    }
    Ok(rows)
}

/// Largest relative distance from a root to the nearest of the others; infinite if their numbers differ.
fn farthest(roots: &[C64], others: &[C64]) -> f64 {
    if roots.len() != others.len() {
        return f64::INFINITY;
    }
    let nearest = |r: &C64| others.iter().map(|o| (o - r).norm() / r.norm()).fold(f64::INFINITY, f64::min);
    roots.iter().map(nearest).fold(0.0, f64::max)
}
