//! One controller of every lane, with its reference and its drive.

use feeler_control::{Controller, Reference};
use feeler_lanes::Lane;

use crate::error::EngineError;
use crate::run::program::Program;
use crate::sample::sampler::Sampler;
use crate::sample::sensing::Sensing;

/// The running controller of every lane.
#[derive(Debug)]
pub(crate) struct SampledController<L: Lane> {
    pub(super) name: String,
    pub(super) sampler: Sampler<L>,
    /// Output as applied.
    pub(super) output: L,
    /// The reference at the last sample.
    pub(super) reference: L,
    /// One reference for all lanes, or one per lane.
    references: Vec<Reference>,
    pub(super) drive: usize,
    /// Whether the command of the drive is its force.
    pub(super) drives_force: bool,
}

impl<L: Lane> SampledController<L> {
    pub(super) fn new(programs: &[Program], i: usize, sensors: &[Sensing<L>]) -> Result<Self, EngineError> {
        let (name, used) =
            programs[0].controllers.get_index(i).ok_or(EngineError::Lanes { given: 0, lanes: L::WIDTH })?;
        let specs: Vec<_> = programs.iter().map(|program| program.controllers[i].spec.clone()).collect();
        let controller =
            Controller::new(&specs).map_err(|source| EngineError::Control { name: name.clone(), source })?;
        let wiring = &programs[0].wiring[i];
        let is_shared = specs.iter().all(|spec| spec.reference == specs[0].reference);
        let kept = if is_shared { 1 } else { L::WIDTH };
        let tapped = [wiring.reading, wiring.motion];
        let (clock, is_velocity) = (wiring.clock.clone(), wiring.motion_is_velocity);
        let drive = &programs[0].motion.assembly().drives[wiring.drive];
        Ok(Self {
            name: name.clone(),
            sampler: Sampler::new(controller, clock, used.spec.delay_s, tapped, is_velocity, sensors),
            output: L::zero(),
            reference: L::zero(),
            references: programs[..kept].iter().map(|p| p.wiring[i].reference.clone()).collect(),
            drive: wiring.drive,
            drives_force: drive.commands_force(),
        })
    }

    /// Takes the sample that is due at `t_s`. Returns its output, unless that is delayed.
    #[inline(always)]
    pub(super) fn sample(&mut self, t_s: f64, signals: &[L], sensors: &[Sensing<L>]) -> Option<L> {
        let references = self.references.as_slice();
        let sampled = self.sampler.sample(t_s, signals, sensors, |sample_s, _| {
            let reference = match references {
                [shared] => L::splat(shared.value(sample_s)),
                own => L::from_fn(|l| own[l].value(sample_s)),
            };
            [reference, L::zero()]
        });
        self.reference = sampled.reference;
        self.sampler.send(sampled.sample_s, sampled.output)
    }
}
