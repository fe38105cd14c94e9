//! Contents of MJCF files.

use super::*;

const MODEL: &str = r#"<mujoco model="two"><compiler angle="degree"/>
  <default><joint damping="1" armature="0.5"/>
    <default class="servo"><joint frictionloss="0.2" armature="0.1"/>
      <position kp="20" kv="2" forcerange="-3 3"/></default></default>
  <worldbody><body name="base"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
    <body name="upper" pos="0 0 1" childclass="servo">
      <joint name="lift" axis="0 1 0" range="-90 90"/>
      <inertial pos="0.5 0 0" mass="2" diaginertia="0.01 0.02 0.03"/>
      <body name="fore" pos="1 0 0">
        <joint name="elbow" axis="0 1 0" pos="0.1 0 0"/>
        <inertial pos="0.3 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
      </body></body></body></worldbody>
  <actuator><position class="servo" joint="lift"/><motor joint="elbow"/></actuator></mujoco>"#;

#[test]
fn truth_classes_and_joints_off_the_body_are_understood() {
    let model = Mjcf::parse(MODEL).expect("a model");
    let lift = &model.joints[0];
    assert_eq!((lift.armature, lift.damping, lift.friction), (0.1, 1.0, 0.2));
    assert_eq!((lift.kp, lift.kd, lift.effort_limit), (Some(20.0), 2.0, Some(3.0)));
    assert_eq!(model.joints[1].kp, None);
    let chain = model.tree.chain("fore").expect("a chain");
    assert!((chain.joints[0].limits[1] - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    let mass = chain.mass_matrix(&[0.0, 0.0]);
    // About the lift: 0.02 + 2 (0.5)^2 + 0.01 + 1 (1.3)^2; about the elbow, at 1.1: 0.01 + 1 (0.2)^2.
    assert!((mass[(0, 0)] - 2.22).abs() < 1e-12 && (mass[(1, 1)] - 0.05).abs() < 1e-12, "{mass}");
}

#[test]
fn truth_what_is_not_simulated_is_refused_with_its_line() {
    let ball = MODEL.replace("name=\"elbow\"", "name=\"elbow\" type=\"ball\"");
    let error = Mjcf::parse(&ball).expect_err("refused").to_string();
    assert!(error.contains("line 10") && error.contains("`ball`"), "{error}");
    assert!(Mjcf::parse("<robot/>").is_err());
}

/// A body of one shape of 1000 kg/m3 on a slide.
fn shape(geom: &str) -> Inertial {
    let text = format!(
        r#"<mujoco><worldbody><body name="b"><joint name="j" type="slide"/><geom {geom}/></body>
        </worldbody></mujoco>"#
    );
    let model = Mjcf::parse(&text).unwrap_or_else(|error| panic!("{geom}: {error}"));
    model.tree.chain("b").expect("a chain").joints[0].inertial.clone()
}

#[test]
fn truth_shapes_have_the_mass_and_inertia_of_their_volume() {
    use std::f64::consts::PI;
    let box_kg = 1000.0 * 8.0 * 0.1 * 0.2 * 0.3;
    let (ball, rod) = (4.0 / 3.0 * PI * 1e3 * 1e-3, PI * 1e3 * 1e-2 * 0.6);
    for (geom, mass_kg, axial) in [
        ("size='0.1'", ball, 0.4 * ball * 0.01),
        ("type='box' size='0.1 0.2 0.3'", box_kg, box_kg / 3.0 * (0.01 + 0.04)),
        ("type='box' size='0.1 0.2 0.3' mass='2'", 2.0, 2.0 / 3.0 * 0.05),
        ("type='cylinder' size='0.1 0.3' density='500'", 0.5 * rod, 0.5 * 0.5 * rod * 0.01),
        ("type='ellipsoid' size='0.1 0.2 0.1' mass='5'", 5.0, 0.01 + 0.04),
        ("type='capsule' size='0.1 0.3'", rod + ball, 0.5 * rod * 0.01 + 0.4 * ball * 0.01),
    ] {
        let found = shape(geom);
        assert!((found.mass_kg - mass_kg).abs() < 1e-12 * mass_kg, "{geom}: {}", found.mass_kg);
        assert!((found.inertia_kg_m2[(2, 2)] - axial).abs() < 1e-12 * axial, "{geom}");
    }
    // Each half of a ball about the ball's centre, moved to the end of the rod by its own centre.
    let half = 0.5 * ball;
    let own = 0.4 * half * 0.01 - half * (0.0375_f64).powi(2);
    let across = rod * (0.01 / 4.0 + 0.09 / 3.0) + 2.0 * (own + half * (0.3_f64 + 0.0375).powi(2));
    let found = shape("type='capsule' size='0.1 0.3'").inertia_kg_m2[(0, 0)];
    assert!((found - across).abs() < 1e-12 * across, "{found} {across}");
    let laid = shape("type='capsule' fromto='0 0 0 0.6 0 0' size='0.1'");
    assert!((laid.centre_m.x - 0.3).abs() < 1e-12 && (laid.inertia_kg_m2[(2, 2)] - across).abs() < 1e-12);
}

#[test]
fn truth_an_inertial_counts_before_shapes_unless_the_compiler_says_otherwise() {
    let mass = |compiler: &str| {
        let text = format!(
            r#"<mujoco><compiler {compiler}/><worldbody><body name="b"><joint type="slide"/>
            <inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/><geom size="0.1" mass="5"/>
            </body></worldbody></mujoco>"#
        );
        Mjcf::parse(&text).expect("a model").tree.chain("b").expect("a chain").joints[0].inertial.mass_kg
    };
    let found = ["", "inertiafromgeom='false'", "inertiafromgeom='true'"].map(mass);
    // The text has the same numbers.
    assert!(found.into_iter().zip([3.0, 3.0, 5.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
}

/// An allow-list: what nobody has looked at is refused.
#[test]
fn truth_what_may_change_a_motion_is_refused_with_its_line() {
    for (from, to, what) in [
        ("name=\"elbow\"", "name=\"elbow\" nonsense=\"1\"", "line 10: `nonsense=\"1\"` of `<joint>`"),
        ("name=\"elbow\"", "name=\"elbow\" springdamper=\"0.1 1\"", "`springdamper"),
        ("angle=\"degree\"", "angle=\"degree\" settotalmass=\"4\"", "line 1: `settotalmass"),
        ("<actuator>", "<magnet/><actuator>", "`<magnet>`"),
        ("<body name=\"fore\"", "<composite/><body name=\"fore\"", "line 9: `<composite>`"),
        ("<worldbody>", "<worldbody><include file=\"hand.xml\"/>", "it includes `hand.xml`"),
        ("<body name=\"base\">", "<body name=\"base\"><freejoint/>", "floats"),
        ("class=\"servo\" joint", "class=\"sevro\" joint", "no default class `sevro`"),
        ("pos=\"1 0 0\"", "pos=\"1 0 0\" quat=\"1 0 0\"", "`quat=\"1 0 0\"` has 3 numbers"),
        ("mass=\"2\"", "mass=\"-2\"", "mass is -2"),
        ("diaginertia=\"0.01 0.02 0.03\"", "diaginertia=\"1 2 9\"", "impossible"),
        ("name=\"fore\"", "name=\"upper\"", "two bodies `upper`"),
        ("<position class=\"servo\"", "<position class=\"servo\" gear=\"2\"", "`gear` of a servo"),
        ("kv=\"2\"", "dampratio=\"1\"", "`dampratio` is not read"),
        (
            "<inertial pos=\"0.3 0 0\" mass=\"1\" diaginertia=\"0.01 0.01 0.01\"/>",
            "<geom type=\"mesh\" mesh=\"fore\"/>",
            "from a mesh is not computed",
        ),
    ] {
        let text = MODEL.replacen(from, to, 1);
        assert_ne!(text, MODEL, "{from}");
        let error = Mjcf::parse(&text).expect_err(to).to_string();
        assert!(error.contains(what), "{to}: {error}");
    }
}

#[test]
fn truth_what_is_not_read_is_remarked_once_with_its_line() {
    assert_eq!(Mjcf::parse(MODEL).expect("a model").remarks, Vec::<String>::new());
    let remarks = |from: &str, to: &str| {
        let text = MODEL.replacen(from, to, 1);
        assert_ne!(text, MODEL, "{from}");
        Mjcf::parse(&text).unwrap_or_else(|error| panic!("{to}: {error}")).remarks
    };
    for (from, to, what) in [
        ("<joint damping", "<joint stiffness=\"3\" damping", "line 2: `stiffness` of `<joint>` is not read"),
        ("<joint damping=\"1\"", "<joint damping=\"1 2\"", "`damping` with several numbers"),
        ("<body name=\"fore\"", "<body name=\"fore\" gravcomp=\"1\"", "line 9: `gravcomp`"),
        ("<actuator>", "<equality><joint joint1=\"lift\"/></equality><actuator>", "`<equality>`"),
        ("<actuator>", "<actuator><velocity joint=\"lift\" kv=\"2\"/>", "`<velocity>` of joint `lift`"),
        ("<actuator>", "<actuator><motor site=\"tip\"/>", "drives no single joint"),
        (
            "<motor joint=\"elbow\"/>",
            "<general joint=\"elbow\" biastype=\"affine\" gainprm=\"9\" biasprm=\"0 -4 0\"/>",
            "the actuator of joint `elbow`",
        ),
        ("<default>", "<option><flag gravity=\"disable\"/></option><default>", "`gravity` of `<flag>`"),
        ("<default>", "<option density=\"1.2\"/><default>", "`density` of `<option>`"),
        ("forcerange=\"-3 3\"", "forcerange=\"-3 2\"", "the smaller limit of the force"),
    ] {
        let found = remarks(from, to);
        assert!(found.len() == 1 && found[0].contains(what), "{to}: {found:?}");
    }
    // Neutral values, and those of solvers and pictures.
    for (from, to) in [
        ("<joint damping", "<joint stiffness=\"0.0\" group=\"3\" damping"),
        ("angle=\"degree\"", "angle=\"degree\" boundmass=\"0\" meshdir=\"a\""),
        ("<default>", "<option density=\"0\" timestep=\"0.1\"/><visual><map/></visual><default>"),
        ("<actuator>", "<equality/><contact><exclude/></contact><actuator>"),
    ] {
        assert_eq!(remarks(from, to), Vec::<String>::new(), "{to}");
    }
}

/// A motor's gear multiplies its force; the tightest limit counts.
#[test]
fn truth_the_limit_of_a_motor_is_that_at_its_joint() {
    let limit = |motor: &str| {
        let text = MODEL.replacen("<motor joint=\"elbow\"/>", motor, 1);
        Mjcf::parse(&text).expect("a model").joints[1].effort_limit
    };
    assert_eq!(limit("<motor joint=\"elbow\" gear=\"150\" ctrlrange=\"-1 1\"/>"), Some(150.0));
    assert_eq!(
        limit("<motor joint=\"elbow\" gear=\"2\" ctrlrange=\"-9 9\" forcerange=\"-4 4\"/>"),
        Some(8.0)
    );
    assert_eq!(limit("<motor joint=\"elbow\" ctrllimited=\"false\" ctrlrange=\"-1 1\"/>"), None);
}
