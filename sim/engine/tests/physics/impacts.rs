//! A free mass against a wall: the impact laws in closed form.

use feeler_engine::{EventKind, RunEnd};
use feeler_plant::description::{Contact, ContactLaw, GROUND, Machine, Spring};

use crate::common::{close, contact, effect, free_mass, run, scenario, spring};

/// Linear contacts are carried by exponentials and their ends found by Newton's rule: a few dozen roundings
/// of an impact's own size.
const EXACT: f64 = 1e-12;
/// Nonlinear contacts are integrated to 4e-14 per step, in tens of steps, and end at a root found to 1e-15 s.
/// A first integral is then a difference of logarithms of similar size.
const INTEGRATED: f64 = 1e-11;

fn against_wall(mass_kg: f64, speed_m_per_s: f64, contact: Contact) -> Machine {
    let mut machine = free_mass(mass_kg, 0.0, speed_m_per_s);
    machine.contacts.insert("wall".into(), contact);
    machine
}

/// Instants of touch and lift, and the remaining speed, of the first impact.
fn impact(machine: Machine, duration_s: f64) -> (f64, f64, f64) {
    let (trace, simulation) = run(&scenario(machine, duration_s, &["tip.velocity"]));
    assert_eq!(simulation.end(0), Some(RunEnd::Completed));
    let kinds: Vec<_> = trace.events.iter().map(|event| event.kind).collect();
    assert_eq!(kinds, [EventKind::Touch, EventKind::Lift]);
    (trace.events[0].t_s, trace.events[1].t_s, simulation.state(0)[1])
}

/// Form F of Schwager and Poeschel gives restitution and duration from `(zeta, c)`; for overdamping with the
/// hyperbolic functions.
#[test]
fn truth_kelvin_voigt_restitution_and_contact_time() {
    let (m, k, v) = (2.5_f64, 4e5_f64, 0.3);
    let omega = (k / m).sqrt();
    for zeta in [0.0_f64, 1e-3, 0.05, 0.2, 0.5, 0.9, 0.99, 1.01, 1.5, 4.0] {
        let duration = if zeta < 1.0 {
            let root = (1.0 - zeta * zeta).sqrt();
            (2.0 * zeta * root).atan2(2.0 * zeta * zeta - 1.0) / (omega * root)
        } else {
            let root = (zeta * zeta - 1.0).sqrt();
            ((zeta + root) / (zeta - root)).ln() / (omega * root)
        };
        let restitution = (-zeta * omega * duration).exp();
        let machine = against_wall(m, v, contact("tip", GROUND, k, 2.0 * zeta * (k * m).sqrt()));
        let (touch, lift, left) = impact(machine, 0.05);
        close(touch, 0.0, EXACT);
        close(lift - touch, duration, EXACT * duration.max(1.0));
        close(-left / v, restitution, EXACT);
    }
}

/// The two restitutions printed in the literature.
#[test]
fn reference_kelvin_voigt_restitution_as_printed() {
    /// The print has four digits.
    const PRINTED: f64 = 5e-5;
    for (zeta, e) in [(0.2, 0.5717), (0.5, 0.2984)] {
        let (m, k) = (1.0_f64, 1e4_f64);
        let (_, _, left) =
            impact(against_wall(m, 1.0, contact("tip", GROUND, k, 2.0 * zeta * (k * m).sqrt())), 0.1);
        close(-left, e, PRINTED);
    }
}

