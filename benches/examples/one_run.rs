//! One run and nothing else, for instruction counters. `one_run M2 exact 8 2.0` steps M2 for two seconds in
//! eight lanes. `one_run M2 hand-written-rk4-with-events 1 2.0` does the same with the hand-written loop.
//! `chain-32` is a chain of 32 bodies, `force-loop` the loop with everything of a real one. Prints the wall
//! time; a fifth argument repeats the run and prints medians. The hand-written loops are compiled for any
//! processor here; `peers/run` compiles them for the present one.

#![expect(clippy::print_stdout, reason = "this program's output is its purpose")]

use std::hint::black_box;
use std::time::{Duration, Instant};

use feeler_benches::hand_written::{Axis, FilteredLoop, FlexibleAxis, FlexibleCell, Method, run};
use feeler_benches::machines::{FILTERED_LOOP, FORCE_LOOP, REFERENCES, chain, load};
use feeler_benches::stopwatch::median;
use feeler_engine::{Integrator, Program, Simulation, Unobserved};
use feeler_lanes::{Lane, Pack};

const STEP_S: f64 = 1e-4;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [machine, method, lanes, duration_s, times @ ..] = arguments.as_slice() else {
        return Err("machine, method, lanes, seconds, and how many times".into());
    };
    let times = times.first().map_or(Ok(1), |times| times.parse())?;
    let duration_s: f64 = duration_s.parse()?;
    if let Some(name) = method.strip_prefix("hand-written-") {
        hand_written(machine, name, (duration_s * 1e3) as usize, times)
    } else if lanes == "8" {
        simulate::<Pack<8>>(machine, method, duration_s, times)
    } else {
        simulate::<f64>(machine, method, duration_s, times)
    }
}

fn simulate<L: Lane>(
    machine: &str,
    method: &str,
    duration_s: f64,
    times: usize,
) -> Result<(), Box<dyn std::error::Error>> {
    let (integrator, _) =
        Integrator::ALL.into_iter().find(|(_, name)| *name == method).ok_or("no such integrator")?;
    let mut scenario = if let Some(bodies) = machine.strip_prefix("chain-") {
        chain(bodies.parse()?)?
    } else if machine == "force-loop" {
        load(FORCE_LOOP)?
    } else {
        let mut references = REFERENCES.iter().chain([&FILTERED_LOOP]);
        references
            .find(|reference| reference.short == machine)
            .ok_or("no such machine")?
            .unrecorded(integrator, STEP_S)?
    };
    (scenario.run.integrator, scenario.run.step_s, scenario.run.duration_s) =
        (integrator, STEP_S, duration_s);
    scenario.run.record.clear();
    let program = Program::new(&scenario)?;
    let per = |time: Duration, of: f64| 1e9 * time.as_secs_f64() / of / L::WIDTH as f64;
    let mut took = Vec::new();
    for _ in 0..times {
        let programs = vec![program.clone(); L::WIDTH];
        let started = Instant::now();
        let mut simulation = Simulation::<L>::new(programs)?;
        let constructed = started.elapsed();
        let begun = Instant::now();
        simulation.run(&mut Unobserved)?;
        took.push([per(constructed, 1.0), per(begun.elapsed(), 1e3 * duration_s)]);
        black_box(simulation.steps());
    }
    let of = |which: usize| median(took.iter().map(|took| took[which]).collect());
    println!(
        "{:.0} ns of construction, {:.1} ns per simulated millisecond, each of one variant",
        of(0),
        of(1)
    );
    Ok(())
}

fn hand_written(
    machine: &str,
    name: &str,
    samples: usize,
    times: usize,
) -> Result<(), Box<dyn std::error::Error>> {
    let method = match name {
        "semi-implicit-euler" => Method::SemiImplicitEuler,
        "rk4" => Method::Rk4,
        "rk4-with-events" => Method::Rk4WithEvents,
        _ => return Err("no such method".into()),
    };
    let mut took = Vec::new();
    for _ in 0..times {
        let begun = Instant::now();
        black_box(match machine {
            "M1" => run(black_box(&Axis::default()), method, samples, 10),
            "M2" => run(black_box(&FlexibleAxis::default()), method, samples, 10),
            "M4" => run(black_box(&FlexibleCell::default()), method, samples, 10),
            _ => run(black_box(&FilteredLoop::default()), method, samples, 10),
        });
        took.push(1e9 * begun.elapsed().as_secs_f64() / samples as f64);
    }
    println!("{:.1} ns per simulated millisecond", median(took));
    Ok(())
}
