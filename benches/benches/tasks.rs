//! What a user waits for: a sweep from its file to its table.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot be set up has nothing to measure")]

mod common;

use std::path::Path;

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use feeler_scenarios::sweep::{Options, Sweep};

/// Maps of M2, gain by wall stiffness: two seconds each under its controller at 1 kHz, every measure taken, rows written as Parquet. One element is one
/// variant.
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
                let result = sweep.run(folder.path(), Options { threads: Some(threads), shard: None }, &|_| {}).unwrap();
                assert_eq!(result.progress.done, points * points);
            });
        });
    }
}

criterion_group! { name = suite; config = common::settings(); targets = map }
criterion_main!(suite);
