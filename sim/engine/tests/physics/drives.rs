//! The chain from a command to a force.

use feeler_control::ReferenceSpec;
use feeler_engine::{EventKind, Program, Scenario, Trace};
use feeler_plant::description::{Actuator, ActuatorKind, GROUND};
use feeler_plant::motion::Mode;

use crate::common::{close, command, drive, effect, free_mass, run, scenario, spring};

/// Sums of a few exponentials, each rounded once or twice, of numbers of size 1 to 100.
const EXACT: f64 = 1e-12;
/// Mass that is driven, kg.
const MASS_KG: f64 = 2.0;

fn driven(actuator: Actuator, reference: ReferenceSpec, duration_s: f64) -> Scenario {
    let mut machine = free_mass(MASS_KG, 0.0, 0.0);
    machine.actuators.insert("drive".into(), actuator);
    let names = ["drive.force", "tip.velocity", "tip.position", "drive.command"];
    let mut scenario = scenario(machine, duration_s, &names);
    command(&mut scenario, "push", reference, 0.01);
    scenario
}

fn with(effects: &[(&str, &[f64])]) -> Actuator {
    Actuator {
        effects: effects.iter().map(|(kind, values)| effect(kind, values)).collect(),
        ..drive("tip", GROUND)
    }
}

fn force(trace: &Trace) -> &[f64] {
    trace.column("drive.force").unwrap()
}

#[test]
fn truth_deadband_then_gain_then_limit() {
    let actuator = with(&[("drive-deadband", &[2.0]), ("drive-gain", &[1.5]), ("force-limit", &[12.0])]);
    let commands = [1.0, -1.9, 3.0, -5.0, 9.9, 20.0, -20.0];
    let steps = commands.iter().enumerate().map(|(i, c)| (0.01 * i as f64, *c)).collect();
    let (trace, _) = run(&driven(actuator, ReferenceSpec::Steps(steps), 0.069));
    // (|c| - 2) 1.5, at most 12.
    let forces = [0.0, 0.0, 1.5, -4.5, 11.85, 12.0, -12.0];
    for (i, expected) in forces.iter().enumerate() {
        close(force(&trace)[10 * i + 5], *expected, EXACT);
        close(trace.column("drive.command").unwrap()[10 * i], commands[i], 0.0);
    }
}

#[test]
fn truth_slew_limit_ramps_exactly() {
    let rate = 1234.5;
    // With and without a little damping: with it the fastest motion is far slower than the ramp.
    for damping in [0.0, 1e-7] {
        let mut scenario = driven(
            with(&[("slew-limit", &[rate])]),
            ReferenceSpec::Steps(vec![(0.0, 40.0), (0.05, -10.0)]),
            0.12,
        );
        scenario.machine.springs.insert("guide".into(), spring(GROUND, "tip", 0.0, damping));
        let (trace, _) = run(&scenario);
        let (up, down) = (40.0 / rate, 50.0 / rate);
        for (i, t) in trace.t_s.iter().enumerate() {
            let expected =
                if *t < 0.05 { (rate * t).min(40.0) } else { (40.0 - rate * (t - 0.05)).max(-10.0) };
            close(force(&trace)[i], expected, 100.0 * EXACT);
            if *t < up {
                close(
                    trace.column("tip.velocity").unwrap()[i],
                    0.5 * rate * t * t / MASS_KG,
                    10.0 * EXACT + damping,
                );
                close(
                    trace.column("tip.position").unwrap()[i],
                    rate * t.powi(3) / (6.0 * MASS_KG),
                    EXACT + damping * 1e-2,
                );
            }
        }
        // After both ramps the impulse is the commanded one less the loss of the ramps.
        let impulse = 0.05 * 40.0 - 0.5 * 40.0 * up - 0.07 * 10.0 + 0.5 * 50.0 * down;
        close(
            *trace.column("tip.velocity").unwrap().last().unwrap(),
            impulse / MASS_KG,
            10.0 * EXACT + damping,
        );
    }
}

