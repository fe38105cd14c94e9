//! Measured series and the believed machine.

use std::path::PathBuf;
use std::sync::Arc;

use feeler_plant::assembly::{Assembly, Source};
use feeler_plant::description::{ActuatorKind, ElementKind, Engagement, Machine, Quantity, Site};
use indexmap::IndexMap;

use super::bridge::bridge;
use super::fault::{Fault, FaultKind};
use super::looped::Looped;
use super::quantum;

/// A measured column and its signal in the machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Header of the column.
    pub column: String,
    pub source: Source,
    /// Standard deviation of white noise, signal units. It is stated for the column or the sensor, or else
    /// estimated from the scatter of the readings ([`Dataset::is_noise_stated`]).
    pub noise: f64,
    /// Believed quantisation step, signal units; zero for none.
    pub resolution: f64,
}

impl Channel {
    /// Quantity of the signal, read directly or through a sensor.
    pub fn quantity(&self, machine: &Machine) -> Quantity {
        match self.source {
            Source::Sensor(i) => machine.sensors[i].reads.quantity,
            Source::Node(_, q) | Source::Contact(_, q) | Source::Link(_, q) | Source::Drive(_, q) => q,
        }
    }

    /// Standard deviation of noise and steps together, signal units.
    pub(crate) fn sigma(&self) -> f64 {
        self.noise.hypot(self.resolution / 12.0_f64.sqrt())
    }

    /// Whether a step of the readings, signal units, is coarser than the believed resolution and the noise.
    pub(crate) fn is_coarse(&self, step: f64) -> bool {
        step > 1.5 * self.resolution && step > self.noise
    }

    /// Gain and offset of the readings.
    pub(crate) fn scale(&self, assembly: &Assembly) -> (f64, f64) {
        match self.source {
            Source::Sensor(i) => (assembly.sensors[i].gain, assembly.sensors[i].bias),
            _ => (1.0, 0.0),
        }
    }

    /// Whether the signal is one of a contact, directly or through a sensor: zero without contact.
    pub(crate) fn is_of_contact(&self, machine: &Machine) -> bool {
        match self.source {
            Source::Sensor(i) => machine.contacts.contains_key(&machine.sensors[i].reads.element),
            source => matches!(source, Source::Contact(..)),
        }
    }
}

/// A drive with recorded commands.
#[derive(Clone, Debug, PartialEq)]
pub struct Driven {
    /// Index of the actuator.
    pub drive: usize,
    /// Header of the column.
    pub column: String,
    /// Time for which each command is held, s; `None` if not stated.
    pub hold_s: Option<f64>,
    /// Standard deviation of the noise of its commands, SI; `None` if not stated.
    pub noise: Option<f64>,
}

/// One experiment: commands and readings on an even grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Record {
    /// Name of the file, for messages.
    pub name: String,
    /// Engagement that replaces that of the machine's contacts.
    pub engagement: Option<Engagement>,
    /// Whether the record is scored and never fitted.
    pub is_check: bool,
    /// Experiments with this name are repetitions of each other.
    pub repeat: Option<String>,
    /// Time of the first row, s.
    pub start_s: f64,
    /// Time stamps as read, s.
    pub times_s: Vec<f64>,
    pub spacing_s: f64,
    /// Commands of every drive, one per row; N (or m/s). [`Dataset::is_sampled`] says whether they vary
    /// between rows.
    pub commands: Vec<Vec<f64>>,
    /// One series per channel.
    pub series: Vec<Vec<f64>>,
    /// Per channel, whether a row has no reading and its value is interpolated: lost rows, and rows between
    /// the readings of a slow channel. Empty if every row has a reading.
    pub bridged: Vec<Vec<bool>>,
    /// Per channel, whether its series carries no information here: it is constant or clipped.
    pub silent: Vec<bool>,
    /// The previous record on the same clock. It ends one row before this one, or before a pause.
    pub before: Option<Arc<Self>>,
}

impl Record {
    /// A record that starts at time zero and is to be fitted.
    pub fn even(
        name: impl Into<String>,
        spacing_s: f64,
        commands: Vec<Vec<f64>>,
        series: Vec<Vec<f64>>,
    ) -> Self {
        let rows = commands.first().map_or(0, Vec::len);
        Self {
            name: name.into(),
            engagement: None,
            is_check: false,
            repeat: None,
            start_s: 0.0,
            times_s: (0..rows).map(|k| k as f64 * spacing_s).collect(),
            spacing_s,
            silent: vec![false; series.len()],
            bridged: Vec::new(),
            before: None,
            commands,
            series,
        }
    }

