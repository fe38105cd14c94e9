//! Doubtful values in a file without mistakes.

use feeler_analysis::{ControlLoop, gain, gain_names, modes};
use feeler_control::{ControllerSpec, Law, Reference};
use feeler_engine::Scenario;
use feeler_plant::assembly::Source;
use feeler_plant::description::{Axis, ContactLaw, Engagement, Quantity};
use feeler_problem::Problem;

use crate::numbers::{plain, two_digits, with_unit};
use crate::operating_point::contact_view;
use crate::run::ForceLoop;

/// Smallest number of samples in one cycle of a motion that a controller can observe.
const LEAST_SAMPLES: f64 = 2.0;
/// Largest damping ratio of the modes that are checked; others hardly oscillate.
const HARDLY_SWINGS: f64 = 0.5;

/// Instants of a run at which a reference is evaluated.
const INSTANTS: u32 = 200;
/// Farthest that a tool plausibly sinks into what it presses on, m: a thick foam gives way by this.
const SOFT_M: f64 = 0.02;

/// Implausible values: keys with the doubt, and the probable intention. Linear theory contributes if it
/// applies.
pub fn doubts(scenario: &Scenario) -> Vec<Problem> {
    let mut found = without_gains(scenario);
    found.extend(of_reference(scenario));
    found.extend(overlaps(scenario));
    if let Ok(whole) = ControlLoop::new(scenario, &contact_view(scenario)) {
        found.extend(slow_samples(scenario, &whole));
        found.extend(off_in_contact(scenario, &whole));
    }
    found
}

/// Laws whose gains are all zero.
fn without_gains(scenario: &Scenario) -> Vec<Problem> {
    let is_idle = |spec: &ControllerSpec| {
        let zero = |name: &&str| gain(spec, name).is_ok_and(|value| value == 0.0);
        !matches!(spec.law, Law::OpenLoop) && gain_names(&spec.law).iter().all(zero)
    };
    let idle = scenario.controllers.iter().filter(|(_, used)| is_idle(&used.spec));
    idle.map(|(name, used)| {
        let names = gain_names(&used.spec.law);
        Problem::new(
            format!("controllers.{name}"),
            format!("every gain of controller `{name}` is zero, so that it never acts"),
            format!("give it one of {}, or leave it out", names.join(", ")),
        )
    })
    .collect()
}

/// A contact that only pushes and is asked for a pull, or sinks in by centimetres under the force asked for.
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
            "turn the sign of the reference",
        ));
    }
    let sinks = most_n / contact.stiffness;
    // A law of its own takes the place of the stiffness.
    let is_linear = contact.law == ContactLaw::KelvinVoigt && contact.effects.is_empty();
    let is_soft = sinks > SOFT_M && is_linear && scenario.machine.axis == Axis::Translational;
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

/// Contacts with a negative gap whose bodies overlap at the start.
fn overlaps(scenario: &Scenario) -> Vec<Problem> {
    let machine = &scenario.machine;
    let unit = if machine.axis == Axis::Translational { "m" } else { "rad" };
    let starts_at = |name: &String| machine.bodies.get(name).map_or(0.0, |body| body.position_m);
    let mut found = Vec::new();
    for (name, contact) in &machine.contacts {
        let [from, to] = &contact.between;
        let inside = starts_at(from) - starts_at(to) - contact.gap_m;
        if contact.engagement == Engagement::Unilateral && contact.gap_m < 0.0 && inside > 0.0 {
            found.push(Problem::new(
                format!("contacts.{name}.gap"),
                format!("`{from}` starts {} inside `{to}`", with_unit(inside, unit)),
                "a positive gap keeps them apart",
            ));
        }
    }
    found
}

/// Controllers with less than two samples per cycle of a motion of the machine in contact.
fn slow_samples(scenario: &Scenario, whole: &ControlLoop) -> Vec<Problem> {
    let Ok(modes) = modes(whole.plant()) else { return Vec::new() };
    let swings =
        modes.iter().filter(|mode| mode.damping_ratio() < HARDLY_SWINGS && mode.damping_ratio() > 0.0);
    let Some(slowest_hz) = swings.map(feeler_analysis::VibrationMode::frequency_hz).reduce(f64::min) else {
        return Vec::new();
    };
    let closing = scenario.controllers.iter().filter(|(_, used)| !matches!(used.spec.law, Law::OpenLoop));
    let slow = closing.filter(|(_, used)| used.spec.period_s * slowest_hz * LEAST_SAMPLES > 1.0);
    slow.map(|(name, used)| {
        Problem::new(
            format!("controllers.{name}.period"),
            format!(
                "a period of {} takes {} samples of each cycle of the machine's slowest mode, {}",
                with_unit(used.spec.period_s, "s"),
                plain(two_digits(1.0 / (used.spec.period_s * slowest_hz))),
                with_unit(slowest_hz, "Hz")
            ),
            format!(
                "a period of {} takes ten; a number without a unit is in seconds",
                with_unit(two_digits(0.1 / slowest_hz), "s")
            ),
        )
    })
    .collect()
}

/// Force loops whose drive pulls the tool off although it is commanded to push, or that have a negative gain.
fn off_in_contact(scenario: &Scenario, whole: &ControlLoop) -> Option<Problem> {
    let found = ForceLoop::find(scenario)?;
    let used = &scenario.controllers[found.controller];
    let drive = scenario.machine.actuators.get_index_of(&used.drives)?;
    let plant = whole.plant();
    let contact = plant.output(Source::Contact(found.contact, Quantity::Force)).ok()?;
    // With the contact held, a pushing drive gives a static force of the same sign.
    let a = plant.a().clone().lu();
    let pressed = a.solve(&plant.b().column(drive).into_owned())?;
    let force = -(&contact.c * pressed)[(0, 0)] + contact.d[drive];
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
        format!("write between = [\"{to}\", \"{from}\"], or turn the sign of actuators.{}.gain", used.drives),
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
        format!("{name} is negative, so the feedback has the wrong sign"),
        format!("turn the sign of {name}"),
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
        let reversed =
            AXIS.replace("between = [\"m\", \"ground\"]\nstiff", "between = [\"ground\", \"m\"]\nstiff");
        assert_eq!(keys(&reversed), ["contacts.tool.between"]);
        let turned = AXIS.replace("kp = 0.4", "kp = -0.4");
        assert_eq!(keys(&turned), ["controllers.f.kp"]);
        // A sensor that falls as the tool pushes takes a negative gain.
        let falling = turned.replace("_force\"", "_force\"\ngain = -1.0");
        assert_eq!(keys(&falling.replace("reference = 20.0", "reference = -20.0")), Vec::<String>::new());
    }

    #[test]
    fn truth_a_tool_that_starts_inside_the_wall_is_doubted() {
        let gap =
            |gap: &str| keys(&AXIS.replace("damping = 120.0", &format!("damping = 120.0\ngap = {gap}")));
        assert_eq!(gap("-0.001"), ["contacts.tool.gap"]);
        assert_eq!(gap("0.001"), Vec::<String>::new());
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
