//! The loop of a sampled servo, of every lane, with its target.

use feeler_control::Controller;
use feeler_lanes::Lane;
use feeler_plant::assembly::{Drive, TargetChain};

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
    /// Largest change of the followed target per sample, on the way to the present target.
    step: L,
    /// Processing of the target in every lane.
    chains: Vec<TargetChain>,
    period_s: f64,
    error_deadband: L,
    /// Inputs besides the target: index of the drive, force per unit, and the value that has arrived.
    fed: Vec<(usize, L, L)>,
}

impl<L: Lane> ServoLoop<L> {
    pub(super) fn new(programs: &[Program], i: usize, sensors: &[Sensing<L>]) -> Result<Self, EngineError> {
        let wired = &programs[0].servos[i];
        let specs: Vec<_> = programs.iter().map(|program| program.servos[i].spec.clone()).collect();
        let controller = Controller::new(&specs)
            .map_err(|source| EngineError::Control { name: wired.name.clone(), source })?;
        let number = |f: &dyn Fn(&Drive) -> f64| {
            L::from_fn(|l| f(&programs[l].motion.assembly().drives[programs[l].servos[i].drive]))
        };
        let start = L::from_fn(|l| programs[l].servos[i].start_m);
        let chain = |program: &Program| {
            let drive = &program.motion.assembly().drives[program.servos[i].drive];
            drive.sampling().map_or(TargetChain::NONE, |sampling| sampling.target)
        };
        let chains: Vec<TargetChain> = programs.iter().map(chain).collect();
        let period_s = wired.spec.period_s;
        let (clock, tapped) = (wired.clock.clone(), [Some(wired.encoder), None]);
        let fed = programs[0].motion.assembly().feeds_of(wired.drive).map(|(input, feed)| {
            let gain = number(&|drive| drive.servo.as_ref().map_or(0.0, |servo| feed.gain(servo)));
            (input, gain, L::zero())
        });
        Ok(Self {
            drive: wired.drive,
            sampler: Sampler::new(controller, clock, wired.spec.delay_s, tapped, false, sensors),
            target: start,
            followed: start,
            step: L::from_fn(|l| chains[l].rate_limit * period_s),
            period_s,
            error_deadband: L::from_fn(|l| chains[l].error_deadband),
            chains,
            fed: fed.collect(),
        })
    }

    /// Takes the command of drive `i` if it is the target or another input of this servo; returns whether it
    /// is.
    pub(super) fn takes(&mut self, i: usize, input: L) -> bool {
        if i == self.drive {
            self.step = L::from_fn(|l| {
                if input.lane(l).to_bits() == self.target.lane(l).to_bits() {
                    return self.step.lane(l);
                }
                self.chains[l].pace((input - self.followed).lane(l)) * self.period_s
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
        let Self { sampler, target, followed, step, error_deadband, fed, .. } = self;
        let sampled = sampler.sample(t_s, signals, sensors, |_, reading| {
            let reference = follow(followed, *target, reading, *step, *error_deadband);
            [reference, fed.iter().fold(L::zero(), |sum, (_, gain, input)| sum + *gain * *input)]
        });
        sampler.send(sampled.sample_s, sampled.output)
    }
}

/// The reference of a servo at a sample: its target, limited in rate to `step`. An error within `deadband`
/// counts as zero.
pub fn follow<L: Lane>(followed: &mut L, target: L, reading: L, step: L, deadband: L) -> L {
    *followed += (target - *followed).clamp_to(step);
    let error = *followed - reading;
    reading + (error - error.clamp_to(deadband))
}
