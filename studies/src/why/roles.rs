//! The role of each element in a machine.

use std::collections::BTreeSet;

use feeler_plant::description::{GROUND, Machine};

/// The parts of a machine by their names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Roles {
    /// Springs within the robot: between the driven bodies and the tips.
    pub(super) transmissions: Vec<String>,
    /// Springs that hold the body with the drives' reaction.
    pub(super) mounts: Vec<String>,
    /// Springs that hold the workpiece.
    pub(super) fixtures: Vec<String>,
}

impl Roles {
    pub(super) fn of(machine: &Machine) -> Self {
        let known = |names: Vec<&String>| {
            names.into_iter().filter(|name| *name != GROUND).cloned().collect::<BTreeSet<String>>()
        };
        let base = known(machine.actuators.values().map(|actuator| &actuator.reacts_on).collect());
        let work: BTreeSet<String> =
            &known(machine.contacts.values().map(|contact| &contact.between[1]).collect()) - &base;
        let driven = machine.actuators.values().map(|actuator| &actuator.on);
        let mut robot =
            known(driven.chain(machine.contacts.values().map(|contact| &contact.between[0])).collect());
        // Bodies that springs join to the robot belong to it; a guide without stiffness joins nothing.
        let outside = |name: &String| name == GROUND || base.contains(name) || work.contains(name);
        for _ in 0..machine.bodies.len() {
            for spring in
                machine.springs.values().filter(|spring| spring.rigid || spring.stiffness_n_per_m > 0.0)
            {
                let [a, b] = &spring.between;
                if !outside(a) && !outside(b) && (robot.contains(a) || robot.contains(b)) {
                    robot.extend([a.clone(), b.clone()]);
                }
            }
        }
        let springs = |wanted: &dyn Fn(&str, &str) -> bool| {
            let joins =
                |between: &[String; 2]| wanted(&between[0], &between[1]) || wanted(&between[1], &between[0]);
            machine
                .springs
                .iter()
                .filter(|(_, spring)| joins(&spring.between))
                .map(|(name, _)| name.clone())
                .collect()
        };
        Self {
            transmissions: springs(&|a, b| robot.contains(a) && robot.contains(b)),
            mounts: springs(&|a, b| base.contains(a) && b == GROUND),
            fixtures: springs(&|a, b| work.contains(a) && (b == GROUND || base.contains(b))),
        }
    }
}
