//! The fit of a chain to the landmarks, and the parameters that they leave free.

use feeler_lti::C64;
use feeler_plant::description::Engagement;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::chain::{LandmarkChain, PARAMETERS};
use super::response::Seen;
use super::{LANDMARK_HZ, Landmarks, landmarks};
use crate::error::ValidationError;

/// Singular values below this share of the largest belong to directions that the landmarks do not determine.
const UNDETERMINED: f64 = 1e-3;

/// Result of a fit from one start.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// The chain that was found.
    pub chain: LandmarkChain,
    /// Its landmarks, by linear theory.
    pub landmarks: Landmarks,
    /// Whether each of them is within 1 Hz of the paper's.
    pub reached: bool,
    /// Steps that it took.
    pub iterations: usize,
    /// Root mean square of the residuals: 1 is 4 degrees of a phase.
    pub rms: f64,
    /// Singular values of the scaled Jacobian, falling: how well the landmarks determine each direction of
    /// the (logarithmic) parameters.
    pub singular_values: Vec<f64>,
    /// Per parameter, its share (0 to 1) in directions that the landmarks do not determine.
    pub undetermined: Vec<(String, f64)>,
}

/// Target peaks of the end-point's acceleration, Hz. The base's peak lies before its phase dips. The three
/// landmarks there (peak at 12, phase below zero from 11 to 13) are therefore met only within their
/// tolerances.
const PEAKS_HZ: [f64; 5] = [11.35, 38.0, 44.0, 67.0, 77.0];
/// Target zero crossings of its phase, Hz.
const CROSSINGS_HZ: [f64; 3] = [11.75, 13.6, 28.0];
/// Half of the span (Hz) for slope and curvature of a peak: the base's peak, and the others. The second
/// constant is the smallest height of the middle above both sides together, as a logarithm.
const SPANS_HZ: [f64; 2] = [0.3, 0.5];
const LEAST_PROMINENCE: [f64; 2] = [0.02, 0.03];
/// Weights of slopes and of missing curvatures.
const SLOPE: f64 = 8.0;
const CURVATURE: f64 = 60.0;
/// Degrees that give a residual of one.
const DEGREES: f64 = 4.0;
/// Bounds on phases at other frequencies: frequency, bound in degrees. The phase of the motor stays below
/// zero beyond its landmark, where it falls permanently.
const END_BELOW: [(f64, f64); 1] = [(12.6, -2.0)];
const END_ABOVE: [(f64, f64); 2] = [(9.0, 8.0), (20.0, 8.0)];
const MOTOR_ABOVE: [(f64, f64); 5] = [(15.0, 5.0), (20.0, 5.0), (30.0, 5.0), (38.0, 5.0), (44.0, 5.0)];
const MOTOR_BELOW: [(f64, f64); 7] =
    [(55.0, -2.0), (60.0, -5.0), (67.0, -5.0), (72.0, -5.0), (77.0, -5.0), (82.0, -5.0), (90.0, -5.0)];
/// Weight of a factor of e from the start of the fit. It is as much as an eighth of a degree, so that
/// undetermined parameters stay at their start.
const STAY: f64 = 0.03;
/// Largest change of the logarithm of a parameter in one step.
const FARTHEST: f64 = 0.2;
/// A step that lowers the residuals by less than this share is the last.
const LAST_STEP: f64 = 1e-7;

/// Residuals: slope and missing curvature of the end-point's acceleration at its target peaks, and phases at
/// the landmarks over 4 degrees. Also the excesses of other phases over their bounds, and the distances of
/// the parameters' logarithms from the start of the fit.
fn residuals(logs: &DVector<f64>, start: &DVector<f64>) -> DVector<f64> {
    let chain = LandmarkChain::from_logs(logs);
    let mut all = Vec::new();
    for (i, f) in PEAKS_HZ.into_iter().enumerate() {
        let which = i.min(1);
        let [before, at, after] =
            [f - SPANS_HZ[which], f, f + SPANS_HZ[which]].map(|f| chain.response(f, Seen::End).norm().ln());
        all.push(SLOPE * (after - before));
        all.push(CURVATURE * (before + after - 2.0 * at + LEAST_PROMINENCE[which]).max(0.0));
    }
    let degrees = |seen: Seen, f: f64, from_deg: f64| {
        (chain.response(f, seen) * C64::from_polar(1.0, -from_deg.to_radians())).arg().to_degrees()
    };
    all.push(degrees(Seen::Motor, 50.0, 0.0) / DEGREES);
    all.extend(CROSSINGS_HZ.map(|f| degrees(Seen::End, f, 0.0) / DEGREES));
    all.push(degrees(Seen::Force, 37.0, 180.0) / DEGREES);
    for (seen, bounds) in [(Seen::End, END_ABOVE.as_slice()), (Seen::Motor, MOTOR_ABOVE.as_slice())] {
        all.extend(bounds.iter().map(|&(f, bound)| (bound - degrees(seen, f, 0.0)).max(0.0) / DEGREES));
    }
    for (seen, bounds) in [(Seen::End, END_BELOW.as_slice()), (Seen::Motor, MOTOR_BELOW.as_slice())] {
        all.extend(bounds.iter().map(|&(f, bound)| (degrees(seen, f, 0.0) - bound).max(0.0) / DEGREES));
    }
    all.extend(logs.iter().zip(start).map(|(l, s)| STAY * (l - s)));
    DVector::from_vec(all)
}

