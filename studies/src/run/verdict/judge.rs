//! The criteria, in their order.

use feeler_engine::RunEnd;

use crate::run::measure::saturation;
use crate::run::measure::trend::Trend;
use crate::run::verdict::evidence::Evidence;
use crate::run::verdict::growth::soars;
use crate::run::verdict::outcome::{Outcome, RunVerdict, Undecided};
use crate::run::verdict::tail::{LASTS, LEAST_ROWS, Motion, SATURATES, Tail};

/// Growth (or decay) from one part of the tail to the next that exceeds the fluctuation of a steady
/// oscillation. It serves oscillations with too few cycles for a trend.
const CREEPS: f64 = 1.05;
/// The same factor for an oscillation within the settling band.
const FEW_CYCLES: f64 = 1.01;
/// Share of the settling band below which growth may be rounding and noise.
const LEAST_GROWTH: f64 = 0.001;
/// Smallest number of lift-offs of chatter in the tail, and in its last part.
const LEAST_LIFTS: (usize, usize) = (3, 2);
/// Smallest number of changes in the tail: between sticking and sliding for hunting, of a free play for a
/// limit cycle.
const LEAST_STICKS: usize = 2;

impl Evidence<'_> {
    pub(in crate::run) fn verdict(&self) -> RunVerdict {
        let tail = Tail::of(self);
        if let Some(verdict) = self.before_contact(&tail).or_else(|| self.without_contact(&tail)) {
            return verdict;
        }
        let motion = Motion::of(self, &tail);
        (self.bouncing(&tail, &motion))
            .or_else(|| self.within_band(&tail, &motion))
            .unwrap_or_else(|| self.of_oscillation(&tail, &motion))
    }

    /// The verdict on a run that stopped, or in which nothing can touch.
    fn before_contact(&self, tail: &Tail) -> Option<RunVerdict> {
        match self.end {
            Some(RunEnd::Diverged { .. }) => Some(RunVerdict {
                growth_per_s: Some(tail.growth_per_s()).filter(|rate| rate.is_finite()),
                ..tail.is(Outcome::Unstable)
            }),
            Some(RunEnd::EventStorm { .. }) => Some(tail.is_undecided(Undecided::EventStorm)),
            _ if self.has_just_moved && !self.driven => Some(tail.is_undecided(Undecided::TooShort)),
            _ if self.is_rendered && self.wanted.is_some() => Some(self.of_controlled(tail)),
            _ if self.is_rendered => {
                let otherwise = tail.is(Outcome::NoContact);
                Some(self.of_rendered(tail.first, otherwise, tail.growth_per_s()))
            }
            _ => None,
        }
    }

    /// The verdict on bouncing that grows, on a tool that is away, and on a tail too short for more.
    fn without_contact(&self, tail: &Tail) -> Option<RunVerdict> {
        if let Some(rate_per_s) = self.impact_growth_per_s(tail.span_s[0]) {
            return Some(self.grows(tail, rate_per_s));
        }
        if self.starts_at_s.is_none() || self.lost_at_s.is_some_and(|lost| lost < tail.span_s[0]) {
            return Some(if self.is_on_its_way && !self.is_longest {
                tail.is_undecided(Undecided::StillApproaching)
            } else {
                tail.is(Outcome::NoContact)
            });
        }
        (self.t_s.len() - tail.first < LEAST_ROWS).then(|| tail.is_undecided(Undecided::TooShort))
    }

    /// Growth by `rate_per_s`. Loss of contact bounds most growth eventually; in contact alone only a limit
    /// does.
    fn grows(&self, tail: &Tail, rate_per_s: f64) -> RunVerdict {
        let lasts = self.is_longest || (self.lifts_s.is_empty() && self.oscillates(tail.first));
        RunVerdict {
            growth_per_s: Some(rate_per_s).filter(|rate| rate.is_finite()),
            ..if lasts { tail.is(Outcome::Unstable) } else { tail.is_undecided(Undecided::StillGrowing) }
        }
    }

    /// The verdict on a motion that grows strongly, leaves the workpiece repeatedly, or follows its driver.
    pub(super) fn bouncing(&self, tail: &Tail, motion: &Motion) -> Option<RunVerdict> {
        let [a1, _, a3] = tail.amplitudes_n;
        let is_certain = !motion.is_noisy || motion.trend.is_some_and(Trend::rises_on);
        if soars(tail.amplitudes_n) && a3 > 0.1 * motion.band_n && is_certain {
            return Some(self.grows(tail, tail.growth_per_s()));
        }
        if motion.lifts.0 >= LEAST_LIFTS.0 && motion.lifts.1 >= LEAST_LIFTS.1 {
            let fades = self.impacts_weaken() || self.decays(motion.trend, tail.amplitudes_n);
            return Some(if a3 >= LASTS * a1 && !fades {
                tail.is(Outcome::Chatter)
            } else {
                tail.is_undecided(Undecided::StillDecaying)
            });
        }
        if self.is_approaching {
            return Some(tail.is_undecided(Undecided::StillApproaching));
        }
        self.driven.then(|| tail.is(Outcome::Driven))
    }

    /// The verdict on a motion within the settling band, and on one with a few lift-offs.
    pub(super) fn within_band(&self, tail: &Tail, motion: &Motion) -> Option<RunVerdict> {
        let [a1, a2, a3] = tail.amplitudes_n;
        let band_n = motion.band_n;
        // An unstable loop that has not left the band yet: its growth exceeds noise, and continues.
        if a3 <= band_n && a3 > LEAST_GROWTH * band_n && a3 > a2 && a2 > a1 {
            if let Some(trend) = motion.trend.filter(|trend| trend.rises_on()) {
                return Some(self.grows(tail, trend.change / tail.length_s()));
            }
            let rises = a3 > FEW_CYCLES * a2 && a2 > FEW_CYCLES * a1;
            if motion.trend.is_none() && !motion.is_noisy && !self.is_longest && rises {
                return Some(tail.is_undecided(Undecided::StillGrowing));
            }
        }
        if a3 <= band_n && motion.lifts.1 == 0 && self.lost_at_s.is_none() {
            let last_part_s = tail.last_part_s();
            let last_row = self.t_s.partition_point(|&t| t < last_part_s);
            if self.winds_up(last_row, band_n) {
                let why = if self.can_wind_up { Undecided::StillWinding } else { Undecided::TooShort };
                return Some(tail.is_undecided(why));
            }
            let never_left = self.lifts_s.is_empty();
            return Some(tail.is(if never_left { Outcome::Settled } else { Outcome::BouncesThenSettles }));
        }
        (motion.lifts.0 > 0).then(|| tail.is_undecided(Undecided::TooFewBounces))
    }

    /// The verdict on a motion in contact beyond the settling band.
    pub(super) fn of_oscillation(&self, tail: &Tail, motion: &Motion) -> RunVerdict {
        let [a1, a2, a3] = tail.amplitudes_n;
        let (trend, is_noisy) = (motion.trend, motion.is_noisy);
        let saturates = saturation::share(&self.saturated[tail.first..]) > SATURATES;
        let sticks = self.sticks_s.iter().filter(|&&t| t >= tail.span_s[0]).count() >= LEAST_STICKS;
        // In noise a few cycles are not conclusive.
        let falls = trend.map_or(!is_noisy && a2 > CREEPS * a3 && a1 > CREEPS * a2, Trend::falls);
        let lasts = a3 >= LASTS * a1;
        if self.surface_moves && !trend.is_some_and(Trend::rises_on) {
            return tail.is(Outcome::FollowsSurface);
        }
        if falls || (!lasts && !is_noisy) {
            return tail.is_undecided(Undecided::StillDecaying);
        }
        if trend.map_or(!is_noisy && a3 > CREEPS * a2 && a2 > CREEPS * a1, Trend::rises) {
            let rate_per_s = trend.map_or(tail.growth_per_s(), |trend| trend.change / tail.length_s());
            // In contact a linear machine has no other end.
            let is_last = self.is_longest || (self.is_last && self.lifts_s.is_empty());
            if is_last && !saturates && !sticks && trend.is_some_and(Trend::rises_on) {
                return self.grows(tail, rate_per_s);
            }
            return RunVerdict {
                growth_per_s: Some(rate_per_s).filter(|rate| rate.is_finite()),
                ..tail.is_undecided(Undecided::StillGrowing)
            };
        }
        if !self.oscillates(tail.first) {
            return tail.is_undecided(Undecided::TooShort);
        }
        // A few cycles between the limits of a drive do not prove a steady size. Without anti-windup they
        // grow with the square root of time.
        if self.is_rendered && saturates && trend.is_none() && !self.is_longest {
            return tail.is_undecided(Undecided::TooShort);
        }
        if saturates {
            return tail.is(Outcome::LimitCycle);
        }
        if sticks {
            return tail.is(Outcome::Hunting);
        }
        if self.is_rendered && self.plays_s.iter().filter(|&&t| t >= tail.span_s[0]).count() >= LEAST_STICKS {
            return tail.is(Outcome::LimitCycle);
        }
        // In contact, without limits or friction, a motion that neither grows nor decays is rare, and a few
        // cycles do not prove it.
        if trend.is_none() && !self.is_longest {
            return tail.is_undecided(Undecided::TooShort);
        }
        tail.is(Outcome::Oscillates)
    }
}

