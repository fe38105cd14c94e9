//! Doubtful values in a file without mistakes.

use feeler_analysis::{ControlLoop, LinearMachine, LoopController, VibrationMode, gain, gain_names, modes};
use feeler_control::{Law, Reference};
use feeler_engine::{ControllerUse, Scenario};
use feeler_plant::assembly::Source;
use feeler_plant::description::{Axis, Contact, ContactLaw, Engagement, Quantity};
use feeler_problem::Problem;
use nalgebra::DMatrix;

use crate::numbers::{plain, two_digits, with_unit};
use crate::operating_point::contact_view;
use crate::run::ForceLoop;

/// Largest damping ratio of the modes that are checked; others hardly oscillate.
const HARDLY_SWINGS: f64 = 0.5;

/// Instants of a run at which a reference is evaluated.
const INSTANTS: u32 = 200;
/// Growth of a command that a machine follows as if at rest, 1/s: slower than its motion.
const SLOW_PER_S: f64 = 1.0;
/// Possible reason of a time that is too long.
const IN_SECONDS: &str = "a number without a unit is in seconds";
/// More samples than these are no usual delay of a controller or sensor.
const MANY_SAMPLES: f64 = 10.0;
/// Largest plausible depth to which a tool sinks into its workpiece, m: a thick foam yields as much.
const SOFT_M: f64 = 0.02;

/// Implausible values: keys with the doubt, and the probable intention. Linear theory contributes if it
/// applies.
pub fn doubts(scenario: &Scenario) -> Vec<Problem> {
    let mut found = without_gains(scenario);
    found.extend(of_reference(scenario));
    found.extend(overlaps(scenario));
    if let Ok(whole) = ControlLoop::new(scenario, &contact_view(scenario)) {
        found.extend(slow_loops(scenario, &whole));
        found.extend(off_in_contact(scenario, &whole));
    }
    found
}

/// Laws whose gains are all zero, and force laws that feed nothing back or follow nothing.
fn without_gains(scenario: &Scenario) -> Vec<Problem> {
    let zero = |value: &f64| *value == 0.0;
    let of_controller = |(name, used): (&String, &ControllerUse)| {
        let law = &used.spec.law;
        let names = gain_names(law);
        let is_zero = |name: &&str| gain(&used.spec, name).is_ok_and(|value| zero(&value));
        if matches!(law, Law::OpenLoop) {
            return None;
        }
        let all_zero = |gains: [f64; 4]| gains.iter().all(zero);
        let (doubt, remedy) = if names.iter().all(is_zero) {
            (
                format!("every gain of controller `{name}` is zero, so it never acts"),
                format!("give it one of {}, or leave it out", names.join(", ")),
            )
        } else if matches!(law, Law::ExplicitForce(g) if all_zero([g.kp, g.ki, g.kd, g.damping])) {
            (
                format!("controller `{name}` has only feed_forward, so the force is not fed back"),
                "give it kp or ki; law = \"open-loop\" says that no feedback is meant".to_owned(),
            )
        } else if matches!(law, Law::ExplicitForce(g) if all_zero([g.kp, g.ki, g.kd, g.feed_forward])) {
            (
                format!("controller `{name}` has only damping, so it follows no reference"),
                "give it kp, ki or feed_forward".to_owned(),
            )
        } else {
            return None;
        };
        Some(Problem::new(format!("controllers.{name}"), doubt, remedy))
    };
    scenario.controllers.iter().filter_map(of_controller).collect()
}

