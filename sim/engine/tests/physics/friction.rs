//! Dry friction: it sticks exactly, and slides by closed forms.

use std::f64::consts::{PI, TAU};

use feeler_control::ReferenceSpec;
use feeler_control::reference::ChirpSweep;
use feeler_engine::{EventKind, Program, RunEnd, Scenario, Simulation, Unobserved};
use feeler_plant::description::{Body, Contact, GROUND, Machine, Spring};

use crate::common::{body, close, command, contact, drive, effect, free_mass, run, scenario, spring};

/// A handful of steps, each exact to a few roundings.
const EXACT: f64 = 1e-12;

fn rubbing(between: [&str; 2], effects: &[(&str, &[f64])]) -> Spring {
    let effects = effects.iter().map(|(kind, values)| effect(kind, values)).collect();
    Spring { effects, ..spring(between[0], between[1], 0.0, 0.0) }
}

/// A body with this friction against ground under a swept force of this amplitude for 60 s.
fn shaken(friction: &[(&str, &[f64])], amplitude_n: f64, mean_n: f64) -> Scenario {
    let mut machine = free_mass(3.0, 0.1234, 0.0);
    machine.springs.insert("guide".into(), rubbing([GROUND, "tip"], friction));
    machine.actuators.insert("drive".into(), drive("tip", GROUND));
    let mut shaken = scenario(machine, 60.0, &["tip.position", "tip.velocity", "guide.force"]);
    shaken.run.step_s = 1e-2;
    let (start_hz, end_hz) = (0.1, 40.0);
    let sweep = ReferenceSpec::Chirp {
        sweep: ChirpSweep::Linear,
        amplitude: amplitude_n,
        start_hz,
        end_hz,
        duration_s: 60.0,
        offset: mean_n,
    };
    command(&mut shaken, "shaker", sweep, 1e-2);
    shaken
}

#[test]
fn truth_friction_below_breakaway_holds_to_the_bit_for_a_minute() {
    let cases: [&[(&str, &[f64])]; 4] = [
        &[("coulomb-friction", &[10.0])],
        &[("stribeck-friction", &[4.0, 10.0, 1e-2])],
        &[("asymmetric-friction", &[12.5, -0.2])],
        &[("coulomb-friction", &[10.0]), ("constant-load", &[5.0]), ("viscous-friction", &[30.0])],
    ];
    for friction in cases {
        let loaded = friction.len() > 1;
        let (trace, simulation) = run(&shaken(friction, 3.9, if loaded { 1.0 } else { 6.0 }));
        assert_eq!(simulation.end(0), Some(RunEnd::Completed));
        assert_eq!(trace.t_s.len(), 6001);
        assert!(trace.events.is_empty(), "{friction:?}: {:?}", trace.events);
        let still = |name: &str, value: f64| {
            trace.column(name).unwrap().iter().all(|x| x.to_bits() == value.to_bits())
        };
        assert!(still("tip.velocity", 0.0) && still("tip.position", 0.1234), "{friction:?}");
    }
}

#[test]
fn truth_friction_breaks_away_at_its_level() {
    // A force that grows by 2 N/s beyond the levels of 10 N, and by the same rate backwards.
    for (friction, forward, backward) in [
        (effect("coulomb-friction", &[10.0]), 10.0, 10.0),
        (effect("stribeck-friction", &[4.0, 10.0, 1e-2]), 10.0, 10.0),
        (effect("asymmetric-friction", &[10.0, 0.3]), 13.0, 7.0),
    ] {
        for (sign, level) in [(1.0, forward), (-1.0, backward)] {
            let mut machine = free_mass(3.0, 0.0, 0.0);
            machine.springs.insert(
                "guide".into(),
                Spring { effects: vec![friction.clone()], ..spring(GROUND, "tip", 0.0, 0.0) },
            );
            let mut pushed = drive("tip", GROUND);
            pushed.rate_limit_per_s = Some(2.0);
            machine.actuators.insert("drive".into(), pushed);
            let mut ramp = scenario(machine, 8.0, &["tip.velocity"]);
            command(&mut ramp, "push", ReferenceSpec::Constant(sign * 100.0), 10.0);
            let (trace, _) = run(&ramp);
            assert_eq!(
                trace.events.iter().map(|event| event.kind).collect::<Vec<_>>(),
                [EventKind::Slip],
                "{friction:?}"
            );
            close(trace.events[0].t_s, 0.5 * level, EXACT * level);
        }
    }
}

