//! Tests whether a smooth force that no effect of the library makes would balance clearly better. At the
//! guide such a force depends on position, speed, direction and time; in the drive it depends on the command.

use feeler_plant::effects::Place;

use super::family::Family;
use super::rows::Rows;
use super::solve::Term;
use super::{Inverse, mean, nats};
use crate::fit::candidates::Candidate;

/// Nodes over the stroke between which a force that depends on position is linear.
const NODES: usize = 9;
/// Time constants of a force that fades while a guide warms, as shares of the recorded time.
const FADES: [f64; 2] = [0.05, 0.2];

/// A smooth force in addition to some causes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Smooth {
    /// The place at which it acts.
    pub(crate) place: Place,
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
            Some(Smooth {
                place: family.place(),
                nats,
                share,
                left: self.force(&before) / self.drive_force(),
            })
        };
        Family::ALL.into_iter().filter_map(of).collect()
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

    /// The terms of a smooth force at the guide; none for a force in the drive.
    pub(super) fn guide_terms(&self, rows: &Rows, family: Family) -> Vec<Term> {
        match family {
            Family::Motion => self.motion_terms(rows),
            Family::Places => self.place_terms(rows),
            Family::Time => self.time_terms(rows),
            Family::Command => Vec::new(),
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
