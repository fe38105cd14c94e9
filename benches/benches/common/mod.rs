//! Settings that all suites share.

use std::time::Duration;

use criterion::Criterion;

/// Whether `FEELER_BENCH_QUICK` requests the short suites, which end within two minutes.
pub(crate) fn quick() -> bool {
    std::env::var_os("FEELER_BENCH_QUICK").is_some()
}

/// Criterion's settings: short, since ratios within one run are compared.
pub(crate) fn settings() -> Criterion {
    let (warm_up_ms, measure_ms) = if quick() { (50, 250) } else { (500, 2000) };
    Criterion::default()
        .sample_size(if quick() { 10 } else { 20 })
        .warm_up_time(Duration::from_millis(warm_up_ms))
        .measurement_time(Duration::from_millis(measure_ms))
        .without_plots()
}
