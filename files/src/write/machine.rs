//! Bodies, springs, contacts, actuators, sensors.

use feeler_catalogue::{Content, Keyed};
use feeler_plant::description::{Contact, Elements, Knot, Machine, Profile};
use feeler_plant::effects::EffectUse;

use super::{Writer, inline};
use crate::keys::surface::{OFFSET, PROFILE, RATE};
use crate::keys::{ACTUATORS, BODIES, CONTACTS, Element, SENSORS, SPRINGS};

impl Writer {
    pub(super) fn elements(&mut self, machine: &Machine) {
        self.each(&BODIES, &machine.bodies, |body| &body.effects);
        self.each(&SPRINGS, &machine.springs, |spring| &spring.effects);
        for (name, contact) in &machine.contacts {
            self.contact(name, contact, machine.profiles.get(name).map(|profile| &**profile));
        }
        self.each(&ACTUATORS, &machine.actuators, |actuator| &actuator.effects);
        self.each(&SENSORS, &machine.sensors, |sensor| &sensor.effects);
    }

    fn each<T: Keyed>(
        &mut self,
        element: &Element,
        elements: &Elements<T>,
        effects: impl Fn(&T) -> &Vec<EffectUse>,
    ) {
        for (name, one) in elements {
            self.header(&[element.table, name]);
            self.form(element, one);
            self.record(one);
            self.effects(element.table, name, effects(one));
        }
    }

    fn contact(&mut self, name: &str, contact: &Contact, profile: Option<&Profile>) {
        let table = CONTACTS.table;
        self.header(&[table, name]);
        self.form(&CONTACTS, contact);
        self.record(contact);
        if let Some(profile) = profile {
            let points = |value: fn(&Knot) -> f64| {
                inline(&Content::Points(profile.knots().iter().map(|knot| (knot.t_s, value(knot))).collect()))
            };
            let (offset, rate) = (points(|knot| knot.offset_m), points(|knot| knot.rate_m_per_s));
            self.header(&[table, name, PROFILE.name]);
            self.line(OFFSET.name, offset);
            self.line(RATE.name, rate);
        }
        self.effects(table, name, &contact.effects);
    }
}
