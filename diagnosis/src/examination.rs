//! A diagnosis with the data that reports and repairs need.

use rayon::prelude::*;

use crate::answer::difference::Difference;
use crate::budget::Budget;
use crate::dataset::Dataset;
use crate::diagnose::diagnose_within;
use crate::error::DiagnosisError;
use crate::gap::replay::{Replay, replay_record};
use crate::report::Diagnosis;

/// A diagnosed dataset: the answer, the change of the machine, and what both machines predict.
#[derive(Debug)]
pub struct Examination {
    /// The records, with the machine as it was believed.
    pub dataset: Dataset,
    pub diagnosis: Diagnosis,
    /// The changes to make in the believed machine.
    pub difference: Difference,
    /// Predictions of each check experiment: by the believed machine, and by the repaired one.
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
        let diagnosis = diagnose_within(&dataset, budget, progress)?;
        progress("predicting the check experiments");
        let checks: Vec<usize> =
            (0..dataset.records.len()).filter(|&r| dataset.records[r].is_check).collect();
        let replays = checks
            .into_par_iter()
            .map(|r| {
                Ok([
                    replay_record(&dataset.machine, &dataset, r)?,
                    replay_record(&diagnosis.machine, &dataset, r)?,
                ])
            })
            .collect::<Result<_, DiagnosisError>>()?;
        let difference = Difference::between(&dataset.machine, &diagnosis.machine)
            .with_ends(&dataset.machine, &dataset.tolerance);
        Ok(Self { dataset, diagnosis, difference, replays })
    }

    /// Experiments that were set aside for scoring and never fitted.
    pub fn checks(&self) -> usize {
        self.dataset.records.iter().filter(|record| record.is_check).count()
    }
}
