//! Prints the limits of the stepper as Markdown tables: share of the processor's measured peak, lanes,
//! threads, bodies, contacts, variants.
//!
//! `limits` prints all except the last line of the last table; `limits million` adds a million variants.

#![expect(clippy::print_stdout, reason = "this program's output is its purpose")]

use std::hint::black_box;
use std::time::Instant;

use feeler_benches::batch::{make_and_run, on_threads, run, variants};
use feeler_benches::machines::{REFERENCES, chain, walls};
use feeler_benches::peak::Peak;
use feeler_benches::stopwatch::{median, medians};
use feeler_engine::{Integrator, Program, Scenario, Simulation, Unobserved};
use feeler_lanes::{Lane, Pack, dispatch};
use feeler_plant::motion::Mode;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

const ROUNDS: usize = 7;
const STEP_S: f64 = 1e-4;

fn main() -> Result<()> {
    let peak = peak_gflops();
    println!("Peak of fused multiply-adds, one thread: {peak:.0} GFLOP/s (two operations each).\n");
    share_of_peak(peak)?;
    lanes_and_threads()?;
    parts_of_a_batch()?;
    bodies()?;
    contacts()?;
    let million = std::env::args().any(|argument| argument == "million");
    many_variants(million)
}

/// Eight independent accumulators of eight lanes: enough to hide the latency of a current core's
/// multiply-add, and few enough for registers.
fn peak_gflops() -> f64 {
    const ACCUMULATORS: usize = 8;
    const REPEATS: usize = 4_000_000;
    let times = (0..ROUNDS).map(|_| {
        let (factor, term) = (black_box(Pack([0.999_999; 8])), black_box(Pack([1e-6; 8])));
        let start = Instant::now();
        let sums = dispatch(
            #[inline(always)]
            || {
                let mut sums = [Pack([1.0; 8]); ACCUMULATORS];
                for _ in 0..REPEATS {
                    for sum in &mut sums {
                        *sum = sum.mul_add(factor, term);
                    }
                }
                sums
            },
        );
        black_box(sums);
        start.elapsed().as_secs_f64()
    });
    (2 * 8 * ACCUMULATORS * REPEATS) as f64 / times.fold(f64::INFINITY, f64::min) * 1e-9
}

/// Multiply-adds that one step of one variant requires: one for each nonzero entry of the equations, and the
/// updates.
fn necessary_flops(program: &Program, integrator: Integrator) -> f64 {
    let equations = program.motion().equations(Mode::default());
    let layout = program.motion().layout();
    let (coordinates, states) = (layout.coordinates(), layout.states());
    let entries = |rows: &[Vec<f64>]| rows.iter().flatten().filter(|entry| **entry != 0.0).count();
    let guards: usize =
        equations.guards.iter().map(|guard| guard.row.iter().filter(|entry| **entry != 0.0).count()).sum();
    let step = match integrator {
        Integrator::SemiImplicitEuler => entries(&equations.derivative[coordinates..]) + states,
        // Four slopes, each added to the sum and to the state for the next slope.
        _ => 4 * (entries(&equations.derivative) + 2 * states),
    };
    2.0 * (step + guards) as f64
}

fn share_of_peak(peak_gflops: f64) -> Result<()> {
    println!(
        "| machine | method | lanes | million steps per second | necessary GFLOP/s | share of peak \
         |\n|---|---|---|---|---|---|"
    );
    for reference in &REFERENCES {
        for (integrator, name) in
            [(Integrator::SemiImplicitEuler, "semi-implicit Euler"), (Integrator::Rk4, "RK4")]
        {
            let scenario = reference.unrecorded(integrator, STEP_S)?;
            let flops = necessary_flops(&Program::new(&scenario)?, integrator);
            let rates = [
                (1, stepping::<f64>(&scenario)?),
                (4, stepping::<Pack<4>>(&scenario)?),
                (8, stepping::<Pack<8>>(&scenario)?),
            ];
            for (lanes, wall_s) in rates {
                let rate = f64::from(lanes) * scenario.run.duration_s / STEP_S / wall_s;
                let gflops = rate * flops * 1e-9;
                let share = 100.0 * gflops / peak_gflops;
                println!(
                    "| {} | {name} | {lanes} | {:.1} | {gflops:.1} | {share:.0} % |",
                    reference.short,
                    rate * 1e-6
                );
            }
        }
    }
    println!();
    Ok(())
}

/// Variants of a batch.
const COUNT: usize = 4096;

fn lanes_and_threads() -> Result<()> {
    println!(
        "| {COUNT} variants of M2, 2 s | 4 lanes / 1 lane | 8 lanes / 1 lane | 2 threads / 1 thread | \
         variants per second, 8 lanes, 2 threads |"
    );
    println!("|---|---|---|---|---|");
    for (integrator, name) in Integrator::ALL {
        let programs = variants(&REFERENCES[1].unrecorded(integrator, STEP_S)?, COUNT)?;
        let times = medians(
            3,
            &mut [
                &mut || drop(on_threads(1, || run::<f64, Unobserved>(&programs))),
                &mut || drop(on_threads(1, || run::<Pack<4>, Unobserved>(&programs))),
                &mut || drop(on_threads(1, || run::<Pack<8>, Unobserved>(&programs))),
                &mut || drop(on_threads(2, || run::<Pack<8>, Unobserved>(&programs))),
            ],
        );
        let over = |i: usize, j: usize| times[i] / times[j];
        println!(
            "| {name} | {:.2} | {:.2} | {:.2} | {:.0} |",
            over(0, 1),
            over(0, 2),
            over(2, 3),
            COUNT as f64 / times[3]
        );
    }
    println!();
    Ok(())
}

