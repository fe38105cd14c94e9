//! What became of a run: settled, chattering, unstable, or something else, by criteria on its tail.
//!
//! The *tail* is the second half of what follows the last change of the reference or the first touch,
//! whichever is later (the second half of what follows the first touch where the reference moves to the end).
//! It is cut into three equal parts whose amplitudes `A1, A2, A3` (half of peak to peak of the force, less
//! its reference where that moves) tell growth from decay. In this order:
//!
//! | outcome | when |
//! |---|---|
//! | unstable | the motion left all bounds; or it grows ([`growth`]) and never left the workpiece, or still grows at the end of the longest extension |
//! | no-contact | the tool never touched, or left for good before the tail, and is not on its way: no controller approaches, and no gap would close at its present rate and acceleration within the longest extension |
//! | chatter | at least 3 lift-offs in the tail, 2 of them in its last part, and `A3 >= 0.7 A1` with no fall by 3 % that goes on to the end, and impacts of which the last ones do not each fall short of the one before by 1 % |
//! | driven | a reference moves to the end, in even steps too, so that there is nothing to settle at |
//! | settled, bounces-then-settles | `A3` within the settling band (2 % of the force wanted, or four sigma of the sensor's noise where that is more; steps of the sensor do not widen it), no lift-off in the last part, no controller in its approach, no command that moves on while the force rests, and no growth from part to part that goes on; by whether the tool had left the workpiece |
//! | limit-cycle | the force oscillates and does not decay, and a drive or controller is at its limit for over 1 % of the tail |
//! | hunting | the same, no limit is reached, and a guide sticks or breaks loose at least twice |
//! | oscillates | the same with neither, over 12 cycles at least or to the end of the longest extension |
//! | undecided | none of these: oscillation or bouncing that decays but has not ended, that creeps up or down (by a line through the logarithms of the amplitudes of 4 to 24 windows, see [`super::trend`]; by more than 1.05 from part to part where there are fewer than 12 cycles), a tool on its way, a reference that was at rest over a fifth of the run and has moved in the last one, a command that winds, growth in a run that left the workpiece and may yet be bounded by that, or a tail too short to judge, with less than two cycles of what lasts or grows |
//!
//! Where nothing can touch, so that a wall is one that a controller renders, the first drive's command takes
//! the force's place: it is unstable where that grows (and at the end of the longest extension where it
//! creeps up), a limit cycle where it swings between limits, and `no-contact` otherwise.
//!
//! A longer run decides most of what a short one leaves undecided: [`super::measure()`] extends the run until
//! it is.

mod growth;
pub(crate) mod outcome;
mod rendered;

use feeler_engine::RunEnd;
use serde::Serialize;

use crate::run::measure::swings::turns;
use crate::run::measure::trend::Trend;
use crate::run::measure::winding::Command;
use crate::run::verdict::outcome::{Outcome, Undecided};

/// Growth (or decay) from one part of the tail to the next that is more than the fluctuation of a steady
/// oscillation of too few cycles for a trend.
const CREEPS: f64 = 1.05;
/// The last part's amplitude over the first part's, below which the oscillation dies out.
const LASTS: f64 = 0.7;
/// Share of the tail at a limit that makes an oscillation one of saturation.
const SATURATES: f64 = 0.01;
/// From part to part a swing within the settling band grows by more than this, where it has too few cycles
/// for a trend.
const FEW_CYCLES: f64 = 1.01;
/// Share of the settling band below which growth may be that of rounding and noise.
const LEAST_GROWTH: f64 = 0.001;
/// Lift-offs in the tail, and in its last part, that make chatter.
const LEAST_LIFTS: (usize, usize) = (3, 2);
/// Changes between sticking and sliding in the tail that make hunting.
const LEAST_STICKS: usize = 2;
/// Turns of the force in the three parts of the tail together, and in each, that make it an oscillation: two
/// cycles.
const LEAST_TURNS: (usize, usize) = (4, 1);
/// Fewer rows tell nothing.
const LEAST_ROWS: usize = 30;

