//! Figures of a controller on a machine by linear theory.

use feeler_analysis::{AnalysisError, ClosedLoop, ControlLoop, MarginReport, SampledLoop, StepResponse};
use feeler_control::ControllerSpec;
use feeler_engine::Scenario;
use serde::Serialize;

use super::knobs::installed;
use super::spec::{TuneLimit, TuneMeasure};
use crate::operating_point::contact_view;

/// The step response is evaluated over this number of periods of the bandwidth. By then the slowest pole that
/// matters at the margins in use has died out.
const STEP_PERIODS: f64 = 10.0;

/// Growth within a sample that may be rounding. It belongs to a mode that this loop does not reach, such as
/// the position of a surface that a source moves.
const ROUNDING: f64 = 1e-9;

/// Frequency that counts as none, Hz.
const AT_REST_HZ: f64 = 1e-3;

/// Figures of a stable loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// Frequency up to which the reading follows its reference, to 3 dB, Hz. Half of the sampling rate if it
    /// never falls so far.
    pub bandwidth_hz: f64,
    /// Reading at rest for a reference of one; below zero if a sign is wrong.
    pub follows: f64,
    /// Smallest phase margin, degrees; `None` if the loop's modulus never passes one.
    pub phase_margin_deg: Option<f64>,
    /// Factor by which the gain may rise, or its inverse fall, whichever is less; `None` if none
    /// destabilises.
    pub gain_margin: Option<f64>,
    /// Frequency at which the loop oscillates with that gain, Hz; `None` without one.
    pub gain_margin_hz: Option<f64>,
    /// Balanced disk margin, 0 to 2.
    pub disk_margin: f64,
    /// Largest modulus of the sensitivity.
    pub sensitivity: f64,
    /// Frequency of that modulus, Hz.
    pub sensitivity_hz: f64,
    /// How far the step response passes its final value, as a share of it; `None` unless it is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step_overshoot: Option<f64>,
}

impl Figures {
    fn value(&self, measure: TuneMeasure) -> Option<f64> {
        Some(match measure {
            TuneMeasure::PhaseMargin => self.phase_margin_deg.unwrap_or(f64::INFINITY),
            TuneMeasure::GainMargin => self.gain_margin.unwrap_or(f64::INFINITY),
            TuneMeasure::DiskMargin => self.disk_margin,
            TuneMeasure::Sensitivity => self.sensitivity,
            TuneMeasure::StepOvershoot => self.step_overshoot?,
            TuneMeasure::Overshoot | TuneMeasure::PeakForce | TuneMeasure::SettlingTime => return None,
        })
    }

    /// Sum of the shares of their bounds by which limits are missed.
    pub(super) fn missed_by<'a>(&self, limits: impl Iterator<Item = &'a TuneLimit<TuneMeasure>>) -> f64 {
        limits.map(|limit| self.value(limit.of).map_or(0.0, |value| limit.missed_by(value))).sum()
    }
}

/// A machine in contact, ready for any controller in the place of one.
#[derive(Clone, Debug)]
pub(super) struct LinearPlant {
    whole: ControlLoop,
    controller: usize,
    with_step: bool,
}

impl LinearPlant {
    /// `at_work` is a controller that reads all sensors that any will; `with_step` asks for step responses.
    pub(super) fn new(
        scenario: &Scenario,
        name: &str,
        at_work: &ControllerSpec,
        with_step: bool,
    ) -> Result<Self, AnalysisError> {
        let mut scenario = scenario.clone();
        if let Some(used) = scenario.controllers.get_mut(name) {
            used.spec = installed(&used.spec, at_work);
        }
        let whole = ControlLoop::new(&scenario, &contact_view(&scenario))?;
        let controller = whole.controller(name)?;
        Ok(Self { whole, controller, with_step })
    }

