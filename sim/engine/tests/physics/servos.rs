//! Drives with a loop, a winding or an imposed motion, against closed forms.

use feeler_control::ReferenceSpec;
use feeler_engine::{Scenario, Trace};
use feeler_plant::description::{
    Actuator, ActuatorKind, DcMotor, GROUND, Machine, MotorInput, PositionServo,
};

use crate::common::{body, close, command, drive, effect, free_mass, run, scenario, spring};

/// Sums of a few exponentials and sines of numbers of size one to a hundred, each rounded a few times a step.
const EXACT: f64 = 1e-11;
/// Loss of the ledger relative to the energy exchanged: its quadrature is exact to machine precision
/// (DESIGN.md).
const LEDGER: f64 = 1e-9;
/// Mass that is driven, kg.
const MASS_KG: f64 = 2.0;
/// Time between commands, s.
const COMMANDED_S: f64 = 0.01;

const RECORD: [&str; 4] = ["tip.position", "tip.velocity", "drive.force", "drive.command"];

fn driven(kind: ActuatorKind, reference: ReferenceSpec, duration_s: f64) -> Scenario {
    let mut machine = free_mass(MASS_KG, 0.0, 0.0);
    machine.actuators.insert("drive".into(), Actuator { kind, ..drive("tip", GROUND) });
    let mut scenario = scenario(machine, duration_s, &RECORD);
    command(&mut scenario, "aim", reference, COMMANDED_S);
    scenario
}

fn servo(kp: f64, kd: f64) -> PositionServo {
    PositionServo { kp, kd, ..PositionServo::default() }
}

fn column<'a>(trace: &'a Trace, name: &str) -> &'a [f64] {
    trace.column(name).unwrap()
}

/// A spring and damper pull the mass to the target: the step response of a system of second order.
#[test]
fn truth_a_continuous_servo_steps_as_a_spring_and_damper() {
    let (kp, kd, target) = (800.0, 12.0, 0.05);
    let scenario = driven(ActuatorKind::PositionServo(servo(kp, kd)), ReferenceSpec::Constant(target), 1.0);
    let (trace, simulation) = run(&scenario);
    let omega = (kp / MASS_KG).sqrt();
    let zeta = kd / (2.0 * (kp * MASS_KG).sqrt());
    let damped = omega * (1.0 - zeta * zeta).sqrt();
    for (i, t) in trace.t_s.iter().enumerate() {
        let decay = (-zeta * omega * t).exp();
        let swing = (damped * t).cos() + zeta * omega / damped * (damped * t).sin();
        close(column(&trace, "tip.position")[i], target * (1.0 - decay * swing), EXACT);
        close(
            column(&trace, "tip.velocity")[i],
            target * omega * omega / damped * decay * (damped * t).sin(),
            EXACT,
        );
    }
    let balance = simulation.energy(0).unwrap();
    assert!(balance.residual().abs() < LEDGER * balance.exchanged());
}

/// A servo with the speed of its target or a force as a further input.
fn fed(servo: PositionServo, kind: ActuatorKind, input: f64, limit_n: Option<f64>) -> Scenario {
    let mut scenario = driven(ActuatorKind::PositionServo(servo), ReferenceSpec::Constant(0.0), 1.0);
    scenario.machine.actuators["drive"].limit_n = limit_n;
    scenario.machine.actuators.insert("input".into(), Actuator { kind, ..drive("tip", GROUND) });
    command(&mut scenario, "lead", ReferenceSpec::Constant(input), COMMANDED_S);
    scenario.controllers["lead"].drives = "input".into();
    scenario
}

/// A force input, the speed of a target times `kd`, and a target that is off by `force / kp` act alike:
/// within the limit, continuous and sampled.
#[test]
fn truth_inputs_of_a_servo_are_forces_of_its_loop() {
    let (kp, kd, speed, force) = (800.0, 12.0, 0.4, -9.0);
    for period_s in [None, Some(0.004)] {
        for limit_n in [None, Some(3.0)] {
            let servo = PositionServo { period_s, ..servo(kp, kd) };
            for (kind, input, by) in
                [(ActuatorKind::TargetVelocity, speed, kd * speed), (ActuatorKind::FeedForward, force, force)]
            {
                let (trace, simulation) = run(&fed(servo, kind, input, limit_n));
                let mut aimed =
                    driven(ActuatorKind::PositionServo(servo), ReferenceSpec::Constant(by / kp), 1.0);
                aimed.machine.actuators["drive"].limit_n = limit_n;
                let (same, _) = run(&aimed);
                for name in &RECORD[..3] {
                    for (own, other) in column(&trace, name).iter().zip(column(&same, name)) {
                        close(*own, *other, EXACT);
                    }
                }
                let most = column(&trace, "drive.force").iter().fold(0.0_f64, |most, f| most.max(f.abs()));
                assert!(limit_n.is_none_or(|limit| most <= limit + EXACT) && most > 1.0, "{most}");
                let fastest =
                    column(&trace, "tip.velocity").iter().fold(0.0_f64, |most, v| most.max(v.abs()));
                let balance = simulation.energy(0).unwrap();
                assert!(balance.residual().abs() < LEDGER * 0.5 * MASS_KG * fastest * fastest, "{balance:?}");
            }
        }
    }
}

