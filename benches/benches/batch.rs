//! Thousands of variants of one machine: lanes side by side, blocks over threads. One element of throughput
//! is one simulated second of one variant.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot be set up has nothing to measure")]

mod common;

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use feeler_benches::batch::{on_threads, run, variants};
use feeler_benches::machines::REFERENCES;
use feeler_benches::peak::Peak;
use feeler_engine::{Integrator, Program};
use feeler_lanes::{Lane, Pack};

const SIMULATED_S: u64 = 2;

/// Runs all variants for two seconds, including compilation of each variant's modes and exponentials. Every
/// variant must hold its 20 N at the end.
fn hold<L: Lane>(programs: &[Program], threads: usize) -> usize {
    let peaks = on_threads(threads, || run::<L, Peak<L>>(programs)).unwrap();
    for peak in &peaks {
        for l in 0..L::WIDTH {
            assert!(
                (peak.last.lane(l) - 20.0).abs() < 1.0,
                "a variant holds {} N of 20 N",
                peak.last.lane(l)
            );
        }
    }
    peaks.len()
}

/// Variants of M1, M2 and M4 that differ in contact stiffness.
fn batches(criterion: &mut Criterion) {
    let count = if common::quick() { 64 } else { 4096 };
    for reference in &REFERENCES {
        for (integrator, name) in Integrator::ALL {
            let mut scenario = reference.recorded(integrator, 1e-4).unwrap();
            scenario.run.record_rate_hz = Some(100.0);
            let programs = variants(&scenario, count).unwrap();
            let mut group = criterion.benchmark_group(format!(
                "engine/batch/{}/{}/{count}_variants",
                reference.name,
                name.replace('-', "_")
            ));
            group.throughput(Throughput::Elements(SIMULATED_S * count as u64));
            group.sampling_mode(SamplingMode::Flat).sample_size(10);
            group.bench_function("1_lane/1_thread", |bench| bench.iter(|| hold::<f64>(&programs, 1)));
            group.bench_function("4_lanes/1_thread", |bench| bench.iter(|| hold::<Pack<4>>(&programs, 1)));
            group.bench_function("8_lanes/1_thread", |bench| bench.iter(|| hold::<Pack<8>>(&programs, 1)));
            group.bench_function("8_lanes/2_threads", |bench| bench.iter(|| hold::<Pack<8>>(&programs, 2)));
        }
    }
}

criterion_group! { name = suite; config = common::settings(); targets = batches }
criterion_main!(suite);
