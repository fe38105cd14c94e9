//! Bodies, springs, contacts, actuators, sensors.

use feeler_plant::description::{
    Actuator, ActuatorKind, Contact, ContactLaw, Engagement, GROUND, Knot, LowPass, Machine, Profile, Sensor,
};

use super::{Writer, number};

/// The name of an engagement in files.
pub(crate) fn engagement(engagement: Engagement) -> &'static str {
    match engagement {
        Engagement::Clamped => "clamped",
        Engagement::Unilateral => "unilateral",
        Engagement::Free => "free",
    }
}

/// A corner frequency, or a table with the damping ratio.
pub(super) fn low_pass(corner_hz: f64, damping_ratio: Option<f64>) -> String {
    match damping_ratio {
        None => format!("{{ corner = {} }}", number(corner_hz)),
        Some(ratio) => format!("{{ corner = {}, damping_ratio = {} }}", number(corner_hz), number(ratio)),
    }
}

impl Writer {
    pub(super) fn elements(&mut self, machine: &Machine) {
        for (name, body) in &machine.bodies {
            self.header(&["bodies", name]);
            self.number("mass", body.mass_kg);
            self.unless("position", body.position_m, 0.0);
            self.unless("velocity", body.velocity_m_per_s, 0.0);
            self.effects("bodies", name, &body.effects);
        }
        for (name, spring) in &machine.springs {
            self.header(&["springs", name]);
            self.pair("between", &spring.between);
            self.unless("stiffness", spring.stiffness_n_per_m, 0.0);
            self.unless("damping", spring.damping_n_s_per_m, 0.0);
            if spring.rigid {
                self.line("rigid", "true");
            }
            self.effects("springs", name, &spring.effects);
        }
        for (name, contact) in &machine.contacts {
            self.contact(name, contact, machine.profiles.get(name).map(|profile| &**profile));
        }
        for (name, actuator) in &machine.actuators {
            self.actuator(name, actuator);
        }
        for (name, sensor) in &machine.sensors {
            self.sensor(name, sensor);
        }
    }

    fn contact(&mut self, name: &str, contact: &Contact, profile: Option<&Profile>) {
        self.header(&["contacts", name]);
        self.pair("between", &contact.between);
        self.words("engagement", engagement(contact.engagement));
        match contact.law {
            ContactLaw::KelvinVoigt => self.words("law", "kelvin-voigt"),
            ContactLaw::Hertz => self.words("law", "hertz"),
            ContactLaw::HuntCrossley { alpha_s_per_m, exponent } => {
                self.words("law", "hunt-crossley");
                self.number("alpha", alpha_s_per_m);
                self.unless("exponent", exponent, 1.0);
            }
        }
        self.number("stiffness", contact.stiffness);
        self.unless("damping", contact.damping_n_s_per_m, 0.0);
        self.unless("gap", contact.gap_m, 0.0);
        if let Some(profile) = profile {
            let points = |value: fn(&Knot) -> f64| {
                let pairs = profile
                    .knots()
                    .iter()
                    .map(|knot| format!("[{}, {}]", number(knot.t_s), number(value(knot))));
                format!("[{}]", pairs.collect::<Vec<_>>().join(", "))
            };
            let (offset, rate) = (points(|knot| knot.offset_m), points(|knot| knot.rate_m_per_s));
            self.header(&["contacts", name, "profile"]);
            self.line("offset", offset);
            self.line("rate", rate);
        }
        self.effects("contacts", name, &contact.effects);
    }

    fn actuator(&mut self, name: &str, actuator: &Actuator) {
        self.header(&["actuators", name]);
        self.words("on", &actuator.on);
        if actuator.reacts_on != GROUND {
            self.words("reacts_on", &actuator.reacts_on);
        }
        match actuator.kind {
            ActuatorKind::Force { bandwidth_hz } => {
                self.words("kind", "force");
                self.optional("bandwidth", bandwidth_hz);
            }
            ActuatorKind::VelocitySource { damping_n_s_per_m, time_constant_s } => {
                self.words("kind", "velocity-source");
                self.number("damping", damping_n_s_per_m);
                self.number("time_constant", time_constant_s);
            }
        }
        self.optional("limit", actuator.limit_n);
        self.optional("rate_limit", actuator.rate_limit_per_s);
        self.effects("actuators", name, &actuator.effects);
    }

    fn sensor(&mut self, name: &str, sensor: &Sensor) {
        self.header(&["sensors", name]);
        self.words("reads", &sensor.reads.to_string());
        if let Some(body) = &sensor.relative_to {
            self.words("relative_to", body);
        }
        self.unless("gain", sensor.gain, 1.0);
        self.unless("bias", sensor.bias, 0.0);
        match sensor.low_pass {
            None => {}
            Some(LowPass::FirstOrder { corner_hz }) => self.line("low_pass", low_pass(corner_hz, None)),
            Some(LowPass::SecondOrder { corner_hz, damping_ratio }) => {
                self.line("low_pass", low_pass(corner_hz, Some(damping_ratio)))
            }
        }
        self.unless("delay", sensor.delay_s, 0.0);
        self.optional("resolution", sensor.resolution);
        self.unless("noise", sensor.noise, 0.0);
        self.effects("sensors", name, &sensor.effects);
    }
}
