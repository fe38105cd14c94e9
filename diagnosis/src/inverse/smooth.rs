//! Tests whether a smooth force that no effect of the library makes would balance clearly better. At the
//! guide such a force depends on position, speed, direction and time; in the drive it depends on the command.

use std::f64::consts::TAU;

use super::family::{FADES, Family, NODES};
use super::rows::Rows;
use super::solve::{Term, solve};
use super::{Inverse, Shaped, mean, nats, squares};
use crate::fit::candidates::Candidate;
use crate::kinds::spread;

/// Trial pitches of friction that waves over the stroke, as shares of the stroke.
const SHORTEST_WAVE: f64 = 0.04;
const LONGEST_WAVE: f64 = 0.7;
const WAVES: usize = 60;

/// A smooth force in addition to some causes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Smooth {
    pub(crate) family: Family,
    /// Gain on the check experiments, nats.
    pub(crate) nats: f64,
    /// Share of the remaining variance on the check experiments that the force removes.
    pub(crate) share: f64,
    /// Root mean square of the force that the causes leave unexplained, over the drive force.
    pub(crate) left: f64,
}

impl Inverse {
    /// Smooth forces of every family, in addition to some causes. Empty if the balance does not involve the
    /// causes.
    pub(crate) fn beyond(&self, causes: &[Candidate]) -> Vec<Smooth> {
        let Some(shaped) = self.shaped(causes) else { return Vec::new() };
        let Some(before) = self.squares(&shaped, None) else { return Vec::new() };
        let left = mean(&before);
        let of = |family: Family| {
            let with = self.squares(&shaped, Some(family))?;
            let share = 1.0 - mean(&with) / left.max(f64::MIN_POSITIVE);
            let nats = nats(&before, &with);
            Some(Smooth { family, nats, share, left: self.force(&before) / self.drive_force() })
        };
        Family::PLAIN.into_iter().chain(self.waves(&shaped)).filter_map(of).collect()
    }

    /// The terms of a smooth force in the drive, a function of the command. `made` is the command that the
    /// motion requires, times the rows' weights. With the measured command the terms would contain its noise,
    /// and would explain it.
    pub(super) fn drive_terms(&self, made: &[f64], weights: &[f64]) -> Vec<Term> {
        let largest = self.extent.command.max(f64::MIN_POSITIVE);
        let shapes: [fn(f64) -> f64; 3] = [|u| u * u, |u| u * u.abs(), |u| u * u * u];
        let term = |f: fn(f64) -> f64| {
            let of = |(u, weight): (&f64, &f64)| weight * largest * f(u / (weight * largest));
            free(made.iter().zip(weights).map(of).collect())
        };
        shapes.into_iter().map(term).collect()
    }

    /// The terms of a drive whose force falls with speed, as of a motor near its largest voltage. `made` as
    /// in [`Self::drive_terms`].
    pub(super) fn fading_terms(&self, made: &[f64], speeds: &[f64]) -> Vec<Term> {
        let usual = self.extent.speed.max(f64::MIN_POSITIVE);
        let shapes: [fn(f64) -> f64; 2] = [f64::abs, |v| v * v];
        let term =
            |f: fn(f64) -> f64| free(made.iter().zip(speeds).map(|(made, v)| made * f(v / usual)).collect());
        shapes.into_iter().map(term).collect()
    }

