//! The changes of remedies, each by a factor or share.

use feeler_control::{AntiWindup, ForceGains, Law, LeadSpec, PositionGains};
use feeler_engine::Scenario;
use feeler_plant::description::{ActuatorKind, LowPass, MotorInput};
use feeler_plant::effects::{ActuatorLag, Definition, EffectUse, Trait};

use super::change::servos;
pub(super) fn shorten_delays(scenario: &mut Scenario, times: f64) {
    for used in scenario.controllers.values_mut() {
        used.spec.delay_s /= times;
        used.spec.velocity_filter_s /= times;
        if let Some(filter) = &mut used.spec.reading_low_pass {
            filter.cutoff_hz *= times;
        }
    }
    for sensor in scenario.machine.sensors.values_mut() {
        sensor.delay_s /= times;
        if let Some(LowPass::FirstOrder { corner_hz } | LowPass::SecondOrder { corner_hz, .. }) =
            &mut sensor.low_pass
        {
            *corner_hz *= times;
        }
    }
    for servo in servos(scenario) {
        (servo.delay_s, servo.compute_delay_s) = (servo.delay_s / times, servo.compute_delay_s / times);
    }
    fade(scenario, times, |effect| effect.has(Trait::Delay));
}

pub(super) fn quicken_drives(scenario: &mut Scenario, times: f64) {
    for actuator in scenario.machine.actuators.values_mut() {
        match &mut actuator.kind {
            ActuatorKind::Force { bandwidth_hz } => {
                *bandwidth_hz = bandwidth_hz.map(|bandwidth| bandwidth * times);
            }
            ActuatorKind::VelocitySource { time_constant_s, .. } => *time_constant_s /= times,
            ActuatorKind::DcMotor(motor) => motor.inductance_h /= times,
            ActuatorKind::PositionServo(servo) => {
                servo.delay_s /= times;
            }
            ActuatorKind::Imposed | ActuatorKind::TargetVelocity | ActuatorKind::FeedForward => {}
        }
        for effect in &mut actuator.effects {
            if let Some(ActuatorLag { time_constant }) = effect.parameters() {
                *effect = EffectUse::of(ActuatorLag { time_constant: time_constant / times });
            }
        }
    }
}

pub(super) fn raise_limits(scenario: &mut Scenario, times: f64) {
    for actuator in scenario.machine.actuators.values_mut() {
        let limits = [&mut actuator.limit_n, &mut actuator.rate_limit_per_s];
        limits.into_iter().flatten().for_each(|limit| *limit *= times);
        let own = match &mut actuator.kind {
            ActuatorKind::PositionServo(servo) => vec![&mut servo.velocity_limit_m_per_s],
            ActuatorKind::DcMotor(motor) if motor.input == MotorInput::Duty => {
                vec![&mut motor.current_limit_a]
            }
            ActuatorKind::DcMotor(motor) => {
                vec![&mut motor.current_limit_a, &mut motor.supply_voltage_v]
            }
            _ => Vec::new(),
        };
        own.into_iter().flatten().for_each(|limit| *limit *= times);
    }
    for used in scenario.controllers.values_mut() {
        used.spec.output_limit = used.spec.output_limit.map(|limit| limit * times);
    }
    fade(scenario, times, |effect| effect.has(Trait::Saturation));
}

/// Tells controllers the limit of the force drive that they command, and stops their integral there.
pub(super) fn stop_windup(scenario: &mut Scenario) {
    for used in scenario.controllers.values_mut() {
        let drive = scenario.machine.actuators.get(&used.drives);
        let force = drive.filter(|drive| matches!(drive.kind, ActuatorKind::Force { .. }));
        let (
            Some(limit_n),
            Law::ExplicitForce(ForceGains { anti_windup, .. })
            | Law::Position(PositionGains { anti_windup, .. }),
        ) = (force.and_then(|drive| drive.limit_n), &mut used.spec.law)
        else {
            continue;
        };
        if *anti_windup == AntiWindup::Off {
            *anti_windup = AntiWindup::Conditional;
        }
        used.spec.output_limit = Some(used.spec.output_limit.map_or(limit_n, |limit| limit.min(limit_n)));
    }
}

pub(super) fn refine_steps(scenario: &mut Scenario, times: f64) {
    for sensor in scenario.machine.sensors.values_mut() {
        sensor.resolution = sensor.resolution.map(|step| step / times);
    }
    for used in scenario.controllers.values_mut() {
        used.spec.output_resolution = used.spec.output_resolution.map(|step| step / times);
    }
    for servo in servos(scenario) {
        for step in [&mut servo.resolution_m, &mut servo.output_resolution_n].into_iter().flatten() {
            *step /= times;
        }
    }
    fade(scenario, times, |effect| effect.has(Trait::Quantisation));
}

/// Reduces the effects of a kind by a factor.
pub(super) fn fade(scenario: &mut Scenario, times: f64, is_meant: impl Fn(&Definition) -> bool) {
    let machine = &mut scenario.machine;
    let hosts = (machine.bodies.values_mut().map(|body| &mut body.effects))
        .chain(machine.springs.values_mut().map(|spring| &mut spring.effects))
        .chain(machine.contacts.values_mut().map(|contact| &mut contact.effects))
        .chain(machine.actuators.values_mut().map(|actuator| &mut actuator.effects))
        .chain(machine.sensors.values_mut().map(|sensor| &mut sensor.effects))
        .chain(scenario.controllers.values_mut().map(|used| &mut used.effects));
    for effect in hosts.flatten().filter(|effect| is_meant(effect.definition)) {
        for (parameter, value) in effect.definition.parameters.iter().zip(&mut effect.values) {
            match parameter.null {
                Some(null) if null.is_finite() => *value = null + (*value - null) / times,
                Some(_) => *value *= times,
                None => {}
            }
        }
    }
}

pub(super) fn scale_springs(scenario: &mut Scenario, names: &[String], stiffness: f64, damping: f64) {
    for name in names {
        if let Some(spring) = scenario.machine.springs.get_mut(name) {
            spring.stiffness_n_per_m *= stiffness;
            spring.damping_n_s_per_m *= damping;
        }
    }
}

/// Damping of `2 m w` times a share, if the loop reads the motion of its own drive.
pub(super) fn add_damping(scenario: &mut Scenario, share: f64) {
    let stiffness = scenario.machine.contacts.values().map(|contact| contact.stiffness).fold(0.0, f64::max);
    let mass: f64 = scenario
        .machine
        .actuators
        .values()
        .filter_map(|a| scenario.machine.bodies.get(&a.on))
        .map(|body| body.mass_kg)
        .sum();
    let sensed = scenario
        .machine
        .sensors
        .values()
        .any(|sensor| scenario.machine.actuators.values().any(|a| a.on == sensor.reads.element));
    for used in scenario.controllers.values_mut() {
        if let Law::ExplicitForce(gains) = &mut used.spec.law
            && sensed
        {
            gains.damping += 2.0 * share * (mass * stiffness).sqrt();
        }
    }
}

pub(super) fn add_lead(scenario: &mut Scenario, zero_hz: f64, times: f64) {
    for used in scenario.controllers.values_mut() {
        if let Law::ExplicitForce(gains) = &mut used.spec.law {
            gains.lead.get_or_insert(LeadSpec { zero_hz, pole_hz: times * zero_hz });
        }
    }
}
