//! Values of the believed machine and records that a balance of forces needs.

use feeler_plant::assembly::Source;
use feeler_plant::description::{ActuatorKind, Axis, Engagement, Machine, Quantity};

use super::rows::Measured;
use crate::dataset::Dataset;

/// The believed values of the chain that the first drive moves, SI.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Believed {
    pub(in super::super) mass: f64,
    pub(in super::super) damping: f64,
    /// Level of dry friction; zero for none.
    pub(in super::super) friction: f64,
    /// Amplitude and phase of gravity.
    pub(in super::super) gravity: Option<[f64; 2]>,
    pub(in super::super) is_rotational: bool,
}

/// Bodies that move rigidly with `body`.
fn together<'a>(machine: &'a Machine, body: &'a str) -> Vec<&'a str> {
    let mut members = vec![body];
    let mut next = 0;
    while let Some(&at) = members.get(next) {
        next += 1;
        for spring in machine.springs.values().filter(|spring| spring.rigid) {
            let [a, b] = [spring.between[0].as_str(), spring.between[1].as_str()];
            for (from, to) in [(a, b), (b, a)] {
                if from == at && !members.contains(&to) {
                    members.push(to);
                }
            }
        }
    }
    members
}

impl Believed {
    /// Values of the chain that the first drive moves; `None` if there is no drive, its command is not a
    /// force, or the chain is held.
    pub(super) fn of(dataset: &Dataset) -> Option<Self> {
        let machine = &dataset.machine;
        let (_, actuator) = machine.actuators.get_index(dataset.drives.first()?.drive)?;
        if !matches!(actuator.kind, ActuatorKind::Force { .. }) {
            return None;
        }
        let chain = together(machine, &actuator.on);
        let mass: f64 = chain.iter().filter_map(|name| Some(machine.bodies.get(*name)?.mass_kg)).sum();
        let guides = machine.springs.values().filter(|spring| {
            let inside = |name: &String| chain.contains(&name.as_str());
            !spring.rigid && inside(&spring.between[0]) != inside(&spring.between[1])
        });
        let mut believed = Self {
            mass,
            damping: 0.0,
            friction: 0.0,
            gravity: None,
            is_rotational: machine.axis == Axis::Rotational,
        };
        for guide in guides {
            believed.damping += guide.damping_n_s_per_m;
            for effect in &guide.effects {
                match (effect.definition.name, effect.values.as_slice()) {
                    ("coulomb-friction", [level]) => believed.friction += level,
                    ("gravity", [amplitude, phase, ..]) => believed.gravity = Some([*amplitude, *phase]),
                    _ => {}
                }
            }
        }
        (mass > 0.0 && chain.len() <= machine.bodies.len()).then_some(believed)
    }
}

/// Measurements in free motion: the first drive's command and the first position of its chain.
pub(super) fn measured(dataset: &Dataset) -> Option<Vec<Measured>> {
    let machine = &dataset.machine;
    let drive = dataset.drives.first()?.drive;
    let chain = together(machine, &machine.actuators.get_index(drive)?.1.on);
    let is_position = |source: Source| match source {
        Source::Sensor(i) => {
            let reads = &machine.sensors[i].reads;
            reads.quantity == Quantity::Position && chain.contains(&reads.element.as_str())
        }
        Source::Node(node, Quantity::Position) => {
            node > 0
                && machine.bodies.get_index(node - 1).is_some_and(|(name, _)| chain.contains(&name.as_str()))
        }
        _ => false,
    };
    let channel = dataset.channels.iter().position(|channel| is_position(channel.source))?;
    let is_free =
        |engagement: Option<Engagement>| machine.contacts.is_empty() || engagement == Some(Engagement::Free);
    let records = dataset.records.iter().filter(|record| is_free(record.engagement));
    let found: Vec<Measured> = records
        .map(|record| Measured {
            spacing_s: record.spacing_s,
            command: record.commands[0].clone(),
            position: record.series[channel].clone(),
            is_check: record.is_check,
        })
        .collect();
    let has = |is_check: bool| found.iter().any(|record| record.is_check == is_check);
    (has(true) && has(false)).then_some(found)
}
