//! Responses from the commands of servos, motors and imposed motions.

use std::f64::consts::TAU;

use crate::common::{sensor, spring};
use feeler_analysis::frf::{Excitation, FrfExperiment};
use feeler_analysis::{AnalysisError, LinearMachine, Request, View, analyze, curves};
use feeler_engine::{RunSettings, Scenario};
use feeler_lti::C64;
use feeler_plant::description::{
    Actuator, ActuatorKind, Body, DcMotor, GROUND, Machine, MotorInput, PositionServo, Quantity,
};
use feeler_plant::effects::{EffectUse, find};

const MASS_KG: f64 = 2.0;
const DAMPING: f64 = 20.0;
/// A multisine leaves its transient: a share of exp(-5 / s times 5 s), and less if the machine has more
/// damping.
const PERIODIC: f64 = 1e-6;
/// A hold of 0.1 ms aliases the response above 5 kHz. At 5 Hz the error is the third power of 5 Hz over 10
/// kHz.
const MIRRORED: f64 = 1e-8;
/// A dozen products and one quotient of numbers of size one, times the condition of a double integrator.
const ROUNDING: f64 = 1e-9;
/// A cubic with the rate between its neighbours, at 5 Hz and 1 ms. Its rate at a sample errs by the sixth of
/// (w T)^2 = 1e-3. Of that, a twelfth of (w T)^2 remains in the mean over a span.
const CUBIC: f64 = 1e-6;

fn machine(kind: ActuatorKind, damping: f64) -> Machine {
    let mut machine = Machine::default();
    machine.bodies.insert("motor".into(), Body { mass_kg: MASS_KG, ..Body::default() });
    machine.springs.insert("guide".into(), spring(GROUND, "motor", 0.0, damping));
    machine.actuators.insert("drive".into(), Actuator { kind, ..Actuator::ideal("motor", GROUND) });
    machine.sensors.insert("encoder".into(), sensor("motor", Quantity::Position));
    machine
}

fn experiment(machine: Machine, output: &str, hold_s: f64) -> FrfExperiment {
    let output = output.parse().unwrap_or_else(|error| panic!("{error}"));
    FrfExperiment { machine, actuator: "drive".into(), output, hold_s, offset: 0.0, seed: 2 }
}

fn servo(period_s: Option<f64>) -> PositionServo {
    PositionServo { kp: 800.0, kd: 30.0, period_s, ..PositionServo::default() }
}

fn motor(input: MotorInput) -> DcMotor {
    DcMotor {
        input,
        resistance_ohm: 1.5,
        torque_constant: 0.05,
        gear_ratio: 20.0,
        supply_voltage_v: Some(24.0),
        ..DcMotor::default()
    }
}

/// A rigid second body behind a spring and a damper, as a rig moves a load.
fn towed() -> Machine {
    let mut machine = machine(ActuatorKind::Imposed, DAMPING);
    machine.bodies.insert("load".into(), Body { mass_kg: 1.0, ..Body::default() });
    machine.springs.insert("knee".into(), spring("motor", "load", 400.0, 12.0));
    machine
}

fn close(found: C64, expected: C64, tolerance: f64, what: &str) {
    assert!((found - expected).norm() < tolerance * expected.norm(), "{what}: {found} {expected}");
}

/// The hold of a command and the delay of a whole run, as factors of the closed forms of continuous machines.
fn held(s: C64, hold_s: f64) -> C64 {
    (C64::new(1.0, 0.0) - (-s * hold_s).exp()) / (s * hold_s)
}

#[test]
fn truth_a_continuous_servo_and_a_motor_answer_as_on_paper() {
    let hold_s = 1e-4;
    let s = C64::new(0.0, TAU * 5.0);
    let own = s * s * MASS_KG + s * DAMPING;
    let gains = servo(None);
    let [of_servo, voltage, current] = [
        (own + s * gains.kd + gains.kp).inv() * gains.kp,
        (own + s * (20.0 * 20.0 * 0.05 * 0.05 / 1.5)).inv() * (20.0 * 0.05 / 1.5),
        own.inv() * (20.0 * 0.05),
    ];
    let cases = [
        (ActuatorKind::PositionServo(gains), of_servo),
        (ActuatorKind::DcMotor(motor(MotorInput::Voltage)), voltage),
        (ActuatorKind::DcMotor(motor(MotorInput::Duty)), voltage * 24.0),
        (ActuatorKind::DcMotor(motor(MotorInput::Current)), current),
    ];
    for (kind, expected) in cases {
        let what = format!("{kind:?}");
        let found =
            experiment(machine(kind, DAMPING), "motor.position", hold_s).linear_response(&[5.0]).unwrap();
        close(found[0], expected * held(s, hold_s), MIRRORED, &what);
    }
}

