//! Times and forces of a contact.

use feeler_engine::{EventKind, Integrator, Peak, Scenario, Trace};
use feeler_plant::assembly::Assembly;
use feeler_plant::description::{Engagement, Quantity, SignalName};
use feeler_plant::motion::Switch;

/// A span of time, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    pub start_s: f64,
    pub end_s: f64,
}

impl Interval {
    /// Its length, s.
    pub fn length_s(self) -> f64 {
        self.end_s - self.start_s
    }

    /// Length of its part within `[from_s, to_s]`, s.
    pub(crate) fn within_s(self, from_s: f64, to_s: f64) -> f64 {
        (self.end_s.min(to_s) - self.start_s.max(from_s)).max(0.0)
    }
}

/// A contact over a run.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactRun {
    pub name: String,
    /// Its engagement, after effects.
    pub engagement: Engagement,
    /// Its intervals of pushing, to the accuracy of the events.
    pub intervals: Vec<Interval>,
    /// The largest force in each of these, N (see [`Self::peak_force_n`]).
    pub interval_peaks_n: Vec<f64>,
    /// Instants of touch-down, s.
    pub touches_s: Vec<f64>,
    /// Instants of lift-off, s.
    pub lifts_s: Vec<f64>,
    /// Largest force, N. It is that of the motion itself for the exact integrator, else of the record, with a
    /// parabola between its rows.
    pub peak_force_n: f64,
    pub peak_at_s: f64,
    /// The largest pull of a clamped contact, as a positive force, if it exceeds the largest push; from the
    /// record.
    pub pull: Option<Peak>,
}

impl ContactRun {
    /// The signal of its total force.
    pub fn force_signal(&self) -> String {
        SignalName::new(&self.name, Quantity::Force).to_string()
    }

    /// Time in contact, s.
    pub fn contact_time_s(&self) -> f64 {
        self.intervals.iter().map(|interval| interval.length_s()).sum()
    }

    /// Time of the first push, s.
    pub fn first_contact_s(&self) -> Option<f64> {
        self.intervals.first().map(|interval| interval.start_s)
    }

    /// The largest force in magnitude, push or pull.
    pub fn largest(&self) -> Peak {
        self.pull.unwrap_or(Peak { t_s: self.peak_at_s, force_n: self.peak_force_n })
    }

    /// Whether it pushes at the end of the run.
    pub(crate) fn ends_in_contact(&self, end_s: f64) -> bool {
        self.intervals.last().is_some_and(|interval| interval.end_s >= end_s)
    }
}

/// `found` are the engine's peaks, per contact; without them the peaks come from the record. Peaks at the
/// ends of fixed steps may be lower than those of a parabola through the rows.
pub(in crate::run) fn contacts(
    scenario: &Scenario,
    assembly: &Assembly,
    record: &Trace,
    found: &[Vec<Peak>],
    end_s: f64,
) -> Vec<ContactRun> {
    let is_exact = scenario.run.integrator == Integrator::Exact;
    let found = |i: usize| found.get(i).map(|peaks| (peaks.as_slice(), is_exact));
    scenario
        .machine
        .contacts
        .keys()
        .enumerate()
        .map(|(i, name)| contact(i, name, assembly, record, found(i), end_s))
        .collect()
}

