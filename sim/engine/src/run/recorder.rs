//! Records the signals of a run.

use feeler_lanes::Lane;

use crate::carry::lanes::Lanes;
use crate::run::program::{Program, Recorded};
use crate::run::wanted::Tapped;
use crate::sample::clock::due;
use crate::sample::reading::Reading;
use crate::sample::sampling::{Sampling, earlier};

/// Takes the recorded signals of every lane.
#[derive(Debug)]
pub(crate) struct Recorder<L: Lane> {
    recorded: Vec<Recorded>,
    /// For each signal, its reader if it is the reading of a sensor.
    readings: Vec<Option<Reading<L>>>,
    any_delayed: bool,
    /// The signals of the last record.
    values: Vec<L>,
    records: u64,
    /// Instant of the next record; infinite if nothing is recorded.
    next_s: f64,
    rate_hz: f64,
}

impl<L: Lane> Recorder<L> {
    pub(crate) fn new(program: &Program, sampling: &Sampling<L>) -> Self {
        let recorded = program.recorded.clone();
        let reading = |recorded: &Recorded| match *recorded {
            Recorded::Reading(sensor, signal) => {
                Some(Reading::new(Tapped { sensor, signal }, sampling.sensors(), 0.0))
            }
            _ => None,
        };
        let readings: Vec<_> = recorded.iter().map(reading).collect();
        Self {
            any_delayed: readings.iter().flatten().any(Reading::is_delayed),
            readings,
            values: vec![L::zero(); recorded.len()],
            records: 0,
            next_s: if recorded.is_empty() { f64::INFINITY } else { 0.0 },
            rate_hz: 1.0 / program.record_spacing_s(),
            recorded,
        }
    }

    /// When the next record is due, s.
    #[inline(always)]
    pub(crate) fn next_instant_s(&self) -> f64 {
        self.next_s
    }

    /// When the next signal for a delayed reading is due, s.
    #[inline(always)]
    pub(crate) fn next_take_s(&self) -> f64 {
        self.earliest_take(Reading::next_s)
    }

    /// Earliest time after `t_s` at which one of these signals is due, s. A time up to `t_s` means that it is
    /// not known yet.
    #[inline(always)]
    pub(crate) fn take_after_s(&self, t_s: f64) -> f64 {
        self.earliest_take(|reading| reading.next_after_s(t_s))
    }

    #[inline(always)]
    fn earliest_take(&self, of: impl Fn(&Reading<L>) -> f64) -> f64 {
        let takes = self.readings.iter().flatten().map(of);
        if self.any_delayed { takes.fold(f64::INFINITY, earlier) } else { f64::INFINITY }
    }

    /// The signals that delayed readings take.
    pub(crate) fn delayed_signals(&self) -> impl Iterator<Item = usize> {
        self.readings.iter().flatten().filter_map(Reading::delayed_signal)
    }

    /// Takes the signals of `t_s` that delayed readings will need.
    #[inline(always)]
    pub(crate) fn take_delayed(&mut self, t_s: f64, signals: &[L]) {
        if self.any_delayed {
            let rate_hz = self.rate_hz;
            for reading in self.readings.iter_mut().flatten() {
                reading.take(t_s, signals, |k| k as f64 / rate_hz);
            }
        }
    }

    #[inline(always)]
    pub(crate) fn is_due(&self, t_s: f64) -> bool {
        due(self.next_s, t_s)
    }

    /// Takes the values that a sampler would read before newly arrived commands act.
    pub(crate) fn take_plant(&mut self, lanes: &Lanes<L>, sampling: &Sampling<L>) {
        let (t_s, signals) = (lanes.time_s(), lanes.signals());
        for ((value, recorded), reading) in self.values.iter_mut().zip(&self.recorded).zip(&mut self.readings)
        {
            *value = match (*recorded, reading) {
                (Recorded::Plant(signal), _) => signals[signal],
                (_, Some(reading)) => reading.read(t_s, signals, sampling.sensors()),
                (Recorded::Touch(contact, which), _) => lanes.touch(contact, which),
                (Recorded::Touching(contact), _) => lanes.is_touching(contact),
                _ => L::zero(),
            };
        }
    }

    /// Takes the values issued at this instant, which complete the record.
    pub(crate) fn take_commands(&mut self, lanes: &Lanes<L>, sampling: &Sampling<L>) {
        for (value, recorded) in self.values.iter_mut().zip(&self.recorded) {
            match *recorded {
                Recorded::Command(i) => *value = sampling.command(i),
                Recorded::Output(i) => *value = sampling.output(i),
                Recorded::Reference(i) => *value = sampling.reference(i),
                _ => {}
            }
        }
        lanes.blank_ended(&mut self.values);
        self.records += 1;
        self.next_s = self.records as f64 / self.rate_hz;
    }

    /// The signals of the last record, in the order of the scenario.
    pub(crate) fn values(&self) -> &[L] {
        &self.values
    }
}