/// An outcome and what it was judged from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// What became of the run.
    pub outcome: Outcome,
    /// From when to when it was judged, s.
    pub tail_s: [f64; 2],
    /// Amplitudes of the three parts of the tail, N.
    pub amplitudes_n: [f64; 3],
    /// Rate at which the amplitude grows, 1/s, where it does.
    pub growth_per_s: Option<f64>,
    /// Why nothing can be said, where nothing can.
    pub undecided: Option<Undecided>,
}

impl Verdict {
    /// Whether a longer run may tell what this one does not.
    pub(super) fn may_be_decided(&self) -> bool {
        self.undecided.is_some_and(Undecided::may_be_decided)
    }
}

/// What is known of a run with a contact.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is a fact of its own")]
pub(super) struct Evidence<'a> {
    pub(super) end: Option<RunEnd>,
    /// Whether the run is as long as it gets, so that growth counts as lasting.
    pub(super) is_longest: bool,
    /// Whether a controller was in its approach at the end.
    pub(super) is_approaching: bool,
    /// Whether the tool, where it is away, may yet touch.
    pub(super) is_on_its_way: bool,
    /// Whether nothing can touch, so that `force_n` is what a drive is commanded.
    pub(super) is_rendered: bool,
    /// Times of the rows, s.
    pub(super) t_s: &'a [f64],
    /// The contact force at the rows, N.
    pub(super) force_n: &'a [f64],
    /// Whether some reference moves to the end.
    pub(super) driven: bool,
    /// Whether some reference was at rest and has moved only just before the end.
    pub(super) has_just_moved: bool,
    /// The force wanted at the rows, where that is what moves.
    pub(super) moving_reference_n: Option<&'a [f64]>,
    /// When the last change of the reference or the first touch was, s; none where there was no touch.
    pub(super) starts_at_s: Option<f64>,
    /// When contact last ended; none where it lasts to the end.
    pub(super) lost_at_s: Option<f64>,
    /// Each contact since settling counts: when it began, s, and its largest force, N.
    pub(super) impacts: &'a [(f64, f64)],
    /// Instants of lift-off, s.
    pub(super) lifts_s: &'a [f64],
    /// Whether a limit was reached, row by row.
    pub(super) saturated: &'a [bool],
    /// Instants at which something began to stick or slip, s.
    pub(super) sticks_s: &'a [f64],
    /// What the drives are commanded that hold the force.
    pub(super) commands: &'a [Command<'a>],
    /// Amplitude of the motion that counts as rest, N; none where no force is wanted: then 2 % of the mean
    /// force is taken.
    pub(super) band_n: Option<f64>,
    /// One sigma of what the sensors' noise makes of the readings, N; zero where there is none.
    pub(super) noise_n: f64,
}

