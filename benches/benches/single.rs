//! Speed of one variant, and of one block of lanes, on one thread. Throughput counts simulated milliseconds.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot be set up has nothing to measure")]

mod common;

use std::hint::black_box;

use criterion::{
    BatchSize, BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main, measurement::WallTime,
};
use feeler_benches::hand_written::{Axis, FilteredLoop, FlexibleAxis, FlexibleCell, Method, Plant, run};
use feeler_benches::machines::{FILTERED_LOOP, FORCE_LOOP, REFERENCES, Reference, load};
use feeler_benches::peak::peak_of;
use feeler_engine::{Integrator, Program, RunEnd, Scenario, Simulation, Unobserved};
use feeler_lanes::{Lane, Pack};

const SAMPLES: usize = 2000;
const STEP_S: f64 = 1e-4;
/// Tolerance of the peak force, relative to the reference. The exact integrator differs by rounding only. At
/// 0.1 ms, the fixed-step tolerance covers first-order steps without events on the worst machine.
const EXACT_TOLERANCE: f64 = 1e-9;
const FIXED_STEP_TOLERANCE: f64 = 0.05;

fn settled<L: Lane>(group: &mut BenchmarkGroup<WallTime>, name: &str, scenario: &Scenario) {
    let program = Program::new(scenario).unwrap();
    group.bench_function(name, |bench| {
        bench.iter_batched(
            || Simulation::<L>::new(vec![program.clone(); L::WIDTH]).unwrap(),
            |mut simulation| {
                simulation.run(&mut Unobserved).unwrap();
                assert_eq!(simulation.end(0), Some(RunEnd::Completed));
                simulation
            },
            BatchSize::SmallInput,
        );
    });
}

/// Steps M1, M2, M4 and the filtered loop for two seconds under sampled force control. The time excludes
/// construction, and no signal is recorded.
fn reference_machines(criterion: &mut Criterion) {
    for reference in REFERENCES.iter().chain([&FILTERED_LOOP]) {
        for (integrator, name) in Integrator::ALL {
            let tolerance =
                if integrator == Integrator::Exact { EXACT_TOLERANCE } else { FIXED_STEP_TOLERANCE };
            let peak = peak_of(&reference.recorded(integrator, STEP_S).unwrap()).unwrap().largest;
            assert!(
                (peak / reference.peak_force_n - 1.0).abs() < tolerance,
                "{} {name}: peak force {peak} N",
                reference.short
            );
            let scenario = reference.unrecorded(integrator, STEP_S).unwrap();
            let mut group = criterion.benchmark_group(format!(
                "engine/step/{}/{}",
                reference.name,
                name.replace('-', "_")
            ));
            group.throughput(Throughput::Elements(SAMPLES as u64));
            settled::<f64>(&mut group, "1_lane", &scenario);
            group.throughput(Throughput::Elements(8 * SAMPLES as u64));
            settled::<Pack<8>>(&mut group, "8_lanes", &scenario);
        }
    }
}

/// The exact runs of M1, M2 and M4 with the contact force recorded every 0.1 ms: the cost of a trace.
fn recorded(criterion: &mut Criterion) {
    for reference in &REFERENCES {
        let scenario = reference.recorded(Integrator::Exact, STEP_S).unwrap();
        let mut group = criterion.benchmark_group(format!("engine/step/{}/exact", reference.name));
        group.throughput(Throughput::Elements(SAMPLES as u64));
        settled::<f64>(&mut group, "recorded_at_10_khz/1_lane", &scenario);
    }
}

/// Two seconds of a force loop with an approach, friction and delayed commands. Its sensor has noise,
/// resolution, a filter and a delay.
fn force_loop(criterion: &mut Criterion) {
    let mut scenario = load(FORCE_LOOP).unwrap();
    let settled_force = peak_of(&scenario).unwrap().last;
    assert!((settled_force - 30.0).abs() < 2.0, "the loop holds {settled_force} N of 30 N");
    scenario.run.record.clear();
    for (integrator, name) in Integrator::ALL {
        scenario.run.integrator = integrator;
        let mut group = criterion.benchmark_group(format!("engine/force_loop/{}", name.replace('-', "_")));
        group.throughput(Throughput::Elements(SAMPLES as u64));
        settled::<f64>(&mut group, "1_lane", &scenario);
        group.throughput(Throughput::Elements(8 * SAMPLES as u64));
        settled::<Pack<8>>(&mut group, "8_lanes", &scenario);
    }
}

/// The loops that an expert would write by hand for these machines, at a step of 0.1 ms.
fn hand_written(criterion: &mut Criterion) {
    for reference in &REFERENCES {
        match reference.short {
            "M1" => yardstick(criterion, reference, &Axis::default()),
            "M2" => yardstick(criterion, reference, &FlexibleAxis::default()),
            _ => yardstick(criterion, reference, &FlexibleCell::default()),
        }
    }
    yardstick(criterion, &FILTERED_LOOP, &FilteredLoop::default());
}

fn yardstick<const S: usize>(criterion: &mut Criterion, reference: &Reference, plant: &impl Plant<S>) {
    let mut group = criterion.benchmark_group(format!("hand_written/step/{}", reference.name));
    group.throughput(Throughput::Elements(SAMPLES as u64));
    let methods = [
        (Method::SemiImplicitEuler, "semi_implicit_euler"),
        (Method::Rk4, "rk4"),
        (Method::Rk4WithEvents, "rk4_with_events"),
    ];
    for (method, name) in methods {
        group.bench_function(name, |bench| {
            bench.iter(|| {
                let result = run(black_box(plant), method, black_box(SAMPLES), black_box(10));
                assert!((result.peak_force_n / reference.peak_force_n - 1.0).abs() < FIXED_STEP_TOLERANCE);
                result
            });
        });
    }
}

criterion_group! {
    name = suite;
    config = common::settings();
    targets = reference_machines, recorded, force_loop, hand_written
}
criterion_main!(suite);