    /// Friction that waves over the stroke, with the pitch that fits the fitted experiments best.
    fn waves(&self, shaped: &Shaped<'_>) -> Option<Family> {
        let stroke = self.extent.stroke();
        let (terms, target) = self.balance(&self.fitted, shaped, None);
        let left = |pitch: f64| {
            let mut terms = terms.clone();
            let mut waves: Vec<Term> = Vec::new();
            for rows in &self.fitted {
                let own = self.wave_terms(rows, pitch);
                let weighed = own.into_iter().map(|term| Term { series: rows.weighed(&term.series), ..term });
                if waves.is_empty() {
                    waves = weighed.collect();
                } else {
                    waves.iter_mut().zip(weighed).for_each(|(all, term)| all.series.extend(term.series));
                }
            }
            terms.extend(waves);
            solve(&terms, &target).map_or(f64::INFINITY, |x| mean(&squares(&terms, &x, &target)))
        };
        let pitches = spread(SHORTEST_WAVE * stroke, LONGEST_WAVE * stroke, WAVES);
        let tried = pitches.into_iter().map(|pitch| (left(pitch), pitch));
        let (_, pitch_m) = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Family::Waves { pitch_m })
    }

    fn wave_terms(&self, rows: &Rows, pitch: f64) -> Vec<Term> {
        let largest = self.extent.command.max(f64::MIN_POSITIVE);
        let term = |f: fn(f64) -> f64| {
            free(rows.of_motion(0.0, |at| largest * at.direction * f(TAU * at.position / pitch)))
        };
        [f64::sin as fn(f64) -> f64, f64::cos].into_iter().map(term).collect()
    }

    /// The terms of a smooth force at the guide; none for a force in the drive.
    pub(super) fn guide_terms(&self, rows: &Rows, family: Family) -> Vec<Term> {
        match family {
            Family::Waves { pitch_m } => self.wave_terms(rows, pitch_m),
            Family::Motion => self.motion_terms(rows),
            Family::Places => self.place_terms(rows),
            Family::Time => self.time_terms(rows),
            Family::Command | Family::Fading => Vec::new(),
        }
    }

    fn motion_terms(&self, rows: &Rows) -> Vec<Term> {
        let half = 0.5 * self.extent.stroke().max(f64::MIN_POSITIVE);
        let usual = self.extent.speed.max(f64::MIN_POSITIVE);
        let largest = self.extent.command.max(f64::MIN_POSITIVE);
        let motion: [fn(f64, f64, f64) -> f64; 12] = [
            |_, _, _| 1.0,
            |s, _, _| s,
            |s, _, _| s * s,
            |s, _, _| s * s * s,
            |s, _, _| s * s * s * s,
            |_, _, d| d,
            |s, _, d| s * d,
            |s, _, d| s * s * d,
            |_, w, _| w.abs(),
            |_, w, _| w * w.abs(),
            |s, w, _| s * w,
            |s, w, _| s * s * w,
        ];
        let term = |f: fn(f64, f64, f64) -> f64| {
            free(rows.of_motion(0.0, |at| {
                largest * f((at.position - at.middle) / half, at.speed / usual, at.direction)
            }))
        };
        motion.into_iter().map(term).chain([self.drifting(rows, |t| t)]).collect()
    }

    fn place_terms(&self, rows: &Rows) -> Vec<Term> {
        let spacing = self.extent.stroke().max(f64::MIN_POSITIVE) / (NODES - 1) as f64;
        let first = self.extent.ends[0];
        let largest = self.extent.command.max(f64::MIN_POSITIVE);
        let share = |position: f64, node: usize| {
            largest * (1.0 - ((position - first) / spacing - node as f64).abs()).max(0.0)
        };
        let smooth = |node| free(rows.of_motion(0.0, |at| share(at.position, node)));
        let dry = |node| free(rows.of_motion(0.0, |at| at.direction * share(at.position, node)));
        (0..NODES).map(smooth).chain((0..NODES).map(dry)).collect()
    }

    fn time_terms(&self, rows: &Rows) -> Vec<Term> {
        let fades = FADES.into_iter().map(|fade| self.drifting(rows, |t| (-t / fade).exp()));
        [self.drifting(rows, |_| 1.0), self.drifting(rows, |t| t)].into_iter().chain(fades).collect()
    }

    /// Friction with a level that is a function of time over the recorded time.
    fn drifting(&self, rows: &Rows, level: impl Fn(f64) -> f64) -> Term {
        let largest = self.extent.command.max(f64::MIN_POSITIVE);
        let turning = rows.of_motion(0.0, |at| at.direction);
        let times = rows.times_s();
        let at = |(d, t): (&f64, &f64)| largest * d * level((t - self.from_s) / self.span_s);
        free(turning.iter().zip(&times).map(at).collect())
    }
}

/// A term with a coefficient of either sign.
pub(super) fn free(series: Vec<f64>) -> Term {
    Term { series, low: f64::NEG_INFINITY, high: f64::INFINITY }
}
