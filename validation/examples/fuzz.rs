//! Reads and runs mutated files of the project: `cargo run --release -p feeler-validation --example fuzz --
//! 20000`.
//!
//! Exits with 1 if a case panics or takes longer than ten seconds of processor time. The case is then in
//! `fuzz-failed.toml`.

use std::path::Path;
use std::process::ExitCode;

#[path = "../tests/validation/mutated.rs"]
mod mutated;
#[path = "../tests/validation/watch.rs"]
mod watch;

use mutated::{Fate, Fuzz};
use watch::{Failed, LONGEST_S, within};

const FAILED: &str = "fuzz-failed.toml";

#[expect(clippy::print_stdout, clippy::print_stderr, reason = "a program that says what it found")]
fn main() -> ExitCode {
    let mut numbers = std::env::args().skip(1).filter_map(|argument| argument.parse::<u64>().ok());
    let (count, first) = (numbers.next().unwrap_or(2000), numbers.next().unwrap_or(0));
    let fuzz = Fuzz::of(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")));
    let (mut refused, mut ran, mut read, mut longest_s) = (0, 0, 0, 0.0_f64);
    for number in first..first + count {
        let case = fuzz.case(number);
        let of_case = case.clone();
        match within(LONGEST_S, move || of_case.run()) {
            Ok((fate, taken_s)) => {
                match fate {
                    Fate::Refused => refused += 1,
                    Fate::Ran => ran += 1,
                    Fate::Read => read += 1,
                }
                longest_s = longest_s.max(taken_s);
            }
            Err(failed) => {
                let text = format!("# case {number} of {}\n{}", case.from.display(), case.text);
                let _ = std::fs::write(FAILED, text);
                let what = if failed == Failed::Late { "takes too long" } else { "panics" };
                eprintln!("case {number} of {} {what}: {FAILED}", case.from.display());
                return ExitCode::FAILURE;
            }
        }
    }
    println!("{count} cases: {refused} refused, {ran} ran, {read} read; the longest took {longest_s:.2} s");
    ExitCode::SUCCESS
}
