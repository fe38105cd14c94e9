//! Parts of a run besides stepping: reading a file, compiling a machine, exponentials, events, estimation.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot be set up has nothing to measure")]

mod common;

use std::hint::black_box;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use feeler_benches::machines::{BOUNCING, FORCE_LOOP, REFERENCES, chain, load};
use feeler_benches::peak::Peak;
use feeler_engine::{Program, Simulation};
use feeler_lti::expm;
use feeler_lti::spectral::{Estimator, WelchSettings, cross_spectra};
use nalgebra::DMatrix;

/// From files to a checked scenario, reading included: M2 builds on M1's file, and M4 on M2's.
fn load_files(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("format/load");
    for (name, path) in REFERENCES.iter().map(|r| (r.name, r.path)).chain([("force_loop", FORCE_LOOP)]) {
        group.bench_function(name, |bench| {
            bench.iter(|| {
                let scenario = load(black_box(path)).unwrap();
                assert_eq!(scenario.controllers.len(), 1);
                scenario
            });
        });
    }
}

/// From a checked scenario to a program, and from there to the first simulated millisecond, which needs the
/// exponentials.
fn compile(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("engine/compile");
    let named = REFERENCES.iter().map(|r| (r.name, r.path)).chain([("force_loop", FORCE_LOOP)]);
    for (name, path) in named {
        let scenario = load(path).unwrap();
        group.bench_function(format!("{name}/program"), |bench| {
            bench.iter(|| Program::new(black_box(&scenario)).unwrap());
        });
        let program = Program::new(&scenario).unwrap();
        group.bench_function(format!("{name}/first_millisecond"), |bench| {
            bench.iter_batched(
                || program.clone(),
                |program| {
                    let mut simulation = Simulation::<f64>::new(vec![program]).unwrap();
                    simulation.run_to(1e-3, &mut Peak::default()).unwrap();
                    assert!((simulation.time_s() - 1e-3).abs() < 1e-12);
                    simulation
                },
                BatchSize::SmallInput,
            );
        });
    }
}

/// The exponential of one controller period of a chain of bodies.
fn exponential(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("lti/exponential");
    for bodies in [1, 2, 4, 16, 64] {
        let matrix = chain_matrix(bodies) * 1e-3;
        group.bench_function(format!("{}_states", 2 * bodies), |bench| {
            bench.iter(|| {
                let exponential = expm(black_box(&matrix)).unwrap();
                assert!(exponential[(0, 0)].is_finite());
                exponential
            });
        });
    }
}

/// Positions and speeds of a chain of 1 kg bodies on springs of 1e5 N/m and 20 N s/m.
fn chain_matrix(bodies: usize) -> DMatrix<f64> {
    DMatrix::from_fn(2 * bodies, 2 * bodies, |i, j| {
        let springs = |a: usize, b: usize| match a.abs_diff(b) {
            0 => -2.0,
            1 => 1.0,
            _ => 0.0,
        };
        match (i < bodies, j < bodies) {
            (true, true) => 0.0,
            (true, false) => f64::from(u8::from(i + bodies == j)),
            (false, true) => 1e5 * springs(i - bodies, j),
            (false, false) => 20.0 * springs(i - bodies, j - bodies),
        }
    })
}

/// A run whose cost comes from events, not samples. One element is one located event.
fn events(criterion: &mut Criterion) {
    let scenario = load(BOUNCING).unwrap();
    let program = Program::new(&scenario).unwrap();
    let count = |simulation: &mut Simulation<f64>| {
        let mut peak = Peak::default();
        simulation.run(&mut peak).unwrap();
        peak.events
    };
    let events = count(&mut Simulation::new(vec![program.clone()]).unwrap());
    assert!(events > 1000, "only {events} events");
    let mut group = criterion.benchmark_group("engine/events");
    group.throughput(Throughput::Elements(events));
    group.bench_function("bouncing_hammer/exact/1_lane", |bench| {
        bench.iter_batched(
            || Simulation::new(vec![program.clone()]).unwrap(),
            |mut simulation| assert_eq!(count(&mut simulation), events),
            BatchSize::SmallInput,
        );
    });
}

/// Welch's estimate of a frequency response from a minute at 1 kHz. One element is one sample of the record.
fn frequency_response(criterion: &mut Criterion) {
    const SAMPLES: usize = 60_000;
    const PERIOD_S: f64 = 1e-3;
    // Reproducible noise that excites every line: the top bits of a linear congruential generator (Knuth's
    // constants).
    let mut seed = 1_u64;
    let input: Vec<f64> = (0..SAMPLES)
        .map(|_| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        })
        .collect();
    // y[n] = 0.8 y[n-1] + 0.2 u[n], of gain 1 at low frequency.
    let output: Vec<f64> = (input.iter())
        .scan(0.0, |y, &u| {
            *y = 0.8 * *y + 0.2 * u;
            Some(*y)
        })
        .collect();
    let mut group = criterion.benchmark_group("lti/spectral");
    group.throughput(Throughput::Elements(SAMPLES as u64));
    group.bench_function("welch_frequency_response/1024_samples_per_segment", |bench| {
        bench.iter(|| {
            let spectra =
                cross_spectra(black_box(&input), &output, PERIOD_S, &WelchSettings::hann(1024)).unwrap();
            let estimate = spectra.response(Estimator::H1, 1.0, 400.0).unwrap();
            assert!(
                (estimate.response[0].norm() - 1.0).abs() < 0.05,
                "gain {} at low frequency",
                estimate.response[0].norm()
            );
            estimate
        });
    });
}

/// Compilation of a chain of bodies: the cost of the number of bodies before the first step.
fn compile_chains(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("engine/compile/chain");
    for bodies in [2, 8, 32] {
        let scenario = chain(bodies).unwrap();
        group.bench_function(format!("{bodies}_bodies"), |bench| {
            bench.iter(|| Simulation::<f64>::new(vec![Program::new(black_box(&scenario)).unwrap()]).unwrap());
        });
    }
}

criterion_group! {
    name = suite;
    config = common::settings();
    targets = load_files, compile, compile_chains, exponential, events, frequency_response
}
criterion_main!(suite);