#[test]
fn truth_lags_in_series() {
    let (corner_hz, tau2) = (80.0, 3.3e-3);
    let tau1 = 1.0 / (std::f64::consts::TAU * corner_hz);
    let actuator = Actuator {
        kind: ActuatorKind::Force { bandwidth_hz: Some(corner_hz) },
        ..with(&[("actuator-lag", &[tau2])])
    };
    let (trace, _) = run(&driven(actuator, ReferenceSpec::Constant(30.0), 0.05));
    for (i, t) in trace.t_s.iter().enumerate() {
        let expected = 30.0 * (1.0 - (tau1 * (-t / tau1).exp() - tau2 * (-t / tau2).exp()) / (tau1 - tau2));
        close(force(&trace)[i], expected, 100.0 * EXACT);
    }
}

/// A delay of any length shifts the response by exactly that length, in the drive, in the controller, or in
/// both.
#[test]
fn truth_delays_of_any_length_shift_the_response() {
    for (drive_delay, loop_delay) in
        [(0.0, 1.234_567_891e-3), (0.3e-3, 0.0), (7.77e-3, 0.0), (1.1e-3, 23.456e-3)]
    {
        let actuator = if drive_delay > 0.0 { with(&[("command-delay", &[drive_delay])]) } else { with(&[]) };
        let mut scenario = driven(actuator, ReferenceSpec::Steps(vec![(0.02, 6.0), (0.05, -4.0)]), 0.1);
        scenario.controllers["push"].spec.delay_s = loop_delay;
        let (trace, _) = run(&scenario);
        let late = drive_delay + loop_delay;
        for (i, t) in trace.t_s.iter().enumerate() {
            let (first, second) = ((t - 0.02 - late).max(0.0), (t - 0.05 - late).max(0.0));
            close(trace.column("tip.velocity").unwrap()[i], (6.0 * first - 10.0 * second) / MASS_KG, EXACT);
            close(
                trace.column("tip.position").unwrap()[i],
                0.5 * (6.0 * first.powi(2) - 10.0 * second.powi(2)) / MASS_KG,
                EXACT,
            );
        }
    }
}

const SOURCE_DAMPING: f64 = 600.0;
const SOURCE_LAG_S: f64 = 2e-3;

fn source(limit_n: Option<f64>) -> Actuator {
    let kind =
        ActuatorKind::VelocitySource { damping_n_s_per_m: SOURCE_DAMPING, time_constant_s: SOURCE_LAG_S };
    Actuator { kind, limit_n, ..drive("tip", GROUND) }
}

/// Speed and force of a mass behind a velocity source, `t` after a step of the commanded speed to 1 m/s:
/// `m tau v'' + m v' + b v = b`.
fn source_step(t: f64) -> (f64, f64) {
    let omega = (SOURCE_DAMPING / (MASS_KG * SOURCE_LAG_S)).sqrt();
    let decay = 0.5 / SOURCE_LAG_S;
    let damped = (omega * omega - decay * decay).sqrt();
    let envelope = (-decay * t).exp();
    let v = 1.0 - envelope * ((damped * t).cos() + decay / damped * (damped * t).sin());
    (v, MASS_KG * omega * omega / damped * envelope * (damped * t).sin())
}

#[test]
fn truth_velocity_source_step_is_second_order() {
    let (trace, _) = run(&driven(source(None), ReferenceSpec::Constant(1.0), 0.05));
    for (i, t) in trace.t_s.iter().enumerate() {
        let (v, f) = source_step(*t);
        close(trace.column("tip.velocity").unwrap()[i], v, EXACT);
        close(force(&trace)[i], f, 1e3 * EXACT);
    }
}

