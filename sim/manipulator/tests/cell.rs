//! The arm in its cell: order of the steps, comparison with the arm's own simulation against a wall, dry
//! friction, and rejected input.

#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests fail as tests do, and say what they measured"
)]

use std::path::Path;

use feeler_arm::{Arm, FlexibleArm, JointDrive, Others, Target, Urdf, Wall, inverse_kinematics};
use feeler_control::{Controller, ControllerSpec, ForceGains, Law, ReferenceSpec};
use feeler_engine::{ControllerUse, EventKind, RunEnd, RunSettings, Scenario};
use feeler_geometry::{Placement, Shape};
use feeler_manipulator::{
    Cell, CellSimulation, Hold, JointPart, ManipulatorError, Part, Start, link_capsules,
};

use feeler_plant::description::{Actuator, Body, Contact, GROUND, Machine, Quantity, Sensor, SignalName};
use feeler_plant::effects::{EffectUse, find};
use nalgebra::Vector3;

const DOWN: [f64; 3] = [0.0, 0.0, -1.0];
const RADIUS_M: f64 = 0.01;
/// Initial height of the tool, and height of the table's top, m.
const TOOL_M: f64 = 0.1;

fn drive(reflected: f64, stiffness: f64, damping: f64, friction: f64, dry: f64) -> JointDrive {
    JointDrive {
        gear_ratio: 100.0,
        rotor_inertia_kg_m2: reflected / 1e4,
        stiffness_n_m_per_rad: stiffness,
        damping_n_m_s_per_rad: damping,
        viscous_friction_n_m_s_per_rad: friction,
        dry_friction_n_m: dry,
        effort_limit_n_m: Some(250.0),
        bandwidth_hz: None,
    }
}

fn six_joint(dry: f64) -> Arm {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/arms/six-joint.urdf");
    let chain = Urdf::parse(&std::fs::read_to_string(path).unwrap()).unwrap().chain("tool").unwrap();
    let large = drive(1.5, 4e4, 30.0, 20.0, dry);
    let elbow = drive(0.9, 2.5e4, 20.0, 12.0, dry);
    let wrist = drive(0.15, 9e3, 3.0, 3.0, 0.2 * dry);
    Arm::new(chain, vec![large.clone(), large, elbow, wrist.clone(), wrist.clone(), wrist]).unwrap()
}

fn pose(arm: &Arm, at: [f64; 3]) -> Vec<f64> {
    let start = vec![at[1].atan2(at[0]), -1.2, 1.9, 0.9, 0.0, 0.0];
    inverse_kinematics(arm.chain(), &Target::Pointing(at.into(), -Vector3::z()), &[start]).unwrap()
}

fn axis(gains: ForceGains, reference: f64, contact: Contact) -> Scenario {
    let mut machine = Machine::default();
    machine.bodies.insert("motor".into(), Body { mass_kg: 1.0, ..Body::default() });
    machine.bodies.insert("tip".into(), Body { mass_kg: 1.0, ..Body::default() });
    machine.contacts.insert("tool".into(), contact);
    machine.actuators.insert("drive".into(), Actuator::ideal("motor", GROUND));
    machine.sensors.insert("force".into(), Sensor::ideal(SignalName::new("tool", Quantity::SpringForce)));
    machine.sensors.insert("encoder".into(), Sensor::ideal(SignalName::new("motor", Quantity::Position)));
    let mut spec = ControllerSpec::new(Law::ExplicitForce(gains), 1e-3);
    spec.reference = ReferenceSpec::Constant(reference);
    Controller::<f64>::new(std::slice::from_ref(&spec)).unwrap();
    let used = ControllerUse {
        spec,
        reads: Some("force".into()),
        motion: Some("encoder".into()),
        drives: "drive".into(),
        effects: vec![],
    };
    Scenario {
        machine,
        controllers: [("force".to_owned(), used)].into_iter().collect(),
        run: RunSettings::default(),
    }
}

