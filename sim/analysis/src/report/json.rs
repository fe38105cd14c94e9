//! A report as programs read it: one flat level, with `null` or empty values if there is no loop.

use serde::{Serialize, Serializer};

use crate::limits::limit_cycle::LimitCycle;
use crate::limits::margins::MarginReport;
use crate::limits::sensitivity::{RankedBy, Sensitivity};
use crate::limits::waterfall::{Limit, Waterfall};
use crate::loops::loop_pair::LoopPair;
use crate::machine::assumptions::Assumption;
use crate::report::{GainReport, ModeReport, Report, StateSpaceReport, WhyNoWaterfall};

/// The fields of a report and of its loop in the order in which they are written. The book shows their
/// comments.
#[derive(Serialize)]
struct Flat<'a> {
    /// Input of the channel that is analysed.
    input: &'a str,
    /// Output of the channel.
    output: &'a str,
    /// Contact force at the operating point; `None` without a contact.
    preload_n: Option<f64>,
    /// Exact delay from input to output, beside poles and zeros.
    delay_s: f64,
    /// Poles as pairs of real and imaginary part, rad/s.
    poles: &'a [[f64; 2]],
    /// Zeros as pairs of real and imaginary part, rad/s.
    zeros: &'a [[f64; 2]],
    /// Moduli of the poles over 2 pi; conjugate pairs once.
    poles_hz: &'a [f64],
    /// Moduli of the zeros over 2 pi; conjugate pairs once.
    zeros_hz: &'a [f64],
    /// Factor of the product of (s - zero) over that of (s - pole); `None` if the output does not depend on
    /// the input.
    zero_pole_gain: Option<f64>,
    /// A, B, C and D, with names of states, inputs and outputs.
    state_space: &'a StateSpaceReport,
    /// Modes: frequency, damping, class, phase and shape of each.
    modes: &'a [ModeReport],
    /// Controller, input, output and controlled quantity of the loop; `None` without a loop.
    #[serde(rename = "loop")]
    pair: Option<&'a LoopPair>,
    /// The gain in question: its present value and its stable intervals, continuous and sampled. `None`
    /// without a loop.
    gain: Option<&'a GainReport>,
    /// Margins of the sampled loop, peaks of S and T, and its Nyquist count; `None` without a loop.
    margins: Option<&'a MarginReport>,
    /// Bandwidth of the loop as set; `None` if it is unstable, or without a loop.
    bandwidth_hz: Option<f64>,
    /// Why there is no waterfall; `None` if there is one.
    untold: Option<&'a WhyNoWaterfall>,
    /// Frequencies of modes without damping that the loop observes.
    undamped_hz: &'a [f64],
    /// The cause that limits the bandwidth; `None` without a waterfall.
    limit: Option<Limit>,
    /// Bandwidth of the ideal loop, and with one more ingredient each; `None` without a loop, or if `untold`
    /// says why.
    waterfall: Option<&'a Waterfall>,
    /// Limit cycles that describing functions predict.
    limit_cycles: &'a [LimitCycle],
    /// Effect of 1 % of each number of the machine.
    sensitivities: &'a [Sensitivity],
    /// The quantity that orders them; `None` if there are none.
    ranked_by: Option<RankedBy>,
    /// Properties that are not linear, and their linear replacements.
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