/// A force that is fed forward is not an error: the integral part counters it, and the servo rests at its
/// target.
#[test]
fn truth_an_integral_part_does_not_integrate_the_force_that_is_fed_forward() {
    for period_s in [None, Some(0.004)] {
        let servo = PositionServo { ki: 4000.0, period_s, ..servo(500.0, 60.0) };
        let mut scenario = fed(servo, ActuatorKind::FeedForward, 8.0, None);
        scenario.run.duration_s = 9.0;
        let (trace, _) = run(&scenario);
        let moved = column(&trace, "tip.position").iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        assert!(moved > 1e-3, "{moved}");
        // The slowest pole decays as exp(-3.7 t) or faster.
        close(*column(&trace, "tip.position").last().unwrap(), 0.0, EXACT);
    }
}

/// A load shifts the rest position of a servo by `load / kp`, and an integral part removes the shift.
#[test]
fn truth_a_servo_droops_by_load_over_gain() {
    let (kp, load, target) = (500.0, -8.0, 0.1);
    for (ki, droop) in [(0.0, load / kp), (4000.0, 0.0)] {
        let kind = ActuatorKind::PositionServo(PositionServo { ki, ..servo(kp, 60.0) });
        let mut scenario = driven(kind, ReferenceSpec::Constant(target), 9.0);
        let mut guide = spring(GROUND, "tip", 0.0, 0.0);
        guide.effects.push(effect("constant-load", &[load]));
        scenario.machine.springs.insert("guide".into(), guide);
        let (trace, _) = run(&scenario);
        // The slowest pole decays as exp(-3.7 t): 3e-15 are left after 9 s.
        close(*column(&trace, "tip.position").last().unwrap(), target + droop, EXACT);
    }
}

/// At its limit a servo accelerates uniformly, until its demand falls below the limit.
#[test]
fn truth_a_servo_at_its_limit_accelerates_evenly() {
    let (kp, kd, target, limit) = (900.0, 30.0, 0.4, 20.0);
    let mut scenario =
        driven(ActuatorKind::PositionServo(servo(kp, kd)), ReferenceSpec::Constant(target), 3.0);
    scenario.machine.actuators["drive"].limit_n = Some(limit);
    let (trace, simulation) = run(&scenario);
    let a = limit / MASS_KG;
    // kp (target - a t^2 / 2) - kd a t = limit.
    let (half, constant) = (kd / kp, 2.0 * (limit / kp - target) / a);
    let leaves_s = -half + (half * half - constant).sqrt();
    assert!(leaves_s > 0.1, "{leaves_s}");
    for (i, t) in trace.t_s.iter().enumerate().filter(|(_, t)| **t > 0.0 && **t < leaves_s) {
        close(column(&trace, "tip.position")[i], 0.5 * a * t * t, EXACT);
        close(column(&trace, "drive.force")[i], limit, EXACT);
    }
    let forces = column(&trace, "drive.force");
    assert!(forces.iter().all(|force| force.abs() <= limit + EXACT));
    close(*column(&trace, "tip.position").last().unwrap(), target, 1e-6);
    // At the end it is at rest again, and the drive has recovered its energy: the exchange is the largest
    // kinetic energy, 6 J.
    let fastest = column(&trace, "tip.velocity").iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let swung_j = 0.5 * MASS_KG * fastest * fastest;
    let balance = simulation.energy(0).unwrap();
    assert!(swung_j > 5.0 && balance.residual().abs() < LEDGER * swung_j, "{balance:?}");
}

/// Within its deadband a servo gives no force: a mass at rest there stays, one outside stops at the edge.
#[test]
fn truth_an_error_within_the_deadband_moves_nothing() {
    let width = 0.01;
    let kind = ActuatorKind::PositionServo(PositionServo { error_deadband_m: width, ..servo(500.0, 80.0) });
    let (trace, _) = run(&driven(kind, ReferenceSpec::Constant(0.9 * width), 0.5));
    assert!(column(&trace, "tip.position").iter().all(|x| *x == 0.0));
    let (trace, _) = run(&driven(kind, ReferenceSpec::Constant(5.0 * width), 4.0));
    // Overdamped: it creeps to the edge as exp(-8.0 t).
    close(*column(&trace, "tip.position").last().unwrap(), 4.0 * width, 1e-12);
}