    /// Time that the rows last, s.
    pub fn duration_s(&self) -> f64 {
        self.len() as f64 * self.spacing_s
    }

    /// The previous records on the same clock, the latest first.
    pub(crate) fn earlier(&self) -> impl Iterator<Item = &Self> {
        std::iter::successors(self.before.as_deref(), |record| record.before.as_deref())
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.commands.first().map_or(0, Vec::len)
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The rows of channel `c` without a reading; `None` if every row is read.
    fn gaps(&self, c: usize) -> Option<&[bool]> {
        self.bridged.get(c).map(Vec::as_slice).filter(|rows| !rows.is_empty())
    }

    /// Whether a row of channel `c` has no reading.
    pub(crate) fn is_bridged(&self, c: usize, row: usize) -> bool {
        self.gaps(c).is_some_and(|gaps| gaps[row])
    }

    /// Rows of channel `c` that were read.
    pub(crate) fn read_rows(&self, c: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.series[c].len()).filter(move |&k| !self.is_bridged(c, k))
    }

    /// The readings of channel `c`, without interpolated rows.
    pub(crate) fn readings(&self, c: usize) -> Vec<f64> {
        self.read_rows(c).map(|k| self.series[c][k]).collect()
    }

    /// Whether no row of channel `c` was read.
    pub(crate) fn is_unread(&self, c: usize) -> bool {
        self.read_rows(c).next().is_none()
    }

    /// Number of readings of channel `c`, at least one.
    pub(crate) fn count(&self, c: usize) -> usize {
        self.gaps(c).map_or(self.series[c].len(), |_| self.read_rows(c).count()).max(1)
    }

    /// Sets the rows of channel `c` without a reading to zero.
    pub(crate) fn blank(&self, c: usize, values: &mut [f64]) {
        let gaps = self.gaps(c).unwrap_or_default();
        values.iter_mut().zip(gaps).filter(|(_, is_gap)| **is_gap).for_each(|(value, _)| *value = 0.0);
    }

    /// Readings of channel `c` less their predictions, linearly interpolated between readings.
    pub(crate) fn residual(&self, c: usize, predicted: &[f64]) -> Vec<f64> {
        let mut left: Vec<f64> = self.series[c].iter().zip(predicted).map(|(m, p)| m - p).collect();
        if let Some(gaps) = self.gaps(c) {
            bridge(&mut left, |k| gaps[k], false);
            if self.is_unread(c) {
                left.fill(0.0);
            }
        }
        left
    }
}

/// All measurements, with the believed machine.
#[derive(Clone, Debug)]
pub struct Dataset {
    pub name: String,
    /// The believed machine.
    pub machine: Machine,
    /// Tolerances of believed values, as fractions, by dotted key.
    pub tolerance: IndexMap<String, f64>,
    /// Drives with recorded commands, in the order of [`Record::commands`].
    pub drives: Vec<Driven>,
    /// Drives whose column is the reference of their controller, not a command.
    pub loops: Vec<Looped>,
    /// Measured channels, in the order of [`Record::series`].
    pub channels: Vec<Channel>,
    /// One for each experiment.
    pub records: Vec<Record>,
    /// Step of each channel's values in the files, before resampling to an even grid; zero without a step.
    /// Empty for records that were not read from files.
    pub grains: Vec<f64>,
    /// Assumptions and remarks from reading.
    pub warnings: Vec<Fault>,
}

impl Dataset {
    /// Records of a machine, without tolerances, loops or warnings.
    pub fn new(
        name: impl Into<String>,
        machine: Machine,
        drives: Vec<Driven>,
        channels: Vec<Channel>,
        records: Vec<Record>,
    ) -> Self {
        Self {
            grains: Vec::new(),
            name: name.into(),
            machine,
            tolerance: IndexMap::new(),
            drives,
            loops: Vec::new(),
            channels,
            records,
            warnings: Vec::new(),
        }
    }

    /// Whether the commands of drive `i` are samples of a signal that varies between rows: a force or a
    /// voltage without a stated hold.
    pub fn is_sampled(&self, i: usize) -> bool {
        self.drives.get(i).is_some_and(|driven| self.is_pushed(driven.drive) && driven.hold_s.is_none())
    }

