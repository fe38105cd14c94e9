//! Gains and signs with which a loop cannot work, and drives that several controllers command.

use feeler_analysis::{ControlLoop, gain, gain_names};
use feeler_catalogue::{Field, GainPart, KeyRole, LAW, Tabled};
use feeler_control::{Law, ReferenceSpec};
use feeler_engine::{ControllerUse, Scenario};
use feeler_plant::assembly::Source;
use feeler_plant::description::{Actuator, Contact, Quantity};
use feeler_problem::Problem;
use nalgebra::DMatrix;

use crate::run::ForceLoop;

/// Growth of a command that a machine follows as if at rest, 1/s: slower than its motion.
const SLOW_PER_S: f64 = 1.0;

/// Laws whose gains are all zero, and force laws that feed nothing back or follow nothing.
pub(super) fn without_gains(scenario: &Scenario) -> Vec<Problem> {
    let of_controller = |(name, used): (&String, &ControllerUse)| {
        let law = &used.spec.law;
        let gains = law.gains();
        let key = |part| law.gain(part).map(|gain| gain.key.name);
        let part = |gain: &&Field<Law>| match gain.role {
            KeyRole::Gain { part, .. } if gain.number(law) != Some(0.0) => Some(part),
            _ => None,
        };
        let acting: Vec<GainPart> = gains.iter().filter_map(part).collect();
        let errors = || Some([key(GainPart::Proportional)?, key(GainPart::Integral)?]);
        let (doubt, remedy) = match (law, &acting[..]) {
            (Law::OpenLoop, _) => return None,
            (_, []) => (
                format!("every gain of controller `{name}` is zero, so it never acts"),
                format!("give it one of {}, or leave it out", gain_names(law).join(", ")),
            ),
            (Law::ExplicitForce(_), [GainPart::Other]) => {
                let ([kp, ki], forward) = (errors()?, key(GainPart::Other)?);
                (
                    format!("controller `{name}` has only {forward}, so the force is not fed back"),
                    format!("give it {kp} or {ki}; {LAW} = \"open-loop\" says that no feedback is meant"),
                )
            }
            (Law::ExplicitForce(_), [GainPart::Damping]) => {
                let ([kp, ki], damping, forward) =
                    (errors()?, key(GainPart::Damping)?, key(GainPart::Other)?);
                (
                    format!("controller `{name}` has only {damping}, so it follows no reference"),
                    format!("give it {kp}, {ki} or {forward}"),
                )
            }
            _ => return None,
        };
        Some(Problem::new(ControllerUse::place(name), doubt, remedy))
    };
    scenario.controllers.iter().filter_map(of_controller).collect()
}

/// Controllers that each follow a reference on one drive, where their outputs add up.
pub(super) fn shared_drives(scenario: &Scenario) -> Vec<Problem> {
    let follows = |(_, used): &(&String, &ControllerUse)| used.spec.reference != ReferenceSpec::Constant(0.0);
    let following: Vec<_> = scenario.controllers.iter().filter(follows).collect();
    let of_second = |(i, (name, used)): (usize, &(&String, &ControllerUse))| {
        let (first, _) = following[..i].iter().find(|(_, other)| other.drives == used.drives)?;
        Some(Problem::new(
            ControllerUse::DRIVES.of(name),
            format!(
                "`{first}` and `{name}` each follow a reference, and both command `{}`: their outputs add up",
                used.drives
            ),
            "leave one out, or give it a reference of zero; an excitation beside a loop may be meant",
        ))
    };
    following.iter().enumerate().filter_map(of_second).collect()
}

/// Force loops whose drive pulls the tool off although it is commanded to push, or that have a negative gain.
pub(super) fn off_in_contact(scenario: &Scenario, whole: &ControlLoop) -> Option<Problem> {
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
        Contact::BETWEEN.of(name),
        format!(
            "a positive command of `{}` pulls `{from}` off `{to}`: the contact pushes the other way",
            used.drives
        ),
        format!(
            "write between = [\"{to}\", \"{from}\"], or exchange `{}` and `{}` of {}",
            Actuator::ON.key.name,
            Actuator::REACTS_ON.key.name,
            Actuator::place(&used.drives)
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
        format!("{}.{name}", ControllerUse::place(&found.name)),
        format!("{name} is negative, so the feedback pushes away from the reference"),
        format!("reverse the sign of {name}"),
    ))
}
