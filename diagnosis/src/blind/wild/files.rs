//! A wild case as files: the machine as believed and the datasets.

use std::fmt::Write as _;
use std::io;
use std::path::Path;

use super::super::make::{Sheet, write_datasets};
use super::super::noise::Random;
use super::conditions::PERIODS;
use super::draw::Drawn;
use super::motion::Motion;
use super::record::{columns, measure};

/// A file with its role and its share of all periods.
struct Experiment {
    name: &'static str,
    role: &'static str,
    motion: Motion,
    share: f64,
}

impl Experiment {
    fn new(name: &'static str, role: &'static str, share: f64, motion: Motion) -> Self {
        Self { name, role, motion, share }
    }
}

/// Experiments that are shown, and those held back.
fn experiments(drawn: &Drawn, random: &mut Random) -> [Vec<Experiment>; 2] {
    let sizes = &drawn.sizes;
    let shown = if drawn.conditions.files == 1 {
        vec![Experiment::new("all", "", 1.0, Motion::swelling(sizes, random))]
    } else {
        vec![
            Experiment::new("waves-1", "fit", 0.2, Motion::waves(sizes, 1.0, random)),
            Experiment::new("waves-2", "fit", 0.2, Motion::waves(sizes, 0.5, random)),
            Experiment::new("strokes-1", "fit", 0.2, Motion::stroke(sizes, 0.8, 1.0)),
            Experiment::new("waves-3", "check", 0.2, Motion::waves(sizes, 0.75, random)),
            Experiment::new("strokes-2", "check", 0.2, Motion::stroke(sizes, 0.6, 1.4)),
        ]
    };
    let held = vec![
        Experiment::new("waves", "check", 0.2, Motion::waves(sizes, 0.9, random)),
        Experiment::new("strokes", "check", 0.2, Motion::stroke(sizes, 0.9, 0.8)),
    ];
    [shown, held]
}

/// Writes the datasets of a case, shown and held back, and the machine file beside the first.
pub(super) fn write(folder: &Path, drawn: &Drawn, random: &mut Random) -> io::Result<()> {
    let groups = experiments(drawn, random).map(|group| {
        let sheet = |Experiment { name, role, motion, share }: Experiment| Sheet {
            name: name.to_owned(),
            keys: if role.is_empty() { String::new() } else { format!("role = \"{role}\"\n") },
            rows: measure(drawn, &motion, share * PERIODS, random),
        };
        group.into_iter().map(sheet).collect()
    });
    write_datasets(folder, &drawn.case.case, &signals(drawn), &machine_file(drawn), &groups)
}

/// Description of the columns.
fn signals(drawn: &Drawn) -> String {
    let [command, motor, load] = columns(drawn.conditions.is_rotational);
    let mut text = format!(
        "[columns.{command}]\nsignal = \"drive.command\"\n[columns.{motor}]\nsignal = \"encoder.reading\"\n"
    );
    if drawn.conditions.channels > 2 {
        let _ = writeln!(text, "[columns.{load}]\nsignal = \"load_encoder.reading\"");
    }
    text
}

fn machine_file(drawn: &Drawn) -> String {
    let believed = &drawn.believed;
    let axis = if drawn.conditions.is_rotational { "rotational" } else { "translational" };
    let mut text = format!(
        "name = \"{}\"\nabout = \"A driven axis as its maker believes it to be\"\naxis = \"{axis}\"\n\n\
         [bodies.motor]\nmass = {:e}\n[bodies.load]\nmass = {:e}\n\n\
         [springs.guide]\nbetween = [\"ground\", \"motor\"]\ndamping = {:e}\n",
        drawn.case.case, believed.motor_kg, believed.load_kg, believed.damping
    );
    if let Some(level) = believed.friction {
        let _ = writeln!(text, "[springs.guide.effects.coulomb-friction]\nlevel = {level:e}");
    }
    if let Some([amplitude, phase]) = believed.gravity {
        let _ =
            writeln!(text, "[springs.guide.effects.gravity]\namplitude = {amplitude:e}\nphase = {phase:e}");
    }
    let _ = write!(
        text,
        "[springs.transmission]\nbetween = [\"motor\", \"load\"]\nrigid = true\n\n\
         [actuators.drive]\non = \"motor\"\nreacts_on = \"ground\"\nkind = \"force\"\nlimit = {:e}\n\n",
        believed.limit
    );
    let sensors: &[(&str, &str)] = if drawn.conditions.channels == 2 {
        &[("encoder", "motor")]
    } else {
        &[("encoder", "motor"), ("load_encoder", "load")]
    };
    for (sensor, body) in sensors {
        let _ = writeln!(
            text,
            "[sensors.{sensor}]\nreads = \"{body}.position\"\nresolution = {:e}",
            drawn.conditions.resolution
        );
    }
    text
}
