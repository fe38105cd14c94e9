//! Prints cost and peak force of each integrator, as CSV on standard output; `peers/run` compares it with
//! others.
//!
//! Columns: who, method, machine, step in seconds (empty if the method has none), wall seconds per simulated
//! second, peak contact force in N.

#![expect(clippy::print_stdout, reason = "this program's output is its purpose")]

use std::hint::black_box;
use std::time::Instant;

use feeler_benches::machines::{FILTERED_LOOP, REFERENCES, Reference};
use feeler_benches::peak::peak_of;
use feeler_benches::stopwatch::median;
use feeler_engine::{Integrator, Program, Scenario, Simulation, Unobserved};

const SIMULATED_S: f64 = 2.0;
/// Steps of 1, 0.5, 0.2 and 0.1 of a tenth of a millisecond.
const STEPS_PER_SAMPLE: [usize; 4] = [10, 20, 50, 100];
const ROUNDS: usize = 15;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for reference in REFERENCES.iter().chain([&FILTERED_LOOP]) {
        simulator(reference)?;
    }
    Ok(())
}

fn simulator(reference: &Reference) -> Result<(), Box<dyn std::error::Error>> {
    let exact = Integrator::Exact;
    let peak = peak_of(&reference.recorded(exact, 1e-4)?)?.largest;
    row("exact", reference.short, None, stepping(&reference.unrecorded(exact, 1e-4)?)?, peak);
    row(
        "exact, recorded at 10 kHz",
        reference.short,
        None,
        stepping(&reference.recorded(exact, 1e-4)?)?,
        peak,
    );
    for (integrator, name) in
        [(Integrator::Rk4, "RK4"), (Integrator::SemiImplicitEuler, "semi-implicit Euler")]
    {
        for steps in STEPS_PER_SAMPLE {
            let step_s = 1e-3 / steps as f64;
            let peak = peak_of(&reference.recorded(integrator, step_s)?)?.largest;
            row(
                name,
                reference.short,
                Some(step_s),
                stepping(&reference.unrecorded(integrator, step_s)?)?,
                peak,
            );
        }
    }
    Ok(())
}

/// Wall seconds per simulated second of the stepping alone.
fn stepping(scenario: &Scenario) -> Result<f64, Box<dyn std::error::Error>> {
    let program = Program::new(scenario)?;
    let mut times = Vec::new();
    for _ in 0..ROUNDS {
        let mut simulation = Simulation::<f64>::new(vec![program.clone()])?;
        let start = Instant::now();
        simulation.run(&mut Unobserved)?;
        times.push(start.elapsed().as_secs_f64() / SIMULATED_S);
        black_box(simulation.state(0));
    }
    Ok(median(times))
}

fn row(method: &str, machine: &str, step_s: Option<f64>, wall_s: f64, peak_n: f64) {
    let step = step_s.map_or(String::new(), |s| format!("{s:e}"));
    println!("feeler,\"{method}\",{machine},{step},{wall_s:.6e},{peak_n:.12}");
}
