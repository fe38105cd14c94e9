//! Machines of many bodies: uniform chains of springs and masses between two walls.

#![expect(
    clippy::unwrap_used,
    reason = "an analysis that fails or lacks a part fails the test that asks for it"
)]

use std::f64::consts::{PI, TAU};

use feeler_analysis::{Request, View, analyze};
use feeler_control::{ForceGains, Law};
use feeler_engine::{RunSettings, Scenario};
use feeler_plant::description::{Actuator, Body, Contact, Engagement, GROUND, Machine, Quantity};

use crate::common::{control, sensor, spring};

/// Stiffness and damping of every spring, SI; masses are 1 kg.
const SPRING: [f64; 2] = [1e5, 10.0];

/// Driven at one end; the force on the wall at the other is controlled.
fn chain(bodies: usize) -> Scenario {
    let [k, c] = SPRING;
    let mut machine = Machine::default();
    let name = |i: usize| if i == 0 { GROUND.to_owned() } else { format!("b{i}") };
    for i in 1..=bodies {
        machine.bodies.insert(name(i), Body { mass_kg: 1.0, ..Body::default() });
        machine.springs.insert(format!("s{i}"), spring(&name(i - 1), &name(i), k, c));
    }
    let contact =
        Contact { engagement: Engagement::Clamped, ..Contact::kelvin_voigt(name(bodies), GROUND, k, c) };
    machine.contacts.insert("tool".into(), contact);
    machine.actuators.insert("drive".into(), Actuator::ideal("b1", GROUND));
    machine.sensors.insert("force".into(), sensor("tool", Quantity::SpringForce));
    let law = Law::ExplicitForce(ForceGains { kp: 0.01, ..ForceGains::default() });
    let controllers = [("force".to_string(), control(law, "force", 1e-3, 0.0))].into_iter().collect();
    Scenario { machine, controllers, run: RunSettings::default() }
}

/// `omega_k = 2 sqrt(k / m) sin(k pi / (2 n + 2))`; damping in proportion to stiffness does not change the
/// modulus of a pole. The tolerance is the rounding of the largest frequency, amplified by the ratio of both.
#[test]
fn truth_a_uniform_chain_swings_at_its_closed_form() {
    for bodies in [3, 14, 24] {
        let request = Request { view: View::CLAMPED, brief: true, ..Request::default() };
        let report = analyze(&chain(bodies), &request).unwrap();
        assert_eq!(report.poles_hz.len(), bodies);
        for (i, found) in report.poles_hz.iter().enumerate() {
            let angle = (i + 1) as f64 * PI / (2 * bodies + 2) as f64;
            let truth = 2.0 * SPRING[0].sqrt() * angle.sin() / TAU;
            assert!((found - truth).abs() < 1e-9 * truth, "{bodies} {i}: {found} {truth}");
        }
    }
}

/// Neighbouring springs share a row of the waterfall, and only the most important parameters are varied. If
/// all masses, stiffnesses and dampings double, forces do not change, so the relative sensitivities of all
/// parameters add up to zero. The parameters left out can change this sum only by their own effect.
#[test]
fn truth_what_is_left_out_of_a_long_chain_matters_little() {
    // Of 24 bodies 32 of 74 parameters are varied, of 14 bodies 32 of 44.
    for (bodies, left_out) in [(14, 0.02), (24, 0.1)] {
        what_is_left_out_adds_up_to(left_out, bodies);
    }
}

fn what_is_left_out_adds_up_to(left_out: f64, bodies: usize) {
    let request = Request { view: View::CLAMPED, sensitivities: true, ..Request::default() };
    let report = analyze(&chain(bodies), &request).unwrap();
    let waterfall = report.waterfall().unwrap();
    let springs = waterfall.stages.iter().filter(|stage| stage.added.starts_with("springs.")).count();
    assert!((2..=12).contains(&springs) && waterfall.stages.len() <= 18, "{:?}", waterfall.stages);
    let all: Vec<f64> = report.sensitivities().iter().map(|s| s.largest_gain_relative).collect();
    let (sum, size) = (all.iter().sum::<f64>(), all.iter().map(|s| s.abs()).sum::<f64>());
    assert!(all.len() == 32 && sum.abs() < left_out * size, "{sum} of {size}: {all:?}");
}
