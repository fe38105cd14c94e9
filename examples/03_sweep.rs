//! A sweep: the same machine in many variants, and where between them stability ends.
//!
//! A rigid axis of 12 kg is held to its force sensor, a spring `k` of 200 kN/m. Guide and sensor damp it with
//! `b` of 180 N s/m together. Force feedback with gain `K` is sampled every `T` of 1 ms. Each held command is
//! half a period late on average, and that feeds `K k T / 2` of negative damping into the motion. What the
//! machine damps must outweigh it:
//!
//! `K < 2 b / (k T)`, to first order in `T`.
//!
//! ```console
//! cargo run --release --example 03_sweep
//! ```
#![expect(clippy::print_stdout, reason = "a program that tells what it found")]

use std::path::Path;

use feeler_sim::analysis::{ControlLoop, View};
use feeler_sim::studies::sweep::{Sweep, SweepOptions, SweepTable};

const GAIN: &str = "controllers.force.kp";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A sweep file names a scenario and the keys that vary. Here it is written in place; its name only
    // determines the folder for the scenario's path.
    let text = format!(
        "scenario = \"../paper/rigid.toml\"\n\
         [axes]\n\
         \"{GAIN}\" = {{ linear = [1.4, 2.2], points = 33 }}\n"
    );
    let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/sweeps/gain.toml");
    let sweep = Sweep::parse(&text, &place.display().to_string())?;

    // Variants run side by side in vector registers and over all processors. The results are one Parquet
    // file, equal to the last bit for any number of threads.
    let folder = std::env::temp_dir().join(format!("feeler-sweep-{}", std::process::id()));
    let result = sweep.run(&folder, SweepOptions::default(), &|_| {})?;
    let table = SweepTable::read(result.table.as_deref().ok_or("no table was written")?)?;
    std::fs::remove_dir_all(&folder)?;

    // Changes of the outcome from one gain to the next.
    let gains: Vec<f64> = table.reals(GAIN).unwrap_or_default().into_iter().flatten().collect();
    let outcomes = table.texts("outcome").unwrap_or_default();
    let ends_as =
        |name: &'static str| (0..gains.len()).filter(move |row| outcomes[*row].as_deref() == Some(name));
    for row in (0..gains.len()).step_by(4) {
        println!("gain {:.3}: {}", gains[row], outcomes[row].as_deref().unwrap_or("failed"));
    }

    // Next to the edge a swing grows or decays so slowly that a run leaves it undecided. The edge lies
    // between the last gain that settles and the first that is unstable.
    let last = ends_as("settled").next_back().ok_or("no gain settles")?;
    let first = ends_as("unstable").next().ok_or("no gain is unstable")?;
    println!("stability ends between {:.3} and {:.3}", gains[last], gains[first]);
    let simulated = 0.5 * (gains[last] + gains[first]);

    let (stiffness, damping, period_s) = (2e5, 60.0 + 120.0, 1e-3);
    println!("stability ends at {simulated:.4}, by hand {:.4}", 2.0 * damping / (stiffness * period_s));

    // Linear theory needs no runs, and is exact in `T`.
    let held = ControlLoop::new(&sweep.document.scenario, &View::CLAMPED)?;
    let bands = held.sampled_bands(GAIN)?.bands;
    let upper = bands.first().and_then(|band| band.upper.as_ref()).ok_or("every gain is stable")?;
    println!("stability ends at {simulated:.4}, by linear theory {:.4}", upper.gain);
    Ok(())
}
