//! What is known of the loop that one gain of a controller closes.

use feeler_plant::description::Machine;
use serde::Serialize;

use crate::error::AnalysisError;
use crate::limits::margins::MarginReport;
use crate::limits::sensitivity::{RankedBy, Sensitivity, rank};
use crate::limits::stability::{Band, BelowZero, Edge, GainBands, nearest};
use crate::limits::waterfall::{Limit, Waterfall};
use crate::loops::closed_loop::ClosedLoop;
use crate::loops::control_loop::ControlLoop;
use crate::loops::gain_key::gain;
use crate::loops::loop_pair::{LoopPair, loop_pair};
use crate::machine::modes::{ModeInPair, VibrationMode};
use crate::workers::Workers;

/// A loop: stable gains, margins, and what limits its bandwidth.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopReport {
    /// Between which signals it is closed, whatever input and output of the report are; absent if the
    /// controller reads nothing.
    pub pair: Option<LoopPair>,
    /// The gain and its stable values.
    pub gain: GainReport,
    /// Absent if the loop varies in time.
    pub margins: Option<MarginReport>,
    /// Frequency at which the reading first falls 3 dB below what it is at low frequency, gains as in the
    /// file, Hz; absent if the loop is unstable, or never falls.
    pub bandwidth_hz: Option<f64>,
    /// What limits the bandwidth; absent without margins or a continuous loop to begin from.
    pub waterfall: Option<Waterfall>,
    /// Why there is no waterfall; absent if there is one.
    pub why_no_waterfall: Option<WhyNoWaterfall>,
    /// What to stiffen, lighten or damp first: the most telling number first; empty unless asked for.
    pub sensitivities: Vec<Sensitivity>,
    /// By what they are ranked; absent if there are none.
    pub ranked_by: Option<RankedBy>,
}

/// Stable values of a gain about its present value.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StableRange {
    /// Smallest and largest stable gain of those that are not below zero (of those below, where the present
    /// gain is); absent if there is none.
    pub stable: [Option<f64>; 2],
    /// Frequency at the upper edge, Hz (at the lower one where there is no upper).
    pub edge_hz: Option<f64>,
    /// Index of the mode that the motion at that edge is most like.
    pub edge_mode: Option<usize>,
    /// Both edges of the interval, the lower one wherever it is, also below zero; absent if the interval
    /// has no end.
    pub edges: [Option<Edge>; 2],
    /// Every interval on either side of zero, rising.
    pub intervals: Vec<Band>,
    /// Every interval of gains from zero on.
    pub all: GainBands,
}

/// Stable values of a gain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GainReport {
    /// The gain's key.
    pub key: String,
    /// Its value in the file.
    pub present: f64,
    /// In the loop without sampling, delay and filters; absent if the law has no such form.
    pub continuous: Option<StableRange>,
    /// In the loop as built.
    pub sampled: StableRange,
}

/// Why the bandwidth of a loop has no account.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "reason", rename_all = "kebab-case")]
pub enum WhyNoWaterfall {
    /// Another controller is sampled more slowly, so that the loop broken at this one varies in time.
    SlowerLoop {
        /// This one.
        controller: String,
        /// Its period, s.
        period_s: f64,
        /// The period with which all repeat together, s.
        common_s: f64,
        /// The controller that has this period, at which the loop can be broken; absent if no period is a
        /// multiple of all others.
        slowest: Option<String>,
    },
    /// The law's continuous form differentiates a signal that jumps with the command, so that there is no
    /// loop on paper.
    NoContinuousForm {
        /// The controller.
        controller: String,
    },
}

/// A loop with what each mode is in it, where the controller reads something.
type LoopAndModes = (LoopReport, Option<Vec<ModeInPair>>);

impl LoopReport {
    /// The loop that the gain `key` closes, with what each of `modes` is in it; of a controller that reads
    /// nothing modes are as `classified`. `workers` find the sensitivities, where these are asked for.
    pub(super) fn new(
        machine: &Machine,
        whole: &ControlLoop,
        key: &str,
        modes: &[VibrationMode],
        classified: &[ModeInPair],
        brief: bool,
        workers: Option<Workers>,
    ) -> Result<LoopAndModes, AnalysisError> {
        let (controller, name) = whole.gain_of_key(key)?;
        let (pair, in_loop) = loop_pair(machine, whole, controller, &name, modes)?.unzip();
        let present = gain(&whole.controllers()[controller].spec, &name)?;
        let (continuous, no_form) = continuous(whole, key, present)?;
        let sampled =
            StableRange::about(present, whole.sampled_bands(key)?, whole.sampled_bands_below_zero(key)?);
        let (margins, slower) = margins(whole, controller)?;
        let waterfall = (continuous.is_some() && margins.is_some() && !brief)
            .then(|| whole.waterfall(key, modes, in_loop.as_deref().unwrap_or(classified)))
            .transpose()?;
        let is_stable = margins.as_ref().is_some_and(|margins| margins.unstable_poles == 0);
        let closed = if is_stable { ClosedLoop::sampled(whole, controller)? } else { None };
        let bandwidth_hz = closed.map(|closed| closed.bandwidth_hz()).transpose()?.flatten();
        let (sensitivities, ranked_by) = match workers.filter(|_| margins.is_some()) {
            Some(workers) => ranked(whole, key, waterfall.as_ref(), workers)?,
            None => (Vec::new(), None),
        };
        let report = Self {
            pair,
            gain: GainReport { key: key.to_owned(), present, continuous, sampled },
            margins,
            bandwidth_hz,
            waterfall,
            why_no_waterfall: slower.or(no_form),
            sensitivities,
            ranked_by,
        };
        Ok((report, in_loop))
    }