#[test]
fn truth_velocity_source_holds_at_its_effort_limit() {
    let limit = 100.0;
    let (trace, _) = run(&driven(source(Some(limit)), ReferenceSpec::Constant(1.0), 0.04));
    // The instant at which the unlimited force first exceeds the limit, by bisection on the closed form.
    let (mut a, mut b) = (0.0, 1e-3);
    for _ in 0..60 {
        let middle = 0.5 * (a + b);
        if source_step(middle).1 < limit { a = middle } else { b = middle }
    }
    assert_eq!([trace.events[0].kind, trace.events[1].kind], [EventKind::Limit, EventKind::Release]);
    close(trace.events[0].t_s, a, EXACT);
    // From there the speed grows uniformly until the source no longer saturates: b (1 - v) = limit.
    let release_speed = 1.0 - limit / SOURCE_DAMPING;
    close(trace.events[1].t_s, a + (release_speed - source_step(a).0) * MASS_KG / limit, EXACT);
    assert!(force(&trace).iter().all(|f| f.abs() <= limit * (1.0 + EXACT)));
}

/// Cogging is a force of position: a mass crosses one hill and keeps its energy, and the drive's force
/// follows the law.
#[test]
fn truth_ripple_is_a_force_of_position() {
    let (amplitude, pitch, phase) = (3.0, 2e-3, 0.7);
    let mut scenario =
        driven(with(&[("force-ripple", &[amplitude, pitch, phase])]), ReferenceSpec::Constant(0.0), 0.1);
    scenario.machine.bodies["tip"].velocity_m_per_s = 0.2;
    let (trace, _) = run(&scenario);
    let (x, v) = (trace.column("tip.position").unwrap(), trace.column("tip.velocity").unwrap());
    let angle = |x: f64| std::f64::consts::TAU * x / pitch + phase;
    for i in 0..trace.t_s.len() {
        close(force(&trace)[i], amplitude * angle(x[i]).sin(), 1e3 * EXACT);
        // Kinetic energy plus the potential amplitude pitch / 2 pi cos(angle).
        let potential = |x: f64| amplitude * pitch / std::f64::consts::TAU * angle(x).cos();
        close(0.5 * MASS_KG * v[i] * v[i] + potential(x[i]), 0.5 * MASS_KG * 0.04 + potential(0.0), EXACT);
    }
}

/// A constant command warms the winding by an exponential. With `c` the heat in the end, the force falls to
/// `f / (1 + c)`, and its integral over time is the speed.
#[test]
fn truth_a_drive_weakens_as_its_winding_warms() {
    let tau = 0.03;
    for (force_n, halved_n) in [(20.0, 20.0), (-20.0, 50.0)] {
        let c = f64::powi(force_n / halved_n, 2);
        let actuator = with(&[("thermal-derating", &[halved_n, tau])]);
        let (trace, _) = run(&driven(actuator, ReferenceSpec::Constant(force_n), 0.2));
        for (i, t) in trace.t_s.iter().enumerate().skip(1) {
            let fallen = (-t / tau).exp();
            close(force(&trace)[i], force_n / (1.0 + c * (1.0 - fallen)), 100.0 * EXACT);
            let impulse = force_n * tau / (1.0 + c) * ((1.0 + c) / fallen - c).ln();
            close(trace.column("tip.velocity").unwrap()[i], impulse / MASS_KG, 10.0 * EXACT);
        }
    }
}

/// A rounding of 20 N is 4e-15 N. At 1 kN/s a ramp of it lasts 4e-18 s, less than the rounding of a clock at
/// one second.
#[test]
fn regress_a_command_that_moves_by_a_rounding_starts_no_ramp() {
    let scenario = driven(with(&[("slew-limit", &[1e3])]), ReferenceSpec::Constant(20.0), 0.1);
    let program = Program::new(&scenario).unwrap();
    let motion = program.motion();
    let (mut xi, ramp) = (motion.initial_vector(), motion.layout().ramp(0).unwrap());
    xi[ramp] = 20.0;
    let at_target = motion.take_input(Mode::default(), 0, 20.0, &mut xi);
    let above = 20.0_f64.next_up();
    assert_eq!(motion.take_input(at_target, 0, above, &mut xi), at_target);
    assert_eq!(xi[ramp].to_bits(), above.to_bits());
    assert_ne!(motion.take_input(at_target, 0, 20.0 + 1e-12, &mut xi), at_target);
}