/// The servo's target moves at most at its speed limit: a stiff loop then moves at that speed.
#[test]
fn truth_a_target_moves_no_faster_than_the_velocity_limit() {
    let (kp, kd, speed) = (2000.0, 100.0, 0.25);
    let kind =
        ActuatorKind::PositionServo(PositionServo { velocity_limit_m_per_s: Some(speed), ..servo(kp, kd) });
    let (trace, _) = run(&driven(kind, ReferenceSpec::Constant(0.5), 1.9));
    let at = |t: f64| trace.t_s.iter().position(|s| (s - t).abs() < 1e-9).unwrap();
    close(column(&trace, "tip.velocity")[at(1.5)], speed, 1e-10);
    // On a ramp it lags by the damping: kd v / kp.
    close(column(&trace, "tip.position")[at(1.5)], speed * 1.5 - kd * speed / kp, 1e-10);
}

/// An interpolated target is a ramp. A servo lags behind it by the damping, and the next ramp begins where
/// the last one ended.
#[test]
fn truth_an_interpolated_target_is_a_ramp_of_its_own_rate() {
    let (kp, kd, interval) = (2000.0, 100.0, 0.8);
    for period_s in [None, Some(0.001)] {
        let kind = ActuatorKind::PositionServo(PositionServo { period_s, ..servo(kp, kd) });
        let targets = ReferenceSpec::Steps(vec![(0.0, 0.4), (0.895, -0.2)]);
        let mut scenario = driven(kind, targets, 2.6);
        scenario.machine.actuators["drive"].effects.push(effect("command-interpolation", &[interval]));
        let (trace, _) = run(&scenario);
        let at = |t: f64| trace.t_s.iter().position(|s| (s - t).abs() < 1e-9).unwrap();
        // The transient of 0.04 s has decayed to 1e-8. A sample is up to a period late.
        let late = period_s.map_or(1e-7, |period_s| 2.0 * period_s);
        for (t, speed, reached) in [(0.7, 0.5, 0.35), (1.6, -0.75, 0.4 - 0.75 * 0.7)] {
            let lag = kd * speed / kp;
            close(column(&trace, "tip.position")[at(t)], reached - lag, late);
        }
        close(*column(&trace, "tip.position").last().unwrap(), -0.2, 1e-6);
    }
}

/// A sampled loop, against its own difference equation: exact motion of a mass under a held force.
#[test]
fn truth_a_sampled_servo_is_its_difference_equation() {
    let (kp, kd, target, period, delay, step) = (600.0, 25.0, 0.03, 0.004, 0.0015, 1e-4);
    for (ki, limit) in [(0.0, f64::INFINITY), (900.0, 9.0)] {
        let kind = ActuatorKind::PositionServo(PositionServo {
            ki,
            period_s: Some(period),
            compute_delay_s: delay,
            resolution_m: Some(step),
            ..servo(kp, kd)
        });
        let mut scenario = driven(kind, ReferenceSpec::Constant(target), 0.4);
        scenario.machine.actuators["drive"].limit_n = Some(limit).filter(|limit| limit.is_finite());
        let (trace, _) = run(&scenario);
        let (mut x, mut v, mut force, mut integral, mut last) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0, 0.0);
        let mut go = |force: f64, s: f64| {
            x += v * s + 0.5 * force / MASS_KG * s * s;
            v += force / MASS_KG * s;
            x
        };
        for k in 0..100 {
            let position = go(0.0, 0.0);
            let row = k * 4;
            close(column(&trace, "tip.position")[row], position, EXACT);
            let read = (position / step).round() * step;
            let speed = if k == 0 { 0.0 } else { (read - last) / period };
            last = read;
            let e = target - read;
            integral += ki * period * e;
            let wanted = kp * e + integral - kd * speed;
            let given = wanted.clamp(-limit, limit);
            if ki > 0.0 {
                integral -= period / (kp / ki) * (wanted - given);
            }
            go(force, delay);
            force = given;
            go(force, period - delay);
        }
    }
}

