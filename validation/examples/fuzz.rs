//! Reads and runs mutated files of the project: `cargo run --release -p feeler-validation --example fuzz --
//! 20000`.
//!
//! Exits with 1 if a case panics or takes longer than ten seconds of processor time. Where that cannot be
//! read, the limit is half a minute. The case is then in `fuzz-failed.toml`.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::{Duration, Instant};

#[path = "../tests/validation/mutated.rs"]
mod mutated;

use mutated::{Fate, Fuzz, FuzzCase};

/// Longest processor time of a case, s.
const LONGEST_S: f64 = 10.0;
/// Longest time of a case by the clock, s: other programs may use the same processors.
const LONGEST_WAIT_S: f64 = 120.0;
/// Longest time by the clock if the processor time is not known, s.
const LONGEST_UNKNOWN_S: f64 = 30.0;
/// Units of processor time in a second.
const TICKS_PER_S: f64 = 100.0;
const FAILED: &str = "fuzz-failed.toml";

#[expect(clippy::print_stdout, clippy::print_stderr, reason = "a program that says what it found")]
fn main() -> ExitCode {
    let mut numbers = std::env::args().skip(1).filter_map(|argument| argument.parse::<u64>().ok());
    let (count, first) = (numbers.next().unwrap_or(2000), numbers.next().unwrap_or(0));
    let fuzz = Fuzz::of(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")));
    let present: &'static Mutex<Option<(FuzzCase, Clock)>> = Box::leak(Box::default());
    let keep = |case: &FuzzCase| {
        std::fs::write(FAILED, format!("# case {} of {}\n{}", case.number, case.from.display(), case.text))
    };
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_millis(200));
            let late = present.lock().ok().and_then(|present| present.clone());
            if let Some((case, started)) = late
                && started.is_late()
            {
                let _ = keep(&case);
                eprintln!("case {} of {} takes too long: {FAILED}", case.number, case.from.display());
                std::process::exit(1);
            }
        }
    });
    let (mut refused, mut ran, mut read, mut longest_s) = (0, 0, 0, 0.0_f64);
    for number in first..first + count {
        let case = fuzz.case(number);
        if let Ok(mut present) = present.lock() {
            *present = Some((case.clone(), Clock::new()));
        }
        let clock = Clock::new();
        let Ok(fate) = catch_unwind(AssertUnwindSafe(|| case.run())) else {
            let _ = keep(&case);
            eprintln!("case {number} of {} panics: {FAILED}", case.from.display());
            return ExitCode::FAILURE;
        };
        match fate {
            Fate::Refused => refused += 1,
            Fate::Ran => ran += 1,
            Fate::Read => read += 1,
        }
        longest_s = longest_s.max(clock.taken_s());
    }
    println!("{count} cases: {refused} refused, {ran} ran, {read} read; the longest took {longest_s:.2} s");
    ExitCode::SUCCESS
}

/// Start of a case, by the clock and in processor time of this program.
#[derive(Clone, Copy)]
struct Clock {
    began: Instant,
    processor_s: Option<f64>,
}

impl Clock {
    fn new() -> Self {
        Self { began: Instant::now(), processor_s: processor_s() }
    }

    /// Processor time since the start if it is known, else the time by the clock, s.
    fn taken_s(self) -> f64 {
        let used_s = self.processor_s.zip(processor_s()).map(|(began_s, now_s)| now_s - began_s);
        used_s.unwrap_or_else(|| self.began.elapsed().as_secs_f64())
    }

    fn is_late(self) -> bool {
        let waited_s = self.began.elapsed().as_secs_f64();
        let longest_s = if self.processor_s.is_some() { LONGEST_S } else { LONGEST_UNKNOWN_S };
        self.taken_s() > longest_s || waited_s > LONGEST_WAIT_S
    }
}

/// Processor time of this program so far, on Linux, s.
fn processor_s() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let (_, after_name) = text.rsplit_once(')')?;
    let ticks = after_name.split_whitespace().skip(11).take(2).map(|ticks| ticks.parse::<f64>().ok());
    ticks.sum::<Option<f64>>().map(|ticks| ticks / TICKS_PER_S)
}
