//! Tests whether a smooth force that no effect of the library makes would balance clearly better. At the
//! guide such a force depends on position, speed, direction and time; in the drive it depends on the command
//! and the speed.

use std::f64::consts::TAU;

use feeler_plant::effects::Place;

use super::family::{FADES, Family, NODES};
use super::rows::Moving;
use super::solve::Term;
use super::{Inverse, PER_UNKNOWN, Shaped, mean, nats};
use crate::fit::candidates::Candidate;

/// Trial numbers of waves per stroke of friction that repeats: the least, their distance and their count.
/// Their distance turns the phase over the stroke by less than half a turn.
const LEAST_WAVES: f64 = 1.4;
const WAVES_STEP: f64 = 0.4;
const WAVES: usize = 60;
/// Step between trial shares of its force that a drive loses at the largest speed, and their count.
const FADING_STEP: f64 = 0.02;
const FADINGS: usize = 46;

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

impl Smooth {
    /// The gain less what its unknowns cost, nats.
    pub(crate) fn evidence(&self) -> f64 {
        self.nats - PER_UNKNOWN * self.family.unknowns() as f64
    }
}

/// A smooth force instead of causes, one of them at least at another place.
#[derive(Clone, Debug)]
pub(crate) struct Instead {
    pub(crate) smooth: Smooth,
    /// The causes that stay.
    pub(crate) kept: Vec<Candidate>,
    /// Evidence over all causes, nats.
    pub(crate) gain: f64,
}

impl Inverse {
    /// Smooth forces of every family, in addition to some causes. Empty if the balance does not involve the
    /// causes.
    pub(crate) fn beyond(&self, causes: &[Candidate]) -> Vec<Smooth> {
        self.shaped(causes, true).map_or_else(Vec::new, |shaped| self.beside(&shaped, |_| true))
    }

    /// Smooth forces that replace causes, one of them at least at another place. Empty if the balance does
    /// not involve the causes.
    pub(crate) fn instead(&self, causes: &[Candidate]) -> Vec<Instead> {
        let Some(own) = self.evidence(causes) else { return Vec::new() };
        let mut found = Vec::new();
        for place in [Place::Drive, Place::Guide] {
            let stands = |family: Family| family.is_distinct() && family.place() == place;
            for kept in fewer(causes, place) {
                let Some(shaped) = self.shaped(&kept, true) else { continue };
                let Some(evidence) = self.evidence_of(&shaped) else { continue };
                found.extend(self.beside(&shaped, stands).into_iter().map(|smooth| Instead {
                    smooth,
                    kept: kept.clone(),
                    gain: evidence + smooth.evidence() - own,
                }));
            }
        }
        found
    }

    /// Gain of causes over calibration alone on the check experiments, less what the unknowns of the balance
    /// cost, nats.
    pub(crate) fn evidence(&self, causes: &[Candidate]) -> Option<f64> {
        self.evidence_of(&self.shaped(causes, true)?)
    }

    fn evidence_of(&self, shaped: &Shaped<'_>) -> Option<f64> {
        let left = self.squares(shaped, None)?;
        Some(nats(&self.alone, &left) - PER_UNKNOWN * shaped.unknowns as f64)
    }

    /// Smooth forces of the families that are wanted, in addition to some causes.
    fn beside(&self, shaped: &Shaped<'_>, is_wanted: impl Fn(Family) -> bool) -> Vec<Smooth> {
        let Some(before) = self.squares(shaped, None) else { return Vec::new() };
        let left = mean(&before);
        let of = |family: Family| {
            let with = self.squares(shaped, Some(family))?;
            let share = 1.0 - mean(&with) / left.max(f64::MIN_POSITIVE);
            let nats = nats(&before, &with);
            Some(Smooth { family, nats, share, left: self.force(&before) / self.drive_force() })
        };
        let wanted = self.families().into_iter().filter(|sort| is_wanted(sort[0]));
        wanted.filter_map(|sort| of(self.best_of(shaped, sort)?)).collect()
    }