/// The other inputs of a continuous servo are forces of its loop. Those of a sampled one are refused.
#[test]
fn truth_inputs_of_a_servo_answer_as_on_paper_or_are_refused() {
    let hold_s = 1e-4;
    let s = C64::new(0.0, TAU * 5.0);
    let gains = servo(None);
    let closed = (s * s * MASS_KG + s * (DAMPING + gains.kd) + gains.kp).inv();
    for (kind, force) in [(ActuatorKind::TargetVelocity, gains.kd), (ActuatorKind::FeedForward, 1.0)] {
        let with = |period_s| {
            let mut machine = machine(ActuatorKind::PositionServo(servo(period_s)), DAMPING);
            machine.actuators.insert("input".into(), Actuator { kind, ..Actuator::ideal("motor", GROUND) });
            let of_target = experiment(machine, "motor.position", hold_s);
            FrfExperiment { actuator: "input".into(), ..of_target }.linear_response(&[5.0])
        };
        close(with(None).unwrap()[0], closed * force * held(s, hold_s), MIRRORED, &format!("{kind:?}"));
        assert!(matches!(with(Some(hold_s)), Err(AnalysisError::Cascade { .. })));
    }
}

#[test]
fn truth_an_interpolated_target_is_late_by_half_its_interval() {
    let (period_s, interval_s) = (8e-3, 8e-3);
    for period in [None, Some(1e-3)] {
        let mut interpolated = machine(ActuatorKind::PositionServo(servo(period)), DAMPING);
        let definition = find("command-interpolation").unwrap();
        interpolated.actuators["drive"].effects.push(EffectUse { definition, values: vec![interval_s] });
        let late = PositionServo { delay_s: 0.5 * interval_s, ..servo(period) };
        let late = machine(ActuatorKind::PositionServo(late), DAMPING);
        let [found, expected] = [interpolated, late].map(|machine| {
            experiment(machine, "motor.position", period_s).linear_response(&[2.0, 20.0]).unwrap()
        });
        for (found, expected) in found.into_iter().zip(expected) {
            close(found, expected, ROUNDING, &format!("{period:?}"));
        }
    }
}

/// `x / r = G kp / (1 + G (kp + kd (1 - 1/z) / T))` with `G = T^2 (z + 1) / (2 m (z - 1)^2)`, and the delay
/// of the target.
#[test]
fn regress_a_sampled_servo_answers_its_target_and_not_a_force() {
    let period_s = 4e-3;
    let kind =
        ActuatorKind::PositionServo(PositionServo { delay_s: 2.0 * period_s, ..servo(Some(period_s)) });
    let gains = servo(None);
    let frequencies = [0.5, 3.0, 20.0, 90.0];
    let found = experiment(machine(kind, 0.0), "motor.position", period_s);
    let found = found.linear_response(&frequencies).unwrap();
    for (found, f) in found.into_iter().zip(frequencies) {
        let z = C64::cis(TAU * f * period_s);
        let plant = (z + 1.0) / ((z - 1.0) * (z - 1.0)) * (period_s * period_s / (2.0 * MASS_KG));
        let back = (C64::new(1.0, 0.0) - z.inv()) * (gains.kd / period_s) + gains.kp;
        let expected = plant * gains.kp / (plant * back + 1.0) * z.powi(-2);
        close(found, expected, ROUNDING, &format!("{f} Hz"));
    }
}

/// Far below its bandwidth a body follows its target. A hundred samples of delay are not states.
#[test]
fn regress_a_servo_with_a_target_a_second_late_follows_it() {
    let kind = ActuatorKind::PositionServo(PositionServo { delay_s: 1.0, ..servo(Some(2e-3)) });
    let found = experiment(machine(kind, DAMPING), "motor.position", 2e-3).linear_response(&[1e-3]).unwrap();
    let late = C64::new(0.0, -TAU * 1e-3).exp();
    // The body lags by (kd + b) / kp = 0.06 s more: 4e-4 at 1 mHz.
    close(found[0], late, 1e-3, "1 mHz");
}

