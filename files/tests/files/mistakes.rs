//! Mistakes that were once accepted, reported without a place, or reported twice.

#![expect(clippy::unwrap_used, reason = "without the file there is no test")]

use feeler_engine::{EngineError, Program};
use feeler_files::{DatasetFile, Document, Draft, FormatError, Located};

use crate::COMPLETE;

fn mistakes(settings: &[&str]) -> Vec<Located> {
    let mut draft = Draft::parse(COMPLETE, "complete.toml").unwrap();
    for setting in settings {
        draft.set(setting).unwrap();
    }
    draft.build().map_or_else(|error| error.problems, |_| Vec::new())
}

fn mistakes_of(text: &str) -> Vec<Located> {
    Document::parse(text, "it.toml").map_or_else(|error| error.problems, |_| Vec::new())
}

#[test]
fn regress_senseless_pairs_are_refused_with_a_remedy() {
    let refused = [
        (
            &["actuators.drive.reacts_on=\"tip\"", "actuators.drive.on=\"tip\""][..],
            "actuators.drive.reacts_on",
        ),
        (&["controllers.force.jitter=1.0"][..], "controllers.force.jitter"),
        (&["controllers.force.approach.speed=-0.03"][..], "controllers.force.approach.speed"),
        (&["run.record=[\"tool.force\", \"tool.force\"]"][..], "run.record"),
        (&["run.duration=0.1", "run.record_rate=1"][..], "run.record_rate"),
    ];
    for (settings, key) in refused {
        let found = mistakes(settings);
        assert!(
            found.iter().any(|problem| problem.key == key && !problem.remedy.is_empty()),
            "{settings:?}: {found:#?}"
        );
    }
}

#[test]
fn regress_a_rigid_joint_with_a_stiffness_is_refused_where_both_are_written() {
    let text = |rest: &str| {
        format!(
            "[bodies.a]\nmass = 1\n[bodies.b]\nmass = 1\n\
             [springs.s]\nbetween = [\"a\", \"b\"]\nrigid = true\n{rest}"
        )
    };
    let found = mistakes_of(&text("stiffness = 1e5\ndamping = 1.0\n"));
    let keys: Vec<_> = found.iter().map(|problem| problem.key.as_str()).collect();
    assert_eq!(keys, ["springs.s.stiffness", "springs.s.damping"]);
    assert_eq!(mistakes_of(&text("stiffness = 0\ndamping = 0\n")), []);
    assert_eq!(
        mistakes(&["springs.transmission.rigid=true"]),
        [],
        "a setting may make a spring of the file rigid"
    );
}

#[test]
fn regress_both_ends_of_a_spring_are_reported_each_at_its_place() {
    let found = mistakes_of(
        "[bodies.tip]\nmass = 1.0\n[springs.s]\nbetween = [\"tpi\", \"grund\"]\nstiffness = 1.0\n",
    );
    let places: Vec<_> =
        found.iter().map(|problem| (problem.line, problem.column, problem.key.as_str())).collect();
    assert_eq!(places, [(4, 12, "springs.s.between"), (4, 19, "springs.s.between")]);
}

#[test]
fn regress_one_misspelling_is_one_mistake() {
    for text in [
        "[bodies.a]\nmas = 12\n",
        "[bodies.a]\nmass = 1\n[actuators.d]\non = \"a\"\n\
         [controllers.c]\nlaw = \"explicit-forse\"\ndrives = \"d\"\nperiod = 1e-3\n\
         approach = { speed = 0.1, until = 1.0 }\n",
    ] {
        let found = mistakes_of(text);
        assert_eq!(found.len(), 1, "{found:#?}");
    }
}

#[test]
fn regress_only_what_has_the_quantity_is_suggested() {
    let found = mistakes_of("[bodies.tip]\nmass = 1.0\n[sensors.s]\nreads = \"tool.spring_force\"\n");
    let remedy = found[0].remedy.clone();
    assert!(!remedy.contains("tip.spring_force"), "{remedy}");
}

