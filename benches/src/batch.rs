//! Many variants: lanes side by side, blocks of lanes over threads.

use feeler_engine::{EngineError, Observer, Program, Scenario, Simulation};
use feeler_lanes::Lane;
use rayon::prelude::*;

/// Variant `i` of `count` of a scenario: each has its own contact stiffness, all within 10 % of the file's.
///
/// # Errors
/// Those of [`Program::new`].
pub fn variant(scenario: &Scenario, i: usize, count: usize) -> Result<Program, EngineError> {
    let mut variant = scenario.clone();
    for contact in variant.machine.contacts.values_mut() {
        contact.stiffness *= 0.9 + 0.2 * i as f64 / count as f64;
    }
    Program::new(&variant)
}

/// All `count` variants of a scenario.
///
/// # Errors
/// Those of [`Program::new`].
pub fn variants(scenario: &Scenario, count: usize) -> Result<Vec<Program>, EngineError> {
    (0..count).into_par_iter().map(|i| variant(scenario, i, count)).collect()
}

/// Runs every variant, `L::WIDTH` at a time, over the threads of the current pool; returns each block's
/// observer, in order.
///
/// # Errors
/// Those of [`Simulation::new`] and [`Simulation::run`]; [`EngineError::Lanes`] if the number of variants is
/// not a multiple of the lanes.
pub fn run<L: Lane, O: Observer<L> + Default + Send>(programs: &[Program]) -> Result<Vec<O>, EngineError> {
    programs.par_chunks(L::WIDTH).map(|block| observe::<L, O>(block.to_vec())).collect()
}

/// [`run`] with variants that are created when they run, so that memory does not grow with their number.
///
/// # Errors
/// Those of [`variant`] and [`run`].
pub fn make_and_run<L: Lane, O: Observer<L> + Default + Send>(
    scenario: &Scenario,
    count: usize,
) -> Result<Vec<O>, EngineError> {
    (0..count.div_ceil(L::WIDTH))
        .into_par_iter()
        .map(|block| {
            observe::<L, O>(
                (0..L::WIDTH)
                    .map(|l| variant(scenario, block * L::WIDTH + l, count))
                    .collect::<Result<_, _>>()?,
            )
        })
        .collect()
}

fn observe<L: Lane, O: Observer<L> + Default>(block: Vec<Program>) -> Result<O, EngineError> {
    let mut observer = O::default();
    Simulation::<L>::new(block)?.run(&mut observer)?;
    Ok(observer)
}

/// Does some work on a pool with this number of threads.
///
/// # Panics
/// If the operating system gives no threads.
pub fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("threads can be started")
        .install(work)
}
