//! Processor time of a classical Runge-Kutta step of the six-joint arm, on Linux.
//!
//! The first time is that of the links alone, which `peers/pinocchio_rows.py` steps in the same way. The
//! positions of the links after a second are printed, so that both can be compared. The second time is that
//! of a whole run: flexible joints, drives, tool, workpiece, sensors and controller.

#![expect(clippy::print_stdout, reason = "this program's output is its purpose")]

use std::hint::black_box;
use std::path::Path;

use feeler_arm::{Chain, Urdf};
use feeler_files::CellFile;
use feeler_manipulator::CellSimulation;
use nalgebra::SVector;

const SCENARIOS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/arms");
const START: [f64; 6] = [0.2, -1.1, 1.4, 0.3, 0.8, -0.5];
const SPEEDS: [f64; 6] = [1.0, -0.6, 0.8, 1.5, -2.0, 3.0];
const STEP_S: f64 = 1e-3;
const STEPS: usize = 1000;
/// Swings that are timed together: a second or more.
const ROUNDS: usize = 200;
/// Units of processor time in a second.
const TICKS_PER_S: f64 = 100.0;

type State = SVector<f64, 12>;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = Path::new(SCENARIOS);
    let text = std::fs::read_to_string(folder.join("six-joint.urdf"))?;
    let chain = Urdf::parse(&text)?.chain("tool")?;
    let mut end = swing(&chain);
    let began_s = processor_s()?;
    for _ in 0..ROUNDS {
        end = swing(black_box(&chain));
    }
    let step_us = 1e6 * (processor_s()? - began_s) / (ROUNDS * STEPS) as f64;
    let end = end.ok_or("the mass matrix is not positive definite")?;
    println!("links alone: {step_us:.2} us a step, {:.12?}", end.as_slice());
    let file = CellFile::load(&folder.join("press-low-gain.toml"))?;
    let mut whole = CellSimulation::new(&file.cell, file.record_rate_hz, 1)?;
    let began_s = processor_s()?;
    let steps = whole.run_to(file.cell.scenario.run.duration_s).steps;
    let step_us = 1e6 * (processor_s()? - began_s) / steps as f64;
    println!("whole arm: {step_us:.2} us a step of {steps}");
    Ok(())
}

/// Processor time of this program so far, s.
fn processor_s() -> Result<f64, Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string("/proc/self/stat")?;
    let (_, after_name) = text.rsplit_once(')').ok_or("a process without a name")?;
    let user_ticks: f64 = after_name.split_whitespace().nth(11).ok_or("no processor time")?.parse()?;
    Ok(user_ticks / TICKS_PER_S)
}

/// Joint positions after a second without gravity and torques, as with compensated gravity.
fn swing(chain: &Chain) -> Option<SVector<f64, 6>> {
    let mut x = State::zeros();
    x.fixed_rows_mut::<6>(0).copy_from_slice(&START);
    x.fixed_rows_mut::<6>(6).copy_from_slice(&SPEEDS);
    for _ in 0..STEPS {
        let a = slope(chain, &x)?;
        let b = slope(chain, &(x + 0.5 * STEP_S * a))?;
        let c = slope(chain, &(x + 0.5 * STEP_S * b))?;
        let d = slope(chain, &(x + STEP_S * c))?;
        x += STEP_S / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    }
    Some(black_box(x).fixed_rows::<6>(0).into_owned())
}

fn slope(chain: &Chain, x: &State) -> Option<State> {
    let (q, v) = x.as_slice().split_at(6);
    let posture = chain.posture(q);
    let accelerations = posture.mass_matrix().cholesky()?.solve(&-posture.coriolis_efforts(v));
    let mut slope = State::zeros();
    slope.fixed_rows_mut::<6>(0).copy_from_slice(v);
    slope.fixed_rows_mut::<6>(6).copy_from(&accelerations);
    Some(slope)
}
