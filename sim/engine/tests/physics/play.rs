//! Free play between two bodies.

use std::f64::consts::PI;

use feeler_engine::EventKind;
use feeler_plant::description::{Body, GROUND, Spring};

use crate::common::{body, close, effect, free_mass, run, scenario, spring};

/// Every flight and every visit to a flank is exact to a few roundings; there are tens of them.
const EXACT: f64 = 1e-12;

/// Without damping, flights of `width / v` alternate for ever with visits to the flanks, each half a period
/// of the reduced mass.
#[test]
fn truth_undamped_play_alternates_between_flights_and_flanks() {
    let (m1, m2, k, width, v) = (2.0, 3.0, 4e5_f64, 1e-3, 0.2);
    let mut machine = free_mass(m1, 0.0, v);
    machine.bodies.insert("load".into(), body(m2, 0.0));
    let play =
        Spring { effects: vec![effect("backlash", &[width, 0.0, 0.0])], ..spring("tip", "load", k, 0.0) };
    machine.springs.insert("joint".into(), play);
    let (trace, simulation) = run(&scenario(machine, 0.2, &[]));
    let visit = PI / (k * (1.0 / m1 + 1.0 / m2)).sqrt();
    assert!(trace.events.len() > 30);
    let mut expected = 0.5 * width / v;
    for pair in trace.events.chunks_exact(2) {
        assert_eq!([pair[0].kind, pair[1].kind], [EventKind::Touch, EventKind::Lift]);
        close(pair[0].t_s, expected, EXACT);
        close(pair[1].t_s, expected + visit, EXACT);
        expected += visit + width / v;
    }
    let momentum = m1 * simulation.state(0)[2] + m2 * simulation.state(0)[3];
    close(momentum, m1 * v, EXACT);
    assert!(simulation.energy(0).unwrap().residual().abs() < EXACT);
}

/// A load dragged against friction lags by half the width plus the stretch of the flank, in both directions:
/// this is the hysteresis.
#[test]
fn truth_play_lags_by_half_its_width_and_the_stretch_of_a_flank() {
    let (k, width, level, speed) = (4e4, 1e-3, 6.0, 0.05);
    let lag = |direction: f64| {
        let mut machine = free_mass(1e15, 0.0, direction * speed);
        machine.bodies.insert("load".into(), Body { velocity_m_per_s: direction * speed, ..body(1.0, 0.0) });
        let play = Spring {
            effects: vec![effect("backlash", &[width, 0.0, 0.0])],
            ..spring("tip", "load", k, 100.0)
        };
        machine.springs.insert("joint".into(), play);
        let rubbing = Spring {
            effects: vec![effect("coulomb-friction", &[level])],
            ..spring(GROUND, "load", 0.0, 0.0)
        };
        machine.springs.insert("guide".into(), rubbing);
        let (trace, _) = run(&scenario(machine, 2.0, &["tip.position", "load.position"]));
        trace.column("tip.position").unwrap().last().unwrap()
            - trace.column("load.position").unwrap().last().unwrap()
    };
    close(lag(1.0), 0.5 * width + level / k, EXACT);
    close(lag(-1.0), -(0.5 * width + level / k), EXACT);
}

/// Inside the play there is neither stiffness nor damping: a body that does not reach the flanks moves
/// freely.
#[test]
fn truth_nothing_acts_inside_the_play() {
    let mut machine = free_mass(2.0, 0.0, 0.01);
    let play =
        Spring { effects: vec![effect("backlash", &[0.1, 0.0, 0.0])], ..spring(GROUND, "tip", 1e6, 1e3) };
    machine.springs.insert("joint".into(), play);
    let (trace, simulation) = run(&scenario(machine, 4.0, &[]));
    assert!(trace.events.is_empty());
    assert_eq!(simulation.state(0)[1].to_bits(), 0.01_f64.to_bits());
    close(simulation.state(0)[0], 0.04, EXACT);
}

/// A flank with damping is an impact by form F at either side: the relative speed falls by its restitution
/// every time.
#[test]
fn truth_damped_flanks_have_the_restitution_of_kelvin_and_voigt() {
    let (m, k, zeta, v) = (2.0_f64, 1e6_f64, 0.2_f64, 0.5);
    let mut machine = free_mass(m, 0.0, v);
    let damping = 2.0 * zeta * (k * m).sqrt();
    let play =
        Spring { effects: vec![effect("backlash", &[1e-2, 0.0, 0.0])], ..spring(GROUND, "tip", k, damping) };
    machine.springs.insert("joint".into(), play);
    let (trace, _) = run(&scenario(machine, 0.5, &["tip.velocity"]));
    let root = (1.0 - zeta * zeta).sqrt();
    let visit = (2.0 * zeta * root).atan2(2.0 * zeta * zeta - 1.0) / root;
    let e = (-zeta * visit).exp();
    let lifts: Vec<f64> =
        trace.events.iter().filter(|event| event.kind == EventKind::Lift).map(|event| event.t_s).collect();
    assert!(lifts.len() >= 3);
    // The speed well after each lift, from the record.
    for (visits, lift) in (1..=3).zip(&lifts) {
        let at = (lift / 1e-3).ceil() as usize + 2;
        close(trace.column("tip.velocity").unwrap()[at].abs(), v * e.powi(visits), EXACT);
    }
}
