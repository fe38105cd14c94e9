//! Controllers that sample or act too late for the motion that they control.

use feeler_analysis::{ControlLoop, LinearMachine, LoopController, VibrationMode, modes};
use feeler_control::{ControllerSpec, Law};
use feeler_engine::Scenario;
use feeler_plant::assembly::Source;
use feeler_plant::description::Sensor;
use feeler_problem::Problem;

use crate::numbers::{plain, two_digits, with_unit};

/// Largest damping ratio of the modes that are checked; others hardly oscillate.
const STRONGLY_DAMPED: f64 = 0.5;
/// More samples than these are no usual delay of a controller or sensor.
const MANY_SAMPLES: f64 = 10.0;
/// Possible reason of a time that is too long.
const IN_SECONDS: &str = "a number without a unit is in seconds";

/// Controllers that sample too seldom, or act too late, for the motion that they control.
pub(super) fn slow_loops(scenario: &Scenario, whole: &ControlLoop) -> Vec<Problem> {
    let closes = |own: &&LoopController| !own.is_servo && !matches!(own.spec.law, Law::OpenLoop);
    let closing: Vec<&LoopController> = whole.controllers().iter().filter(closes).collect();
    if closing.is_empty() {
        return Vec::new();
    }
    let Ok(modes) = modes(whole.plant()) else { return Vec::new() };
    let oscillates =
        |mode: &&VibrationMode| (f64::MIN_POSITIVE..STRONGLY_DAMPED).contains(&mode.damping_ratio());
    let slowest_hz = modes.iter().find(oscillates).map(VibrationMode::frequency_hz);
    let of_controller = |own: &LoopController| {
        let sensor = own.fed_back()?;
        let beyond = Beyond { plant: whole.plant(), own, sensor, slowest_hz };
        let (name, sensed) = scenario.machine.sensors.get_index(sensor)?;
        let delays = [
            (ControllerSpec::DELAY.of(&own.name), own.spec.delay_s),
            (Sensor::DELAY.of(name), sensed.delay_s),
        ];
        let late = delays.into_iter().filter_map(|(key, delay_s)| beyond.late(key, delay_s));
        Some(beyond.slow_sample().into_iter().chain(late).collect::<Vec<Problem>>())
    };
    closing.into_iter().filter_map(of_controller).flatten().collect()
}

/// Modes and delays of a control loop above a frequency.
struct Beyond<'a> {
    plant: &'a LinearMachine,
    own: &'a LoopController,
    /// The sensor that is fed back.
    sensor: usize,
    /// The machine's slowest mode that oscillates.
    slowest_hz: Option<f64>,
}

enum Found {
    /// The machine's slowest mode, Hz.
    Mode(f64),
    /// A loop gain above one.
    Gain(f64),
}

impl Beyond<'_> {
    /// The slowest mode above a frequency, or a loop gain there that is above one.
    fn above(&self, hz: f64) -> Option<Found> {
        let Self { plant, own, sensor, slowest_hz } = self;
        let channel = plant.channel_of(own.drive, &plant.output(Source::Sensor(*sensor)).ok()?).ok()?;
        let response = |hz: f64| channel.frequency_response(&[hz]).ok().map(|values| values[0].norm());
        let here = response(hz)?;
        // The loop of a velocity drive has a fast mode of its own, which the reading hardly shows.
        let is_seen = |hz: f64| response(hz).is_none_or(|peak| peak > here);
        if let Some(mode_hz) = slowest_hz.filter(|&mode_hz| mode_hz > hz && is_seen(mode_hz)) {
            return Some(Found::Mode(mode_hz));
        }
        let law = own.spec.linear(own.motion_is_velocity).ok()?;
        let [_, of_reading, of_motion] = law.d;
        let direct = if own.reading == Some(*sensor) { of_reading } else { of_motion };
        let gain = direct.abs() * here;
        (gain > 1.0).then_some(Found::Gain(gain))
    }

    /// Less than two samples of each cycle of the slowest mode, or a loop gain above one at half of the
    /// sampling rate.
    fn slow_sample(&self) -> Option<Problem> {
        let period_s = self.own.spec.period_s;
        let half_rate_hz = 0.5 / period_s;
        let period = with_unit(period_s, "s");
        let (doubt, remedy) = match self.above(half_rate_hz)? {
            Found::Mode(mode_hz) => (
                format!(
                    "a period of {period} takes {} samples of each cycle of the machine's slowest mode, {}",
                    plain(two_digits(1.0 / (period_s * mode_hz))),
                    with_unit(mode_hz, "Hz")
                ),
                format!("a period of {} takes ten", with_unit(two_digits(0.1 / mode_hz), "s")),
            ),
            Found::Gain(gain) => (
                format!(
                    "a period of {period} is too long for this loop: at half of the sampling rate, {}, its \
                     gain is still {}",
                    with_unit(half_rate_hz, "Hz"),
                    plain(two_digits(gain))
                ),
                "shorten the period, or lower the gain".to_owned(),
            ),
        };
        let key = ControllerSpec::PERIOD.of(&self.own.name);
        Some(Problem::new(key, doubt, format!("{remedy}; {IN_SECONDS}")))
    }

    /// A delay of many samples that lasts half a cycle of the slowest mode, or that reverses the feedback at
    /// a frequency with a loop gain above one.
    fn late(&self, key: String, delay_s: f64) -> Option<Problem> {
        let period_s = self.own.spec.period_s;
        if delay_s <= MANY_SAMPLES * period_s {
            return None;
        }
        let reversed_hz = 0.5 / delay_s;
        let why = match self.above(reversed_hz)? {
            Found::Mode(mode_hz) => format!(
                "{} cycles of the machine's slowest mode, {}",
                plain(two_digits(delay_s * mode_hz)),
                with_unit(mode_hz, "Hz")
            ),
            Found::Gain(gain) => format!(
                "reverses the feedback at {}, where the gain of the loop is {}",
                with_unit(reversed_hz, "Hz"),
                plain(two_digits(gain))
            ),
        };
        let samples = plain(two_digits(delay_s / period_s));
        Some(Problem::new(
            key,
            format!(
                "a delay of {} is {samples} samples of the controller, and {why}",
                with_unit(delay_s, "s")
            ),
            format!("one sample is {}; {IN_SECONDS}", with_unit(period_s, "s")),
        ))
    }
}
