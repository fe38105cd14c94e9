//! The axis of an arm along a normal: exact for one joint, and compared with the whole arm for six.

#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests fail as tests do, and say what they measured"
)]

mod simulated;

use std::path::Path;

use feeler_arm::{Agreement, Arm, ArmError, JointDrive, Others, Target, Urdf, inverse_kinematics};
use nalgebra::Vector3;
use rayon::prelude::*;

/// Rounding of a small eigenvalue problem.
const ROUNDING: f64 = 1e-9;
const DOWN: [f64; 3] = [0.0, 0.0, -1.0];

fn drive(reflected: f64, stiffness: f64, damping: f64, friction: f64) -> JointDrive {
    JointDrive {
        gear_ratio: 100.0,
        rotor_inertia_kg_m2: reflected / 1e4,
        stiffness_n_m_per_rad: stiffness,
        damping_n_m_s_per_rad: damping,
        viscous_friction_n_m_s_per_rad: friction,
        dry_friction_n_m: 0.0,
        effort_limit_n_m: Some(200.0),
        bandwidth_hz: None,
    }
}

fn six_joint() -> Arm {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/arms/six-joint.urdf");
    let chain = Urdf::parse(&std::fs::read_to_string(path).unwrap()).unwrap().chain("tool").unwrap();
    let large = drive(1.5, 4e4, 30.0, 20.0);
    let elbow = drive(0.9, 2.5e4, 20.0, 12.0);
    let wrist = drive(0.15, 9e3, 3.0, 3.0);
    Arm::new(chain, vec![large.clone(), large, elbow, wrist.clone(), wrist.clone(), wrist]).unwrap()
}

/// Twenty poses with the tool pointing down on a table of 0.4 by 0.6 m.
fn poses(arm: &Arm) -> Vec<Vec<f64>> {
    let mut poses = Vec::new();
    for i in 0..5 {
        for k in 0..4 {
            let at = Vector3::new(0.45 + 0.1 * f64::from(i), -0.3 + 0.2 * f64::from(k), 0.1);
            let pan = at.y.atan2(at.x);
            let start = vec![pan, -1.2, 1.9, 0.9, 0.0, 0.0];
            poses.push(
                inverse_kinematics(arm.chain(), &Target::Pointing(at, -Vector3::z()), &[start]).unwrap(),
            );
        }
    }
    poses
}

#[test]
fn truth_one_joint_is_two_masses_exactly() {
    let text = r#"<robot name="lever"><link name="base"/>
        <link name="rod"><inertial><mass value="2"/><inertia ixx="0.7" iyy="0.7" izz="0.7"/></inertial></link>
        <link name="tip"/>
        <joint name="hinge" type="continuous">
        <parent link="base"/><child link="rod"/><axis xyz="0 -1 0"/></joint>
        <joint name="end" type="fixed">
        <parent link="rod"/><child link="tip"/><origin xyz="0.8 0 0"/></joint></robot>"#;
    let chain = Urdf::parse(text).unwrap().chain("tip").unwrap();
    let arm = Arm::new(chain, vec![drive(1.1, 3e4, 25.0, 7.0)]).unwrap();
    for others in [Others::Held, Others::Free] {
        let found = arm.reduce(&[0.0], [0.0, 0.0, 2.0], others).unwrap();
        let square = 0.8 * 0.8;
        let pairs = [
            (found.tip_mass_kg, 0.7 / square),
            (found.motor_mass_kg, 1.1 / square),
            (found.mass_kg, 1.8 / square),
            (found.stiffness_n_per_m, 3e4 / square),
            (found.static_stiffness_n_per_m, 3e4 / square),
            (found.damping_n_s_per_m, 25.0 / square),
            (found.guide_damping_n_s_per_m, 7.0 / square),
            (found.link_mass_kg, 0.7 / square),
            (found.force_limit_n.unwrap(), 200.0 / 0.8),
        ];
        for (found, expected) in pairs {
            assert!((found / expected - 1.0).abs() < ROUNDING, "{others:?}: {found} {expected}");
        }
    }
    // Along the rod it cannot move at all.
    assert!(matches!(arm.reduce(&[0.0], [1.0, 0.0, 0.0], Others::Free), Err(ArmError::Singular { .. })));
    assert!(matches!(arm.reduce(&[0.0], [0.0; 3], Others::Free), Err(ArmError::Normal { .. })));
}

