//! `feeler live`.

use std::path::Path;

use feeler_diagnosis::dataset::Dataset;
use feeler_files::{CellFile, Document, Draft, rounded};

use crate::arguments::Live as Arguments;
use crate::live::{Live, Measured, Session};
use crate::terminal;
use crate::terminal::failure::{BadInput, Failure};

/// Digits of joint positions: they give a micrometre at the tool.
const DIGITS: usize = 7;
/// Smaller parts of a pose are rounding errors, rad or m.
const FINEST: f64 = 1e-9;

pub(crate) fn run(arguments: &Arguments) -> crate::Result<()> {
    let draft = Draft::load_with(&arguments.file, &arguments.settings)?;
    if let Some(arm) = draft.arm_file() {
        return Err(of_arm(&CellFile::build(draft)?, &arm));
    }
    let measured = match &arguments.data {
        Some(path) => {
            let machine = Document::load(&arguments.file)?.scenario.machine;
            let dataset = Dataset::load_for(path, &machine)?;
            let repaired = arguments.repaired.as_deref().map(Document::load).transpose()?;
            Some(Measured::new(dataset, repaired.map(|document| document.scenario.machine)))
        }
        None => None,
    };
    let session = Session::new(&arguments.file, &arguments.settings, measured)?;
    let live = Live::new(arguments.port)?;
    terminal::print(&live.address())?;
    terminal::complain("open this address in a browser of this computer; Ctrl-C ends it");
    live.serve(&session);
    Ok(())
}

/// A run of a whole arm takes seconds, which no slider waits for. Names the commands that move its axis.
fn of_arm(file: &CellFile, arm: &Path) -> Failure {
    let list = |values: &[f64]| {
        let short = |value: &f64| rounded((value / FINEST).round() * FINEST + 0.0, DIGITS).to_string();
        values.iter().map(short).collect::<Vec<_>>().join(",")
    };
    let (start, cell) = (&file.cell.start, &file.cell);
    let hold = if cell.hold.bandwidth_hz > 0.0 { " --hold" } else { "" };
    let contact = cell.scenario.machine.contacts.values().next().map_or_else(String::new, |contact| {
        let (stiffness, damping) = (contact.stiffness, contact.damping_n_s_per_m);
        format!(" --contact-stiffness {stiffness} --contact-damping {damping}")
    });
    BadInput::error(
        "this is a scenario of a whole arm, whose run takes seconds: too long to follow a slider",
        format!(
            "reduce it to one axis along the contact normal, and move that: feeler reduce {} --pose={} \
             --normal={}{hold}{contact} --out axis.toml, then feeler live axis.toml",
            arm.display(),
            list(&start.pose),
            list(&start.normal)
        ),
    )
}
