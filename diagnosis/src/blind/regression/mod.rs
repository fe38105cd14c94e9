//! A plain regression on the balance of forces, with which the diagnosis is compared. The balance is
//! low-passed without phase shift, a few times above the motion. Bounded least squares on the fit experiments
//! give mass, damping and the terms of one cause. Causes are ranked by their likelihood on the check
//! experiments.
//!
//! It shares only the low-pass with the diagnosis, and simulates nothing.

mod believed;
mod causes;
mod rows;
mod solve;

use std::collections::BTreeMap;
use std::path::Path;

use believed::Believed;
use causes::{Balance, CAUSES, Cause, Form, Seen, balance};
use feeler_plant::effects::find;
use rayon::prelude::*;
use rows::{Measured, Rows, corner_hz, rms};
use serde::{Deserialize, Serialize};
use solve::{Term, solve, sum};

use super::cases::Case;
use super::make::CASES;
use crate::dataset::Dataset;

/// Evidence that a cause must bring before it is named, nats.
const ENOUGH: f64 = 6.0;
/// Rows kept for each independent one: rows at twice the corner frequency are independent.
const ROWS_PER_INDEPENDENT: f64 = 2.0;

/// A cause with its gain on the check experiments.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Regressed {
    /// Kind of the cause in the library.
    pub kind: String,
    pub place: String,
    /// Increase of the likelihood over calibration alone on the check experiments, less the penalty, nats.
    pub gain: f64,
}

/// The causes that a regression ranks, for each case whose dataset is in a folder of cases.
pub fn regressions(folder: &Path, cases: &[Case]) -> BTreeMap<String, Vec<Regressed>> {
    let made = folder.join(CASES);
    let inside = if made.is_dir() { made.as_path() } else { folder };
    let of = |case: &Case| {
        let dataset = Dataset::load(&inside.join(&case.case)).ok()?.in_pieces();
        Some((case.case.clone(), regress(&dataset)))
    };
    let found: Vec<_> = cases.par_iter().filter_map(of).collect();
    found.into_iter().collect()
}

/// Causes of the library by their gain on the check experiments, the best first. The list is empty if the
/// dataset lacks free experiments, with a command and a position, to fit and to check. A cause is named if
/// [`named`] says so.
fn regress(dataset: &Dataset) -> Vec<Regressed> {
    let prepared = Believed::of(dataset).zip(believed::measured(dataset));
    prepared.map_or_else(Vec::new, |(believed, measured)| rank(&believed, &measured))
}

/// The cause that the regression names: the best one, if its gain is large enough.
pub(super) fn named(ranking: &[Regressed]) -> Option<&Regressed> {
    ranking.first().filter(|best| best.gain >= ENOUGH)
}

fn rank(believed: &Believed, measured: &[Measured]) -> Vec<Regressed> {
    let corner_hz = corner_hz(measured);
    let rows: Vec<Rows> = measured.iter().map(|record| Rows::new(record, corner_hz)).collect();
    let seen = seen(&rows, measured, corner_hz);
    let regression = Regression { believed, rows: &rows, seen };
    let Some(alone) = regression.evaluate(&CAUSES[0], None) else { return Vec::new() };
    let mut found: Vec<Regressed> = CAUSES[1..]
        .iter()
        .filter(|cause| find(cause.kind).is_some() && (cause.kind != "gravity" || believed.is_rotational))
        .filter_map(|cause| {
            let evaluated = regression.evaluate(cause, Some(&alone))?;
            let gain = evaluated.likelihood - alone.likelihood;
            Some(Regressed { kind: cause.kind.into(), place: cause.place.into(), gain })
        })
        .filter(|regressed| regressed.gain.is_finite())
        .collect();
    found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    found
}

fn seen(rows: &[Rows], measured: &[Measured], corner_hz: f64) -> Seen {
    let speeds: Vec<f64> = rows.iter().flat_map(|rows| rows.thin(&rows.speed)).collect();
    let positions: Vec<f64> = rows.iter().flat_map(|rows| rows.thin(&rows.position)).collect();
    let commands = measured.iter().flat_map(|record| &record.command);
    Seen {
        speed: rms(&speeds),
        command: commands.fold(0.0, |most: f64, u| most.max(u.abs())),
        reach: positions
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)]),
        resolved_s: 1.0 / (std::f64::consts::TAU * corner_hz),
    }
}

struct Regression<'a> {
    believed: &'a Believed,
    rows: &'a [Rows],
    seen: Seen,
}

/// A fitted cause.
struct Evaluated {
    /// Log likelihood on the check experiments, less the penalty, nats.
    likelihood: f64,
    coefficients: Vec<f64>,
    /// Value of the nonlinear parameter.
    at: f64,
}

