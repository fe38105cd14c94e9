//! Tasks that a user waits for: a sweep from its file to its table, a diagnosis from records to answer.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot be set up has nothing to measure")]

mod common;

use std::path::Path;

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::diagnose;
use feeler_plant::effects::Kind;
use feeler_studies::sweep::{Sweep, SweepOptions};

/// Maps of M2, gain by wall stiffness: two seconds each under its controller at 1 kHz, with every measure,
/// and rows written as Parquet. One element is one variant.
fn map(criterion: &mut Criterion) {
    let points: u64 = if common::quick() { 8 } else { 64 };
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/reference/m2.toml");
    let text = format!(
        "name = \"map\"\nscenario = \"{}\"\n\n[axes]\n\
         \"contacts.tool.stiffness\" = {{ log = [\"10 kN/m\", \"10 MN/m\"], points = {points} }}\n\
         \"controllers.force.kp\" = {{ log = [0.05, 5.0], points = {points} }}\n",
        scenario.display()
    );
    let sweep = Sweep::parse(&text, "map.toml").unwrap();
    let mut group = criterion.benchmark_group(format!("sweep/map/{points}x{points}"));
    group.throughput(Throughput::Elements(points * points));
    group.sampling_mode(SamplingMode::Flat).sample_size(10);
    for threads in [1, 2] {
        group.bench_function(format!("{threads}_threads"), |bench| {
            bench.iter(|| {
                let folder = tempfile::tempdir().unwrap();
                let result = sweep
                    .run(folder.path(), SweepOptions { threads: Some(threads), shard: None }, &|_| {})
                    .unwrap();
                assert_eq!(result.progress.done, points * points);
            });
        });
    }
}

/// One diagnosis on all processors: calibration, every cause of the library at every place, pairs of causes,
/// and the answer. It uses two records of free motion under sines from the repository's dataset, one to fit
/// and one to check. They show a delay of commands and a further unexplained effect.
fn diagnosis(criterion: &mut Criterion) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/datasets/bench-axis");
    let mut dataset = Dataset::load(&folder).unwrap();
    dataset.records.retain(|record| record.name.starts_with("free-sines"));
    assert_eq!(dataset.records.len(), 2);
    let mut group = criterion.benchmark_group("diagnosis");
    group.sampling_mode(SamplingMode::Flat).sample_size(10);
    group.bench_function("axis_in_free_motion/two_records", |bench| {
        bench.iter(|| {
            let diagnosis = diagnose(&dataset, &|_| {}).unwrap();
            assert!(
                diagnosis.effects.iter().any(|effect| effect.accepted && effect.kind == Kind::CommandDelay)
            );
            diagnosis
        });
    });
}

criterion_group! { name = suite; config = common::settings(); targets = map, diagnosis }
criterion_main!(suite);
