//! Reads and runs mutated files of the project: `cargo run --release -p feeler-validation --example fuzz --
//! 20000`.
//!
//! Exits with 1 if a case panics or takes longer than ten seconds; the case is then in `fuzz-failed.toml`.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use feeler_validation::fuzz::{Case, Fate, Fuzz};

/// Longest time of a case, s.
const LONGEST_S: f64 = 10.0;
const FAILED: &str = "fuzz-failed.toml";

#[expect(clippy::print_stdout, clippy::print_stderr, reason = "a program that says what it found")]
fn main() -> ExitCode {
    let mut numbers = std::env::args().skip(1).filter_map(|argument| argument.parse::<u64>().ok());
    let (count, first) = (numbers.next().unwrap_or(2000), numbers.next().unwrap_or(0));
    let fuzz = Fuzz::of(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")));
    let present: &'static Mutex<Option<(Case, Instant)>> = Box::leak(Box::default());
    let keep = |case: &Case| {
        std::fs::write(FAILED, format!("# case {} of {}\n{}", case.number, case.from.display(), case.text))
    };
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_millis(200));
            let late = present.lock().ok().and_then(|present| present.clone());
            if let Some((case, started)) = late
                && started.elapsed().as_secs_f64() > LONGEST_S
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
            *present = Some((case.clone(), Instant::now()));
        }
        let Ok((fate, took_s)) = catch_unwind(AssertUnwindSafe(|| case.run())) else {
            let _ = keep(&case);
            eprintln!("case {number} of {} panics: {FAILED}", case.from.display());
            return ExitCode::FAILURE;
        };
        match fate {
            Fate::Refused => refused += 1,
            Fate::Ran => ran += 1,
            Fate::Read => read += 1,
        }
        longest_s = longest_s.max(took_s);
    }
    println!("{count} cases: {refused} refused, {ran} ran, {read} read; the longest took {longest_s:.2} s");
    ExitCode::SUCCESS
}
