//! Response of a controller's reading to its reference, with the loop closed.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use feeler_control::{ControllerSpec, Law, LinearLaw};
use feeler_lti::{C64, Continuous, Discrete, DiscreteStateSpace, StateSpace, TimeDomain, TransferEvaluator};
use feeler_plant::assembly::Source;
use nalgebra::DMatrix;
use serde::Serialize;

use crate::error::AnalysisError;
use crate::loops::continuous_law::{ContinuousLaw, POSITION, READING, READING_RATE, VELOCITY};
use crate::loops::continuous_loop::ContinuousLoop;
use crate::loops::control_loop::{ControlLoop, LoopController};
use crate::loops::late::Evaluator;

/// Frequency that counts as low, Hz.
const LOWEST_HZ: f64 = 1e-3;
/// Highest frequency of the search in a continuous loop, Hz.
const HIGHEST_HZ: f64 = 1e5;
/// Ratio of neighbouring frequencies of the search; it misses a narrower notch.
const STEP: f64 = 1.02;
/// Multiples of the bandwidth at which a shelf is measured. A first-order fall leaves a fifth and a tenth
/// there; a shelf leaves about the same at both, and at least this share.
const SHELF_AT: [f64; 2] = [5.0, 10.0];
const SHELF_SHARE: f64 = 0.05;
const SHELF_FLAT: f64 = 1.25;
/// Range, relative to a known bandwidth, in which that of a slightly different loop is sought.
const NEAR: [f64; 2] = [0.97, 1.03];
/// Relative accuracy of a bandwidth.
const ACCURACY: f64 = 1e-12;

/// The transfer function from a controller's reference to what it controls ([`LoopController::controlled`]),
/// all loops closed.
#[derive(Debug)]
pub struct ClosedLoop<T: TimeDomain> {
    domain: T,
    /// From the controller's output to the reading, with this loop open.
    plant: Evaluator,
    /// Response of the loop broken at the controller.
    around: Evaluator,
    law: ReferencePath,
    highest_hz: f64,
    /// The reference is a position and the sensor measures velocity: the integral of the reading is compared.
    integrates: bool,
}

/// A shelf: 3 dB down, the reading still follows a share of the reference, because proportional action
/// remains where integral action ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Shelf {
    /// Share of the value at low frequency.
    pub share: f64,
    /// Frequency at which the response falls 3 dB below the shelf, Hz.
    pub to_hz: f64,
}

/// From the reference to a controller's output.
#[derive(Debug)]
enum ReferencePath {
    Sampled(TransferEvaluator),
    Continuous { spec: Box<ControllerSpec>, law: TransferEvaluator },
}

impl ClosedLoop<Discrete> {
    /// The sampled loop of controller `controller`; `None` if it reads nothing.
    ///
    /// # Errors
    /// Those of [`crate::SampledLoop::open_loop`].
    pub fn sampled(whole: &ControlLoop, controller: usize) -> Result<Option<Self>, AnalysisError> {
        let own = &whole.controllers()[controller];
        let Some(sensor) = own.controlled() else { return Ok(None) };
        let around = whole.open_loop(controller)?;
        let reading = whole.plant().output(Source::Sensor(sensor))?;
        let plant = whole.response_to(controller, reading)?;
        Ok(Some(Self {
            domain: around.system.domain(),
            plant: plant.evaluator(),
            around: around.evaluator(),
            law: ReferencePath::Sampled(TransferEvaluator::new(&law_of_reference(own)?)),
            highest_hz: 0.5 / own.spec.period_s,
            integrates: integrates(own),
        }))
    }
}

impl ClosedLoop<Continuous> {
    /// The continuous loop of controller `controller`; `None` if it reads nothing.
    ///
    /// # Errors
    /// Those of [`ContinuousLoop::open_loop`].
    pub fn continuous(whole: &ControlLoop, controller: usize) -> Result<Option<Self>, AnalysisError> {
        let own = &whole.controllers()[controller];
        let Some(sensor) = own.controlled() else { return Ok(None) };
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
            law: ReferencePath::Continuous {
                spec: Box::new(own.spec.clone()),
                law: TransferEvaluator::new(&law),
            },
            highest_hz: HIGHEST_HZ,
            integrates: integrates(own),
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
        let reading = self.plant.at(point)? * law / (self.around.at(point)? + 1.0);
        Ok(if self.integrates { reading / C64::new(0.0, w) } else { reading })
    }