fn contact(stiffness: f64, damping: f64) -> Contact {
    Contact::kelvin_voigt("tip", GROUND, stiffness, damping)
}

/// A table whose top is `gap_m` below the tool, which points down at a place. The lowest point of the tip is
/// the origin of the tool.
fn cell(arm: Arm, at: [f64; 2], gap_m: f64, speed_m_per_s: f64, scenario: Scenario) -> Cell {
    let joints = arm
        .chain()
        .joints
        .iter()
        .zip(arm.drives())
        .map(|(joint, drive)| JointPart::new(&joint.name, drive, false, &[]).unwrap());
    let joints = joints.collect();
    let half_extents_m = [0.5, 0.5, 0.05];
    Cell {
        bodies: link_capsules(arm.chain()),
        start: Start { pose: pose(&arm, [at[0], at[1], TOOL_M]), normal: DOWN, speed_m_per_s },
        joints,
        tip: Part { shape: Shape::Ball { radius_m: RADIUS_M }, place: Placement::at([-RADIUS_M, 0.0, 0.0]) },
        workpiece: Part {
            shape: Shape::Cuboid { half_extents_m },
            place: Placement::at([0.6, 0.0, TOOL_M - gap_m - 0.05]),
        },
        hold: Hold { bandwidth_hz: 0.0, damping_ratio: 0.7 },
        scenario,
        step_s: None,
        arm,
    }
}

fn forces(cell: &Cell, step_s: f64, rate_hz: f64, end_s: f64) -> Vec<f64> {
    let mut simulation =
        CellSimulation::new(&Cell { step_s: Some(step_s), ..cell.clone() }, rate_hz, 1).unwrap();
    assert!(simulation.run_to(end_s).end.is_none_or(|end| end == RunEnd::Completed));
    simulation.finish();
    simulation.into_record().measures.columns.swap_remove(0)
}

/// Smallest slope of the error's logarithm that separates fourth order from third. At fourth order, halving
/// the step divides the error by 16.
const FOURTH: f64 = 3.6;

#[test]
fn order_the_force_of_an_impact_converges_at_fourth_order_through_touch_and_lift() {
    let cell =
        cell(six_joint(0.0), [0.65, 0.1], 0.4e-3, 0.05, axis(ForceGains::default(), 0.0, contact(2e4, 40.0)));
    let of = |step_s: f64| forces(&cell, step_s, 250.0, 0.12);
    let finest = of(1.5625e-5);
    assert!(
        finest.iter().any(|force| *force > 10.0) && finest.last().is_some_and(|force| *force <= 0.0),
        "{finest:?}"
    );
    let error = |step_s: f64| of(step_s).iter().zip(&finest).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let errors = [5e-4, 2.5e-4, 1.25e-4].map(error);
    println!("error of the force at 0.5, 0.25, 0.125 ms: {errors:?} N");
    for pair in errors.windows(2) {
        assert!((pair[0] / pair[1]).log2() > FOURTH, "{errors:?}");
    }
}

/// In an impact the tip's point moves away from the tool's origin by the radius times the rotation of the
/// tool. The errors of both integrators are smaller.
const SAME_ARM: f64 = 2e-3;

#[test]
fn reference_an_impact_on_a_table_is_that_of_the_arm_against_a_plane_wall() {
    for at in [[0.65, 0.1], [0.5, -0.25]] {
        let arm = six_joint(0.0);
        let wall = Wall { gap_m: 0.0, stiffness_n_per_m: 2e4, damping_n_s_per_m: 40.0 };
        let mut plain =
            FlexibleArm::new(&arm, &pose(&arm, [at[0], at[1], TOOL_M]), DOWN, Others::Free, wall).unwrap();
        plain.throw(Others::Free, 0.05).unwrap();
        let mut expected = 0.0_f64;
        for _ in 0..1200 {
            plain.step(5e-5, 0.0).unwrap();
            expected = expected.max(plain.force_n());
        }
        let cell = cell(arm.clone(), at, 0.0, 0.05, axis(ForceGains::default(), 0.0, contact(2e4, 40.0)));
        let peak = forces(&cell, 5e-5, 2e4, 0.06).into_iter().fold(0.0, f64::max);
        println!("at {at:?}: {peak:.4} N on the table, {expected:.4} N at the wall");
        assert!((peak / expected - 1.0).abs() < SAME_ARM, "{peak} {expected}");
    }
}

