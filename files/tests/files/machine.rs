//! Machine and scenario files as people write them.

use std::io::Write as _;
use std::path::Path;

use feeler_control::{Law, ReferenceSpec};
use feeler_files::{Document, Draft};
use feeler_plant::description::Quantity;

use crate::COMPLETE;

/// Units are powers of ten and their products, so a value has a few rounding errors at most.
const ROUNDING: f64 = 1e-15;

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= ROUNDING * b.abs()
}

#[test]
fn truth_the_complete_example_is_read_in_si() {
    let document = Document::parse(COMPLETE, "complete.toml").unwrap_or_else(|error| panic!("{error}"));
    let scenario = &document.scenario;
    let machine = &scenario.machine;
    assert_eq!(machine.name, "flexible-contact");
    assert!(close(machine.bodies["tip"].mass_kg, 5.0));
    assert!(machine.springs["mount"].rigid);
    assert!(close(machine.contacts["tool"].gap_m, 0.004));
    assert!(close(machine.sensors["encoder"].resolution.unwrap(), 1e-6));
    assert!(close(machine.springs["guide"].effects[0].values[0], 12.0));
    assert!(close(machine.actuators["drive"].effects[0].values[0], 1.2e-3));
    let controller = &scenario.controllers["force"];
    assert!(close(controller.spec.delay_s, 4e-4));
    let approach = controller.spec.approach.unwrap();
    assert!(close(approach.speed, 0.03));
    assert!(close(approach.effective_mass, 12.0), "motor and tip, without base: {}", approach.effective_mass);
    let Law::ExplicitForce(gains) = &controller.spec.law else { panic!("{:?}", controller.spec.law) };
    assert!(close(gains.ki, 25.0));
    assert_eq!(controller.spec.reference, ReferenceSpec::Steps(vec![(0.0, 20.0), (1.2, 30.0)]));
    assert!(close(scenario.run.record_rate_hz.unwrap(), 2000.0));
    assert_eq!(scenario.run.record[2].quantity, Quantity::Command);
}

#[test]
fn truth_an_override_is_as_if_written() {
    let mut draft = Draft::parse(COMPLETE, "complete.toml").unwrap();
    for assignment in [
        "controllers.force.kp=0.8",
        "contacts.tool.gap = 5 mm",
        "run.energy=true",
        "springs.guide.effects.viscous-friction.damping=7",
    ] {
        draft.set(assignment).unwrap();
    }
    let scenario = draft.build().unwrap().scenario;
    let Law::ExplicitForce(gains) = &scenario.controllers["force"].spec.law else { panic!() };
    assert!(close(gains.kp, 0.8));
    assert!(close(scenario.machine.contacts["tool"].gap_m, 0.005));
    assert!(scenario.run.energy);
    assert_eq!(scenario.machine.springs["guide"].effects.len(), 2);
}

#[test]
fn truth_an_override_of_what_does_not_exist_names_the_nearest() {
    for (assignment, expected) in [
        ("controllers.forse.kp=1", "did you mean `force`?"),
        ("contollers.force.kp=1", "did you mean `controllers`?"),
        ("controllers.force.kpp=1", "did you mean `kp`?"),
        ("springs.guide.effects.coulomb-fricton.level=1", "did you mean `coulomb-friction`?"),
        ("controllers.force.kp", "write KEY=VALUE"),
        ("contacts.tool.gap=5 kg", "this must be a length (m)"),
    ] {
        let mut draft = Draft::parse(COMPLETE, "complete.toml").unwrap();
        let error = draft.set(assignment).and_then(|()| draft.build().map(drop)).unwrap_err();
        let problem = &error.problems[0];
        assert_eq!(problem.file, "--set", "{error}");
        assert!(error.to_string().contains(expected), "{assignment}: {error}");
    }
}

