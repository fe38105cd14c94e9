//! A machine with recorded commands.

use std::fmt::Write as _;

use feeler_plant::description::Machine;

use super::machine_to_toml;

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
    let mut text = machine_to_toml(machine);
    let mut files = Vec::new();
    let (experiment, period) = (commands.experiment, commands.spacing_s);
    let _ =
        write!(text, "\n# The commands of {experiment}; replace these tables by a controller of your own.\n");
    for (drive, column, values) in &commands.columns {
        let Some((drive, _)) = machine.actuators.get_index(*drive) else { continue };
        let name = format!("{column}.csv");
        let _ = write!(
            text,
            "[controllers.recorded-{drive}]\nlaw = \"open-loop\"\ndrives = \"{drive}\"\nperiod = \
             {period:?}\nreference = {{ kind = \"file\", file = \"{name}\" }}\n\n"
        );
        files.push((name, samples_csv(period, values)));
    }
    let rows = commands.columns.iter().map(|(_, _, values)| values.len()).max().unwrap_or_default();
    let (duration, rate) = (period * rows as f64, 1.0 / period);
    let _ = write!(text, "[run]\nduration = {duration:?}\nrecord_rate = {rate:?}\n");
    (text, files)
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
