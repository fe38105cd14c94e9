//! Arm files, the axis that represents an arm, and the force bandwidth that it allows.

#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests fail as tests do, and say what they measured"
)]

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use feeler_analysis::{Request, analyze};
use feeler_arm::{Others, Reduction, inverse_kinematics};
use feeler_control::{ForceGains, Law};
use feeler_files::{ArmFile, Document};
use feeler_studies::arm::{Grid, ToolContact, axis_file, bandwidth_map, tool_target};
use feeler_studies::run::{Outcome, run};

const DOWN: [f64; 3] = [0.0, 0.0, -1.0];
const CONTACT: ToolContact = ToolContact { stiffness_n_per_m: 2e4, damping_n_s_per_m: 40.0 };

fn arms() -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")).join("arms")
}

fn six_joint() -> (ArmFile, Vec<f64>) {
    let file = ArmFile::load(&arms().join("six-joint.toml")).unwrap_or_else(|error| panic!("{error}"));
    let target = tool_target(&file, [0.65, 0.1, 0.1], DOWN).unwrap();
    let pose =
        inverse_kinematics(file.arm.chain(), &target, &[vec![0.15, -1.2, 1.9, 0.9, 0.0, 0.0]]).unwrap();
    (file, pose)
}

#[test]
fn truth_the_axis_of_an_arm_is_a_file_that_runs_and_settles() {
    let (file, pose) = six_joint();
    for others in [Others::Free, Others::Held] {
        let axis = axis_file(&file, &pose, DOWN, others, CONTACT).unwrap();
        let document =
            Document::parse(&axis.text, "axis.toml").unwrap_or_else(|error| panic!("{error}\n{}", axis.text));
        let machine = &document.scenario.machine;
        let mass: f64 = machine.bodies.values().map(|body| body.mass_kg).sum();
        assert!((mass / axis.reduction.mass_kg - 1.0).abs() < 1e-12, "{mass}");
        // Two masses are enough if the other directions are free, and not if they are held.
        assert_eq!(machine.bodies.len() > 2, others == Others::Held, "{}", axis.text);
        assert_eq!(
            axis.text.contains("Two masses alone miss these"),
            others == Others::Held,
            "{}",
            axis.text
        );
        let result = run(&document.scenario, &mut |_| {}).unwrap();
        println!("{others:?}: {:?}, largest kp {:.3}", result.summary.outcome, axis.largest_gain);
        let settles = matches!(result.summary.outcome, Outcome::Settled | Outcome::BouncesThenSettles);
        assert!(settles, "{others:?}: {:?}", result.summary.outcome);
    }
}

/// Eigenvalues of the analysis, against crossings of the unit circle. The two differ by rounding, and by
/// frequencies beyond half the sample rate.
const SAME_LOOP: f64 = 1e-6;
/// The lag of differenced positions, of the hold and of the drives, and the contact's damper, at 4 Hz. There
/// 1 ms is 0.025 rad, and the damper a twentieth of the spring.
const CONTINUOUS: f64 = 0.03;

#[test]
fn truth_stable_gains_of_an_axis_are_those_that_its_file_has() {
    let (file, pose) = six_joint();
    for others in [Others::Free, Others::Held] {
        let axis = axis_file(&file, &pose, DOWN, others, CONTACT).unwrap();
        let own = &axis.agreement;
        let mut scenario = Document::parse(&axis.text, "axis.toml").unwrap().scenario;
        scenario.machine.springs["guide"].effects.clear();
        for used in scenario.controllers.values_mut() {
            used.spec.law = Law::ExplicitForce(ForceGains {
                ki: 0.1,
                damping: own.motor_damping_n_s_per_m,
                ..ForceGains::default()
            });
        }
        let report =
            analyze(&scenario, &Request { gain: Some("controllers.force.ki".into()), ..Request::default() })
                .unwrap();
        let largest_ki = report.gain().unwrap().sampled.stable[1].unwrap();
        let pairs = [(own.largest_kp[1], axis.largest_gain), (own.largest_ki_per_s[1], largest_ki)];
        for (own, of_file) in pairs {
            println!("{others:?}: {own} {of_file}");
            assert!((own / of_file - 1.0).abs() < SAME_LOOP, "{others:?}: {own} {of_file}");
        }
        // The continuous loop at the force bandwidth, at half of the gain.
        let frequency_hz = own.force_bandwidth_hz[1];
        let guide_damping_n_s_per_m = axis.reduction.guide_damping_n_s_per_m + own.motor_damping_n_s_per_m;
        let damped = Reduction { guide_damping_n_s_per_m, ..axis.reduction.clone() };
        let plant = damped
            .response_in_contact([CONTACT.stiffness_n_per_m, CONTACT.damping_n_s_per_m], frequency_hz)
            .norm();
        let gain = 0.5 * largest_ki / (TAU * frequency_hz) * plant;
        println!("{others:?}: a gain of {gain} at {frequency_hz} Hz");
        assert!((gain - 1.0).abs() < CONTINUOUS, "{others:?}: {gain} at {frequency_hz} Hz");
    }
}