impl Evidence<'_> {
    pub(super) fn verdict(&self) -> Verdict {
        let end_s = self.t_s.last().copied().unwrap_or(0.0);
        let start_s = self.starts_at_s.map_or(0.5 * end_s, |start| start + 0.5 * (end_s - start));
        let tail_s = [start_s.min(end_s), end_s];
        let first = self.t_s.partition_point(|&t| t < tail_s[0]);
        let amplitudes_n = self.amplitudes_n(first);
        let say = |outcome| Verdict { outcome, tail_s, amplitudes_n, growth_per_s: None, undecided: None };
        let unsure = |why| Verdict { undecided: Some(why), ..say(Outcome::Undecided) };
        let growth_per_s = (amplitudes_n[2] / amplitudes_n[0]).ln() / (2.0 / 3.0 * (tail_s[1] - tail_s[0]));
        match self.end {
            Some(RunEnd::Diverged { .. }) => {
                return Verdict {
                    growth_per_s: Some(growth_per_s).filter(|rate| rate.is_finite()),
                    ..say(Outcome::Unstable)
                };
            }
            Some(RunEnd::EventStorm { .. }) => return unsure(Undecided::EventStorm),
            _ => {}
        }
        if self.has_just_moved && !self.driven {
            return unsure(Undecided::TooShort);
        }
        if self.is_rendered {
            return self.of_rendered(first, say(Outcome::NoContact), growth_per_s);
        }
        // The loss of contact bounds most growth, only later: in contact alone nothing but a limit does.
        let swings = self.swings(first);
        let growth_lasts = self.is_longest || (self.lifts_s.is_empty() && swings);
        let grows = |rate_per_s: f64| Verdict {
            growth_per_s: Some(rate_per_s).filter(|rate| rate.is_finite()),
            ..if growth_lasts { say(Outcome::Unstable) } else { unsure(Undecided::StillGrowing) }
        };
        if let Some(rate_per_s) = self.impact_growth_per_s(tail_s[0]) {
            return grows(rate_per_s);
        }
        if self.starts_at_s.is_none() || self.lost_at_s.is_some_and(|lost| lost < tail_s[0]) {
            return if self.is_on_its_way && !self.is_longest {
                unsure(Undecided::StillApproaching)
            } else {
                say(Outcome::NoContact)
            };
        }
        if self.t_s.len() - first < LEAST_ROWS {
            return unsure(Undecided::TooShort);
        }
        let force = &self.force_n[first..];
        let mean = force.iter().sum::<f64>() / force.len() as f64;
        let band_n = self.band_n.unwrap_or(crate::run::measure::settling::SETTLING_BAND * mean.abs());
        let [a1, a2, a3] = amplitudes_n;
        let noisy = self.may_be_noise(a3);
        let trend = self.trend(force, a3);
        if growth::soars(amplitudes_n) && a3 > 0.1 * band_n && (!noisy || trend.is_some_and(Trend::rises_on))
        {
            return grows(growth_per_s);
        }
        let last_part_s = tail_s[1] - (tail_s[1] - tail_s[0]) / 3.0;
        let lifts = (self.lifts_after(tail_s[0]), self.lifts_after(last_part_s));
        let lasts = a3 >= LASTS * a1;
        if lifts.0 >= LEAST_LIFTS.0 && lifts.1 >= LEAST_LIFTS.1 {
            return if lasts && !self.impacts_weaken() && !self.dies_out(trend, amplitudes_n) {
                say(Outcome::Chatter)
            } else {
                unsure(Undecided::StillDecaying)
            };
        }
        if self.is_approaching {
            return unsure(Undecided::StillApproaching);
        }
        if self.driven {
            return say(Outcome::Driven);
        }
        // An unstable loop that has not left the band yet: what grows there is more than noise, and goes on
        // to grow.
        if a3 <= band_n && a3 > LEAST_GROWTH * band_n && a3 > a2 && a2 > a1 {
            if let Some(trend) = trend.filter(|trend| trend.rises_on()) {
                return grows(trend.change / (tail_s[1] - tail_s[0]));
            }
            if trend.is_none() && !noisy && !self.is_longest && a3 > FEW_CYCLES * a2 && a2 > FEW_CYCLES * a1 {
                return unsure(Undecided::StillGrowing);
            }
        }
        if a3 <= band_n && lifts.1 == 0 && self.lost_at_s.is_none() {
            let last_row = self.t_s.partition_point(|&t| t < last_part_s);
            if self.commands.iter().any(|command| command.winds(self.force_n, last_row, band_n)) {
                return unsure(Undecided::StillWinding);
            }
            return say(if self.lifts_s.is_empty() { Outcome::Settled } else { Outcome::BouncesThenSettles });
        }
        if lifts.0 > 0 {
            return unsure(Undecided::TooFewBounces);
        }
        let saturates = crate::run::measure::saturation::share(&self.saturated[first..]) > SATURATES;
        let sticks = self.sticks_s.iter().filter(|&&t| t >= tail_s[0]).count() >= LEAST_STICKS;
        // Noise makes of a few cycles what it likes.
        let falls = trend.map_or(!noisy && a2 > CREEPS * a3 && a1 > CREEPS * a2, Trend::falls);
        if falls || (!lasts && !noisy) {
            return unsure(Undecided::StillDecaying);
        }
        if trend.map_or(!noisy && a3 > CREEPS * a2 && a2 > CREEPS * a1, Trend::rises) {
            let rate_per_s = trend.map_or(growth_per_s, |trend| trend.change / (tail_s[1] - tail_s[0]));
            // In contact a linear machine has no other end.
            if self.is_longest && !saturates && !sticks && trend.is_some_and(Trend::rises_on) {
                return grows(rate_per_s);
            }
            return Verdict {
                growth_per_s: Some(rate_per_s).filter(|rate| rate.is_finite()),
                ..unsure(Undecided::StillGrowing)
            };
        }
        if !swings {
            return unsure(Undecided::TooShort);
        }
        if saturates {
            return say(Outcome::LimitCycle);
        }
        if sticks {
            return say(Outcome::Hunting);
        }
        // In contact, without limits or friction, what neither grows nor dies out is rare, and a few cycles
        // do not tell it.
        if trend.is_none() && !self.is_longest {
            return unsure(Undecided::TooShort);
        }
        say(Outcome::Oscillates)
    }

    /// Whether the tail, from row `first` on, has cycles enough to tell a swing from a slow move.
    fn swings(&self, first: usize) -> bool {
        let force_n = &self.force_n[first..self.t_s.len()];
        let parts: [usize; 3] =
            std::array::from_fn(|i| turns(&force_n[i * force_n.len() / 3..(i + 1) * force_n.len() / 3]));
        parts.iter().sum::<usize>() >= LEAST_TURNS.0 && parts.iter().all(|&turns| turns >= LEAST_TURNS.1)
    }

    fn lifts_after(&self, t_s: f64) -> usize {
        self.lifts_s.iter().filter(|&&lift| lift >= t_s).count()
    }

    fn amplitudes_n(&self, first: usize) -> [f64; 3] {
        let rows = self.t_s.len() - first;
        let error =
            |row: usize| self.force_n[row] - self.moving_reference_n.map_or(0.0, |reference| reference[row]);
        std::array::from_fn(|part| {
            let part_rows = first + part * rows / 3..first + (part + 1) * rows / 3;
            let (low, high) = part_rows
                .map(error)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), e| (low.min(e), high.max(e)));
            if high > low { 0.5 * (high - low) } else { 0.0 }
        })
    }
}