/// Levenberg and Marquardt's method on the logarithms of the parameters, with difference quotients for the
/// Jacobian.
///
/// # Errors
/// [`ValidationError::Analysis`].
pub fn fit(start: &LandmarkChain, iterations: usize) -> Result<Fit, ValidationError> {
    let origin = start.to_logs();
    let mut logs = origin.clone();
    let mut current = residuals(&logs, &origin);
    let mut damping = 1e-1;
    let mut steps = 0;
    while steps < iterations {
        steps += 1;
        let jacobian = jacobian(&logs, &origin, &current);
        let normal = jacobian.transpose() * &jacobian;
        let gradient = jacobian.transpose() * &current;
        let mut improved = false;
        while damping < 1e8 {
            let mut damped = normal.clone();
            for i in 0..PARAMETERS {
                damped[(i, i)] += damping * (normal[(i, i)] + 1e-6);
            }
            let Some(step) = damped.cholesky().map(|c| c.solve(&gradient)) else { break };
            let step = &step * (FARTHEST / step.amax()).min(1.0);
            let trial = &logs - step;
            let there = residuals(&trial, &origin);
            if there.norm() < current.norm() {
                improved = (current.norm() - there.norm()) > LAST_STEP * current.norm();
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
    let chain = LandmarkChain::from_logs(&logs);
    let told = current.len() - PARAMETERS;
    let whole = jacobian(&logs, &origin, &current);
    let decomposition = whole.rows(0, told).into_owned().svd(false, true);
    let singular_values: Vec<f64> = decomposition.singular_values.iter().copied().collect();
    let largest = singular_values.iter().copied().fold(0.0, f64::max);
    let directions = decomposition.v_t.unwrap_or_else(|| DMatrix::zeros(told, PARAMETERS));
    let seen = |j: usize| -> f64 {
        let kept = (0..singular_values.len()).filter(|&i| singular_values[i] > UNDETERMINED * largest);
        kept.map(|i| directions[(i, j)] * directions[(i, j)]).sum()
    };
    let undetermined = LandmarkChain::parameter_names()
        .into_iter()
        .enumerate()
        .map(|(j, name)| (name, (1.0 - seen(j)).max(0.0)))
        .collect();
    let rms = current.rows(0, told).norm() / (told as f64).sqrt();
    let landmarks = landmarks(&chain.machine(Engagement::Free))?;
    let reached = landmarks.against_paper().iter().all(|(_, got, paper)| (got - paper).abs() <= LANDMARK_HZ);
    Ok(Fit { chain, landmarks, reached, iterations: steps, rms, singular_values, undetermined })
}

fn jacobian(logs: &DVector<f64>, origin: &DVector<f64>, current: &DVector<f64>) -> DMatrix<f64> {
    const STEP: f64 = 1e-5;
    let mut jacobian = DMatrix::zeros(current.len(), PARAMETERS);
    for j in 0..PARAMETERS {
        let mut moved = logs.clone();
        moved[j] += STEP;
        jacobian.set_column(j, &((residuals(&moved, origin) - current) / STEP));
    }
    jacobian
}

/// Fits from several starts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StartSearch {
    /// The fit from each start.
    pub fits: Vec<Fit>,
    /// Index of the chosen fit: the first that reaches every landmark, else the one with the smallest
    /// residuals.
    pub taken: usize,
    /// Per parameter, the smallest and the largest value among the fits that reach every landmark. All chains
    /// are scaled to the base mass of the chosen one.
    pub ranges: Vec<Option<[f64; 2]>>,
}

impl StartSearch {
    /// Fits from the first starts of [`LandmarkChain::start`], or from other ones.
    ///
    /// # Errors
    /// [`ValidationError::Analysis`]; [`ValidationError::Reference`] without a start.
    pub fn from_starts(starts: &[LandmarkChain], iterations: usize) -> Result<Self, ValidationError> {
        let fits = starts.iter().map(|start| fit(start, iterations)).collect::<Result<Vec<_>, _>>()?;
        let best = || (0..fits.len()).min_by(|&i, &j| fits[i].rms.total_cmp(&fits[j].rms));
        let taken = fits.iter().position(|fit| fit.reached).or_else(best);
        let taken = taken.ok_or_else(|| ValidationError::Reference { what: "a fit needs a start".into() })?;
        let size = fits[taken].chain.base_kg;
        let alike: Vec<Vec<f64>> =
            fits.iter().filter(|fit| fit.reached).map(|fit| fit.chain.of_base(size).values()).collect();
        let range = |j: usize| {
            let bounds = alike
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v[j]), high.max(v[j])]);
            (!alike.is_empty()).then_some(bounds)
        };
        let ranges = (0..PARAMETERS).map(range).collect();
        Ok(Self { fits, taken, ranges })
    }

    /// The chosen fit.
    pub fn fit(&self) -> &Fit {
        &self.fits[self.taken]
    }

    /// Number of fits that reach every landmark.
    pub fn reached(&self) -> usize {
        self.fits.iter().filter(|fit| fit.reached).count()
    }
}
