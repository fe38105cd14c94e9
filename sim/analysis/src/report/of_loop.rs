//! The loop that one gain of a controller closes.

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
use crate::report::Request;
use crate::workers::Workers;

/// A loop: stable gains, margins, and what limits its bandwidth.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopReport {
    /// The signals between which it is closed, independent of the report's input and output; `None` if the
    /// controller reads nothing.
    pub pair: Option<LoopPair>,
    /// The gain and its stable values.
    pub gain: GainReport,
    /// Absent if the loop varies in time.
    pub margins: Option<MarginReport>,
    /// Frequency at which the reading first falls 3 dB below its value at low frequency, with the gains of
    /// the file, Hz. `None` if the loop is unstable or the reading never falls so far.
    pub bandwidth_hz: Option<f64>,
    /// The ingredients that limit the bandwidth; `None` without margins or a continuous loop to start from.
    pub waterfall: Option<Waterfall>,
    /// Why there is no waterfall; `None` if there is one.
    pub why_no_waterfall: Option<WhyNoWaterfall>,
    /// Parameters to stiffen, lighten or damp, the most important first; empty unless requested.
    pub sensitivities: Vec<Sensitivity>,
    /// The criterion of the ranking; `None` without sensitivities.
    pub ranked_by: Option<RankedBy>,
}

/// Stable values of a gain about its present value.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StableRange {
    /// Smallest and largest stable gain of the interval at or above zero, or below zero if the present gain
    /// is; `None` if there is none.
    pub stable: [Option<f64>; 2],
    /// Frequency at the upper edge, Hz; at the lower edge if there is no upper one.
    pub edge_hz: Option<f64>,
    /// Index of the mode that the motion at that edge resembles most; `None` if it resembles none.
    pub edge_mode: Option<usize>,
    /// Both edges of the interval, also a lower one below zero; `None` if the interval has no end.
    pub edges: [Option<Edge>; 2],
    /// Every interval on both sides of zero, rising.
    pub intervals: Vec<Band>,
    /// Every interval of gains from zero onwards.
    pub all: GainBands,
}

/// Stable values of a gain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GainReport {
    /// The gain's key.
    pub key: String,
    /// Its value in the file.
    pub present: f64,
    /// In the loop without sampling, delay and filters; `None` if the law has no such form.
    pub continuous: Option<StableRange>,
    /// In the loop as built.
    pub sampled: StableRange,
}

/// Why there is no waterfall of the bandwidth of a loop.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "reason", rename_all = "kebab-case")]
pub enum WhyNoWaterfall {
    /// Another controller samples more slowly, so the loop broken at this one varies in time.
    SlowerLoop {
        /// The controller at which the loop is broken.
        controller: String,
        /// Period of that controller, s.
        period_s: f64,
        /// The period with which all repeat together, s.
        common_s: f64,
        /// The controller with this period, at which the loop can be broken; `None` if no period is a
        /// multiple of all others.
        slowest: Option<String>,
    },
    /// The law's continuous form differentiates a signal that jumps with the command, so there is no
    /// continuous loop.
    NoContinuousForm {
        /// The controller.
        controller: String,
    },
}

/// A loop, and each mode's part in it if the controller reads something.
type LoopAndModes = (LoopReport, Option<Vec<ModeInPair>>);

impl LoopReport {
    /// The loop that the gain `key` closes, with the class of each of `modes` in it. If the controller reads
    /// nothing, modes are as `classified`.
    pub(super) fn new(
        machine: &Machine,
        whole: &ControlLoop,
        key: &str,
        modes: &[VibrationMode],
        classified: &[ModeInPair],
        request: &Request,
    ) -> Result<LoopAndModes, AnalysisError> {
        let (controller, name) = whole.gain_of_key(key)?;
        let (pair, in_loop) = loop_pair(machine, whole, controller, &name, modes)?.unzip();
        let present = gain(&whole.controllers()[controller].spec, &name)?;
        let workers = request.workers;
        // For a brief report, gains on the other side of zero do not matter.
        let with_below = !request.brief || present < 0.0;
        let below_zero = || {
            if with_below { whole.sampled_bands_below_zero(key) } else { Ok(BelowZero::not_sought()) }
        };
        let ((continuous, margins), (above, below)) = workers.both(
            || workers.both(|| continuous(whole, key, with_below), || margins(whole, controller)),
            || workers.both(|| whole.sampled_bands(key), below_zero),
        );
        let (continuous, no_form) = continuous?;
        let continuous = continuous.map(|(bands, below)| StableRange::about(present, bands, below));
        let sampled = StableRange::about(present, above?, below?);
        let (margins, slower) = margins?;
        let waterfall = (continuous.is_some() && margins.is_some() && !request.brief)
            .then(|| whole.waterfall(key, modes, in_loop.as_deref().unwrap_or(classified), workers))
            .transpose()?;
        let is_stable = margins.as_ref().is_some_and(|margins| margins.unstable_poles == 0);
        let closed = if is_stable { ClosedLoop::sampled(whole, controller)? } else { None };
        let bandwidth_hz = closed.map(|closed| closed.bandwidth_hz()).transpose()?.flatten();
        let (sensitivities, ranked_by) = if request.sensitivities && margins.is_some() {
            ranked(whole, key, waterfall.as_ref(), workers)?
        } else {
            (Vec::new(), None)
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

    /// The cause that limits the bandwidth; `None` without a waterfall.
    pub fn limit(&self) -> Option<Limit> {
        self.waterfall.as_ref().map(|waterfall| waterfall.limit)
    }
}

/// Intervals at or above zero, and below zero, in the continuous loop, or why there are none.
type Intervals = (Option<(GainBands, BelowZero)>, Option<WhyNoWaterfall>);
/// Margins of the sampled loop, or why there are none.
type MarginsOrWhy = (Option<MarginReport>, Option<WhyNoWaterfall>);

fn continuous(whole: &ControlLoop, key: &str, with_below: bool) -> Result<Intervals, AnalysisError> {
    let below_zero = || {
        if with_below { whole.continuous_bands_below_zero(key) } else { Ok(BelowZero::not_sought()) }
    };
    match whole.continuous_bands(key) {
        Ok(bands) => Ok((Some((bands, below_zero()?)), None)),
        Err(AnalysisError::Improper { name }) => {
            Ok((None, Some(WhyNoWaterfall::NoContinuousForm { controller: name })))
        }
        Err(other) => Err(other),
    }
}

fn margins(whole: &ControlLoop, controller: usize) -> Result<MarginsOrWhy, AnalysisError> {
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

/// Sensitivities and the criterion of their ranking.
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
    /// Whether the file's own value lies outside every stable interval of the loop as built.
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
        // If the present gain is not below zero, intervals below zero do not matter.
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
