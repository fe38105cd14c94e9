//! Random machines: no panic, no event storm and no NaN, and the energy ledger closes.

use feeler_control::ForceGains;
use feeler_engine::{Integrator, RunEnd, Scenario};
use feeler_plant::description::{Contact, ContactLaw, GROUND, Machine, Quantity, Spring};
use feeler_plant::motion::MeterKind;
use proptest::prelude::*;

use crate::common::{body, contact, drive, effect, force_control, run, scenario, sensor, spring};

/// Residual relative to the energy exchanged. An impact of an integrated law costs about 1e-13, and there may
/// be hundreds.
const LEDGER: f64 = 1e-9;

fn log(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

/// A joint of two bodies with random elements.
fn joint() -> impl Strategy<Value = (f64, f64, u8, f64)> {
    (log(1e3, 1e7), log(1.0, 1e3), 0_u8..8, log(0.1, 10.0))
}

fn link(between: [&str; 2], (k, c, what, size): (f64, f64, u8, f64)) -> Spring {
    let mut link = spring(between[0], between[1], k, c);
    match what {
        0 => link.effects.push(effect("coulomb-friction", &[size])),
        1 => link.effects.push(effect("backlash", &[1e-4 * size, 0.0, 0.0])),
        2 => link.effects.push(effect("hardening-stiffness", &[1e7 * k * size])),
        3 => link.effects.push(effect("stribeck-friction", &[size, 1.5 * size, 5e-3])),
        4 => link
            .effects
            .extend([effect("load-friction", &[0.05 * size]), effect("asymmetric-friction", &[size, 0.5])]),
        5 => link.stiffness_n_per_m = 0.0,
        6 => link.effects.extend([
            effect("backlash", &[1e-4 * size, 0.0, 0.0]),
            effect("hardening-stiffness", &[1e7 * k * size]),
        ]),
        _ => {}
    }
    link
}

fn machines() -> impl Strategy<Value = Scenario> {
    let bodies = prop::collection::vec(
        (log(0.5, 20.0), -1e-3..1e-3, -0.05..0.05, joint(), any::<prop::sample::Index>()),
        2..6,
    );
    let contacts = prop::collection::vec(
        (log(1e4, 1e6), prop_oneof![Just(0.0), log(1.0, 1e3)], 0_u8..4, 0.0..5e-4, any::<bool>()),
        1..3,
    );
    (bodies, contacts, joint(), 0.0..1.0_f64, 0.0..2e-3).prop_map(|(bodies, contacts, extra, kp, delay_s)| {
        let mut machine = Machine::default();
        let names: Vec<String> = (0..bodies.len()).map(|i| format!("body-{i}")).collect();
        for (i, (mass, x, v, held, to)) in bodies.into_iter().enumerate() {
            let mut part = body(mass, x);
            part.velocity_m_per_s = v;
            machine.bodies.insert(names[i].clone(), part);
            // A tree: each body is attached to an earlier one or to ground.
            let on = match to.index(i + 1) {
                0 => GROUND,
                j => &names[j - 1],
            };
            machine.springs.insert(format!("link-{i}"), link([on, &names[i]], held));
        }
        // One more link, which may close a loop.
        let last = names.last().unwrap();
        machine.springs.insert("extra".into(), link([GROUND, last], extra));
        for (i, (stiffness, damping, law, gap_m, hardens)) in contacts.into_iter().enumerate() {
            let (law, stiffness) = match law {
                0 => (ContactLaw::Hertz, 100.0 * stiffness),
                1 => (ContactLaw::HuntCrossley { alpha_s_per_m: 2.0, exponent: 1.5 }, 100.0 * stiffness),
                _ => (ContactLaw::KelvinVoigt, stiffness),
            };
            let tip = if i == 0 { last } else { &names[0] };
            let effects = if hardens { vec![effect("hardening-stiffness", &[1e14])] } else { Vec::new() };
            machine.contacts.insert(
                format!("wall-{i}"),
                Contact { law, gap_m, effects, ..contact(tip, GROUND, stiffness, damping) },
            );
        }
        machine.actuators.insert("drive".into(), drive(&names[0], GROUND));
        machine.sensors.insert("force".into(), sensor("wall-0", Quantity::Force));
        let mut scenario = scenario(machine, 0.1, &["wall-0.force", "drive.force"]);
        force_control(
            &mut scenario,
            ForceGains { feed_forward: 1.0, kp: 0.3 * kp, ..ForceGains::default() },
            1e-3,
            10.0,
        );
        scenario.controllers["force"].spec.delay_s = delay_s;
        scenario.controllers["force"].spec.output_limit = Some(50.0);
        scenario
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn prop_random_machines_run_and_close_the_ledger(base in machines()) {
        let (trace, simulation) = run(&base);
        prop_assert_eq!(simulation.end(0), Some(RunEnd::Completed));
        prop_assert!(trace.columns.iter().flatten().chain(&simulation.state(0)).all(|x| x.is_finite()));
        let balance = simulation.energy(0).unwrap();
        let share = balance.residual().abs() / balance.exchanged();
        prop_assert!(share < LEDGER, "residual {:e}", share);
        for (kind, name, joule) in &balance.meters {
            let is_sink =
                matches!(kind, MeterKind::LinkDamping | MeterKind::Friction | MeterKind::ContactDamping);
            let is_taken = *joule >= -LEDGER * balance.exchanged();
            prop_assert!(!is_sink || is_taken, "{:?} of {} gave {} J", kind, name, joule);
        }
    }

    #[test]
    fn prop_random_machines_end_with_numbers_by_fixed_steps(base in machines(), method in 0..2_usize) {
        let mut scenario = base;
        scenario.run.integrator = [Integrator::Rk4, Integrator::SemiImplicitEuler][method];
        scenario.run.step_s = 1e-4;
        let (_, simulation) = run(&scenario);
        prop_assert!(simulation.state(0).iter().all(|x| x.is_finite()));
    }
}