    /// Bandwidth, Hz: where the reading first falls 3 dB below its value at low frequency. `None` if it does
    /// not fall so far up to half of the sampling rate, or does not follow the reference at all.
    ///
    /// # Errors
    /// As [`Self::at`].
    pub fn bandwidth_hz(&self) -> Result<Option<f64>, AnalysisError> {
        let least = FRAC_1_SQRT_2 * self.at(LOWEST_HZ)?.norm();
        if least == 0.0 { Ok(None) } else { self.falls_below(least, LOWEST_HZ) }
    }

    /// Bandwidth of a loop that is known to have it near `near_hz`, Hz.
    ///
    /// # Errors
    /// As [`Self::at`].
    pub(crate) fn bandwidth_near_hz(&self, near_hz: f64) -> Result<Option<f64>, AnalysisError> {
        let least = FRAC_1_SQRT_2 * self.at(LOWEST_HZ)?.norm();
        let [low_hz, high_hz] = NEAR.map(|factor| (factor * near_hz).min(self.highest_hz));
        if least > 0.0 && self.at(low_hz)?.norm() >= least && self.at(high_hz)?.norm() < least {
            return Ok(Some(self.crossed_hz(least, low_hz, high_hz)?));
        }
        self.bandwidth_hz()
    }

    /// The frequency between two others at which the reading falls below `least`, Hz.
    fn crossed_hz(&self, least: f64, mut above: f64, mut below: f64) -> Result<f64, AnalysisError> {
        while below > above * (1.0 + ACCURACY) {
            let middle = (above * below).sqrt();
            if middle <= above || middle >= below {
                break;
            }
            if self.at(middle)?.norm() < least { below = middle } else { above = middle }
        }
        Ok(below)
    }

    /// The shelf beyond the bandwidth of a law with integral action, if the response is about constant over a
    /// large part of a decade.
    ///
    /// # Errors
    /// As [`Self::at`].
    pub fn shelf(&self, bandwidth_hz: f64) -> Result<Option<Shelf>, AnalysisError> {
        let [near_hz, far_hz] = SHELF_AT.map(|factor| factor * bandwidth_hz);
        if far_hz >= self.highest_hz {
            return Ok(None);
        }
        let low = self.at(LOWEST_HZ)?.norm();
        let (near, far) = (self.at(near_hz)?.norm(), self.at(far_hz)?.norm());
        if far < SHELF_SHARE * low || (near / far).max(far / near) > SHELF_FLAT {
            return Ok(None);
        }
        let to_hz = self.falls_below(FRAC_1_SQRT_2 * far, far_hz)?.unwrap_or(self.highest_hz);
        Ok(Some(Shelf { share: far / low, to_hz }))
    }

    /// The first frequency above `from_hz` at which the reading is less than `least`, Hz.
    fn falls_below(&self, least: f64, from_hz: f64) -> Result<Option<f64>, AnalysisError> {
        let mut above = from_hz;
        while above < self.highest_hz {
            let next = (above * STEP).min(self.highest_hz);
            if self.at(next)?.norm() < least {
                return Ok(Some(self.crossed_hz(least, above, next)?));
            }
            above = next;
        }
        Ok(None)
    }
}

/// Whether the reference is a position and the sensor measures its velocity.
pub(crate) fn integrates(controller: &LoopController) -> bool {
    controller.motion_is_velocity
        && controller.motion.is_some()
        && controller.controlled() == controller.motion
}

/// From the reference to the output of a sampled law, in the z plane.
pub(crate) fn law_of_reference(controller: &LoopController) -> Result<DiscreteStateSpace, AnalysisError> {
    let law: LinearLaw = controller.spec.linear(controller.motion_is_velocity)?;
    let n = law.c.len();
    let a = DMatrix::from_fn(n, n, |i, j| law.a[i][j]);
    let b = DMatrix::from_fn(n, 1, |i, _| law.b[i][0]);
    Ok(StateSpace::discrete(
        a,
        b,
        DMatrix::from_row_slice(1, n, &law.c),
        DMatrix::from_element(1, 1, law.d[0]),
        controller.spec.period_s,
    )?)
}

/// From the reference to the output of a continuous law. The reference enters with the reading, with opposite
/// sign, and may be fed forward.
fn continuous_reference(spec: &ControllerSpec, law: &DMatrix<C64>, s: C64) -> C64 {
    let of = |value: usize, rate: usize| -(law[(0, value)] + s * law[(0, rate)]);
    match &spec.law {
        Law::ExplicitForce(gains) => of(READING, READING_RATE) + gains.feed_forward,
        // Damping acts on the motion alone.
        Law::Position(gains) => of(READING, READING_RATE) - s * gains.damping,
        Law::Impedance(_) => of(POSITION, VELOCITY),
        Law::OpenLoop | Law::Admittance(_) => of(READING, READING_RATE),
    }
}
