//! Chatter: a tool that hits the wall again and again, for ever, though nobody pushes it away.
//!
//! The scenario is a file of this repository: force control at 1 kHz with 0.4 ms of delay on a stiff wall. At
//! its gain the loop is unstable in contact. The oscillation grows until the tool leaves the wall, and the
//! flights bound it. At half the gain the same machine settles.
//!
//! ```console
//! cargo run --release --example 02_chatter
//! ```
#![expect(clippy::print_stdout, reason = "a program that tells what it found")]

use std::path::Path;

use feeler_sim::analysis::{ControlLoop, View};
use feeler_sim::files::Draft;
use feeler_sim::studies::run::{RunResult, run};

/// The reference of the force, N.
const WANTED_N: f64 = 20.0;
/// Time from which the transient of the approach no longer counts, s.
const FROM_S: f64 = 2.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/chatter/sustained.toml");
    let with_gain = |kp: f64| Draft::load_with(&file, &[format!("controllers.force.kp={kp}")])?.build();

    // Linear theory of the loop with the tool held to the wall: gains up to here are stable.
    let document = with_gain(1.2)?;
    let held = ControlLoop::new(&document.scenario, &View::CLAMPED)?;
    let limit = held.sampled_bands("controllers.force.kp")?.bands.first().and_then(|band| band.upper.clone());
    let Some(limit) = limit else { return Err("every gain is stable".into()) };
    println!(
        "linear theory: stable up to a gain of {:.3}, then oscillates at {:.1} Hz",
        limit.gain, limit.frequency_hz
    );

    // Beyond the limit, simulated.
    let chatters = run(&document.scenario, &mut |_| {})?;
    println!("gain 1.2: {:?}, {} bounces", chatters.summary.outcome, chatters.summary.bounces);

    // While chatter lasts, the tool is off the wall most of the time, and hits it with several times the
    // desired force. But momentum must balance: over many cycles the wall pushes as hard, on average, as the
    // drive.
    let wall_n = mean(&chatters, "tool.force");
    let drive_n = mean(&chatters, "drive.force");
    println!("mean force of the wall {wall_n:.3} N, by hand {drive_n:.3} N, which is the mean of the drive");
    println!("largest force {:.1} N, for a reference of {WANTED_N} N", chatters.summary.peak_force_n);

    // Half the gain lies below the limit, and the force settles at its reference.
    let settles = run(&with_gain(0.6)?.scenario, &mut |_| {})?;
    println!("gain 0.6: {:?}", settles.summary.outcome);
    println!("mean force of the wall {:.3} N, by hand {WANTED_N:.3} N", mean(&settles, "tool.force"));
    Ok(())
}

/// Mean of a recorded signal after the transient.
fn mean(result: &RunResult, signal: &str) -> f64 {
    let from = result.trace.t_s.partition_point(|t_s| *t_s < FROM_S);
    let values = &result.trace.column(signal).unwrap_or_default()[from..];
    values.iter().sum::<f64>() / values.len() as f64
}