#[cfg(test)]
#[expect(clippy::large_stack_arrays, reason = "constant evidence, promoted to statics")]
pub(super) mod tests {
    use super::*;
    use std::f64::consts::TAU;

    pub(in crate::run::verdict) const ROWS: usize = 20_000;

    pub(in crate::run::verdict) fn times() -> Vec<f64> {
        (0..ROWS).map(|i| i as f64 * 1e-4).collect()
    }

    /// A run without motion after a touch at 0.2 s.
    pub(in crate::run::verdict) fn still() -> Evidence<'static> {
        Evidence {
            end: Some(RunEnd::Completed),
            is_longest: false,
            is_last: false,
            is_approaching: false,
            is_on_its_way: false,
            is_rendered: false,
            wanted: None,
            surface_moves: false,
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
            plays_s: &[],
            commands: &[],
            can_wind_up: false,
            band_n: Some(0.4),
            noise_n: 0.0,
        }
    }

    pub(in crate::run::verdict) fn verdict_of(
        force: impl Fn(f64) -> f64,
        change: impl Fn(&mut Evidence<'_>),
    ) -> RunVerdict {
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

    /// 1.1 s to 2 s of a ramp, and of an oscillation with a longer period.
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

    /// 3 % from part to part of 0.3 s: within the fluctuation of a steady oscillation with few cycles.
    #[test]
    fn regress_slow_growth_and_decay_of_many_cycles_are_no_sustained_oscillation() {
        let oscillation = |rate: f64| move |t: f64| 20.0 + 5.0 * (rate * t).exp() * (TAU * 60.0 * t).cos();
        let falls = verdict_of(oscillation(-0.1), |_| {});
        assert_eq!(falls.undecided, Some(Undecided::StillDecaying));
        let rises = verdict_of(oscillation(0.1), |_| {});
        assert_eq!(rises.undecided, Some(Undecided::StillGrowing));
        // The windows' ends leave up to 0.2 % of an amplitude, over 0.9 s.
        assert!((rises.growth_per_s.unwrap() - 0.1).abs() < 0.005, "{rises:?}");
        assert_eq!(verdict_of(oscillation(0.1), |e| e.is_longest = true).outcome, Outcome::Unstable);
        assert_eq!(verdict_of(oscillation(0.1), |e| e.is_last = true).outcome, Outcome::Unstable);
        let bounced = verdict_of(oscillation(0.1), |e| (e.is_last, e.lifts_s) = (true, &[0.21]));
        assert_eq!(bounced.outcome, Outcome::Undecided);
        let limited = verdict_of(oscillation(0.1), |e| (e.is_longest, e.saturated) = (true, &[true; ROWS]));
        assert_eq!(limited.undecided, Some(Undecided::StillGrowing), "a limit may yet bound it");
        assert_eq!(verdict_of(oscillation(0.0), |_| {}).outcome, Outcome::Oscillates);
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
        let oscillates = |t: f64| 20.0 + 5.0 * (TAU * 12.0 * t).sin();
        let sticks: Vec<f64> = (0..20).map(|i| 0.1 * f64::from(i)).collect();
        // Eleven cycles in the tail do not show slow growth or decay; more cycles do, or the end of all
        // extension.
        assert_eq!(verdict_of(oscillates, |_| {}).undecided, Some(Undecided::TooShort));
        assert_eq!(verdict_of(oscillates, |e| e.is_longest = true).outcome, Outcome::Oscillates);
        assert_eq!(verdict_of(|t| 20.0 + 5.0 * (TAU * 24.0 * t).sin(), |_| {}).outcome, Outcome::Oscillates);
        let t_s = times();
        let force_n: Vec<f64> = t_s.iter().map(|&t| oscillates(t)).collect();
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

    /// Swings of 2 Hz and of 20 Hz that the surface forces on the tool, and one that grows all the same.
    #[test]
    fn truth_a_force_under_a_moving_surface_follows_it_unless_it_grows() {
        for hz in [2.0, 20.0] {
            let oscillates = |t: f64| 20.0 + 5.0 * (TAU * hz * t).sin();
            assert_eq!(verdict_of(oscillates, |e| e.surface_moves = true).outcome, Outcome::FollowsSurface);
        }
        let grows = |t: f64| 20.0 + 0.5 * (3.0 * t).exp() * (TAU * 60.0 * t).cos();
        assert_eq!(verdict_of(grows, |e| e.surface_moves = true).outcome, Outcome::Unstable);
        assert_eq!(verdict_of(|_| 20.0, |e| e.surface_moves = true).outcome, Outcome::Settled);
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
