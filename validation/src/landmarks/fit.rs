//! The fit of a chain to the landmarks, and what they leave free.

use feeler_analysis::{Channel, LinearMachine, View};
use feeler_lti::C64;
use feeler_plant::description::{Engagement, Quantity, SignalName};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::chain::{Chain, PARAMETERS};
use super::{Landmarks, landmarks};
use crate::error::ValidationError;

/// Singular values below this share of the largest belong to directions that the landmarks do not tell.
const UNDETERMINED: f64 = 1e-3;

/// Result of a fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// The chain.
    pub chain: Chain,
    /// Its landmarks.
    pub landmarks: Landmarks,
    /// Root mean square of the residuals: 1 is 4 degrees of a phase.
    pub rms: f64,
    /// Singular values of the scaled Jacobian, falling: how much the landmarks tell of each direction of the (logarithmic) parameters.
    pub singular_values: Vec<f64>,
    /// Per parameter, the share of it (0 to 1) that lies in directions which the landmarks do not tell.
    pub undetermined: Vec<(String, f64)>,
}

/// Where the end-point's acceleration is to peak, Hz. The base's peak lies before its phase dips, so that the three landmarks there (peak at 12, phase
/// below zero from 11 to 13) are met by leaning on what each may be off.
const PEAKS_HZ: [f64; 5] = [11.35, 38.0, 44.0, 67.0, 77.0];
/// Where its phase crosses zero, Hz.
const CROSSINGS_HZ: [f64; 3] = [11.75, 13.6, 28.0];
/// Half of the span (Hz) over which slope and curvature of a peak are taken, for the base's and for the others, and by how much its middle stands above its
/// sides at least, in logarithm, both together.
const SPANS_HZ: [f64; 2] = [0.3, 0.5];
const STANDS: [f64; 2] = [0.02, 0.03];
/// Weights of slopes and of curvatures that are missing.
const SLOPE: f64 = 8.0;
const CURVATURE: f64 = 60.0;
/// Degrees that make a residual of one.
const DEGREES: f64 = 4.0;
/// Phases at other frequencies that must stay on one side, in degrees: frequency, bound.
const END_BELOW: (f64, f64) = (12.6, -2.0);
const END_ABOVE: [(f64, f64); 2] = [(9.0, 8.0), (20.0, 8.0)];
const MOTOR_ABOVE: [(f64, f64); 5] = [(15.0, 5.0), (20.0, 5.0), (30.0, 5.0), (38.0, 5.0), (44.0, 5.0)];

/// Residuals: slope and missing curvature of the end-point's acceleration where it is to peak, phases at the landmarks over 4 degrees, what other phases
/// are beyond their bounds, and logarithms of the parameters over a factor of ten from where the fit began, so that what the landmarks do not tell stays where
/// it was.
fn residuals(logs: &DVector<f64>, start: &DVector<f64>) -> Result<DVector<f64>, ValidationError> {
    let chain = Chain::from_logs(logs);
    let free = LinearMachine::new(&chain.machine(Engagement::Free), &View::default())?;
    let clamped = LinearMachine::new(&chain.machine(Engagement::Clamped), &View::default())?;
    let command = SignalName::new("drive", Quantity::Command);
    let motor = free.channel(&command, &SignalName::new("motor", Quantity::Acceleration))?;
    let end = free.channel(&command, &SignalName::new("link4", Quantity::Acceleration))?;
    let force = clamped.channel(&command, &SignalName::new("tool", Quantity::SpringForce))?;
    let mut all = Vec::new();
    for (i, f) in PEAKS_HZ.into_iter().enumerate() {
        let which = i.min(1);
        let [before, at, after] = logarithms(&end, [f - SPANS_HZ[which], f, f + SPANS_HZ[which]])?;
        all.push(SLOPE * (after - before));
        all.push(CURVATURE * (before + after - 2.0 * at + STANDS[which]).max(0.0));
    }
    let degrees = |channel: &Channel, f: f64, from_deg: f64| -> Result<f64, ValidationError> {
        let value = channel.frequency_response(&[f])?[0];
        Ok((value * C64::from_polar(1.0, -from_deg.to_radians())).arg().to_degrees())
    };
    all.push(degrees(&motor, 50.0, 0.0)? / DEGREES);
    for f in CROSSINGS_HZ {
        all.push(degrees(&end, f, 0.0)? / DEGREES);
    }
    all.push(degrees(&force, 37.0, 180.0)? / DEGREES);
    let (f, bound) = END_BELOW;
    all.push((degrees(&end, f, 0.0)? - bound).max(0.0) / DEGREES);
    for (channel, bounds) in [(&end, END_ABOVE.as_slice()), (&motor, MOTOR_ABOVE.as_slice())] {
        for &(f, bound) in bounds {
            all.push((bound - degrees(channel, f, 0.0)?).max(0.0) / DEGREES);
        }
    }
    all.extend(logs.iter().zip(start).map(|(l, s)| 0.03 * (l - s)));
    Ok(DVector::from_vec(all))
}

