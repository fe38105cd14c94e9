//! A quick view of a scenario, for a page with adjustable numbers: one run and linear theory side by side,
//! without the slow parts.

use feeler_analysis::{AnalysisError, Curves, Report, Request, analyze, curves};
use feeler_control::ReferenceSpec;
use feeler_engine::Scenario;

use crate::operating_point::contact_view;
use crate::run::{Outcome, PreparedRun, RunError, RunResult, measure_resting, run_once};
use crate::threads::ALL_PROCESSORS;

/// The part of a run, after the last change of its references, from which an outcome is guessed first.
const BEGINNING: f64 = 0.25;

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
        let (run, theory) = rayon::join(|| run_once(scenario), || theory(scenario, Loci::Drawn));
        Self { run, theory }
    }
}

/// Whether root loci are wanted, which take up to a third of the time of all theory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loci {
    /// With them.
    Drawn,
    /// Without them.
    Omitted,
}

/// Linear theory in contact and its curves, without the waterfall of the bandwidth.
///
/// # Errors
/// As [`analyze`].
pub fn theory(scenario: &Scenario, loci: Loci) -> Result<(Report, Curves), AnalysisError> {
    let (view, workers) = (contact_view(scenario), ALL_PROCESSORS);
    let without_loci = loci == Loci::Omitted;
    let request = Request { view, workers, brief: true, without_loci, ..Request::default() };
    let report = analyze(scenario, &request)?;
    let curves = curves(scenario, &request, &report)?;
    Ok((report, curves))
}

/// The same scenario with a shorter run. If the beginning does not decide the outcome, [`outcomes`] extends
/// it, up to twice the whole.
#[must_use]
pub fn beginning(scenario: &Scenario) -> Scenario {
    let mut scenario = scenario.clone();
    let changes_s = scenario.controllers.values().map(|used| match &used.spec.reference {
        ReferenceSpec::Constant(_) => 0.0,
        ReferenceSpec::Steps(points) | ReferenceSpec::PiecewiseLinear(points) => {
            points.last().map_or(0.0, |(time_s, _)| *time_s)
        }
        // All other references move to the end.
        _ => f64::INFINITY,
    });
    let whole_s = scenario.run.duration_s;
    let changed_s = changes_s.fold(0.0, f64::max).min(whole_s);
    scenario.run.duration_s = changed_s + BEGINNING * (whole_s - changed_s);
    scenario
}

/// Outcomes of some scenarios, side by side if their structure allows it; `None` for one that cannot run.
/// `rest` is called at each row of each run, and may let other work go first.
pub fn outcomes(scenarios: Vec<Scenario>, rest: &dyn Fn()) -> Vec<Option<Outcome>> {
    let prepared: Vec<Option<PreparedRun>> =
        scenarios.into_iter().map(|scenario| PreparedRun::new(scenario).ok()).collect();
    let candidates: Vec<PreparedRun> = prepared.iter().flatten().cloned().collect();
    let mut measured = measure_resting(&candidates, 0, rest).into_iter();
    let mut outcome =
        |_: &PreparedRun| measured.next().and_then(Result::ok).map(|found| found.summary.outcome);
    prepared.iter().map(|candidate| candidate.as_ref().and_then(&mut outcome)).collect()
}