/// Time shares in a batch of exact runs: construction and the first sample, samples of a run without contact,
/// and the additional cost of contact.
fn parts_of_a_batch() -> Result<()> {
    println!(
        "| {COUNT} variants of M2, exact, 2 s, microseconds of one | 1 lane | 8 lanes | 1 lane / 8 lanes \
         |\n|---|---|---|---|"
    );
    let whole = REFERENCES[1].unrecorded(Integrator::Exact, STEP_S)?;
    let mut short = whole.clone();
    short.run.duration_s = 1e-3;
    let mut far = whole.clone();
    far.machine.contacts.values_mut().for_each(|contact| contact.gap_m = 1e3);
    let mut times = Vec::new();
    for scenario in [&short, &far, &whole] {
        let programs = variants(scenario, COUNT)?;
        let of = medians(
            3,
            &mut [&mut || drop(on_threads(1, || run::<f64, Unobserved>(&programs))), &mut || {
                drop(on_threads(1, || run::<Pack<8>, Unobserved>(&programs)));
            }],
        );
        times.push([of[0], of[1]].map(|wall_s| 1e6 * wall_s / COUNT as f64));
    }
    let line = |part: &str, of: [f64; 2]| {
        println!("| {part} | {:.1} | {:.1} | {:.1} |", of[0], of[1], of[0] / of[1]);
    };
    let less = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
    line("construction, exponentials and the first sample", times[0]);
    line("1999 samples that touch nothing", less(times[1], times[0]));
    line("what touching adds: more exponentials, events located one by one", less(times[2], times[1]));
    line("all", times[2]);
    println!();
    Ok(())
}

/// Wall time of a whole run's stepping, s.
fn stepping<L: Lane>(scenario: &Scenario) -> Result<f64> {
    let program = Program::new(scenario)?;
    let mut times = Vec::new();
    for _ in 0..ROUNDS {
        let mut simulation = Simulation::<L>::new(vec![program.clone(); L::WIDTH])?;
        let start = Instant::now();
        simulation.run(&mut Unobserved)?;
        times.push(start.elapsed().as_secs_f64());
        black_box(simulation.steps());
    }
    Ok(median(times))
}

/// One row: nanoseconds per step of the fixed-step methods, per controller period of the exact one.
fn row(label: usize, scenario: &Scenario) -> Result<()> {
    let mut scenario = scenario.clone();
    scenario.run.duration_s = 0.5;
    scenario.run.step_s = STEP_S;
    let mut cost_ns = |integrator, span_s: f64| -> Result<f64> {
        scenario.run.integrator = integrator;
        Ok(1e9 * stepping::<f64>(&scenario)? * span_s / scenario.run.duration_s)
    };
    let euler = cost_ns(Integrator::SemiImplicitEuler, STEP_S)?;
    let rk4 = cost_ns(Integrator::Rk4, STEP_S)?;
    let exact = cost_ns(Integrator::Exact, 1e-3)?;
    let per = label as f64;
    println!(
        "| {label} | {euler:.0} ({:.1}) | {rk4:.0} ({:.1}) | {exact:.0} ({:.1}) |",
        euler / per,
        rk4 / per,
        exact / per
    );
    Ok(())
}

fn bodies() -> Result<()> {
    println!(
        "| bodies in a chain | semi-implicit Euler, ns per step (per body) | RK4, ns per step (per body) | \
         exact, ns per ms (per body) |"
    );
    println!("|---|---|---|---|");
    for bodies in [2, 4, 8, 16, 32, 64] {
        row(bodies, &chain(bodies)?)?;
    }
    println!();
    Ok(())
}

fn contacts() -> Result<()> {
    println!(
        "| contacts on one body | semi-implicit Euler, ns per step (per contact) | RK4, ns per step (per \
         contact) | exact, ns per ms (per contact) |"
    );
    println!("|---|---|---|---|");
    for contacts in [1, 2, 4, 8, 16] {
        row(contacts, &walls(contacts)?)?;
    }
    println!();
    Ok(())
}

fn many_variants(million: bool) -> Result<()> {
    println!(
        "| variants of M2, exact, 0.2 s each, 2 threads | wall, s | microseconds per variant |\n|---|---|---|"
    );
    let mut scenario = REFERENCES[1].recorded(Integrator::Exact, STEP_S)?;
    scenario.run.duration_s = 0.2;
    scenario.run.record_rate_hz = Some(100.0);
    let counts = [1, 8, 64, 512, 4096, 32_768].into_iter().chain(million.then_some(1_000_000));
    for count in counts {
        let start = Instant::now();
        if count == 1 {
            on_threads(2, || make_and_run::<f64, Peak<f64>>(&scenario, count))?;
        } else {
            on_threads(2, || make_and_run::<Pack<8>, Peak<Pack<8>>>(&scenario, count))?;
        }
        let wall_s = start.elapsed().as_secs_f64();
        println!("| {count} | {wall_s:.3} | {:.1} |", 1e6 * wall_s / count as f64);
    }
    // Only if the system reports the peak memory.
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    if let Some(most) = status.lines().find_map(|line| line.strip_prefix("VmHWM:")) {
        println!("\nPeak memory: {}.", most.trim());
    }
    Ok(())
}
