//! Ratios of times on a shared machine.

use std::time::Instant;

/// Times each piece of work in turn, round after round, and returns the median time of each, s.
///
/// Turns spread a busy period of the machine over all of them, and the median drops it. Only ratios of these
/// medians are meaningful.
pub fn medians(rounds: usize, work: &mut [&mut dyn FnMut()]) -> Vec<f64> {
    let mut times = vec![Vec::with_capacity(rounds); work.len()];
    for _ in 0..rounds {
        for (work, times) in work.iter_mut().zip(&mut times) {
            let start = Instant::now();
            work();
            times.push(start.elapsed().as_secs_f64());
        }
    }
    times.into_iter().map(median).collect()
}

/// The median of some times.
///
/// # Panics
/// If there are none.
pub fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
