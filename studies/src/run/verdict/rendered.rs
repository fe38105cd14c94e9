//! The verdict without contact, if a controller renders the wall: by the motion under control, else by the
//! drive's command.

use crate::run::measure::saturation;
use crate::run::measure::trend::Trend;
use crate::run::verdict::evidence::Evidence;
use crate::run::verdict::growth::soars;
use crate::run::verdict::outcome::{Outcome, RunVerdict, Undecided};
use crate::run::verdict::tail::{LASTS, LEAST_ROWS, Motion, SATURATES, Tail};

/// Growth of a command below this share of the largest one is rounding.
const ROUNDING: f64 = 1e-9;

/// A motion diverges if it moves away and is this many times farther from its reference than after a start or
/// step. With a drive at its limit the growth is slower than exponential.
const FAR: f64 = 10.0;
/// Growth from part to part of the tail that exceeds the fluctuation of a steady oscillation.
const GOES: f64 = 1.05;

impl Evidence<'_> {
    /// The verdict without contact on the motion under control.
    pub(super) fn of_controlled(&self, tail: &Tail) -> RunVerdict {
        if let Some(rate_per_s) = self.departure_per_s(tail) {
            return RunVerdict { growth_per_s: Some(rate_per_s), ..tail.is(Outcome::Unstable) };
        }
        if self.t_s.len() - tail.first < LEAST_ROWS {
            return tail.is_undecided(Undecided::TooShort);
        }
        let motion = Motion::of(self, tail);
        (self.bouncing(tail, &motion))
            .or_else(|| self.within_band(tail, &motion))
            .unwrap_or_else(|| self.of_oscillation(tail, &motion))
    }

    /// Rate at which the controlled motion departs, if it is far from its reference.
    fn departure_per_s(&self, tail: &Tail) -> Option<f64> {
        let wanted = self.wanted?;
        let error = |row: usize| self.force_n[row] - wanted[row];
        let rows = self.t_s.len() - tail.first;
        let parts: [[f64; 2]; 3] = std::array::from_fn(|part| {
            let rows = tail.first + part * rows / 3..tail.first + (part + 1) * rows / 3;
            let end_s = tail.span_s[0] + (part + 1) as f64 * tail.length_s() / 3.0;
            [end_s, rows.map(|row| error(row).abs()).fold(0.0, f64::max)]
        });
        let steps = (1..wanted.len()).map(|row| (wanted[row] - wanted[row - 1]).abs()).fold(0.0, f64::max);
        let scale = steps.max(if wanted.is_empty() { 0.0 } else { error(0).abs() });
        let departs = |[[_, e1], [_, e2], [_, e3]]: &[[f64; 2]; 3]| {
            *e3 > GOES * e2 && *e2 > GOES * e1 && *e3 > FAR * scale && scale > 0.0
        };
        let rate = |[[t1, e1], _, [t3, e3]]: [[f64; 2]; 3]| (e3 / e1).ln() / (t3 - t1);
        // Parts of the tail may be shorter than a swing.
        let widest = || widest_swings((0..wanted.len()).map(|row| [self.t_s[row], error(row)]));
        let found = Some(parts).filter(departs).or_else(|| widest().filter(departs));
        found.map(rate).filter(|rate| rate.is_finite())
    }

    /// Whether a command moves on from `first` onwards while its motion rests within a band.
    pub(super) fn winds_up(&self, first: usize, band_n: f64) -> bool {
        if !self.is_rendered {
            return self.commands.iter().any(|command| command.winds_up(self.force_n, first, band_n));
        }
        // Without a guide that sticks, a command that moves on belongs to a slow motion within the band.
        if !self.can_wind_up {
            return false;
        }
        // A motion is not a force: the tolerance of a command that holds it in place is a share of its own
        // size.
        let still = vec![0.0; self.t_s.len()];
        self.commands.iter().any(|command| command.winds_up(&still, first, command.band_n(first)))
    }

    /// The verdict without contact on a command that grows, or oscillates between limits. `otherwise` is the
    /// verdict on any other command.
    pub(super) fn of_rendered(&self, first: usize, otherwise: RunVerdict, growth_per_s: f64) -> RunVerdict {
        let command = &self.force_n[first..self.t_s.len()];
        let (tail_s, [a1, a2, a3]) = (otherwise.tail_s, otherwise.amplitudes_n);
        let largest = self.force_n.iter().fold(0.0, |largest: f64, u| largest.max(u.abs()));
        if self.driven || command.len() < LEAST_ROWS || a3 <= ROUNDING * largest {
            return otherwise;
        }
        let unstable = |rate: f64| RunVerdict {
            outcome: Outcome::Unstable,
            growth_per_s: Some(rate).filter(|rate| rate.is_finite()),
            ..otherwise
        };
        let open = |verdict, why| RunVerdict { outcome: Outcome::Undecided, undecided: Some(why), ..verdict };
        let trend = if self.noise_n > 0.0 { Trend::in_noise(command) } else { Trend::of(command) };
        if soars([a1, a2, a3]) && (self.noise_n <= 0.0 || trend.is_some_and(Trend::rises_on)) {
            return unstable(growth_per_s);
        }
        let saturates = saturation::share(&self.saturated[first..]) > SATURATES;
        if let Some(trend) = trend.filter(|trend| trend.rises()) {
            let grows = unstable(trend.change / (tail_s[1] - tail_s[0]));
            return if self.is_longest && !saturates { grows } else { open(grows, Undecided::StillGrowing) };
        }
        if saturates && a3 >= LASTS * a1 && self.oscillates(first) {
            RunVerdict { outcome: Outcome::LimitCycle, ..otherwise }
        } else {
            otherwise
        }
    }
}

