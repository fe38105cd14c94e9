//! A limit on the processor time of a case.

use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::thread;
use std::time::{Duration, Instant};

/// Longest processor time of a case, s.
pub(crate) const LONGEST_S: f64 = 10.0;
/// Longest time by the clock for each second of processor time: other programs may use the same processors.
const WAITS: f64 = 12.0;
/// Units of processor time in a second.
const TICKS_PER_S: f64 = 100.0;
/// Shortest and longest time between two looks.
const LOOKS: [Duration; 2] = [Duration::from_micros(100), Duration::from_millis(200)];

/// Why a case has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Failed {
    Panicked,
    /// It takes longer than the limit. Its thread goes on.
    Late,
}

/// The result of a job and its processor time, s, if it keeps within `longest_s` of it.
pub(crate) fn within<T: Send + 'static>(
    longest_s: f64,
    job: impl FnOnce() -> T + Send + 'static,
) -> Result<(T, f64), Failed> {
    let (tell, told) = channel();
    let began = Instant::now();
    let taken_s =
        move |own: Option<&Path>| own.and_then(processor_s).unwrap_or_else(|| began.elapsed().as_secs_f64());
    let worker = thread::spawn(move || {
        let own =
            std::fs::read_link("/proc/thread-self").ok().map(|own| Path::new("/proc").join(own).join("stat"));
        let _ = tell.send(own.clone());
        let result = job();
        (result, taken_s(own.as_deref()))
    });
    let own: Option<PathBuf> = told.recv().ok().flatten();
    let mut look = LOOKS[0];
    while !worker.is_finished() {
        thread::sleep(look);
        look = LOOKS[1].min(2 * look);
        let is_late =
            taken_s(own.as_deref()) > longest_s || began.elapsed().as_secs_f64() > WAITS * longest_s;
        if is_late && !worker.is_finished() {
            return Err(Failed::Late);
        }
    }
    worker.join().map_err(|_| Failed::Panicked)
}

/// Processor time of a thread so far, on Linux, s.
fn processor_s(stat: &Path) -> Option<f64> {
    let text = std::fs::read_to_string(stat).ok()?;
    let (_, after_name) = text.rsplit_once(')')?;
    let ticks = after_name.split_whitespace().skip(11).take(2).map(|ticks| ticks.parse::<f64>().ok());
    ticks.sum::<Option<f64>>().map(|ticks| ticks / TICKS_PER_S)
}
