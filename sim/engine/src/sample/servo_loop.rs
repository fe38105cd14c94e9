//! The loop of a sampled servo, of every lane: its target, its samples and its outputs in transit.

use std::collections::VecDeque;

use feeler_control::{Controller, Inputs, SampleClock};
use feeler_lanes::Lane;
use feeler_plant::assembly::Drive;

use crate::error::EngineError;
use crate::run::program::Program;
use crate::sample::reading::Reading;
use crate::sample::sensing::Sensing;

/// The running sampled servo of every lane.
#[derive(Debug)]
pub(crate) struct ServoLoop<L: Lane> {
    pub(super) drive: usize,
    controller: Controller<L>,
    clock: SampleClock,
    next_sample: u64,
    pub(super) next_sample_s: f64,
    pub(super) delay_s: f64,
    /// Outputs in transit: arrival time and value.
    pub(super) pending: VecDeque<(f64, L)>,
    encoder: Reading<L>,
    /// The target that has arrived.
    target: L,
    /// The rate-limited target, after the first sample.
    followed: L,
    /// Largest change of that target between samples, in general and on the present way.
    step: L,
    pace: L,
    /// Number of samples on the way from one target to the next; zero without interpolation.
    samples_apart: L,
    error_deadband: L,
    /// Its inputs besides the target: their drives, force per unit, and what has arrived.
    fed: Vec<(usize, L, L)>,
}

impl<L: Lane> ServoLoop<L> {
    /// Servo `i` of all programs.
    pub(super) fn new(programs: &[Program], i: usize, sensors: &[Sensing<L>]) -> Result<Self, EngineError> {
        let wired = &programs[0].servos[i];
        let specs: Vec<_> = programs.iter().map(|program| program.servos[i].spec.clone()).collect();
        let controller = Controller::new(&specs)
            .map_err(|source| EngineError::Control { name: wired.name.clone(), source })?;
        let number = |f: &dyn Fn(&Drive) -> f64| {
            L::from_fn(|l| f(&programs[l].motion.assembly().drives[programs[l].servos[i].drive]))
        };
        let start = L::from_fn(|l| programs[l].servos[i].start_m);
        let chain = |f: fn(&feeler_plant::assembly::TargetChain) -> f64| {
            number(&|drive| drive.sampling().map_or(0.0, |sampling| f(&sampling.target)))
        };
        let inputs = programs[0].motion.assembly().drives.iter().enumerate();
        let fed = inputs.filter_map(|(input, drive)| {
            let feed = drive.feeds.filter(|feed| feed.servo == wired.drive)?;
            let gain = number(&|drive| drive.servo.as_ref().map_or(0.0, |servo| feed.gain(servo)));
            Some((input, gain, L::zero()))
        });
        let next_sample_s = wired.clock.sample_time_s(0);
        let step = chain(|target| target.rate_limit) * L::splat(wired.spec.period_s);
        let interval = chain(|target| target.interval);
        Ok(Self {
            drive: wired.drive,
            controller,
            clock: wired.clock.clone(),
            next_sample: 0,
            next_sample_s,
            delay_s: wired.spec.delay_s,
            pending: VecDeque::new(),
            encoder: Reading::new(wired.encoder, sensors, next_sample_s),
            target: start,
            followed: start,
            step,
            pace: step,
            samples_apart: L::from_fn(|l| interval.lane(l) / wired.spec.period_s),
            error_deadband: chain(|target| target.error_deadband),
            fed: fed.collect(),
        })
    }

    /// Takes the command of drive `i` if it is the target or another input of this servo; returns whether it
    /// is.
    pub(super) fn takes(&mut self, i: usize, input: L) -> bool {
        if i == self.drive {
            self.pace = L::from_fn(|l| {
                let [apart, step, before] = [self.samples_apart, self.step, self.pace].map(|of| of.lane(l));
                if input.lane(l).to_bits() == self.target.lane(l).to_bits() {
                    return before;
                }
                let left = (input - self.followed).lane(l).abs();
                if apart > 0.0 { (left / apart).min(step) } else { step }
            });
            self.target = input;
            return true;
        }
        let Some((.., fed)) = self.fed.iter_mut().find(|(drive, ..)| *drive == i) else { return false };
        *fed = input;
        true
    }

    /// Takes the sample that is due at `t_s`. Returns its output, unless that is delayed.
    pub(super) fn sample(&mut self, t_s: f64, signals: &[L], sensors: &[Sensing<L>]) -> Option<L> {
        let sample_s = self.next_sample_s;
        let reading = self.encoder.read(t_s, signals, sensors);
        self.followed += (self.target - self.followed).clamp_to(self.pace);
        let error = self.followed - reading;
        let reference = reading + (error - error.clamp_to(self.error_deadband));
        let inputs = Inputs { reading, motion: L::zero(), motion_is_velocity: false };
        let fed = self.fed.iter().fold(L::zero(), |sum, (_, gain, input)| sum + *gain * *input);
        let output = self.controller.sample_fed(sample_s, &inputs, reference, fed);
        self.next_sample += 1;
        self.next_sample_s = self.clock.sample_time_s(self.next_sample);
        if self.delay_s > 0.0 {
            self.pending.push_back((sample_s + self.delay_s, output));
            return None;
        }
        Some(output)
    }

    /// When the next output arrives.
    pub(super) fn next_arrival_s(&self) -> f64 {
        self.pending.front().map_or(f64::INFINITY, |(t, _)| *t)
    }
}