/// Time and size of the last three swings of an error, if each is wider than all before. `errors` are times
/// and errors. The last swing may not be at its widest yet, so it counts only if it is the widest already.
fn widest_swings(errors: impl Iterator<Item = [f64; 2]>) -> Option<[[f64; 2]; 3]> {
    let mut swings: Vec<[f64; 2]> = Vec::new();
    let mut is_above = None;
    for [t_s, error] in errors.filter(|[_, error]| *error != 0.0) {
        if is_above.replace(error > 0.0) != Some(error > 0.0) {
            swings.push([t_s, 0.0]);
        }
        if let Some(swing) = swings.last_mut().filter(|swing| error.abs() > swing[1]) {
            *swing = [t_s, error.abs()];
        }
    }
    let widest = |swings: &[[f64; 2]]| swings.iter().map(|swing| swing[1]).fold(0.0, f64::max);
    let (last, earlier) = swings.split_last()?;
    if last[1] <= widest(earlier) {
        swings.pop();
    }
    let (earlier, last) = swings.split_last_chunk::<3>()?;
    (last[0][1] > widest(earlier)).then_some(*last)
}

#[cfg(test)]
#[expect(clippy::large_stack_arrays, reason = "constant evidence, promoted to statics")]
mod tests {
    use super::super::judge::tests::{ROWS, verdict_of};
    use super::*;
    use std::f64::consts::TAU;

    /// The verdict on a motion whose reference is 1, from 0 on.
    fn of_motion(motion: impl Fn(f64) -> f64, change: impl Fn(&mut Evidence<'_>)) -> Outcome {
        verdict_of(motion, |e| {
            (e.is_rendered, e.starts_at_s, e.wanted) = (true, None, Some(&[1.0; ROWS][..]));
            e.band_n = Some(0.02);
            change(e);
        })
        .outcome
    }

    #[test]
    fn truth_a_controlled_motion_settles_diverges_hunts_or_cycles() {
        let settles = |t: f64| 1.0 - (-10.0 * t).exp() * (TAU * 5.0 * t).cos();
        assert_eq!(of_motion(settles, |_| {}), Outcome::Settled);
        // The amplitude grows with the square of time, as under a drive at its limit, and not exponentially.
        let winds_up = |t: f64| 20.0 * t * t * (TAU * 20.0 * t).cos();
        assert_eq!(of_motion(winds_up, |e| e.saturated = &[true; ROWS]), Outcome::Unstable);
        let oscillates = |t: f64| 1.0 + 0.1 * (TAU * 20.0 * t).cos();
        assert_eq!(of_motion(oscillates, |_| {}), Outcome::Oscillates);
        assert_eq!(of_motion(oscillates, |e| e.plays_s = &[1.2, 1.25, 1.3]), Outcome::LimitCycle);
        assert_eq!(of_motion(oscillates, |e| e.sticks_s = &[1.2, 1.25, 1.3]), Outcome::Hunting);
        assert_eq!(of_motion(oscillates, |e| e.saturated = &[true; ROWS]), Outcome::LimitCycle);
        assert_eq!(of_motion(oscillates, |e| e.driven = true), Outcome::Driven);
    }

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