    /// What limits the bandwidth; absent without a waterfall.
    pub fn limit(&self) -> Option<Limit> {
        self.waterfall.as_ref().map(|waterfall| waterfall.limit)
    }
}

/// Stable values in the continuous loop, or why there are none.
fn continuous(
    whole: &ControlLoop,
    key: &str,
    present: f64,
) -> Result<(Option<StableRange>, Option<WhyNoWaterfall>), AnalysisError> {
    match whole.continuous_bands(key) {
        Ok(bands) => {
            let below = whole.continuous_bands_below_zero(key)?;
            Ok((Some(StableRange::about(present, bands, below)), None))
        }
        Err(AnalysisError::Improper { name }) => {
            Ok((None, Some(WhyNoWaterfall::NoContinuousForm { controller: name })))
        }
        Err(other) => Err(other),
    }
}

/// Margins of the sampled loop, or why there are none.
fn margins(
    whole: &ControlLoop,
    controller: usize,
) -> Result<(Option<MarginReport>, Option<WhyNoWaterfall>), AnalysisError> {
    match whole.open_loop(controller) {
        Ok(open) => Ok((Some(MarginReport::new(&open.transfer()?)?), None)),
        Err(AnalysisError::SlowerThanLoop { name, period_s, common_s }) => {
            let slowest = whole
                .controllers()
                .iter()
                .find(|c| (common_s - c.spec.period_s).abs() <= 1e-9 * common_s)
                .map(|controller| controller.name.clone());
            Ok((None, Some(WhyNoWaterfall::SlowerLoop { controller: name, period_s, common_s, slowest })))
        }
        Err(other) => Err(other),
    }
}

/// Sensitivities, and by what they are ranked.
fn ranked(
    whole: &ControlLoop,
    key: &str,
    waterfall: Option<&Waterfall>,
    workers: Workers,
) -> Result<(Vec<Sensitivity>, Option<RankedBy>), AnalysisError> {
    let mut sensitivities = whole.sensitivities(key, workers)?;
    let by = match waterfall {
        Some(Waterfall { limit: Limit::Saturation, .. }) => RankedBy::Saturation,
        Some(Waterfall { rides_mode: Some(_), .. }) => RankedBy::LargestGain,
        _ => RankedBy::BandwidthAndGain,
    };
    rank(&mut sensitivities, by);
    let ranked_by = (!sensitivities.is_empty()).then_some(by);
    Ok((sensitivities, ranked_by))
}

impl GainReport {
    /// Whether the file's own value lies beyond every stable interval of the loop as built.
    pub fn is_unstable_as_set(&self) -> bool {
        let holds = |band: &Band| {
            let from = band.lower.as_ref().map_or(f64::NEG_INFINITY, |edge| edge.gain);
            let to = band.upper.as_ref().map_or(f64::INFINITY, |edge| edge.gain);
            (from..=to).contains(&self.present)
        };
        !self.sampled.intervals.iter().any(holds)
    }
}

impl StableRange {
    fn about(present: f64, all: GainBands, below: BelowZero) -> Self {
        let intervals = all.joined(below);
        // Of a gain that is not below zero, those below are asked for by nobody.
        let asked = |band: &&Band| present < 0.0 || band.upper.as_ref().is_none_or(|edge| edge.gain > 0.0);
        let Some(band) = nearest(intervals.iter().filter(asked), present).cloned() else {
            return Self { intervals, all, ..Self::default() };
        };
        let [low, high] = [&band.lower, &band.upper].map(|edge| edge.as_ref().map(|e| e.gain));
        let edge = band.upper.as_ref().or(band.lower.as_ref());
        Self {
            stable: [if present < 0.0 { low } else { Some(low.unwrap_or(0.0).max(0.0)) }, high],
            edge_hz: edge.map(|e| e.frequency_hz),
            edge_mode: edge.and_then(|e| e.mode),
            edges: [band.lower, band.upper],
            intervals,
            all,
        }
    }
}
