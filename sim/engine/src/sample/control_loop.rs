//! One controller of every lane, with its clock and its outputs in transit.

use std::collections::VecDeque;

use feeler_control::{Controller, Inputs, Reference, SampleClock};
use feeler_lanes::Lane;

use crate::error::EngineError;
use crate::run::program::Program;
use crate::sample::reading::Reading;
use crate::sample::sensing::Sensing;

/// The running controller of every lane.
#[derive(Debug)]
pub(crate) struct ControlLoop<L: Lane> {
    pub(super) name: String,
    pub(super) controller: Controller<L>,
    clock: SampleClock,
    next_sample: u64,
    pub(super) next_sample_s: f64,
    pub(super) delay_s: f64,
    /// Outputs in transit: arrival time and value.
    pub(super) pending: VecDeque<(f64, L)>,
    /// Output as applied.
    pub(super) output: L,
    /// The reference at the last sample.
    pub(super) reference: L,
    /// One reference for all lanes, or one per lane.
    references: Vec<Reference>,
    pub(super) drive: usize,
    /// Whether the command of the drive is its force.
    pub(super) drives_force: bool,
    motion_is_velocity: bool,
    /// The sensor it controls.
    reading: Option<Reading<L>>,
    /// The sensor of position or velocity.
    motion: Option<Reading<L>>,
}

impl<L: Lane> ControlLoop<L> {
    /// Controller `i` of all programs.
    pub(super) fn new(programs: &[Program], i: usize, sensors: &[Sensing<L>]) -> Result<Self, EngineError> {
        let (name, used) =
            programs[0].controllers.get_index(i).ok_or(EngineError::Lanes { given: 0, lanes: L::WIDTH })?;
        let specs: Vec<_> = programs.iter().map(|program| program.controllers[i].spec.clone()).collect();
        let controller =
            Controller::new(&specs).map_err(|source| EngineError::Control { name: name.clone(), source })?;
        let wiring = &programs[0].wiring[i];
        let next_sample_s = wiring.clock.sample_time_s(0);
        let is_shared = specs.iter().all(|spec| spec.reference == specs[0].reference);
        let kept = if is_shared { 1 } else { L::WIDTH };
        let drive = &programs[0].motion.assembly().drives[wiring.drive];
        Ok(Self {
            name: name.clone(),
            controller,
            clock: wiring.clock.clone(),
            next_sample: 0,
            next_sample_s,
            delay_s: used.spec.delay_s,
            pending: VecDeque::new(),
            output: L::zero(),
            reference: L::zero(),
            references: programs[..kept].iter().map(|p| p.wiring[i].reference.clone()).collect(),
            drive: wiring.drive,
            drives_force: drive.commands_force(),
            motion_is_velocity: wiring.motion_is_velocity,
            reading: wiring.reading.map(|tapped| Reading::new(tapped, sensors, next_sample_s)),
            motion: wiring.motion.map(|tapped| Reading::new(tapped, sensors, next_sample_s)),
        })
    }

    /// Takes the sample that is due at `t_s`. Returns its output, unless that is delayed.
    #[inline(always)]
    pub(super) fn sample(&mut self, t_s: f64, signals: &[L], sensors: &[Sensing<L>]) -> Option<L> {
        let sample_s = self.next_sample_s;
        let read = |reading: &mut Option<Reading<L>>| {
            reading.as_mut().map_or_else(L::zero, |reading| reading.read(t_s, signals, sensors))
        };
        let inputs = Inputs {
            reading: read(&mut self.reading),
            motion: read(&mut self.motion),
            motion_is_velocity: self.motion_is_velocity,
        };
        self.reference = match self.references.as_slice() {
            [shared] => L::splat(shared.value(sample_s)),
            own => L::from_fn(|l| own[l].value(sample_s)),
        };
        let output = self.controller.sample(sample_s, &inputs, self.reference);
        self.next_sample += 1;
        self.next_sample_s = self.clock.sample_time_s(self.next_sample);
        if self.delay_s > 0.0 {
            self.pending.push_back((sample_s + self.delay_s, output));
            return None;
        }
        Some(output)
    }

    /// Whether a sensor that it reads is delayed.
    pub(super) fn is_delayed(&self) -> bool {
        [&self.reading, &self.motion].into_iter().flatten().any(Reading::is_delayed)
    }

    /// Takes the signals that delayed readings will need.
    pub(super) fn take_delayed(&mut self, t_s: f64, signals: &[L]) {
        for reading in [&mut self.reading, &mut self.motion].into_iter().flatten() {
            reading.take(t_s, signals, |k| self.clock.sample_time_s(k));
        }
    }

    /// When the next signal for a delayed reading is due, s.
    #[inline(always)]
    pub(super) fn next_take_s(&self) -> f64 {
        let of = |reading: &Option<Reading<L>>| reading.as_ref().map_or(f64::INFINITY, Reading::next_s);
        of(&self.reading).min(of(&self.motion))
    }

    /// Whether a sample has been taken.
    pub(super) fn has_sampled(&self) -> bool {
        self.next_sample > 0
    }

    /// When the next output arrives.
    #[inline(always)]
    pub(super) fn next_arrival_s(&self) -> f64 {
        self.pending.front().map_or(f64::INFINITY, |(t, _)| *t)
    }
}
