//! Causes that may be hidden although calibration alone explains the records.

use crate::adequacy::{Doubt, Doubted};
use crate::budget::Stage;
use crate::fit::candidates::{Candidate, candidates};
use crate::fit::glance::glance;
use crate::fit::odds::{PER_UNKNOWN, gain};
use crate::fit::search::score;
use crate::judge::{Attempts, Judge};
use crate::kinds::{Glance, dossier};

/// Evidence at which odds are twenty to one, nats: 3.0 is the logarithm of 20.
const TWENTY_TO_ONE: f64 = 3.0;
/// Fit steps of the believed values beside a cause of a given size.
const STEPS: usize = 8;

impl Judge<'_> {
    /// The cause that explains more but could not be accepted, and causes that believed values may hide.
    /// They are reasons not to call calibration the whole truth.
    pub(super) fn hidden(&self, attempts: &Attempts) -> Vec<Doubt> {
        let glance = glance(&self.search.task, &self.search.calibrated);
        let behind = candidates(&self.dataset.machine);
        let behind = behind.iter().filter_map(|cause| self.behind_calibration(cause, &glance));
        self.nearly_found(attempts).into_iter().chain(behind).collect()
    }

    /// The single cause with most evidence, if it has odds of twenty to one.
    fn nearly_found(&self, attempts: &Attempts) -> Option<Doubt> {
        let tried = attempts.fitted.iter().chain(&attempts.screened).filter(|tried| tried.causes.len() == 1);
        let likely = tried.filter(|tried| {
            self.all(tried) > TWENTY_TO_ONE && self.is_finding(tried) && self.is_meant(tried)
        });
        let best = likely.max_by(|a, b| self.all(a).total_cmp(&self.all(b)))?;
        let what = format!(
            "{} would explain more, but the evidence is too little to accept it (record more of the same)",
            named(&best.causes[0])
        );
        Some(Doubt { place: Some(best.causes[0].place), about: Doubted::Cause, what })
    }

    /// A cause of the smallest size of note, if the machine with it predicts as well within the tolerances of
    /// its believed values.
    fn behind_calibration(&self, cause: &Candidate, glance: &Glance) -> Option<Doubt> {
        let Self { dataset, search, .. } = self;
        let calibrated = &search.calibrated;
        let (values, record) = (dossier(cause.definition.kind).behind_calibration)(glance)?;
        let believed = dataset.machine.element(cause.site).map_or(&[][..], |(_, element)| element.effects());
        let is_believed = believed.iter().any(|effect| effect.definition.kind == cause.definition.kind);
        if is_believed || search.task.budget.is_over(Stage::Compose) {
            return None;
        }
        let model = calibrated.fitted.model.with(cause.site, cause.definition, &values).held();
        let mut start = model.start();
        model.take_over(&mut start, &calibrated.fitted.model, &calibrated.fitted.theta, 0);
        let with = score(&search.task, vec![*cause], search.task.fit(&model, &start, STEPS));
        let odds = gain(&search.task.weights, calibrated, &with, &self.everything()) + PER_UNKNOWN;
        let size = cause.definition.parameters.first()?;
        if odds < -TWENTY_TO_ONE {
            return None;
        }
        Some(Doubt {
            place: Some(cause.place),
            about: Doubted::Cause,
            what: format!(
                "{} with a {} of {:.3} {} would not show: believed values may take its place within their \
                 tolerances (record {record}, or state narrower tolerances)",
                named(cause),
                size.name,
                values.first()?,
                self.unit_of(cause, size)
            ),
        })
    }
}

fn named(cause: &Candidate) -> String {
    format!("{} at the {}", cause.definition.kind, cause.place.name())
}
