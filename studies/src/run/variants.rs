//! Measures of many variants: no energy ledger, only the signals for the measures, and variants of one
//! structure side by side.

use feeler_engine::{Integrator, Program, RunSettings, Scenario, Simulation, Trace, sharing_exponentials};
use feeler_lanes::{Lane, Pack};

use crate::run::error::RunError;
use crate::run::measure::contact::{ContactRun, Interval};
use crate::run::measure::strobe::Strobe;
use crate::run::record::lanes::{Lanes, Rest};
use crate::run::record::recording::Recording;
use crate::run::verdict::MOST_EXTENSION;
use crate::run::{Ended, Judged, Outcome, Summary, engine};

/// Number of variants side by side.
pub const LANES: usize = 8;
/// A step of all lanes costs as much as one of this many lone variants. If so few variants are undecided,
/// they run again alone, since the other lanes would idle.
const CHEAPER_ALONE: usize = 2;

/// A variant prepared for measuring.
#[derive(Clone, Debug)]
pub struct PreparedRun {
    scenario: Scenario,
    program: Program,
}

/// Measures of a variant.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Figures of the run, without energies.
    pub summary: Summary,
    /// Largest forces of the contacts that began and ended within the tail, N, the last ones in order. Empty
    /// if the tool no longer leaves the wall.
    pub impact_peaks_n: Vec<f64>,
    /// The contact force once per cycle over the tail, N, one sample of the fastest controller after each
    /// touch-down. If the tool stays in contact, it is the maximum of each cycle. So is that of a controlled
    /// motion without contact, which has its own unit. One value if every cycle repeats the last, two after a
    /// period doubling. None of a motion that grows, or whose end is not known.
    pub strobe_n: Vec<f64>,
}

impl PreparedRun {
    /// Checks and prepares a scenario.
    ///
    /// # Errors
    /// Every mistake of machine and wiring.
    pub fn new(scenario: Scenario) -> Result<Self, RunError> {
        let recording = Recording::lean(&scenario);
        let run = RunSettings { energy: false, ..recording.settings(&scenario.run) };
        let scenario = Scenario { run, ..scenario };
        let program = Program::new(&scenario)?;
        Ok(Self { scenario, program })
    }

    /// Whether the two may run side by side.
    pub(crate) fn runs_beside(&self, other: &Self) -> bool {
        // Fixed steps handle events one variant at a time, so there is no advantage.
        self.scenario.run.integrator == Integrator::Exact && self.program.difference(&other.program).is_none()
    }

    /// Measures this variant alone until its outcome is decided, up to [`MOST_EXTENSION`] times its duration.
    /// `tail` limits the number of impacts and strobes that are kept.
    ///
    /// # Errors
    /// Exponentials that cannot be computed. A motion that diverges is a result.
    pub fn measure(&self, tail: usize) -> Result<Measured, RunError> {
        self.measure_resting(tail, &|| {})
    }

    fn measure_resting(&self, tail: usize, rest: Rest<'_>) -> Result<Measured, RunError> {
        let simulation = engine::simulation(self.program.clone(), self.scenario.machine.axis)?;
        let mut measured = measure_lanes(&[self], simulation, &mut Lanes::new(rest), tail)?;
        Ok(measured.swap_remove(0))
    }

    fn judge(&self, record: &Trace, ended: &Ended, tail: usize) -> Measured {
        let judged = Judged::new(&self.scenario, self.program.motion().assembly(), record, ended, None);
        let main = judged.summary.main_contact.map(|i| &judged.contacts[i]).filter(|_| tail > 0);
        let from_s = judged.summary.verdict.tail_s[0];
        let end_s = record.t_s.last().copied().unwrap_or(0.0);
        let impact_peaks_n = main.map_or_else(Vec::new, |contact| {
            // The peak of a contact that the end of the run cuts off is unknown.
            let whole = |interval: &Interval| interval.start_s >= from_s && interval.end_s < end_s;
            let impacts = contact
                .intervals
                .iter()
                .zip(&contact.interval_peaks_n)
                .filter(|(interval, _)| whole(interval));
            let peaks: Vec<f64> = impacts.map(|(_, peak)| *peak).collect();
            peaks[peaks.len().saturating_sub(tail)..].to_vec()
        });
        let signal = judged.summary.controlled.clone().or(main.map(ContactRun::force_signal));
        let force_n = signal.and_then(|signal| record.column(&signal)).filter(|_| tail > 0);
        let contacts = main.map_or(&[][..], |contact| &contact.intervals);
        let strobe_n = force_n.map_or_else(Vec::new, |force_n| {
            self.strobe_n((force_n, contacts), record, &judged.summary, tail)
        });
        Measured { summary: judged.summary, impact_peaks_n, strobe_n }
    }

