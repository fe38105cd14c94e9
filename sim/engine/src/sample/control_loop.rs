//! One controller of every lane, with its clock and what is under way.

use std::collections::VecDeque;

use feeler_control::{Controller, Inputs};
use feeler_lanes::Lane;

use crate::error::EngineError;
use crate::run::program::{Program, Tapped};

/// A controller of every lane at work.
#[derive(Debug)]
pub(crate) struct ControlLoop<L: Lane> {
    pub(crate) controller: Controller<L>,
    next_sample: u64,
    pub(crate) next_sample_s: f64,
    pub(crate) delay_s: f64,
    /// Outputs under way: when they arrive, and what they are.
    pub(crate) pending: VecDeque<(f64, L)>,
    /// Output as applied.
    pub(crate) output: L,
    /// The reference at the last sample.
    pub(crate) reference: L,
    /// Whether all lanes follow the same reference, which is then asked for once.
    reference_is_shared: bool,
    pub(crate) drive: usize,
    motion_is_velocity: bool,
    /// The sensor it controls, and its tap where that is delayed.
    pub(crate) reading: Option<(Tapped, Option<usize>)>,
    /// The sensor of position or velocity, likewise.
    pub(crate) motion: Option<(Tapped, Option<usize>)>,
}

impl<L: Lane> ControlLoop<L> {
    /// Controller `i` of all programs. `tap(sensor, first sample)` makes a tap where one is needed.
    pub(crate) fn new(
        programs: &[Program],
        i: usize,
        mut tap: impl FnMut(Tapped, f64) -> Option<usize>,
    ) -> Result<Self, EngineError> {
        let (name, used) =
            programs[0].controllers.get_index(i).ok_or(EngineError::Lanes { given: 0, lanes: L::WIDTH })?;
        let specs: Vec<_> = programs.iter().map(|program| program.controllers[i].spec.clone()).collect();
        let controller =
            Controller::new(&specs).map_err(|source| EngineError::Control { name: name.clone(), source })?;
        let wiring = &programs[0].wiring[i];
        let next_sample_s = wiring.clock.sample_time_s(0);
        Ok(Self {
            controller,
            next_sample: 0,
            next_sample_s,
            delay_s: used.spec.delay_s,
            pending: VecDeque::new(),
            output: L::zero(),
            reference: L::zero(),
            reference_is_shared: specs.iter().all(|spec| spec.reference == specs[0].reference),
            drive: wiring.drive,
            motion_is_velocity: wiring.motion_is_velocity,
            reading: wiring.reading.map(|t| (t, tap(t, next_sample_s))),
            motion: wiring.motion.map(|t| (t, tap(t, next_sample_s))),
        })
    }

    /// Takes the sample that is due: its instant, and the output that follows from it after the delay.
    #[inline(always)]
    pub(crate) fn sample(
        &mut self,
        i: usize,
        programs: &[Program],
        reading: Option<L>,
        motion: Option<L>,
    ) -> (f64, L) {
        let sample_s = self.next_sample_s;
        self.reference = if self.reference_is_shared {
            L::splat(programs[0].wiring[i].reference.value(sample_s))
        } else {
            L::from_fn(|l| programs[l].wiring[i].reference.value(sample_s))
        };
        let inputs = Inputs {
            reading: reading.unwrap_or_else(L::zero),
            motion: motion.unwrap_or_else(L::zero),
            motion_is_velocity: self.motion_is_velocity,
        };
        let output = self.controller.sample(sample_s, &inputs, self.reference);
        self.next_sample += 1;
        self.next_sample_s = programs[0].wiring[i].clock.sample_time_s(self.next_sample);
        (sample_s, output)
    }

    /// Whether a sample has been taken.
    pub(crate) fn has_sampled(&self) -> bool {
        self.next_sample > 0
    }

    /// When the next output arrives.
    #[inline(always)]
    pub(crate) fn next_arrival_s(&self) -> f64 {
        self.pending.front().map_or(f64::INFINITY, |(t, _)| *t)
    }
}
