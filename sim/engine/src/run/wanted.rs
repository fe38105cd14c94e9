//! Signals of the plant that controllers, servos and the record read.

use feeler_plant::assembly::Source;

/// A sensor with a reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tapped {
    pub sensor: usize,
    /// Index of its signal among the wanted ones.
    pub signal: usize,
}

/// The signals of the plant that have a reader.
#[derive(Default)]
pub(crate) struct Wanted {
    pub(crate) sources: Vec<Source>,
}

impl Wanted {
    /// The index of a signal; a new signal is added.
    pub(crate) fn index(&mut self, source: Source) -> usize {
        self.sources.iter().position(|&s| s == source).unwrap_or_else(|| {
            self.sources.push(source);
            self.sources.len() - 1
        })
    }

    pub(crate) fn tap(&mut self, sensor: usize) -> Tapped {
        Tapped { sensor, signal: self.index(Source::Sensor(sensor)) }
    }
}