#[test]
fn truth_motors_held_by_dry_friction_stay_where_they_are() {
    // A force of 2 N at 0.7 m gives at most 1.4 N m, less than the friction of the three large joints. The
    // wrist's 1 N m holds 2 N at 0.26 m.
    let scenario = axis(ForceGains { feed_forward: 1.0, ..ForceGains::default() }, 2.0, contact(2e4, 40.0));
    let cell = cell(six_joint(5.0), [0.65, 0.1], 1e-3, 0.0, scenario);
    let mut simulation = CellSimulation::new(&cell, 1e3, 1).unwrap();
    assert!(simulation.run_to(0.05).end.is_none_or(|end| end == RunEnd::Completed));
    assert_eq!(simulation.links(), cell.start.pose);
    // A tenth of the friction releases them.
    let loose = self::cell(six_joint(0.1), [0.65, 0.1], 1e-3, 0.0, cell.scenario.clone());
    let mut simulation = CellSimulation::new(&loose, 1e3, 1).unwrap();
    simulation.run_to(0.6);
    assert!(simulation.into_record().measures.events.iter().any(|event| event.kind == EventKind::Touch));
}

#[test]
fn truth_starts_that_make_no_sense_are_refused() {
    let still = |gap_m| {
        cell(six_joint(0.0), [0.65, 0.1], gap_m, 0.0, axis(ForceGains::default(), 0.0, contact(2e4, 40.0)))
    };
    assert!(still(1e-3).check_start().is_ok());
    assert!(still(0.0).check_start().is_ok());
    match still(-2e-3).check_start() {
        Err(ManipulatorError::Penetrates { depth_m }) => assert!((depth_m - 2e-3).abs() < 1e-9, "{depth_m}"),
        other => panic!("{other:?}"),
    }
    let mut up = still(1e-3);
    up.start.normal = [0.0, 0.0, 1.0];
    assert!(matches!(up.check_start(), Err(ManipulatorError::NeverMeets)));
    let mut far = still(1e-3);
    far.workpiece.place = Placement::at([0.6, 0.0, -1.3]);
    assert!(
        matches!(far.check_start(), Err(ManipulatorError::OutOfReach { travel_m, .. }) if travel_m > 1.3)
    );
    let mut folded = still(1e-3);
    folded.start.pose = vec![0.0, -1.2, 2.75, 2.9, 0.0, 0.0];
    match folded.check_start() {
        Err(ManipulatorError::SelfIntersects { a, b, .. }) => println!("{a} meets {b}"),
        other => panic!("{other:?}"),
    }
    let long = Cell { step_s: Some(5e-3), ..still(1e-3) };
    assert!(matches!(CellSimulation::new(&long, 1e3, 1), Err(ManipulatorError::Step { .. })));
}