fn contact(
    index: usize,
    name: &str,
    assembly: &Assembly,
    record: &Trace,
    found: Option<(&[Peak], bool)>,
    end_s: f64,
) -> ContactRun {
    let instants = |kind: EventKind| {
        let meant = record
            .events
            .iter()
            .filter(move |event| event.kind == kind && event.switch == Switch::Contact(index));
        meant.map(|event| event.t_s).collect::<Vec<_>>()
    };
    let (touches_s, lifts_s) = (instants(EventKind::Touch), instants(EventKind::Lift));
    let column = |quantity| record.column(&SignalName::new(name, quantity).to_string()).unwrap_or_default();
    let closed_at_start = column(Quantity::Contact).first().is_some_and(|&state| state > 0.5);
    let force_n = column(Quantity::Force);
    let intervals = intervals(closed_at_start, &touches_s, &lifts_s, end_s);
    let peak_within = |interval: &Interval| {
        let touches = touches_s.binary_search_by(|touch| touch.total_cmp(&interval.start_s)).is_ok();
        // A row at the exact instant of a touch is still one without contact.
        let first = record
            .t_s
            .partition_point(|&t| if touches { t <= interval.start_s } else { t < interval.start_s });
        let rows = first..record.t_s.partition_point(|&t| t <= interval.end_s).max(first);
        let (t_s, force_n) = (&record.t_s[rows.clone()], &force_n[rows]);
        let begins = touches.then(|| at_touch(interval.start_s, t_s, force_n)).flatten();
        begins.map_or_else(|| peak(t_s, force_n), |force_n| Peak { t_s: interval.start_s, force_n })
    };
    let higher = |(a, b): (Peak, &Peak)| if b.force_n > a.force_n { *b } else { a };
    let of_record = intervals.iter().map(peak_within);
    let peaks: Vec<Peak> = match found {
        Some((found, true)) => found.to_vec(),
        Some((found, false)) => of_record.zip(found).map(higher).collect(),
        None => of_record.collect(),
    };
    debug_assert_eq!(peaks.len(), intervals.len(), "one peak for every time that `{name}` pushes");
    let hardest =
        peaks.iter().copied().reduce(|a, b| if b.force_n > a.force_n { b } else { a }).unwrap_or_default();
    let engagement = assembly.contacts[index].engagement;
    ContactRun {
        name: name.to_owned(),
        engagement,
        pull: Some(engagement)
            .filter(|held| *held == Engagement::Clamped)
            .and_then(|_| pull(&record.t_s, force_n, hardest.force_n)),
        interval_peaks_n: peaks.iter().map(|peak| peak.force_n).collect(),
        intervals,
        touches_s,
        lifts_s,
        peak_force_n: hardest.force_n,
        peak_at_s: hardest.t_s,
    }
}

/// The largest pull of a contact, if it exceeds the largest push.
fn pull(t_s: &[f64], force_n: &[f64], push_n: f64) -> Option<Peak> {
    if force_n.iter().all(|&force| force >= -push_n) {
        return None;
    }
    let pulls_n: Vec<f64> = force_n.iter().map(|force| -force).collect();
    Some(peak(t_s, &pulls_n))
}

fn intervals(closed_at_start: bool, touches_s: &[f64], lifts_s: &[f64], end_s: f64) -> Vec<Interval> {
    // A touch at time zero is already in the state of the first row.
    let at_start = closed_at_start
        && !touches_s.first().is_some_and(|&touch| lifts_s.first().is_none_or(|&lift| touch < lift));
    let starts = at_start.then_some(0.0).into_iter().chain(touches_s.iter().copied());
    let ends = lifts_s.iter().copied().chain(std::iter::once(end_s));
    starts.zip(ends).map(|(start_s, end_s)| Interval { start_s, end_s }).collect()
}

/// The force at the start of a touch, if it only falls from there: a damper acts immediately. From a parabola
/// through the first three rows.
fn at_touch(touch_s: f64, t_s: &[f64], force_n: &[f64]) -> Option<f64> {
    let (&[t1, t2, ..], &[f1, f2, f3, ..]) = (t_s, force_n) else { return None };
    let falls = f1 > f2 && force_n.iter().all(|&force| force <= f1);
    let before = (t1 - touch_s) / (t2 - t1);
    falls.then_some(f1 + before * (f1 - f2) + 0.5 * before * (before + 1.0) * (f1 - 2.0 * f2 + f3))
}