/// Form G: the relation between the speeds, and along the whole impact its first integral `d^(n+1) = (n+1) m
/// / (k a) (v_i - v - ln((1 + a v_i) / (1 + a v)) / a)`. Its value at `v = 0` is the largest compression.
#[test]
fn truth_hunt_crossley_speeds_and_compression() {
    let (m, v, k) = (1.5, 0.4, 3e6);
    for (n, k) in [(1.0, k), (1.5, k * 30.0), (2.0, k * 1e3)] {
        for a_v in [0.08, 0.32, 0.8] {
            let a = a_v / v;
            let law = ContactLaw::HuntCrossley { alpha_s_per_m: a, exponent: n };
            let machine = against_wall(m, v, Contact { law, ..contact("tip", GROUND, k, 0.0) });
            let (_, lift, left) = impact(machine.clone(), 0.05);
            let a_vo = -a * left;
            close(-a_vo - (-a_vo).ln_1p(), a_v - a_v.ln_1p(), INTEGRATED);

            let mut dense =
                scenario(machine, lift, &["wall.compression", "tip.velocity", "tip.acceleration"]);
            dense.run.step_s = lift / 64.0;
            let (trace, _) = run(&dense);
            let power = |speed: f64| {
                (n + 1.0) * m / (k * a) * (v - speed - ((1.0 + a_v) / (1.0 + a * speed)).ln() / a)
            };
            let largest = power(0.0).powf(1.0 / (n + 1.0));
            for (d, speed) in
                trace.column("wall.compression").unwrap().iter().zip(trace.column("tip.velocity").unwrap())
            {
                close(d.max(0.0).powf(n + 1.0) / power(0.0), power(*speed) / power(0.0), INTEGRATED);
            }
            let peak = trace.column("wall.compression").unwrap().iter().copied().fold(0.0, f64::max);
            assert!(
                peak <= largest * (1.0 + INTEGRATED) && peak > 0.99 * largest,
                "{peak} against {largest}"
            );
        }
    }
}

/// The printed restitutions of form G.
#[test]
fn reference_hunt_crossley_restitution_as_printed() {
    /// The print has six digits.
    const PRINTED: f64 = 5e-7;
    for (a_v, e) in [(0.08, 0.949_354), (0.32, 0.823_632), (0.8, 0.647_967)] {
        let law = ContactLaw::HuntCrossley { alpha_s_per_m: a_v / 0.5, exponent: 1.5 };
        let (_, _, left) =
            impact(against_wall(1.0, 0.5, Contact { law, ..contact("tip", GROUND, 1e8, 0.0) }), 0.02);
        close(-left / 0.5, e, PRINTED);
    }
}

/// Johnson, Contact Mechanics, section 11.4: `d_max = (5 m v^2 / (4 k))^(2/5)`, contact for
/// `2 sqrt(pi) Gamma(7/5) / Gamma(9/10) d_max / v`, and no loss.
#[test]
fn truth_hertz_contact_time_and_peak_force() {
    const SHAPE: f64 = 2.943_275_184_324_706;
    for (m, k, v) in [(0.2, 1e9, 0.1), (12.0, 2e7, 0.5), (12.0, 2e7, 0.01)] {
        let machine =
            against_wall(m, v, Contact { law: ContactLaw::Hertz, ..contact("tip", GROUND, k, 0.0) });
        let largest = (1.25 * m * v * v / k).powf(0.4);
        let duration = SHAPE * largest / v;
        let (touch, lift, left) = impact(machine.clone(), 2.0 * duration);
        close((lift - touch) / duration, 1.0, INTEGRATED);
        close(-left / v, 1.0, INTEGRATED);
        // At half time the mass is at rest and the force is largest.
        let mut half = scenario(machine, 0.5 * duration, &["wall.force", "tip.velocity"]);
        half.run.step_s = 0.5 * duration;
        let (trace, _) = run(&half);
        close(trace.column("wall.force").unwrap()[1] / (k * largest.powf(1.5)), 1.0, INTEGRATED);
        close(trace.column("tip.velocity").unwrap()[1] / v, 0.0, INTEGRATED);
    }
}

/// Two free bodies: the centre of mass keeps its motion, and the relative motion is that of the reduced mass.
#[test]
fn truth_impact_of_two_free_bodies_keeps_the_momentum() {
    let (m1, m2, v, k, zeta) = (2.0_f64, 3.0, 0.6, 1e6_f64, 0.1_f64);
    let mu = m1 * m2 / (m1 + m2);
    let mut machine = free_mass(m1, -1e-3, v);
    machine.bodies.insert("ball".into(), crate::common::body(m2, 0.0));
    machine.contacts.insert("wall".into(), contact("tip", "ball", k, 2.0 * zeta * (k * mu).sqrt()));
    let (trace, simulation) = run(&scenario(machine, 0.05, &[]));
    let root = (1.0 - zeta * zeta).sqrt();
    let phase = (2.0 * zeta * root).atan2(2.0 * zeta * zeta - 1.0) / root;
    let e = (-zeta * phase).exp();
    let state = simulation.state(0);
    let mean = m1 * v / (m1 + m2);
    close(trace.events[0].t_s, 1e-3 / v, EXACT);
    close(trace.events[1].t_s, 1e-3 / v + phase / (k / mu).sqrt(), EXACT);
    close(state[2], mean - e * v * m2 / (m1 + m2), EXACT);
    close(state[3], mean + e * v * m1 / (m1 + m2), EXACT);
}

