//! From names to numbers.

mod drives;

use std::collections::HashMap;

use feeler_catalogue::Tabled;

use super::resolve::resolve;
use super::{
    Assembly, ContactPart, ForceLaw, GROUND_NODE, Link, Node, NodeId, PositionForce, Pull, SensorPart,
    Source, Weight,
};
use crate::description::{
    Actuator, Axis, Body, Contact, ContactLaw, GROUND, Machine, Sensor, SignalName, Spring,
};
use crate::effects::{Change, EffectUse, Host, Kind};
use crate::names::did_you_mean;
use crate::problem::{Problem, Remedy};

/// Resolves every name of a machine and applies its effects, in the order: bodies, springs, contacts,
/// actuators, sensors.
///
/// # Errors
/// Every mistake of the machine at once: dangling names, elements that join a body to itself, and effects on
/// the wrong elements.
pub fn assemble(machine: &Machine) -> Result<Assembly, Vec<Problem>> {
    let mut build = Build::new(machine);
    build.weights();
    build.links();
    build.contacts();
    build.drives();
    build.sensors();
    if build.problems.is_empty() {
        build.effects();
        build.encoders();
    }
    if build.problems.is_empty() { Ok(build.assembly) } else { Err(build.problems) }
}

struct Build<'a> {
    machine: &'a Machine,
    node_of: HashMap<&'a str, NodeId>,
    assembly: Assembly,
    problems: Vec<Problem>,
}

impl<'a> Build<'a> {
    fn new(machine: &'a Machine) -> Self {
        let ground =
            Node { name: GROUND.into(), mass_kg: f64::INFINITY, position_m: 0.0, velocity_m_per_s: 0.0 };
        let bodies = machine.bodies.iter().map(|(name, body)| Node {
            name: name.clone(),
            mass_kg: body.mass_kg,
            position_m: body.position_m,
            velocity_m_per_s: body.velocity_m_per_s,
        });
        let nodes: Vec<Node> = std::iter::once(ground).chain(bodies).collect();
        let names = std::iter::once(GROUND).chain(machine.bodies.keys().map(String::as_str));
        let node_of = names.enumerate().map(|(i, name)| (name, i)).collect();
        let assembly = Assembly {
            nodes,
            links: Vec::new(),
            contacts: Vec::new(),
            weights: Vec::new(),
            drives: Vec::new(),
            sensors: Vec::new(),
        };
        Self { machine, node_of, assembly, problems: Vec::new() }
    }

    /// The node of a body. A dangling name is recorded and gives ground, so that the rest of the file is
    /// still checked.
    fn node(&mut self, key: &str, name: &str) -> NodeId {
        if let Some(&node) = self.node_of.get(name) {
            return node;
        }
        let candidates = std::iter::once(GROUND).chain(self.machine.bodies.keys().map(String::as_str));
        self.problems.push(Problem::new(
            key,
            format!("there is no body `{name}`"),
            did_you_mean(name, candidates),
        ));
        GROUND_NODE
    }

    fn pair(&mut self, key: &str, between: &[String; 2]) -> (NodeId, NodeId) {
        let before = self.problems.len();
        let pair = (self.node(&format!("{key}.0"), &between[0]), self.node(&format!("{key}.1"), &between[1]));
        if pair.0 == pair.1 && self.problems.len() == before {
            self.problems.push(Problem::new(
                key,
                format!("both ends are `{}`", between[0]),
                "name two different bodies",
            ));
        }
        pair
    }

    fn weights(&mut self) {
        for (i, (name, body)) in self.machine.bodies.iter().enumerate() {
            if body.gravity_n == 0.0 {
                continue;
            }
            if self.machine.axis == Axis::Translational {
                self.problems.push(Problem::new(
                    Body::GRAVITY.of(name),
                    "gravity changes with the angle of a body, and this axis does not turn",
                    format!("set `axis = \"rotational\"`, or give the guide a `{}`", Kind::ConstantLoad),
                ));
            }
            self.assembly.weights.push(Weight {
                name: name.clone(),
                on: i + 1,
                reacts_on: GROUND_NODE,
                is_of_earth: true,
                course: PositionForce::Pull(Pull {
                    amplitude: body.gravity_n,
                    period: std::f64::consts::TAU,
                    phase: body.gravity_phase_rad,
                }),
            });
        }
    }

    fn links(&mut self) {
        for (name, spring) in &self.machine.springs {
            let (a, b) = self.pair(&Spring::BETWEEN.of(name), &spring.between);
            self.assembly.links.push(Link {
                rigid: spring.rigid,
                stiffness: spring.stiffness_n_per_m,
                damping: spring.damping_n_s_per_m,
                ..Link::between(name.clone(), a, b)
            });
        }
    }

