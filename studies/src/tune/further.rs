//! Numbers that could be tuned beside those asked for.

use feeler_analysis::leading_gain;
use feeler_catalogue::GainPart;
use feeler_control::Law;
use feeler_engine::{Program, Scenario};

use super::spec::{Spec, TunedPart};

/// A tip that names further numbers to tune; `None` if the specification names its own.
pub fn further(scenario: &Scenario, spec: &Spec, controller: &str) -> Option<String> {
    if spec.gains.is_some() || !spec.parts.is_empty() {
        return None;
    }
    let law = &scenario.controllers.get(controller)?.spec;
    let damping = law.law.gain(GainPart::Damping).filter(|gain| gain.number(&law.law) == Some(0.0));
    let damped = leading_gain(law).zip(damping).filter(|_| reads_motion(scenario, controller));
    let damped = damped.map_or_else(String::new, |(leading, damping)| {
        format!("\"gains = {leading}+{}\" or ", damping.key.name)
    });
    let part =
        if matches!(law.law, Law::ExplicitForce(_)) { TunedPart::Lead } else { TunedPart::Filter }.name();
    Some(format!("more bandwidth may come from --spec {damped}\"structure = gains+{part}\""))
}

/// Whether a controller knows the motion of its drive, as damping needs.
fn reads_motion(scenario: &Scenario, controller: &str) -> bool {
    let program = Program::new(scenario);
    program.is_ok_and(|program| {
        program.loops().any(|wiring| wiring.name == controller && wiring.motion.is_some())
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use feeler_files::Draft;

    use super::*;

    /// The tip for the press of a force, with these settings.
    fn tip(settings: &[&str], spec: &str) -> Option<String> {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/chatter/settles.toml");
        let settings: Vec<String> = settings.iter().map(|&setting| setting.into()).collect();
        let document = Draft::load_with(Path::new(file), &settings).unwrap().build().unwrap();
        further(&document.scenario, &Spec::parse(spec).unwrap(), "force")
    }

    #[test]
    fn truth_a_tip_names_what_the_law_has_and_the_specification_does_not() {
        let spec = "phase margin >= 60 deg";
        let undamped = tip(&["controllers.force.damping=0", "controllers.force.motion=\"encoder\""], spec);
        let (damping, lead) = ("\"gains = kp+damping\" or ", "\"structure = gains+lead\"");
        assert_eq!(undamped, Some(format!("more bandwidth may come from --spec {damping}{lead}")));
        let damped = tip(&["controllers.force.damping=9"], spec);
        assert_eq!(damped, Some(format!("more bandwidth may come from --spec {lead}")));
        assert_eq!(tip(&[], &format!("{spec}, gains = ki")), None);
    }
}
