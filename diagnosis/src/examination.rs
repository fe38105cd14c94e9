//! A diagnosis with the data that reports and repairs need.

use feeler_plant::description::Machine;
use rayon::prelude::*;

use crate::answer::difference::Difference;
use crate::budget::Budget;
use crate::dataset::Dataset;
use crate::diagnose::diagnose_within;
use crate::error::DiagnosisError;
use crate::gap::replay::{Replay, replay_within};
use crate::report::Diagnosis;

/// A diagnosed dataset: the answer, the change of the machine, and what both machines predict.
#[derive(Debug)]
pub struct Examination {
    /// The records, with the machine as it was believed.
    pub dataset: Dataset,
    pub diagnosis: Diagnosis,
    /// The changes to make in the believed machine.
    pub difference: Difference,
    /// Predictions of the check experiments: by the believed machine, and by the repaired one. If the time
    /// runs out, the rest are left out.
    pub replays: Vec<[Replay; 2]>,
}

impl Examination {
    /// Diagnoses, then predicts the check experiments with both machines, in parallel. `progress` receives
    /// the name of each stage.
    ///
    /// # Errors
    /// If the records cannot be used, or a machine has no motion.
    pub fn of(dataset: Dataset, progress: &dyn Fn(&str)) -> Result<Self, DiagnosisError> {
        Self::within(dataset, Budget::unlimited(), progress)
    }

    /// Examines with a diagnosis that ends within a time budget.
    ///
    /// # Errors
    /// As [`Examination::of`].
    pub fn within(dataset: Dataset, budget: Budget, progress: &dyn Fn(&str)) -> Result<Self, DiagnosisError> {
        let mut diagnosis = diagnose_within(&dataset, budget, progress)?;
        progress("predicting the check experiments");
        let checks: Vec<usize> =
            (0..dataset.records.len()).filter(|&r| dataset.records[r].is_check).collect();
        let both = |r: usize| {
            let of = |machine: &Machine| replay_within(machine, &dataset, r, budget).ok();
            Some([of(&dataset.machine)?, of(&diagnosis.machine)?])
        };
        let replays: Vec<[Replay; 2]> = checks.par_iter().filter_map(|&r| both(r)).collect();
        let missing = checks.len() - replays.len();
        if missing > 0 {
            let (all, what) = (checks.len(), "check experiments are not shown: the time ran out");
            diagnosis
                .warnings
                .push(format!("predictions of {missing} of {all} {what} (give a longer `--budget`)"));
        }
        let difference = Difference::between(&dataset.machine, &diagnosis.machine)
            .with_ends(&dataset.machine, &dataset.tolerance);
        Ok(Self { dataset, diagnosis, difference, replays })
    }

    /// Experiments that were set aside for scoring and never fitted.
    pub fn checks(&self) -> usize {
        self.dataset.records.iter().filter(|record| record.is_check).count()
    }
}