/// A place without an axis has a reason, and the map continues.
#[test]
fn regress_a_map_never_ends_at_one_place() {
    let (file, pose) = six_joint();
    let hard = ToolContact { stiffness_n_per_m: 5e4, damping_n_s_per_m: 60.0 };
    // The first place had a body of a milligram, which no machine file takes; the last is out of reach.
    let grid = Grid { x: (0.266, 1.6, 2), y: (-0.263, -0.263, 1), z_m: 0.194 };
    let map = bandwidth_map(&file, &grid, DOWN, Others::Held, hard, &pose, &|_| ()).unwrap();
    assert!(
        map[0].found.as_ref().is_ok_and(|found| found.agreement.force_bandwidth_hz[0] > 0.0),
        "{:?}",
        map[0].found
    );
    assert_eq!(map[1].found, Err(feeler_studies::arm::NoAxis::OutOfReach));
}

#[test]
fn prop_the_bandwidth_map_agrees_with_each_place_alone() {
    let (file, pose) = six_joint();
    let grid = Grid { x: (0.5, 0.8, 2), y: (-0.2, 0.2, 2), z_m: 0.1 };
    let places = |others: Others| {
        bandwidth_map(&file, &grid, DOWN, others, CONTACT, &pose, &|_| ())
            .unwrap()
            .into_iter()
            .map(move |point| (others, point))
    };
    let map: Vec<_> = [Others::Free, Others::Held].into_iter().flat_map(places).collect();
    assert_eq!(map.len(), 8);
    for (others, point) in &map {
        let found = point.found.as_ref().unwrap();
        let place = file.arm.chain().tool_place(&found.pose).translation.vector;
        assert!((0..3).all(|i| (place[i] - point.place_m[i]).abs() < 1e-6), "{place}");
        let (_, agreement) = file
            .arm
            .reduce_in_contact(
                &found.pose,
                DOWN,
                *others,
                [CONTACT.stiffness_n_per_m, CONTACT.damping_n_s_per_m],
            )
            .unwrap();
        let [arm, axis] = agreement.force_bandwidth_hz;
        assert!((arm / found.agreement.force_bandwidth_hz[0] - 1.0).abs() < 1e-9);
        println!("{:?}: {:.2} kg, {arm:.3} Hz, axis {axis:.3} Hz", point.place_m, found.mass_kg);
        // Each takes half of its stable gain, so they agree as closely as these gains.
        assert!(arm > 0.0 && (axis / arm - 1.0).abs() < 0.05, "{arm} {axis}");
    }
    // Far away there is no pose.
    let far = Grid { x: (3.0, 3.0, 1), y: (0.0, 0.0, 1), z_m: 0.1 };
    assert!(
        bandwidth_map(&file, &far, DOWN, Others::Free, CONTACT, &pose, &|_| ()).unwrap()[0].found.is_err()
    );
}

#[test]
fn truth_mistakes_of_arm_files_are_told_together() {
    let good = std::fs::read_to_string(arms().join("six-joint.toml")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let urdf = std::fs::read_to_string(arms().join("six-joint.urdf")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("six-joint.urdf", &urdf);
    write("hollow.urdf", &urdf.replace("izz=\"0.0022\"", "izz=\"0\""));
    let mesh =
        "<visual><geometry><mesh filename=\"package://arm/meshes/hand.stl\"/></geometry></visual></link>";
    write("mesh.urdf", &urdf.replacen("</link>", mesh, 1));
    let parse = |text: &str| {
        ArmFile::parse(text, &folder.path().join("arm.toml").to_string_lossy())
            .map_err(|error| error.to_string())
    };
    assert!(parse(&good).is_ok_and(|arm| arm.doubts.is_empty()));
    let doubts = parse(&good.replacen("\"six-joint.urdf\"", "\"mesh.urdf\"", 1)).unwrap().doubts;
    let expected = "link `base` names the mesh `package://arm/meshes/hand.stl`, which does not exist";
    assert!(doubts.len() == 1 && doubts[0].message.ends_with(expected), "{doubts:?}");
    write("short.urdf", &urdf.replace(" ixy=\"0\"", ""));
    let doubts = parse(&good.replacen("\"six-joint.urdf\"", "\"short.urdf\"", 1)).unwrap().doubts;
    let expected =
        "line 5: the inertia of link `base` lacks `ixy`, which counts as zero here (8 links lack some)";
    assert!(doubts.len() == 1 && doubts[0].message.ends_with(expected), "{doubts:?}");
    let cases: [(&str, &str, &[&str]); 7] = [
        ("\"six-joint.urdf\"", "\"absent.urdf\"", &["absent.urdf", "No such file"]),
        (
            "\"six-joint.urdf\"",
            "\"hollow.urdf\"",
            &["hollow.urdf: line", "link `tool` has an inertia of 0 kg m2"],
        ),
        ("\"six-joint.urdf\"", "\"six-joint.urdf\"\ntool = \"hand\"", &["there is no link `hand`"]),
        (
            "[joints.roll]",
            "[joints.rol]",
            &["no joint `rol` moves", "did you mean `roll`", "joint `roll` has no drive"],
        ),
        ("gear_ratio    = 100", "gear_ratio    = -100", &["joints.pan.gear_ratio"]),
        ("\"40 kN m/rad\"", "\"40 kN/m\"", &["joints.pan.stiffness"]),
        ("rotor_inertia = \"0.9e-4 kg m2\"\n", "", &["`rotor_inertia` is missing"]),
    ];
    for (from, to, said) in cases {
        let error = parse(&good.replacen(from, to, 1)).unwrap_err();
        assert!(said.iter().all(|part| error.contains(part)), "{to}: {error}");
    }
}
