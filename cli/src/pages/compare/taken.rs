//! A scenario of a comparison, with its results.

use feeler_analysis::{Curves, Report};
use feeler_files::Document;
use feeler_studies::glimpse::Glimpse;
use feeler_studies::run::RunResult;
use serde::Serialize;

use crate::units::Units;

/// A scenario with its results.
pub(crate) struct Taken {
    pub(crate) name: String,
    pub(crate) document: Document,
    pub(crate) glimpse: Glimpse,
}

impl Taken {
    pub(super) fn run(&self) -> Option<&RunResult> {
        self.glimpse.run.as_ref().ok()
    }

    pub(super) fn theory(&self) -> Option<&(Report, Curves)> {
        self.glimpse.theory.as_ref().ok()
    }

    pub(super) fn figures(&self) -> Option<LoopFigures> {
        self.theory().map(|(report, _)| LoopFigures::of(report))
    }

    pub(super) fn units(&self) -> Units {
        Units::of(&self.document.scenario.machine)
    }
}

/// Figures of the sampled loop by linear theory.
#[derive(Serialize)]
pub(super) struct LoopFigures {
    /// The gain as set; `None` without a loop.
    pub(super) gain: Option<f64>,
    /// The largest stable gain; `None` if there is none.
    pub(super) largest_stable_gain: Option<f64>,
    /// Whether the loop is stable as set; `None` without a loop.
    pub(super) is_stable: Option<bool>,
    /// Phase margin; `None` without a crossover, or if the loop is unstable.
    pub(super) phase_margin_deg: Option<f64>,
    /// Factor by which the gain may rise; `None` if no rise destabilises or the loop is unstable.
    pub(super) gain_margin: Option<f64>,
    /// Largest modulus of the sensitivity; `None` if the loop is unstable.
    pub(super) largest_sensitivity: Option<f64>,
    /// Bandwidth of the closed loop, Hz; `None` without one.
    pub(super) bandwidth_hz: Option<f64>,
}

impl LoopFigures {
    fn of(report: &Report) -> Self {
        // The margins of an unstable loop have no practical meaning.
        let margins = report.margins().filter(|margins| margins.unstable_poles == 0);
        let gain = report.gain();
        Self {
            gain: gain.map(|gain| gain.present),
            largest_stable_gain: gain.and_then(|gain| gain.sampled.stable[1]),
            is_stable: report.margins().map(|margins| margins.unstable_poles == 0),
            phase_margin_deg: margins.and_then(|margins| margins.phase_deg),
            gain_margin: margins.and_then(|margins| margins.gain),
            largest_sensitivity: margins.map(|margins| margins.sensitivity_peak),
            bandwidth_hz: report.looped.as_ref().and_then(|looped| looped.bandwidth_hz),
        }
    }
}