    /// The judged signal once per cycle, with the spans of its contact.
    fn strobe_n(
        &self,
        (force_n, contacts): (&[f64], &[Interval]),
        record: &Trace,
        summary: &Summary,
        tail: usize,
    ) -> Vec<f64> {
        if matches!(summary.outcome, Outcome::Undecided | Outcome::Unstable) {
            return Vec::new();
        }
        if summary.oscillation.is_none() {
            return force_n.last().copied().into_iter().collect();
        }
        let periods_s = self.scenario.controllers.values().map(|used| used.spec.period_s);
        // Without a controller, the delay is two rows.
        let delay_s = periods_s.reduce(f64::min).unwrap_or(2.0 * self.program.record_spacing_s());
        let values_n =
            Strobe { t_s: &record.t_s, force_n, contacts, tail_s: summary.verdict.tail_s, delay_s }
                .values_n();
        values_n[values_n.len().saturating_sub(tail)..].to_vec()
    }
}

/// Measures variants, side by side if their structure allows it. Each gets the same numbers as alone, bit for
/// bit, in the given order.
pub fn measure(candidates: &[PreparedRun], tail: usize) -> Vec<Result<Measured, RunError>> {
    measure_resting(candidates, tail, &|| {})
}

/// As [`measure`], calling `rest` at each row of each run.
pub(crate) fn measure_resting(
    candidates: &[PreparedRun],
    tail: usize,
    rest: Rest<'_>,
) -> Vec<Result<Measured, RunError>> {
    let mut results: Vec<Option<Result<Measured, RunError>>> = candidates.iter().map(|_| None).collect();
    let mut left: Vec<usize> = (0..candidates.len()).collect();
    let mut lanes = Lanes::new(rest);
    while let Some(&first) = left.first() {
        let alike = left.iter().copied().filter(|&i| candidates[first].runs_beside(&candidates[i]));
        let block: Vec<usize> = alike.take(LANES).collect();
        let block = if block.len() == LANES { block } else { vec![first] };
        left.retain(|i| !block.contains(i));
        if block.len() == LANES
            && let Ok(measured) =
                side_by_side(&block.iter().map(|&i| &candidates[i]).collect::<Vec<_>>(), &mut lanes, tail)
        {
            for (&i, measured) in block.iter().zip(measured) {
                results[i] = Some(Ok(measured));
            }
        }
        // Too few for the lanes, or failed together with another one.
        for &i in &block {
            results[i].get_or_insert_with(|| candidates[i].measure_resting(tail, rest));
        }
    }
    results.into_iter().flatten().collect()
}

fn side_by_side(
    block: &[&PreparedRun],
    lanes: &mut Lanes<'_, Pack<LANES>>,
    tail: usize,
) -> Result<Vec<Measured>, RunError> {
    sharing_exponentials(|| {
        let simulation = Simulation::new(block.iter().map(|candidate| candidate.program.clone()).collect())?;
        measure_lanes(block, simulation, lanes, tail)
    })
}

