//! Tests whether a motion grows, or bouncing dies out.
//!
//! In contact it grows if `A3 > 1.5 A2` and `A2 > 1.5 A1`. Bouncing grows if the peaks of the last half of
//! all contacts rise from each to the next and exceed all earlier ones. This needs at least 6 contacts with a
//! total rise of more than 2.25 times, or 3 of which each exceeds 1.5 times the last. The last of them must
//! fall into the tail, or the tool must be away at the end. So it has not come to rest since.
//!
//! Sensor noise keeps a stable loop moving; the closer the loop is to its limit, the slower its amplitude
//! varies. The three amplitudes then also rise by chance. In one run of a hundred they rise by 1.5 times
//! each. In one of ten a line through their logarithms exceeds four of its standard errors. Up to 100 sigma
//! the motion may be a response to noise. It then grows only if the rise from window to window is significant
//! against the spread of these rises ([`Trend::in_noise`]).

use crate::run::measure::trend::Trend;
use crate::run::verdict::evidence::Evidence;

/// Smallest significant growth from one part of the tail to the next, or from impact to impact.
const GROWS: f64 = 1.5;
/// Number of contacts at the end of the run whose peaks must rise for unstable bouncing. In aperiodic
/// bouncing they rise by chance in one run of 720, and far more rarely exceed all earlier ones too.
const LEAST_RISING: usize = 6;
/// The smallest number if each contact is so much harder than the previous one that the whole motion grows.
const LEAST_SOARING: usize = 3;
/// Smallest significant fall of bouncing over the whole tail.
const FADES: f64 = 0.03;
/// Number of impacts that become weaker; the end of the run may cut off the last one.
const LEAST_WEAKER: usize = 4;
/// Each falls by this part of the significant fall over a tail.
const WEAKER_SHARE: f64 = 3.0;
/// A stable loop in practice oscillates by less than this number of standard deviations of its reading noise.
/// With a damping ratio of 0.01 % it is about 50.
const NOISE_REACH: f64 = 100.0;

/// Whether the amplitudes of the tail's three parts grow clearly from each to the next.
pub(super) fn soars([a1, a2, a3]: [f64; 3]) -> bool {
    a3 > GROWS * a2 && a2 > GROWS * a1
}