#[test]
fn truth_bodies_that_stick_together_move_alike_to_the_bit() {
    // The lower body is shaken. Only friction carries the upper one, whose inertia stays below the friction
    // level.
    let mut machine = free_mass(3.0, 0.0, 0.0);
    machine.bodies.insert("rider".into(), body(2.0, 0.05));
    machine.bodies.insert("pillion".into(), body(1.0, 0.07));
    machine.springs.insert("joint".into(), rubbing(["tip", "rider"], &[("coulomb-friction", &[9.0])]));
    machine
        .springs
        .insert("second".into(), rubbing(["pillion", "rider"], &[("stribeck-friction", &[2.0, 4.0, 1e-3])]));
    machine.springs.insert("guide".into(), spring(GROUND, "tip", 300.0, 5.0));
    machine.actuators.insert("drive".into(), drive("tip", GROUND));
    let mut shaken = scenario(machine, 5.0, &["tip.velocity", "rider.velocity", "pillion.velocity"]);
    let (start_hz, end_hz) = (0.5, 5.0);
    let sweep = ReferenceSpec::Chirp {
        sweep: ChirpSweep::Linear,
        amplitude: 2.0,
        start_hz,
        end_hz,
        duration_s: 5.0,
        offset: 0.0,
    };
    command(&mut shaken, "shaker", sweep, 1e-3);
    let (trace, _) = run(&shaken);
    assert!(trace.events.is_empty(), "{:?}", trace.events);
    let [tip, rider, pillion] =
        ["tip", "rider", "pillion"].map(|name| trace.column(&format!("{name}.velocity")).unwrap());
    assert!(tip.iter().any(|v| v.abs() > 0.02));
    for ((a, b), c) in tip.iter().zip(rider).zip(pillion) {
        assert!(a.to_bits() == b.to_bits() && a.to_bits() == c.to_bits());
    }
}

#[test]
fn truth_sliding_body_stops_after_its_energy_is_spent() {
    let (m, v, level) = (3.0, 0.7, 8.0);
    let mut machine = free_mass(m, 0.0, v);
    machine.springs.insert("guide".into(), rubbing([GROUND, "tip"], &[("coulomb-friction", &[level])]));
    let (trace, simulation) = run(&scenario(machine, 1.0, &[]));
    close(trace.events[0].t_s, m * v / level, EXACT);
    assert_eq!((trace.events.len(), trace.events[0].kind), (1, EventKind::Stick));
    close(simulation.state(0)[0], 0.5 * m * v * v / level, EXACT);
    assert_eq!(simulation.state(0)[1].to_bits(), 0.0_f64.to_bits());
}

#[test]
fn truth_sliding_body_takes_the_other_along_at_the_common_speed() {
    // Friction between two free bodies ends their relative motion at the speed of the centre of mass.
    let (m1, m2, v, level) = (3.0, 2.0, 0.7, 8.0);
    let mut machine = free_mass(m1, 0.0, v);
    machine.bodies.insert("rider".into(), body(m2, 0.0));
    machine.springs.insert("joint".into(), rubbing(["tip", "rider"], &[("coulomb-friction", &[level])]));
    let (trace, simulation) = run(&scenario(machine, 1.0, &[]));
    let mu = m1 * m2 / (m1 + m2);
    close(trace.events[0].t_s, mu * v / level, EXACT);
    close(simulation.state(0)[2], m1 * v / (m1 + m2), EXACT);
    assert_eq!(simulation.state(0)[2].to_bits(), simulation.state(0)[3].to_bits());
}

/// A mass on a spring and a rough floor: each half swing is `2 F / k` shorter than the last, and lasts half
/// an undamped period.
#[test]
fn truth_rough_oscillator_loses_the_same_amplitude_every_half_swing() {
    let (m, k, level, start) = (2.0_f64, 800.0_f64, 3.0, 0.1);
    let mut machine = free_mass(m, start, 0.0);
    machine.springs.insert(
        "guide".into(),
        Spring { stiffness_n_per_m: k, ..rubbing([GROUND, "tip"], &[("coulomb-friction", &[level])]) },
    );
    let (trace, simulation) = run(&scenario(machine, 6.0, &[]));
    let half = PI / (k / m).sqrt();
    // The mass comes to rest at the first turn with k |x| <= level: 0.1 - 13 * 0.0075 = 0.0025 < 0.00375 (the
    // turn before is at 0.01).
    let swings = 13;
    let turns: Vec<f64> = trace.events.iter().map(|event| event.t_s).collect();
    assert_eq!(turns.len(), swings + 1, "{turns:?}");
    for (i, t) in turns.iter().enumerate() {
        close(*t, half * i as f64, EXACT);
    }
    assert_eq!(trace.events[swings].kind, EventKind::Stick);
    close(simulation.state(0)[0], -(start - 2.0 * level / k * 13.0), EXACT);
}