    /// Every family, with its trial shapes.
    fn families(&self) -> [Vec<Family>; 6] {
        let stroke = self.extent.stroke();
        let waves = (0..WAVES).map(|k| LEAST_WAVES + WAVES_STEP * k as f64);
        let fastest = self.fitted.iter().flat_map(|rows| rows.thin(&rows.speed));
        let fastest = fastest.fold(f64::MIN_POSITIVE, |most, v| most.max(v.abs()));
        let fading = (1..=FADINGS).map(|k| FADING_STEP * k as f64 / fastest);
        [
            vec![Family::Motion],
            vec![Family::Places],
            waves.map(|waves| Family::Waves { pitch_m: stroke / waves }).collect(),
            vec![Family::Time],
            vec![Family::Command],
            fading.map(|per_speed| Family::Fading { per_speed }).collect(),
        ]
    }

    /// The shape that leaves least on the fitted experiments.
    fn best_of(&self, shaped: &Shaped<'_>, sort: Vec<Family>) -> Option<Family> {
        if let [only] = sort[..] {
            return Some(only);
        }
        let tried = sort.into_iter().map(|family| (self.left(shaped, Some(family)), family));
        let best = tried.filter(|(left, _)| left.is_finite()).min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(best.1)
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

    /// Terms of friction that repeats over the stroke, with its mean.
    fn wave_terms(&self, rows: &Moving<'_>, pitch_m: f64) -> Vec<Term> {
        let shapes: [fn(f64) -> f64; 3] = [|_| 1.0, f64::sin, f64::cos];
        let largest = self.extent.command.max(f64::MIN_POSITIVE);
        let term = |f: fn(f64) -> f64| {
            free(rows.of_motion(0.0, |at| largest * at.direction * f(TAU * at.position / pitch_m)))
        };
        shapes.into_iter().map(term).collect()
    }

    /// The terms of a smooth force at the guide; none for a force in the drive.
    pub(super) fn guide_terms(&self, rows: &Moving<'_>, family: Family) -> Vec<Term> {
        match family {
            Family::Waves { pitch_m } => self.wave_terms(rows, pitch_m),
            Family::Motion => self.motion_terms(rows),
            Family::Places => self.place_terms(rows),
            Family::Time => self.time_terms(rows),
            Family::Command | Family::Fading { .. } => Vec::new(),
        }
    }

    fn motion_terms(&self, rows: &Moving<'_>) -> Vec<Term> {
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

    fn place_terms(&self, rows: &Moving<'_>) -> Vec<Term> {
        let spacing = self.extent.stroke().max(f64::MIN_POSITIVE) / (NODES - 1) as f64;
        let first = self.extent.ends[0];
        let largest = self.extent.command.max(f64::MIN_POSITIVE);
        let share = |position: f64, node: usize| {
            largest * (1.0 - ((position - first) / spacing - node as f64).abs()).max(0.0)
        };
        // A term without rows would leave the others undetermined, too.
        let is_reached = |node: &usize| {
            let centre = first + *node as f64 * spacing;
            self.fitted.iter().any(|rows| rows.come_near(centre, spacing))
        };
        let nodes: Vec<usize> = (0..NODES).filter(is_reached).collect();
        let smooth = |&node: &usize| free(rows.of_motion(0.0, |at| share(at.position, node)));
        let dry = |&node: &usize| free(rows.of_motion(0.0, |at| at.direction * share(at.position, node)));
        nodes.iter().map(smooth).chain(nodes.iter().map(dry)).collect()
    }

    fn time_terms(&self, rows: &Moving<'_>) -> Vec<Term> {
        let fades = FADES.into_iter().map(|fade| self.drifting(rows, |t| (-t / fade).exp()));
        [self.drifting(rows, |_| 1.0), self.drifting(rows, |t| t)].into_iter().chain(fades).collect()
    }

    /// Friction with a level that is a function of time over the recorded time.
    fn drifting(&self, rows: &Moving<'_>, level: impl Fn(f64) -> f64) -> Term {
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

/// The sets of causes that lack some, one of them at another place than `place`.
fn fewer(causes: &[Candidate], place: Place) -> Vec<Vec<Candidate>> {
    let is_kept = |i: usize, set: usize| set & (1 << i) != 0;
    let lacks = |set: &usize| (0..causes.len()).any(|i| causes[i].place != place && !is_kept(i, *set));
    let of = |set: usize| (0..causes.len()).filter(|i| is_kept(*i, set)).map(|i| causes[i]).collect();
    (0..1_usize << causes.len()).filter(lacks).map(of).collect()
}