    fn contacts(&mut self) {
        for (name, contact) in &self.machine.contacts {
            let (a, b) = self.pair(&Contact::BETWEEN.of(name), &contact.between);
            let law = force_law(contact);
            let profile = self.machine.profiles.get(name).cloned();
            let (engagement, gap) = (contact.engagement, contact.gap_m);
            self.assembly.contacts.push(ContactPart {
                name: name.clone(),
                a,
                b,
                engagement,
                gap,
                profile,
                law,
            });
        }
        for name in self.machine.profiles.keys().filter(|name| !self.machine.contacts.contains_key(*name)) {
            let remedy = did_you_mean(name, self.machine.contacts.keys().map(String::as_str));
            self.problems.push(Problem::new(
                Contact::place(name),
                format!("there is no contact `{name}` whose gap could move"),
                remedy,
            ));
        }
    }

    fn sensors(&mut self) {
        for (name, sensor) in &self.machine.sensors {
            let key = Sensor::READS.of(name);
            let Some(source) = self.source(&key, &sensor.reads) else { continue };
            let relative_to = match &sensor.relative_to {
                Some(body) => self.node(&Sensor::RELATIVE_TO.of(name), body),
                None => GROUND_NODE,
            };
            self.assembly.sensors.push(sensor_part(name, sensor, source, relative_to));
        }
    }

    fn source(&mut self, key: &str, signal: &SignalName) -> Option<Source> {
        match resolve(self.machine, signal) {
            Ok(Source::Sensor(_)) => {
                self.problems.push(Problem::new(
                    key,
                    "a sensor cannot read another sensor",
                    "name a body, contact, spring or actuator",
                ));
                None
            }
            Ok(Source::Contact(_, quantity)) if quantity.of_touch().is_some() => {
                let message = format!("a sensor cannot read `{signal}`, which follows from the feed alone");
                self.problems.push(Problem::new(key, message, "record it with `run.record`"));
                None
            }
            Ok(source) => Some(source),
            Err(problem) => {
                self.problems.push(Problem { key: key.into(), ..problem });
                None
            }
        }
    }

    fn effects(&mut self) {
        let machine = self.machine;
        let hosts = (machine
            .bodies
            .iter()
            .enumerate()
            .map(|(i, (n, e))| (Body::TABLE, n, Host::Body(i + 1), &e.effects)))
        .chain(
            machine
                .springs
                .iter()
                .enumerate()
                .map(|(i, (n, e))| (Spring::TABLE, n, Host::Spring(i), &e.effects)),
        )
        .chain(
            machine
                .contacts
                .iter()
                .enumerate()
                .map(|(i, (n, e))| (Contact::TABLE, n, Host::Contact(i), &e.effects)),
        )
        .chain(
            machine
                .actuators
                .iter()
                .enumerate()
                .map(|(i, (n, e))| (Actuator::TABLE, n, Host::Actuator(i), &e.effects)),
        )
        .chain(
            machine
                .sensors
                .iter()
                .enumerate()
                .map(|(i, (n, e))| (Sensor::TABLE, n, Host::Sensor(i), &e.effects)),
        );
        let mut uses: Vec<_> = hosts
            .flat_map(|(table, name, host, effects)| {
                // In the order of the library, so that the order in a file does not matter.
                let mut ordered: Vec<&EffectUse> = effects.iter().collect();
                ordered.sort_by_key(|effect| effect.definition.kind);
                ordered.into_iter().map(move |effect| (table, name, host, effect))
            })
            .collect();
        // Weights come first: a joint that becomes flexible takes along the weights that hang behind it.
        uses.sort_by_key(|(.., effect)| effect.definition.kind != Kind::Gravity);
        for (table, name, host, effect) in uses {
            self.effect(&format!("{table}.{name}.effects.{}", effect.definition.kind), host, effect);
        }
    }

    fn effect(&mut self, key: &str, host: Host, effect: &EffectUse) {
        if matches!(effect.definition.change, Change::SampleJitter(_)) {
            self.problems.push(Problem::new(
                key,
                "this effect disturbs a controller, not the plant",
                "move it under a controller",
            ));
        } else if let Err(error) = effect.definition.apply(&mut self.assembly, host, &effect.values) {
            self.problems.push(Problem::new(key, error.to_string(), error.remedy()));
        }
    }
}

fn force_law(contact: &Contact) -> ForceLaw {
    let alpha = match contact.law {
        ContactLaw::HuntCrossley { alpha_s_per_m, .. } => alpha_s_per_m,
        ContactLaw::KelvinVoigt | ContactLaw::Hertz => 0.0,
    };
    ForceLaw {
        stiffness: contact.stiffness,
        exponent: contact.law.exponent(),
        damping: contact.damping_n_s_per_m,
        alpha,
        cubic: 0.0,
    }
}

fn sensor_part(name: &str, sensor: &Sensor, source: Source, relative_to: NodeId) -> SensorPart {
    SensorPart {
        name: name.into(),
        source,
        relative_to,
        tool_inertia: (0.0, GROUND_NODE),
        gain: sensor.gain,
        bias: sensor.bias,
        filters: sensor.low_pass.into_iter().collect(),
        delay: sensor.delay_s,
        resolutions: sensor.resolution.into_iter().collect(),
        noise: sensor.noise,
    }
}
