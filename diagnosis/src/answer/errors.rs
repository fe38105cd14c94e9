//! Prediction errors of an answer, and their sizes against noise.

use crate::adequacy::Sizes;
use crate::fit::least_squares::Fitted;
use crate::fit::model::Model;
use crate::fit::scored::Scored;
use crate::gap::ladder::noise_force;
use crate::gap::size::{self, Floors};
use crate::judge::Judge;
use crate::report::Gap;

/// An error above this many noise floors is an error of the model.
pub(super) const ROUGH: f64 = 2.0;

/// Prediction errors over the check experiments.
pub(super) struct Errors {
    pub(super) refit: Vec<f64>,
    pub(super) after: Vec<f64>,
    /// One sigma of every channel.
    pub(super) noise: Vec<f64>,
    /// Error of short predictions that the noise of all channels leaves, over the scale.
    pub(super) read: f64,
    pub(super) gap: Gap,
}

impl Judge<'_> {
    /// Share of the gap that accepted causes close.
    pub(crate) fn closed(&self, accepted: &Scored) -> f64 {
        self.errors(accepted).gap.closed
    }

    /// Errors of short predictions after calibration and with the accepted causes, and their floors.
    pub(super) fn errors(&self, accepted: &Scored) -> Errors {
        let (task, checks) = (&self.search.task, self.checks());
        let calibrated = &self.search.calibrated.fitted;
        let errors = |model: &Model, theta: &[f64]| size::square_errors(task, model, theta, &checks);
        let refit = errors(&calibrated.model, &calibrated.theta);
        let refit = refit.unwrap_or_else(|| vec![f64::INFINITY; checks.len()]);
        let before = errors(&calibrated.model, &calibrated.model.start()).unwrap_or_else(|| refit.clone());
        let Fitted { model, theta, .. } = &accepted.fitted;
        let after = errors(model, theta).unwrap_or_else(|| refit.clone());
        let noise = size::noise(task, model, theta);
        let Floors { square, read } = Floors::of(task, model, theta, &noise, &checks);
        let gap = size::gap(&before, &refit, &after, &square);
        Errors { refit, after, noise, read, gap }
    }

    /// Errors that the conditions use. `missing_force_n` is the force missing after calibration and with the
    /// accepted causes, `read` the floor due to the channels.
    pub(super) fn sizes(&self, accepted: &Scored, missing_force_n: [f64; 2], gap: &Gap, read: f64) -> Sizes {
        let noise_n = noise_force(&self.search.task, accepted, &self.checks());
        let beyond = |force: f64| (force * force - noise_n * noise_n).max(0.0).sqrt();
        Sizes {
            floor: read,
            closed: (gap.after > ROUGH * gap.floor).then_some(gap.closed),
            most_closed: (gap.refit > ROUGH * gap.floor).then_some(gap.closed_ci90[1]),
            missing_force_n: missing_force_n.map(beyond),
        }
    }
}
