//! A run exactly as a sweep makes it, with everything that can be shown of it.

use feeler_engine::Scenario;

use super::{Manner, Progress, RunError, RunResult, recorded};
use crate::run::record::recording::Recording;

/// Runs a scenario as a variant of a sweep. The run lasts until its outcome is decided, up to
/// [`super::MOST_EXTENSION`] times its duration. It has rows at the instants of a sweep and no energy ledger.
/// Its figures equal those of the variant's row bit for bit, also for aperiodic motion. The signals requested
/// by the file are recorded at those instants, except for readings of sensors, whose delays would add
/// instants.
///
/// # Errors
/// As [`super::run`].
pub fn run_as_swept(scenario: &Scenario, progress: &mut dyn FnMut(Progress)) -> Result<RunResult, RunError> {
    recorded(scenario, &Recording::as_swept(scenario), Manner { energy: false, extends: true }, progress)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{Outcome, PreparedRun};
    use feeler_files::{Document, Setting};

    /// An aperiodic motion, in which any difference would grow by orders of magnitude within the run, and one
    /// that a sweep extends.
    #[test]
    fn prop_a_run_as_swept_has_the_figures_of_the_row() {
        let document = Document::load(
            &std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios"))
                .join("chatter/sustained.toml"),
        )
        .unwrap();
        for (kp, duration, sustained) in [(2.5, 1.0, true), (0.6, 0.3, false)] {
            let settings =
                [("controllers.force.kp", Setting::Number(kp)), ("run.duration", Setting::Number(duration))];
            let scenario = document.with(settings).unwrap().scenario;
            let row = PreparedRun::new(scenario.clone()).unwrap().measure(0).unwrap().summary;
            let run = run_as_swept(&scenario, &mut |_| {}).unwrap();
            assert_eq!(row.outcome == Outcome::Chatter, sustained, "{:?}", row.verdict);
            assert!(sustained || row.simulated_s > duration);
            assert_eq!(
                format!("{row:?}"),
                format!("{:?}", crate::run::Summary { wall_s: 0.0, ..run.summary })
            );
            assert_eq!(run.trace.names.len(), scenario.run.record.len() - 1, "all but the sensor's reading");
        }
    }

    /// A velocity source that swings at 70 MHz, after the first step of its force. The ledger would take a
    /// million pieces for two milliseconds.
    #[test]
    fn regress_a_motion_too_fast_for_the_ledger_runs_without_it() {
        let document = Document::load(
            &std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios"))
                .join("limits/integral-delay.toml"),
        )
        .unwrap();
        let settings = [
            ("actuators.drive.damping", Setting::Number(1e13)),
            ("controllers.force.reference", Setting::Number(20.0)),
            ("run.duration", Setting::Number(0.012)),
        ];
        let scenario = document.with(settings).unwrap().scenario;
        let kept = crate::run::run(&scenario, &mut |_| {}).unwrap().summary;
        assert_ne!(kept.verdict.undecided, Some(crate::run::Undecided::EventStorm));
        assert!(kept.energy.is_none() && (kept.simulated_s - 0.012).abs() < 1e-12);
    }
}
