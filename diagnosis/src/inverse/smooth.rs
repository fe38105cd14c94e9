//! Tests whether a smooth force that no effect of the library makes would balance clearly better. At the
//! guide such a force depends on position, speed, direction and time; in the drive it depends on the command.

use feeler_plant::effects::Place;

use super::Inverse;
use super::rows::Rows;
use super::solve::Term;
use crate::fit::candidates::Candidate;

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
    /// Smooth forces at the guide and in the drive, in addition to some causes. Empty if the balance does not
    /// involve the causes.
    pub(crate) fn beyond(&self, causes: &[Candidate]) -> Vec<Smooth> {
        let Some(shaped) = self.shaped(causes) else { return Vec::new() };
        let Some(left) = self.left(&shaped, None) else { return Vec::new() };
        let of = |place: Place| {
            let with = self.left(&shaped, Some(place))?;
            let share = 1.0 - with / left.max(f64::MIN_POSITIVE);
            let nats = self.nats(left, with);
            Some(Smooth { place, nats, share, left: left.sqrt() / self.drive_force() })
        };
        [Place::Guide, Place::Drive].into_iter().filter_map(of).collect()
    }

    /// The terms of a smooth force in the drive, a function of the command. `made` is the command that the
    /// motion requires. With the measured command the terms would contain its noise, and would explain it.
    pub(super) fn drive_terms(&self, made: &[f64]) -> Vec<Term> {
        let largest = self.extent.command.max(f64::MIN_POSITIVE);
        let shapes: [fn(f64) -> f64; 3] = [|u| u * u, |u| u * u.abs(), |u| u * u * u];
        let term = |f: fn(f64) -> f64| free(made.iter().map(|u| largest * f(u / largest)).collect());
        shapes.into_iter().map(term).collect()
    }

    /// The terms of a smooth force at the guide, as functions of position, speed, direction and time.
    pub(super) fn guide_terms(&self, rows: &Rows) -> Vec<Term> {
        let half = 0.5 * self.extent.stroke.max(f64::MIN_POSITIVE);
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
        let centre = self.centre;
        let mut terms: Vec<Term> = motion
            .into_iter()
            .map(|f| {
                free(rows.of_motion(0.0, |at| {
                    largest * f((at.position - centre) / half, at.speed / usual, at.direction)
                }))
            })
            .collect();
        let turning = rows.of_motion(0.0, |at| at.direction);
        let times = rows.times_s();
        terms.push(free(turning.iter().zip(&times).map(|(d, t)| largest * d * t / self.until_s).collect()));
        terms
    }
}

/// A term with a coefficient of either sign.
fn free(series: Vec<f64>) -> Term {
    Term { series, low: f64::NEG_INFINITY, high: f64::INFINITY }
}
