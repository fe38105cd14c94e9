//! Bodies, springs, contacts, actuators, sensors.

use std::sync::Arc;

use feeler_catalogue::{Bound, Content, Dimension, KeyRole, Keyed, LAW};
use feeler_plant::description::{
    Actuator, Body, Contact, ContactLaw, Machine, MotorInput, Profile, Quantity, Sensor, SignalName, Spring,
};
use feeler_plant::effects::HostKind;

use super::{Builder, Item};
use crate::keys::{ACTUATORS, BODIES, CONTACTS, KIND, SENSORS, SPRINGS};
use crate::read::{Reader, Scope};
use crate::tree::node_at;

impl Builder<'_> {
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
            let top = self.draft.top();
            self.problems.add(&top, BODIES.table, "there is no body", "add [bodies.NAME] with a mass");
        }
        machine
    }

    fn body(&mut self, item: Item<'_>) -> Option<Body> {
        let fields = self.fields(item, self.scope());
        Some(Body { effects: self.effects(item, HostKind::Body), ..Body::read(&fields)? })
    }

    fn spring(&mut self, item: Item<'_>) -> Option<Spring> {
        let fields = self.fields(item, self.scope());
        let mut spring = Spring::read(&fields)?;
        let host = if spring.rigid { HostKind::RigidSpring } else { HostKind::Spring };
        if spring.rigid {
            // `rigid` overrides values from another file or a setting. In the same file it contradicts them.
            let here = item.table.get(Spring::RIGID.key.name).map(|entry| entry.node.origin.source);
            for field in Spring::FIELDS.iter().filter(|field| field.role == KeyRole::Believed) {
                let key = field.key.name;
                let written = item.table.get(key).filter(|entry| Some(entry.node.origin.source) == here);
                if let Some(entry) = written.filter(|_| field.number(&spring) != Some(0.0)) {
                    let message = format!("a rigid joint has no {key}");
                    let remedy =
                        format!("remove it, or leave out `{}` to have a spring", Spring::RIGID.key.name);
                    self.problems.add(&entry.node.origin, item.key(key), message, remedy);
                }
                field.set_number(&mut spring, 0.0);
            }
        }
        spring.effects = self.effects(item, host);
        Some(spring)
    }

    fn contact(&mut self, item: Item<'_>) -> Option<(Contact, Option<Arc<Profile>>)> {
        let law = item.table.get(LAW).and_then(|entry| entry.node.as_text());
        let mut unread: Contact = of_form(law);
        if let Some(entry) = item.table.get(Contact::EXPONENT.key.name) {
            Contact::EXPONENT.set_number(&mut unread, self.quietly(&entry.node));
        }
        let before = self.problems.count();
        let fields = self.fields(item, Scope { exponent: unread.law.exponent(), ..self.scope() });
        let sound = self.problems.count() == before;
        let mut contact = Contact::read(&fields)?;
        let damping = Contact::DAMPING.key.name;
        if matches!(contact.law, ContactLaw::HuntCrossley { .. })
            && item.table.contains_key(damping)
            && contact.damping_n_s_per_m != 0.0
        {
            let message = "the Hunt-Crossley law has no linear damping: its damping is alpha";
            self.problems.add(item.place(damping), item.key(damping), message, "remove it");
        }
        if let Some(stiffness) = self.stiffness_of_materials(item, &fields, contact.law) {
            contact.stiffness = stiffness;
        }
        contact.effects = self.effects(item, HostKind::Contact);
        Some((contact, self.gap(item, &fields, sound)))
    }

    /// A pure number whose mistakes are recorded elsewhere.
    fn quietly(&self, node: &crate::tree::Node) -> f64 {
        let mut unheard = crate::problem::Problems::default();
        let mut reader = Reader { problems: &mut unheard, scope: self.scope() };
        reader.quantity_of(node, Dimension::NONE, Bound::Any, "").unwrap_or(1.0)
    }

    fn actuator(&mut self, item: Item<'_>) -> Option<Actuator> {
        let fields = self.fields(item, self.scope());
        let actuator = Actuator::read(&fields)?;
        if actuator.on == actuator.reacts_on {
            let body = &actuator.on;
            let message =
                format!("it pushes `{body}` and carries its reaction there too: it can move nothing");
            let [on, reacts_on] = [Actuator::ON, Actuator::REACTS_ON].map(|field| field.key.name);
            let key = if item.table.contains_key(reacts_on) { reacts_on } else { on };
            self.problems.add(item.place(key), item.key(key), message, "name two different bodies");
        }
        let command = actuator.kind.command();
        Some(Actuator { effects: self.effects_on(item, HostKind::Actuator, command), ..actuator })
    }

    fn sensor(&mut self, item: Item<'_>) -> Option<Sensor> {
        let reads = item.table.get(Sensor::READS.key.name).and_then(|entry| entry.node.as_text());
        let signal = reads.and_then(|text| text.parse().ok());
        let dim = signal.as_ref().map_or(Dimension::UNKNOWN, |signal| self.signal_dim(signal));
        let fields = self.fields(item, Scope { signal: dim, ..self.scope() });
        let sensor = Sensor::read(&fields)?;
        let reads = &sensor.reads;
        let motion =
            matches!(reads.quantity, Quantity::Position | Quantity::Velocity | Quantity::Acceleration);
        let relative_to = Sensor::RELATIVE_TO.key.name;
        if !motion && item.table.contains_key(relative_to) {
            let message = format!("`{reads}` is not relative to a body");
            self.problems.add(item.place(relative_to), item.key(relative_to), message, "remove it");
        }
        let host = match reads.quantity {
            quantity if quantity.is_force() => HostKind::ForceSensor,
            Quantity::Position
            | Quantity::Velocity
            | Quantity::Acceleration
            | Quantity::Compression
            | Quantity::Gap
            | Quantity::GapRate => HostKind::MotionSensor,
            _ => HostKind::OtherSensor,
        };
        Some(Sensor { effects: self.effects(item, host), ..sensor })
    }

    pub(super) fn signal_dim(&self, signal: &SignalName) -> Dimension {
        match signal.quantity {
            Quantity::Command => self.command_dim(&signal.element),
            quantity => quantity.dimension().unwrap_or(Dimension::NONE),
        }
    }

    /// Dimension of a signal; for a reading, that of the signal that the sensor reads.
    pub(crate) fn measured_dim(&self, signal: &SignalName) -> Dimension {
        let path = [SENSORS.table, &signal.element, Sensor::READS.key.name];
        let read = node_at(&self.draft.root, &path).and_then(|node| node.as_text());
        match read.and_then(|text| text.parse().ok()) {
            Some(read) if signal.quantity == Quantity::Reading => self.signal_dim(&read),
            _ => self.signal_dim(signal),
        }
    }

    /// Dimension of an actuator's command.
    pub(super) fn command_dim(&self, actuator: &str) -> Dimension {
        let kind =
            node_at(&self.draft.root, &[ACTUATORS.table, actuator, KIND]).and_then(|node| node.as_text());
        let mut found: Actuator = of_form(kind);
        let input = Actuator::MOTOR_INPUT;
        let node = node_at(&self.draft.root, &[ACTUATORS.table, actuator, input.key.name]);
        if let Some(word) = node.and_then(|node| MotorInput::named(node.as_text()?)) {
            (input.set)(&mut found, &Content::Word(word.name()));
        }
        found.kind.command()
    }
}

/// The value of a table of this form before its keys are read; of the first form if `name` is not a form.
fn of_form<T: Keyed>(name: Option<&str>) -> T {
    let named = T::FORMS.iter().find(|form| Some(form.name) == name);
    (named.unwrap_or(&T::FORMS[0]).start)()
}
