//! The examples print numbers next to hand-computed ones: both must agree.

#![expect(
    clippy::unwrap_used,
    reason = "a file or command of the repository that is not there fails the test"
)]

use std::path::PathBuf;
use std::process::Command;

/// One comparing line of an example: `... VALUE UNIT, by hand VALUE UNIT`.
struct Compared {
    line: String,
    found: f64,
    by_hand: f64,
}

/// Runs an example that `cargo test` has built with this test.
fn run(name: &str) -> Vec<Compared> {
    let mut path: PathBuf = std::env::current_exe().unwrap();
    path.pop();
    path.pop();
    let program = path.join("examples").join(name).with_extension(std::env::consts::EXE_EXTENSION);
    let output = Command::new(&program).output().unwrap_or_else(|error| {
        panic!("{}: {error}; `cargo test -p feeler-sim` builds it", program.display())
    });
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().filter_map(compared).collect()
}

fn compared(line: &str) -> Option<Compared> {
    let (found, by_hand) =
        line.split_once(", by hand ").or_else(|| line.split_once(", by linear theory "))?;
    let number = |word: &str| word.parse::<f64>().ok();
    let found = found.split_whitespace().rev().find_map(number)?;
    let by_hand = by_hand.split(|c: char| c.is_whitespace() || c == ',').find_map(number)?;
    Some(Compared { line: line.to_owned(), found, by_hand })
}

/// Runs an example, and compares its output with the hand-computed values, relatively.
fn holds(name: &str, lines: usize, tolerance: f64) {
    let all = run(name);
    assert_eq!(all.len(), lines, "{name}: another number of comparisons");
    for Compared { line, found, by_hand } in all {
        assert!((found - by_hand).abs() <= tolerance * by_hand.abs(), "{name}: {line}");
    }
}

/// Values are printed to six digits or more. The peak comes from a record at 100 kHz, and between two rows a
/// sine of 100 rad/s turns by 1e-3. So the peak loses (1e-3)^2 / 8 of its height.
const PRINTED: f64 = 1e-5;
/// Two seconds of chatter do not end in the initial state: 12 kg may be 0.1 m/s faster, which is 0.6 N of 20
/// N.
const MOMENTUM: f64 = 0.03;
/// Settling and unstable gains end 0.075 apart (those in between are undecided), so their middle is known to
/// 0.0375 of 1.8.
const EDGE: f64 = 0.021;
/// Damping of 1 % moves a mode by the square of 1 %, and a zero likewise.
const DAMPED: f64 = 1e-3;
/// The force sensor resolves 0.05 N of 20 N.
const PRESSED: f64 = 2.5e-3;

#[test]
fn truth_pressing_a_wall_is_what_a_hand_computes() {
    holds("01_press", 4, PRINTED);
}

#[test]
fn truth_the_wall_pushes_as_hard_as_the_drive_whether_it_chatters_or_not() {
    holds("02_chatter", 2, MOMENTUM);
}

#[test]
fn truth_a_sweep_ends_where_the_hold_outweighs_the_damping() {
    holds("03_sweep", 2, EDGE);
}

#[test]
fn truth_modes_and_zeros_are_those_of_two_masses_on_a_spring() {
    holds("04_theory", 4, DAMPED);
}

#[test]
fn truth_an_arm_presses_with_the_force_that_it_is_asked_for() {
    holds("06_arm", 2, PRESSED);
}
