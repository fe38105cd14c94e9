//! Units of mass, length and time are arbitrary: a machine in other units has the same motion.

use feeler_control::{Law, ReferenceSpec};
use feeler_engine::Scenario;
use feeler_plant::description::{ActuatorKind, ContactLaw, LowPass, Quantity};
use feeler_plant::effects::{EffectUse, Kind, LIBRARY};
use feeler_plant::units::Dimension;

use crate::common::{axis, run};

/// Scales are powers of two, so only the engine's own tolerances in seconds differ, and with them roundings
/// of instants.
const TOLERANCE: f64 = 1e-9;

/// New units per old unit: a value of dimension `kg^a m^b s^c` is multiplied by `mass^a length^b time^c`.
#[derive(Clone, Copy, Debug)]
struct Units {
    mass: f64,
    length: f64,
    time: f64,
}

impl Units {
    fn of(self, dimension: Dimension) -> f64 {
        self.mass.powf(dimension.mass) * self.length.powf(dimension.length) * self.time.powf(dimension.time)
    }

    /// Factor for the stiffness of a power law.
    fn power_stiffness(self, exponent: f64) -> f64 {
        self.of(Dimension::FORCE) / self.length.powf(exponent)
    }

    fn quantity(self, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::Position | Quantity::Compression | Quantity::Gap => self.of(Dimension::LENGTH),
            Quantity::Velocity | Quantity::GapRate => self.of(Dimension::VELOCITY),
            Quantity::Acceleration => self.of(Dimension::ACCELERATION),
            Quantity::Contact => 1.0,
            _ => self.of(Dimension::FORCE),
        }
    }

    fn scale_effect(self, used: &mut EffectUse) {
        let exponent =
            used.definition.parameters.iter().position(|p| p.name == "exponent").map(|i| used.values[i]);
        for (value, parameter) in used.values.iter_mut().zip(used.definition.parameters) {
            *value *= match exponent {
                Some(n) if parameter.dimension.any_length => self.power_stiffness(n),
                _ => self.of(parameter.dimension),
            };
        }
    }

    /// The same scenario in these units.
    fn scale(self, scenario: &Scenario) -> Scenario {
        let mut scaled = scenario.clone();
        let machine = &mut scaled.machine;
        for body in machine.bodies.values_mut() {
            body.mass_kg *= self.mass;
            body.position_m *= self.length;
            body.velocity_m_per_s *= self.of(Dimension::VELOCITY);
            body.effects.iter_mut().for_each(|used| self.scale_effect(used));
        }
        for spring in machine.springs.values_mut() {
            spring.stiffness_n_per_m *= self.of(Dimension::STIFFNESS);
            spring.damping_n_s_per_m *= self.of(Dimension::DAMPING);
            spring.effects.iter_mut().for_each(|used| self.scale_effect(used));
        }
        for contact in machine.contacts.values_mut() {
            let exponent = match &mut contact.law {
                ContactLaw::KelvinVoigt => 1.0,
                ContactLaw::Hertz => 1.5,
                ContactLaw::HuntCrossley { alpha_s_per_m, exponent } => {
                    *alpha_s_per_m *= self.of(Dimension::INVERSE_VELOCITY);
                    *exponent
                }
            };
            contact.stiffness *= self.power_stiffness(exponent);
            contact.damping_n_s_per_m *= self.of(Dimension::DAMPING);
            contact.gap_m *= self.length;
            contact.effects.iter_mut().for_each(|used| self.scale_effect(used));
        }
        for actuator in machine.actuators.values_mut() {
            assert!(matches!(actuator.kind, ActuatorKind::Force { bandwidth_hz: None }));
            actuator.effects.iter_mut().for_each(|used| self.scale_effect(used));
        }
        for sensor in machine.sensors.values_mut() {
            if let Some(LowPass::FirstOrder { corner_hz } | LowPass::SecondOrder { corner_hz, .. }) =
                &mut sensor.low_pass
            {
                *corner_hz /= self.time;
            }
            sensor.delay_s *= self.time;
            sensor.effects.iter_mut().for_each(|used| self.scale_effect(used));
        }
        for control in scaled.controllers.values_mut() {
            let (Law::ExplicitForce(gains), ReferenceSpec::Constant(force)) =
                (&mut control.spec.law, &mut control.spec.reference)
            else {
                unreachable!("the axis has an explicit force loop with a constant reference");
            };
            gains.damping *= self.of(Dimension::DAMPING);
            *force *= self.of(Dimension::FORCE);
            control.spec.period_s *= self.time;
            control.spec.delay_s *= self.time;
            control.effects.iter_mut().for_each(|used| self.scale_effect(used));
        }
        scaled.run.duration_s *= self.time;
        scaled.run.step_s *= self.time;
        scaled
    }
}

