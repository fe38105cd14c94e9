//! Robot descriptions with mistakes: each is reported with its line and remedy.

use feeler_arm::{ArmError, CollisionShape, Target, Urdf, inverse_kinematics};
use feeler_problem::Remedy;
use nalgebra::Vector3;

const GOOD: &str = "<robot name=\"two\">\n\
     <link name=\"base\"/>\n\
     <link name=\"one\"><inertial><mass value=\"2\"/>\
     <inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\"/></inertial>\n\
     <collision><geometry><mesh filename=\"one.stl\"/></geometry></collision></link>\n\
     <link name=\"two\"><inertial><origin xyz=\"0.1 0 0\"/><mass value=\"1\"/>\
     <inertia ixx=\"0.01\" iyy=\"0.02\" izz=\"0.02\"/></inertial></link>\n\
     <joint name=\"a\" type=\"revolute\"><parent link=\"base\"/><child link=\"one\"/>\
     <axis xyz=\"0 0 1\"/><limit lower=\"-2\" upper=\"2\" effort=\"10\"/></joint>\n\
     <joint name=\"b\" type=\"prismatic\"><parent link=\"one\"/><child link=\"two\"/>\
     <axis xyz=\"1 0 0\"/><limit lower=\"0\" upper=\"0.5\"/></joint>\n\
     </robot>";

#[test]
fn truth_what_is_written_is_read() {
    let urdf = Urdf::parse(GOOD).unwrap();
    let meshes: Vec<_> = urdf.meshes().collect();
    assert_eq!((meshes[0].file.as_str(), meshes[0].link.as_str(), meshes[0].line), ("one.stl", "one", 4));
    assert_eq!(urdf.last_link(), Some("two"));
    let chain = urdf.chain("two").unwrap();
    assert_eq!(chain.joints[0].effort_limit, Some(10.0));
    // A turntable with a slide: I1 + I2 + m (0.3 + 0.1)^2 about z, m along x.
    let mass = chain.mass_matrix(&[0.4, 0.3]);
    assert!(
        (mass[(0, 0)] - (0.1 + 0.02 + 0.16)).abs() < 1e-12 && (mass[(1, 1)] - 1.0).abs() < 1e-12,
        "{mass}"
    );
    // Rotation at 2 rad/s pulls the slide outward, and its outward motion brakes the rotation.
    let efforts = chain.coriolis_efforts(&[0.4, 0.3], &[2.0, 0.5]);
    assert!(
        (efforts[1] + 0.4 * 4.0).abs() < 1e-12 && (efforts[0] - 2.0 * 0.4 * 2.0 * 0.5).abs() < 1e-12,
        "{efforts}"
    );
}

/// The mass matrix sums the bodies that each joint carries, and inverse dynamics runs through all links: two
/// methods for one force. The arm moves in space, with a prismatic joint between revolute ones, and centres
/// of mass off every axis.
#[test]
fn truth_forces_of_accelerations_are_those_of_the_mass_matrix() {
    /// Sums of some ten products of numbers of size one.
    const ROUNDING: f64 = 1e-14;
    let link = |name: &str, scale: f64| {
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0.1 -0.2 {scale}\" rpy=\"0.3 0.2 {scale}\"/>\
             <mass value=\"{scale}\"/><inertia ixx=\"0.3\" \
             ixy=\"0.02\" ixz=\"-0.03\" iyy=\"0.4\" iyz=\"0.01\" \
             izz=\"0.5\"/></inertial></link>"
        )
    };
    let joint = |name: &str, kind: &str, [parent, child]: [&str; 2], axis: &str| {
        format!(
            "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <origin xyz=\"0.2 0.3 0.5\" rpy=\"0.4 -0.7 0.1\"/><axis xyz=\"{axis}\"/>\
             <limit lower=\"-9\" upper=\"9\"/></joint>"
        )
    };
    let links = [link("l1", 1.1), link("l2", 0.7), link("l3", 0.4), link("l4", 0.2)].concat();
    let joints = [
        joint("j1", "revolute", ["base", "l1"], "0 0 1"),
        joint("j2", "prismatic", ["l1", "l2"], "0 0.6 0.8"),
        joint("j3", "revolute", ["l2", "l3"], "1 0 0"),
        joint("j4", "revolute", ["l3", "l4"], "0 1 0"),
    ]
    .concat();
    let text = format!("<robot name=\"four\"><link name=\"base\"/>{links}{joints}</robot>");
    let chain = Urdf::parse(&text).unwrap().chain("l4").unwrap();
    let (q, still) = ([0.7, -0.4, 1.9, -2.3], [0.0; 4]);
    let mass = chain.mass_matrix(&q);
    let weight = chain.inverse_dynamics(&q, &still, &still);
    for joint in 0..4 {
        let unit = [0, 1, 2, 3].map(|i| if i == joint { 1.0 } else { 0.0 });
        let force = chain.inverse_dynamics(&q, &still, &unit) - &weight;
        // Weights of up to 24 N are subtracted.
        assert!((force - mass.column(joint)).amax() < 24.0 * ROUNDING, "{mass}");
    }
}

