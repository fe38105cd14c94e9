//! A servo case as files: the machine as believed, and records of target and position.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::io;
use std::path::Path;

use super::super::make::{Sheet, write_datasets};
use super::super::noise::Random;
use super::draw::Drawn;
use super::record::{Asked, measure};

/// Length of an experiment, in radians of the loop.
const LENGTH: f64 = 190.0;
/// Largest number of rows of an experiment.
const MOST_ROWS: f64 = 2500.0;

/// Writes the datasets of a case, shown and held back, and the machine file beside the first.
pub(super) fn write(folder: &Path, drawn: &Drawn, random: &mut Random) -> io::Result<()> {
    let shown = [
        ("waves-1", "fit", Asked::waves(drawn, 1.0, random)),
        ("waves-2", "fit", Asked::waves(drawn, 0.4, random)),
        ("steps-1", "fit", Asked::steps(drawn, 0.8, random)),
        ("strokes-1", "fit", Asked::strokes(drawn, 0.7, 60.0)),
        ("waves-3", "check", Asked::waves(drawn, 0.7, random)),
        ("steps-2", "check", Asked::steps(drawn, 1.0, random)),
        ("strokes-2", "check", Asked::strokes(drawn, 1.0, 90.0)),
    ];
    let held = [
        ("waves", "check", Asked::waves(drawn, 0.8, random)),
        ("steps", "check", Asked::steps(drawn, 0.7, random)),
    ];
    let seconds = (LENGTH / (TAU * drawn.conditions.loop_hz)).min(MOST_ROWS / drawn.conditions.rate_hz);
    let mut sheets = |experiments: &[(&str, &str, Asked)]| {
        let sheet = |(name, role, asked): &(&str, &str, Asked)| Sheet {
            name: (*name).to_owned(),
            keys: format!("role = \"{role}\"\n"),
            rows: measure(drawn, asked, seconds, random),
        };
        experiments.iter().map(sheet).collect()
    };
    let columns = format!(
        "[columns.target_rad]\nsignal = \"servo.target\"\nhold = {:e}\n\
         [columns.position_rad]\nsignal = \"encoder.reading\"\n",
        1.0 / drawn.conditions.rate_hz
    );
    let groups = [sheets(&shown), sheets(&held)];
    write_datasets(folder, &drawn.case.case, &columns, &machine_file(drawn), &groups)
}

fn machine_file(drawn: &Drawn) -> String {
    let (axis, firmware) = (&drawn.believed.axis, &drawn.believed.firmware);
    let mut text = format!(
        "name = \"{}\"\nabout = \"A servo joint as its maker believes it to be\"\naxis = \"rotational\"\n\n\
         [bodies.motor]\nmass = {:e}\n[bodies.link]\nmass = {:e}\n\n\
         [springs.bearing]\nbetween = [\"ground\", \"motor\"]\ndamping = {:e}\n",
        drawn.case.case, axis.motor_kg, axis.load_kg, axis.damping
    );
    if drawn.is_friction_believed {
        let _ =
            writeln!(text, "[springs.bearing.effects.coulomb-friction]\nlevel = {:e}", axis.friction.level);
    }
    if let Some([amplitude, phase]) = axis.gravity {
        let _ =
            writeln!(text, "[springs.bearing.effects.gravity]\namplitude = {amplitude:e}\nphase = {phase:e}");
    }
    let _ = writeln!(
        text,
        "[springs.gear]\nbetween = [\"motor\", \"link\"]\nrigid = true\n\n\
         [actuators.servo]\non = \"motor\"\nkind = \"position-servo\"\nkp = {:e}\nkd = {:e}\ndelay = {:e}",
        firmware.kp, firmware.kd, firmware.delay_s
    );
    let _ = match firmware.no_load_speed {
        Some(speed) => writeln!(
            text,
            "[actuators.servo.effects.torque-speed-line]\nforce = {:e}\nspeed = {speed:e}",
            firmware.limit
        ),
        None => writeln!(text, "limit = {:e}", firmware.limit),
    };
    let _ = write!(
        text,
        "\n[sensors.encoder]\nreads = \"motor.position\"\nresolution = {:e}\n",
        drawn.conditions.resolution
    );
    text
}
