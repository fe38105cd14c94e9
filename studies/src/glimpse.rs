//! A quick view of a scenario, for a page with adjustable numbers: one run and linear theory side by side,
//! without the slow parts.

use feeler_analysis::{AnalysisError, Curves, Report, Request, analyze, curves};
use feeler_control::ReferenceSpec;
use feeler_engine::Scenario;

use crate::ALL_PROCESSORS;
use crate::operating_point::contact_view;
use crate::run::{Candidate, Outcome, RunError, RunResult, measure, run_once};

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

/// The same scenario with a shorter run. If the beginning does not decide the outcome, [`outcomes`] extends it,
/// up to twice the whole.
#[must_use]
pub fn beginning(scenario: &Scenario) -> Scenario {
    let mut scenario = scenario.clone();
    let changes_s = scenario.controllers.values().map(|used| match &used.spec.reference {
        ReferenceSpec::Constant(_) => 0.0,
        ReferenceSpec::Steps(points) | ReferenceSpec::PiecewiseLinear(points) => {
            points.last().map_or(0.0, |(time_s, _)| *time_s)
        }
        // They move to the end.
        _ => f64::INFINITY,
    });
    let whole_s = scenario.run.duration_s;
    let changed_s = changes_s.fold(0.0, f64::max).min(whole_s);
    scenario.run.duration_s = changed_s + BEGINNING * (whole_s - changed_s);
    scenario
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

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_files::{Document, Setting};

    fn scenario(kp: f64) -> Scenario {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/chatter/sustained.toml");
        let document = Document::load(std::path::Path::new(path)).unwrap();
        document.with([("controllers.force.kp", Setting::Number(kp))]).unwrap().scenario
    }

    #[test]
    fn truth_a_beginning_has_every_change_of_a_reference() {
        let of = |reference| {
            let mut scenario = scenario(0.3);
            scenario.run.duration_s = 2.0;
            scenario.controllers[0].spec.reference = reference;
            beginning(&scenario).run.duration_s
        };
        assert_eq!(of(ReferenceSpec::Constant(20.0)), 2.0 * BEGINNING);
        assert_eq!(of(ReferenceSpec::Steps(vec![(0.0, 20.0), (1.0, 25.0)])), 1.0 + BEGINNING);
        assert_eq!(of(ReferenceSpec::Steps(vec![(0.0, 20.0), (3.0, 25.0)])), 2.0);
        let noise = ReferenceSpec::WhiteNoise { low_hz: 1.0, high_hz: 40.0, rms: 1.0, offset: 20.0 };
        assert_eq!(of(noise), 2.0);
    }

    /// The limit of the gain is 0.903, and the gains are clear of it.
    #[test]
    fn truth_beginnings_suggest_what_whole_runs_tell() {
        let gains = [0.2, 0.4, 0.6, 1.1, 1.4, 1.8];
        let whole = outcomes(gains.map(scenario).to_vec());
        assert_eq!(outcomes(gains.map(|kp| beginning(&scenario(kp))).to_vec()), whole);
        assert!(whole.contains(&Some(Outcome::Chatter)) && whole[0].is_some_and(Outcome::is_stable));
    }
}
