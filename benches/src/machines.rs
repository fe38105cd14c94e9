//! The machines of the benchmarks: M1, M2, M4, whole force loops, and families of growing size.

use std::fmt::Write as _;
use std::path::Path;

use feeler_engine::{Integrator, Scenario};
use feeler_files::{Document, FormatError};

/// A reference machine with its independent results.
#[derive(Clone, Copy, Debug)]
pub struct Reference {
    /// Short name.
    pub short: &'static str,
    /// Name in benchmarks.
    pub name: &'static str,
    /// The scenario file.
    pub path: &'static str,
    /// Largest contact force on a grid of 0.1 ms, N; computed outside this project by event-located
    /// integration, checked against DOP853 and Radau.
    pub peak_force_n: f64,
    /// Contact force after two seconds, N, from the same source.
    pub force_at_2s_n: f64,
}

/// M1, M2 and M4.
pub const REFERENCES: [Reference; 3] = [
    Reference {
        short: "M1",
        name: "rigid_contact",
        path: concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/reference/m1.toml"),
        peak_force_n: 140.269_504_131_704_14,
        force_at_2s_n: 19.999_999_989_441_182,
    },
    Reference {
        short: "M2",
        name: "flexible_contact",
        path: concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/reference/m2.toml"),
        peak_force_n: 142.273_739_491_869_86,
        force_at_2s_n: 19.999_999_993_076_64,
    },
    Reference {
        short: "M4",
        name: "flexible_cell_contact",
        path: concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/reference/m4.toml"),
        peak_force_n: 127.472_053_082_160_19,
        force_at_2s_n: 20.301_925_783_869_812,
    },
];

/// M2 in a whole force loop that can be written by hand: a filtered and delayed reading, and a PI controller
/// with its limit.
pub const FILTERED_LOOP: Reference = Reference {
    short: "loop",
    name: "filtered_loop",
    path: concat!(env!("CARGO_MANIFEST_DIR"), "/machines/filtered-loop.toml"),
    peak_force_n: 129.052_691_842_286_66,
    force_at_2s_n: 19.902_811_898_013_737,
};

impl Reference {
    /// Its scenario with nothing recorded, so that only the machine and its controller are stepped.
    ///
    /// # Errors
    /// The file is not there, or does not describe a scenario.
    pub fn unrecorded(&self, integrator: Integrator, step_s: f64) -> Result<Scenario, FormatError> {
        let mut scenario = self.recorded(integrator, step_s)?;
        scenario.run.record.clear();
        Ok(scenario)
    }

    /// Its scenario with the contact force, the first signal of the file's record, and nothing else recorded
    /// every 0.1 ms.
    ///
    /// # Errors
    /// The file is not there, or does not describe a scenario.
    pub fn recorded(&self, integrator: Integrator, step_s: f64) -> Result<Scenario, FormatError> {
        let mut scenario = load(self.path)?;
        scenario.run.record.truncate(1);
        scenario.run.integrator = integrator;
        scenario.run.step_s = step_s;
        scenario.run.record_rate_hz = Some(1e4);
        scenario.run.duration_s = DURATION_S;
        Ok(scenario)
    }
}

/// Duration of the reference machines, s, whatever their files contain: the reference numbers are for it.
const DURATION_S: f64 = 2.0;

/// A force loop with everything of a real one: sensor noise, resolution, filter and delay, an approach,
/// friction, and delayed commands.
pub const FORCE_LOOP: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/machines/force-loop.toml");

/// A hammer that bounces off an anvil about once per controller sample: a run dense in events.
pub const BOUNCING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/machines/bouncing.toml");

/// The scenario of a file.
///
/// # Errors
/// The file is not there, or does not describe a scenario.
pub fn load(path: &str) -> Result<Scenario, FormatError> {
    Ok(Document::load(Path::new(path))?.scenario)
}

/// A chain of `bodies` equal masses with a drive on the first; for measurements over the number of bodies.
///
/// # Errors
/// None for any `bodies >= 1`.
pub fn chain(bodies: usize) -> Result<Scenario, FormatError> {
    let mut text = String::new();
    for i in 0..bodies {
        let _ = write!(text, "[bodies.b{i}]\nmass = 1.0\n");
        let (before, stiffness) =
            if i == 0 { ("ground".to_owned(), 0.0) } else { (format!("b{}", i - 1), 1e5) };
        let _ = write!(
            text,
            "[springs.s{i}]\nbetween = [\"{before}\", \"b{i}\"]\nstiffness = {stiffness:?}\ndamping = 20.0\n"
        );
    }
    text += DRIVE_AND_LOOP;
    Ok(Document::parse(&text, "chain.toml")?.scenario)
}

/// A body behind a guide that meets `contacts` walls one after another, 0.1 mm apart.
///
/// # Errors
/// None for any `contacts >= 1`.
pub fn walls(contacts: usize) -> Result<Scenario, FormatError> {
    let mut text = String::from(
        "[bodies.b0]\nmass = 5.0\n[springs.s0]\nbetween = [\"ground\", \"b0\"]\ndamping = 20.0\n",
    );
    for i in 0..contacts {
        let gap_m = 1e-4 * (i + 1) as f64;
        let _ = write!(
            text,
            "[contacts.c{i}]\nbetween = [\"b0\", \"ground\"]\nstiffness = 2e4\ndamping = 20.0\ngap = \
             {gap_m:?}\n"
        );
    }
    text += DRIVE_AND_LOOP;
    Ok(Document::parse(&text, "walls.toml")?.scenario)
}

const DRIVE_AND_LOOP: &str = r#"
[actuators.drive]
on = "b0"
kind = "force"
[sensors.encoder]
reads = "b0.position"
[controllers.position]
law = "position"
reads = "encoder"
drives = "drive"
period = "1 ms"
kp = 2000.0
damping = 50.0
output_limit = 200.0
reference = 0.002
[run]
duration = "2 s"
"#;
