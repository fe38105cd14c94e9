//! A table of the missing force, for answers without a cause: fitted on the fit records, and proposed if the
//! check records confirm it.

use feeler_plant::description::Machine;

use crate::adequacy::worsens;
use crate::budget::Stage;
use crate::fit::least_squares::Fitted;
use crate::fit::scored::Scored;
use crate::fit::tabled::{Tabled, tabled};
use crate::gap::replay::strays;
use crate::gap::size::{self, Floors};
use crate::gap::unknown::lacking;
use crate::judge::Judge;
use crate::report::{Diagnosis, ForceOver, Verdict};

/// Least share of the gap that a table must close on the check experiments.
const LEAST_CLOSED: f64 = 0.1;
/// The nearest causes stay beside a table only if at most this share of the misfit remains with them. A wrong
/// cause often compensates for the coarse knots of a table.
const NEEDED: f64 = 0.5;

impl Judge<'_> {
    /// Adds a table to an answer without a cause, if the check records confirm one. If the time is over, the
    /// answer says that the table was not tried. `accepted` holds the nearest causes.
    pub(crate) fn add_table(&self, answer: &mut Diagnosis, accepted: &Scored) {
        let task = &self.search.task;
        if answer.verdict != Verdict::UnknownCause {
            return;
        }
        let is_late = || task.budget.is_over(Stage::Compose);
        if is_late() {
            answer.adequacy.add_untried_table();
            return;
        }
        let calibrated = &self.search.calibrated;
        let is_told = answer.effects.iter().any(|effect| effect.accepted);
        let checks = self.checks();
        let alone = tabled(task, calibrated, &checks);
        let may_stay = is_told && answer.adequacy.may_be_meant(true);
        let is_cut = may_stay && is_late();
        let beside = (may_stay && !is_cut).then(|| tabled(task, accepted, &checks)).flatten();
        let best = match (alone, beside) {
            (Some(alone), Some(beside)) if beside.scored.fitted.cost < NEEDED * alone.scored.fitted.cost => {
                Some(beside)
            }
            (alone, beside) => alone.or(beside),
        };
        let told = if is_told { accepted } else { calibrated };
        let held = best.and_then(|best| Some((self.held(told, &best)?, best)));
        if let Some(((machine, table), best)) = held {
            (answer.machine, answer.table) = (machine, Some(table));
            if let Some(&r) = checks.first() {
                answer.inverse = lacking(task, calibrated, &best.scored, r);
            }
        } else if is_cut {
            answer.adequacy.add_untried_table();
        }
    }

    /// The machine with a table, and the share of the gap that the table closes. `None` if predictions of the
    /// check experiments do not improve, or if the free run of any experiment strays. Also `None` if a
    /// believed value is at the limit of its tolerance, because another error may be behind it.
    fn held(&self, told: &Scored, tabled: &Tabled) -> Option<(Machine, ForceOver)> {
        let (task, checks) = (&self.search.task, self.checks());
        let errors = |fitted: &Fitted| size::square_errors(task, &fitted.model, &fitted.theta, &checks);
        let Fitted { model, theta, .. } = &tabled.scored.fitted;
        let noise = size::noise(task, model, theta);
        let Floors { square, read } = Floors::of(task, model, theta, &noise, &checks);
        let (refit, after) = (errors(&told.fitted)?, errors(&tabled.scored.fitted)?);
        let closed = size::gap(&refit, &refit, &after, &square).closed;
        let machine = model.machine(theta);
        let holds = closed > LEAST_CLOSED
            && model.at_limits(theta).is_empty()
            && !worsens(task, told, &tabled.scored, &checks, read)
            && strays(self.dataset, &machine, &self.dataset.machine, task.budget).is_none()
            && !task.budget.is_over(Stage::RunFreely);
        let knots = tabled.table.points().to_vec();
        let on = tabled.site.key(&self.dataset.machine);
        holds.then_some((
            machine,
            ForceOver { kind: tabled.kind, on, over: tabled.over.name(), knots, closed },
        ))
    }
}