/// A lever of 0.8 m about y; nothing is within its reach.
fn lever(drive: &JointDrive, effects: &[(&str, &[f64])], speed_m_per_s: f64, force_n: f64) -> Cell {
    let text = r#"<robot name="lever"><link name="base"/>
        <link name="rod"><inertial><mass value="2"/><inertia ixx="0.7" iyy="0.7" izz="0.7"/></inertial></link>
        <link name="tip"/>
        <joint name="hinge" type="continuous">
        <parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint>
        <joint name="end" type="fixed">
        <parent link="rod"/><child link="tip"/><origin xyz="0.8 0 0"/></joint></robot>"#;
    let arm = Arm::new(Urdf::parse(text).unwrap().chain("tip").unwrap(), vec![drive.clone()]).unwrap();
    let of = |(kind, values): &(&str, &[f64])| EffectUse {
        definition: find(kind).unwrap(),
        values: values.to_vec(),
    };
    let effects: Vec<EffectUse> = effects.iter().map(of).collect();
    let mut scenario = axis(ForceGains::default(), force_n, contact(2e4, 40.0));
    for used in scenario.controllers.values_mut() {
        used.spec.law = Law::OpenLoop;
    }
    Cell {
        joints: vec![JointPart::new("hinge", drive, false, &effects).unwrap()],
        bodies: link_capsules(arm.chain()),
        start: Start { pose: vec![0.0], normal: DOWN, speed_m_per_s },
        tip: Part { shape: Shape::Ball { radius_m: RADIUS_M }, place: Placement::default() },
        workpiece: Part {
            shape: Shape::Cuboid { half_extents_m: [0.1; 3] },
            place: Placement::at([0.8, 0.0, -3.0]),
        },
        hold: Hold { bandwidth_hz: 0.0, damping_ratio: 1.0 },
        scenario,
        step_s: None,
        arm,
    }
}

fn events(cell: &Cell, what: &str, end_s: f64) -> Vec<f64> {
    let mut simulation = CellSimulation::new(cell, 1e3, 1).unwrap();
    assert!(simulation.run_to(end_s).end.is_none_or(|end| end == RunEnd::Completed));
    simulation
        .into_record()
        .joint_events
        .iter()
        .filter(|event| event.what == what)
        .map(|event| event.t_s)
        .collect()
}

/// When friction begins, the gear rings at 2650 1/s. The motor's speed then differs from the lever's by 3e-4
/// of 1.1 rad/s^2 times 0.056 s.
const RINGING_S: f64 = 5e-5;

#[test]
fn truth_dry_friction_stops_a_lever_when_its_momentum_is_spent() {
    let cell = lever(&drive(1.1, 3e6, 2500.0, 0.0, 2.0), &[], 0.05, 0.0);
    let stops = events(&cell, "stick", 0.1);
    let expected_s = 0.05 / 0.8 * (1.1 + 0.7) / 2.0;
    println!("the lever stops at {:?}, {expected_s} s expected", stops.first());
    assert!((stops[0] - expected_s).abs() < RINGING_S, "{stops:?}");
}

/// The lever turns by 10 mrad. The torque of a force at its end falls by half the square of that, 5e-5.
const ALMOST_LEVEL: f64 = 5e-5;

#[test]
fn truth_a_motor_crosses_half_its_play_under_its_own_inertia() {
    let cell = lever(&drive(1.1, 3e4, 25.0, 0.0, 0.0), &[("backlash", &[0.02, 0.0, 0.0])], 0.0, 10.0);
    let meets = events(&cell, "touch", 0.06);
    let expected_s = f64::sqrt(2.0 * 0.01 * 1.1 / (10.0 * 0.8));
    println!("the flank meets at {:?}, {expected_s} s expected", meets.first());
    assert!((meets[0] / expected_s - 1.0).abs() < ALMOST_LEVEL, "{meets:?}");
}

/// With `c` the heat in the end, a constant torque falls to `1 / (1 + c)` of it. The heat goes with the
/// square of a torque that falls by [`ALMOST_LEVEL`] itself.
#[test]
fn truth_a_joint_weakens_as_its_winding_warms() {
    let (force_n, halved_n_m, tau) = (10.0, 8.0, 0.02);
    let effect: (&str, &[f64]) = ("thermal-derating", &[halved_n_m, tau]);
    let cell = lever(&drive(1.1, 3e4, 25.0, 0.0, 0.0), &[effect], 0.0, force_n);
    let mut simulation = CellSimulation::new(&cell, 1e3, 1).unwrap();
    assert!(simulation.run_to(0.05).end.is_none_or(|end| end == RunEnd::Completed));
    simulation.finish();
    let motion = simulation.into_record().motion;
    let cold = force_n * 0.8;
    let c = f64::powi(cold / halved_n_m, 2);
    let torques = motion.column("joints.hinge.torque").unwrap();
    assert!(torques.len() > 40);
    for (torque, t) in torques.iter().zip(&motion.t_s).skip(1) {
        let expected = cold / (1.0 + c * (1.0 - (-t / tau).exp()));
        assert!((torque.abs() / expected - 1.0).abs() < 3.0 * ALMOST_LEVEL, "{torque} {expected} at {t} s");
    }
}

