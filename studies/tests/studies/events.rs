//! Events that happen once are reported once, whatever the rounding of the instant.

use feeler_engine::{EventKind, Integrator};
use feeler_files::{Document, Setting};
use feeler_studies::run::{RunResult, run};

use crate::common::{file, result_of};

/// Events of one guide or contact closer than this are one event reported twice: the machines here need a
/// thousand times longer.
const APART_S: f64 = 1e-9;

/// The wall at zero and the tip in front of it, or the tip at zero and a gap. Both are the same machine, but
/// the first touches at a compression of pure rounding.
#[test]
fn regress_a_touch_of_an_undamped_nonlinear_contact_is_one() {
    for (law, alpha) in [("hunt-crossley", 0.3), ("hunt-crossley", 0.0), ("hertz", 0.0)] {
        let bounces = |gap: [(&'static str, Setting); 2]| {
            let mut settings = vec![
                ("contacts.tool.law", Setting::Text(law.into())),
                ("contacts.tool.damping", Setting::Number(0.0)),
                ("run.duration", Setting::Number(0.6)),
            ];
            match law {
                "hertz" => settings.push(("contacts.tool.stiffness", Setting::Number(1e7))),
                _ => settings.push(("contacts.tool.alpha", Setting::Number(alpha))),
            }
            settings.extend(gap);
            let result = result_of(&file("reference/m1.toml", &settings));
            let touches_s = &result.contacts[0].touches_s;
            assert!(
                touches_s.windows(2).all(|pair| pair[1] - pair[0] > APART_S),
                "{law} {alpha}: {touches_s:?}"
            );
            result.summary.bounces
        };
        let with_gap = bounces([
            ("bodies.tip.position", Setting::Number(0.0)),
            ("contacts.tool.gap", Setting::Text("5 mm".into())),
        ]);
        let before_wall = bounces([
            ("bodies.tip.position", Setting::Text("-5 mm".into())),
            ("contacts.tool.gap", Setting::Number(0.0)),
        ]);
        assert!(
            with_gap > 2 && with_gap == before_wall,
            "{law} {alpha}: {with_gap} and {before_wall} bounces"
        );
    }
}

#[test]
fn regress_a_guide_breaks_loose_once() {
    for name in ["coulomb-friction", "load-friction", "asymmetric-friction"] {
        for rate in [1e3, 7e3, 1e4] {
            let result = result_of(&file(
                &format!("effects/{name}.toml"),
                &[("run.record_rate", Setting::Number(rate))],
            ));
            let guide = |kind| matches!(kind, EventKind::Stick | EventKind::Slip);
            let at_s: Vec<f64> = result
                .record
                .events
                .iter()
                .filter(|event| guide(event.kind))
                .map(|event| event.t_s)
                .collect();
            assert!(
                !at_s.is_empty() && at_s.windows(2).all(|pair| pair[1] - pair[0] > APART_S),
                "{name} at {rate} Hz: {at_s:?}"
            );
        }
    }
}

const LIMITED: &str = r#"
[bodies.tip]
mass = 1.0
[springs.guide]
between = ["ground", "tip"]
damping = 10.0
[actuators.drive]
on = "tip"
kind = "velocity-source"
damping = 600.0
time_constant = "2 ms"
limit = 10.0
[controllers.open]
law = "open-loop"
drives = "drive"
period = "1 ms"
reference = [[0.0, 0.5], [0.1, -0.2], [0.2, 0.0]]
[run]
duration = 0.4
step = 1e-4
record = ["tip.velocity", "drive.force"]
"#;

/// A fixed step goes beyond the limit by up to a step's share of the source's 2 ms, 5 %.
const STEP_SHARE: f64 = 0.05;

#[test]
fn regress_a_velocity_source_leaves_its_limit_with_fixed_steps_too() {
    let document = Document::parse(LIMITED, "limited.toml").unwrap();
    let exact = result_of(&document);
    let events = |result: &RunResult| result.record.events.iter().map(|event| event.kind).collect::<Vec<_>>();
    assert!(events(&exact).contains(&EventKind::Release));
    for integrator in [Integrator::Rk4, Integrator::SemiImplicitEuler] {
        let mut scenario = document.scenario.clone();
        scenario.run.integrator = integrator;
        let fixed = run(&scenario, &mut |_| {}).unwrap();
        assert_eq!(events(&fixed), events(&exact), "{integrator:?}");
        for (name, size) in [("tip.velocity", 0.5), ("drive.force", 10.0)] {
            let pairs = fixed.record.column(name).unwrap().iter().zip(exact.record.column(name).unwrap());
            let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < STEP_SHARE * size, "{integrator:?} {name}: {worst}");
        }
    }
}
