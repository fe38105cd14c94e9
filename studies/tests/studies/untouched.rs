//! Sweeps over a machine that touches nothing: its outcomes are those of the motion under control.

#![expect(clippy::unwrap_used, reason = "a file that cannot be read or run fails the test that asks for it")]

use feeler_studies::sweep::{Sweep, SweepOptions, SweepTable};

/// A mass under PI position control whose reading is late. At a low gain it settles or sticks and slips. At a
/// high gain it swings between the limits of the drive; with a drive without limit it diverges.
const MACHINE: &str = r#"
[bodies.m]
mass = 1.0
[springs.guide]
between = ["ground", "m"]
damping = 6.0
[springs.guide.effects.stribeck-friction]
coulomb = 1.0
static = 1.5
velocity = 0.001
[actuators.drive]
on = "m"
limit = 5.0
[sensors.enc]
reads = "m.position"
delay = 0.05
[controllers.c]
law = "position"
reads = "enc"
drives = "drive"
period = 0.001
kp = 3.0
ki = 4.0
anti_windup = "off"
reference = 1.0
[run]
duration = 100.0
"#;

fn swept(axes: &str) -> SweepTable {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("axis.toml"), MACHINE).unwrap();
    let path = folder.path().join("sweep.toml");
    let head = "name = \"free\"\nabout = \"no contact\"\nscenario = \"axis.toml\"";
    std::fs::write(&path, format!("{head}\n[keep]\ntail = 4\n[axes]\n{axes}")).unwrap();
    let sweep = Sweep::load(&path).unwrap();
    let result = sweep.run(&folder.path().join("out"), SweepOptions::default(), &|_| {}).unwrap();
    SweepTable::read(&result.table.unwrap()).unwrap()
}

fn outcomes(table: &SweepTable) -> Vec<String> {
    table.texts("outcome").unwrap().iter().map(|outcome| outcome.clone().unwrap_or_default()).collect()
}

/// The high gain: the delay of 50 ms takes far more phase than the damping gives.
const GAINS: &str = "\"controllers.c.kp\" = { linear = [3.0, 2500.0], points = 2 }\n";

/// Sweeps over the gain, and over integral gain and limit, with and without friction.
#[test]
fn truth_a_map_tells_settled_hunting_limit_cycle_and_diverging_apart() {
    let friction = "springs.guide.effects.stribeck-friction";
    for (level, gentle) in [(0.0, "settled"), (1.0, "hunting")] {
        let level =
            format!("\"{friction}.coulomb\" = [{level:?}]\n\"{friction}.static\" = [{:?}]\n", 1.5 * level);
        assert_eq!(outcomes(&swept(&format!("{GAINS}{level}"))), [gentle, "limit-cycle"], "{level}");
        let limits = "\"controllers.c.ki\" = { linear = [4.0, 100.0], points = 2 }\n\
                      \"actuators.drive.limit\" = { log = [5.0, 1e6], points = 2 }\n";
        // The limit varies fastest. A gentle integral never reaches either. A strong one diverges without a
        // limit, and winds up at one.
        let expected = [gentle, gentle, "unstable", "unstable"];
        assert_eq!(outcomes(&swept(&format!("{limits}{level}"))), expected, "{level}");
    }
}

/// Without anti-windup an integrator at the limits makes the swing grow with the square root of time. A few
/// cycles of it look steady.
#[test]
fn truth_a_swing_that_winds_up_is_no_limit_cycle() {
    let table = swept("\"controllers.c.ki\" = [60.0, 76.0, 100.0, 116.0]\n");
    assert_eq!(outcomes(&table), ["unstable"; 4]);
}

/// The bifurcation diagram has the largest position of each cycle: one value where each cycle is like the
/// last.
#[test]
fn truth_a_bifurcation_diagram_shows_the_motion_under_control() {
    let table = swept(GAINS);
    assert_eq!(outcomes(&table), ["hunting", "limit-cycle"]);
    let (strobes, amplitudes) = (table.lists("strobe_n").unwrap(), table.reals("amplitude_n").unwrap());
    for row in 0..2 {
        let (strobe, amplitude) = (&strobes[row], amplitudes[row].unwrap());
        let (first, last) = (strobe[0], strobe[strobe.len() - 1]);
        assert!((first - last).abs() < 0.02 * last, "{strobe:?}");
        // About the reference of 1 m.
        assert!((last - 1.0 - amplitude).abs() < 0.1 * last, "{strobe:?} {amplitude}");
    }
}