/// Share of the arm's mass in modes too weak to be counted: 1e-9 each, with a margin for closely spaced ones.
const LEFT_OUT: f64 = 1e-6;

#[test]
fn truth_with_all_its_branches_the_axis_has_the_arm_s_frequencies() {
    let arm = six_joint();
    for others in [Others::Free, Others::Held] {
        for q in poses(&arm) {
            let pair = arm.reduce(&q, DOWN, others).unwrap();
            let axis = arm.reduce_with_branches(&q, DOWN, others, usize::MAX).unwrap();
            let bodies = axis.branches.iter().map(|branch| branch.mass_kg).sum::<f64>()
                + axis.motor_mass_kg
                + axis.tip_mass_kg;
            assert!((bodies / pair.mass_kg - 1.0).abs() < ROUNDING && axis.motor_mass_kg > 0.0, "{axis:?}");
            for own in axis.modes_in_contact(0.0) {
                let nearest = pair
                    .modes
                    .iter()
                    .map(|mode| (own.frequency_hz / mode.frequency_hz - 1.0).abs())
                    .fold(f64::INFINITY, f64::min);
                assert!(nearest < LEFT_OUT, "{others:?}: {} Hz is none of the arm's", own.frequency_hz);
            }
            assert!(axis.branches.len() >= 2, "{others:?}");
        }
    }
}

/// Tolerance of the phase crossover on any contact.
const CROSSOVER: f64 = 0.012;
/// Contacts (N/m, N s/m), each with the tolerance of its contact mode. The documents give figures for the
/// second. A softer and a harder one show that the axis is valid beyond one contact. On harder contacts the
/// mode is closer to those in which several joints bend against each other.
const CONTACTS: [([f64; 2], f64); 3] = [([5e3, 20.0], 2e-3), ([2e4, 40.0], 5e-3), ([5e4, 60.0], 0.01)];

#[test]
fn reference_contact_mode_and_phase_crossover_are_the_whole_arm_s_at_twenty_poses() {
    let arm = six_joint();
    let off = |[whole, axis]: [f64; 2]| (axis / whole - 1.0).abs();
    for (contact, most) in CONTACTS {
        for others in [Others::Free, Others::Held] {
            let [mut mode, mut crossover, mut of_pair] = [0.0_f64; 3];
            let mut branches = Vec::new();
            for q in poses(&arm) {
                let pair = arm.reduce(&q, DOWN, others).unwrap();
                of_pair = of_pair
                    .max(off(arm.agreement(&pair, &q, DOWN, others, contact).unwrap().phase_crossover_hz));
                let (axis, found) = arm.reduce_in_contact(&q, DOWN, others, contact).unwrap();
                branches.push(axis.branches.len());
                mode = mode.max(off(found.contact_mode_hz));
                crossover = crossover.max(off(found.phase_crossover_hz));
            }
            println!(
                "{contact:?}, {others:?}: contact mode off by up to {mode:.1e}, phase crossover by up to \
                 {crossover:.1e} (two masses {of_pair:.1e}), \
                 branches {branches:?}"
            );
            assert!(crossover < CROSSOVER && mode < most, "{others:?}: {mode} {crossover}");
        }
    }
}

/// A position of the tool, m, a normal, and a contact, N/m and N s/m.
type Touch = ([f64; 3], [f64; 3], [f64; 2]);