#[test]
fn truth_simulated_servos_motors_and_imposed_motions_answer_as_linear_theory() {
    let excitation =
        Excitation::Multisine { period_s: 1.0, periods: 2, transient_periods: 5, realisations: 1 };
    let servo_with = |delay_s, compute_delay_s| {
        ActuatorKind::PositionServo(PositionServo { delay_s, compute_delay_s, ..servo(Some(2e-3)) })
    };
    let mut late = towed();
    let definition = find("command-delay").unwrap();
    late.actuators["drive"].effects.push(EffectUse { definition, values: vec![2.5e-3] });
    let motor = ActuatorKind::DcMotor(motor(MotorInput::Voltage));
    let cases = [
        experiment(machine(ActuatorKind::PositionServo(servo(None)), DAMPING), "encoder.reading", 1e-3),
        experiment(machine(servo_with(0.0, 0.0), DAMPING), "encoder.reading", 2e-3),
        experiment(machine(servo_with(1.7e-3, 0.6e-3), DAMPING), "encoder.reading", 4e-3),
        experiment(machine(motor, DAMPING), "motor.velocity", 1e-3),
        experiment(towed(), "load.position", 1e-3),
        experiment(towed(), "knee.force", 1e-3),
        experiment(late, "load.velocity", 1e-3),
    ];
    for (i, case) in cases.iter().enumerate() {
        let measured = case.measure(&excitation, 1e-3, (1.0, 60.0)).unwrap();
        assert!(measured.linear.len() >= 59);
        for ((f, found), linear) in
            measured.estimate.frequencies_hz.iter().zip(&measured.estimate.response).zip(&measured.linear)
        {
            close(*found, *linear, PERIODIC, &format!("case {i}, {f} Hz"));
        }
    }
}

#[test]
fn truth_an_imposed_motion_tows_a_body_as_on_paper() {
    let s = C64::new(0.0, TAU * 5.0);
    let pull = s * 12.0 + 400.0;
    let expected = pull / (s * s + pull);
    let found = experiment(towed(), "load.position", 1e-3).linear_response(&[5.0]).unwrap();
    close(found[0], expected, CUBIC, "sampled");
    // The continuous channel, without a hold.
    let plant = LinearMachine::new(&towed(), &View::default()).unwrap();
    let name = |name: &str| name.parse().unwrap_or_else(|error| panic!("{error}"));
    let channel = plant.channel(&name("drive.command"), &name("load.position")).unwrap();
    close(channel.frequency_response(&[5.0]).unwrap()[0], expected, ROUNDING, "continuous");
    assert_eq!(channel.states.len(), 2, "{:?}", channel.states);
}

#[test]
fn regress_poles_of_a_sampled_servo_without_its_loop_are_those_from_its_force() {
    for (period_s, expected) in [(None, "drive.command"), (Some(2e-3), "drive.force")] {
        let kind = ActuatorKind::PositionServo(servo(period_s));
        let scenario = Scenario {
            machine: machine(kind, DAMPING),
            controllers: std::iter::empty().collect(),
            run: RunSettings::default(),
        };
        let request = Request { brief: true, ..Request::default() };
        assert_eq!(analyze(&scenario, &request).unwrap().input, expected);
    }
}

#[test]
fn regress_curves_of_a_sampled_servo_are_drawn_from_its_force() {
    let kind = ActuatorKind::PositionServo(servo(Some(2e-3)));
    let scenario = Scenario {
        machine: machine(kind, DAMPING),
        controllers: std::iter::empty().collect(),
        run: RunSettings::default(),
    };
    let request = Request::default();
    let report = analyze(&scenario, &request).unwrap();
    let drawn = curves(&scenario, &request, &report).unwrap();
    assert_eq!(report.input, "drive.force");
    for (f, found) in drawn.frequencies_hz.iter().zip(&drawn.plant) {
        let s = C64::new(0.0, TAU * f);
        close(*found, (s * s * MASS_KG + s * DAMPING).inv(), ROUNDING, &format!("{f} Hz"));
    }
    assert!(drawn.plant.len() > 100 && drawn.open_sampled.is_some());
}
