//! Terms of each cause in the balance between the command and the forces of the motion.

use std::f64::consts::TAU;

use super::believed::Believed;
use super::rows::{Rows, sign};
use super::solve::Term;

/// Largest relative error of a believed mass.
const MASS_OFF: f64 = 0.15;
/// Largest factor between the true and the believed damping or friction level.
const FACTOR_OFF: f64 = 4.0;
/// Largest relative error of believed gravity.
const GRAVITY_OFF: f64 = 0.15;

/// Magnitudes over all records.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Root mean square of speed, m/s.
    pub(super) speed: f64,
    /// Largest command, N.
    pub(super) command: f64,
    /// Least and largest position, m.
    pub(super) reach: [f64; 2],
    /// Shortest time that the records resolve, s.
    pub(super) resolved_s: f64,
}

/// Regressor of one row from position, speed and the grid's value.
type OfMotion = fn(f64, f64, f64, &Seen) -> f64;

/// The terms that a cause changes.
#[derive(Clone, Copy)]
pub(super) enum Form {
    /// Nothing: calibration alone.
    Nothing,
    /// It adds forces of the motion; each is a function of position, speed and the grid's value.
    Forces(&'static [(OfMotion, bool)]),
    /// It adds a force in proportion to acceleration.
    Mass,
    /// The force is a constant multiple of the command.
    Gain,
    /// The force comes later than the command by a lag.
    Lag,
    /// The force comes later than the command by a delay.
    Delay,
    /// The force lacks a constant part in the direction of the command.
    Deadband,
    /// The force stays below a limit.
    Limit,
}

/// A cause with the tried values of its one nonlinear parameter.
pub(super) struct Cause {
    pub(super) kind: &'static str,
    pub(super) place: &'static str,
    pub(super) form: Form,
    pub(super) grid: fn(&Seen) -> Vec<f64>,
    pub(super) parameters: usize,
}

const fn cause(kind: &'static str, place: &'static str, form: Form, parameters: usize) -> Cause {
    Cause { kind, place, form, grid: |_| vec![0.0], parameters }
}

/// `n` values from `low` to `high`, evenly spaced in the logarithm.
fn spread(low: f64, high: f64, n: usize) -> Vec<f64> {
    (0..n).map(|i| low * (high / low).powf(i as f64 / (n - 1) as f64)).collect()
}

fn stroke(seen: &Seen) -> f64 {
    seen.reach[1] - seen.reach[0]
}

const SIGN: OfMotion = |_, v, _, seen| sign(v, seen.speed);
const SIGNED: bool = true;
const POSITIVE: bool = false;

/// Every cause that a balance of forces shows.
pub(super) static CAUSES: &[Cause] = &[
    cause("", "", Form::Nothing, 0),
    cause("coulomb-friction", "guide", Form::Forces(&[(SIGN, POSITIVE)]), 1),
    Cause {
        grid: |seen| spread(0.02 * seen.speed, 0.6 * seen.speed, 12),
        ..cause(
            "stribeck-friction",
            "guide",
            Form::Forces(&[
                (SIGN, POSITIVE),
                (|_, v, at, seen| sign(v, seen.speed) * (-(v / at).powi(2)).exp(), POSITIVE),
            ]),
            3,
        )
    },
    cause(
        "asymmetric-friction",
        "guide",
        Form::Forces(&[
            (|_, v, _, seen| sign(v, seen.speed).max(0.0), POSITIVE),
            (|_, v, _, seen| sign(v, seen.speed).min(0.0), POSITIVE),
        ]),
        2,
    ),
    cause("viscous-friction", "guide", Form::Forces(&[(|_, v, _, _| v, POSITIVE)]), 1),
    cause("quadratic-drag", "guide", Form::Forces(&[(|_, v, _, _| v * v.abs(), POSITIVE)]), 1),
    cause("directional-damping", "guide", Form::Forces(&[(|_, v, _, _| v.abs(), SIGNED)]), 1),
    cause("constant-load", "guide", Form::Forces(&[(|_, _, _, _| 1.0, SIGNED)]), 1),
    cause(
        "gravity",
        "guide",
        Form::Forces(&[(|x, _, _, _| x.sin(), SIGNED), (|x, _, _, _| x.cos(), SIGNED)]),
        2,
    ),
    Cause {
        grid: |seen| spread(0.02 * stroke(seen), 0.6 * stroke(seen), 120),
        ..cause(
            "force-ripple",
            "drive",
            Form::Forces(&[
                (|x, _, pitch, _| (TAU * x / pitch).sin(), SIGNED),
                (|x, _, pitch, _| (TAU * x / pitch).cos(), SIGNED),
            ]),
            3,
        )
    },
    cause("added-mass", "transmission", Form::Mass, 1),
    Cause { grid: |_| spread(0.4, 2.5, 41), ..cause("drive-gain", "drive", Form::Gain, 1) },
    Cause {
        grid: |seen| spread(0.03 * seen.resolved_s, 3.0 * seen.resolved_s, 30),
        ..cause("actuator-lag", "drive", Form::Lag, 1)
    },
    Cause {
        grid: |seen| spread(0.03 * seen.resolved_s, 3.0 * seen.resolved_s, 30),
        ..cause("command-delay", "drive", Form::Delay, 1)
    },
    cause("drive-deadband", "drive", Form::Deadband, 1),
    Cause {
        grid: |seen| spread(0.3 * seen.command, 0.98 * seen.command, 25),
        ..cause("force-limit", "drive", Form::Limit, 1)
    },
];

/// The balance of one record: the force of the command, and the terms whose sum must equal it.
pub(super) struct Balance {
    pub(super) target: Vec<f64>,
    pub(super) terms: Vec<Term>,
}

/// The balance of a record under a cause with the nonlinear parameter `at`. `before` is the drive force after
/// calibration alone; its sign is the direction of the force that a dead band removes.
pub(super) fn balance(
    rows: &Rows,
    believed: &Believed,
    seen: &Seen,
    cause: &Cause,
    at: f64,
    before: Option<&[f64]>,
) -> Balance {
    let believed_terms = believed_terms(rows, believed, seen);
    let scale = if matches!(cause.form, Form::Gain) { 1.0 / at } else { 1.0 };
    let change = |series: &[f64]| match cause.form {
        Form::Lag => series.iter().zip(rows.rate(series)).map(|(x, rate)| x + at * rate).collect(),
        Form::Delay => rows.shifted(series, -at),
        _ => series.to_vec(),
    };
    let mut terms: Vec<Term> = believed_terms
        .iter()
        .map(|term| Term {
            series: rows.thin(&change(&term.series)),
            low: term.low * scale,
            high: term.high * scale,
        })
        .collect();
    let mut add = |series: Vec<f64>, is_signed: bool| {
        let low = if is_signed { f64::NEG_INFINITY } else { 0.0 };
        terms.push(Term { series, low, high: f64::INFINITY });
    };
    match cause.form {
        Form::Forces(forces) => {
            for (force, is_signed) in forces {
                add(rows.thin(&rows.of_motion(|x, v| force(x, v, at, seen))), *is_signed);
            }
        }
        Form::Mass => add(rows.thin(&rows.acceleration), false),
        Form::Deadband => {
            if let Some(before) = before {
                let usual = super::rows::rms(before);
                add(before.iter().map(|force| sign(*force, usual)).collect(), false);
            }
        }
        _ => {}
    }
    let limit = if matches!(cause.form, Form::Limit) { at } else { f64::INFINITY };
    Balance { target: rows.command(|u| u.clamp(-limit, limit)), terms }
}

/// Terms of the believed machine at every row, each bounded by its tolerance.
pub(super) fn believed_terms(rows: &Rows, believed: &Believed, seen: &Seen) -> Vec<Term> {
    let by_factor = |series: Vec<f64>, value: f64, factor: f64| Term {
        series,
        low: (value / factor).min(value * factor),
        high: (value / factor).max(value * factor),
    };
    let mut terms = vec![by_factor(rows.acceleration.clone(), believed.mass, 1.0 + MASS_OFF)];
    if believed.damping > 0.0 {
        terms.push(by_factor(rows.speed.clone(), believed.damping, FACTOR_OFF));
    }
    if believed.friction > 0.0 {
        terms.push(by_factor(rows.of_motion(|x, v| SIGN(x, v, 0.0, seen)), believed.friction, FACTOR_OFF));
    }
    if let Some([amplitude, phase]) = believed.gravity {
        let series = rows.of_motion(|x, _| (x + phase).sin());
        terms.push(by_factor(series, amplitude, 1.0 + GRAVITY_OFF));
    }
    terms
}