#[cfg(test)]
#[expect(clippy::large_stack_arrays, reason = "constant evidence, promoted to statics")]
pub(super) mod tests {
    use super::*;
    use std::f64::consts::TAU;

    pub(super) const ROWS: usize = 20_000;

    pub(super) fn times() -> Vec<f64> {
        (0..ROWS).map(|i| i as f64 * 1e-4).collect()
    }

    /// A run in which nothing happens after a touch at 0.2 s.
    pub(super) fn still() -> Evidence<'static> {
        Evidence {
            end: Some(RunEnd::Completed),
            is_longest: false,
            is_approaching: false,
            is_on_its_way: false,
            is_rendered: false,
            t_s: &[],
            force_n: &[0.0; ROWS],
            driven: false,
            has_just_moved: false,
            moving_reference_n: None,
            starts_at_s: Some(0.2),
            lost_at_s: None,
            impacts: &[],
            lifts_s: &[],
            saturated: &[false; ROWS],
            sticks_s: &[],
            commands: &[],
            band_n: Some(0.4),
            noise_n: 0.0,
        }
    }

    pub(super) fn verdict_of(force: impl Fn(f64) -> f64, change: impl Fn(&mut Evidence<'_>)) -> Verdict {
        let t_s = times();
        let force_n: Vec<f64> = t_s.iter().map(|&t| force(t)).collect();
        let mut evidence = Evidence { t_s: &t_s, force_n: &force_n, ..still() };
        change(&mut evidence);
        evidence.verdict()
    }

    #[test]
    fn truth_rest_is_settled_and_bounces_are_remembered() {
        let decays = |t: f64| 20.0 + 100.0 * (-10.0 * t).exp() * (TAU * 25.0 * t).cos();
        assert_eq!(verdict_of(decays, |_| {}).outcome, Outcome::Settled);
        assert_eq!(verdict_of(decays, |e| e.lifts_s = &[0.21, 0.25]).outcome, Outcome::BouncesThenSettles);
    }

    /// 1.1 s to 2 s of a ramp, and of a swing that takes longer.
    #[test]
    fn regress_a_slow_move_is_no_oscillation() {
        for force in [|t: f64| 20.0 + 3.0 * t, |t: f64| 20.0 + 5.0 * (TAU * 0.5 * t).sin()] {
            let verdict = verdict_of(force, |_| {});
            assert_eq!(verdict.outcome, Outcome::Undecided, "{verdict:?}");
        }
    }

    #[test]
    fn truth_growth_rate_is_found() {
        let grows = |t: f64| 20.0 + 0.5 * (3.0 * t).exp() * (TAU * 60.0 * t).cos();
        let verdict = verdict_of(grows, |_| {});
        assert_eq!(verdict.outcome, Outcome::Unstable);
        let left = verdict_of(grows, |e| e.lifts_s = &[0.21]);
        assert_eq!(
            (left.undecided, left.growth_per_s),
            (Some(Undecided::StillGrowing), verdict.growth_per_s)
        );
        // Each part's largest swing lies within one period of 17 ms of its end, so the ratio errs by less
        // than exp(3 / 60).
        assert!((verdict.growth_per_s.unwrap() - 3.0).abs() < 0.2, "{verdict:?}");
        let diverged = verdict_of(grows, |e| e.end = Some(RunEnd::Diverged { t_s: 2.0 }));
        assert_eq!(diverged.outcome, Outcome::Unstable);
    }

    #[test]
    fn truth_slow_growth_and_slow_decay_are_left_to_a_longer_run() {
        // Per part of 0.3 s: exp(0.3) = 1.35.
        let creeps = verdict_of(|t| 20.0 + 2.0 * t.exp() * (TAU * 60.0 * t).cos(), |_| {});
        assert_eq!((creeps.outcome, creeps.undecided), (Outcome::Undecided, Some(Undecided::StillGrowing)));
        assert!((creeps.growth_per_s.unwrap() - 1.0).abs() < 0.1, "{creeps:?}");
        let decays = verdict_of(|t| 20.0 + 5.0 * (-0.3 * t).exp() * (TAU * 60.0 * t).cos(), |_| {});
        assert_eq!((decays.outcome, decays.undecided), (Outcome::Undecided, Some(Undecided::StillDecaying)));
    }

    /// 3 % from part to part of 0.3 s: by no more than a steady oscillation of few cycles may fluctuate.
    #[test]
    fn regress_slow_growth_and_decay_of_many_cycles_are_no_sustained_oscillation() {
        let swing = |rate: f64| move |t: f64| 20.0 + 5.0 * (rate * t).exp() * (TAU * 60.0 * t).cos();
        let falls = verdict_of(swing(-0.1), |_| {});
        assert_eq!(falls.undecided, Some(Undecided::StillDecaying));
        let rises = verdict_of(swing(0.1), |_| {});
        assert_eq!(rises.undecided, Some(Undecided::StillGrowing));
        // The windows' ends leave up to 0.2 % of an amplitude, over 0.9 s.
        assert!((rises.growth_per_s.unwrap() - 0.1).abs() < 0.005, "{rises:?}");
        assert_eq!(verdict_of(swing(0.1), |e| e.is_longest = true).outcome, Outcome::Unstable);
        let limited = verdict_of(swing(0.1), |e| (e.is_longest, e.saturated) = (true, &[true; ROWS]));
        assert_eq!(limited.undecided, Some(Undecided::StillGrowing), "a limit may yet bound it");
        assert_eq!(verdict_of(swing(0.0), |_| {}).outcome, Outcome::Oscillates);
    }

    #[test]
    fn truth_repeated_lifts_are_chatter_unless_they_die_out() {
        let lifts: Vec<f64> = (5..50).map(|i| f64::from(i) * 0.04).collect();
        let bounces = |t: f64| 60.0 * (TAU * 25.0 * t).sin().max(0.0);
        let of = |force: &dyn Fn(f64) -> f64| {
            let t_s = times();
            let force_n: Vec<f64> = t_s.iter().map(|&t| force(t)).collect();
            let evidence = Evidence {
                t_s: &t_s,
                force_n: &force_n,
                lifts_s: &lifts,
                saturated: &[true; ROWS],
                ..still()
            };
            evidence.verdict()
        };
        assert_eq!(of(&bounces).outcome, Outcome::Chatter);
        let dying = of(&|t| bounces(t) * (-t).exp());
        assert_eq!((dying.outcome, dying.undecided), (Outcome::Undecided, Some(Undecided::StillDecaying)));
    }

    #[test]
    fn truth_sustained_oscillation_is_named_after_what_is_in_play() {
        let swings = |t: f64| 20.0 + 5.0 * (TAU * 12.0 * t).sin();
        let sticks: Vec<f64> = (0..20).map(|i| 0.1 * f64::from(i)).collect();
        // Eleven cycles in the tail tell no slow growth or decay; more do, or the end of all extension.
        assert_eq!(verdict_of(swings, |_| {}).undecided, Some(Undecided::TooShort));
        assert_eq!(verdict_of(swings, |e| e.is_longest = true).outcome, Outcome::Oscillates);
        assert_eq!(verdict_of(|t| 20.0 + 5.0 * (TAU * 24.0 * t).sin(), |_| {}).outcome, Outcome::Oscillates);
        let t_s = times();
        let force_n: Vec<f64> = t_s.iter().map(|&t| swings(t)).collect();
        let base =
            Evidence { t_s: &t_s, force_n: &force_n, saturated: &[true; ROWS], sticks_s: &sticks, ..still() };
        assert_eq!(base.verdict().outcome, Outcome::LimitCycle);
        assert_eq!(Evidence { saturated: &[false; ROWS], ..base }.verdict().outcome, Outcome::Hunting);
        let reference: Vec<f64> = t_s.iter().map(|t| 20.0 + t).collect();
        assert_eq!(
            Evidence { driven: true, moving_reference_n: Some(&reference), ..base }.verdict().outcome,
            Outcome::Driven
        );
    }

    #[test]
    fn truth_without_lasting_contact_there_is_none() {
        assert_eq!(verdict_of(|_| 0.0, |e| e.starts_at_s = None).outcome, Outcome::NoContact);
        assert_eq!(verdict_of(|_| 0.0, |e| e.lost_at_s = Some(0.3)).outcome, Outcome::NoContact);
        let comes = |e: &mut Evidence<'_>| (e.starts_at_s, e.is_on_its_way) = (None, true);
        assert_eq!(verdict_of(|_| 0.0, comes).undecided, Some(Undecided::StillApproaching));
        let in_vain =
            |e: &mut Evidence<'_>| (e.starts_at_s, e.is_on_its_way, e.is_longest) = (None, true, true);
        assert_eq!(verdict_of(|_| 0.0, in_vain).outcome, Outcome::NoContact);
        assert_eq!(
            verdict_of(|_| 1.0, |e| e.is_approaching = true).undecided,
            Some(Undecided::StillApproaching)
        );
        let late = verdict_of(|_| 20.0, |e| e.starts_at_s = Some(1.999));
        assert_eq!(late.undecided, Some(Undecided::TooShort));
        let storm = verdict_of(|_| 20.0, |e| e.end = Some(RunEnd::EventStorm { t_s: 1.0 }));
        assert_eq!(storm.undecided, Some(Undecided::EventStorm));
    }
}
