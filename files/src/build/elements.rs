//! Bodies, springs, contacts, actuators, sensors.

use std::sync::Arc;

use feeler_catalogue::{Bound, Contents, Dim};
use feeler_plant::description::{
    Actuator, ActuatorKind, Body, Contact, ContactLaw, Engagement, GROUND, LowPass, Machine, Profile,
    Quantity, Sensor, SignalName, Spring,
};
use feeler_plant::effects::HostKind;
use feeler_plant::units::Dimension;

use super::{Builder, Item};
use crate::document::node_at;
use crate::keys::{ACTUATORS, BODIES, CONTACTS, SENSORS, SPRINGS};
use crate::read::{Reader, Scope};

impl Builder<'_> {
    /// The machine, unnamed.
    pub(crate) fn machine(&mut self) -> Machine {
        let contacts = self.each(&CONTACTS, Self::contact);
        let mut machine = Machine {
            axis: self.axis,
            bodies: self.each(&BODIES, Self::body),
            springs: self.each(&SPRINGS, Self::spring),
            actuators: self.each(&ACTUATORS, Self::actuator),
            sensors: self.each(&SENSORS, Self::sensor),
            ..Machine::default()
        };
        self.gaps(&mut machine, contacts);
        if !self.draft.root.contains_key(BODIES.table) {
            let top = crate::source::Origin { source: self.draft.main, span: 0..0 };
            self.problems.add(&top, BODIES.table, "there is no body", "add [bodies.NAME] with a mass");
        }
        machine
    }

    fn body(&mut self, item: Item<'_>) -> Body {
        let fields = self.fields(item, self.scope());
        Body {
            mass_kg: fields.number("mass"),
            position_m: fields.number("position"),
            velocity_m_per_s: fields.number("velocity"),
            effects: self.effects(item, HostKind::Body),
        }
    }

    fn spring(&mut self, item: Item<'_>) -> Spring {
        let fields = self.fields(item, self.scope());
        let rigid = fields.flag("rigid");
        // What another file gives or a setting leaves behind is put out of force by `rigid`; written together
        // they contradict.
        let here = item.table.get("rigid").map(|entry| entry.node.origin.source);
        for key in ["stiffness", "damping"] {
            let written = item
                .table
                .get(key)
                .filter(|entry| Some(entry.node.origin.source) == here && fields.number(key) != 0.0);
            if let Some(entry) = written.filter(|_| rigid) {
                let message = format!("a rigid joint has no {key}");
                self.problems.add(
                    &entry.node.origin,
                    item.key(key),
                    message,
                    "remove it, or leave out `rigid` to have a spring",
                );
            }
        }
        let of_spring = |key| if rigid { 0.0 } else { fields.number(key) };
        Spring {
            between: fields.pair("between"),
            stiffness_n_per_m: of_spring("stiffness"),
            damping_n_s_per_m: of_spring("damping"),
            rigid,
            effects: self.effects(item, if rigid { HostKind::RigidSpring } else { HostKind::Spring }),
        }
    }

    fn contact(&mut self, item: Item<'_>) -> (Contact, Option<Arc<Profile>>) {
        let exponent = match item.table.get("law").and_then(|entry| entry.node.as_text()) {
            Some("hertz") => 1.5,
            Some("hunt-crossley") => {
                item.table.get("exponent").map_or(1.0, |entry| self.quietly(&entry.node))
            }
            _ => 1.0,
        };
        let before = self.problems.count();
        let fields = self.fields(item, Scope { exponent, ..self.scope() });
        let sound = self.problems.count() == before;
        let law = match fields.variant {
            Some("hunt-crossley") => ContactLaw::HuntCrossley {
                alpha_s_per_m: fields.number("alpha"),
                exponent: fields.number("exponent"),
            },
            Some("hertz") => ContactLaw::Hertz,
            _ => ContactLaw::KelvinVoigt,
        };
        if matches!(law, ContactLaw::HuntCrossley { .. })
            && item.table.contains_key("damping")
            && fields.number("damping") != 0.0
        {
            let message = "the Hunt-Crossley law has no linear damping: its damping is alpha";
            self.problems.add(item.place("damping"), item.key("damping"), message, "remove it");
        }
        let stiffness = fields
            .optional("stiffness")
            .or_else(|| self.stiffness_of_materials(item, &fields, law))
            .unwrap_or(1.0);
        let contact = Contact {
            between: fields.pair("between"),
            engagement: engagement(&fields).unwrap_or_default(),
            law,
            stiffness,
            damping_n_s_per_m: fields.number("damping"),
            gap_m: fields.number("gap"),
            effects: self.effects(item, HostKind::Contact),
        };
        (contact, self.gap(item, &fields, sound))
    }

    /// A pure number whose mistakes are noted elsewhere.
    fn quietly(&self, node: &crate::tree::Node) -> f64 {
        let mut unheard = crate::problem::Problems::default();
        let mut reader = Reader { problems: &mut unheard, scope: self.scope() };
        reader.quantity_of(node, Dimension::NONE.into(), Bound::Any, "").unwrap_or(1.0)
    }

    fn actuator(&mut self, item: Item<'_>) -> Actuator {
        let fields = self.fields(item, self.scope());
        let kind = match fields.variant {
            Some("velocity-source") => ActuatorKind::VelocitySource {
                damping_n_s_per_m: fields.number("damping"),
                time_constant_s: fields.number("time_constant"),
            },
            _ => ActuatorKind::Force { bandwidth_hz: fields.optional("bandwidth") },
        };
        if let Some(body) = fields.text("on").filter(|body| fields.text("reacts_on") == Some(body)) {
            let message =
                format!("it pushes `{body}` and carries its reaction there too: it can move nothing");
            let key = if item.table.contains_key("reacts_on") { "reacts_on" } else { "on" };
            self.problems.add(item.place(key), item.key(key), message, "name two different bodies");
        }
        Actuator {
            on: fields.text("on").unwrap_or(GROUND).into(),
            reacts_on: fields.text("reacts_on").unwrap_or(GROUND).into(),
            kind,
            limit_n: fields.optional("limit"),
            rate_limit_per_s: fields.optional("rate_limit"),
            effects: self.effects(item, HostKind::Actuator),
        }
    }

    fn sensor(&mut self, item: Item<'_>) -> Sensor {
        let signal =
            item.table.get("reads").and_then(|entry| entry.node.as_text()).and_then(|text| text.parse().ok());
        let dim = signal.as_ref().map_or(Dim::UNKNOWN, |signal| self.signal_dim(signal));
        let fields = self.fields(item, Scope { signal: dim, ..self.scope() });
        let reads = signal.unwrap_or_else(|| SignalName::new("", Quantity::Position));
        let motion =
            matches!(reads.quantity, Quantity::Position | Quantity::Velocity | Quantity::Acceleration);
        if !motion && item.table.contains_key("relative_to") {
            let message = format!("`{reads}` is not relative to a body");
            self.problems.add(item.place("relative_to"), item.key("relative_to"), message, "remove it");
        }
        let host = match reads.quantity {
            Quantity::Force | Quantity::SpringForce => HostKind::ForceSensor,
            Quantity::Position
            | Quantity::Velocity
            | Quantity::Acceleration
            | Quantity::Compression
            | Quantity::Gap
            | Quantity::GapRate => HostKind::MotionSensor,
            _ => HostKind::OtherSensor,
        };
        Sensor {
            reads,
            relative_to: fields.text("relative_to").map(str::to_owned),
            gain: fields.number("gain"),
            bias: fields.number("bias"),
            low_pass: fields.table("low_pass").map(low_pass),
            delay_s: fields.number("delay"),
            resolution: fields.optional("resolution"),
            noise: fields.number("noise"),
            effects: self.effects(item, host),
        }
    }

    /// Dimension of a signal of the plant.
    pub(super) fn signal_dim(&self, signal: &SignalName) -> Dim {
        match signal.quantity {
            Quantity::Position
            | Quantity::Compression
            | Quantity::Gap
            | Quantity::PointX
            | Quantity::PointY
            | Quantity::PointZ => Dimension::LENGTH.into(),
            Quantity::Velocity | Quantity::GapRate => Dimension::VELOCITY.into(),
            Quantity::Acceleration => Dimension::ACCELERATION.into(),
            Quantity::Force | Quantity::SpringForce => Dimension::FORCE.into(),
            Quantity::Command => self.command_dim(&signal.element),
            Quantity::Contact
            | Quantity::NormalX
            | Quantity::NormalY
            | Quantity::NormalZ
            | Quantity::Reading
            | Quantity::Output
            | Quantity::Reference => Dimension::NONE.into(),
        }
    }

    /// Dimension of a signal; that of a reading is that of what the sensor reads.
    pub(crate) fn measured_dim(&self, signal: &SignalName) -> Dim {
        let read = node_at(&self.draft.root, &[SENSORS.table, &signal.element, "reads"])
            .and_then(|node| node.as_text());
        match read.and_then(|text| text.parse().ok()) {
            Some(read) if signal.quantity == Quantity::Reading => self.signal_dim(&read),
            _ => self.signal_dim(signal),
        }
    }

    /// Dimension of an actuator's command.
    pub(super) fn command_dim(&self, actuator: &str) -> Dim {
        let kind =
            node_at(&self.draft.root, &[ACTUATORS.table, actuator, "kind"]).and_then(|node| node.as_text());
        if kind == Some("velocity-source") { Dimension::VELOCITY.into() } else { Dimension::FORCE.into() }
    }
}

/// The engagement that fields name.
pub(crate) fn engagement(fields: &Contents) -> Option<Engagement> {
    match fields.text("engagement")? {
        "clamped" => Some(Engagement::Clamped),
        "free" => Some(Engagement::Free),
        _ => Some(Engagement::Unilateral),
    }
}

fn low_pass(fields: &Contents) -> LowPass {
    let corner_hz = fields.number("corner");
    match fields.optional("damping_ratio") {
        Some(damping_ratio) => LowPass::SecondOrder { corner_hz, damping_ratio },
        None => LowPass::FirstOrder { corner_hz },
    }
}