#[test]
fn truth_collision_shapes_stand_in_the_frame_of_what_carries_them() {
    let text = r#"<robot name="post">
        <link name="base"><collision><geometry><box size="0.2 0.4 0.6"/></geometry></collision></link>
        <link name="arm"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial></link>
        <link name="hand"><collision><origin xyz="0 0 0.1"/>
        <geometry><cylinder radius="0.03" length="0.2"/></geometry></collision></link>
        <link name="tip"/>
        <joint name="a" type="continuous">
        <parent link="base"/><child link="arm"/><origin xyz="0 0 1"/></joint>
        <joint name="wrist" type="fixed">
        <parent link="arm"/><child link="hand"/><origin xyz="0.5 0 0"/></joint>
        <joint name="end" type="fixed"><parent link="hand"/><child link="tip"/></joint></robot>"#;
    let found = Urdf::parse(text).unwrap().collisions("tip").unwrap();
    assert_eq!(found.len(), 2);
    assert_eq!(found[0][0].shape, CollisionShape::Box { half_extents_m: [0.1, 0.2, 0.3] });
    assert_eq!(found[1][0].shape, CollisionShape::Cylinder { radius_m: 0.03, half_length_m: 0.1 });
    // Half a metre along the arm, in the frame of joint `a`.
    assert!((found[1][0].place.translation.vector - Vector3::new(0.5, 0.0, 0.1)).norm() < 1e-15);
    let flat = Urdf::parse(&text.replace("0.2 0.4 0.6", "0.2 0 0.6")).unwrap_err().problems()[0].to_string();
    assert!(flat.contains("line 2: the `size` of this box is not above zero (write three numbers"), "{flat}");
}

#[test]
fn truth_mistakes_are_told_with_line_and_remedy() {
    let cases = [
        (("izz=\"0.02\"", "izz=\"0\""), "line 5: link `two` has an inertia of 0 kg m2"),
        (("iyy=\"0.02\"", "iyy=\"0.2\""), "line 5: the principal moments"),
        (("mass value=\"1\"", "mass value=\"-1\""), "line 5: link `two` has a mass of -1 kg"),
        (("<mass value=\"1\"/>", ""), "has no `mass` (add `<mass"),
        (("ixx=\"0.01\"", "ixx=\"light\""), "`ixx=\"light\"` is not a finite number"),
        (("type=\"prismatic\"", "type=\"floating\""), "line 7: joint `b` is of type `floating`"),
        (
            ("child link=\"two\"", "child link=\"three\""),
            "line 7: joint `b` names a link `three` that is not there",
        ),
        (("child link=\"two\"", "child link=\"one\""), "hangs on two joints, `a` and `b`"),
        (
            ("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 0\"/>"),
            "line 6: the axis of joint `a` has no direction",
        ),
        (("lower=\"-2\"", "lower=\"3\""), "write the lower one first"),
        (("<limit lower=\"-2\" upper=\"2\" effort=\"10\"/>", ""), "joint `a` has no `limit`"),
        (("xyz=\"0.1 0 0\"", "xyz=\"0.1 0\""), "is not three finite numbers"),
        (("<robot name=\"two\">", "<robot name=\"two\""), "the model is not XML"),
        (("name=\"two\"><inertial", "name=\"one\"><inertial"), "there are two links `one`"),
    ];
    for ((from, to), said) in cases {
        assert!(GOOD.contains(from), "{from}");
        let error = Urdf::parse(&GOOD.replacen(from, to, 1)).unwrap_err().problems()[0].to_string();
        assert!(error.contains(said), "{to}: {error}");
    }
    let urdf = Urdf::parse(GOOD).unwrap();
    let unknown = urdf.chain("hand").unwrap_err().problems()[0].to_string();
    assert!(unknown.contains("no link `hand`") && unknown.contains("base, one, two"), "{unknown}");
    assert!(matches!(urdf.chain("base"), Err(ArmError::NoJoints { .. })));
    let hollow = GOOD.replacen(
        "<inertial><origin xyz=\"0.1 0 0\"/><mass value=\"1\"/><inertia ixx=\"0.01\" iyy=\"0.02\" \
         izz=\"0.02\"/></inertial>",
        "",
        1,
    );
    let massless = Urdf::parse(&hollow).unwrap().chain("two").unwrap_err().to_string();
    assert!(massless.contains("joint `b` moves nothing that has mass"), "{massless}");
}

#[test]
fn truth_poses_are_checked_and_found() {
    let chain = Urdf::parse(GOOD).unwrap().chain("two").unwrap();
    assert!(matches!(chain.check_pose(&[0.0]), Err(ArmError::Pose { given: 1, needed: 2, .. })));
    assert!(matches!(chain.check_pose(&[2.5, 0.1]), Err(ArmError::Limit { .. })));
    let target = Target::Position(Vector3::new(0.12, 0.16, 0.0));
    let q = inverse_kinematics(&chain, &target, &[vec![0.0, 0.1]]).unwrap();
    assert!((q[0] - f64::atan2(0.16, 0.12)).abs() < 1e-7 && (q[1] - 0.2).abs() < 1e-7, "{q:?}");
    let far = inverse_kinematics(&chain, &Target::Position(Vector3::new(0.0, 0.9, 0.0)), &[vec![0.0, 0.1]])
        .unwrap_err();
    assert!(matches!(far, ArmError::Unreachable { left_m, .. } if (left_m - 0.4).abs() < 1e-3), "{far}");
}

#[test]
fn truth_a_point_of_mass_and_a_fixed_joint_without_an_axis_are_no_mistakes() {
    let frame = "<link name=\"tip\"><inertial><mass value=\"0.5\"/>
        <inertia ixx=\"0\" iyy=\"0\" izz=\"0\"/></inertial></link>
        <joint name=\"fixed\" type=\"fixed\">
        <origin xyz=\"0.1 0 0\"/><parent link=\"two\"/><child link=\"tip\"/>
        <axis xyz=\"0 0 0\"/></joint></robot>";
    let with = Urdf::parse(&GOOD.replacen("</robot>", frame, 1)).unwrap().chain("tip").unwrap();
    let without = Urdf::parse(GOOD).unwrap().chain("two").unwrap();
    let [with, without] = [&with, &without].map(|chain| chain.joints.last().unwrap().inertial.clone());
    assert!((with.mass_kg - without.mass_kg - 0.5).abs() < 1e-15);
}
