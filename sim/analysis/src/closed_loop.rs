//! A controller's reading against its reference, the loop closed.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use feeler_control::{ControllerSpec, Law, LinearLaw};
use feeler_lti::{C64, Continuous, Discrete, StateSpace, TimeDomain, TransferEvaluator};
use feeler_plant::assembly::Source;
use nalgebra::DMatrix;

use crate::continuous_law::{ContinuousLaw, POSITION, READING, READING_RATE, VELOCITY};
use crate::continuous_loop::ContinuousLoop;
use crate::control_loop::{ControlLoop, LoopController};
use crate::error::AnalysisError;
use crate::late::Evaluator;

/// Frequency that counts as low, Hz.
const LOWEST_HZ: f64 = 1e-3;
/// Highest frequency of the search in a continuous loop, Hz.
const HIGHEST_HZ: f64 = 1e5;
/// Ratio of neighbouring frequencies of the search: a notch narrower than that is passed over.
const STEP: f64 = 1.02;
/// Relative accuracy of a bandwidth.
const ACCURACY: f64 = 1e-12;

/// The transfer function from a controller's reference to what it reads (its motion sensor where it reads nothing else), all loops closed.
#[derive(Debug)]
pub struct ClosedLoop<T: TimeDomain> {
    domain: T,
    /// From the controller's output to the reading, this loop open.
    plant: Evaluator,
    /// Around the loop.
    around: Evaluator,
    law: ReferencePath,
    highest_hz: f64,
}

/// From the reference to a controller's output.
#[derive(Debug)]
enum ReferencePath {
    Sampled(TransferEvaluator),
    Continuous { spec: Box<ControllerSpec>, law: TransferEvaluator },
}

impl ClosedLoop<Discrete> {
    /// The sampled loop of controller `controller`; none where it reads nothing.
    ///
    /// # Errors
    /// Those of [`crate::SampledLoop::open_loop`].
    pub fn sampled(whole: &ControlLoop, controller: usize) -> Result<Option<Self>, AnalysisError> {
        let own = &whole.controllers()[controller];
        let Some(sensor) = read(own) else { return Ok(None) };
        let around = whole.open_loop(controller)?;
        let reading = whole.plant().output(Source::Sensor(sensor))?;
        let plant = whole.response_to(controller, reading)?;
        Ok(Some(Self {
            domain: around.system.domain(),
            plant: plant.evaluator(),
            around: around.evaluator(),
            law: ReferencePath::Sampled(law_of_reference(own)?),
            highest_hz: 0.5 / own.spec.period_s,
        }))
    }
}

impl ClosedLoop<Continuous> {
    /// The continuous loop of controller `controller`; none where it reads nothing.
    ///
    /// # Errors
    /// Those of [`ContinuousLoop::open_loop`].
    pub fn continuous(whole: &ControlLoop, controller: usize) -> Result<Option<Self>, AnalysisError> {
        let own = &whole.controllers()[controller];
        let Some(sensor) = read(own) else { return Ok(None) };
        let around = ContinuousLoop::new(whole)?.open_loop(controller)?;
        let plant = ContinuousLoop::response_to(whole, controller, sensor)?;
        let law = ContinuousLaw::new(&own.spec);
        let law = StateSpace::new(
            law.a,
            law.b,
            DMatrix::from_row_slice(1, law.c.len(), law.c.as_slice()),
            DMatrix::from_row_slice(1, law.d.len(), law.d.as_slice()),
        )?;
        Ok(Some(Self {
            domain: Continuous,
            plant: Evaluator::prompt(&plant),
            around: Evaluator::prompt(&around),
            law: ReferencePath::Continuous { spec: Box::new(own.spec.clone()), law: TransferEvaluator::new(&law) },
            highest_hz: HIGHEST_HZ,
        }))
    }
}

impl<T: TimeDomain> ClosedLoop<T> {
    /// Reading over reference at a frequency.
    ///
    /// # Errors
    /// [`AnalysisError::Lti`] at a pole of the open loop.
    pub fn at(&self, frequency_hz: f64) -> Result<C64, AnalysisError> {
        let w = TAU * frequency_hz;
        let point = self.domain.boundary_point(w);
        let law = match &self.law {
            ReferencePath::Sampled(law) => law.at(point)?[(0, 0)],
            ReferencePath::Continuous { spec, law } => continuous_reference(spec, &law.at(point)?, point),
        };
        Ok(self.plant.at(point)? * law / (self.around.at(point)? + 1.0))
    }

    /// The frequency at which the reading first falls 3 dB below what it is at low frequency, Hz; none where it never does up to half of the sampling
    /// rate, or does not follow the reference at all.
    ///
    /// # Errors
    /// As [`Self::at`].
    pub fn bandwidth_hz(&self) -> Result<Option<f64>, AnalysisError> {
        let least = FRAC_1_SQRT_2 * self.at(LOWEST_HZ)?.norm();
        if least == 0.0 {
            return Ok(None);
        }
        let mut above = LOWEST_HZ;
        while above < self.highest_hz {
            let next = (above * STEP).min(self.highest_hz);
            if self.at(next)?.norm() < least {
                let mut below = next;
                while below > above * (1.0 + ACCURACY) {
                    let middle = (above * below).sqrt();
                    if middle <= above || middle >= below {
                        break;
                    }
                    if self.at(middle)?.norm() < least { below = middle } else { above = middle }
                }
                return Ok(Some(below));
            }
            above = next;
        }
        Ok(None)
    }
}

/// What a controller is there to control.
fn read(controller: &LoopController) -> Option<usize> {
    controller.reading.or(controller.motion)
}

/// From the reference to the output of a sampled law, in the z plane.
pub(crate) fn law_of_reference(controller: &LoopController) -> Result<TransferEvaluator, AnalysisError> {
    let law: LinearLaw = controller.spec.linear(controller.motion_is_velocity)?;
    let n = law.c.len();
    let a = DMatrix::from_fn(n, n, |i, j| law.a[i][j]);
    let b = DMatrix::from_fn(n, 1, |i, _| law.b[i][0]);
    let system =
        StateSpace::discrete(a, b, DMatrix::from_row_slice(1, n, &law.c), DMatrix::from_element(1, 1, law.d[0]), controller.spec.period_s)?;
    Ok(TransferEvaluator::new(&system))
}

/// From the reference to the output of a law on paper: it enters wherever the reading does, with the other sign, and may be fed forward.
fn continuous_reference(spec: &ControllerSpec, law: &DMatrix<C64>, s: C64) -> C64 {
    let of = |value: usize, rate: usize| -(law[(0, value)] + s * law[(0, rate)]);
    match &spec.law {
        Law::ExplicitForce(gains) => of(READING, READING_RATE) + gains.feed_forward,
        // Damping acts on the motion alone.
        Law::Position(gains) => of(READING, READING_RATE) - s * gains.damping,
        Law::Impedance(_) => of(POSITION, VELOCITY),
        _ => of(READING, READING_RATE),
    }
}