/// A spring drags a block; the body that pulls it is too heavy to slow down. Static friction exceeds kinetic
/// friction by `D`. Slips last `(2 pi - 2 atan(D w / (k V))) / w`, sticks `2 D / (k V)`.
#[test]
fn truth_stick_slip_period_on_a_pulled_spring() {
    let (m, k, pull, kinetic, excess) = (1.0_f64, 1000.0_f64, 0.02_f64, 3.0, 2.0);
    let omega = (k / m).sqrt();
    let period = (TAU - 2.0 * (excess * omega / (k * pull)).atan()) / omega + 2.0 * excess / (k * pull);
    let error = |stribeck_speed: f64| {
        let mut machine = free_mass(m, 0.0, 0.0);
        machine.bodies.insert("puller".into(), Body { velocity_m_per_s: pull, ..body(1e18, 0.0) });
        machine.springs.insert("spring".into(), spring("tip", "puller", k, 0.0));
        let levels = [kinetic, kinetic + excess, stribeck_speed];
        machine.springs.insert("guide".into(), rubbing([GROUND, "tip"], &[("stribeck-friction", &levels)]));
        let (trace, _) = run(&scenario(machine, 1.6, &[]));
        let of = |kind| trace.events.iter().filter(|e| e.kind == kind).map(|e| e.t_s).collect::<Vec<_>>();
        let (slips, sticks) = (of(EventKind::Slip), of(EventKind::Stick));
        close(slips[0], (kinetic + excess) / (k * pull), EXACT);
        assert!(slips.len() >= 4 && sticks.len() >= 3);
        let measured = slips[3] - slips[2];
        close(slips[2] - slips[1], measured, 1e-9);
        (measured - period) / period
    };
    // From rest the excess force grows as k V t, so the level stays static until about sqrt(2 m v_s / (k V)).
    // That time is added.
    let late = |stribeck_speed: f64| (2.0 * m * stribeck_speed / (k * pull)).sqrt() / period;
    let (coarse, fine) = (error(1e-6), error(1e-10));
    assert!(
        coarse.abs() < 2.0 * late(1e-6) && fine.abs() < 2.0 * late(1e-10),
        "{coarse:e} {fine:e}, late {:e}",
        late(1e-10)
    );
}

/// Coulomb friction alone has no jump, so the pulled block oscillates about the pull's speed and just reaches
/// rest once a period.
#[test]
fn truth_slip_without_excess_is_an_oscillation_about_the_pull() {
    let (m, k, pull, level) = (1.0_f64, 1000.0_f64, 0.02_f64, 3.0);
    let omega = (k / m).sqrt();
    let mut machine = free_mass(m, 0.0, 0.0);
    machine.bodies.insert("puller".into(), Body { velocity_m_per_s: pull, ..body(1e18, 0.0) });
    machine.springs.insert("spring".into(), spring("tip", "puller", k, 0.0));
    machine.springs.insert("guide".into(), rubbing([GROUND, "tip"], &[("coulomb-friction", &[level])]));
    let start = level / (k * pull);
    let mut dragged = scenario(machine, start + 0.9 * TAU / omega, &["tip.velocity"]);
    dragged.run.step_s = 1e-3;
    let (trace, _) = run(&dragged);
    close(trace.events[0].t_s, start, EXACT);
    for (t, v) in trace.t_s.iter().zip(trace.column("tip.velocity").unwrap()) {
        let expected = if *t < start { 0.0 } else { pull * (1.0 - (omega * (t - start)).cos()) };
        close(*v, expected, EXACT);
    }
}

fn two_guides(push_n: f64, velocity_m_per_s: f64) -> Scenario {
    let mut machine: Machine = free_mass(3.0, 0.0, velocity_m_per_s);
    machine.springs.insert("left".into(), rubbing([GROUND, "tip"], &[("coulomb-friction", &[5.0])]));
    machine
        .springs
        .insert("right".into(), rubbing(["tip", GROUND], &[("asymmetric-friction", &[10.0, 0.2])]));
    machine.actuators.insert("drive".into(), drive("tip", GROUND));
    let mut held = scenario(machine, 2.0, &["tip.velocity"]);
    command(&mut held, "push", ReferenceSpec::Steps(vec![(1.0, push_n)]), 0.5);
    held
}

/// Two parallel guides hold the sum of both levels. It is 5 + 8 N forward (the right one is mounted the other
/// way round) and 5 + 12 N backward.
#[test]
fn regress_parallel_guides_hold_the_sum_of_their_levels() {
    for v in [0.0, 0.01, -0.01] {
        for (push, holds) in [(12.9, true), (13.1, false), (-16.9, true), (-17.1, false)] {
            let (trace, simulation) = run(&two_guides(push, v));
            let v = simulation.state(0)[1];
            assert_eq!(v == 0.0, holds, "pushed with {push} N: {v} m/s, {:?}", trace.events);
            let free: f64 = if push > 0.0 { push - 13.0 } else { push + 17.0 };
            close(v, if holds { 0.0 } else { free / 3.0 }, EXACT);
            assert!(simulation.energy(0).unwrap().residual().abs() < EXACT);
        }
    }
}

