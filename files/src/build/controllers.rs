//! Controllers: their law and timing, and what they read, follow and drive.

use std::collections::HashSet;

use feeler_catalogue::{Dim, Record};
use feeler_control::{ControlError, ControllerSpec, Law, READS, Reference};
use feeler_engine::ControllerUse;
use feeler_plant::description::{ActuatorKind, Elements, GROUND, Machine, Quantity};
use feeler_plant::effects::HostKind;
use feeler_plant::names::did_you_mean;

use super::{Builder, Item};
use crate::keys::CONTROLLERS;
use crate::read::{Scope, join};

impl Builder<'_> {
    /// The controllers of a machine.
    pub(crate) fn controllers(&mut self, machine: &Machine) -> Elements<ControllerUse> {
        self.each(&CONTROLLERS, |builder, item| builder.controller(item, machine))
    }

    fn controller(&mut self, item: Item<'_>, machine: &Machine) -> ControllerUse {
        let word = |key: &str| item.table.get(key).and_then(|entry| entry.node.as_text()).unwrap_or_default();
        let output = self.command_dim(word("drives"));
        let scope = Scope { output, ..self.scope() };
        let reference = Law::named(word("law")).map_or(Dim::UNKNOWN, |law| scope.dim(law.follows()));
        let before = self.problems.count();
        let fields = self.fields(item, Scope { reference, ..scope });
        let effects = self.effects(item, HostKind::Controller);
        let mut found = ControllerUse {
            spec: ControllerSpec {
                law: Law::read(&fields),
                reference: self.reference(item, &fields),
                ..ControllerSpec::read(&fields)
            },
            reads: fields.text(READS.name).map(str::to_owned),
            effects,
            ..ControllerUse::read(&fields)
        };
        if let Some(approach) = &mut found.spec.approach {
            approach.velocity_drive = machine
                .actuators
                .get(&found.drives)
                .is_some_and(|actuator| matches!(actuator.kind, ActuatorKind::VelocitySource { .. }));
            approach.effective_mass = effective_mass_kg(machine, &found.drives);
        }
        // A law that was not understood says nothing of what it needs.
        if fields.variant.is_some() {
            self.wiring(item, &found, machine);
        }
        if self.problems.count() == before {
            self.check(item, &found);
        }
        found
    }

    /// What only the control crate knows to be wrong.
    fn check(&mut self, item: Item<'_>, found: &ControllerUse) {
        let error =
            found.spec.check().and_then(|()| Reference::new(&found.spec.reference, 1, item.name).map(drop));
        if found.spec.jitter_s >= found.spec.period_s {
            let (jitter, period) = (found.spec.jitter_s, found.spec.period_s);
            let message = format!("a jitter of {jitter} s is not below the period of {period} s");
            self.problems.add(
                item.place("jitter"),
                item.key("jitter"),
                message,
                "write a jitter well below the period",
            );
        }
        let Err(error) = error else { return };
        let key = match &error {
            ControlError::OutOfRange { key, .. } => key,
            ControlError::TooLarge { key, .. } => *key,
            ControlError::ApproachNeedsForce => "approach",
            ControlError::AdmittanceWithoutMassOrDamping => "mass",
            _ => "reference",
        };
        let first = key.split('.').next().unwrap_or_default();
        let remedy = match &error {
            ControlError::TooLarge { key, bound, .. } => format!("choose `{key}` below {bound}"),
            ControlError::OutOfRange { bound, .. } => format!("this {}", bound.words()),
            ControlError::ApproachNeedsForce => {
                "remove `approach`, or choose a law that reads a force".into()
            }
            ControlError::AdmittanceWithoutMassOrDamping => {
                "give the virtual body a mass or a damping".into()
            }
            _ => "change the reference".into(),
        };
        let within = item.table.get(first).and_then(|entry| entry.node.as_table());
        let inner =
            key.split_once('.').and_then(|(_, rest)| within?.get(rest)).map(|entry| &entry.node.origin);
        self.problems.add(inner.unwrap_or(item.place(first)), item.key(key), error.to_string(), remedy);
    }

    fn wiring(&mut self, item: Item<'_>, found: &ControllerUse, machine: &Machine) {
        if item.table.contains_key("drives")
            && !found.drives.is_empty()
            && !machine.actuators.contains_key(&found.drives)
        {
            let remedy = did_you_mean(&found.drives, machine.actuators.keys().map(String::as_str));
            self.problems.add(
                item.place("drives"),
                item.key("drives"),
                format!("there is no actuator `{}`", found.drives),
                remedy,
            );
        }
        let force = [Quantity::Force, Quantity::SpringForce];
        let motion = [Quantity::Position, Quantity::Velocity];
        match found.spec.law {
            Law::Position(_) => self.sensor_of(
                item,
                "reads",
                found.reads.as_deref(),
                machine,
                &[Quantity::Position],
                "a position",
            ),
            _ => self.sensor_of(item, "reads", found.reads.as_deref(), machine, &force, "a force"),
        }
        self.sensor_of(item, "motion", found.motion.as_deref(), machine, &motion, "a position or velocity");

        let driven = machine.actuators.get(&found.drives);
        let default = || {
            let body = driven.map(|actuator| actuator.on.as_str());
            machine.sensors.values().any(|sensor| {
                motion.contains(&sensor.reads.quantity) && Some(sensor.reads.element.as_str()) == body
            })
        };
        let approach = found.spec.approach.is_some_and(|approach| !approach.velocity_drive);
        if driven.is_some()
            && found.motion.is_none()
            && (found.spec.law.needs_motion() || approach)
            && !default()
        {
            let message = if approach {
                "the approach of a force drive needs a motion sensor"
            } else {
                "this law needs a motion sensor"
            };
            let remedy =
                "add `motion = \"...\"`, or a sensor that reads position or velocity of the driven body";
            self.problems.add(item.at, item.key("motion"), message, remedy);
        }
        let inner = matches!(found.spec.law, Law::Impedance(gains) if gains.force_gain != 0.0);
        if found.reads.is_none()
            && (inner || (found.spec.approach.is_some() && !matches!(found.spec.law, Law::Position(_))))
        {
            let what = if inner { "force_gain" } else { "the approach" };
            self.problems.add(
                item.at,
                item.key("reads"),
                format!("{what} needs a force sensor"),
                "add `reads = \"...\"`",
            );
        }
    }

    fn sensor_of(
        &mut self,
        item: Item<'_>,
        key: &str,
        name: Option<&str>,
        machine: &Machine,
        wanted: &[Quantity],
        what: &str,
    ) {
        let Some(name) = name else { return };
        let Some(sensor) = machine.sensors.get(name) else {
            let remedy = did_you_mean(name, machine.sensors.keys().map(String::as_str));
            self.problems.add(item.place(key), item.key(key), format!("there is no sensor `{name}`"), remedy);
            return;
        };
        // A sensor whose own signal is wrong has been noted already.
        let known = !self.problems.covers(&join(&join("sensors", name), "reads"));
        if known && !wanted.contains(&sensor.reads.quantity) {
            let fitting = machine
                .sensors
                .iter()
                .filter(|(_, sensor)| wanted.contains(&sensor.reads.quantity))
                .map(|(name, _)| name.as_str());
            let message = format!("the sensor `{name}` reads `{}`, and this needs {what}", sensor.reads);
            self.problems.add(item.place(key), item.key(key), message, did_you_mean(name, fitting));
        }
    }
}

/// What the drive moves: the driven body and all that hangs on it by springs, as far as ground and the body
/// that carries the reaction.
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
