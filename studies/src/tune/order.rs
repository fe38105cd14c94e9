//! The order in which to try gains on the robot, and the signs that mean stop.

use feeler_control::ControllerSpec;
use rayon::prelude::*;
use serde::Serialize;

use super::knobs::Knobs;
use super::simulated::Runs;
use super::spec::{Spec, TuneMeasure};
use super::theory::LinearPlant;

/// Shares of the tuned gains on errors, in the order of trying: doublings first, then smaller steps. A loop
/// with a gain margin of two stays stable when its gains double. If the force does not come to rest with
/// every share, nothing is proposed.
const SHARES: [f64; 5] = [0.125, 0.25, 0.5, 0.75, 1.0];
/// No run of the model reaches a force this much above the largest of all runs. The margin is a quarter,
/// half of the amplitude that a gain margin of 6 dB leaves.
const BEYOND: f64 = 1.25;
/// An oscillation this many times as wide as the whole settling band is not a rest.
const SWINGS: f64 = 2.0;
/// A wait this many times as long as the slowest run needs means that it does not settle.
const WAITS: f64 = 2.0;

/// One step: the settings, what should be seen, and the signs that mean stop.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Step {
    /// Share of the tuned gains on errors; damping and filters are as tuned from the first step onwards.
    pub share: f64,
    /// Values for `--set`, which are those to set on the robot.
    pub settings: Vec<String>,
    /// Smallest bandwidth over the machines, Hz.
    pub bandwidth_hz: f64,
    /// Factor by which the gain may still rise, by linear theory, on the worst machine; `None` if none
    /// destabilises.
    pub gain_margin: Option<f64>,
    /// Outcomes and measures of the runs of this step.
    pub expected: Runs,
    /// Stop if the reading passes this, N.
    pub stop_force_n: f64,
    /// Stop if the reading oscillates by more than this after `wait_s`, N; `None` if no force rests.
    pub stop_swing_n: Option<f64>,
    /// Frequency at which it would oscillate, Hz: where the loop comes nearest to instability.
    pub swing_hz: f64,
    /// How long to wait for rest after touch or step, s; `None` if nothing is to settle.
    pub wait_s: Option<f64>,
}

/// The tuned gains at each share except the whole, with the name of the share.
pub(super) fn on_the_way(tuned: &ControllerSpec) -> Vec<(String, ControllerSpec)> {
    let below = SHARES.into_iter().filter(|share| *share < 1.0);
    below.map(|share| (format!("{share} of the gains"), Knobs::with_share(tuned, share))).collect()
}

/// The steps to a tuned controller. `expected` holds the results of the runs of each share, the whole
/// last; `settings` gives the values of `--set` for each of some controllers.
pub(super) fn steps(
    plants: &[LinearPlant],
    tuned: &ControllerSpec,
    expected: Vec<Runs>,
    spec: &Spec,
    settings: &dyn Fn(&[ControllerSpec]) -> Vec<Vec<String>>,
) -> Vec<Step> {
    let forces = spec.limits.iter().filter(|limit| limit.of == TuneMeasure::PeakForce);
    let most_n = forces.map(|limit| limit.bound).fold(f64::INFINITY, f64::min);
    let mut specs: Vec<ControllerSpec> = on_the_way(tuned).into_iter().map(|(_, spec)| spec).collect();
    specs.push(tuned.clone());
    let step = |(((share, spec), settings), expected): (((f64, &ControllerSpec), Vec<String>), Runs)| {
        let figures: Option<Vec<_>> =
            plants.par_iter().map(|plant| plant.figures(spec).ok().flatten()).collect();
        let figures = figures?;
        let nearest = figures.iter().max_by(|a, b| a.sensitivity.total_cmp(&b.sensitivity))?;
        Some(Step {
            share,
            settings,
            bandwidth_hz: figures.iter().map(|f| f.bandwidth_hz).fold(f64::INFINITY, f64::min),
            gain_margin: figures.iter().filter_map(|f| f.gain_margin).reduce(f64::min),
            stop_force_n: (BEYOND * expected.peak_force_n).min(most_n),
            stop_swing_n: expected.band_n.map(|band| SWINGS * 2.0 * band),
            swing_hz: nearest.gain_margin_hz.unwrap_or(nearest.sensitivity_hz),
            wait_s: expected.rest_time_s.map(|rests| WAITS * rests),
            expected,
        })
    };
    SHARES.into_iter().zip(&specs).zip(settings(&specs)).zip(expected).filter_map(step).collect()
}
