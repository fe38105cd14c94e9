//! A controller with its clock, its readings and its outputs in transit.

use std::collections::VecDeque;

use feeler_control::{Controller, Inputs, SampleClock};
use feeler_lanes::{Lane, LaneMask};

use crate::run::wanted::Tapped;
use crate::sample::clock::due;
use crate::sample::reading::Reading;
use crate::sample::sensing::Sensing;

/// A sampled controller; `O` is the type of its output.
#[derive(Debug)]
pub struct Sampler<L: Lane, O = L> {
    controller: Controller<L>,
    clock: SampleClock,
    next_sample: u64,
    /// When the next sample is due, s.
    pub next_sample_s: f64,
    delay_s: f64,
    /// The sensor that it controls, and that of position or velocity.
    readings: [Option<Reading<L>>; 2],
    motion_is_velocity: bool,
    /// Outputs in transit: arrival time and value.
    pending: VecDeque<(f64, O)>,
}

/// One sample of a controller.
#[derive(Clone, Copy, Debug)]
pub struct Sampled<L> {
    /// Time at which it was due, s.
    pub sample_s: f64,
    pub reference: L,
    /// The output that it computed.
    pub output: L,
}

impl<L: Lane, O> Sampler<L, O> {
    /// A controller before its first sample. `tapped` are the sensor that it controls and that of its motion.
    pub fn new(
        controller: Controller<L>,
        clock: SampleClock,
        delay_s: f64,
        tapped: [Option<Tapped>; 2],
        motion_is_velocity: bool,
        sensors: &[Sensing<L>],
    ) -> Self {
        let next_sample_s = clock.sample_time_s(0);
        let reading = |tapped: Option<Tapped>| tapped.map(|own| Reading::new(own, sensors, next_sample_s));
        Self {
            controller,
            next_sample: 0,
            next_sample_s,
            delay_s,
            readings: tapped.map(reading),
            motion_is_velocity,
            pending: VecDeque::new(),
            clock,
        }
    }

    /// Takes the sample that is due at `t_s`. From its time and its reading, `asked` gives the reference and
    /// a force that the law adds.
    #[inline(always)]
    pub fn sample(
        &mut self,
        t_s: f64,
        signals: &[L],
        sensors: &[Sensing<L>],
        asked: impl FnOnce(f64, L) -> [L; 2],
    ) -> Sampled<L> {
        let sample_s = self.next_sample_s;
        let mut read = |which: usize| {
            let reading = self.readings[which].as_mut();
            reading.map_or_else(L::zero, |reading| reading.read(t_s, signals, sensors))
        };
        let (reading, motion) = (read(0), read(1));
        let inputs = Inputs { reading, motion, motion_is_velocity: self.motion_is_velocity };
        let [reference, fed] = asked(sample_s, reading);
        let output = self.controller.sample_fed(sample_s, &inputs, reference, fed);
        self.next_sample += 1;
        self.next_sample_s = self.clock.sample_time_s(self.next_sample);
        Sampled { sample_s, reference, output }
    }

    /// Sends the output of a sample; returns it unless it is delayed.
    #[inline(always)]
    pub fn send(&mut self, sample_s: f64, output: O) -> Option<O> {
        if self.delay_s > 0.0 {
            self.pending.push_back((sample_s + self.delay_s, output));
            return None;
        }
        Some(output)
    }

    /// When the next output arrives, s.
    #[inline(always)]
    pub fn next_arrival_s(&self) -> f64 {
        self.pending.front().map_or(f64::INFINITY, |(t_s, _)| *t_s)
    }

    /// The next output that has arrived.
    #[inline(always)]
    pub fn arrive(&mut self, t_s: f64) -> Option<O> {
        if !due(self.next_arrival_s(), t_s) {
            return None;
        }
        self.pending.pop_front().map(|(_, output)| output)
    }

    /// Whether outputs arrive late.
    pub fn is_late(&self) -> bool {
        self.delay_s > 0.0
    }

    /// Whether a sensor that it reads is delayed.
    pub fn is_delayed(&self) -> bool {
        self.readings.iter().flatten().any(Reading::is_delayed)
    }

    /// Takes the signals that delayed readings will need.
    #[inline(always)]
    pub fn take_delayed(&mut self, t_s: f64, signals: &[L]) {
        for reading in self.readings.iter_mut().flatten() {
            reading.take(t_s, signals, |k| self.clock.sample_time_s(k));
        }
    }

    /// When the next signal for a delayed reading is due, s.
    #[inline(always)]
    pub fn next_take_s(&self) -> f64 {
        self.earliest_take(Reading::next_s)
    }

    /// When the first of these signals later than `t_s` is due, s (see [`Reading::next_after_s`]).
    #[inline(always)]
    pub(crate) fn take_after_s(&self, t_s: f64) -> f64 {
        self.earliest_take(|reading| reading.next_after_s(t_s))
    }

    #[inline(always)]
    fn earliest_take(&self, of: impl Fn(&Reading<L>) -> f64) -> f64 {
        let [first, second] =
            self.readings.each_ref().map(|reading| reading.as_ref().map_or(f64::INFINITY, &of));
        first.min(second)
    }

    /// The signals that delayed readings take.
    pub(crate) fn delayed_signals(&self) -> impl Iterator<Item = usize> {
        self.readings.iter().flatten().filter_map(Reading::delayed_signal)
    }

    /// Whether lane `l` was in its approach at the last sample.
    pub fn is_approaching(&self, l: usize) -> bool {
        self.next_sample > 0 && !self.controller.in_contact_phase().test(l)
    }
}