#[test]
fn regress_mistakes_of_the_motion_have_places() {
    let still = "[bodies.a]\nmass = 1.0\n[springs.s]\nbetween = [\"ground\", \"a\"]\nrigid = true\n";
    let apart = "[bodies.a]\nmass = 1.0\n[bodies.b]\nmass = 1.0\nvelocity = 2.0\n\
                 [springs.s]\nbetween = [\"a\", \"b\"]\nrigid = true\n";
    for (text, place) in [(still, (1, "bodies")), (apart, (5, "bodies.b.velocity"))] {
        let document = Document::parse(text, "it.toml").unwrap();
        let Err(EngineError::Problems { problems }) = Program::new(&document.scenario) else {
            panic!("this cannot move")
        };
        let found = document.locate_problems(&problems).problems;
        assert_eq!((found[0].line, found[0].key.as_str()), place);
        assert!(!found[0].remedy.is_empty());
    }
}

#[test]
fn regress_every_mistake_comes_with_a_remedy() {
    for settings in [
        &["springs.transmission.rigid=\"yes\""][..],
        &["run.record=[\"tool.sprng_force\"]"][..],
        &["controllers.force.approach.release=1e6"][..],
        &["controllers.force.reference={ kind = \"multisine\", rms = 1.0, band = [1.0, 1e9], period = 1.0 }"]
            [..],
        &["springs.guide.effects.transmission-flexibility={ stiffness = 1e5, damping = 1.0, \
           tip_mass = 1.0 }"][..],
        &["springs.guide.effects.backlash={ width = 1e-4 }"][..],
        &["springs.transmission.effects.base-flexibility={ mass = 100.0, stiffness = 1e6, damping = 100.0 }"]
            [..],
    ] {
        let found = mistakes(settings);
        assert!(
            !found.is_empty() && found.iter().all(|problem| !problem.remedy.is_empty()),
            "{settings:?}: {found:#?}"
        );
    }
}

#[test]
fn truth_a_slip_of_a_number_or_unit_is_named() {
    for (setting, key, said, remedy) in [
        (
            "bodies.motor.mass=\"12,5 kg\"",
            "bodies.motor.mass",
            "decimal comma",
            "a decimal point: \"12.5 kg\"",
        ),
        ("controllers.force.period=\"1 msec\"", "controllers.force.period", "`msec`", "did you mean `ms`?"),
        (
            "bodies.motor.mass=\"7 t\"",
            "bodies.motor.mass",
            "`t`",
            "a number in kg, or a text such as \"1 kg\"",
        ),
        ("controllers.force.period=\"0.001 seconds\"", "controllers.force.period", "`seconds`", "mean `s`?"),
    ] {
        let found = mistakes(&[setting]);
        let is_said = found.iter().any(|problem| {
            problem.key == key && problem.message.contains(said) && problem.remedy.contains(remedy)
        });
        assert!(is_said, "{setting}: {found:#?}");
    }
}

#[test]
fn truth_a_setting_without_its_path_proposes_the_whole_path() {
    let mut draft = Draft::parse(COMPLETE, "complete.toml").unwrap();
    let error = draft.set("kp=0.8").unwrap_err();
    assert_eq!(error.problems[0].remedy, "did you mean `controllers.force.kp`?");
    // If several elements have such a key, no suggestion is made.
    let error = draft.set("mass=1.0").unwrap_err();
    assert!(!error.problems[0].remedy.contains("mass"), "{error}");
}

