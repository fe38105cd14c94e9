//! The fit of a chain to the landmarks, and what they leave free.

use std::f64::consts::TAU;

use feeler_analysis::{LinearMachine, View, modes};
use feeler_lti::C64;
use feeler_plant::description::{Engagement, Quantity, SignalName};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::chain::{Chain, PARAMETERS};
use super::{Landmarks, RESONANCES_HZ, landmarks};
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
    /// Root mean square of the residuals: 1 is half the tolerance of the landmarks.
    pub rms: f64,
    /// Singular values of the scaled Jacobian, falling: how much the landmarks tell of each direction of the (logarithmic) parameters.
    pub singular_values: Vec<f64>,
    /// Per parameter, the share of it (0 to 1) that lies in directions which the landmarks do not tell.
    pub undetermined: Vec<(String, f64)>,
}

/// Residuals: logarithms of the resonances over 1 %, phases at the landmarks over 3 degrees, and logarithms of the parameters over a factor of ten
/// from where the fit began, so that what the landmarks do not tell stays where it was.
fn residuals(logs: &DVector<f64>, start: &DVector<f64>) -> Result<DVector<f64>, ValidationError> {
    let chain = Chain::from_logs(logs);
    let free = LinearMachine::new(&chain.machine(Engagement::Free), &View::default())?;
    let clamped = LinearMachine::new(&chain.machine(Engagement::Clamped), &View::default())?;
    let own: Vec<f64> = modes(&free)?.iter().map(|mode| mode.eigenvalue.im / TAU).collect();
    let mut all: Vec<f64> = RESONANCES_HZ.iter().enumerate().map(|(i, f)| (own.get(i).unwrap_or(&1e3) / f).ln() / 0.01).collect();
    let mut phase = |plant: &LinearMachine, signal: SignalName, at_hz: &[(f64, f64)]| -> Result<(), ValidationError> {
        let channel = plant.channel(&SignalName::new("drive", Quantity::Command), &signal)?;
        let frequencies: Vec<f64> = at_hz.iter().map(|(f, _)| *f).collect();
        for (g, (_, wanted_deg)) in channel.frequency_response(&frequencies)?.iter().zip(at_hz) {
            all.push((g * C64::from_polar(1.0, -wanted_deg.to_radians())).arg().to_degrees() / 3.0);
        }
        Ok(())
    };
    phase(&free, SignalName::new("motor", Quantity::Acceleration), &[(50.0, 0.0)])?;
    phase(&free, SignalName::new("link4", Quantity::Acceleration), &[(11.0, 0.0), (13.0, 0.0), (28.0, 0.0)])?;
    phase(&clamped, SignalName::new("tool", Quantity::SpringForce), &[(37.0, 180.0)])?;
    all.extend(logs.iter().zip(start).map(|(l, s)| 0.03 * (l - s)));
    Ok(DVector::from_vec(all))
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
