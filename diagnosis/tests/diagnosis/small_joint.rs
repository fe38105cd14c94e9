//! A small flexible joint with an arm is found, though its stiffness is far below that of a linear axis.

use feeler_diagnosis::diagnose;
use feeler_plant::effects::Kind;

use crate::recovery::{multisine, recorded};

const NOISE_RAD: f64 = 1e-5;

/// A servo as small as a thumb: an arm of 0.1 kg at 5 cm.
const BELIEVED: &str = r#"
name = "joint"
axis = "rotational"
[bodies.motor]
mass = 2.0e-4
[bodies.arm]
mass = 3.0e-4
[springs.guide]
between = ["ground", "motor"]
damping = 3.0e-3
[springs.guide.effects.gravity]
amplitude = 0.05
phase = 0.4
[springs.transmission]
between = ["motor", "arm"]
rigid = true
[actuators.drive]
on = "motor"
reacts_on = "ground"
kind = "force"
[sensors.encoder]
reads = "motor.position"
[sensors.arm_encoder]
reads = "arm.position"
"#;

/// The mode of the joint lies at 10 Hz. Its stiffness is 2.4 million times below the typical one.
#[test]
fn truth_a_small_flexible_joint_under_an_arm_is_recovered() {
    let effect = "[springs.transmission.effects.transmission-flexibility]\n\
        stiffness = 0.5\ndamping = 4.0e-4\ntip_mass = 3.0e-4\n";
    let commands = [
        (multisine(0.05, 1.0, 60.0, 0.0), false),
        (multisine(0.03, 1.0, 30.0, 0.7), false),
        (multisine(0.04, 1.0, 60.0, 1.9), true),
    ];
    let real = format!("{BELIEVED}{effect}");
    let answer = diagnose(&recorded([BELIEVED, &real], &commands, &[NOISE_RAD; 2]), &|_| {}).unwrap();
    let found: Vec<_> = answer.effects.iter().filter(|effect| effect.accepted).collect();
    let [joint] = found[..] else { panic!("{found:?}") };
    assert_eq!(joint.kind, Kind::TransmissionFlexibility);
    let stiffness = &joint.parameters["stiffness"];
    let [low, high] = stiffness.ci90;
    assert!(low < 0.5 && 0.5 < high, "{low} to {high}");
    assert!(answer.gap.after < 1.2 * answer.gap.floor, "{:?}", answer.gap);
}