/// A contact that only pushes and has a pull as its reference, or sinks in by centimetres under it.
fn of_reference(scenario: &Scenario) -> Option<Problem> {
    let found = ForceLoop::find(scenario)?;
    let spec = &scenario.controllers[found.controller].spec;
    let (touched, contact) = scenario.machine.contacts.get_index(found.contact)?;
    let sensor = &scenario.machine.sensors[found.sensor];
    if sensor.reads.element != *touched || contact.engagement != Engagement::Unilateral || sensor.gain == 0.0
    {
        return None;
    }
    let reference = Reference::new(&spec.reference, scenario.run.seed, &found.name).ok()?;
    let wanted = (0..=INSTANTS).map(|i| {
        let t_s = scenario.run.duration_s * f64::from(i) / f64::from(INSTANTS);
        reference.value(t_s) / sensor.gain
    });
    let [least_n, most_n] = wanted.fold([0.0_f64; 2], |[least, most], n| [least.min(n), most.max(n)]);
    let unit = if scenario.machine.axis == Axis::Translational { "N" } else { "N m" };
    if least_n < 0.0 && most_n <= 0.0 {
        return Some(Problem::new(
            format!("controllers.{}.reference", found.name),
            format!(
                "the reference asks `{touched}` for a pull of {}, but a contact only pushes",
                with_unit(-least_n, unit)
            ),
            "reverse the sign of the reference",
        ));
    }
    let sinks = most_n / contact.stiffness;
    let is_soft = sinks > SOFT_M && is_plain(contact) && scenario.machine.axis == Axis::Translational;
    is_soft.then(|| {
        Problem::new(
            format!("contacts.{touched}.stiffness"),
            format!(
                "under the {} asked for, the tool sinks in by {}",
                with_unit(most_n, unit),
                with_unit(sinks, "m")
            ),
            "stiffness is in N/m unless a unit is given: write \"kN/m\" if that is meant",
        )
    })
}

/// Whether a contact pushes with its stiffness times its compression. Another law, or an effect, replaces the
/// stiffness.
fn is_plain(contact: &Contact) -> bool {
    contact.law == ContactLaw::KelvinVoigt && contact.effects.is_empty()
}

/// Contacts with a negative gap whose bodies overlap at the start.
fn overlaps(scenario: &Scenario) -> Vec<Problem> {
    let machine = &scenario.machine;
    let [unit, force] = if machine.axis == Axis::Translational { ["m", "N"] } else { ["rad", "N m"] };
    let starts_at = |name: &String| machine.bodies.get(name).map_or(0.0, |body| body.position_m);
    let mut found = Vec::new();
    for (name, contact) in &machine.contacts {
        let [from, to] = &contact.between;
        let inside = starts_at(from) - starts_at(to) - contact.gap_m;
        if contact.engagement == Engagement::Unilateral && contact.gap_m < 0.0 && inside > 0.0 {
            let pushes = is_plain(contact).then(|| {
                format!(
                    ": the contact begins with a push of {}",
                    with_unit(contact.stiffness * inside, force)
                )
            });
            found.push(Problem::new(
                format!("contacts.{name}.gap"),
                format!(
                    "`{from}` starts {} inside `{to}`{}",
                    with_unit(inside, unit),
                    pushes.unwrap_or_default()
                ),
                "a positive gap keeps them apart",
            ));
        }
    }
    found
}