/// A rider on a sliding body: both come to rest at exactly zero speed, whatever the order of the guides in
/// the file.
#[test]
fn regress_a_chain_of_sticking_bodies_rests_to_the_bit() {
    for order in [["joint", "guide"], ["guide", "joint"]] {
        let mut machine = free_mass(3.0, 0.0, 0.7);
        machine.bodies.insert("rider".into(), Body { velocity_m_per_s: 0.9, ..body(2.0, 0.0) });
        for name in order {
            let between = if name == "joint" { ["rider", "tip"] } else { [GROUND, "tip"] };
            machine.springs.insert(name.into(), rubbing(between, &[("coulomb-friction", &[8.0])]));
        }
        let (trace, simulation) = run(&scenario(machine, 2.0, &[]));
        assert_eq!(trace.events.iter().filter(|event| event.kind == EventKind::Stick).count(), 2);
        for speed in &simulation.state(0)[2..] {
            assert_eq!(speed.to_bits(), 0.0_f64.to_bits(), "{order:?}");
        }
    }
}

/// A state that is set is in its own mode: stuck bodies may move, separated bodies may touch.
#[test]
fn regress_a_state_that_is_set_is_in_its_own_mode() {
    let mut machine = free_mass(3.0, 0.0, 0.0);
    machine.springs.insert("guide".into(), rubbing([GROUND, "tip"], &[("coulomb-friction", &[8.0])]));
    machine.contacts.insert("wall".into(), Contact { gap_m: 0.01, ..contact("tip", GROUND, 1e4, 0.0) });
    let program = Program::new(&scenario(machine, 1.0, &["wall.contact"])).unwrap();
    let mut simulation = Simulation::<f64>::new(vec![program]).unwrap();
    simulation.run_to(0.1, &mut Unobserved).unwrap();
    // It starts 10 mm inside the wall, whose energy lengthens the braking distance.
    simulation.set_state(0, &[0.02, -0.5]).unwrap();
    simulation.run_to(0.9, &mut Unobserved).unwrap();
    let energy = 0.5 * 3.0 * 0.25 + 0.5 * 1e4 * 1e-4;
    close(simulation.state(0)[0], 0.02 - energy / 8.0, EXACT);
    assert_eq!(simulation.state(0)[1].to_bits(), 0.0_f64.to_bits());
    assert!(simulation.energy(0).unwrap().residual().abs() < EXACT);
}

#[test]
fn regress_rest_is_seen_although_an_event_later_in_the_same_step_was_found_first() {
    // Touch-down raises the friction of a loaded slide that barely moves, so it stops at once. Lift-off ends
    // the same step of the nonlinear mode. Beyond lift-off, where the damper would pull, the slide would move
    // forward again.
    let (ratio, damping, speed, creep, gap_m) = (0.43, 780.0, 0.1, 1e-8, 3.4e-4);
    let mut machine = free_mass(1.0, gap_m - 1e-9, speed);
    let hardening =
        Spring { effects: vec![effect("hardening-stiffness", &[6e13])], ..spring(GROUND, "tip", 6e6, 1.0) };
    machine.springs.insert("hard".into(), hardening);
    machine.contacts.insert("wall".into(), Contact { gap_m, ..contact("tip", GROUND, 1e4, damping) });
    machine.bodies.insert("slide".into(), Body { velocity_m_per_s: creep, ..body(1.0, 0.0) });
    machine.springs.insert("guide".into(), rubbing([GROUND, "slide"], &[("load-friction", &[ratio])]));
    let (trace, simulation) = run(&scenario(machine, 1e-3, &["slide.velocity"]));
    assert_eq!(simulation.end(0), Some(RunEnd::Completed));
    let first = |kind| trace.events.iter().find(|event| event.kind == kind).unwrap().t_s;
    // The speed of touch-down differs from the initial one by 4e-4, the force within this time by less.
    let expected_s = creep / (ratio * damping * speed);
    close(first(EventKind::Stick) - first(EventKind::Touch), expected_s, 1e-3 * expected_s);
    assert_eq!(trace.column("slide.velocity").unwrap().last(), Some(&0.0));
    let balance = simulation.energy(0).unwrap();
    close(balance.residual(), 0.0, EXACT * balance.exchanged());
}