#[test]
fn truth_a_file_of_another_kind_is_refused_in_one_sentence() {
    use feeler_files::{ArmFile, DatasetFile, SweepFile};

    let scenario = "machine = \"m.toml\"\n[contacts.tool]\nbetween = [\"a\", \"b\"]\n[run]\nduration = 1\n";
    let sweep = "scenario = \"a.toml\"\n[axes]\n";
    let arm = "urdf = \"a.urdf\"\n[joints.j1]\n";
    let dataset = "machine = \"m.toml\"\n[columns.x]\n[[experiments]]\nfile = \"a.csv\"\n";
    let as_scenario = |text: &str| Document::parse(text, "a.toml").map(drop);
    let as_arm = |text: &str| ArmFile::parse(text, "a.toml").map(drop);
    let as_sweep = |text: &str| SweepFile::parse(text, "a.toml").map(drop);
    let as_dataset = |text: &str| DatasetFile::parse(text, "a.toml").map(drop);
    for (result, is, command) in [
        (as_scenario(sweep), "a sweep file", "feeler sweep"),
        (as_scenario(arm), "an arm file", "feeler reduce"),
        (as_scenario(dataset), "a dataset file", "feeler diagnose"),
        (as_arm(scenario), "a machine or scenario file", "feeler run"),
        (as_sweep(scenario), "a machine or scenario file", "feeler run"),
        (as_dataset(scenario), "a machine or scenario file", "feeler run"),
        (as_dataset(sweep), "a sweep file", "feeler sweep"),
    ] {
        let problems = result.unwrap_err().problems;
        assert_eq!(problems.len(), 1, "{problems:#?}");
        assert!(problems[0].message.starts_with(&format!("this is {is}, but")), "{problems:#?}");
        assert!(problems[0].remedy.contains(command) && problems[0].line > 0, "{problems:#?}");
    }
}

#[test]
fn truth_what_is_no_toml_is_one_mistake_with_its_remedy() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes, said, remedy) in [
        (
            "robot.urdf",
            &b"<?xml version=\"1.0\"?>\n<robot name=\"a\">\n</robot>\n"[..],
            "a URDF",
            "feeler new arm --urdf robot.urdf",
        ),
        ("record.mcap", b"\x89MCAP0\r\n", "an MCAP log", "feeler diagnose"),
        ("bag.db3", b"SQLite format 3\0", "ROS 2 bags", "feeler import"),
        ("pose.npy", b"\x93NUMPY\x01\0", "NumPy", "feeler import"),
        ("robot.xml", b"<mujoco model='a'>", "MJCF", "--mjcf"),
        ("trace.parquet", b"PAR1....", "a Parquet table", "feeler diagnose"),
        ("record.csv", b"t_s,command_n\n0,1\n", "a table of numbers", "feeler diagnose"),
        ("machine.json", b"{\"bodies\": {}}", "JSON", "TOML"),
        ("empty.toml", b"", "empty", "feeler new"),
        ("wide.toml", b"\xff\xfe[\0", "UTF-16", "UTF-8"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let problems = Draft::load(&path).unwrap_err().problems;
        assert_eq!(problems.len(), 1, "{name}: {problems:#?}");
        assert!(
            problems[0].message.contains(said) && problems[0].remedy.contains(remedy),
            "{name}: {problems:#?}"
        );
    }
}

#[test]
fn regress_effects_on_a_force_are_refused_where_the_motion_is_imposed() {
    let of = |kind: &str, effect: &str| {
        let text = format!(
            "[bodies.rig]\nmass = 1.0\n[actuators.drive]\non = \"rig\"\nkind = \"{kind}\"\n\
             [actuators.drive.effects.{effect}\n"
        );
        match Document::parse(&text, "it.toml") {
            Err(error) => error.problems,
            Ok(document) => match Program::new(&document.scenario) {
                Err(EngineError::Problems { problems }) => document.locate_problems(&problems).problems,
                _ => Vec::new(),
            },
        }
    };
    for effect in [
        "force-limit]\nlimit = 5.0",
        "actuator-lag]\ntime_constant = 0.01",
        "slew-limit]\nrate = 1.0",
        "command-noise]\nsigma = 0.1",
        "force-ripple]\namplitude = 1.0\npitch = 0.1\nphase = 0.0",
    ] {
        let found = of("imposed", effect);
        assert_eq!(found.len(), 1, "{effect}: {found:?}");
        assert!(found[0].message.contains("a drive that gives a force"), "{found:?}");
        assert!(found[0].key.starts_with("actuators.drive.effects.") && found[0].line == 6, "{found:?}");
        assert_eq!(of("force", effect), []);
    }
}