/// Tolerance of row times, from the arithmetic of the clocks.
const ROW: f64 = 1e-9;

#[test]
fn truth_a_delayed_sensor_reads_the_force_as_it_was() {
    let mut scenario = axis(ForceGains::default(), 0.0, contact(2e4, 40.0));
    scenario.machine.sensors["force"].delay_s = 2e-3;
    let cell = cell(six_joint(0.0), [0.65, 0.1], 0.2e-3, 0.05, scenario);
    let mut simulation = CellSimulation::new(&cell, 1e3, 1).unwrap();
    simulation.run_to(0.03);
    let record = simulation.into_record().measures;
    let [force, reading] =
        ["tool.spring_force", "force.reading"].map(|name| record.column(name).unwrap().to_vec());
    assert!(force.iter().any(|force| *force > 5.0));
    for (row, was) in force.iter().enumerate().take(force.len() - 2) {
        assert!((reading[row + 2] - was).abs() < ROW * (1.0 + was), "row {row}: {} {was}", reading[row + 2]);
    }
}

/// The time is reported at the end of a step, of at most 0.2 ms here. Meanwhile the joint's speed changes by
/// a few per cent.
const MET_S: f64 = 0.1;

#[test]
fn truth_a_joint_is_stopped_at_the_end_of_its_travel_and_named() {
    let arm = six_joint(0.0);
    let home = pose(&arm, [0.65, 0.1, TOOL_M]);
    let (speed, room) = (0.1, 2e-3);
    let direction = arm.reduce(&home, DOWN, Others::Free).unwrap().direction;
    let joint = 1;
    let side = usize::from(direction[joint] > 0.0);
    let mut chain = arm.chain().clone();
    chain.joints[joint].limits[side] = home[joint] + room * direction[joint].signum();
    let limited = Arm::new(chain, arm.drives().to_vec()).unwrap();
    let cell = cell(limited, [0.65, 0.1], 0.2, speed, axis(ForceGains::default(), 0.0, contact(2e4, 40.0)));
    let mut simulation = CellSimulation::new(&Cell { step_s: Some(2e-4), ..cell }, 1000.0, 1).unwrap();
    assert!(simulation.has_a_way());
    let limit = home[joint] + room * direction[joint].signum();
    let mut farthest = 0.0_f64;
    for i in 1..=400 {
        assert!(simulation.run_to(1e-3 * f64::from(i)).end.is_none_or(|end| end == RunEnd::Completed));
        farthest = farthest.max((simulation.links()[joint] - limit) * direction[joint].signum());
    }
    let record = simulation.into_record();
    let met = record.joint_events.iter().find(|event| event.joint == joint).unwrap();
    assert_eq!(met.what, if side == 1 { feeler_manipulator::UPPER } else { feeler_manipulator::LOWER });
    let expected_s = room / (speed * direction[joint].abs());
    println!(
        "met at {:.4} s, {expected_s:.4} s at constant speed; {farthest:.2e} rad into the stop",
        met.t_s
    );
    assert!((met.t_s / expected_s - 1.0).abs() < MET_S, "{} {expected_s}", met.t_s);
    // Half the kinetic energy of 14 kg at 0.1 m/s in the spring of the stop.
    assert!(farthest > 0.0 && farthest < 4e-3, "{farthest}");
}