/// Runs the lanes for their duration, and undecided ones for longer, by doubling.
fn measure_lanes<L: Lane>(
    block: &[&PreparedRun],
    mut simulation: Simulation<L>,
    lanes: &mut Lanes<'_, L>,
    tail: usize,
) -> Result<Vec<Measured>, RunError> {
    let duration_s = block[0].scenario.run.duration_s;
    let mut results: Vec<Option<Measured>> = vec![None; block.len()];
    let mut until_s = duration_s;
    lanes.begin(block.iter().map(|candidate| &candidate.program));
    while results.iter().any(Option::is_none) {
        simulation.run_to(until_s, lanes)?;
        until_s *= 2.0;
        let is_longest = until_s > MOST_EXTENSION * duration_s;
        for l in lanes.open() {
            let ended = Ended { is_longest, ..Ended::of(&simulation, l) };
            let measured = block[l].judge(lanes.trace(l), &ended, tail);
            if !measured.summary.verdict.may_be_decided() || is_longest {
                results[l] = Some(measured);
                lanes.close(l);
                simulation.stop(l);
            }
        }
        let open = lanes.open();
        if L::WIDTH > 1 && open.len() <= CHEAPER_ALONE {
            for l in open {
                let mut measured = block[l].measure_resting(tail, lanes.rest())?;
                // Steps of variants side by side are counted together.
                measured.summary.steps = 0;
                results[l] = Some(measured);
            }
        }
    }
    Ok(results.into_iter().flatten().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Undecided;
    use feeler_files::{Document, Setting};

    fn file(name: &str) -> Document {
        Document::load(&std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")).join(name))
            .unwrap()
    }

    /// Lanes that settle, chatter and are undecided at the end of the run, beside one of another structure.
    #[test]
    fn prop_variants_side_by_side_have_the_bits_they_have_alone() {
        let document = file("chatter/sustained.toml");
        let mut candidates: Vec<PreparedRun> = (0..9)
            .map(|i| {
                let kp = 0.3 + 0.15 * f64::from(i);
                let settings =
                    [("controllers.force.kp", Setting::Number(kp)), ("run.duration", Setting::Number(1.0))];
                PreparedRun::new(document.with(settings).unwrap().scenario).unwrap()
            })
            .collect();
        candidates.insert(3, PreparedRun::new(file("chatter/stiction.toml").scenario).unwrap());
        let together = measure(&candidates, 16);
        let mut sustained = 0;
        for (candidate, together) in candidates.iter().zip(together) {
            let (mut alone, together) = (candidate.measure(16).unwrap(), together.unwrap());
            sustained += usize::from(together.summary.outcome.is_sustained());
            alone.summary.steps = together.summary.steps;
            assert_eq!(format!("{alone:?}"), format!("{together:?}"));
        }
        assert!((2..10).contains(&sustained), "{sustained}");
    }

    /// A cell between those of sweeps/flexible-map.toml whose impacts rise for the first 2 s, and which then
    /// chatters with a bounded amplitude. A stiffness larger by a share of some 1e-13 gives the same
    /// behaviour.
    #[test]
    fn regress_impacts_that_rise_at_first_are_not_called_unstable() {
        let settings = [
            ("contacts.tool.stiffness", Setting::Number(2.524e6)),
            ("controllers.force.kp", Setting::Number(2.03)),
            ("run.duration", Setting::Number(2.0)),
        ];
        let document = file("paper/flexible-contact.toml").with(settings).unwrap();
        let short = crate::run::run(&document.scenario, &mut |_| {}).unwrap();
        assert_eq!(short.summary.verdict.undecided, Some(Undecided::StillGrowing));
        let measured = PreparedRun::new(document.scenario).unwrap().measure(0).unwrap();
        assert_eq!(measured.summary.outcome, Outcome::Chatter);
    }

    fn number(key: &str, value: f64) -> (&str, Setting) {
        (key, Setting::Number(value))
    }

    /// Stuck 7 N from the reference with an integrator that winds up for four seconds: the force rests only
    /// temporarily.
    #[test]
    fn regress_hunting_is_not_settled_while_it_sticks() {
        let settings = [
            number("controllers.force.ki", 1.6),
            number("springs.guide.effects.stribeck-friction.static", 28.0),
            number("run.duration", 6.0),
        ];
        let document = file("chatter/stiction.toml").with(settings).unwrap();
        let short = crate::run::run(&document.scenario, &mut |_| {}).unwrap();
        assert_eq!(short.summary.verdict.undecided, Some(Undecided::StillWinding));
        // Without an integrator nothing winds up: a slow filter moves the command.
        let slow = document.with([
            number("controllers.force.ki", 0.0),
            number("controllers.force.kp", 1.0),
            number("sensors.force.low_pass", 0.02),
        ]);
        let slow = crate::run::run(&slow.unwrap().scenario, &mut |_| {}).unwrap();
        assert_eq!(slow.summary.verdict.undecided, Some(Undecided::TooShort));
        let measured = PreparedRun::new(document.scenario).unwrap().measure(0).unwrap();
        assert_eq!(measured.summary.outcome, Outcome::Hunting, "{:?}", measured.summary.verdict);
    }

    /// At 0.09 mm/s the tool touches after 11.5 s, and at 12 s the force of 2 N that starts the law is not
    /// reached. The run appears at rest and is unstable later.
    #[test]
    fn regress_an_approach_is_not_settled() {
        let settings = [
            number("controllers.force.ki", 200.0),
            number("controllers.force.approach.speed", 0.0872e-3),
            number("run.duration", 12.0),
        ];
        let document = file("chatter/settles.toml").with(settings).unwrap();
        let short = crate::run::run(&document.scenario, &mut |_| {}).unwrap();
        assert_eq!(
            short.summary.verdict.undecided,
            Some(Undecided::StillApproaching),
            "{:?}",
            short.summary.verdict
        );
        let measured = PreparedRun::new(document.scenario).unwrap().measure(0).unwrap();
        assert_eq!(measured.summary.outcome, Outcome::Unstable);
    }

    #[test]
    fn regress_a_tool_on_its_way_is_waited_for() {
        let of = |settings: &[(&str, f64)]| {
            let settings = settings.iter().map(|(key, value)| number(key, *value));
            PreparedRun::new(file("chatter/sustained.toml").with(settings).unwrap().scenario)
                .unwrap()
                .measure(0)
                .unwrap()
                .summary
        };
        assert_eq!(of(&[("run.duration", 0.1)]).outcome, Outcome::Chatter);
        // 1 m away at 30 mm/s.
        let far = of(&[("run.duration", 0.1), ("contacts.tool.gap", 1.0)]);
        assert_eq!(far.outcome, Outcome::NoContact);
        assert!((far.simulated_s - 0.1 * MOST_EXTENSION).abs() < 1e-9, "{}", far.simulated_s);
    }

    /// The strobe of a run at rest is its force. A force at which a run happens to end is not a point of any
    /// map.
    #[test]
    fn regress_a_run_that_is_undecided_has_no_strobe() {
        let of = |duration: f64| {
            let settings = [number("controllers.force.kp", 0.3), number("run.duration", duration)];
            let document = file("chatter/sustained.toml").with(settings).unwrap();
            PreparedRun::new(document.scenario).unwrap().measure(16).unwrap()
        };
        let (rests, ends) = (of(2.0), of(0.05));
        assert!(rests.summary.outcome.is_stable() && rests.strobe_n.len() == 1, "{:?}", rests.strobe_n);
        assert!((rests.strobe_n[0] - 20.0).abs() < 0.4, "{:?}", rests.strobe_n);
        assert_eq!(ends.summary.outcome, Outcome::Undecided);
        assert_eq!(ends.strobe_n, Vec::<f64>::new());
    }

    /// A virtual wall is passive up to 2 b / T = 120 kN/m.
    #[test]
    fn regress_a_virtual_wall_that_grows_is_unstable() {
        for (stiffness, outcome) in
            [(100e3, Outcome::Settled), (140e3, Outcome::Unstable), (300e3, Outcome::Unstable)]
        {
            let document = file("control/virtual-wall.toml")
                .with([number("controllers.wall.stiffness", stiffness)])
                .unwrap();
            let measured = PreparedRun::new(document.scenario).unwrap().measure(0).unwrap();
            assert_eq!(measured.summary.outcome, outcome, "{stiffness}: {:?}", measured.summary.verdict);
        }
        let settings = [number("controllers.wall.stiffness", 300e3), number("actuators.drive.limit", 400.0)];
        let limited = PreparedRun::new(file("control/virtual-wall.toml").with(settings).unwrap().scenario)
            .unwrap()
            .measure(0)
            .unwrap();
        assert_eq!(limited.summary.outcome, Outcome::LimitCycle);
        assert!(
            limited.summary.oscillation.is_some_and(|found| found.frequency_hz > 10.0),
            "{:?}",
            limited.summary.oscillation
        );
    }

    /// Just below the limit of 0.9027 the impacts weaken by 3 to 7 % from part to part, for seconds: not
    /// sustained chatter.
    #[test]
    fn regress_bouncing_that_weakens_slowly_is_no_chatter() {
        for (kp, duration) in [(0.86, 0.7), (0.86, 1.0), (0.88, 1.5)] {
            let settings = [number("controllers.force.kp", kp), number("run.duration", duration)];
            let measured = PreparedRun::new(file("chatter/sustained.toml").with(settings).unwrap().scenario)
                .unwrap()
                .measure(0)
                .unwrap();
            assert_ne!(
                measured.summary.outcome,
                Outcome::Chatter,
                "{kp}, {duration} s: {:?}",
                measured.summary.verdict
            );
        }
        let settings = [number("controllers.force.kp", 0.95), number("run.duration", 0.7)];
        let beyond = PreparedRun::new(file("chatter/sustained.toml").with(settings).unwrap().scenario)
            .unwrap()
            .measure(0)
            .unwrap();
        assert_eq!(beyond.summary.outcome, Outcome::Chatter);
    }

    /// Close to its limit of 0.6067 the loop rings for seconds, and a run of one second is undecided.
    #[test]
    fn truth_an_undecided_run_is_extended_until_it_is_decided() {
        let document = file("limits/sampled-delay.toml");
        let settings = |duration: f64| {
            [("controllers.force.kp", Setting::Number(0.55)), ("run.duration", Setting::Number(duration))]
        };
        let short = crate::run::run(&document.with(settings(1.0)).unwrap().scenario, &mut |_| {}).unwrap();
        assert_eq!(short.summary.verdict.undecided, Some(Undecided::StillDecaying));
        let measured =
            PreparedRun::new(document.with(settings(1.0)).unwrap().scenario).unwrap().measure(0).unwrap();
        assert_eq!(measured.summary.outcome, Outcome::Settled);
        assert!(measured.summary.simulated_s > 1.0);
    }

    /// A step of the reference at 95 % of the run, from 20 N to 25 N, below and beyond the limit of the gain.
    /// Also drives that last.
    #[test]
    fn regress_a_late_step_is_waited_for_and_a_lasting_drive_is_not() {
        use feeler_control::ReferenceSpec::{Multisine, Steps};
        let of = |kp: f64, reference| {
            let settings = [number("controllers.force.kp", kp), number("run.duration", 1.0)];
            let mut scenario = file("limits/sampled-delay.toml").with(settings).unwrap().scenario;
            scenario.controllers[0].spec.reference = reference;
            PreparedRun::new(scenario).unwrap().measure(0).unwrap().summary
        };
        let late = || Steps(vec![(0.0, 20.0), (0.95, 25.0)]);
        let settles = of(0.3, late());
        assert_eq!(settles.outcome, Outcome::Settled, "{:?}", settles.verdict);
        assert!(
            settles.simulated_s > 1.5
                && settles.response.and_then(|response| response.final_reference_n) == Some(25.0)
        );
        assert_eq!(of(0.7, late()).outcome, Outcome::Unstable);
        let staircase = of(0.3, Steps((0..10).map(|i| (0.1 * f64::from(i), 20.0 + f64::from(i))).collect()));
        assert_eq!((staircase.outcome, staircase.simulated_s), (Outcome::Driven, 1.0));
        let square = of(
            0.3,
            Steps((0..40).map(|i| (0.45 * f64::from(i), if i % 2 == 0 { 20.0 } else { 25.0 })).collect()),
        );
        assert_eq!(square.outcome, Outcome::Driven, "{:?}", square.verdict);
        let multisine = Multisine {
            lines: feeler_control::reference::Lines::All,
            low_hz: 1.0,
            high_hz: 40.0,
            period_s: 1.0,
            rms: 1.0,
            offset: 20.0,
        };
        let driven = of(0.3, multisine);
        assert_eq!((driven.outcome, driven.simulated_s), (Outcome::Driven, 1.0));
    }

    /// At kp = -2 the spring of the loop is k (1 + kp) = -k: the contact force only pulls, and never pushes.
    #[test]
    fn regress_a_force_that_only_pulls_has_a_peak() {
        let settings = [number("controllers.force.kp", -2.0)];
        let summary = PreparedRun::new(file("paper/rigid.toml").with(settings).unwrap().scenario)
            .unwrap()
            .measure(0)
            .unwrap()
            .summary;
        assert_eq!(summary.outcome, Outcome::Unstable);
        assert!(summary.peak_force_n > 1e3 && summary.contacts[0].peak_is_pull, "{}", summary.peak_force_n);
        assert_eq!(summary.overshoot, Some(0.0));
    }
}
