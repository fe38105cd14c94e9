//! One run and nothing else, for instruction counters: `one_run M2 exact 8 2.0` steps M2 for two seconds in eight lanes;
//! `one_run M2 hand-written-rk4-with-events 1 2.0` does the same with the loop written for it.

use std::hint::black_box;

use feeler_benches::hand_written::{Axis, FilteredLoop, FlexibleAxis, FlexibleCell, Method, run};
use feeler_benches::machines::{FILTERED_LOOP, REFERENCES};
use feeler_engine::{Integrator, Program, Simulation, Unobserved};
use feeler_lanes::{Lane, Pack};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [machine, method, lanes, duration_s] = arguments.as_slice() else { return Err("machine, method, lanes, seconds".into()) };
    let duration_s: f64 = duration_s.parse()?;
    if let Some(name) = method.strip_prefix("hand-written-") {
        hand_written(machine, name, (duration_s * 1e3) as usize)
    } else if lanes == "8" {
        simulate::<Pack<8>>(machine, method, duration_s)
    } else {
        simulate::<f64>(machine, method, duration_s)
    }
}

fn simulate<L: Lane>(machine: &str, method: &str, duration_s: f64) -> Result<(), Box<dyn std::error::Error>> {
    let reference = REFERENCES.iter().chain([&FILTERED_LOOP]).find(|reference| reference.short == machine).ok_or("no such machine")?;
    let (integrator, _) = Integrator::ALL.into_iter().find(|(_, name)| *name == method).ok_or("no such integrator")?;
    let mut scenario = reference.unrecorded(integrator, 1e-4)?;
    scenario.run.duration_s = duration_s;
    let mut simulation = Simulation::<L>::new(vec![Program::new(&scenario)?; L::WIDTH])?;
    simulation.run(&mut Unobserved)?;
    black_box(simulation.steps());
    Ok(())
}

fn hand_written(machine: &str, name: &str, samples: usize) -> Result<(), Box<dyn std::error::Error>> {
    let method = match name {
        "semi-implicit-euler" => Method::SemiImplicitEuler,
        "rk4" => Method::Rk4,
        "rk4-with-events" => Method::Rk4WithEvents,
        _ => return Err("no such method".into()),
    };
    black_box(match machine {
        "M1" => run(black_box(&Axis::default()), method, samples, 10),
        "M2" => run(black_box(&FlexibleAxis::default()), method, samples, 10),
        "M4" => run(black_box(&FlexibleCell::default()), method, samples, 10),
        _ => run(black_box(&FilteredLoop::default()), method, samples, 10),
    });
    Ok(())
}