#[test]
fn truth_practice_machines_are_read() {
    let practice = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/blind/practice");
    let Ok(cases) = std::fs::read_dir(&practice) else {
        // `eprintln!` would not be shown, because a passing test captures its output.
        let _ = writeln!(std::io::stderr(), "skipped: {} is absent", practice.display());
        return;
    };
    for case in cases.map(|case| case.unwrap().path()).filter(|case| case.is_dir()) {
        Document::load(&case.join("machine.toml")).unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn truth_a_rotational_axis_has_its_own_units() {
    let text = "axis = \"rotational\"\n[bodies.arm]\nmass = \"0.5 kg m2\"\nposition = \"90 deg\"\nvelocity \
                = \"60 rpm\"\n\
                [springs.drive]\nbetween = [\"ground\", \"arm\"]\nstiffness = \"2 kN m/rad\"\ndamping = \"3 \
                N m s/rad\"\n";
    let machine =
        Document::parse(text, "arm.toml").unwrap_or_else(|error| panic!("{error}")).scenario.machine;
    assert!(close(machine.bodies["arm"].position_m, std::f64::consts::FRAC_PI_2));
    assert!(close(machine.bodies["arm"].velocity_m_per_s, std::f64::consts::TAU));
    assert!(close(machine.springs["drive"].stiffness_n_per_m, 2e3));
    let error = Document::parse(&text.replace("90 deg", "90 mm"), "arm.toml").unwrap_err();
    assert!(error.problems[0].message.contains("this must be an angle (rad)"), "{error}");
}

#[test]
fn truth_gains_have_the_units_of_drive_and_law() {
    let text = COMPLETE
        .replace("kind = \"force\"", "kind = \"velocity-source\"\ndamping = 600.0\ntime_constant = \"2 ms\"");
    let scenario =
        Document::parse(&text.replace("kp = 0.6", "kp = \"0.5 mm/(s N)\""), "source.toml").unwrap().scenario;
    let Law::ExplicitForce(gains) = &scenario.controllers["force"].spec.law else { panic!() };
    assert!(close(gains.kp, 5e-4));
    assert!(scenario.controllers["force"].spec.approach.unwrap().velocity_drive);
    let error = Document::parse(&text.replace("kp = 0.6", "kp = \"0.5 N\""), "source.toml").unwrap_err();
    assert!(error.problems[0].message.contains("this must be in m/(N s)"), "{error}");
}

#[test]
fn truth_wiring_must_fit() {
    let cases = [
        (
            "[springs.tool]\nbetween = [\"ground\", \"tip\"]\n",
            "contacts.tool",
            "there is already a spring `tool`",
        ),
        ("[bodies.ground]\nmass = 1.0\n", "bodies.ground", "`ground` is the fixed body"),
        ("[bodies.\"a b\"]\nmass = 1.0\n", "bodies.a b", "cannot be a name"),
        (
            "[sensors.s]\nreads = \"encoder.reading\"\n",
            "sensors.s.reads",
            "a sensor cannot read another sensor",
        ),
        (
            "[controllers.c]\nlaw = \"position\"\nreads = \"force\"\ndrives = \"drive\"\nperiod = 1e-3\n",
            "controllers.c.reads",
            "this needs a position",
        ),
        (
            "[controllers.c]\nlaw = \"open-loop\"\nkp = 1.0\ndrives = \"drive\"\nperiod = 1e-3\n",
            "controllers.c.kp",
            "belongs to law",
        ),
        (
            "[controllers.c]\nlaw = \"admittance\"\nreads = \"force\"\ndrives = \"drive\"\nperiod = 1e-3\n",
            "controllers.c.mass",
            "virtual",
        ),
        (
            "[tolerance]\n\"bodies.motr.mass\" = 0.05\n",
            "tolerance.\"bodies.motr.mass\"",
            "there is no `bodies.motr.mass`",
        ),
        (
            "[tolerance]\n\"springs.guide.rigid\" = 0.05\n",
            "tolerance.\"springs.guide.rigid\"",
            "a tolerance of it has no effect",
        ),
        (
            "[tolerance]\n\"controllers.force.kp\" = 0.05\n",
            "tolerance.\"controllers.force.kp\"",
            "a tolerance of it has no effect",
        ),
        (
            "[controllers.force.effects.timing-jitter]\nsigma = -1.0\n",
            "controllers.force.effects.timing-jitter.sigma",
            "is out of range",
        ),
    ];
    for (added, key, expected) in cases {
        let error = Document::parse(&format!("{COMPLETE}\n{added}"), "wired.toml").unwrap_err();
        assert!(
            error.problems.iter().any(|problem| problem.key == key && problem.message.contains(expected)),
            "{key}: {error}"
        );
        assert_eq!(error.problems.len(), 1, "{error}");
    }
}

#[test]
fn truth_a_name_may_be_shared_where_quantities_differ() {
    for added in ["[bodies.tool]\nmass = 1.0\n", "[sensors.tool]\nreads = \"tool.compression\"\n"] {
        let read = Document::parse(&format!("{COMPLETE}\n{added}"), "shared.toml");
        assert!(read.is_ok(), "{}", read.unwrap_err());
    }
}

#[test]
fn truth_places_of_keys_are_known() {
    let document = Document::parse(COMPLETE, "complete.toml").unwrap();
    let place = document.place("controllers.force.kp").unwrap();
    let line = COMPLETE.lines().position(|line| line == "kp = 0.6").unwrap() + 1;
    assert_eq!((place.line, place.column), (line, 6));
    assert_eq!(document.place("controllers.force.kd"), None);
}
