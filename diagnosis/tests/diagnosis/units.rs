//! Columns in a wrong unit or with a wrong sign: only the column that one factor corrects is named.

use std::fmt::Write as _;
use std::fs;

use feeler_diagnosis::dataset::{Dataset, Fault, FaultKind};

const ROWS: usize = 3000;
const SPACING_S: f64 = 1e-3;

const FORCE_AXIS: &str = "[bodies.tip]\nmass = 5.0\n[springs.guide]\nbetween = [\"ground\", \"tip\"]\n\
    damping = 20.0\n[sensors.encoder]\nreads = \"tip.position\"\nnoise = 1e-7\n\
    [sensors.accelerometer]\nreads = \"tip.acceleration\"\nnoise = 0.01\n\
    [actuators.drive]\non = \"tip\"\nkind = \"force\"\n";
const JOINT: &str = "axis = \"rotational\"\n[bodies.link]\nmass = 0.1\n[springs.bearing]\n\
    between = [\"ground\", \"link\"]\ndamping = 0.1\n[sensors.encoder]\nreads = \"link.position\"\n\
    noise = 1e-5\n[sensors.tachometer]\nreads = \"link.velocity\"\nnoise = 1e-3\n\
    [actuators.drive]\non = \"link\"\n";
const SERVO: &str = "kind = \"position-servo\"\nkp = 20.0\nkd = 1.0\n";
const MOTOR: &str = "kind = \"dc-motor\"\nresistance = 4.0\ntorque_constant = 0.01\ngear_ratio = 345.0\n\
    supply_voltage = 7.4\n[controllers.servo]\nlaw = \"position\"\nreads = \"encoder\"\n\
    drives = \"drive\"\nperiod = \"1 ms\"\nkp = 17.0\n";

/// A sum of sines, and its derivatives.
fn wave(t: f64) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for (omega, size) in [(3.0_f64, 0.3), (7.0, 0.1), (17.0, 0.04), (31.0, 0.01)] {
        let (sin, cos) = (omega * t + omega).sin_cos();
        sums[0] += size * sin;
        sums[1] += size * omega * cos;
        sums[2] -= size * omega * omega * sin;
    }
    sums
}

/// A column: header, signal, further keys, and the numbers in the file as a function of time.
type Column<'a> = (&'a str, &'a str, &'a str, fn(f64) -> f64);