/// The largest value of a record and its time: the vertex of the parabola through the largest row and its
/// neighbours.
pub(in crate::run) fn peak(t_s: &[f64], values: &[f64]) -> Peak {
    let Some((row, &largest)) = values.iter().enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b)) else {
        return Peak::default();
    };
    let at_row = Peak { t_s: t_s[row], force_n: largest.max(0.0) };
    let (Some(&before), Some(&after)) = (row.checked_sub(1).and_then(|i| values.get(i)), values.get(row + 1))
    else {
        return at_row;
    };
    let bend = before - 2.0 * largest + after;
    // A parabola across a jump of the force would overshoot it.
    if before <= 0.0 || after <= 0.0 || bend >= 0.0 {
        return at_row;
    }
    let shift = 0.5 * (before - after) / bend;
    Peak {
        t_s: t_s[row] + shift * (t_s[row + 1] - t_s[row]),
        force_n: largest - 0.25 * (before - after) * shift,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Peak of a sine of 150 Hz at 10 kHz: the parabola errs by about (w dt)^4 / 128 = 6e-7 of it.
    const PARABOLA: f64 = 1e-5;

    #[test]
    fn truth_the_peak_of_a_sine_is_found_between_rows() {
        let t_s: Vec<f64> = (0..200).map(|i| f64::from(i) * 1e-4).collect();
        let shift_s = 0.37e-4;
        let force: Vec<f64> = t_s
            .iter()
            .map(|t| 50.0 + 40.0 * (std::f64::consts::TAU * 150.0 * (t - 5e-3 - shift_s)).cos())
            .collect();
        let found = peak(&t_s[..100], &force[..100]);
        assert!((found.force_n - 90.0).abs() < 40.0 * PARABOLA, "{found:?}");
        assert!((found.t_s - 5e-3 - shift_s).abs() < 1e-6, "{found:?}");
    }

    /// `100 exp(-t / 1 ms)` from a touch between two rows on: the parabola errs by
    /// `(dt / tau)^3 s (s + 1) (s + 2) / 6`, 3e-4 here.
    #[test]
    fn truth_the_force_at_touch_down_is_found_before_the_first_row() {
        let touch_s = 4.5e-5;
        let t_s: Vec<f64> = (1..40).map(|i| f64::from(i) * 1e-4).collect();
        let force: Vec<f64> = t_s.iter().map(|t| 100.0 * (-(t - touch_s) / 1e-3).exp()).collect();
        assert!((at_touch(touch_s, &t_s, &force).unwrap() - 100.0).abs() < 0.04);
        assert_eq!(at_touch(touch_s, &t_s, &t_s), None);
    }

    #[test]
    fn truth_a_jump_is_not_overshot() {
        assert_eq!(peak(&[0.0, 1.0, 2.0], &[0.0, 10.0, 9.0]), Peak { t_s: 1.0, force_n: 10.0 });
    }

    #[test]
    fn regress_a_contact_that_only_pulls_has_a_peak() {
        let t_s = [0.0, 1.0, 2.0, 3.0];
        assert_eq!(pull(&t_s, &[0.0, -1.0, -4.0, -9.0], 0.0), Some(Peak { t_s: 3.0, force_n: 9.0 }));
        assert_eq!(pull(&t_s, &[0.0, 10.0, -4.0, -9.0], 10.0), None);
    }

    #[test]
    fn truth_intervals_follow_from_events() {
        let spans = |closed, touches: &[f64], lifts: &[f64]| {
            intervals(closed, touches, lifts, 9.0).iter().map(|i| (i.start_s, i.end_s)).collect::<Vec<_>>()
        };
        assert_eq!(spans(false, &[1.0, 3.0], &[2.0]), [(1.0, 2.0), (3.0, 9.0)]);
        assert_eq!(spans(true, &[3.0], &[2.0, 4.0]), [(0.0, 2.0), (3.0, 4.0)]);
        assert_eq!(spans(true, &[], &[]), [(0.0, 9.0)]);
        assert_eq!(spans(true, &[0.0], &[2.0]), [(0.0, 2.0)]);
        assert_eq!(spans(false, &[], &[]), []);
    }
}