#[test]
fn truth_an_input_of_a_servo_needs_one_servo_on_its_bodies() {
    let of = |more: &str| {
        let text = format!(
            "[bodies.axis]\nmass = 1.0\n[actuators.speed]\non = \"axis\"\nkind = \"target-velocity\"\n{more}"
        );
        Document::parse(&text, "it.toml").map_or_else(|error| error.problems, |_| Vec::new())
    };
    let servo =
        |name: &str| format!("[actuators.{name}]\non = \"axis\"\nkind = \"position-servo\"\nkp = 100.0\n");
    assert_eq!(of(&servo("a")), []);
    let none = of("");
    let said = "there is no position servo on `axis` that reacts on `ground`";
    assert!(none[0].message == said && none[0].line == 4, "{none:?}");
    assert!(of(&(servo("a") + &servo("b")))[0].message.contains("more than one position servo"));
    let limited = of(&format!("limit = 3.0\n{}", servo("a")));
    assert!(limited[0].key == "actuators.speed.limit", "{limited:?}");
}

/// An effect on a command has the unit of the command. The unit of a stiffness has the power of its law.
#[test]
fn regress_units_of_effects_are_those_of_the_command_and_of_the_law() {
    let of = |actuator: &str, effect: &str| {
        mistakes_of(&format!(
            "[bodies.tip]\nmass = 1.0\n[contacts.tool]\nbetween = [\"tip\", \"ground\"]\n\
             stiffness = \"1 kN/m\"\n[actuators.drive]\non = \"tip\"\n{actuator}\n[{effect}\n"
        ))
    };
    let servo = "kind = \"position-servo\"\nkp = 100.0";
    // The voltage of a motor is not proportional to force at every instant, so only a current accepts noise.
    let motor = "kind = \"dc-motor\"\ninput = \"current\"\nresistance = 1.0\ntorque_constant = 1.0";
    let noise = |sigma: &str| format!("actuators.drive.effects.command-noise]\nsigma = \"{sigma}\"");
    for (actuator, sigma, wrong) in
        [(servo, "1 mm", "2 N"), (motor, "1 A", "2 N"), ("kind = \"force\"", "2 N", "1 mm")]
    {
        assert_eq!(of(actuator, &noise(sigma)), []);
        let found = of(actuator, &noise(wrong));
        assert!(found.len() == 1 && found[0].key.ends_with("command-noise.sigma"), "{found:?}");
    }
    let rate = |rate: &str| format!("actuators.drive.effects.slew-limit]\nrate = \"{rate}\"");
    assert_eq!(of(servo, &rate("1 m/s")), []);
    assert_eq!(of(servo, &rate("1 N/s")).len(), 1);
    let hertz = |unit: &str| {
        format!("contacts.tool.effects.hertz-contact]\nexponent = 1.3\nstiffness = \"20 {unit}\"")
    };
    assert_eq!(of(servo, &hertz("MN/m^1.3")), []);
    let found = of(servo, &hertz("MN/m^1.5"));
    assert!(found.len() == 1 && found[0].key.ends_with("hertz-contact.stiffness"), "{found:?}");
}

#[test]
fn regress_a_folder_in_place_of_a_file_is_named_with_what_takes_it() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("log.csv"), "t_s,x\n0.0,1.0\n").unwrap();
    let said = |error: FormatError| {
        let problem = &error.problems[0];
        format!("{} {}", problem.message, problem.remedy)
    };
    let of_dataset = || said(DatasetFile::load(folder.path()).expect_err("no dataset.toml"));
    let of_machine = || said(Document::load(folder.path()).expect_err("no file"));
    assert!(of_dataset().contains("`feeler import "), "{}", of_dataset());
    assert!(of_machine().contains("`feeler import` takes a folder of logs"), "{}", of_machine());
    std::fs::write(folder.path().join("dataset.toml"), "").unwrap();
    assert!(of_machine().contains("`feeler diagnose` takes it"), "{}", of_machine());
}
