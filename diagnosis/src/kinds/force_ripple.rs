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

    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        ripples(&glance.missing)
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
    let (low, high) =
        missing.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (x, _)| (l.min(*x), h.max(*x)));
    let stroke = high - low;
    if missing.len() < 50 || stroke <= 0.0 {
        return Vec::new();
    }
    let thin = (missing.len() / (8 * POINTS)).max(1);
    let points: Vec<(f64, f64)> = missing.iter().step_by(thin).copied().collect();
    let mean = points.iter().map(|(_, f)| f).sum::<f64>() / points.len() as f64;
    let points: Vec<(f64, f64)> = points.iter().map(|(x, f)| (*x, f - mean)).collect();
    let mut found: Vec<(f64, ForceRipple)> = (0..PITCHES)
        .filter_map(|k| {
            let pitch = stroke / (WAVES_STEP * (k + 2) as f64);
            let (gain, [a, b]) = wave(&points, pitch)?;
            Some((gain, ForceRipple { amplitude: a.hypot(b), pitch, phase: b.atan2(a), harmonic: 1.0 }))
        })
        .collect();
    found.sort_by(|x, y| y.0.total_cmp(&x.0));
    let mut best: Vec<ForceRipple> = Vec::new();
    for (_, wave) in found {
        if best.len() < BEST_PITCHES
            && best.iter().all(|other| (stroke / other.pitch - stroke / wave.pitch).abs() > 1.0)
        {
            best.push(wave);
        }
    }
    best
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