/// Rounding of a force of some hundred newtons, and of the compression it is computed from.
const FORCE: f64 = 1e-8;

/// `max(0, k d^n (1 + alpha d') + c d' + cubic d^3)` for a tip on a wall.
fn law_force(law: ContactLaw, [k, c, cubic]: [f64; 3], [d, rate]: [f64; 2]) -> f64 {
    let (exponent, alpha) = match law {
        ContactLaw::Hertz => (1.5, 0.0),
        ContactLaw::HuntCrossley { alpha_s_per_m, exponent } => (exponent, alpha_s_per_m),
        ContactLaw::KelvinVoigt => (1.0, 0.0),
    };
    let force = k * d.max(0.0).powf(exponent) * (1.0 + alpha * rate) + c * rate + cubic * d.powi(3);
    if d > 0.0 { force.max(0.0) } else { 0.0 }
}

#[test]
fn truth_a_contact_pushes_as_its_law_says_and_never_pulls() {
    let hunt_crossley = |alpha_s_per_m, exponent| ContactLaw::HuntCrossley { alpha_s_per_m, exponent };
    let laws = [
        (ContactLaw::KelvinVoigt, 2e5),
        (ContactLaw::Hertz, 2e7),
        (hunt_crossley(3.0, 1.5), 2e7),
        (hunt_crossley(8.0, 1.0), 2e5),
        (hunt_crossley(8.0, 3.0), 1e12),
        (hunt_crossley(8.0, 3.5), 1e13),
    ];
    for (law, k) in laws {
        for (c, cubic) in [(0.0, 0.0), (150.0, 0.0), (0.0, 1e12), (150.0, 1e12)] {
            // A soft spring with tension presses the mass against the wall, so that it bounces. At the first
            // speed the mass leaves the wall so fast that most laws would pull.
            for velocity_m_per_s in [-0.6, -0.1, 0.4] {
                let mut machine = free_mass(2.0, 6e-4, velocity_m_per_s);
                machine.springs.insert(
                    "press".into(),
                    Spring {
                        effects: vec![effect("constant-load", &[150.0])],
                        ..spring(GROUND, "tip", 2e3, 1.0)
                    },
                );
                let effects =
                    if cubic > 0.0 { vec![effect("hardening-stiffness", &[cubic])] } else { Vec::new() };
                machine
                    .contacts
                    .insert("wall".into(), Contact { law, effects, ..contact("tip", GROUND, k, c) });
                let mut scenario = scenario(machine, 0.2, &["wall.force", "tip.position", "tip.velocity"]);
                scenario.run.step_s = 2e-4;
                let (trace, simulation) = run(&scenario);
                assert_eq!(
                    simulation.end(0),
                    Some(RunEnd::Completed),
                    "{law:?} {c} {cubic} {velocity_m_per_s}"
                );
                let [force, position, velocity] = [0, 1, 2].map(|i| &trace.columns[i]);
                assert!(
                    force.iter().filter(|f| **f > 0.0).count() > 10,
                    "{law:?} {c} {cubic}: hardly any contact"
                );
                for (i, f) in force.iter().enumerate() {
                    let expected = law_force(law, [k, c, cubic], [position[i], velocity[i]]);
                    assert!(
                        (f - expected).abs() < FORCE * (1.0 + expected),
                        "{law:?} {c} {cubic} {velocity_m_per_s}: row {i}: {f} {expected}"
                    );
                }
            }
        }
    }
}
