//! Response of a force to its reference: overshoot, settling time, remaining error.

use serde::Serialize;

use crate::run::measure::contact::peak;

/// Half-width of the settling band, as a share of the final reference.
pub(in crate::run) const SETTLING_BAND: f64 = 0.02;
/// A reference that is constant over this part of the run is at rest.
pub(in crate::run) const RESTS_OVER: f64 = 0.2;
/// A rest before a late step must be longer by this factor, more than a row or a sample. A staircase with
/// equal treads has no such rest.
const CLEARLY: f64 = 1.02;
/// Smallest number of rests of a staircase.
const LEAST_TREADS: usize = 3;
/// Largest ratio between the longest and the shortest of these rests.
const EVEN: f64 = 1.5;
/// Rows that are compared at once in search of a change.
const ROWS_AT_ONCE: usize = 64;

/// Behaviour of a reference in the last part of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::run) enum Ending {
    Rests,
    /// The reference was at rest and has just moved; a longer run shows the response of the force.
    JustMoved,
    /// The reference moves all the time, possibly in even steps.
    Moves,
}

impl Ending {
    /// The behaviour of a reference over the rows of a record.
    pub(in crate::run) fn of(t_s: &[f64], reference_n: &[f64]) -> Self {
        let end_s = t_s.last().copied().unwrap_or(0.0);
        if last_change_s(t_s, reference_n) <= end_s * (1.0 - RESTS_OVER) {
            return Self::Rests;
        }
        let changes_s = (1..reference_n.len()).filter(|&row| changes(reference_n, row)).map(|row| t_s[row]);
        let mut before_s = 0.0;
        let spans_s = changes_s.map(|at_s| at_s - std::mem::replace(&mut before_s, at_s));
        let rests_s: Vec<f64> = spans_s.filter(|span_s| *span_s > CLEARLY * RESTS_OVER * end_s).collect();
        let longest_s = rests_s.iter().copied().fold(0.0, f64::max);
        let is_staircase =
            rests_s.len() >= LEAST_TREADS && rests_s.iter().all(|rest_s| longest_s <= EVEN * rest_s);
        if rests_s.is_empty() || is_staircase { Self::Moves } else { Self::JustMoved }
    }
}

/// The response of a contact force to its reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ForceResponse {
    /// The final reference, N; `None` if it moves all the time.
    pub final_reference_n: Option<f64>,
    /// Start of the settling time: the last change of the reference, or the first touch if that is later, s.
    pub starts_at_s: f64,
    /// Half-width of the settling band, N: 2 % of the final reference. If that is zero, of the largest
    /// earlier reference, else of the peak force. The sensor's uncertainty is a lower limit.
    pub band_n: f64,
    /// Half-width of the band without the sensor's uncertainty, N.
    #[serde(skip)]
    pub(in crate::run) share_n: f64,
    /// Overshoot after [`Self::starts_at_s`] relative to the final reference, above it if the force comes
    /// from below.
    pub overshoot: Option<f64>,
    /// Time from [`Self::starts_at_s`] until the force stays within the band to the end of the run; `None` if
    /// it does not stay there.
    pub settling_time_s: Option<f64>,
    /// The same time until the force stays within the band about its own end, which friction may keep off the
    /// reference; `None` if the reference moves.
    #[serde(skip)]
    pub(crate) rest_time_s: Option<f64>,
    /// Mean of the last tenth of the run less the reference, N; `None` if the reference moves.
    pub steady_error_n: Option<f64>,
    /// How closely the force follows, if its reference or the surface moves to the end.
    pub tracking: Option<Tracking>,
}

/// How closely a force follows its reference over the tail of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tracking {
    /// Largest distance from the reference, N.
    pub largest_error_n: f64,
    /// Root mean square of the distance, N.
    pub rms_error_n: f64,
}

/// A force and its reference over the rows of a record.
#[derive(Clone, Copy, Debug)]
pub(in crate::run) struct Answer<'a> {
    pub(in crate::run) t_s: &'a [f64],
    pub(in crate::run) force_n: &'a [f64],
    pub(in crate::run) reference_n: &'a [f64],
    pub(in crate::run) peak_force_n: f64,
    pub(in crate::run) first_contact_s: f64,
    pub(in crate::run) unresolved_n: f64,
}