/// Controllers that sample too seldom, or act too late, for the motion that they control.
fn slow_loops(scenario: &Scenario, whole: &ControlLoop) -> Vec<Problem> {
    let closes = |own: &&LoopController| !own.is_servo && !matches!(own.spec.law, Law::OpenLoop);
    let closing: Vec<&LoopController> = whole.controllers().iter().filter(closes).collect();
    if closing.is_empty() {
        return Vec::new();
    }
    let Ok(modes) = modes(whole.plant()) else { return Vec::new() };
    let swings = |mode: &&VibrationMode| (f64::MIN_POSITIVE..HARDLY_SWINGS).contains(&mode.damping_ratio());
    let slowest_hz = modes.iter().find(swings).map(VibrationMode::frequency_hz);
    let of_controller = |own: &LoopController| {
        let sensor = own.fed_back()?;
        let beyond = Beyond { plant: whole.plant(), own, sensor, slowest_hz };
        let (name, sensed) = scenario.machine.sensors.get_index(sensor)?;
        let delays = [
            (format!("controllers.{}.delay", own.name), own.spec.delay_s),
            (format!("sensors.{name}.delay"), sensed.delay_s),
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
        let key = format!("controllers.{}.period", self.own.name);
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

/// Force loops whose drive pulls the tool off although it is commanded to push, or that have a negative gain.
fn off_in_contact(scenario: &Scenario, whole: &ControlLoop) -> Option<Problem> {
    let found = ForceLoop::find(scenario)?;
    let used = &scenario.controllers[found.controller];
    let drive = scenario.machine.actuators.get_index_of(&used.drives)?;
    let plant = whole.plant();
    let contact = plant.output(Source::Contact(found.contact, Quantity::Force)).ok()?;
    // With the contact held, a push of the drive that grows slowly gives a force of the same sign. At rest, a
    // body that nothing holds in place has no answer.
    let n = plant.a().nrows();
    let growing = (DMatrix::<f64>::identity(n, n) * SLOW_PER_S - plant.a()).lu();
    let pressed = growing.solve(&plant.b().column(drive).into_owned())?;
    let force = (&contact.c * pressed)[(0, 0)] + contact.d[drive];
    if !force.is_finite() {
        return None;
    }
    if force >= 0.0 {
        return turned_gain(scenario, &found);
    }
    let (name, touched) = scenario.machine.contacts.get_index(found.contact)?;
    let [from, to] = &touched.between;
    Some(Problem::new(
        format!("contacts.{name}.between"),
        format!(
            "a positive command of `{}` pulls `{from}` off `{to}`: the contact pushes the other way",
            used.drives
        ),
        format!(
            "write between = [\"{to}\", \"{from}\"], or reverse the sign of actuators.{}.gain",
            used.drives
        ),
    ))
}

/// A negative gain of a force law where a positive command raises the reading.
fn turned_gain(scenario: &Scenario, found: &ForceLoop) -> Option<Problem> {
    let spec = &scenario.controllers[found.controller].spec;
    if !matches!(spec.law, Law::ExplicitForce(_)) || scenario.machine.sensors[found.sensor].gain <= 0.0 {
        return None;
    }
    let names = gain_names(&spec.law);
    let name = names.iter().find(|name| gain(spec, name).is_ok_and(|value| value < 0.0))?;
    Some(Problem::new(
        format!("controllers.{}.{name}", found.name),
        format!("{name} is negative, so the feedback pushes away from the reference"),
        format!("reverse the sign of {name}"),
    ))
}

#[cfg(test)]
mod tests {
    use feeler_files::Document;

    use super::*;

    const AXIS: &str = r#"
[bodies.m]
mass = 6.0
[springs.g]
between = ["ground", "m"]
damping = 60.0
[contacts.tool]
between = ["m", "ground"]
stiffness = 100000.0
damping = 120.0
[actuators.drive]
on = "m"
[sensors.force]
reads = "tool.spring_force"
[controllers.f]
law = "explicit-force"
reads = "force"
drives = "drive"
period = 0.001
feed_forward = 1.0
kp = 0.4
reference = 20.0
"#;

    fn keys(text: &str) -> Vec<String> {
        let document = Document::parse(text, "axis.toml").unwrap();
        doubts(&document.scenario).into_iter().map(|doubt| doubt.key).collect()
    }

    /// 20.5 Hz in contact.
    #[test]
    fn truth_nonsense_is_doubted_and_sense_is_not() {
        assert_eq!(keys(AXIS), Vec::<String>::new());
        assert_eq!(keys(&AXIS.replace("period = 0.001", "period = 0.03")), ["controllers.f.period"]);
        let idle = AXIS.replace("kp = 0.4", "kp = 0.0").replace("feed_forward = 1.0", "feed_forward = 0.0");
        assert_eq!(keys(&idle), ["controllers.f"]);
        assert_eq!(keys(&AXIS.replace("kp = 0.4", "kp = 0.0")), ["controllers.f"]);
        let sensed = |text: &str| format!("{text}[sensors.encoder]\nreads = \"m.velocity\"\n");
        assert_eq!(keys(&sensed(&idle.replace("kp = 0.0", "damping = 60.0"))), ["controllers.f"]);
        assert_eq!(
            keys(&sensed(&AXIS.replace("kp = 0.4", "damping = 60.0\nkp = 0.4"))),
            Vec::<String>::new()
        );
        assert_eq!(keys(&AXIS.replace("kp = 0.4", "ki = 4.0")), Vec::<String>::new());
        let reversed =
            AXIS.replace("between = [\"m\", \"ground\"]\nstiff", "between = [\"ground\", \"m\"]\nstiff");
        assert_eq!(keys(&reversed), ["contacts.tool.between"]);
        let turned = AXIS.replace("kp = 0.4", "kp = -0.4");
        assert_eq!(keys(&turned), ["controllers.f.kp"]);
        // A sensor that falls as the tool pushes takes a negative gain.
        let falling = turned.replace("_force\"", "_force\"\ngain = -1.0");
        assert_eq!(keys(&falling.replace("reference = 20.0", "reference = -20.0")), Vec::<String>::new());
    }

    /// A stiff velocity drive has a mode of its own, here at 6.5 kHz. The loop is an integrator with a gain
    /// of kp k / (2 pi f): 0.14 at half of 200 Hz, and 141 at half of 0.2 Hz.
    #[test]
    fn truth_the_mode_of_a_velocity_drive_asks_for_no_faster_samples_than_its_loop() {
        let kind = "kind = \"velocity-source\"\ndamping = 1e6\ntime_constant = 1e-4\n";
        let source = AXIS.replace("on = \"m\"\n", &format!("on = \"m\"\n{kind}"));
        let source = source.replace("feed_forward = 1.0\nkp = 0.4", "kp = 0.0009");
        let every = |period: &str| keys(&source.replace("period = 0.001", &format!("period = {period}")));
        assert_eq!(every("0.005"), Vec::<String>::new());
        assert_eq!(every("5.0"), ["controllers.f.period"]);
    }

    /// 8.2 cycles of the 20.5 Hz in contact; 20 ms are 0.4 of one, and 8 ms are 8 samples. The loop gain of
    /// the velocity drive above is 11 at 1.25 Hz.
    #[test]
    fn truth_a_delay_of_many_samples_and_cycles_is_doubted() {
        let late =
            |delay: &str| keys(&AXIS.replace("period = 0.001", &format!("period = 0.001\ndelay = {delay}")));
        assert_eq!(late("0.4"), ["controllers.f.delay"]);
        for plausible in ["0.0004", "0.008", "0.02"] {
            assert_eq!(late(plausible), Vec::<String>::new(), "{plausible}");
        }
        let sensed =
            AXIS.replace("reads = \"tool.spring_force\"", "reads = \"tool.spring_force\"\ndelay = 0.4");
        assert_eq!(keys(&sensed), ["sensors.force.delay"]);
        let kind = "kind = \"velocity-source\"\ndamping = 1e6\ntime_constant = 1e-4\n";
        let source = AXIS.replace("on = \"m\"\n", &format!("on = \"m\"\n{kind}"));
        let source = source.replace("feed_forward = 1.0\nkp = 0.4", "kp = 0.0009\ndelay = 0.4");
        assert_eq!(keys(&source), ["controllers.f.delay"]);
        assert_eq!(keys(&source.replace("delay = 0.4", "delay = 0.02")), Vec::<String>::new());
    }

    #[test]
    fn truth_a_tool_that_starts_inside_the_wall_is_doubted() {
        let gap =
            |gap: &str| keys(&AXIS.replace("damping = 120.0", &format!("damping = 120.0\ngap = {gap}")));
        assert_eq!(gap("-0.001"), ["contacts.tool.gap"]);
        assert_eq!(gap("0.001"), Vec::<String>::new());
        // 1 mm of 100 kN/m.
        let inside = Document::parse(&AXIS.replace("damping = 120.0", "damping = 120.0\ngap = -0.001"), "it");
        let found = doubts(&inside.unwrap().scenario);
        assert!(found[0].message.ends_with("a push of 100 N"), "{found:?}");
    }

    /// 20 N sink 100 mm into 200 N/m, and 10 mm into 2 kN/m.
    #[test]
    fn truth_a_pull_and_a_wall_of_foam_are_doubted() {
        let pulls = AXIS.replace("reference = 20.0", "reference = -20.0");
        assert_eq!(keys(&pulls), ["controllers.f.reference"]);
        assert_eq!(
            keys(&pulls.replace("stiffness", "engagement = \"clamped\"\nstiffness")),
            Vec::<String>::new()
        );
        // A sensor whose reading falls as the tool pushes.
        let turned = pulls.replace("spring_force\"", "spring_force\"\ngain = -1.0");
        assert!(!keys(&turned).contains(&"controllers.f.reference".to_owned()));
        let of = |stiffness: &str| {
            keys(&AXIS.replace("stiffness = 100000.0", &format!("stiffness = {stiffness}")))
        };
        assert_eq!(of("200.0"), ["contacts.tool.stiffness"]);
        assert_eq!(of("2000.0"), Vec::<String>::new());
    }
}
