//! Guides that stick and break loose: one outcome, whatever the law of their friction.

#![expect(clippy::unwrap_used, reason = "a file that cannot be read or run fails the test that asks for it")]

use feeler_files::{Document, Draft};
use feeler_studies::run::{Outcome, PreparedRun, Summary};

/// A mass under a PID position loop that hunts. Source: C. Canudas de Wit, H. Olsson, K. J. Åström and
/// P. Lischinsky, IEEE Transactions on Automatic Control 40 (1995).
fn positioned(friction: &str) -> Summary {
    let text = format!(
        r#"
[bodies.m]
mass = 1.0
[springs.guide]
between = ["ground", "m"]
damping = 0.4
{friction}
[actuators.drive]
on = "m"
[sensors.enc]
reads = "m.position"
[controllers.c]
law = "position"
reads = "enc"
drives = "drive"
period = 0.001
kp = 3.0
ki = 4.0
kd = 6.0
derivative_filter = 0.002
reference = 1.0
[run]
duration = 100.0
"#
    );
    measured(&Document::parse(&text, "axis.toml").unwrap())
}

fn measured(document: &Document) -> Summary {
    PreparedRun::new(document.scenario.clone()).and_then(|candidate| candidate.measure(0)).unwrap().summary
}

/// The axis of `chatter/stiction.toml` with another friction in its guide.
fn in_contact(friction: &[&str]) -> Summary {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/chatter/stiction.toml");
    let mut draft = Draft::load(std::path::Path::new(file)).unwrap();
    draft.set("controllers.force.damping=100").unwrap();
    for setting in friction {
        draft.set(setting).unwrap();
    }
    measured(&draft.build().unwrap())
}

/// Bristles bend before the mass breaks loose, so the two periods differ a little.
const SIMILAR: f64 = 0.05;

#[test]
fn truth_an_integrator_hunts_on_stribeck_friction_and_on_bristles() {
    let of = |law: &str, level: f64| {
        positioned(&format!(
            "[springs.guide.effects.{law}\ncoulomb = 1.0\nstatic = {level}\nvelocity = 0.001\n"
        ))
    };
    let (stribeck, bristles) = ("stribeck-friction]", "lugre-friction]\nstiffness = 1e5\ndamping = 316.2");
    let hunts = [stribeck, bristles].map(|law| {
        let summary = of(law, 1.5);
        assert_eq!(summary.outcome, Outcome::Hunting, "{law}: {:?}", summary.verdict);
        summary.oscillation.unwrap().frequency_hz
    });
    // It sticks for 20 s of each cycle; the drive needs that long to wind up.
    assert!((0.03..0.05).contains(&hunts[0]), "{hunts:?}");
    assert!((hunts[1] / hunts[0] - 1.0).abs() < SIMILAR, "{hunts:?}");
    assert_eq!(positioned("").outcome, Outcome::Settled);
}

#[test]
fn truth_a_force_loop_hunts_on_bristles_as_on_stribeck_friction() {
    let bristles = |level: f64| {
        let law = "springs.guide.effects.lugre-friction";
        in_contact(&[
            "springs.guide.effects.stribeck-friction.static=0",
            "springs.guide.effects.stribeck-friction.coulomb=0",
            &format!("{law}.stiffness=3e7"),
            &format!("{law}.damping=6e3"),
            &format!("{law}.coulomb=10"),
            &format!("{law}.static={level}"),
            &format!("{law}.velocity=0.001"),
        ])
    };
    let (stribeck, hunts) = (in_contact(&[]), bristles(30.0));
    for summary in [&stribeck, &hunts] {
        assert_eq!(summary.outcome, Outcome::Hunting, "{:?}", summary.verdict);
    }
    let hz = |summary: &Summary| summary.oscillation.unwrap().frequency_hz;
    assert!((hz(&hunts) / hz(&stribeck) - 1.0).abs() < 0.2, "{} {}", hz(&hunts), hz(&stribeck));
    // Without a surplus at rest nothing throws the axis past its reference.
    assert_eq!(bristles(10.0).outcome, Outcome::Settled);
}