impl Answer<'_> {
    pub(in crate::run) fn response(&self) -> ForceResponse {
        let changed = last_change_s(self.t_s, self.reference_n);
        let rests = Ending::of(self.t_s, self.reference_n) != Ending::Moves;
        let reference = self.reference_n.last().copied().filter(|_| rests);
        let starts_at_s = if rests { changed.max(self.first_contact_s) } else { self.first_contact_s };
        let share_n = SETTLING_BAND * reference.map_or(0.0, |reference| self.scale_n(reference));
        let band_n = share_n.max(self.unresolved_n);
        let steady_error_n = reference.and_then(|r| self.steady_error_n(r));
        let end_n = reference.zip(steady_error_n).map(|(reference, error)| reference + error);
        ForceResponse {
            final_reference_n: reference,
            starts_at_s,
            band_n,
            share_n,
            overshoot: reference.filter(|r| *r != 0.0).map(|r| self.overshoot(r, starts_at_s)),
            settling_time_s: reference.and_then(|r| self.settling_time_s(r, band_n, starts_at_s)),
            rest_time_s: end_n.and_then(|end| self.settling_time_s(end, band_n, starts_at_s)),
            steady_error_n,
            tracking: None,
        }
    }

    /// How closely the force follows from `from_s` onwards; `None` without rows there.
    pub(in crate::run) fn tracking(&self, from_s: f64) -> Option<Tracking> {
        let first = self.t_s.partition_point(|&t| t < from_s);
        let errors = || {
            let rows = self.force_n.iter().zip(self.reference_n).skip(first);
            rows.map(|(force, reference)| force - reference).filter(|error| error.is_finite())
        };
        let count = errors().count();
        (count > 0).then(|| Tracking {
            largest_error_n: errors().fold(0.0, |most, error| most.max(error.abs())),
            rms_error_n: (errors().map(|error| error * error).sum::<f64>() / count as f64).sqrt(),
        })
    }

    /// The scale of the band: the reference, or for a zero reference the earlier ones, or the force.
    fn scale_n(&self, reference: f64) -> f64 {
        if reference.abs() > 0.0 {
            return reference.abs();
        }
        let before_n =
            self.reference_n.iter().filter(|r| r.is_finite()).fold(0.0_f64, |most, r| most.max(r.abs()));
        [before_n, self.peak_force_n].into_iter().find(|scale| *scale > 0.0).unwrap_or(0.0)
    }

    /// For a rise the largest force counts; for a fall the smallest.
    fn overshoot(&self, reference: f64, starts_at_s: f64) -> f64 {
        if starts_at_s <= self.first_contact_s && reference > 0.0 {
            return (self.peak_force_n / reference - 1.0).max(0.0);
        }
        let first = self.t_s.partition_point(|&t| t < starts_at_s);
        let share: Vec<f64> = self.force_n[first..].iter().map(|force| force / reference).collect();
        let passed = if share.first().is_some_and(|&share| share > 1.0) {
            1.0 - share.iter().copied().fold(f64::INFINITY, f64::min)
        } else {
            peak(&self.t_s[first..], &share).force_n - 1.0
        };
        passed.max(0.0)
    }

    fn settling_time_s(&self, reference: f64, band_n: f64, starts_at_s: f64) -> Option<f64> {
        let first = self.t_s.partition_point(|&t| t < starts_at_s);
        let force = self.force_n.get(first..).filter(|rows| !rows.is_empty())?;
        let settled = match force.iter().rposition(|f| (f - reference).abs() > band_n) {
            None => first,
            Some(last_outside) => first + last_outside + 1,
        };
        self.t_s.get(settled).map(|t| (t - starts_at_s).max(0.0))
    }

    fn steady_error_n(&self, reference: f64) -> Option<f64> {
        let last = &self.force_n[self.force_n.len() - self.force_n.len() / 10..];
        (!last.is_empty()).then(|| last.iter().sum::<f64>() / last.len() as f64 - reference)
    }
}

/// Time of the last change of a reference, s; zero if it never changed.
pub(in crate::run) fn last_change_s(t_s: &[f64], reference_n: &[f64]) -> f64 {
    // The controller's first sample may follow the first row.
    let mut end = reference_n.len();
    while end > 1 {
        let start = end.saturating_sub(ROWS_AT_ONCE).max(1);
        // References are mostly held: many rows are compared without a branch for each.
        let differ = |pair: &[f64]| pair[0].to_bits() != pair[1].to_bits();
        if reference_n[start - 1..end].windows(2).fold(false, |any, pair| any | differ(pair)) {
            return (start..end).rev().find(|&row| changes(reference_n, row)).map_or(0.0, |row| t_s[row]);
        }
        end = start;
    }
    0.0
}

