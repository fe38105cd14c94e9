//! Values that users write for "ideal": a part that decays within nanoseconds is stepped over.

use feeler_control::ReferenceSpec;
use feeler_engine::RunEnd;
use feeler_plant::description::{Actuator, ActuatorKind};

use crate::common::{axis, body, effect, run, spring};

/// A lag of 0.2 ns changes a force with a rate of a few kilonewtons a second by less than a micronewton. The
/// ideal drive's own force is exact.
const LAG_N: f64 = 1e-4;
/// An exponential over a millisecond of a part that decays at 6e9 1/s is squared about 23 times. Each time
/// the error is rounding times the product of that time and rate, 1e-9.
const BALANCE: f64 = 5e-8;

#[test]
fn truth_a_drive_of_a_gigahertz_is_an_ideal_one() {
    let ideal = axis(0.05);
    let (expected, _) = run(&ideal);
    let mut fast = ideal.clone();
    let drive = &mut fast.machine.actuators["drive"];
    *drive = Actuator { kind: ActuatorKind::Force { bandwidth_hz: Some(1e9) }, ..drive.clone() };
    let mut lagging = ideal;
    lagging.machine.actuators["drive"].effects.push(effect("actuator-lag", &[1e-10]));
    for scenario in [fast, lagging] {
        let (found, simulation) = run(&scenario);
        assert_eq!(simulation.end(0), Some(RunEnd::Completed));
        assert_eq!(found.events.len(), expected.events.len());
        let forces = [&found, &expected].map(|trace| trace.column("tool.force").unwrap());
        assert!(forces[0].iter().zip(forces[1]).all(|(a, b)| (a - b).abs() < LAG_N));
        let balance = simulation.energy(0).unwrap();
        assert!(balance.residual().abs() < BALANCE * balance.exchanged(), "{balance:?}");
    }
}

/// A microgram on the motor, behind a spring and a damper: it settles within 10 ps.
#[test]
fn truth_a_body_of_a_microgram_moves_with_its_neighbours() {
    let mut scenario = axis(0.02);
    scenario.machine.bodies.insert("flake".into(), body(1e-9, 0.0));
    scenario.machine.springs.insert("grip".into(), spring("motor", "flake", 1e5, 100.0));
    let (trace, simulation) = run(&scenario);
    assert_eq!(simulation.end(0), Some(RunEnd::Completed));
    let (expected, _) = run(&axis(0.02));
    let forces = [&trace, &expected].map(|trace| trace.column("tool.force").unwrap());
    // A microgram at some hundred m/s2 takes 1e-7 N.
    assert!(forces[0].iter().zip(forces[1]).all(|(a, b)| (a - b).abs() < LAG_N));
}

/// A velocity source of 1e15 N s/m with a lag of 0.1 ms oscillates at 190 MHz on its body, so one polynomial
/// reaches a nanosecond. A machine at rest needs no such polynomials.
#[test]
fn regress_a_machine_at_rest_takes_no_steps_however_stiff_it_is() {
    let mut scenario = axis(0.1);
    scenario.controllers["force"].spec.reference = ReferenceSpec::Constant(0.0);
    scenario.machine.actuators["drive"].kind =
        ActuatorKind::VelocitySource { damping_n_s_per_m: 1e15, time_constant_s: 1e-4 };
    let (trace, simulation) = run(&scenario);
    // With polynomials, ten milliseconds would take ten million of them, and the run would end as an event
    // storm.
    assert_eq!(simulation.end(0), Some(RunEnd::Completed));
    assert!(trace.column("motor.position").unwrap().iter().all(|x| *x == 0.0));
}