/// Positions all over the arm's reach, from the table to a height of 0.45 m. Normals are vertical and
/// inclined, contacts soft to hard.
fn workspace() -> Vec<Touch> {
    let (xs, ys) = ([0.4, 0.55, 0.7, 0.85], [-0.3, 0.0, 0.2]);
    let mut all: Vec<Touch> = Vec::new();
    for z in [0.1, 0.2, 0.3, 0.45] {
        all.extend(xs.iter().flat_map(|x| ys.map(|y| ([*x, y, z], DOWN, [2e4, 40.0]))));
    }
    for contact in [[5e3, 20.0], [5e4, 60.0], [2e5, 100.0]] {
        all.extend([0.4, 0.6, 0.8].map(|x| ([x, 0.1, 0.15], DOWN, contact)));
    }
    for normal in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.0, -1.0]] {
        for z in [0.1, 0.2] {
            all.extend(
                [0.45, 0.6, 0.75].iter().flat_map(|x| [0.0, 0.2].map(|y| ([*x, y, z], normal, [2e4, 40.0]))),
            );
        }
    }
    all
}

/// Misfit of the axis against the arm at a touch, with the other directions held. `None` if the arm does not
/// reach it, or cannot move along the normal.
fn misfit(arm: &Arm, (place, normal, contact): Touch) -> Option<Agreement> {
    let target = Target::Pointing(place.into(), Vector3::from(normal).normalize());
    let q = inverse_kinematics(arm.chain(), &target, &feeler_arm::usual_starts(arm.chain(), place)).ok()?;
    match arm.reduce_in_contact(&q, normal, Others::Held, contact) {
        Ok((axis, found)) => {
            let masses = axis.motor_mass_kg
                + axis.tip_mass_kg
                + axis.branches.iter().map(|branch| branch.mass_kg).sum::<f64>();
            assert!(
                (masses / axis.mass_kg - 1.0).abs() < ROUNDING
                    && axis.motor_mass_kg > 0.0
                    && axis.tip_mass_kg > 0.0,
                "{axis:?}"
            );
            assert_eq!(found.is_trusted(), found.worst() <= 0.05, "what is printed is what is warned of");
            println!(
                "{place:?} along {normal:?} on {contact:?}: off by {:.4?}, {} bodies",
                found.misfits(),
                axis.branches.len()
            );
            // A thousandth of the whole, except for rounding.
            let lightest = axis
                .branches
                .iter()
                .map(|branch| branch.mass_kg)
                .fold(axis.motor_mass_kg.min(axis.tip_mass_kg), f64::min);
            assert!(
                !axis.branches.iter().any(feeler_arm::Branch::is_linked) || lightest > 5e-4 * axis.mass_kg,
                "{axis:?}"
            );
            Some(found)
        }
        Err(ArmError::Singular { .. }) => None,
        Err(error) => panic!("{error}"),
    }
}

/// Tolerance of contact mode, phase crossover and largest stable ki with damped motors, anywhere. The files
/// promise it.
const ANYWHERE: f64 = 0.05;
/// Tolerance of the largest stable kp. If the phase stays near -180 degrees over several hertz, a hundredth
/// of a radian decides which of two crossings is the loop's edge. The axis then reports the misfit.
const KP_ANYWHERE: f64 = 0.3;

/// The largest misfit of the landmarks that are promised everywhere. The misfit of the stable kp is bounded
/// here.
fn promised(found: &Agreement) -> f64 {
    let [mode, crossover, kp, ki] = found.misfits();
    assert!(kp < KP_ANYWHERE, "{found:?}");
    mode.max(crossover).max(ki)
}

/// Several modes share the tool's displacement. With only one of them as the tool, the error was up to 71 %.
#[test]
fn regress_the_axis_is_the_arm_s_where_modes_share_the_tool() {
    let arm = six_joint();
    let hard = [
        ([0.3, 0.1, 0.1], DOWN, [2e4, 40.0]),
        ([0.35, 0.0, 0.1], DOWN, [2e4, 40.0]),
        ([0.4, 0.0, 0.1], DOWN, [2e4, 40.0]),
        ([0.4, 0.0, 0.1], DOWN, [5e3, 40.0]),
        ([0.75, 0.0, 0.1], [1.0, 0.0, 0.0], [2e4, 40.0]),
        ([0.75, 0.2, 0.1], [1.0, 0.0, 0.0], [2e4, 40.0]),
        ([0.45, 0.0, 0.1], [0.3, 0.0, -1.0], [2e4, 40.0]),
        ([0.95, 0.4, 0.1], DOWN, [2e4, 40.0]),
    ];
    for touch in hard {
        assert!(promised(&misfit(&arm, touch).unwrap()) < ANYWHERE, "{touch:?}");
    }
}