    /// The figures with a controller; `None` if the loop is unstable.
    pub(super) fn figures(&self, spec: &ControllerSpec) -> Result<Option<Figures>, AnalysisError> {
        let own = &self.whole.controllers()[self.controller].spec;
        let whole = self.whole.with_spec(self.controller, installed(own, spec));
        let open = whole.open_loop(self.controller)?;
        // Eigenvalues cost less than margins, and most points that are tried are unstable.
        if open.samples == 0
            && SampledLoop::new(&whole)?.eigenvalues()?.iter().any(|pole| pole.norm() >= 1.0 + ROUNDING)
        {
            return Ok(None);
        }
        let margins = MarginReport::new(&open.transfer()?)?;
        if margins.unstable_poles > 0 {
            return Ok(None);
        }
        let highest_hz = 0.5 / spec.period_s;
        let closed = ClosedLoop::sampled(&whole, self.controller)?;
        let follows = closed.as_ref().map(|closed| closed.at(AT_REST_HZ)).transpose()?;
        let bandwidth_hz = closed.map(|closed| closed.bandwidth_hz()).transpose()?.flatten();
        let follows = follows.map_or(0.0, |response| response.re);
        let bandwidth_hz = if follows == 0.0 { 0.0 } else { bandwidth_hz.unwrap_or(highest_hz) };
        let falls = margins.gain_decrease.filter(|factor| *factor > 0.0).map(f64::recip);
        let gain_margin = margins.gain.into_iter().chain(falls).reduce(f64::min);
        let step_overshoot =
            if self.with_step { Some(self.step_overshoot(&whole, bandwidth_hz, follows)?) } else { None };
        Ok(Some(Figures {
            bandwidth_hz,
            follows,
            phase_margin_deg: margins.phase_deg.map(f64::abs),
            gain_margin,
            gain_margin_hz: margins.gain_hz,
            disk_margin: margins.disk,
            sensitivity: margins.sensitivity_peak,
            sensitivity_hz: margins.sensitivity_peak_hz,
            step_overshoot,
        }))
    }

    fn step_overshoot(
        &self,
        whole: &ControlLoop,
        bandwidth_hz: f64,
        follows: f64,
    ) -> Result<f64, AnalysisError> {
        if follows == 0.0 || bandwidth_hz == 0.0 {
            return Ok(f64::INFINITY);
        }
        let step = StepResponse::new(whole, self.controller, STEP_PERIODS / bandwidth_hz)?;
        let values = step.map_or_else(Vec::new, |step| step.values);
        if values.iter().any(|value| value.is_nan()) {
            return Ok(f64::INFINITY);
        }
        let most = values.iter().map(|value| value / follows).fold(0.0, f64::max);
        Ok((most - 1.0).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::knobs::Knobs;
    use super::*;
    use feeler_files::{Document, Setting};

    /// The place of the surface is the integral of its speed. It is a pole at one, give or take rounding,
    /// that no gain of the force loop moves.
    #[test]
    fn regress_a_surface_that_a_source_moves_does_not_make_the_loop_unstable() {
        let scenarios = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios"));
        let settings = [("kp", 1.951), ("ki", 65.02), ("damping", 2637.0)];
        let settings =
            settings.map(|(name, value)| (format!("controllers.force.{name}"), Setting::Number(value)));
        let document = Document::load(&scenarios.join("contact/polishing.toml")).unwrap();
        let settings = settings.iter().map(|(key, value)| (key.as_str(), value.clone()));
        let scenario = document.with(settings).unwrap().scenario;
        let spec = &scenario.controllers["force"].spec;
        let plant = LinearPlant::new(&scenario, "force", spec, false).unwrap();
        for share in [0.125, 0.25, 0.5, 0.75, 1.0] {
            let figures = plant.figures(&Knobs::with_share(spec, share)).unwrap();
            assert!(figures.is_some_and(|figures| figures.bandwidth_hz > 1.0), "{share}: {figures:?}");
        }
    }
}