impl Evidence<'_> {
    /// Whether a motion of this amplitude may be the response of a stable loop to noise.
    pub(super) fn may_be_noise(&self, amplitude_n: f64) -> bool {
        amplitude_n < NOISE_REACH * self.noise_n
    }

    /// The trend of the tail's force, of amplitude `amplitude_n` at the end; `None` if there are too few
    /// cycles.
    pub(super) fn trend(&self, force_n: &[f64], amplitude_n: f64) -> Option<Trend> {
        if self.may_be_noise(amplitude_n) { Trend::in_noise(force_n) } else { Trend::of(force_n) }
    }

    /// Rate at which the peaks of the last contacts rise, if they do.
    pub(super) fn impact_growth_per_s(&self, tail_starts_at_s: f64) -> Option<f64> {
        let rises = |least: usize, step: f64, whole: f64| {
            let last = self.last_impacts(least);
            let [(from_s, first_n), .., (to_s, last_n)] = last else { return None };
            let before = self.impacts[..self.impacts.len() - last.len()]
                .iter()
                .map(|impact| impact.1)
                .fold(0.0, f64::max);
            let goes_on = self.lost_at_s.is_some() || *to_s >= tail_starts_at_s;
            let grows = *last_n > before
                && *last_n > whole * first_n
                && last.windows(2).all(|pair| pair[1].1 > step * pair[0].1);
            (last.len() >= least && goes_on && grows).then(|| (last_n / first_n).ln() / (to_s - from_s))
        };
        rises(LEAST_RISING, 1.0, GROWS * GROWS).or_else(|| rises(LEAST_SOARING, GROWS, GROWS * GROWS))
    }

    /// The last half of all impacts, but at least `least` if there are that many.
    fn last_impacts(&self, least: usize) -> &[(f64, f64)] {
        let all = self.impacts.len();
        &self.impacts[all - all.div_ceil(2).max(least).min(all)..]
    }

    /// Whether each of the last impacts is weaker than the previous one: bouncing that dies out.
    pub(super) fn impacts_weaken(&self) -> bool {
        let last = self.last_impacts(LEAST_WEAKER);
        let weaker = |pair: &[(f64, f64)]| pair[1].1 < pair[0].1 * (1.0 - FADES / WEAKER_SHARE);
        // The end of the run may cut off the last one.
        let whole = &last[..last.len().saturating_sub(1)];
        last.len() >= LEAST_WEAKER && whole.windows(2).all(weaker)
    }

    /// Whether nearly steady bouncing dies out: its decay is as fast at the end as before. A decay towards a
    /// limit cycle would slow down.
    pub(super) fn decays(&self, trend: Option<Trend>, [a1, a2, a3]: [f64; 3]) -> bool {
        match trend {
            Some(trend) => trend.falls_on() && trend.change < -FADES,
            None => !self.is_longest && a1 > (1.0 + FADES) * a3 && a2 - a3 > 0.5 * (a1 - a2),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::judge::tests::{ROWS, still, times};
    use super::super::{Evidence, RunVerdict};
    use crate::run::verdict::outcome::{Outcome, Undecided};
    use feeler_control::Stream;
    use std::f64::consts::TAU;

    /// The verdict on these impacts, with the tool away at the end or at rest on the wall.
    fn of_impacts(impacts: &[(f64, f64)], lost_at_s: Option<f64>, is_longest: bool) -> RunVerdict {
        let t_s = times();
        Evidence { lost_at_s, impacts, lifts_s: &[0.05, 0.75], is_longest, t_s: &t_s, ..still() }.verdict()
    }

    #[test]
    fn truth_impacts_that_rise_to_the_end_of_the_longest_run_are_unstable_even_where_the_tool_is_away() {
        let impacts: Vec<(f64, f64)> =
            (0..8).map(|i| (0.1 * f64::from(i), 10.0 * (0.4 * f64::from(i)).exp())).collect();
        let away = |impacts: &[(f64, f64)], is_longest| of_impacts(impacts, Some(0.75), is_longest);
        let verdict = away(&impacts, true);
        assert_eq!(verdict.outcome, Outcome::Unstable);
        assert!((verdict.growth_per_s.unwrap() - 4.0).abs() < 1e-9);
        let sooner = away(&impacts, false);
        assert_eq!((sooner.outcome, sooner.undecided), (Outcome::Undecided, Some(Undecided::StillGrowing)));
        assert_eq!(sooner.growth_per_s, verdict.growth_per_s);
        let falling: Vec<(f64, f64)> = impacts.iter().map(|(t, f)| (*t, 1.0 / f)).collect();
        assert_eq!(away(&falling, true).outcome, Outcome::NoContact);
    }

    /// Each bounce throws the tool farther than the last, so only a few fit into a run.
    #[test]
    fn regress_few_bounces_each_much_harder_than_the_last_are_unstable() {
        let bounces = [(0.2, 30.0), (0.3, 120.0), (0.7, 900.0)];
        assert_eq!(of_impacts(&bounces, Some(0.75), true).outcome, Outcome::Unstable);
        assert_eq!(of_impacts(&bounces, Some(0.75), false).undecided, Some(Undecided::StillGrowing));
        // On the wall ever since: the last bounce was the hardest.
        assert_eq!(of_impacts(&bounces, None, true).outcome, Outcome::BouncesThenSettles);
        let even = [(0.2, 30.0), (0.3, 40.0), (0.7, 50.0)];
        assert_eq!(of_impacts(&even, Some(0.75), true).outcome, Outcome::NoContact);
    }

    /// An oscillation of 60 Hz in contact whose two quadratures lose or gain `rate_per_s`, driven by white
    /// noise to an amplitude of about `sigma_n`.
    fn oscillation(rate_per_s: f64, sigma_n: f64, seed: u64) -> Vec<f64> {
        let stream = Stream::new(seed, "swing");
        let dt = 1e-4;
        let (keeps, kick) = ((rate_per_s * dt).exp(), sigma_n * (2.0 * rate_per_s.abs() * dt).sqrt());
        let [mut x, mut y] = stream.normal_pairs_from::<1>(0)[0].map(|normal| sigma_n * normal);
        let mut values = Vec::with_capacity(ROWS);
        for (i, [p, q]) in stream.normal_pairs_from::<ROWS>(1).into_iter().enumerate() {
            (x, y) = (keeps * x + kick * p, keeps * y + kick * q);
            let (sin, cos) = (TAU * 60.0 * i as f64 * dt).sin_cos();
            values.push(20.0 + x * cos + y * sin);
        }
        values
    }

    fn of_noisy_oscillation(rate_per_s: f64, seed: u64) -> Outcome {
        let t_s = times();
        let force_n = oscillation(rate_per_s, 0.1, seed);
        let longest = Evidence { t_s: &t_s, force_n: &force_n, is_longest: true, noise_n: 0.1, ..still() };
        longest.verdict().outcome
    }

    /// From an oscillation that lasts much longer than the tail of 0.9 s to one that ends in a hundredth of
    /// it. By construction none of them grows.
    #[test]
    fn truth_what_noise_makes_of_a_stable_loop_does_not_grow() {
        for rate_per_s in [-0.3, -1.0, -3.0, -10.0, -100.0] {
            for seed in 0..40 {
                let outcome = of_noisy_oscillation(rate_per_s, seed);
                assert!(
                    matches!(outcome, Outcome::Settled | Outcome::Oscillates | Outcome::Undecided),
                    "{rate_per_s}, {seed}: {outcome:?}"
                );
            }
        }
    }

    /// Growth over the tail by a factor of 90 and more, from the same noise.
    #[test]
    fn truth_what_grows_out_of_the_noise_is_unstable() {
        for rate_per_s in [5.0, 8.0, 20.0] {
            let unstable =
                (0..20).filter(|seed| of_noisy_oscillation(rate_per_s, *seed) == Outcome::Unstable).count();
            assert_eq!(unstable, 20, "{rate_per_s}");
        }
    }
}