/// Whether a reference changes at a row. Bitwise: a held one repeats exactly.
fn changes(reference_n: &[f64], row: usize) -> bool {
    reference_n[row - 1].to_bits() != reference_n[row].to_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `20 (1 - exp(-t / 0.1))` from `t = 1` on enters the band of 2 % after `0.1 ln 50`.
    #[test]
    fn truth_a_first_order_answer_settles_after_four_time_constants() {
        let t_s: Vec<f64> = (0..30_000).map(|i| f64::from(i) * 1e-4).collect();
        let force_n: Vec<f64> = t_s
            .iter()
            .map(|t| if *t < 1.0 { 0.0 } else { 20.0 * (1.0 - (-(t - 1.0) / 0.1).exp()) })
            .collect();
        let reference_n = vec![20.0; t_s.len()];
        let answer = Answer {
            t_s: &t_s,
            force_n: &force_n,
            reference_n: &reference_n,
            peak_force_n: 20.0,
            first_contact_s: 1.0,
            unresolved_n: 0.0,
        };
        let response = answer.response();
        // Rows are 0.1 ms apart.
        assert!((response.settling_time_s.unwrap() - 0.1 * 50.0_f64.ln()).abs() < 1.1e-4);
        assert_eq!(response.overshoot, Some(0.0));
        assert!(response.steady_error_n.unwrap().abs() < 1e-4);
        // Kept 2 N off its reference, it rests as soon.
        let held: Vec<f64> = force_n.iter().map(|force| 0.9 * force).collect();
        let held = Answer { force_n: &held, ..answer }.response();
        assert_eq!(held.settling_time_s, None);
        assert!((held.rest_time_s.unwrap() - 0.1 * 45.0_f64.ln()).abs() < 1.1e-4, "{held:?}");
        let late = Answer { peak_force_n: 25.0, unresolved_n: 2.0, ..answer }.response();
        assert!((late.overshoot.unwrap() - 0.25).abs() < 1e-12);
        assert!((late.settling_time_s.unwrap() - 0.1 * 10.0_f64.ln()).abs() < 1.1e-4);
    }

    #[test]
    fn truth_a_step_of_the_reference_starts_settling_anew() {
        let t_s: Vec<f64> = (0..100).map(|i| f64::from(i) * 1e-2).collect();
        let reference_n: Vec<f64> = t_s.iter().map(|t| if *t < 0.5 { 10.0 } else { 20.0 }).collect();
        let force_n: Vec<f64> = t_s.iter().map(|t| if *t < 0.6 { 10.0 } else { 20.0 }).collect();
        let answer = Answer {
            t_s: &t_s,
            force_n: &force_n,
            reference_n: &reference_n,
            peak_force_n: 20.0,
            first_contact_s: 0.1,
            unresolved_n: 0.0,
        };
        let response = answer.response();
        assert!((response.starts_at_s - 0.5).abs() < 1e-12);
        assert!((response.settling_time_s.unwrap() - 0.1).abs() < 1e-12);
        // Motion before the step is not overshoot; for a fall, the force below the reference is.
        assert_eq!(Answer { peak_force_n: 50.0, ..answer }.response().overshoot, Some(0.0));
        let down_n: Vec<f64> = reference_n.iter().map(|n| 30.0 - n).collect();
        let dips: Vec<f64> =
            t_s.iter().map(|t| if *t < 0.6 { 20.0 } else { 10.0 - 10.0 * (0.7 - t).max(0.0) }).collect();
        let down = Answer { reference_n: &down_n, force_n: &dips, ..answer }.response();
        assert!((down.overshoot.unwrap() - 0.1).abs() < 1e-12, "{down:?}");
        let moving: Vec<f64> = t_s.iter().map(|t| 10.0 + t).collect();
        assert_eq!(Answer { reference_n: &moving, ..answer }.response().final_reference_n, None);
    }

    /// A force 0.5 N above a rising reference, with a sine of 1 N on top: at most 1.5 N away, and
    /// `sqrt(0.5^2 + 1 / 2)` N on average. What came before the tail does not count.
    #[test]
    fn truth_tracking_is_the_distance_from_a_reference_that_moves() {
        let t_s: Vec<f64> = (0..2000).map(|i| f64::from(i) * 1e-3).collect();
        let reference_n: Vec<f64> = t_s.iter().map(|t| 10.0 + 5.0 * t).collect();
        let error_n = |t: f64| if t < 1.0 { 9.0 } else { 0.5 + (std::f64::consts::TAU * 10.0 * t).sin() };
        let force_n: Vec<f64> = t_s.iter().zip(&reference_n).map(|(t, r)| r + error_n(*t)).collect();
        let answer = Answer {
            t_s: &t_s,
            force_n: &force_n,
            reference_n: &reference_n,
            peak_force_n: 25.0,
            first_contact_s: 0.1,
            unresolved_n: 0.0,
        };
        let found = answer.tracking(1.0).unwrap();
        assert!((found.largest_error_n - 1.5).abs() < 1e-9, "{found:?}");
        assert!((found.rms_error_n - 0.75_f64.sqrt()).abs() < 1e-9, "{found:?}");
        assert_eq!(answer.tracking(3.0), None);
    }

    /// Rows 1 ms apart over 1 s, with changes at these instants.
    fn ending(changes_s: &[f64]) -> Ending {
        let t_s: Vec<f64> = (0..=1000).map(|i| f64::from(i) * 1e-3).collect();
        let reference_n: Vec<f64> =
            t_s.iter().map(|t| 20.0 + changes_s.iter().filter(|at| *t >= **at).count() as f64).collect();
        Ending::of(&t_s, &reference_n)
    }

    #[test]
    fn regress_a_late_step_of_a_reference_at_rest_is_no_moving_reference() {
        for late in [
            &[0.99][..],
            &[0.9],
            &[0.1, 0.85],
            &[0.1, 0.2, 0.3, 0.9],
            &[0.1, 0.6, 0.9],
            &[0.9, 0.91, 0.92, 0.93],
        ] {
            assert_eq!(ending(late), Ending::JustMoved, "{late:?}");
        }
        for early in [&[][..], &[0.1], &[0.1, 0.79]] {
            assert_eq!(ending(early), Ending::Rests, "{early:?}");
        }
    }

    /// Treads of a tenth to three tenths of the run, with the last one just begun, and a change at every row.
    #[test]
    fn truth_staircases_and_lasting_drives_move_to_the_end() {
        for tread in [0.1, 0.2, 0.25, 0.3] {
            let stairs: Vec<f64> =
                (1..10).map(|i| f64::from(i) * tread - 0.01).filter(|at| *at < 1.0).collect();
            assert_eq!(ending(&stairs), Ending::Moves, "{stairs:?}");
        }
        assert_eq!(ending(&[0.15, 0.4, 0.65, 0.9]), Ending::Moves);
        let always: Vec<f64> = (1..1000).map(|i| f64::from(i) * 1e-3).collect();
        assert_eq!(ending(&always), Ending::Moves);
    }

    #[test]
    fn truth_a_reference_of_zero_has_a_band_all_the_same() {
        // 20 N, released at 1 s: 20 exp(-t / 0.1) is within 2 % of 20 N after 0.1 ln 50.
        let t_s: Vec<f64> = (0..3000).map(|i| f64::from(i) * 1e-3).collect();
        let reference_n: Vec<f64> = t_s.iter().map(|&t| if t < 1.0 { 20.0 } else { 0.0 }).collect();
        let force_n: Vec<f64> =
            t_s.iter().map(|&t| if t < 1.0 { 20.0 } else { 20.0 * (-(t - 1.0) / 0.1).exp() }).collect();
        let answer = Answer {
            t_s: &t_s,
            force_n: &force_n,
            reference_n: &reference_n,
            peak_force_n: 20.0,
            first_contact_s: 0.0,
            unresolved_n: 0.0,
        };
        let found = answer.response();
        assert!((found.band_n - 0.4).abs() < 1e-12);
        // To a row.
        assert!((found.settling_time_s.unwrap() - 0.1 * 50.0_f64.ln()).abs() < 2e-3, "{found:?}");
        let nothing = vec![0.0; t_s.len()];
        assert!((Answer { reference_n: &nothing, ..answer }.response().band_n - 0.4).abs() < 1e-12);
    }
}
