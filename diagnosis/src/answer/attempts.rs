//! Results of every set of causes that was tried.

use crate::fit::candidates::Candidate;
use crate::fit::odds::ACCEPT;
use crate::fit::scored::Scored;
use crate::judge::{Attempts, Judge};
use crate::report::{Attempt, AttemptOutcome};

impl Judge<'_> {
    /// All trials, the best first, with their results.
    pub(super) fn tried(&self, attempts: &Attempts, accepted: &Scored) -> Vec<Attempt> {
        let mut tried: Vec<Attempt> =
            attempts.fitted.iter().map(|scored| self.attempt(scored, accepted, attempts)).collect();
        tried.extend(attempts.screened.iter().map(|scored| {
            let attempt = self.attempt(scored, accepted, attempts);
            Attempt { why: attempt.why.of_few_steps(), ..attempt }
        }));
        tried.sort_by(|a, b| {
            b.gain_all.unwrap_or(f64::NEG_INFINITY).total_cmp(&a.gain_all.unwrap_or(f64::NEG_INFINITY))
        });
        let silent = |causes: &Vec<Candidate>| Attempt {
            causes: self.named(causes),
            gain_check: None,
            gain_all: None,
            gain_balance: None,
            why: AttemptOutcome::NotFitted,
        };
        tried.extend(attempts.silent.iter().map(silent));
        let late = |causes: &Vec<Candidate>| Attempt { why: AttemptOutcome::NotTried, ..silent(causes) };
        tried.extend(attempts.untried.iter().map(late));
        tried
    }

    fn attempt(&self, scored: &Scored, accepted: &Scored, attempts: &Attempts) -> Attempt {
        let (gain_check, gain_all) = (self.check(&self.search.calibrated, scored), self.all(scored));
        let best = self.all(accepted);
        let why = if scored.is_same(accepted) {
            AttemptOutcome::Accepted
        } else if attempts.unfinished.iter().any(|causes| scored.is_of(causes)) {
            AttemptOutcome::Unfinished
        } else if let Some(why) = self.no_departure(scored) {
            why
        } else if gain_check < ACCEPT {
            AttemptOutcome::TooLittle { gained_nats: gain_check, needed_nats: ACCEPT }
        } else if (best - gain_all).abs() < 1.0 {
            AttemptOutcome::AsMuch
        } else if gain_all < best {
            AttemptOutcome::Less { nats: best - gain_all }
        } else {
            AttemptOutcome::More { nats: gain_all - best }
        };
        Attempt {
            causes: self.named(&scored.causes),
            gain_check: Some(gain_check),
            gain_all: Some(gain_all),
            gain_balance: scored.balanced.as_ref().map(|balanced| balanced.nats),
            why,
        }
    }

    fn named(&self, causes: &[Candidate]) -> String {
        let name = |cause: &Candidate| {
            format!("{}@{}", cause.definition.kind, cause.site.key(&self.dataset.machine))
        };
        causes.iter().map(name).collect::<Vec<_>>().join("+")
    }
}
