//! Measured series with the believed machine.

use std::path::PathBuf;

use feeler_plant::assembly::{Assembly, Source};
use feeler_plant::description::{ActuatorKind, Engagement, Machine, Quantity};
use indexmap::IndexMap;

use super::fault::{Fault, FaultKind};
use super::looped::Looped;

/// A measured column and its signal in the machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Header of the column.
    pub column: String,
    /// The signal.
    pub source: Source,
    /// Standard deviation of white noise, signal units: as stated, or that of the sensor, or else from the
    /// scatter of its own readings ([`Dataset::is_noise_stated`]).
    pub noise: f64,
    /// Believed quantisation step, signal units; zero for none.
    pub resolution: f64,
}

impl Channel {
    /// Whether the signal is the acceleration of a body, bare or through a sensor.
    pub fn quantity(&self, machine: &Machine) -> Quantity {
        match self.source {
            Source::Sensor(i) => machine.sensors[i].reads.quantity,
            Source::Node(_, q) | Source::Contact(_, q) | Source::Link(_, q) | Source::Drive(_, q) => q,
        }
    }

    /// Whether a step of the readings, signal units, is coarser than believed and than the noise.
    pub(crate) fn is_coarse(&self, step: f64) -> bool {
        step > 1.5 * self.resolution && step > self.noise
    }

    /// Factor and offset of its readings.
    pub(crate) fn scale(&self, assembly: &Assembly) -> (f64, f64) {
        match self.source {
            Source::Sensor(i) => (assembly.sensors[i].gain, assembly.sensors[i].bias),
            _ => (1.0, 0.0),
        }
    }

    /// Whether the signal is one of a contact, directly or through a sensor: zero without contact.
    pub fn is_of_contact(&self, machine: &Machine) -> bool {
        match self.source {
            Source::Sensor(i) => machine.contacts.contains_key(&machine.sensors[i].reads.element),
            source => matches!(source, Source::Contact(..)),
        }
    }
}

/// One experiment: commands and readings on an even grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// File name, as a person would say it.
    pub name: String,
    /// Overrides the engagement of the machine's contacts.
    pub engagement: Option<Engagement>,
    /// Scored, never fitted.
    pub is_check: bool,
    /// Experiments with this name are repetitions of each other.
    pub repeat: Option<String>,
    /// Time of the first row, s.
    pub start_s: f64,
    /// Time stamps as read, s.
    pub times_s: Vec<f64>,
    /// Spacing of rows, s.
    pub spacing_s: f64,
    /// Commands of every drive, one per row; N (or m/s). [`Dataset::is_sampled`] says whether they go on
    /// between rows.
    pub commands: Vec<Vec<f64>>,
    /// One series per channel.
    pub series: Vec<Vec<f64>>,
    /// Per channel, whether its series carries no information here: it is constant or clipped.
    pub silent: Vec<bool>,
}

impl Record {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.commands.first().map_or(0, Vec::len)
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// All measurements, with the believed machine.
#[derive(Clone, Debug)]
pub struct Dataset {
    /// Short name.
    pub name: String,
    /// The believed machine.
    pub machine: Machine,
    /// Tolerances of believed values, as fractions, by dotted key.
    pub tolerance: IndexMap<String, f64>,
    /// Drives with recorded commands: index of the actuator and its column, in the order of
    /// [`Record::commands`].
    pub drives: Vec<(usize, String)>,
    /// Per drive, the time for which its commands are held, s; `None`: not stated.
    pub holds_s: Vec<Option<f64>>,
    /// Drives of which not the command was recorded, but what the controller that commands them followed.
    pub loops: Vec<Looped>,
    /// Measured channels, in the order of [`Record::series`].
    pub channels: Vec<Channel>,
    /// The experiments.
    pub records: Vec<Record>,
    /// Assumptions and remarks from reading.
    pub warnings: Vec<Fault>,
}

impl Dataset {
    /// Whether the commands of drive `i` are samples of a signal that goes on between rows. It is then a
    /// force or a voltage of which no hold is stated.
    pub fn is_sampled(&self, i: usize) -> bool {
        let Some((drive, _)) = self.drives.get(i) else { return false };
        let is_pushed = matches!(
            self.machine.actuators[*drive].kind,
            ActuatorKind::Force { .. } | ActuatorKind::DcMotor { .. }
        );
        is_pushed && !self.is_looped(*drive) && self.holds_s.get(i).is_none_or(Option::is_none)
    }

    /// The first column whose commands are such samples.
    pub(crate) fn first_sampled(&self) -> Option<&str> {
        (0..self.drives.len()).find(|i| self.is_sampled(*i)).map(|i| self.drives[i].1.as_str())
    }

    /// Whether a controller commands a drive, so that what was recorded of it is no command.
    pub fn is_looped(&self, drive: usize) -> bool {
        self.loops.iter().any(|looped| looped.drive == drive)
    }

    /// Whether the noise of a channel is stated, and not estimated from the scatter of its readings.
    pub fn is_noise_stated(&self, column: &str) -> bool {
        let is_of = |fault: &Fault| {
            matches!(fault.kind, FaultKind::NoiseNotStated { .. }) && fault.column.as_deref() == Some(column)
        };
        !self.warnings.iter().any(is_of)
    }
}

/// A file's numbers as read: header and columns.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    pub(crate) file: PathBuf,
    /// The clock, the columns of the dataset, then the unused columns.
    pub(crate) header: Vec<String>,
    /// Empty for unused columns.
    pub(crate) columns: Vec<Vec<f64>>,
    /// For each column, the first cell that is not a number, and the number of such cells.
    pub(crate) unreadable: Vec<Option<(usize, usize)>>,
    /// Rows of the file before the first one with data.
    pub(crate) rows_before: usize,
    /// Columns that were resampled, a sentence each.
    pub(crate) notes: Vec<String>,
}
