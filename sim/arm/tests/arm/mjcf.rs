//! Models of MuJoCo, compared with MuJoCo itself.

use std::io::Write as _;
use std::path::PathBuf;
use std::process::Command;

use feeler_arm::{Chain, Mjcf};

/// Every shape, classes in classes, frames, every way to write a turn, a slide, joints shown at `ref`.
const MODEL: &str = r#"<mujoco model="all">
  <compiler angle="degree" eulerseq="ZyX" inertiagrouprange="0 2" autolimits="true"/>
  <option gravity="1 -2 -9" timestep="0.001"/>
  <default>
    <joint damping="1" armature="0.5"/><geom density="800"/>
    <general forcerange="-30 30"/>
    <default class="servo"><joint frictionloss="0.2" armature="0.1"/>
      <position kp="20" kv="2"/><geom type="capsule" size="0.03 0.1"/>
      <default class="strong"><position kp="70" forcerange="-5 5" armature="0.01" damping="0.3"/></default>
    </default>
  </default>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="base" pos="0 0 1"><geom type="mesh" mesh="none"/>
      <frame pos="0.1 0 0" axisangle="0 1 1 40" childclass="servo">
        <body name="a" euler="10 20 30">
          <joint name="a" axis="0 1 0.2" pos="0.05 0 0.02" ref="15" range="-90 90"/>
          <geom/><geom type="box" size="0.1 0.02 0.05" pos="0.1 0 0" mass="0.7" euler="5 0 40"/>
          <geom type="sphere" size="0.2" group="3"/>
          <body name="b" pos="0.3 0 0" xyaxes="1 0.2 0 0 1 0.3">
            <frame pos="0 0.02 0" euler="0 0 90">
              <joint name="b" type="slide" axis="1 0 0" ref="0.05"/>
              <geom class="main" type="ellipsoid" size="0.05 0.1 0.15" zaxis="1 1 0"/>
            </frame>
            <geom type="cylinder" fromto="0 0 0 0.2 0.1 0" size="0.04"/>
            <body name="c" pos="0.1 0.2 0" zaxis="0 0 -1">
              <joint name="c" axis="1 0 1" limited="false" range="0 1"/>
              <inertial pos="0.01 0 0.02" mass="0.4" fullinertia="0.003 0.004 0.005 1e-4 2e-4 3e-4"/>
              <geom type="sphere" size="0.5"/>
              <body name="tool" pos="0 0 0.2" quat="1 2 0 1"><geom fromto="0 0 0 0 0.1 0.1" size="0.02"/>
                <geom type="box" fromto="0 0 0 0.1 0 0.1" size="0.02"/></body>
            </body>
          </body>
        </body>
      </frame>
    </body>
  </worldbody>
  <asset><mesh name="none" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>
  <actuator>
    <position joint="a" class="strong"/>
    <position joint="b" class="servo" kp="90"/>
    <motor joint="c" gear="3" ctrlrange="-2 2"/>
  </actuator>
</mujoco>"#;
/// Positions of the joints.
const POSE: [f64; 3] = [0.4, -0.1, 0.9];
/// Both sides round some hundred products of numbers near one.
const ROUNDING: f64 = 1e-12;

/// The numbers of MuJoCo: that of `FEELER_PYTHON`, else of `python3`.
fn of_mujoco(folder: &tempfile::TempDir) -> Option<Vec<Vec<f64>>> {
    let python = std::env::var("FEELER_PYTHON").unwrap_or_else(|_| "python3".into());
    let has = Command::new(&python).args(["-c", "import mujoco, numpy"]).output();
    if !has.is_ok_and(|done| done.status.success()) {
        let _ = writeln!(std::io::stderr(), "skipped: Python with mujoco and numpy is absent");
        return None;
    }
    let file = folder.path().join("model.xml");
    std::fs::write(&file, MODEL).expect("written");
    let script = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/arm/mjcf.py");
    let mut command = Command::new(&python);
    command.arg(script).arg(file).args(POSE.map(|q| q.to_string()));
    let done = command.output().expect("it runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let text = String::from_utf8(done.stdout).expect("text");
    let numbers = |line: &str| line.split(' ').map(|word| word.parse().expect("a number")).collect();
    Some(text.lines().map(numbers).collect())
}

fn assert_near(what: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (found, expected) in found.iter().zip(expected) {
        let off = (found - expected).abs();
        assert!(off <= ROUNDING * (1.0 + expected.abs()), "{what}: {found}, but MuJoCo has {expected}");
    }
}

#[test]
fn reference_masses_loads_and_loops_are_those_of_mujoco() {
    let model = Mjcf::parse(MODEL).expect("a model");
    let chain: Chain = model.tree.chain("tool").expect("a chain");
    let folder = tempfile::tempdir().expect("a folder");
    let Some(expected) = of_mujoco(&folder) else { return };
    let mass: Vec<f64> = chain.mass_matrix(&POSE).transpose().iter().copied().collect();
    assert_near("mass matrix", &mass, &expected[0]);
    let gravity = chain.inverse_dynamics(&POSE, &[0.0; 3], &[0.0; 3]);
    assert_near("gravity", gravity.as_slice(), &expected[1]);
    let of =
        |number: fn(&feeler_arm::JointBelief) -> f64| model.joints.iter().map(number).collect::<Vec<_>>();
    assert_near("armature", &of(|joint| joint.armature), &expected[2]);
    assert_near("damping", &of(|joint| joint.damping), &expected[3]);
    assert_near("friction", &of(|joint| joint.friction), &expected[4]);
    assert_near("kp", &of(|joint| joint.kp.unwrap_or(0.0)), &expected[5]);
    assert_near("kv", &of(|joint| joint.kd), &expected[6]);
    assert_near("limit", &of(|joint| joint.effort_limit.unwrap_or(f64::INFINITY)), &expected[7]);
}
