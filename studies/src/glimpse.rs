//! A quick view of a scenario, for a page with adjustable numbers: one run and linear theory side by side,
//! without the slow parts.

use feeler_analysis::{AnalysisError, Curves, Report, Request, analyze, curves};
use feeler_engine::Scenario;

use crate::ALL_PROCESSORS;
use crate::operating_point::contact_view;
use crate::run::{Candidate, Outcome, RunError, RunResult, measure, run_once};

/// A run and the theory beside it.
#[derive(Debug)]
pub struct Glimpse {
    /// The run over the file's duration, without energies.
    pub run: Result<RunResult, RunError>,
    /// Linear theory in contact and its curves, without the waterfall of the bandwidth.
    pub theory: Result<(Report, Curves), AnalysisError>,
}

impl Glimpse {
    /// Computes both, on two processors if available.
    pub fn of(scenario: &Scenario) -> Self {
        let (run, theory) = rayon::join(|| run_once(scenario), || theory(scenario));
        Self { run, theory }
    }
}

/// Linear theory in contact and its curves, without the waterfall of the bandwidth.
///
/// # Errors
/// As [`analyze`].
pub fn theory(scenario: &Scenario) -> Result<(Report, Curves), AnalysisError> {
    let (view, workers) = (contact_view(scenario), ALL_PROCESSORS);
    let request = Request { view, workers, brief: true, ..Request::default() };
    let report = analyze(scenario, &request)?;
    let curves = curves(scenario, &request, &report)?;
    Ok((report, curves))
}

/// Outcomes of some scenarios, side by side if their structure allows it; `None` for one that cannot run.
pub fn outcomes(scenarios: Vec<Scenario>) -> Vec<Option<Outcome>> {
    let prepared: Vec<Option<Candidate>> =
        scenarios.into_iter().map(|scenario| Candidate::new(scenario).ok()).collect();
    let candidates: Vec<Candidate> = prepared.iter().flatten().cloned().collect();
    let mut measured = measure(&candidates, 0).into_iter();
    let mut outcome = |_: &Candidate| measured.next().and_then(Result::ok).map(|found| found.summary.outcome);
    prepared.iter().map(|candidate| candidate.as_ref().and_then(&mut outcome)).collect()
}
