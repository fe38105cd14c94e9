//! `force-ripple`: a force periodic in position.

use std::f64::consts::TAU;

use feeler_plant::effects::ForceRipple;

use super::{Balance, Element, Force, Form, Glance, Known, Seen, spread};

/// Step between trial waves, in waves per stroke, from half a wave upwards. It changes the phase over the
/// stroke by less than half a turn.
const WAVES_STEP: f64 = 0.25;
const PITCHES: usize = 400;
/// Number of pitches passed on to the fit.
const BEST_PITCHES: usize = 4;
/// Largest number of ripples per turn of a geared motor that is tried, and the number of these pitches passed
/// on to the fit.
const PER_TURN: u32 = 12;
const BEST_PER_TURN: usize = 2;
/// Number of trial pitches in a balance of forces.
const BALANCED_PITCHES: usize = 120;
/// Number of evaluated points of the missing force per record.
const POINTS: usize = 1500;
/// Smallest number of periods of a ripple within the stroke.
const PERIODS: f64 = 1.6;

impl Known for ForceRipple {
    const BALANCE: Option<Balance<Self>> = Some(Balance {
        form: Form::Forces(&[
            Force::signed(|at| -(TAU * at.position / at.shape).sin()),
            Force::signed(|at| -(TAU * at.position / at.shape).cos()),
        ]),
        shapes: |extent| spread(0.02 * extent.stroke(), 0.6 * extent.stroke(), BALANCED_PITCHES),
        values: |of, pitch| Self {
            amplitude: of[0].hypot(of[1]),
            pitch,
            phase: of[1].atan2(of[0]),
            harmonic: 1.0,
        },
        coefficients: |own| {
            (vec![own.amplitude * own.phase.cos(), own.amplitude * own.phase.sin()], own.pitch / own.harmonic)
        },
    });

    /// Ripple of a geared motor repeats a whole number of times per turn of the motor.
    fn starts(element: &Element<'_>, glance: &Glance) -> Vec<Self> {
        let Some(points) = Points::of(&glance.missing) else { return Vec::new() };
        let turn = element.motor_turn();
        let of_motor = turn.into_iter().flat_map(|turn| (1..=PER_TURN).map(move |n| turn / f64::from(n)));
        let of_motor = points.waves(of_motor.filter(|pitch| points.stroke > PERIODS * pitch), BEST_PER_TURN);
        of_motor.into_iter().chain(points.best()).collect()
    }

    /// A sine with hardly more than one period within the stroke is a general position-dependent force, not a
    /// ripple.
    fn is_trivial(self, _: &Element<'_>, seen: Seen) -> bool {
        seen.stroke_m() < PERIODS * self.pitch
    }

    fn force_over_position(self) -> Option<f64> {
        Some(self.amplitude)
    }
}

/// The sines over position that explain most of the missing force.
pub(crate) fn ripples(missing: &[(f64, f64)]) -> Vec<ForceRipple> {
    Points::of(missing).map_or_else(Vec::new, |points| points.best())
}

/// Points of the missing force over position, without its mean.
struct Points {
    points: Vec<(f64, f64)>,
    stroke: f64,
}

impl Points {
    /// `None` if there are too few, or no stroke.
    fn of(missing: &[(f64, f64)]) -> Option<Self> {
        let (low, high) =
            missing.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (x, _)| (l.min(*x), h.max(*x)));
        let stroke = high - low;
        if missing.len() < 50 || stroke <= 0.0 {
            return None;
        }
        let thin = (missing.len() / (8 * POINTS)).max(1);
        let points: Vec<(f64, f64)> = missing.iter().step_by(thin).copied().collect();
        let mean = points.iter().map(|(_, f)| f).sum::<f64>() / points.len() as f64;
        Some(Self { points: points.iter().map(|(x, f)| (*x, f - mean)).collect(), stroke })
    }

    /// The best sines of any pitch.
    fn best(&self) -> Vec<ForceRipple> {
        self.waves((0..PITCHES).map(|k| self.stroke / (WAVES_STEP * (k + 2) as f64)), BEST_PITCHES)
    }

    /// Up to `most` sines of these pitches that explain most of the force, more than a wave per stroke apart.
    fn waves(&self, pitches: impl Iterator<Item = f64>, most: usize) -> Vec<ForceRipple> {
        let mut found: Vec<(f64, ForceRipple)> = pitches
            .filter_map(|pitch| {
                let (gain, [a, b]) = wave(&self.points, pitch)?;
                Some((gain, ForceRipple { amplitude: a.hypot(b), pitch, phase: b.atan2(a), harmonic: 1.0 }))
            })
            .collect();
        found.sort_by(|x, y| y.0.total_cmp(&x.0));
        let mut best: Vec<ForceRipple> = Vec::new();
        for (_, wave) in found {
            let count = |wave: &ForceRipple| self.stroke / wave.pitch;
            let is_new = |other: &ForceRipple| (count(other) - count(&wave)).abs() > 1.0;
            if best.len() < most && best.iter().all(is_new) {
                best.push(wave);
            }
        }
        best
    }
}

/// The sine and cosine of a period that explain most of a force over position, and the explained amount.
/// `None` if the positions do not determine their amplitudes.
pub(super) fn wave(points: &[(f64, f64)], period: f64) -> Option<(f64, [f64; 2])> {
    let (mut ss, mut cc, mut sc, mut sf, mut cf) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (x, f) in points {
        let (s, c) = (TAU * x / period).sin_cos();
        ss += s * s;
        cc += c * c;
        sc += s * c;
        sf += s * f;
        cf += c * f;
    }
    let det = ss * cc - sc * sc;
    let (a, b) = ((cc * sf - sc * cf) / det, (ss * cf - sc * sf) / det);
    Some((a * sf + b * cf, [a, b])).filter(|(gain, _)| gain.is_finite())
}
