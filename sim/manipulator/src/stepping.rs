//! Steps that end with their mode.

use feeler_plant::motion::SwitchState;
use nalgebra::DVector;

use crate::evaluation::Plant;
use crate::mode::{CellMode, SwitchChange};

/// Number of changes within one step after which the rest is taken in one piece, with the changes at its end.
const MOST_CHANGES: usize = 32;
/// Largest number of trials for the end of a mode; every third is a bisection.
const TRIALS: usize = 120;
/// Tolerance of the end of a mode, over the step.
const CLOSE: f64 = 1e-11;
/// Offset of a trial from the secant, over the step.
const NUDGE: f64 = 0.4 * CLOSE;

/// Classical Runge-Kutta over `h` within a mode.
fn step(plant: &Plant, x: &DVector<f64>, h: f64, mode: &CellMode, inputs: &[f64]) -> Option<DVector<f64>> {
    let slope = |x: &DVector<f64>| plant.slope(x, mode, inputs);
    let a = slope(x)?;
    let b = slope(&(x + 0.5 * h * &a))?;
    let c = slope(&(x + 0.5 * h * &b))?;
    let d = slope(&(x + h * &c))?;
    Some(x + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)).filter(|x| x.iter().all(|x| x.is_finite()))
}

fn least(plant: &Plant, x: &DVector<f64>, mode: &CellMode, inputs: &[f64]) -> f64 {
    let now = plant.evaluate(x, mode, inputs);
    plant.margins(x, mode, &now).into_iter().map(|(_, margin)| margin).fold(f64::INFINITY, f64::min)
}

/// Changes the mode at one instant until the state is within it; each change occurs once. `changed` receives
/// each change with the old and new state of its switch.
pub(crate) fn settle(
    plant: &Plant,
    x: &mut DVector<f64>,
    mode: &mut CellMode,
    inputs: &[f64],
    mut changed: impl FnMut(SwitchChange, [SwitchState; 2]),
) {
    let mut taken: Vec<SwitchChange> = Vec::new();
    loop {
        let now = plant.evaluate(x, mode, inputs);
        let left = plant
            .margins(x, mode, &now)
            .into_iter()
            .find(|(change, margin)| *margin < 0.0 && !taken.contains(change));
        let Some((change, _)) = left else { return };
        let net = now.net().to_vec();
        drop(now);
        let states = plant.change(change, x, mode, &net);
        taken.push(change);
        changed(change, states);
    }
}

/// Moves a state by `h`; `changed` receives the time of every switch from the start of the step. `None` if
/// the state is not finite.
pub(crate) fn advance(
    plant: &Plant,
    x: &mut DVector<f64>,
    h: f64,
    mode: &mut CellMode,
    inputs: &[f64],
    mut changed: impl FnMut(f64, SwitchChange, [SwitchState; 2]),
) -> Option<()> {
    let mut left = h;
    for _ in 0..MOST_CHANGES {
        let next = step(plant, x, left, mode, inputs)?;
        let ends = least(plant, &next, mode, inputs);
        if ends >= 0.0 {
            *x = next;
            return Some(());
        }
        let begins = least(plant, x, mode, inputs).max(0.0);
        let (at, found) = locate(plant, x, (left, begins, ends), next, mode, inputs)?;
        *x = found;
        left -= at;
        settle(plant, x, mode, inputs, |change, states| changed(h - left, change, states));
        if left <= CLOSE * h {
            return Some(());
        }
    }
    *x = step(plant, x, left, mode, inputs)?;
    settle(plant, x, mode, inputs, |change, states| changed(h, change, states));
    Some(())
}

/// The first instant outside the mode, and the state there, by secants and bisection. `next` is the state
/// after `h`, where the smallest margin is `ends`.
fn locate(
    plant: &Plant,
    x: &DVector<f64>,
    (h, begins, ends): (f64, f64, f64),
    next: DVector<f64>,
    mode: &CellMode,
    inputs: &[f64],
) -> Option<(f64, DVector<f64>)> {
    let (mut low, mut low_margin) = (0.0, begins);
    let (mut high, mut high_margin, mut found) = (h, ends, next);
    for trial in 0..TRIALS {
        if high - low <= CLOSE * h {
            break;
        }
        let middle = 0.5 * (low + high);
        let secant = low + (high - low) * low_margin / (low_margin - high_margin);
        // If the secant is right, trials slightly after and before it bracket the border; every third trial
        // is a bisection.
        let nudged = match trial % 3 {
            0 => secant + NUDGE * h,
            1 => secant - NUDGE * h,
            _ => middle,
        };
        let t = if nudged > low && nudged < high { nudged } else { middle };
        let state = step(plant, x, t, mode, inputs)?;
        let margin = least(plant, &state, mode, inputs);
        if margin >= 0.0 {
            (low, low_margin) = (t, margin);
        } else {
            (high, high_margin, found) = (t, margin, state);
        }
    }
    Some((high, found))
}
