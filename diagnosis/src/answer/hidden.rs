//! Causes that may be hidden although calibration alone explains the records.

use feeler_plant::description::ElementKind;
use feeler_problem::short;

use crate::adequacy::{Doubt, Doubted};
use crate::fit::candidates::{Candidate, candidates};
use crate::fit::odds::gain;
use crate::fit::scored::Scored;
use crate::fit::search::score;
use crate::judge::{Attempts, Judge};
use crate::kinds::{Behind, dossier};

/// Evidence at which odds are twenty to one, nats: 3.0 is the logarithm of 20.
const TWENTY_TO_ONE: f64 = 3.0;
/// Fit steps of the believed values beside a cause of a given size.
const STEPS: usize = 8;

impl Judge<'_> {
    /// The tried cause that explains more but could not be accepted, and causes that believed values may
    /// hide.
    pub(crate) fn hidden(&self, attempts: &Attempts) -> Vec<Doubt> {
        let nearly = self.nearly_found(attempts).map(|tried| tried.causes[0]);
        let all = candidates(&self.dataset.machine);
        let others = all.iter().filter(|cause| nearly.is_none_or(|nearly| !nearly.is(cause)));
        let behind = others.filter_map(|cause| self.behind_calibration(cause));
        nearly.map(|cause| doubt(&cause, explains_more(&cause.named()))).into_iter().chain(behind).collect()
    }

    /// The single cause with most evidence of those with odds of twenty to one that were not accepted.
    fn nearly_found<'t>(&self, attempts: &'t Attempts) -> Option<&'t Scored> {
        let tried = attempts.fitted.iter().chain(&attempts.screened).filter(|tried| tried.causes.len() == 1);
        let is_likely = |tried: &&Scored| {
            self.all(tried) > TWENTY_TO_ONE
                && self.check(&self.search.calibrated, tried) > 0.0
                && !self.is_acceptable(tried)
                && self.is_finding(tried)
                && self.is_meant(tried)
        };
        tried.filter(is_likely).max_by(|a, b| self.all(a).total_cmp(&self.all(b)))
    }

    /// A cause of the smallest size of note, if the machine with it predicts as well within the tolerances of
    /// its believed values. Only predictions count: a balance of forces fits a size of its own.
    fn behind_calibration(&self, cause: &Candidate) -> Option<Doubt> {
        let Self { dataset, search, .. } = self;
        let task = &search.task;
        let calibrated = &search.calibrated;
        let largest = self.largest_push(cause)?;
        let Behind { values, record } = (dossier(cause.definition.kind).behind_calibration)(largest)?;
        let believed = dataset.machine.element(cause.site).map_or(&[][..], |(_, element)| element.effects());
        if believed.iter().any(|effect| effect.definition.kind == cause.definition.kind) {
            return None;
        }
        let model = calibrated.fitted.model.with(cause.site, cause.definition, &values).held();
        let mut start = model.start();
        model.take_over(&mut start, &calibrated.fitted.model, &calibrated.fitted.theta, 0);
        let with = score(task, vec![*cause], task.fit(&model, &start, STEPS));
        let odds = gain(&task.weights, calibrated, &with, &self.everything());
        let size = cause.definition.parameters.first()?;
        let unit = self.unit_of(cause, size);
        let it = format!("{} with a {} of {} {unit}", cause.named(), size.name, short(*values.first()?));
        if odds > TWENTY_TO_ONE {
            return Some(doubt(cause, explains_more(&it)));
        }
        (odds > -TWENTY_TO_ONE).then(|| {
            let what = format!(
                "{it} would not show: believed values may take its place within their tolerances (record \
                 {record}, or state narrower tolerances)"
            );
            doubt(cause, what)
        })
    }

    /// The largest recorded command of the drive that has a cause, if the command is a force or makes one.
    fn largest_push(&self, cause: &Candidate) -> Option<f64> {
        let Self { dataset, .. } = self;
        let drive = (cause.site.table == ElementKind::Actuators).then_some(cause.site.index)?;
        let d = dataset.drives.iter().position(|driven| driven.drive == drive)?;
        let commands = dataset.records.iter().flat_map(|record| &record.commands[d]);
        let largest = commands.fold(0.0_f64, |most, command| most.max(command.abs()));
        (dataset.is_pushed(drive) && largest > 0.0).then_some(largest)
    }
}

fn explains_more(it: &str) -> String {
    format!("{it} would explain more, but the evidence is too little to accept it (record more of the same)")
}

fn doubt(cause: &Candidate, what: String) -> Doubt {
    Doubt { place: Some(cause.place), about: Doubted::Cause, what }
}
