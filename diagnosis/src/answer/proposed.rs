//! The machine that an answer proposes.

use feeler_plant::description::Machine;

use crate::adequacy::{Adequacy, Criteria};
use crate::budget::Stage;
use crate::fit::scored::Scored;
use crate::gap::replay::{free_run, strays};
use crate::judge::Judge;

impl Judge<'_> {
    /// The proposed machine: with the accepted causes, or only calibrated. It is the believed machine if that
    /// has the smaller error in free runs over the check experiments. If the answer is not sure, any
    /// experiment on which the change makes the free run stray is enough. If the causes are not proposed,
    /// `adequacy` gets the reason. Without the time for free runs, it is the believed machine.
    pub(super) fn proposed(&self, accepted: &Scored, adequacy: &mut Adequacy) -> Machine {
        let mut weighed = adequacy.clone();
        let machine = self.steadier(accepted, &mut weighed);
        if self.search.task.budget.is_over(Stage::RunFreely) {
            if !accepted.causes.is_empty() {
                adequacy.add_unrun();
            }
            return self.dataset.machine.clone();
        }
        *adequacy = weighed;
        machine
    }

    fn steadier(&self, accepted: &Scored, adequacy: &mut Adequacy) -> Machine {
        let of = |scored: &Scored, adequacy: &Adequacy| self.machine_of(scored, adequacy);
        let (repaired, believed) = (of(accepted, adequacy), &self.dataset.machine);
        // Calibration alone makes no claim that needs a reason.
        let is_promised = !accepted.causes.is_empty();
        // Once impacts have made a prediction lose the motion, the size of its error is chance.
        let is_chance = |error: f64| error > Criteria::default().lost && !believed.contacts.is_empty();
        let budget = self.search.task.budget;
        let given = free_run(self.dataset, believed, budget).filter(|given| !is_chance(*given));
        let Some(given) = given else {
            return if adequacy.may_be_meant(is_promised) { repaired } else { believed.clone() };
        };
        let is_better = |own: Option<f64>| own.is_some_and(|own| own <= given);
        let own = free_run(self.dataset, &repaired, budget);
        if is_promised && !is_better(own) {
            adequacy.add_free_run([own.unwrap_or(f64::INFINITY), given]);
        }
        let is_sure = !adequacy.is_short() && !adequacy.has_rival();
        if is_better(own) && (is_sure || adequacy.may_be_meant(is_promised)) {
            let stray = || strays(self.dataset, &repaired, believed, budget);
            let Some((r, errors)) = (!is_sure).then(stray).flatten() else { return repaired };
            if is_promised {
                adequacy.add_stray(&self.dataset.records[r].name, errors);
            }
        }
        let calibrated = of(&self.search.calibrated, adequacy);
        let may_be_calibrated = is_promised
            && adequacy.may_be_meant(false)
            && is_better(free_run(self.dataset, &calibrated, budget))
            && strays(self.dataset, &calibrated, believed, budget).is_none();
        if may_be_calibrated { calibrated } else { believed.clone() }
    }
}