/// A delayed target arrives late by exactly the delay, in a continuous and in a sampled loop.
#[test]
fn truth_a_late_target_shifts_the_motion() {
    let late = 0.03;
    for period_s in [None, Some(0.005)] {
        let of = |delay_s: f64| {
            let kind = ActuatorKind::PositionServo(PositionServo { period_s, delay_s, ..servo(300.0, 20.0) });
            run(&driven(kind, ReferenceSpec::Constant(0.02), 0.3)).0
        };
        let (prompt, delayed) = (of(0.0), of(late));
        let rows = (late / 1e-3_f64).round() as usize;
        for i in rows..delayed.t_s.len() {
            close(column(&delayed, "tip.position")[i], column(&prompt, "tip.position")[i - rows], EXACT);
        }
    }
}

fn motor() -> DcMotor {
    DcMotor {
        resistance_ohm: 1.5,
        torque_constant: 0.05,
        gear_ratio: 20.0,
        supply_voltage_v: Some(12.0),
        rotor_inertia: 1e-3,
        ..DcMotor::default()
    }
}

/// Driven mass with the rotor, kg.
fn moved_kg(motor: &DcMotor) -> f64 {
    MASS_KG + motor.rotor_inertia * motor.gear_ratio.powi(2)
}

/// A motor at constant voltage reaches its no-load speed with the time constant `m R / (N^2 K_t K_e)`. The
/// supply limits the voltage, and a duty cycle is a share of the supply voltage.
#[test]
fn truth_a_motor_runs_up_to_its_no_load_speed() {
    let one = motor();
    for (input, asked, volts) in
        [(MotorInput::Voltage, 6.0, 6.0), (MotorInput::Voltage, 99.0, 12.0), (MotorInput::Duty, -0.25, -3.0)]
    {
        let kind = ActuatorKind::DcMotor(DcMotor { input, ..one });
        let mut scenario = driven(kind, ReferenceSpec::Constant(asked), 1.0);
        scenario.run.record.push("drive.current".parse().unwrap());
        let (trace, simulation) = run(&scenario);
        let top = volts / (one.gear_ratio * one.torque_constant);
        let damping = (one.gear_ratio * one.torque_constant).powi(2) / one.resistance_ohm;
        let rate = damping / moved_kg(&one);
        for (i, t) in trace.t_s.iter().enumerate() {
            let v = top * (1.0 - (-rate * t).exp());
            close(column(&trace, "tip.velocity")[i], v, EXACT * top.abs());
            let current = (volts - one.gear_ratio * one.torque_constant * v) / one.resistance_ohm;
            if i > 0 {
                close(column(&trace, "drive.current")[i], current, EXACT * top.abs());
            }
        }
        let balance = simulation.energy(0).unwrap();
        assert!(balance.residual().abs() < LEDGER * balance.exchanged());
    }
}

/// With inductance the current builds up: two poles, of `m L s^2 + m R s + N^2 K_t K_e`.
#[test]
fn truth_inductance_adds_a_pole() {
    let one = DcMotor { inductance_h: 0.02, ..motor() };
    let (trace, _) = run(&driven(ActuatorKind::DcMotor(one), ReferenceSpec::Constant(5.0), 0.5));
    let (m, c) = (moved_kg(&one), one.gear_ratio * one.torque_constant);
    let (a, b) = (one.resistance_ohm / one.inductance_h, c * c / (m * one.inductance_h));
    let root = (a * a / 4.0 - b).sqrt();
    let (p, q) = (-a / 2.0 + root, -a / 2.0 - root);
    for (i, t) in trace.t_s.iter().enumerate() {
        let v = 5.0 / c * (1.0 + (q * (p * t).exp() - p * (q * t).exp()) / (p - q));
        close(column(&trace, "tip.velocity")[i], v, EXACT);
    }
}

/// With a current command the force is constant up to the speed at which the supply voltage is exhausted.
/// From there the motor runs as at that voltage.
#[test]
fn truth_a_current_is_kept_as_far_as_the_supply_allows() {
    let one = DcMotor { input: MotorInput::Current, ..motor() };
    let amperes = 6.0;
    let (trace, _) = run(&driven(ActuatorKind::DcMotor(one), ReferenceSpec::Constant(amperes), 2.5));
    let (m, c) = (moved_kg(&one), one.gear_ratio * one.torque_constant);
    let a = c * amperes / m;
    let corner = (12.0 - amperes * one.resistance_ohm) / c;
    let (top, rate, leaves_s) = (12.0 / c, c * c / (one.resistance_ohm * m), corner / a);
    for (i, t) in trace.t_s.iter().enumerate() {
        let after = top - (top - corner) * (-rate * (t - leaves_s)).exp();
        let v = if *t < leaves_s { a * t } else { after };
        close(column(&trace, "tip.velocity")[i], v, EXACT * top);
    }
    assert!(leaves_s < 2.0, "{leaves_s}");
}

