//! Finds how friction reverses, and sets it in all experiments.

use super::reversal::{Limits, Reversal, least, lowest};
use super::rows::{Moving, Reversals, Rows};
use super::smooth::free;
use super::solve::{mean, residual, solve, squared};
use super::{Inverse, ROWS_PER_INDEPENDENT};
use crate::kinds::At;

/// Presliding length where nothing shows it, as a share of the stroke.
const USUAL_LENGTH: f64 = 1e-4;
/// Evidence of friction, in nats, from which its reversals are fitted on a machine without dry friction.
const FRICTION_NATS: f64 = 6.0;

impl Inverse {
    pub(super) fn limits(&self) -> Limits {
        let stroke = self.extent.stroke();
        let command = self.extent.command.max(f64::MIN_POSITIVE);
        let all = self.fitted.iter().chain(&self.checked);
        Limits::new(stroke, self.base.mass() / command, all.map(Rows::sharpest).min().unwrap_or(0))
    }

    /// How friction turns in the fitted experiments only.
    pub(super) fn trial(&self, reversal: Reversal) -> Reversals {
        let fitted = self.fitted.iter().map(|rows| rows.turning(reversal)).collect();
        Reversals { reversal, fitted, checked: Vec::new() }
    }

    /// How friction turns in all experiments.
    pub(super) fn reversals(&self, reversal: Reversal) -> Reversals {
        let checked = self.checked.iter().map(|rows| rows.turning(reversal)).collect();
        Reversals { checked, ..self.trial(reversal) }
    }

    pub(super) fn moving_fitted<'a>(&'a self, reversals: &'a Reversals) -> Vec<Moving<'a>> {
        self.fitted.iter().zip(&reversals.fitted).map(|(rows, turning)| rows.moving(turning)).collect()
    }

    pub(super) fn moving_checked<'a>(&'a self, reversals: &'a Reversals) -> Vec<Moving<'a>> {
        self.checked.iter().zip(&reversals.checked).map(|(rows, turning)| rows.moving(turning)).collect()
    }

    /// How friction reverses on a machine with any friction, load, drag and mass.
    pub(super) fn free_reversal(&self) -> Reversal {
        let limits = self.limits();
        let left = |reversal: Reversal| self.left_free(reversal, true).0;
        let stroke = self.extent.stroke();
        let begun = (0..=limits.sharpest()).map(|sharpness| {
            let trials = limits.all().map(|usual| Reversal { lead_s: 0.0, sharpness, ..usual });
            // The lead is a coefficient here.
            let fixed = |near: Reversal| if near.lead_s > 0.0 { f64::INFINITY } else { left(near) };
            limits.refined(least(trials, left), fixed)
        });
        let (without, _) = self.left_free(Reversal::default(), false);
        let (with, found) = lowest(begun);
        let rows: usize = self.fitted.iter().map(|rows| rows.weights.len()).sum();
        let nats = 0.5 * rows as f64 / ROWS_PER_INDEPENDENT * (without / with).ln();
        if self.base.has_dry_friction(&[]) || nats >= FRICTION_NATS {
            let (_, lead_s) = self.left_free(found, true);
            limits.within(Reversal { lead_s, ..found })
        } else {
            Reversal { length_m: USUAL_LENGTH * stroke, ..Reversal::default() }
        }
    }

    /// Mean square residual of the believed machine with any load, drag and mass, and with any friction if
    /// wanted; and the lead of that friction. A wrong length would otherwise make up for these.
    fn left_free(&self, reversal: Reversal, has_friction: bool) -> (f64, f64) {
        let trial = self.trial(reversal);
        let fitted = self.moving_fitted(&trial);
        let (mut terms, target) = self.balance(&fitted, &self.nothing(), None);
        for dry in self.base.dry_sides().into_iter().rev() {
            terms.remove(dry);
        }
        let mut add = |series: &dyn Fn(&Moving<'_>) -> Vec<f64>| {
            terms.push(free(fitted.iter().flat_map(|rows| rows.weighed(&series(rows))).collect()));
        };
        let smooth: [fn(At) -> f64; 3] = [|_| 1.0, |at| at.speed, |at| at.speed * at.speed.abs()];
        for force in smooth {
            add(&|rows| rows.of_motion(0.0, force));
        }
        add(&|rows| rows.acceleration.clone());
        if has_friction {
            add(&|rows| rows.of_motion(0.0, |at| at.direction));
            add(&|rows| rows.rate(&rows.of_motion(0.0, |at| at.direction)));
        }
        let Some(found) = solve(&terms, &target) else { return (f64::INFINITY, 0.0) };
        let lead_s = match found[..] {
            [.., level, damping] if level > 0.0 => damping / level,
            _ => 0.0,
        };
        (mean(&squared(&residual(&terms, &found, &target))), lead_s)
    }
}
