//! The verdict where nothing can touch, so that a wall, if there is one, is one that a controller renders: by
//! what the drive is commanded.

use crate::run::measure::saturation;
use crate::run::measure::trend::Trend;
use crate::run::verdict::evidence::Evidence;
use crate::run::verdict::growth::soars;
use crate::run::verdict::outcome::{Outcome, Undecided, Verdict};
use crate::run::verdict::tail::{LASTS, LEAST_ROWS, SATURATES};

/// Growth of a command below this share of the largest one is rounding.
const ROUNDING: f64 = 1e-9;

impl Evidence<'_> {
    /// Where nothing can touch: of a command that grows, or swings between limits. `otherwise` is what
    /// becomes of one that does neither.
    pub(super) fn of_rendered(&self, first: usize, otherwise: Verdict, growth_per_s: f64) -> Verdict {
        let command = &self.force_n[first..self.t_s.len()];
        let (tail_s, [a1, a2, a3]) = (otherwise.tail_s, otherwise.amplitudes_n);
        let largest = self.force_n.iter().fold(0.0, |largest: f64, u| largest.max(u.abs()));
        if self.driven || command.len() < LEAST_ROWS || a3 <= ROUNDING * largest {
            return otherwise;
        }
        let unstable = |rate: f64| Verdict {
            outcome: Outcome::Unstable,
            growth_per_s: Some(rate).filter(|rate| rate.is_finite()),
            ..otherwise
        };
        let open = |verdict, why| Verdict { outcome: Outcome::Undecided, undecided: Some(why), ..verdict };
        let trend = if self.noise_n > 0.0 { Trend::in_noise(command) } else { Trend::of(command) };
        if soars([a1, a2, a3]) && (self.noise_n <= 0.0 || trend.is_some_and(Trend::rises_on)) {
            return unstable(growth_per_s);
        }
        let saturates = saturation::share(&self.saturated[first..]) > SATURATES;
        if let Some(trend) = trend.filter(|trend| trend.rises()) {
            let grows = unstable(trend.change / (tail_s[1] - tail_s[0]));
            return if self.is_longest && !saturates { grows } else { open(grows, Undecided::StillGrowing) };
        }
        if saturates && a3 >= LASTS * a1 && self.swings(first) {
            Verdict { outcome: Outcome::LimitCycle, ..otherwise }
        } else {
            otherwise
        }
    }
}

#[cfg(test)]
#[expect(clippy::large_stack_arrays, reason = "constant evidence, promoted to statics")]
mod tests {
    use super::super::judge::tests::{ROWS, verdict_of};
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn truth_a_command_where_nothing_can_touch_grows_or_swings_between_limits_or_neither() {
        let of = |rate: f64, change: &dyn Fn(&mut Evidence<'_>)| {
            let force = |t: f64| 20.0 * (rate * t).exp() * (TAU * 60.0 * t).cos();
            verdict_of(force, |e| {
                (e.is_rendered, e.starts_at_s) = (true, None);
                change(e);
            })
        };
        assert_eq!(of(3.0, &|_| {}).outcome, Outcome::Unstable);
        assert_eq!(of(0.2, &|_| {}).undecided, Some(Undecided::StillGrowing));
        assert_eq!(of(0.2, &|e| e.is_longest = true).outcome, Outcome::Unstable);
        for rate in [0.0, -0.2, -3.0] {
            assert_eq!(of(rate, &|_| {}).outcome, Outcome::NoContact, "{rate}");
        }
        assert_eq!(of(0.0, &|e| e.saturated = &[true; ROWS]).outcome, Outcome::LimitCycle);
        assert_eq!(of(3.0, &|e| e.driven = true).outcome, Outcome::NoContact);
    }
}
