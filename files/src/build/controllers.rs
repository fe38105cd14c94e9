//! Controllers: law, timing, and the elements that they read, follow and drive.

use std::collections::HashSet;

use feeler_catalogue::{Dimension, Keyed, LAW};
use feeler_control::{ControllerSpec, Law, READS, Reference};
use feeler_engine::ControllerUse;
use feeler_plant::description::{ActuatorKind, Elements, GROUND, Machine, Sensor};
use feeler_plant::effects::HostKind;
use feeler_problem::Remedy;

use super::{Builder, Item};
use crate::keys::{CONTROLLERS, SENSORS};
use crate::read::{Scope, join};

impl Builder<'_> {
    pub(crate) fn controllers(&mut self, machine: &Machine) -> Elements<ControllerUse> {
        self.each(&CONTROLLERS, |builder, item| builder.controller(item, machine))
    }

    fn controller(&mut self, item: Item<'_>, machine: &Machine) -> Option<ControllerUse> {
        let word = |key: &str| item.table.get(key).and_then(|entry| entry.node.as_text()).unwrap_or_default();
        let output = self.command_dim(word(ControllerUse::DRIVES.key.name));
        let scope = Scope { output, ..self.scope() };
        let reference = Law::named(word(LAW)).map_or(Dimension::UNKNOWN, |law| scope.dim(law.follows()));
        let before = self.problems.count();
        let fields = self.fields(item, Scope { reference, ..scope });
        let effects = self.effects(item, HostKind::Controller);
        let reference = self.reference(item, &fields);
        let mut spec = ControllerSpec::new(Law::read(&fields)?, 1.0);
        spec.take(&fields);
        spec.reference = reference.unwrap_or(spec.reference);
        let reads = fields.value(&READS);
        let mut found = ControllerUse { spec, reads, motion: None, drives: String::new(), effects };
        found.take(&fields);
        if let Some(approach) = &mut found.spec.approach {
            approach.velocity_drive = machine
                .actuators
                .get(&found.drives)
                .is_some_and(|actuator| matches!(actuator.kind, ActuatorKind::VelocitySource { .. }));
            approach.effective_mass = effective_mass_kg(machine, &found.drives);
        }
        self.wiring(item, &found, machine);
        if self.problems.count() == before {
            self.check(item, &found);
        }
        Some(found)
    }

    /// Checks that need the control crate.
    fn check(&mut self, item: Item<'_>, found: &ControllerUse) {
        let error =
            found.spec.check().and_then(|()| Reference::new(&found.spec.reference, 1, item.name).map(drop));
        if found.spec.jitter_s >= found.spec.period_s {
            let (jitter, period) = (found.spec.jitter_s, found.spec.period_s);
            let message = format!("a jitter of {jitter} s is not below the period of {period} s");
            let key = ControllerSpec::JITTER.key.name;
            let remedy = "write a jitter well below the period";
            self.problems.add(item.place(key), item.key(key), message, remedy);
        }
        let Err(error) = error else { return };
        let key = error.place();
        let first = key.split('.').next().unwrap_or_default();
        let within = item.table.get(first).and_then(|entry| entry.node.as_table());
        let inner =
            key.split_once('.').and_then(|(_, rest)| within?.get(rest)).map(|entry| &entry.node.origin);
        self.problems.add(
            inner.unwrap_or(item.place(first)),
            item.key(&key),
            error.to_string(),
            error.remedy(),
        );
    }

    /// The sensors and drive of a controller. A key with its own mistake, and a sensor with a wrong signal,
    /// have been recorded already.
    fn wiring(&mut self, item: Item<'_>, found: &ControllerUse, machine: &Machine) {
        for problem in found.wiring_problems(machine) {
            let sensor = match problem.key.as_str() {
                key if key == READS.name => found.reads.as_deref(),
                key if key == ControllerUse::MOTION.key.name => found.motion.as_deref(),
                _ => None,
            };
            let sensor = sensor.filter(|name| machine.sensors.contains_key(*name));
            let is_noted = sensor.is_some_and(|name| {
                self.problems.covers(&join(&join(SENSORS.table, name), Sensor::READS.key.name))
            }) || self.problems.covers(&item.key(&problem.key));
            if !is_noted {
                let remedy = problem.remedy;
                self.problems.add(item.place(&problem.key), item.key(&problem.key), problem.message, remedy);
            }
        }
    }
}

/// The mass that the drive moves. It is the driven body and everything attached to it by springs, up to
/// ground and the body that carries the reaction.
fn effective_mass_kg(machine: &Machine, actuator: &str) -> f64 {
    let Some(actuator) = machine.actuators.get(actuator) else { return 1.0 };
    let mut members = vec![actuator.on.as_str()];
    let mut seen: HashSet<&str> = [GROUND, actuator.reacts_on.as_str(), actuator.on.as_str()].into();
    let mut next = 0;
    while let Some(&at) = members.get(next) {
        next += 1;
        for [a, b] in machine.springs.values().map(|spring| &spring.between) {
            let other = if a == at {
                b
            } else if b == at {
                a
            } else {
                continue;
            };
            if seen.insert(other) {
                members.push(other);
            }
        }
    }
    members.iter().filter_map(|name| machine.bodies.get(*name)).map(|body| body.mass_kg).sum()
}
