//! Times the hand-written loops, compiled for the host processor with `rustc -O -C target-cpu=native`. Prints
//! the common CSV.

#[expect(unused_imports, reason = "the library offers more than is needed here")]
#[path = "../src/hand_written/mod.rs"]
mod hand_written;

use std::hint::black_box;
use std::time::Instant;

use hand_written::{Axis, FilteredLoop, FlexibleAxis, FlexibleCell, Method, Plant, run};

const SAMPLES: usize = 2000;
const ROUNDS: usize = 15;

fn main() {
    rows("M1", &Axis::default());
    rows("M2", &FlexibleAxis::default());
    rows("M4", &FlexibleCell::default());
    rows("loop", &FilteredLoop::default());
}

fn rows<const S: usize>(machine: &str, plant: &impl Plant<S>) {
    let methods = [
        (Method::SemiImplicitEuler, "semi-implicit Euler"),
        (Method::Rk4, "RK4"),
        (Method::Rk4WithEvents, "RK4 with events"),
    ];
    for (method, name) in methods {
        for steps in [10, 20, 50, 100] {
            let mut times = Vec::new();
            let mut peak_n = 0.0;
            for _ in 0..ROUNDS {
                let start = Instant::now();
                let result = run(black_box(plant), method, black_box(SAMPLES), black_box(steps));
                times.push(start.elapsed().as_secs_f64() / (SAMPLES as f64 * 1e-3));
                assert!((black_box(result.final_force_n) - 20.0).abs() < 2.0);
                peak_n = result.peak_force_n;
            }
            times.sort_by(f64::total_cmp);
            println!(
                "hand-written Rust,\"{name}\",{machine},{:e},{:.6e},{peak_n:.12}",
                1e-3 / steps as f64,
                times[ROUNDS / 2]
            );
        }
    }
}
