//! A machine with recorded commands.

use std::fmt::Write as _;

use feeler_catalogue::{Content, Contents};
use feeler_control::reference::{FOLLOWED, REFERENCE, SAMPLES_FILE, SAMPLES_PATH};
use feeler_control::{ControllerSpec, Law};
use feeler_engine::{ControllerUse, RunSettings};
use feeler_plant::description::Machine;

use super::{Writer, inline_of, machine_to_toml};
use crate::keys::{CONTROLLERS, RUN_TABLE};

/// Recorded commands.
#[derive(Clone, Debug)]
pub struct Commands<'a> {
    pub experiment: &'a str,
    /// Time between rows.
    pub spacing_s: f64,
    /// For each column: index of its drive among the actuators, name, and values.
    pub columns: Vec<(usize, &'a str, &'a [f64])>,
}

/// The file of a machine with these commands, and the names and texts of the files that it reads.
pub fn driven_to_toml(machine: &Machine, commands: &Commands<'_>) -> (String, Vec<(String, String)>) {
    let (mut writer, mut files) = (Writer::default(), Vec::new());
    let (experiment, period) = (commands.experiment, commands.spacing_s);
    for (drive, column, values) in &commands.columns {
        let Some((drive, _)) = machine.actuators.get_index(*drive) else { continue };
        let name = format!("{column}.csv");
        writer.header(&[CONTROLLERS.table, &format!("recorded-{drive}")]);
        writer.form(&CONTROLLERS, &Law::OpenLoop);
        writer.words(ControllerUse::DRIVES.key.name, drive);
        writer.number(ControllerSpec::PERIOD.key.name, period);
        let mut samples = Contents::new(Some(SAMPLES_FILE.name));
        samples.insert(SAMPLES_PATH.name, Content::Text(name.clone()));
        writer.line(FOLLOWED.name, inline_of(&REFERENCE, &samples));
        files.push((name, samples_csv(period, values)));
    }
    let rows = commands.columns.iter().map(|(_, _, values)| values.len()).max().unwrap_or_default();
    writer.header(&[RUN_TABLE]);
    writer.number(RunSettings::DURATION.key.name, period * rows as f64);
    writer.number(RunSettings::RECORD_RATE.key.name, 1.0 / period);
    let remark = format!("# The commands of {experiment}; replace these tables by a controller of your own.");
    (format!("{}\n{remark}\n{}", machine_to_toml(machine), writer.text), files)
}

/// Evenly spaced samples in the format of a reference: `t_s,value`, with times to the nanosecond.
pub fn samples_csv(spacing_s: f64, values: &[f64]) -> String {
    let mut text = String::from("t_s,value\n");
    for (k, value) in values.iter().enumerate() {
        let t_s = (k as f64 * spacing_s * 1e9).round() * 1e-9;
        let _ = writeln!(text, "{t_s},{value}");
    }
    text
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use feeler_control::ReferenceSpec;

    use super::*;
    use crate::Document;

    #[test]
    fn truth_recorded_commands_are_read_back_as_written() {
        let scenarios = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios"));
        let machine = Document::load(&scenarios.join("chatter/settles.toml")).unwrap().scenario.machine;
        let columns = vec![(0, "command", [1.0, -0.25, 0.1].as_slice())];
        let commands = Commands { experiment: "push.csv", spacing_s: 1e-3, columns };
        let (text, files) = driven_to_toml(&machine, &commands);
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in &files {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let path = folder.path().join("driven.toml");
        std::fs::write(&path, &text).unwrap();
        let read = Document::load(&path).unwrap().scenario;
        assert_eq!(read.machine.actuators, machine.actuators);
        let [(name, recorded)] = read.controllers.iter().collect::<Vec<_>>()[..] else { panic!("{text}") };
        assert_eq!((name.as_str(), recorded.drives.as_str()), ("recorded-drive", "drive"));
        let expected = ReferenceSpec::samples(vec![0.0, 1e-3, 2e-3], vec![1.0, -0.25, 0.1]);
        assert_eq!(recorded.spec.reference, expected);
        assert_eq!((recorded.spec.period_s, &recorded.spec.law), (1e-3, &Law::OpenLoop));
        assert_eq!((read.run.duration_s, read.run.record_rate_hz), (3e-3, Some(1e3)));
    }
}