impl Regression<'_> {
    /// Fits a cause with every value of its grid, keeps the best, and weighs it on the check experiments.
    fn evaluate(&self, cause: &Cause, alone: Option<&Evaluated>) -> Option<Evaluated> {
        let mut best: Option<(f64, f64, Vec<f64>)> = None;
        for at in (cause.grid)(&self.seen) {
            let balances = self.balances(cause, at, alone, false);
            let (terms, target) = joined(&balances);
            let coefficients = solve(&terms, &target);
            let left = mean_square(&terms, &coefficients, &target);
            if left.is_finite() && best.as_ref().is_none_or(|(least, ..)| left < *least) {
                best = Some((left, at, coefficients));
            }
        }
        let (_, at, coefficients) = best?;
        let (terms, target) = joined(&self.balances(cause, at, alone, true));
        let left = mean_square(&terms, &coefficients, &target);
        let independent = target.len() as f64 / ROWS_PER_INDEPENDENT;
        let penalty = 0.5 * cause.parameters as f64 * independent.max(1.0).ln();
        let likelihood = -0.5 * independent * left.max(f64::MIN_POSITIVE).ln() - penalty;
        Some(Evaluated { likelihood, coefficients, at })
    }

    fn balances(&self, cause: &Cause, at: f64, alone: Option<&Evaluated>, is_check: bool) -> Vec<Balance> {
        let records = self.rows.iter().filter(|rows| rows.is_check == is_check);
        records
            .map(|rows| {
                let before = alone.filter(|_| matches!(cause.form, Form::Deadband)).map(|alone| {
                    let plain = balance(rows, self.believed, &self.seen, &CAUSES[0], alone.at, None);
                    sum(&plain.terms, &alone.coefficients, plain.target.len())
                });
                balance(rows, self.believed, &self.seen, cause, at, before.as_deref())
            })
            .collect()
    }
}

/// Balances of several records as one.
fn joined(balances: &[Balance]) -> (Vec<Term>, Vec<f64>) {
    let target = balances.iter().flat_map(|balance| balance.target.clone()).collect();
    let Some(first) = balances.first() else { return (Vec::new(), target) };
    let terms = (0..first.terms.len())
        .map(|i| Term {
            series: balances.iter().flat_map(|balance| balance.terms[i].series.clone()).collect(),
            ..first.terms[i]
        })
        .collect();
    (terms, target)
}

fn mean_square(terms: &[Term], coefficients: &[f64], target: &[f64]) -> f64 {
    let made = sum(terms, coefficients, target.len());
    made.iter().zip(target).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / target.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    const OMEGA: f64 = 5.0;

    /// Records of 1.2 kg moving by 0.3 m under the forces of `law`, which is given position, speed and time.
    /// The command has noise of 2 %.
    fn records(law: impl Fn(f64, f64, f64) -> f64) -> Vec<Measured> {
        let mut random = super::super::noise::Random::new(11);
        let waves = |t: f64, order: i32, shift: f64| {
            let wave = |amplitude: f64, omega: f64, phase: f64| {
                amplitude
                    * omega.powi(order)
                    * (omega * t + phase + f64::from(order) * 0.5 * std::f64::consts::PI).sin()
            };
            wave(0.2, OMEGA, shift) + wave(0.1, 1.7 * OMEGA, 2.0 * shift)
        };
        [0.3, 1.1, 2.0]
            .into_iter()
            .enumerate()
            .map(|(i, shift)| {
                let spacing_s = 2e-3;
                let times = (0..8000).map(|k| f64::from(k) * spacing_s);
                let position: Vec<f64> = times.clone().map(|t| waves(t, 0, shift)).collect();
                let force = |t: f64| {
                    1.2 * waves(t, 2, shift)
                        + 4.0 * waves(t, 1, shift)
                        + law(waves(t, 0, shift), waves(t, 1, shift), t)
                };
                let clean: Vec<f64> = times.map(force).collect();
                let noise = 0.02 * rms(&clean);
                let command = clean.iter().map(|u| u + noise * random.normal()).collect();
                Measured { spacing_s, command, position, is_check: i == 2 }
            })
            .collect()
    }

    fn believed() -> Believed {
        Believed { mass: 1.2, damping: 4.0, friction: 0.0, gravity: None, is_rotational: false }
    }

    fn best(law: impl Fn(f64, f64, f64) -> f64) -> Option<String> {
        let ranking = rank(&believed(), &records(law));
        named(&ranking).map(|regressed| regressed.kind.clone())
    }

    #[test]
    fn truth_forces_of_the_motion_are_named() {
        assert_eq!(best(|_, _, _| 0.0), None);
        assert_eq!(best(|_, v, _| 6.0 * v.signum()).as_deref(), Some("coulomb-friction"));
        assert_eq!(best(|_, v, _| if v > 0.0 { 8.0 } else { -4.0 }).as_deref(), Some("asymmetric-friction"));
        assert_eq!(best(|_, v, _| 5.0 * v * v.abs()).as_deref(), Some("quadratic-drag"));
        assert_eq!(best(|_, _, _| 3.0).as_deref(), Some("constant-load"));
        assert_eq!(
            best(|x, _, _| 2.0 * (std::f64::consts::TAU * x / 0.08 + 0.4).sin()).as_deref(),
            Some("force-ripple")
        );
    }

    #[test]
    fn truth_known_parameters_come_back() {
        let measured = records(|_, v, _| 6.0 * v.signum());
        let corner_hz = corner_hz(&measured);
        let rows: Vec<Rows> = measured.iter().map(|record| Rows::new(record, corner_hz)).collect();
        let seen = seen(&rows, &measured, corner_hz);
        let believed = Believed { mass: 1.3, damping: 7.0, ..believed() };
        let regression = Regression { believed: &believed, rows: &rows, seen };
        let found = regression.evaluate(&CAUSES[1], None).unwrap().coefficients;
        // Noise of 2 % over thousands of rows shifts none of them by a percent. The smooth sign of a speed
        // loses a few percent of the level about its reversals.
        for (value, truth) in found.iter().zip([1.2, 4.0, 6.0]) {
            assert!((value / truth - 1.0).abs() < 0.05, "{found:?}");
        }
    }
}
