//! The loop of a sampled servo, of every lane, with its target.

use feeler_control::Controller;
use feeler_lanes::Lane;
use feeler_plant::assembly::Drive;

use crate::error::EngineError;
use crate::run::program::Program;
use crate::sample::sampler::Sampler;
use crate::sample::sensing::Sensing;

/// The running sampled servo of every lane.
#[derive(Debug)]
pub(crate) struct ServoLoop<L: Lane> {
    pub(super) drive: usize,
    pub(super) sampler: Sampler<L>,
    /// The target that has arrived.
    target: L,
    /// The rate-limited target, after the first sample.
    followed: L,
    /// Largest change of that target between samples.
    step: L,
    error_deadband: L,
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
        let (clock, tapped) = (wired.clock.clone(), [Some(wired.encoder), None]);
        Ok(Self {
            drive: wired.drive,
            sampler: Sampler::new(controller, clock, wired.spec.delay_s, tapped, false, sensors),
            target: start,
            followed: start,
            step: chain(|target| target.rate_limit) * L::splat(wired.spec.period_s),
            error_deadband: chain(|target| target.error_deadband),
        })
    }

    /// A target arrives.
    pub(super) fn aim(&mut self, target: L) {
        self.target = target;
    }

    /// Takes the sample that is due at `t_s`. Returns its output, unless that is delayed.
    pub(super) fn sample(&mut self, t_s: f64, signals: &[L], sensors: &[Sensing<L>]) -> Option<L> {
        let Self { sampler, target, followed, step, error_deadband, .. } = self;
        let sampled = sampler.sample(t_s, signals, sensors, |_, reading| {
            follow(followed, *target, reading, *step, *error_deadband)
        });
        sampler.send(sampled.sample_s, sampled.output)
    }
}

/// The reference of a servo at a sample: its target, limited in rate to `step`, less errors within
/// `deadband`.
pub fn follow<L: Lane>(followed: &mut L, target: L, reading: L, step: L, deadband: L) -> L {
    *followed += (target - *followed).clamp_to(step);
    let error = *followed - reading;
    reading + (error - error.clamp_to(deadband))
}
