//! Controllers and their references.

use feeler_control::reference::{Between, Lines, Sweep};
use feeler_control::{READS, ReferenceSpec};
use feeler_engine::ControllerUse;

use super::{Writer, number, points};
use crate::keys::CONTROLLERS;

impl Writer {
    pub(super) fn controller(&mut self, name: &str, controller: &ControllerUse) {
        let spec = &controller.spec;
        self.header(&["controllers", name]);
        self.form(&CONTROLLERS, &spec.law);
        if let Some(sensor) = &controller.reads {
            self.words(READS.name, sensor);
        }
        self.record(controller);
        self.record(spec);
        self.record(&spec.law);
        self.line("reference", reference(&spec.reference));
        self.effects("controllers", name, &controller.effects);
    }
}

fn reference(spec: &ReferenceSpec) -> String {
    let table = |kind: &str, rest: String| format!("{{ kind = \"{kind}\", {rest} }}");
    match spec {
        ReferenceSpec::Constant(value) => number(*value),
        ReferenceSpec::Steps(steps) => points(steps.iter().copied()),
        ReferenceSpec::PiecewiseLinear(corners) => {
            table("ramp", format!("points = {}", points(corners.iter().copied())))
        }
        ReferenceSpec::Chirp { sweep, amplitude, start_hz, end_hz, duration_s, offset } => {
            let sweep = match sweep {
                Sweep::Linear => "linear",
                Sweep::Logarithmic => "logarithmic",
            };
            let [amplitude, start, end, duration, offset] =
                [*amplitude, *start_hz, *end_hz, *duration_s, *offset].map(number);
            let numbers = format!(
                "amplitude = {amplitude}, start = {start}, end = {end}, duration = {duration}, offset = {offset}"
            );
            table("chirp", format!("{numbers}, sweep = \"{sweep}\""))
        }
        ReferenceSpec::Multisine { lines, low_hz, high_hz, period_s, rms, offset } => {
            let lines = match lines {
                Lines::All => "all",
                Lines::Odd => "odd",
                Lines::OddSparse => "odd-sparse",
            };
            let [low, high, period, rms, offset] = [*low_hz, *high_hz, *period_s, *rms, *offset].map(number);
            table(
                "multisine",
                format!(
                    "rms = {rms}, band = [{low}, {high}], period = {period}, lines = \"{lines}\", offset = {offset}"
                ),
            )
        }
        ReferenceSpec::WhiteNoise { low_hz, high_hz, rms, offset } => {
            let [low, high, rms, offset] = [*low_hz, *high_hz, *rms, *offset].map(number);
            table("white-noise", format!("rms = {rms}, band = [{low}, {high}], offset = {offset}"))
        }
        ReferenceSpec::Prbs { order, clock_period_s, amplitude, offset } => {
            let [clock, amplitude, offset] = [*clock_period_s, *amplitude, *offset].map(number);
            table(
                "prbs",
                format!(
                    "order = {order}, clock_period = {clock}, amplitude = {amplitude}, offset = {offset}"
                ),
            )
        }
        ReferenceSpec::Table { times_s, values, between, offset } => {
            let between = match between {
                Between::Hold => "hold",
                Between::Linear => "linear",
            };
            let samples = points(times_s.iter().copied().zip(values.iter().copied()));
            table(
                "samples",
                format!("points = {samples}, between = \"{between}\", offset = {}", number(*offset)),
            )
        }
        // A shape that the format does not know cannot have come from a file.
        _ => number(0.0),
    }
}
