//! Readings with coarser steps than the file states. The readings themselves show such steps. Predictions do
//! not, because the estimated noise includes the steps.

use feeler_plant::assembly::Source;
use feeler_plant::description::ElementKind;

use crate::dataset::{Channel, Dataset};
use crate::fit::candidates::Candidate;
use crate::kinds::dossier;

/// A channel whose readings are all multiples of a coarser step than the file states. Neither motion nor
/// noise causes this.
#[derive(Clone, Debug)]
pub(crate) struct Coarse {
    channel: usize,
    sensor: usize,
    /// Evidence of one independent reading, nats: the logarithm of the ratio of the coarse step to the stated
    /// one.
    nats: f64,
}

impl Coarse {
    pub(super) fn of(dataset: &Dataset) -> Vec<Self> {
        let coarse = |(channel, own): (usize, &Channel)| {
            let Source::Sensor(sensor) = own.source else { return None };
            let step = dataset.grain(channel);
            let is_contradicted = own.resolution > 0.0 && step > 0.0;
            is_contradicted.then(|| Self { channel, sensor, nats: (step / own.resolution).ln() })
        };
        dataset.channels.iter().enumerate().filter_map(coarse).collect()
    }

    /// Whether a set of causes explains these steps.
    pub(crate) fn is_seen_by(&self, causes: &[Candidate]) -> bool {
        let tells = |cause: &Candidate| {
            cause.site.table == ElementKind::Sensors
                && cause.site.index == self.sensor
                && dossier(cause.definition.kind).read_off.is_some()
        };
        causes.iter().any(tells)
    }

    /// Evidence of an experiment for a set of causes, nats. `looks` is the number of independent readings of
    /// each channel.
    pub(crate) fn evidence(&self, causes: &[Candidate], looks: &[f64]) -> f64 {
        if self.is_seen_by(causes) { looks[self.channel] * self.nats } else { 0.0 }
    }
}
