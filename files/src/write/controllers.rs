//! Controllers and their references.

use feeler_control::reference::{Between, Lines, Sweep};
use feeler_control::{AntiWindup, Approach, Law, ReferenceSpec};
use feeler_engine::ControllerUse;

use super::machine::low_pass;
use super::{Writer, number, points};

impl Writer {
    pub(super) fn controller(&mut self, name: &str, controller: &ControllerUse) {
        let spec = &controller.spec;
        self.header(&["controllers", name]);
        self.words("law", spec.law.name());
        if let Some(sensor) = &controller.reads {
            self.words("reads", sensor);
        }
        if let Some(sensor) = &controller.motion {
            self.words("motion", sensor);
        }
        self.words("drives", &controller.drives);
        self.number("period", spec.period_s);
        self.unless("delay", spec.delay_s, 0.0);
        self.unless("jitter", spec.jitter_s, 0.0);
        self.unless("offset", spec.offset_s, 0.0);
        self.gains(&spec.law);
        self.optional("output_resolution", spec.output_resolution);
        self.optional("output_limit", spec.output_limit);
        if let Some(filter) = &spec.reading_low_pass {
            self.line("low_pass", low_pass(filter.cutoff_hz, filter.damping_ratio));
        }
        self.unless("velocity_filter", spec.velocity_filter_s, 0.0);
        if let Some(approach) = &spec.approach {
            self.approach(approach);
        }
        self.line("reference", reference(&spec.reference));
        self.effects("controllers", name, &controller.effects);
    }

    fn gains(&mut self, law: &Law) {
        match law {
            Law::ExplicitForce(gains) => {
                self.unless("feed_forward", gains.feed_forward, 0.0);
                self.unless("kp", gains.kp, 0.0);
                self.unless("ki", gains.ki, 0.0);
                self.unless("kd", gains.kd, 0.0);
                self.unless("damping", gains.damping, 0.0);
                self.unless("derivative_filter", gains.derivative_filter_s, 0.0);
                if let Some(lead) = &gains.lead {
                    self.line(
                        "lead",
                        format!("{{ zero = {}, pole = {} }}", number(lead.zero_hz), number(lead.pole_hz)),
                    );
                }
                self.anti_windup(gains.anti_windup);
            }
            Law::Position(gains) => {
                self.unless("kp", gains.kp, 0.0);
                self.unless("ki", gains.ki, 0.0);
                self.unless("kd", gains.kd, 0.0);
                self.unless("damping", gains.damping, 0.0);
                self.unless("derivative_filter", gains.derivative_filter_s, 0.0);
                self.anti_windup(gains.anti_windup);
            }
            Law::Impedance(gains) => {
                self.unless("stiffness", gains.stiffness, 0.0);
                self.unless("damping", gains.damping, 0.0);
                self.unless("force_gain", gains.force_gain, 0.0);
            }
            Law::Admittance(gains) => {
                self.unless("mass", gains.mass, 0.0);
                self.unless("damping", gains.damping, 0.0);
                self.unless("stiffness", gains.stiffness, 0.0);
                self.unless("kp", gains.kp, 0.0);
                self.unless("kd", gains.kd, 0.0);
                self.unless("velocity_feed_forward", gains.velocity_feed_forward, 0.0);
            }
            // The open loop has none; a law that the format does not know cannot have come from a file.
            _ => {}
        }
    }

    fn anti_windup(&mut self, anti_windup: AntiWindup) {
        match anti_windup {
            AntiWindup::Conditional => {}
            AntiWindup::Off => self.words("anti_windup", "off"),
            AntiWindup::BackCalculation { tracking_time_s } => {
                self.line("anti_windup", format!("{{ tracking_time = {} }}", number(tracking_time_s)));
            }
        }
    }

    fn approach(&mut self, approach: &Approach) {
        let release =
            approach.release.map_or_else(String::new, |release| format!(", release = {}", number(release)));
        let [speed, until, bandwidth] = [approach.speed, approach.until, approach.bandwidth_hz].map(number);
        self.line(
            "approach",
            format!("{{ speed = {speed}, until = {until}{release}, bandwidth = {bandwidth} }}"),
        );
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
