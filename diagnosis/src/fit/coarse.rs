//! Readings in coarser steps than the file states. They are read off the values themselves: noise that was
//! taken from the same readings hides them from every prediction.

use feeler_plant::assembly::Source;
use feeler_plant::description::ElementKind;

use crate::dataset::{Channel, Dataset};
use crate::fit::candidates::Candidate;
use crate::kinds::dossier;

/// A channel whose readings all lie on coarser steps than the file states. No motion and no noise does that.
#[derive(Clone, Debug)]
pub(crate) struct Coarse {
    channel: usize,
    sensor: usize,
    /// Evidence of one independent reading, nats: one in this many stated steps is a coarse one.
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

    /// Whether a set of causes has these steps.
    pub(crate) fn is_seen_by(&self, causes: &[Candidate]) -> bool {
        let tells = |cause: &Candidate| {
            cause.site.table == ElementKind::Sensors
                && cause.site.index == self.sensor
                && dossier(cause.definition.kind).read_off.is_some()
        };
        causes.iter().any(tells)
    }

    /// Evidence of an experiment with these independent readings per channel for a set of causes, nats.
    pub(crate) fn evidence(&self, causes: &[Candidate], looks: &[f64]) -> f64 {
        if self.is_seen_by(causes) { looks[self.channel] * self.nats } else { 0.0 }
    }
}