/// The columns reported in a wrong unit, with their messages; the numbers of column `spoilt` are multiplied.
fn accused(machine: &str, columns: &[Column<'_>], spoilt: Option<(&str, f64)>) -> Vec<Fault> {
    let all = warned(machine, columns, spoilt);
    all.into_iter().filter(|fault| matches!(fault.kind, FaultKind::Units { .. })).collect()
}

/// All warnings.
fn warned(machine: &str, columns: &[Column<'_>], spoilt: Option<(&str, f64)>) -> Vec<Fault> {
    let folder = tempfile::tempdir().expect("a folder");
    let mut dataset = "machine = \"machine.toml\"\n".to_owned();
    for (name, signal, keys, _) in columns {
        let _ = writeln!(dataset, "[columns.{name}]\nsignal = \"{signal}\"\n{keys}");
    }
    let header: Vec<&str> = columns.iter().map(|(name, ..)| *name).collect();
    for (file, start_s) in [("a.csv", 0.0), ("b.csv", 40.0)] {
        let _ = writeln!(dataset, "[[experiments]]\nfile = \"{file}\"");
        let mut rows = format!("t_s,{}\n", header.join(","));
        for k in 0..ROWS {
            let t = k as f64 * SPACING_S;
            let _ = write!(rows, "{t}");
            for (name, .., numbers) in columns {
                let factor = spoilt.filter(|(other, _)| other == name).map_or(1.0, |(_, factor)| factor);
                let _ = write!(rows, ",{}", factor * numbers(t + start_s));
            }
            rows.push('\n');
        }
        fs::write(folder.path().join(file), rows).expect("written");
    }
    fs::write(folder.path().join("machine.toml"), machine).expect("written");
    fs::write(folder.path().join("dataset.toml"), dataset).expect("written");
    Dataset::load(folder.path()).unwrap_or_else(|error| panic!("{error}")).warnings
}

/// Asserts that only this column is named, with these words.
fn names(found: &[Fault], column: &str, words: &str) {
    let [only] = found else { panic!("{column}: {found:?}") };
    assert_eq!(only.column.as_deref(), Some(column), "{only}");
    assert!(only.to_string().contains(words), "{words}: {only}");
}

/// The numbers are SI, and one column states another unit. No other column is named instead, with or without
/// a third column of the same motion.
#[test]
fn truth_a_column_whose_stated_unit_is_not_that_of_its_numbers_is_named() {
    let push: fn(f64) -> f64 = |t| 5.0 * wave(t)[2] + 20.0 * wave(t)[1];
    let all: [Column<'_>; 3] = [
        ("command", "drive.command", "", push),
        ("place", "encoder.reading", "", |t| wave(t)[0]),
        ("acceleration", "accelerometer.reading", "", |t| wave(t)[2]),
    ];
    let stated =
        [("command", "scale = 0.001"), ("place", "unit = \"mm\""), ("acceleration", "scale = 0.001")];
    for used in [&all[..], &all[..2]] {
        let columns = |wrong: Option<(&str, &'static str)>| -> Vec<Column<'_>> {
            let keys = |name: &str| wrong.filter(|(other, _)| *other == name).map_or("", |(_, keys)| keys);
            used.iter().map(|(name, signal, _, numbers)| (*name, *signal, keys(name), *numbers)).collect()
        };
        assert_eq!(accused(FORCE_AXIS, &columns(None), None), Vec::<Fault>::new());
        for wrong in stated.iter().filter(|(name, _)| used.iter().any(|(other, ..)| other == name)) {
            let found = accused(FORCE_AXIS, &columns(Some(*wrong)), None);
            names(&found, wrong.0, "its own `unit` or `scale` (are its numbers in SI already?)");
            assert!(found[0].remedy().contains("remove its `unit` or `scale`"), "{}", found[0]);
        }
    }
}

/// Each column in turn, with opposite sign and in other units.
#[test]
fn truth_every_column_of_a_force_axis_is_named_for_its_own_fault() {
    let columns: [Column<'_>; 3] = [
        ("command", "drive.command", "", |t| 5.0 * wave(t)[2] + 20.0 * wave(t)[1]),
        ("place", "encoder.reading", "", |t| wave(t)[0]),
        ("acceleration", "accelerometer.reading", "", |t| wave(t)[2]),
    ];
    for (column, factor, words) in [
        ("command", -1.0, "-1 (a sign?)"),
        ("place", -1.0, "-1 (a sign?)"),
        ("acceleration", -1.0, "-1 (a sign?)"),
        ("command", 1e-3, "1/1000 (kN for N?)"),
        ("place", 1e3, "1000 (mm for m?)"),
        // A length has no counts of a turn.
        ("place", 4096.0 / std::f64::consts::TAU, "no factor of common units (counts?)"),
        ("place", 2e5, "no factor of common units (counts?)"),
        ("acceleration", 1.0 / 9.806_65, "1/9.81 (g for m/s²?)"),
        ("acceleration", 1e3, "1000 (mm/s² for m/s²?)"),
    ] {
        names(&accused(FORCE_AXIS, &columns, Some((column, factor))), column, words);
    }
}

/// Half of the command is friction, the encoder's steps hide the acceleration of single rows, and the command
/// is noisy. A hidden mass does not count as a wrong unit.
#[test]
fn truth_a_wrong_unit_is_named_where_friction_and_steps_hide_the_acceleration() {
    const HIDDEN: f64 = 2.5;
    let machine =
        FORCE_AXIS.replace("[sensors.accelerometer]\nreads = \"tip.acceleration\"\nnoise = 0.01\n", "");
    let push: fn(f64) -> f64 = |t| {
        let [_, speed, acceleration] = wave(t);
        let noise = (43_758.5 * (12_989.8 * t).sin()).fract();
        5.0 * acceleration + 20.0 * speed + 40.0 * speed.signum() + 10.0 * noise
    };
    let place: fn(f64) -> f64 = |t| (wave(t)[0] / 2e-3).round() * 2e-3;
    let more: fn(f64) -> f64 = |t| {
        let [_, speed, acceleration] = wave(t);
        HIDDEN * 5.0 * acceleration + 20.0 * speed + 40.0 * speed.signum()
    };
    for push in [push, more] {
        let columns: [Column<'_>; 2] =
            [("command", "drive.command", "", push), ("place", "encoder.reading", "", place)];
        assert_eq!(accused(&machine, &columns, None), Vec::<Fault>::new());
    }
    let columns: [Column<'_>; 2] =
        [("command", "drive.command", "", push), ("place", "encoder.reading", "", place)];
    for (column, factor, named, words) in [
        ("place", 180.0 / std::f64::consts::PI, "place", "57.3 (degrees for radians?)"),
        ("place", 4096.0 / std::f64::consts::TAU, "place", "652 (counts of 4096 a turn for radians?)"),
        ("place", 1e3, "place", "1000 (mm for m?)"),
        ("command", 1e3, "command", "1000 (mN for N?)"),
        ("command", 10.0, "command", "no factor of common units (a current for a force"),
        ("command", 0.1, "command", "no factor of common units (a current for a force"),
    ] {
        // Only an angle is in degrees, or in counts of a turn.
        let axis = if words.contains("radians") { "axis = \"rotational\"\n" } else { "" };
        names(&accused(&format!("{axis}{machine}"), &columns, Some((column, factor))), named, words);
    }
    // The encoder is turned in the second experiment only, which begins at 40 s.
    let turned: fn(f64) -> f64 = |t| wave(t)[0] * if t < 20.0 { 1.0 } else { -1.0 };
    let columns_turned = [columns[0], ("place", "encoder.reading", "", turned)];
    let found = accused(&machine, &columns_turned, None);
    names(&found, "place", "-1 (a sign?)");
    assert!(found[0].to_string().contains("b.csv"), "{}", found[0]);
    // Without the steps of the encoder either column may be wrong. If they are as stated, the command is.
    let kilo = Some(("command", 1e-3));
    names(&accused(&machine, &columns, kilo), "place", "1000 (mm for m?)");
    let machine = machine.replace("noise = 1e-7", "resolution = 2e-3");
    names(&accused(&machine, &columns, kilo), "command", "1/1000 (kN for N?)");
}

/// The believed spring stands in for the acceleration, which it exceeds in most of the motion.
#[test]
fn truth_a_wrong_unit_is_named_where_a_spring_holds_the_axis() {
    let machine = FORCE_AXIS
        .replace("[sensors.accelerometer]\nreads = \"tip.acceleration\"\nnoise = 0.01\n", "")
        .replace("damping = 20.0", "damping = 20.0\nstiffness = 2000.0");
    // At rest the spring is stretched by 0.1 m.
    let push: fn(f64) -> f64 = |t| {
        let [place, speed, acceleration] = wave(t);
        5.0 * acceleration + 20.0 * speed + 10.0 * speed.signum() + 2000.0 * (place + 0.1)
    };
    let columns: [Column<'_>; 2] =
        [("command", "drive.command", "", push), ("place", "encoder.reading", "", |t| wave(t)[0])];
    assert_eq!(accused(&machine, &columns, None), Vec::<Fault>::new());
    names(&accused(&machine, &columns, Some(("place", 1e3))), "place", "1000 (mm for m?)");
    names(&accused(&machine, &columns, Some(("command", 1e3))), "command", "1000 (mN for N?)");
    // A spring that is softer than believed is not a wrong unit. A stop that is not reached is not a spring.
    assert_eq!(accused(&machine.replace("2000.0", "14000.0"), &columns, None), Vec::<Fault>::new());
    let stop = "stiffness = 2000.0\neffects.hard-stop = { position = 0.9, stiffness = 1e6 }";
    assert_eq!(accused(&machine.replace("stiffness = 2000.0", stop), &columns, None), Vec::<Fault>::new());
    // Near the resonance, small errors of the spring change the needed force by a large factor.
    let hum: fn(f64) -> f64 = |t| 0.1 * (0.97 * 20.0 * t).sin();
    let push: fn(f64) -> f64 = |t| {
        let phase = 0.97 * 20.0 * t;
        0.1 * ((1900.0 - 5.0 * (0.97_f64 * 20.0).powi(2)) * phase.sin() + 20.0 * 19.4 * phase.cos())
    };
    let resonant: [Column<'_>; 2] =
        [("command", "drive.command", "", push), ("place", "encoder.reading", "", hum)];
    assert_eq!(accused(&machine, &resonant, None), Vec::<Fault>::new());
    // Another body at the end of the spring may move as well.
    let apart =
        machine.replace("[\"ground\", \"tip\"]", "[\"base\", \"tip\"]") + "[bodies.base]\nmass = 9.0\n";
    assert_eq!(accused(&apart, &columns, Some(("place", 1e3))), Vec::<Fault>::new());
}

/// Target and motion of a servo, and of a motor with a position loop, 40 ms apart.
#[test]
fn truth_a_target_or_position_of_a_servo_in_a_wrong_unit_is_named() {
    let target: fn(f64) -> f64 = |t| wave(t)[0];
    let place: fn(f64) -> f64 = |t| wave(t - 0.04)[0] + 0.02;
    for (drive, signal) in [(SERVO, "drive.target"), (MOTOR, "controllers.servo.reference")] {
        let machine = format!("{JOINT}{drive}");
        let columns = [("asked", signal, "", target), ("place", "encoder.reading", "", place)];
        assert_eq!(accused(&machine, &columns, None), Vec::<Fault>::new());
        for (factor, words) in [
            (180.0 / std::f64::consts::PI, "57.3 (degrees for radians?)"),
            (4096.0 / std::f64::consts::TAU, "652 (counts of 4096 a turn for radians?)"),
            (1e3, "1000 (mm for m?)"),
            (17.5, "no factor of common units (counts?)"),
            (2e5, "no factor of common units (counts?)"),
        ] {
            for column in ["asked", "place"] {
                names(&accused(&machine, &columns, Some((column, factor))), column, words);
            }
        }
        // No reading shows which of the two has the wrong sign.
        for column in ["asked", "place"] {
            names(&accused(&machine, &columns, Some((column, -1.0))), "place", "-1 (a sign?)");
        }
    }
}

/// The range of the sines is at most 0.9 rad. An encoder with its zero half a turn away is offset by 3.1 rad
/// and is reported. An offset of 0.3 rad due to a load is not.
#[test]
fn truth_a_position_with_another_zero_than_its_target_is_named() {
    let machine = format!("{JOINT}{SERVO}");
    let beside = |place: fn(f64) -> f64| {
        let columns: [Column<'_>; 2] =
            [("asked", "drive.target", "", |t| wave(t)[0]), ("place", "encoder.reading", "", place)];
        let found = warned(&machine, &columns, None).into_iter();
        found.filter(|fault| matches!(fault.kind, FaultKind::Beside { .. })).collect::<Vec<Fault>>()
    };
    assert_eq!(beside(|t| wave(t - 0.04)[0] + 0.3), Vec::<Fault>::new());
    let found = beside(|t| wave(t - 0.04)[0] + std::f64::consts::PI);
    names(&found, "place", "is offset by 3.1");
    assert!(found[0].remedy().contains("`offset`") && !found[0].kind.is_contradiction(), "{}", found[0]);
}

/// A steady sine of 120 rad/s, far above the servo's 14 rad/s. The link moves by 1/71 of it, with opposite
/// sign: `20 / (20 - 0.1 w^2 + j w)`.
#[test]
fn truth_a_servo_that_cannot_follow_its_target_has_no_wrong_unit() {
    let machine = format!("{JOINT}{SERVO}");
    let columns: [Column<'_>; 2] = [
        ("asked", "drive.target", "", |t| (120.0 * t).sin()),
        ("place", "encoder.reading", "", |t| {
            let [real, imaginary]: [f64; 2] = [20.0 - 0.1 * 120.0 * 120.0, 120.0];
            20.0 / real.hypot(imaginary) * (120.0 * t - imaginary.atan2(real)).sin()
        }),
    ];
    assert_eq!(accused(&machine, &columns, None), Vec::<Fault>::new());
}

#[test]
fn truth_a_velocity_of_another_unit_or_sign_is_held_against_the_position() {
    let machine = format!("{JOINT}{SERVO}");
    let columns: [Column<'_>; 3] = [
        ("asked", "drive.target", "", |t| wave(t)[0]),
        ("place", "encoder.reading", "", |t| wave(t - 0.04)[0]),
        ("speed", "tachometer.reading", "", |t| wave(t - 0.04)[1]),
    ];
    assert_eq!(accused(&machine, &columns, None), Vec::<Fault>::new());
    for (factor, words) in [
        (180.0 / std::f64::consts::PI, "57.3 (degrees for radians?)"),
        (30.0 / std::f64::consts::PI, "9.55 (turns a minute for rad/s?)"),
        (-1.0, "-1 (a sign?)"),
    ] {
        names(&accused(&machine, &columns, Some(("speed", factor))), "speed", words);
    }
}

/// A sensor behind a gear reads a hundred turns in the other direction for one. Its gain is believed, so it
/// is not a fault.
#[test]
fn truth_a_believed_gain_is_no_wrong_unit() {
    let machine = FORCE_AXIS.replace("noise = 1e-7", "noise = 1e-5\ngain = -100.0");
    let columns: [Column<'_>; 3] = [
        ("command", "drive.command", "", |t| 5.0 * wave(t)[2] + 20.0 * wave(t)[1]),
        ("place", "encoder.reading", "", |t| -100.0 * wave(t)[0]),
        ("acceleration", "accelerometer.reading", "", |t| wave(t)[2]),
    ];
    for used in [&columns[..], &columns[..2]] {
        assert_eq!(accused(&machine, used, None), Vec::<Fault>::new());
        names(&accused(&machine, used, Some(("place", 1e3))), "place", "1000 (mm for m?)");
    }
}

/// A tachometer with more noise than motion is not evidence about the position.
#[test]
fn truth_a_lone_position_in_a_wrong_unit_is_named_beside_a_tachometer_of_noise() {
    let machine =
        FORCE_AXIS.replace("accelerometer", "tachometer").replace("tip.acceleration", "tip.velocity");
    let columns: [Column<'_>; 3] = [
        ("command", "drive.command", "", |t| 5.0 * wave(t)[2] + 20.0 * wave(t)[1]),
        ("place", "encoder.reading", "", |t| wave(t)[0]),
        // Uniform noise between -2 and 2 m/s, on a speed of at most about 2 m/s.
        ("speed", "tachometer.reading", "", |t| {
            wave(t)[1] + 4.0 * ((43_758.5 * (12_989.8 * t).sin()).fract())
        }),
    ];
    assert_eq!(accused(&machine, &columns, None), Vec::<Fault>::new());
    names(&accused(&machine, &columns, Some(("place", 1e3))), "place", "1000 (mm for m?)");
}