/// Logarithms of a response's size.
fn logarithms(channel: &Channel, frequencies_hz: [f64; 3]) -> Result<[f64; 3], ValidationError> {
    let response = channel.frequency_response(&frequencies_hz)?;
    Ok(std::array::from_fn(|i| response[i].norm().ln()))
}

/// Levenberg and Marquardt's method on the logarithms of the parameters, with difference quotients for the Jacobian.
///
/// # Errors
/// [`ValidationError::Analysis`].
pub fn fit(start: &Chain, iterations: usize) -> Result<Fit, ValidationError> {
    let origin = start.to_logs();
    let mut logs = origin.clone();
    let mut current = residuals(&logs, &origin)?;
    let mut damping = 1e-1;
    for _ in 0..iterations {
        let jacobian = jacobian(&logs, &origin, &current)?;
        let normal = jacobian.transpose() * &jacobian;
        let gradient = jacobian.transpose() * &current;
        let mut improved = false;
        while damping < 1e8 {
            let mut damped = normal.clone();
            for i in 0..PARAMETERS {
                damped[(i, i)] += damping * (normal[(i, i)] + 1e-6);
            }
            let Some(step) = damped.cholesky().map(|c| c.solve(&gradient)) else { break };
            // No parameter moves by more than a fifth at once.
            let step = &step * (0.2 / step.amax()).min(1.0);
            let trial = &logs - step;
            let there = residuals(&trial, &origin)?;
            if there.norm() < current.norm() {
                improved = (current.norm() - there.norm()) > 1e-7 * current.norm();
                (logs, current) = (trial, there);
                damping = (damping * 0.3).max(1e-9);
                break;
            }
            damping *= 4.0;
        }
        if !improved {
            break;
        }
    }
    let chain = Chain::from_logs(&logs);
    let told = current.len() - PARAMETERS;
    let whole = jacobian(&logs, &origin, &current)?;
    let decomposition = whole.rows(0, told).into_owned().svd(false, true);
    let singular_values: Vec<f64> = decomposition.singular_values.iter().copied().collect();
    let largest = singular_values.iter().copied().fold(0.0, f64::max);
    let directions = decomposition.v_t.unwrap_or_else(|| DMatrix::zeros(told, PARAMETERS));
    let seen = |j: usize| -> f64 {
        let kept = (0..singular_values.len()).filter(|&i| singular_values[i] > UNDETERMINED * largest);
        kept.map(|i| directions[(i, j)] * directions[(i, j)]).sum()
    };
    let undetermined = Chain::parameter_names().into_iter().enumerate().map(|(j, name)| (name, (1.0 - seen(j)).max(0.0))).collect();
    let rms = current.rows(0, told).norm() / (told as f64).sqrt();
    Ok(Fit { chain, landmarks: landmarks(&chain.machine(Engagement::Free))?, rms, singular_values, undetermined })
}

fn jacobian(logs: &DVector<f64>, origin: &DVector<f64>, current: &DVector<f64>) -> Result<DMatrix<f64>, ValidationError> {
    const STEP: f64 = 1e-5;
    let mut jacobian = DMatrix::zeros(current.len(), PARAMETERS);
    for j in 0..PARAMETERS {
        let mut moved = logs.clone();
        moved[j] += STEP;
        jacobian.set_column(j, &((residuals(&moved, origin)? - current) / STEP));
    }
    Ok(jacobian)
}
