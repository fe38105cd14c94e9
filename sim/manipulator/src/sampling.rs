//! Actions at instants: readings, control, arrivals of commands.

use std::collections::VecDeque;

use feeler_arm::Arm;
use feeler_control::{Controller, Inputs, Reference, SampleClock};
use feeler_engine::Program;
use feeler_engine::parts::{DriveChain, Sensing, Tap, due};
use nalgebra::DVector;

use crate::cell::Cell;
use crate::error::ManipulatorError;
use crate::hold::HoldControl;

/// Share of its limit from which a command of a drive counts as limited.
const AT_LIMIT: f64 = 1.0 - 1e-9;

/// The controller, with its clock and its outputs in transit.
#[derive(Debug)]
pub(crate) struct Control {
    controller: Controller<f64>,
    clock: SampleClock,
    reference: Reference,
    next_sample: u64,
    pub(crate) next_s: f64,
    delay_s: f64,
    period_s: f64,
    velocity_filter_s: f64,
    /// Sensors that it reads, each with its tap.
    reading: Option<(usize, Tap<f64>)>,
    motion: Option<(usize, Tap<f64>)>,
    motion_is_velocity: bool,
    /// Force along the normal and joint torques in transit, with their arrival times.
    pending: VecDeque<(f64, f64, DVector<f64>)>,
    hold: HoldControl,
    last: Option<DVector<f64>>,
    speeds: DVector<f64>,
    /// The force along the normal as applied, and the reference at the last sample.
    pub(crate) output: f64,
    pub(crate) wanted: f64,
}

impl Control {
    pub(crate) fn new(cell: &Cell, program: &Program) -> Result<Self, ManipulatorError> {
        let count = program.loops().count();
        let mut loops = program.loops();
        let (Some(wired), 1) = (loops.next(), count) else {
            return Err(ManipulatorError::Count { what: "controller", count });
        };
        let (spec, seed) = (wired.spec, program.settings().seed);
        let key = format!("controllers.{}", wired.name);
        let clock = SampleClock::new(spec, seed, &key)?;
        let next_s = clock.sample_time_s(0);
        let sensors = &program.motion().assembly().sensors;
        let tap = |sensor: Option<usize>| sensor.map(|i| (i, Tap::new(i, sensors[i].delay, next_s)));
        let hold = HoldControl::new(&cell.arm, cell.hold, &cell.start.pose, cell.unit_normal());
        Ok(Self {
            controller: Controller::new(std::slice::from_ref(spec))?,
            reference: Reference::new(&spec.reference, seed, &key)?,
            next_sample: 0,
            next_s,
            delay_s: spec.delay_s,
            period_s: spec.period_s,
            velocity_filter_s: spec.velocity_filter_s,
            reading: tap(wired.reading),
            motion: tap(wired.motion),
            motion_is_velocity: wired.motion_is_velocity,
            pending: VecDeque::new(),
            hold,
            last: None,
            speeds: DVector::zeros(cell.joints.len()),
            output: 0.0,
            wanted: 0.0,
            clock,
        })
    }

    /// Whether it has sampled and is still in its approach.
    pub(crate) fn is_approaching(&self) -> bool {
        self.next_sample > 0 && !self.controller.in_contact_phase()
    }

    /// Time of the next action: a sample, a reading for one, or the arrival of an output.
    pub(crate) fn next_instant_s(&self) -> f64 {
        let taps = [&self.reading, &self.motion].into_iter().flatten().map(|(_, tap)| tap.next_s);
        let arrival = self.pending.front().map_or(f64::INFINITY, |(t, ..)| *t);
        taps.fold(self.next_s.min(arrival), f64::min)
    }

    /// Takes the signals of sensors whose readings are due.
    pub(crate) fn take(&mut self, t_s: f64, signals: &[f64]) {
        let clock = &self.clock;
        for (sensor, tap) in [&mut self.reading, &mut self.motion].into_iter().flatten() {
            tap.take(t_s, signals[*sensor], |k| clock.sample_time_s(k));
        }
    }

    /// Takes the sample that is due; `motors` are the readings of the joints' encoders.
    pub(crate) fn sample(&mut self, t_s: f64, arm: &Arm, sensors: &[Sensing<f64>], motors: &[f64]) {
        let sample_s = self.next_s;
        let read = |tapped: &mut Option<(usize, Tap<f64>)>| {
            tapped.as_mut().map_or(0.0, |(i, tap)| sensors[*i].read(t_s, tap.pop()))
        };
        let reading = read(&mut self.reading);
        let motion = read(&mut self.motion);
        self.wanted = self.reference.value(sample_s);
        let inputs = Inputs { reading, motion, motion_is_velocity: self.motion_is_velocity };
        let force_n = self.controller.sample(sample_s, &inputs, self.wanted);
        let now = DVector::from_column_slice(motors);
        if let Some(last) = &self.last {
            // Backward Euler form of a first-order filter on the differences.
            let tau = self.velocity_filter_s;
            self.speeds = (tau * &self.speeds + &now - last) / (tau + self.period_s);
        }
        self.last = Some(now);
        let torques = self.hold.torques(arm, motors, &self.speeds, force_n);
        self.pending.push_back((sample_s + self.delay_s, force_n, torques));
        self.next_sample += 1;
        self.next_s = self.clock.sample_time_s(self.next_sample);
    }

    /// The next output that is due.
    pub(crate) fn arrive(&mut self, t_s: f64) -> Option<DVector<f64>> {
        if !self.pending.front().is_some_and(|(at, ..)| due(*at, t_s)) {
            return None;
        }
        let (_, force_n, torques) = self.pending.pop_front()?;
        self.output = force_n;
        Some(torques)
    }
}

/// The drives of all joints.
#[derive(Clone, Debug)]
pub(crate) struct Drives {
    chains: Vec<DriveChain<f64>>,
    /// Commands at the limits.
    limits: Vec<f64>,
}

impl Drives {
    pub(crate) fn new(cell: &Cell, seed: u64) -> Self {
        let drives = || cell.joints.iter().map(|joint| &joint.drive);
        Self {
            chains: drives().map(|drive| DriveChain::new(&[drive], seed)).collect(),
            limits: drives().map(|drive| drive.limit / drive.gain.abs()).collect(),
        }
    }

    /// Takes new commands; those without delay go into `inputs`.
    pub(crate) fn issue(&mut self, t_s: f64, torques: &DVector<f64>, inputs: &mut [f64]) {
        for ((chain, torque), input) in self.chains.iter_mut().zip(torques).zip(inputs) {
            if let Some(acting) = chain.issue(t_s, *torque) {
                *input = acting;
            }
        }
    }

    /// Takes the delayed commands that are due.
    pub(crate) fn arrivals(&mut self, t_s: f64, inputs: &mut [f64]) {
        for (chain, input) in self.chains.iter_mut().zip(inputs) {
            while due(chain.next_arrival_s(), t_s) {
                let Some(acting) = chain.arrive() else { break };
                *input = acting;
            }
        }
    }

    pub(crate) fn next_instant_s(&self) -> f64 {
        self.chains.iter().map(DriveChain::next_arrival_s).fold(f64::INFINITY, f64::min)
    }

    /// Whether some command exceeds its limit.
    pub(crate) fn limited(&self) -> bool {
        self.chains.iter().zip(&self.limits).any(|(chain, limit)| chain.command.abs() >= limit * AT_LIMIT)
    }
}
