//! Actions at instants: readings, control, arrivals of commands.

use feeler_arm::Arm;
use feeler_catalogue::Tabled;
use feeler_control::{Controller, Reference, SampleClock};
use feeler_engine::parts::{DriveChain, Sampler, Sensing, Tapped, due};
use feeler_engine::{ControllerUse, Program};
use nalgebra::DVector;

use crate::cell::Cell;
use crate::error::ManipulatorError;
use crate::hold::HoldControl;

/// Share of its limit from which a command of a drive counts as limited.
const AT_LIMIT: f64 = 1.0 - 1e-9;

/// The controller, and the position control of the other directions.
#[derive(Debug)]
pub(crate) struct Control {
    /// Sends the force along the normal and the torques of the joints.
    sampler: Sampler<f64, (f64, DVector<f64>)>,
    reference: Reference,
    period_s: f64,
    velocity_filter_s: f64,
    hold: HoldControl,
    last: Option<DVector<f64>>,
    speeds: DVector<f64>,
    /// The force along the normal as applied, and the reference at the last sample.
    pub(crate) output: f64,
    pub(crate) wanted: f64,
}

impl Control {
    pub(crate) fn new(
        cell: &Cell,
        program: &Program,
        sensors: &[Sensing<f64>],
    ) -> Result<Self, ManipulatorError> {
        let count = program.loops().count();
        let mut loops = program.loops();
        let (Some(wired), 1) = (loops.next(), count) else {
            return Err(ManipulatorError::Count { what: "controller", count });
        };
        let (spec, seed) = (wired.spec, program.settings().seed);
        let key = ControllerUse::place(wired.name);
        let clock = SampleClock::new(spec, seed, &key)?;
        let controller = Controller::new(std::slice::from_ref(spec))?;
        let tap = |sensor: Option<usize>| sensor.map(|i| Tapped { sensor: i, signal: i });
        let tapped = [tap(wired.reading), tap(wired.motion)];
        Ok(Self {
            sampler: Sampler::new(controller, clock, spec.delay_s, tapped, wired.motion_is_velocity, sensors),
            reference: Reference::new(&spec.reference, seed, &key)?,
            period_s: spec.period_s,
            velocity_filter_s: spec.velocity_filter_s,
            hold: HoldControl::new(&cell.arm, cell.hold, &cell.start.pose, cell.unit_normal()),
            last: None,
            speeds: DVector::zeros(cell.joints.len()),
            output: 0.0,
            wanted: 0.0,
        })
    }

    pub(crate) fn is_approaching(&self) -> bool {
        self.sampler.is_approaching(0)
    }

    pub(crate) fn next_s(&self) -> f64 {
        self.sampler.next_sample_s
    }

    /// Time of the next action: a sample, a reading for one, or the arrival of an output.
    pub(crate) fn next_instant_s(&self) -> f64 {
        self.next_s().min(self.sampler.next_arrival_s()).min(self.sampler.next_take_s())
    }

    /// Takes the signals that delayed readings will need.
    pub(crate) fn take(&mut self, t_s: f64, signals: &[f64]) {
        self.sampler.take_delayed(t_s, signals);
    }

    /// Takes the sample that is due; `motors` are the readings of the joints' encoders. Returns the torques,
    /// unless they are delayed.
    pub(crate) fn sample(
        &mut self,
        t_s: f64,
        arm: &Arm,
        [signals, motors]: [&[f64]; 2],
        sensors: &[Sensing<f64>],
    ) -> Option<DVector<f64>> {
        let reference = &self.reference;
        let asked = |sample_s: f64, _| [reference.value(sample_s), 0.0];
        let sampled = self.sampler.sample(t_s, signals, sensors, asked);
        self.wanted = sampled.reference;
        let now = DVector::from_column_slice(motors);
        if let Some(last) = &self.last {
            // Backward Euler form of a first-order filter on the differences.
            let tau = self.velocity_filter_s;
            self.speeds = (tau * &self.speeds + &now - last) / (tau + self.period_s);
        }
        self.last = Some(now);
        let torques = self.hold.torques(arm, motors, &self.speeds, sampled.output);
        let sent = self.sampler.send(sampled.sample_s, (sampled.output, torques));
        self.applied(sent)
    }

    /// The torques that arrive at `t_s`.
    pub(crate) fn arrive(&mut self, t_s: f64) -> Option<DVector<f64>> {
        let arrived = self.sampler.arrive(t_s);
        self.applied(arrived)
    }

    fn applied(&mut self, sent: Option<(f64, DVector<f64>)>) -> Option<DVector<f64>> {
        let (force_n, torques) = sent?;
        self.output = force_n;
        Some(torques)
    }
}

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
