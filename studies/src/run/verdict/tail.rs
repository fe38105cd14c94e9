//! The last part of a run, which decides its outcome.

use crate::run::measure::settling::SETTLING_BAND;
use crate::run::measure::trend::Trend;
use crate::run::measure::turns::turns;
use crate::run::verdict::evidence::Evidence;
use crate::run::verdict::outcome::{Outcome, RunVerdict, Undecided};

/// Ratio of the last part's amplitude to the first part's below which the oscillation decays.
pub(super) const LASTS: f64 = 0.7;
/// Smallest share of the tail at a limit for an oscillation by saturation.
pub(super) const SATURATES: f64 = 0.01;
/// Smallest number of turns of the force in the three parts of the tail together, and in each, for an
/// oscillation: two cycles.
const LEAST_TURNS: (usize, usize) = (4, 1);
/// Smallest number of rows for a verdict.
pub(super) const LEAST_ROWS: usize = 30;

#[derive(Clone, Copy, Debug)]
pub(super) struct Tail {
    /// First row of the tail.
    pub(super) first: usize,
    /// Start and end of the tail, s.
    pub(super) span_s: [f64; 2],
    /// Amplitudes of the three parts of the tail, N.
    pub(super) amplitudes_n: [f64; 3],
}

impl Tail {
    /// The tail: from the middle between the last change and the end.
    pub(super) fn of(evidence: &Evidence<'_>) -> Self {
        let end_s = evidence.t_s.last().copied().unwrap_or(0.0);
        let start_s = evidence.starts_at_s.map_or(0.5 * end_s, |start| start + 0.5 * (end_s - start));
        let span_s = [start_s.min(end_s), end_s];
        let first = evidence.t_s.partition_point(|&t| t < span_s[0]);
        Self { first, span_s, amplitudes_n: evidence.amplitudes_n(first) }
    }

    pub(super) fn length_s(&self) -> f64 {
        self.span_s[1] - self.span_s[0]
    }

    /// Rate at which the amplitude grows from the first part to the last, 1/s.
    pub(super) fn growth_per_s(&self) -> f64 {
        (self.amplitudes_n[2] / self.amplitudes_n[0]).ln() / (2.0 / 3.0 * self.length_s())
    }

    /// Start of the last part of the tail, s.
    pub(super) fn last_part_s(&self) -> f64 {
        self.span_s[1] - self.length_s() / 3.0
    }

    pub(super) fn is(&self, outcome: Outcome) -> RunVerdict {
        RunVerdict {
            outcome,
            tail_s: self.span_s,
            amplitudes_n: self.amplitudes_n,
            growth_per_s: None,
            undecided: None,
            touches_at_s: None,
        }
    }

    pub(super) fn is_undecided(&self, why: Undecided) -> RunVerdict {
        RunVerdict { undecided: Some(why), ..self.is(Outcome::Undecided) }
    }
}

/// Properties of the force in the tail, with contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    /// Amplitude that counts as rest, N.
    pub(super) band_n: f64,
    /// Whether the last part may be a response to noise.
    pub(super) is_noisy: bool,
    /// Trend of the amplitudes of its windows; `None` with too few windows.
    pub(super) trend: Option<Trend>,
    /// Lift-offs in the tail, and in its last part.
    pub(super) lifts: (usize, usize),
}

impl Motion {
    pub(super) fn of(evidence: &Evidence<'_>, tail: &Tail) -> Self {
        let force = &evidence.force_n[tail.first..];
        let mean = force.iter().sum::<f64>() / force.len() as f64;
        let last_n = tail.amplitudes_n[2];
        Self {
            band_n: evidence.band_n.unwrap_or(SETTLING_BAND * mean.abs()),
            is_noisy: evidence.may_be_noise(last_n),
            trend: evidence.trend(force, last_n),
            lifts: (evidence.lifts_after(tail.span_s[0]), evidence.lifts_after(tail.last_part_s())),
        }
    }
}

impl Evidence<'_> {
    /// Whether the tail, from row `first` on, has enough cycles to separate an oscillation from a slow
    /// motion.
    pub(super) fn oscillates(&self, first: usize) -> bool {
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