/// An imposed body follows its command, and pulls another by a spring: `v t - v sin(w t) / w`. The required
/// force is that of the spring.
#[test]
fn truth_an_imposed_body_moves_as_told() {
    let (speed, k) = (0.2, 450.0);
    let mut machine = free_mass(MASS_KG, 0.0, 0.0);
    machine.bodies.insert("rig".into(), body(5.0, 0.0));
    machine.springs.insert("rope".into(), spring("rig", "tip", k, 0.0));
    machine
        .actuators
        .insert("drive".into(), Actuator { kind: ActuatorKind::Imposed, ..drive("rig", GROUND) });
    let names = ["rig.position", "tip.position", "drive.force", "rope.force", "rig.velocity"];
    let mut scenario = scenario(machine, 1.0, &names);
    let points = vec![(0.0, 0.0), (2.0, 2.0 * speed)];
    command(&mut scenario, "aim", ReferenceSpec::PiecewiseLinear(points), COMMANDED_S);
    let (trace, simulation) = run(&scenario);
    let omega = (k / MASS_KG).sqrt();
    for (i, t) in trace.t_s.iter().enumerate() {
        close(column(&trace, "rig.position")[i], speed * t, EXACT);
        close(column(&trace, "tip.position")[i], speed * t - speed / omega * (omega * t).sin(), EXACT);
        // The spring's force acts on its second body, the tip, and the drive opposes it. Curvatures of the
        // pieces are zero up to the rounding of their knots, 1e-16 / (10 ms)^2.
        close(column(&trace, "drive.force")[i], column(&trace, "rope.force")[i], 1e-9);
    }
    let balance = simulation.energy(0).unwrap();
    assert!(balance.residual().abs() < LEDGER * balance.exchanged());
}

/// A sticking guide between an imposed and a free body carries the free one along; it slips if the
/// acceleration exceeds the friction.
#[test]
fn truth_an_imposed_body_carries_what_sticks_to_it() {
    let (a, level) = (1.5, 2.0);
    let carry = |friction: f64| {
        let mut machine = free_mass(MASS_KG, 0.0, 0.0);
        machine.bodies.insert("rig".into(), body(5.0, 0.0));
        let mut pad = spring("rig", "tip", 0.0, 0.0);
        pad.effects.push(effect("coulomb-friction", &[friction]));
        machine.springs.insert("pad".into(), pad);
        machine
            .actuators
            .insert("drive".into(), Actuator { kind: ActuatorKind::Imposed, ..drive("rig", GROUND) });
        let mut scenario = scenario(machine, 0.5, &["rig.velocity", "tip.velocity"]);
        let points: Vec<(f64, f64)> =
            (0..200).map(|k| f64::from(k) * 5e-3).map(|t| (t, 0.5 * a * t * t)).collect();
        command(&mut scenario, "aim", ReferenceSpec::PiecewiseLinear(points), 5e-3);
        run(&scenario).0
    };
    // 1.5 m/s2 on 2 kg takes 3 N.
    let held = carry(1e3);
    let [rig, tip] = ["rig.velocity", "tip.velocity"].map(|name| *column(&held, name).last().unwrap());
    close(tip, rig, 1e-12);
    let sliding = carry(level);
    close(*column(&sliding, "tip.velocity").last().unwrap(), level / MASS_KG * 0.5, 1e-9);
}

/// Invalid drives are rejected, with the key of the mistake.
#[test]
fn truth_what_a_drive_cannot_be_is_refused() {
    let problem = |kind: ActuatorKind, change: &dyn Fn(&mut Machine)| {
        let mut scenario = driven(kind, ReferenceSpec::Constant(0.0), 0.1);
        change(&mut scenario.machine);
        feeler_engine::Program::new(&scenario).unwrap_err().to_string()
    };
    let nothing = |_: &mut Machine| {};
    let stepped = PositionServo { output_resolution_n: Some(0.1), ..servo(1.0, 0.0) };
    assert!(
        problem(ActuatorKind::PositionServo(stepped), &nothing).contains("actuators.drive.output_resolution")
    );
    let duty = DcMotor { input: MotorInput::Duty, ..DcMotor::default() };
    assert!(problem(ActuatorKind::DcMotor(duty), &nothing).contains("actuators.drive.supply_voltage"));
    let limited = |machine: &mut Machine| machine.actuators["drive"].limit_n = Some(1.0);
    assert!(problem(ActuatorKind::Imposed, &limited).contains("actuators.drive.limit"));
}
