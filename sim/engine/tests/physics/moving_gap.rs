//! A gap with its own motion: exact for cubics, with the energy of its motion counted, the same in every
//! integrator.

use std::sync::Arc;

use feeler_engine::{Integrator, RunEnd};
use feeler_plant::description::{Contact, Engagement, GROUND, Knot, Profile};

use crate::common::{contact, force_control, free_mass, reference_machine, run, scenario};
use feeler_control::ForceGains;

/// Rounding of about 1e3 exponentials of motions of millimetres.
const ROUNDING_M: f64 = 1e-14;
/// Largest relative residual of the energy ledger.
const LEDGER: f64 = 1e-9;

/// Waves of 0.1 mm at 7 Hz for a second, in pieces whose lengths fit no period.
fn waves() -> Profile {
    let omega = 44.0;
    let knots: Vec<Knot> = (0..90)
        .map(|i| {
            let t_s = 0.011_3 * f64::from(i);
            Knot {
                t_s,
                offset_m: 1e-4 * f64::sin(omega * t_s),
                rate_m_per_s: 1e-4 * omega * f64::cos(omega * t_s),
            }
        })
        .collect();
    Profile::new(&knots).unwrap()
}

#[test]
fn truth_a_mass_on_a_spring_follows_a_cubic() {
    // m s'' + k (s - w) = 0 with w = a t + j t^3 / 6 has the solution s = w - (m/k) w'', if the motion starts
    // on it.
    let (m, k, a, j, end_s) = (2.0, 5e4, 3e-3, 0.4, 0.25);
    let rate = |t: f64| a + j * t * t / 2.0;
    let w = |t: f64| a * t + j * t * t * t / 6.0;
    let knots = [0.0, end_s].map(|t_s| Knot { t_s, offset_m: 7e-3 + w(t_s), rate_m_per_s: rate(t_s) });
    let mut machine = free_mass(m, 0.0, a - m / k * j);
    machine
        .contacts
        .insert("tool".into(), Contact { engagement: Engagement::Clamped, ..contact("tip", GROUND, k, 0.0) });
    machine.profiles.insert("tool".into(), Arc::new(Profile::new(&knots).unwrap()));
    let (trace, simulation) = run(&scenario(machine, end_s, &["tip.position", "tool.force"]));
    assert_eq!(simulation.end(0), Some(RunEnd::Completed));
    for (i, &t) in trace.t_s.iter().enumerate() {
        let expected = w(t) - m / k * j * t;
        let (position, force) = (trace.columns[0][i], trace.columns[1][i]);
        assert!((position - expected).abs() < ROUNDING_M, "{t}: {position} {expected}");
        assert!((force + m * j * t).abs() < k * ROUNDING_M, "{t}: {force}");
    }
}

#[test]
fn truth_ledger_closes_while_the_surface_moves() {
    for profile in [waves(), Profile::smooth(&[(0.05, 0.0), (0.3, 1e-3), (0.55, -2e-3)]).unwrap()] {
        let mut scenario = reference_machine(4, 0.8);
        scenario.machine.profiles.insert("tool".into(), Arc::new(profile));
        scenario.run.energy = true;
        let (trace, simulation) = run(&scenario);
        assert_eq!(simulation.end(0), Some(RunEnd::Completed));
        let balance = simulation.energy(0).unwrap();
        let share = balance.residual().abs() / balance.exchanged();
        println!("{share:.1e} of {:.2e} J, {} events", balance.exchanged(), trace.events.len());
        assert!(share < LEDGER && trace.events.len() > 2, "{share:e} {}", trace.events.len());
    }
}

#[test]
fn order_fixed_steps_converge_to_the_exact_motion() {
    let mut given = scenario(free_mass(5.0, 0.0, 0.0), 0.5, &["tip.position", "tool.force"]);
    given.machine.contacts.insert(
        "tool".into(),
        Contact { engagement: Engagement::Clamped, ..contact("tip", GROUND, 2e4, 60.0) },
    );
    given.machine.profiles.insert("tool".into(), Arc::new(waves()));
    given.run.energy = false;
    given.run.record_rate_hz = Some(100.0);
    let exact = run(&given).0;
    for (integrator, order, floor) in
        [(Integrator::Rk4, 4.0, 1e-13), (Integrator::SemiImplicitEuler, 1.0, 0.0)]
    {
        let errors = [4e-4, 2e-4].map(|step_s| {
            given.run.integrator = integrator;
            given.run.step_s = step_s;
            let found = run(&given).0;
            exact.columns[0].iter().zip(&found.columns[0]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        });
        // Steps end early at the ends of pieces, which leaves a tenth of an order to chance.
        let found = (errors[0] / errors[1]).log2();
        assert!(errors[1] < floor || (found - order).abs() < 0.2, "{integrator:?}: {errors:?} {found}");
    }
}

#[test]
fn prop_a_state_that_is_set_keeps_the_gap() {
    let mut given = reference_machine(2, 0.4);
    given.machine.profiles.insert("tool".into(), Arc::new(waves()));
    given.controllers.clear();
    given.machine.actuators.insert("drive".into(), crate::common::drive("motor", GROUND));
    given
        .machine
        .sensors
        .insert("force".into(), crate::common::sensor("tool", feeler_plant::description::Quantity::Force));
    force_control(&mut given, ForceGains { feed_forward: 1.0, ..ForceGains::default() }, 1e-3, 20.0);
    given.run.energy = false;
    let whole = run(&given).0;
    let program = feeler_engine::Program::new(&given).unwrap();
    let mut trace = feeler_engine::Trace::new(program.record_names());
    let mut simulation = feeler_engine::Simulation::<f64>::new(vec![program]).unwrap();
    simulation.run_to(0.15, &mut trace).unwrap();
    let state = simulation.state(0);
    simulation.set_state(0, &state).unwrap();
    simulation.run(&mut trace).unwrap();
    let worst =
        whole.columns[0].iter().zip(&trace.columns[0]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let size = whole.columns[0].iter().map(|x| x.abs()).fold(0.0, f64::max);
    assert!(worst < 1e-9 * size, "{worst} of {size}");
}