fn moves_the_same(what: &str, scenario: &Scenario, units: Units) {
    let ((trace, _), (scaled, _)) = (run(scenario), run(&units.scale(scenario)));
    assert_eq!(trace.events.len(), scaled.events.len(), "{what}, {units:?}");
    for (event, other) in trace.events.iter().zip(&scaled.events) {
        assert_eq!((event.kind, event.switch), (other.kind, other.switch), "{what}");
        let late = other.t_s / units.time - event.t_s;
        assert!(late.abs() < TOLERANCE, "{what}, {units:?}: {:?} {late:e} s late", event.kind);
    }
    for (name, signal) in trace.names.iter().zip(&scenario.run.record) {
        let factor = units.quantity(if name == "force.reading" { Quantity::Force } else { signal.quantity });
        let (values, others) = (trace.column(name).unwrap(), scaled.column(name).unwrap());
        let size = values.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        for (t, (value, other)) in trace.t_s.iter().zip(values.iter().zip(others)) {
            let off = (other / factor - value).abs();
            assert!(off <= TOLERANCE * size, "{what}, {units:?}: {name} at {t} s is {off:e} of {size:e} off");
        }
    }
}

const UNITS: [Units; 4] = [
    Units { mass: 8.0, length: 1.0, time: 1.0 },
    Units { mass: 1.0, length: 0.25, time: 1.0 },
    Units { mass: 1.0, length: 1.0, time: 4.0 },
    Units { mass: 0.5, length: 16.0, time: 0.5 },
];

#[test]
fn prop_units_are_free_for_every_contact_law() {
    for (law, stiffness) in [
        (ContactLaw::KelvinVoigt, 2e5),
        (ContactLaw::Hertz, 2e7),
        (ContactLaw::HuntCrossley { alpha_s_per_m: 3.0, exponent: 1.5 }, 2e7),
    ] {
        let mut scenario = axis(0.1);
        scenario.machine.contacts["tool"].law = law;
        scenario.machine.contacts["tool"].stiffness = stiffness;
        for units in UNITS {
            moves_the_same(&format!("{law:?}"), &scenario, units);
        }
    }
}

#[test]
fn prop_units_are_free_for_every_effect() {
    for definition in LIBRARY {
        let values = definition.parameters.iter().map(|parameter| parameter.typical).collect();
        let used = EffectUse { definition, values };
        let mut scenario = axis(0.1);
        let machine = &mut scenario.machine;
        let on_guide = matches!(definition.place.name(), "guide" | "base");
        match definition.place.name() {
            // Random instants are shares of the period, which scale.
            "timing" => scenario.controllers["force"].effects.push(used),
            "drive" => machine.actuators["drive"].effects.push(used),
            "force-sensor" => machine.sensors["force"].effects.push(used),
            "encoder" => machine.sensors["encoder"].effects.push(used),
            "contact" | "workpiece" => machine.contacts["tool"].effects.push(used),
            _ if definition.kind == Kind::AddedMass => machine.bodies["tip"].effects.push(used),
            _ => machine.springs[if on_guide { "guide" } else { "transmission" }].effects.push(used),
        }
        // Noise is a function of the clock in seconds: another unit of time draws other numbers.
        let kept =
            |units: &Units| definition.kind != Kind::CommandNoise || units.time.to_bits() == 1_f64.to_bits();
        for units in UNITS.into_iter().filter(kept) {
            moves_the_same(definition.name, &scenario, units);
        }
    }
}
