//! A whole arm: six flexible joints come down on a dome and press it with 20 N.
//!
//! Nothing is reduced to an axis here. The arm is read from a URDF file, with dry friction in its joints. The
//! dome is a mesh. The tool is a ball that may touch it anywhere. Force control along the normal works beside
//! position control of the other directions.
//!
//! ```console
//! cargo run --release --example 06_arm
//! ```
#![expect(clippy::print_stdout, reason = "a program that tells what it found")]

use std::path::Path;

use feeler_sim::files::CellFile;
use feeler_sim::studies::run::run_cell;

/// The reference of the force, N, and the contact's stiffness, N/m.
const WANTED_N: f64 = 20.0;
const STIFFNESS_N_PER_M: f64 = 20e3;
/// Speed of the approach, m/s.
const APPROACH_M_PER_S: f64 = 0.01;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/arms/press-low-gain.toml");
    let cell = CellFile::load(&file)?;
    let result = run_cell(&cell, &mut |_| {})?;
    let summary = &result.summary;
    println!("{}: {:?}, {} events at its joints", cell.name, summary.figures.outcome, summary.joint_events);

    // The integral part of the controller leaves no error at rest, friction of the joints or not.
    println!("presses with {:.3} N in the end, by hand {WANTED_N:.3} N", summary.final_force_n);

    // The contact is a spring, so the force gives its compression.
    let compressions = result.motion.column("tool.compression").ok_or("no compression was recorded")?;
    let depth_m = compressions.last().ok_or("nothing was recorded")?;
    println!(
        "compresses the contact by {:.4} mm, by hand {:.4} mm",
        1e3 * depth_m,
        1e3 * summary.final_force_n / STIFFNESS_N_PER_M
    );

    // On the way down only the approach acts. Friction in six joints takes a little of its speed.
    let touch_s = summary.figures.contacts[0].first_contact_s.ok_or("it never touched")?;
    let at = |t_s: f64| result.motion.t_s.partition_point(|t| *t < t_s);
    let (half, last) = (at(0.5 * touch_s), at(touch_s) - 1);
    let speed =
        (compressions[last] - compressions[half]) / (result.motion.t_s[last] - result.motion.t_s[half]);
    println!("came down at {:.2} mm/s, for a reference of {:.2} mm/s", 1e3 * speed, 1e3 * APPROACH_M_PER_S);
    println!("and got {:.2} mm off its line on the way", 1e3 * summary.sideways_m);
    Ok(())
}
