//! A diagnosis ends in its time, with a whole answer.

use std::f64::consts::TAU;
use std::time::{Duration, Instant};

use feeler_diagnosis::adequacy::Condition;
use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::report::AttemptOutcome;
use feeler_diagnosis::{Budget, Diagnosis, diagnose_within};

use crate::recovery::{BELIEVED, SPACING_S, recorded};

const ROWS: usize = 12_000;
/// Time beyond the budget, in times of a diagnosis without any, which does what cannot be left out. The
/// promise is a deadline, not a speed: tests share the cores with others, and this measures how busy these
/// are.
const MARGIN: u32 = 3;

/// Dry friction, a soft joint, ripple and a delay, in long records.
const REAL: &str = "
    [springs.guide.effects.coulomb-friction]
    level = 12.0
    [actuators.drive.effects.force-ripple]
    amplitude = 8.0
    pitch = 2.0e-4
    phase = 0.5
    [actuators.drive.effects.command-delay]
    delay = 1.6e-3
    [springs.transmission.effects.transmission-flexibility]
    stiffness = 9.0e5
    damping = 60.0
    tip_mass = 5.0
";

/// A chirp of 1 to 100 Hz.
fn chirp(peak_n: f64, turn: f64) -> Vec<f64> {
    let lasts_s = ROWS as f64 * SPACING_S;
    let wave = |t: f64| peak_n * (TAU * (t + 49.5 * t * t / lasts_s) + turn).sin();
    (0..ROWS).map(|k| wave(k as f64 * SPACING_S)).collect()
}

/// The answer, which came within the budget and the margin.
pub(crate) fn in_time(dataset: &Dataset, budget: Duration) -> Diagnosis {
    let within = |budget: Duration| {
        let begun = Instant::now();
        let answer = diagnose_within(dataset, Budget::of(budget), &|_| {}).expect("there is an answer");
        (answer, begun.elapsed())
    };
    let ((_, least), (answer, took)) = (within(Duration::ZERO), within(budget));
    assert!(took < budget + MARGIN * least, "{took:?} for {budget:?}, {least:?} for none");
    answer
}

#[test]
fn truth_a_hard_case_is_answered_within_its_budget() {
    let levels = [(90.0, false), (60.0, false), (25.0, false), (40.0, false), (70.0, true), (30.0, true)];
    let commands: Vec<_> =
        (0_u8..).zip(levels).map(|(i, (peak_n, is_check))| (chirp(peak_n, f64::from(i)), is_check)).collect();
    let dataset = recorded([BELIEVED, &format!("{BELIEVED}{REAL}")], &commands, &[2e-7, 0.03, 0.03]);
    for budget in [2, 5].map(Duration::from_secs) {
        let answer = in_time(&dataset, budget);
        // The answer has the gap, its place, and all that was not tried.
        assert!(answer.gap.refit.is_finite() && !answer.places.is_empty() && !answer.cells.is_empty());
        let untried =
            answer.attempts.iter().filter(|attempt| matches!(attempt.why, AttemptOutcome::NotTried)).count();
        let said = answer.adequacy.shortfalls.iter().find(|short| short.condition == Condition::Tried);
        let said = &said.unwrap_or_else(|| panic!("{budget:?}: {:?}", answer.adequacy.shortfalls)).what;
        assert!(untried > 0 && said.contains(&format!("{untried} causes")), "{untried}: {said}");
    }
}