/// With other directions held, a slow push moves the tool here more than its drive, unlike any two masses.
/// Such poses were rejected as if the arm could not move.
#[test]
fn regress_an_arm_whose_tool_leads_its_drive_has_an_axis() {
    let arm = six_joint();
    for q in [[0.763, -0.783, 1.189, 1.98, -0.368, -0.635], [0.0, -1.2, 2.79, 1.2, 0.0, 0.0]] {
        let (_, found) = arm.reduce_in_contact(&q, DOWN, Others::Held, [2e4, 40.0]).unwrap();
        assert!(promised(&found) < ANYWHERE, "{q:?}: {found:?}");
    }
}

#[test]
fn reference_the_axis_is_the_arm_s_all_over_the_workspace() {
    let arm = six_joint();
    let touches = workspace();
    let all: Vec<Agreement> = touches.par_iter().filter_map(|touch| misfit(&arm, *touch)).collect();
    let worst = all.iter().map(promised).fold(0.0, f64::max);
    let kp = all.iter().map(|found| found.misfits()[2]).fold(0.0, f64::max);
    let doubted = all.iter().filter(|found| !found.is_trusted()).count();
    println!(
        "{} poses, worst {worst:.4}, stable kp {kp:.4}, {doubted} not trusted; {} are out of reach or do \
         not let the tool move along the normal",
        all.len(),
        touches.len() - all.len()
    );
    // 7 of 91 poses are not trusted; rounding may decide over one more.
    assert!(all.len() > 80 && worst < ANYWHERE && doubted * 11 < all.len(), "{worst} {doubted}");
}

/// The fit ignored the mass at the drive. Its motor of 0.56 kg, against the arm's rotors of 1.70 kg, had no
/// stable ki, although the arm is stable up to 114 1/s.
#[test]
fn regress_the_sampled_loop_with_damped_motors_is_the_arm_s() {
    let arm = six_joint();
    for place in [[0.8227, -0.3, 0.1], [0.8864, 0.2, 0.1]] {
        let found = misfit(&arm, (place, DOWN, [5e4, 40.0])).unwrap();
        assert!(found.largest_ki_per_s[0] > 100.0 && found.worst() < ANYWHERE, "{found:?}");
    }
}

/// On very hard contacts no mode moves the tool. The axis then had no contact mode, and no damping of the
/// motors.
#[test]
fn regress_a_hard_contact_has_its_contact_mode() {
    let arm = six_joint();
    let q = &poses(&arm)[9];
    let mode = |others: Others, k: f64| {
        let (axis, found) = arm.reduce_in_contact(q, DOWN, others, [k, 300.0]).unwrap();
        assert!(axis.motor_mass_kg > 0.0 && found.motor_damping_n_s_per_m.is_finite(), "{found:?}");
        found.contact_mode_hz
    };
    for others in [Others::Free, Others::Held] {
        // A contact stiffer than the arm acts like a rigid wall.
        let ([hard, own], [harder, _]) = (mode(others, 1e9), mode(others, 1e11));
        assert!(
            (harder / hard - 1.0).abs() < 1e-3 && (own / hard - 1.0).abs() < ANYWHERE,
            "{others:?}: {hard} {own} {harder}"
        );
    }
    let touch = ([0.691, -0.174, 0.399], [0.7868, -0.3285, 0.5226], [1e6, 300.0]);
    assert!(promised(&misfit(&arm, touch).unwrap()) < ANYWHERE);
    let touch = ([0.342, 0.394, 0.445], [0.8953, -0.2723, 0.3525], [1e6, 300.0]);
    assert!(promised(&misfit(&arm, touch).unwrap()) < ANYWHERE);
}

/// A fit gave a body of a milligram between two dampers, which no engine can step.
#[test]
fn regress_no_body_is_a_mere_point_between_dampers() {
    assert!(promised(&misfit(&six_joint(), ([0.266, -0.263, 0.194], DOWN, [5e4, 60.0])).unwrap()) < ANYWHERE);
}
