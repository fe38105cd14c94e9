//! A report as programs read it: one flat level, with `null` or empty values if there is no loop.

use serde::{Serialize, Serializer};

use crate::limits::limit_cycle::LimitCycle;
use crate::limits::margins::MarginReport;
use crate::limits::sensitivity::{RankedBy, Sensitivity};
use crate::limits::waterfall::{Limit, Waterfall};
use crate::loops::loop_pair::LoopPair;
use crate::machine::assumptions::Assumption;
use crate::report::{GainReport, ModeReport, Report, StateSpaceReport, WhyNoWaterfall};

/// The fields of a report and of its loop in the order in which they are written.
#[derive(Serialize)]
struct Flat<'a> {
    input: &'a str,
    output: &'a str,
    preload_n: Option<f64>,
    delay_s: f64,
    poles: &'a [[f64; 2]],
    zeros: &'a [[f64; 2]],
    poles_hz: &'a [f64],
    zeros_hz: &'a [f64],
    zero_pole_gain: Option<f64>,
    state_space: &'a StateSpaceReport,
    modes: &'a [ModeReport],
    #[serde(rename = "loop")]
    pair: Option<&'a LoopPair>,
    gain: Option<&'a GainReport>,
    margins: Option<&'a MarginReport>,
    bandwidth_hz: Option<f64>,
    untold: Option<&'a WhyNoWaterfall>,
    undamped_hz: &'a [f64],
    limit: Option<Limit>,
    waterfall: Option<&'a Waterfall>,
    limit_cycles: &'a [LimitCycle],
    sensitivities: &'a [Sensitivity],
    ranked_by: Option<RankedBy>,
    assumptions: &'a [Assumption],
}

impl Serialize for Report {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Flat {
            input: &self.input,
            output: &self.output,
            preload_n: self.preload_n,
            delay_s: self.delay_s,
            poles: &self.poles,
            zeros: &self.zeros,
            poles_hz: &self.poles_hz,
            zeros_hz: &self.zeros_hz,
            zero_pole_gain: self.zero_pole_gain,
            state_space: &self.state_space,
            modes: &self.modes,
            pair: self.pair(),
            gain: self.gain(),
            margins: self.margins(),
            bandwidth_hz: self.looped.as_ref().and_then(|looped| looped.bandwidth_hz),
            untold: self.why_no_waterfall(),
            undamped_hz: &self.undamped_hz,
            limit: self.limit(),
            waterfall: self.waterfall(),
            limit_cycles: &self.limit_cycles,
            sensitivities: self.sensitivities(),
            ranked_by: self.ranked_by(),
            assumptions: &self.assumptions,
        }
        .serialize(serializer)
    }
}