    /// Whether the column of a drive is its command, and this is a force or a voltage.
    pub(crate) fn is_pushed(&self, drive: usize) -> bool {
        let is_motor = matches!(self.machine.actuators[drive].kind, ActuatorKind::DcMotor { .. });
        self.is_forced(drive) || is_motor && !self.is_looped(drive)
    }

    /// Whether the column of a drive is its command, and this is a force.
    pub(crate) fn is_forced(&self, drive: usize) -> bool {
        let is_force = matches!(self.machine.actuators[drive].kind, ActuatorKind::Force { .. });
        is_force && !self.is_looped(drive)
    }

    /// Whether the element is a drive with sampled commands ([`Self::is_sampled`]).
    pub(crate) fn is_sampled_at(&self, site: Site) -> bool {
        let is_it = |i: usize| self.drives[i].drive == site.index && self.is_sampled(i);
        site.table == ElementKind::Actuators && (0..self.drives.len()).any(is_it)
    }

    /// The first column with sampled commands ([`Self::is_sampled`]).
    pub(crate) fn first_sampled(&self) -> Option<&str> {
        (0..self.drives.len()).find(|i| self.is_sampled(*i)).map(|i| self.drives[i].column.as_str())
    }

    /// Whether a controller commands a drive, so that its column is not a command.
    pub(crate) fn is_looped(&self, drive: usize) -> bool {
        self.loops.iter().any(|looped| looped.drive == drive)
    }

    /// Step of the values of channel `c`, signal units, if most experiments show a step and it is coarser
    /// than believed; otherwise zero.
    pub(crate) fn grain(&self, c: usize) -> f64 {
        let channel = &self.channels[c];
        let columns = || self.records.iter().map(|record| record.readings(c));
        let step = self
            .grains
            .get(c)
            .copied()
            .unwrap_or_else(|| quantum::grain(|step| channel.is_coarse(step), columns()).usual);
        if channel.is_coarse(step) { step } else { 0.0 }
    }

    /// Whether the noise of a channel is stated, and not estimated from the scatter of its readings.
    pub fn is_noise_stated(&self, column: &str) -> bool {
        let is_of = |fault: &Fault| {
            matches!(fault.kind, FaultKind::NoiseNotStated { .. }) && fault.column.as_deref() == Some(column)
        };
        !self.warnings.iter().any(is_of)
    }
}

/// Numbers of a file as read: header and columns.
#[derive(Clone, Debug)]
pub(crate) struct FileRows {
    pub(crate) file: PathBuf,
    /// The clock, the columns of the dataset, then the unused columns.
    pub(crate) header: Vec<String>,
    /// Empty for unused columns.
    pub(crate) columns: Vec<Vec<f64>>,
    /// For each column, the first cell that is not a number, and the number of such cells.
    pub(crate) unreadable: Vec<Option<(usize, usize)>>,
    /// Rows of the file before the first one with data.
    pub(crate) rows_before: usize,
    /// For each column, the rows without a reading; empty if there are none.
    pub(crate) bridged: Vec<Vec<bool>>,
    /// Sentences about columns that were resampled.
    pub(crate) notes: Vec<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows 1, 2 and 4 of five are bridged; their values are arbitrary.
    #[test]
    fn truth_bridged_rows_are_unknown() {
        let gaps = vec![false, true, true, false, true];
        let of = |unknown: f64| Record {
            series: vec![vec![1.0, unknown, -unknown, 7.0, unknown], vec![0.0; 5]],
            bridged: vec![gaps.clone(), Vec::new()],
            ..Record::default()
        };
        for record in [of(0.0), of(1e9)] {
            assert_eq!(record.readings(0), [1.0, 7.0]);
            assert_eq!([record.count(0), record.count(1)], [2, 5]);
            // The residuals of the readings are 1 and 4; those between are interpolated.
            let left = record.residual(0, &[0.0, 0.0, 0.0, 3.0, 0.0]);
            assert_eq!(left, [1.0, 2.0, 3.0, 4.0, 4.0]);
            let mut values = [1.0; 5];
            record.blank(0, &mut values);
            assert_eq!(values.to_vec(), [1.0, 0.0, 0.0, 1.0, 0.0]);
        }
    }
}
