//! Runs of a controller on some machines by the full simulation.

use std::collections::BTreeMap;

use feeler_control::ControllerSpec;
use feeler_engine::Scenario;
use rayon::prelude::*;
use serde::Serialize;

use super::knobs::installed;
use super::spec::{Spec, TuneLimit, TuneMeasure};
use crate::run::{LANES, Measured, Outcome, PreparedRun, RunError, measure, nothing_can_touch};

/// Figures of some runs, the worst of each.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Runs {
    /// Number of runs with each outcome.
    pub outcomes: BTreeMap<&'static str, usize>,
    /// Largest force of any contact, N.
    pub peak_force_n: f64,
    /// Farthest that a force passed its reference, impact included, as a share of it. `None` if no force has
    /// a reference that rests.
    pub overshoot: Option<f64>,
    /// Longest settling time, s; `None` if a run never settles, or nothing is to settle.
    pub settling_time_s: Option<f64>,
    /// Longest time until the force rests, on its reference or where friction keeps it, s; `None` if nothing
    /// is to settle.
    pub rest_time_s: Option<f64>,
    /// Half-width of the band in which the force counts as settled, N; `None` if nothing is to settle.
    pub band_n: Option<f64>,
}

/// Why a machine is not well controlled.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Trouble {
    /// The run does not end at rest.
    Ends(Outcome),
    Misses(TuneLimit<TuneMeasure>, Option<f64>),
    Fails(String),
    /// The trouble of another controller near this one, or on the way to it, with the name of that
    /// controller.
    Near(String, Box<Self>),
}

/// Figures of some runs, and the first machine with a trouble.
pub(super) type Ran = (Runs, Option<(usize, Trouble)>);

impl Runs {
    /// Runs one controller on several machines: the figures of the runs, and the first machine with a
    /// trouble.
    pub(super) fn of(machines: &[&Scenario], name: &str, spec: &ControllerSpec, asked: &Spec) -> Ran {
        let found = measured(machines, name, spec);
        let mut runs = Self::default();
        let mut trouble = None;
        let mut settles = true;
        for (i, (measured, scenario)) in found.into_iter().zip(machines).enumerate() {
            let of_this = match &measured {
                Ok(measured) => {
                    settles &= runs.take(measured);
                    troubles(measured, scenario, asked)
                }
                Err(error) => Some(Trouble::Fails(error.to_string())),
            };
            trouble = trouble.or(of_this.map(|trouble| (i, trouble)));
        }
        if !settles {
            runs.settling_time_s = None;
        }
        (runs, trouble)
    }

    /// Adds a run; returns whether it settled.
    fn take(&mut self, measured: &Measured) -> bool {
        let summary = &measured.summary;
        *self.outcomes.entry(summary.outcome.name()).or_default() += 1;
        self.peak_force_n = self.peak_force_n.max(summary.peak_force_n);
        let most = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::max);
        self.overshoot = most(self.overshoot, summary.overshoot);
        self.settling_time_s = most(self.settling_time_s, summary.settling_time_s);
        let rests = summary.settling_time_s.or(summary.response.and_then(|response| response.rest_time_s));
        self.rest_time_s = most(self.rest_time_s, rests);
        self.band_n = most(self.band_n, summary.response.map(|response| response.band_n));
        summary.settling_time_s.is_some()
    }
}

/// The trouble of a run, if any.
fn troubles(measured: &Measured, scenario: &Scenario, asked: &Spec) -> Option<Trouble> {
    let summary = &measured.summary;
    let rests_away = summary.outcome == Outcome::NoContact && nothing_can_touch(scenario);
    if !summary.outcome.is_stable() && !rests_away {
        return Some(Trouble::Ends(summary.outcome));
    }
    let value = |measure| match measure {
        TuneMeasure::Overshoot => summary.overshoot,
        TuneMeasure::PeakForce => Some(summary.peak_force_n),
        TuneMeasure::SettlingTime => summary.settling_time_s,
        _ => None,
    };
    // A force that never settles misses any limit on the time for it.
    let misses = |limit: &&TuneLimit<TuneMeasure>| match value(limit.of) {
        Some(value) => limit.missed_by(value) > 0.0,
        None => limit.of == TuneMeasure::SettlingTime,
    };
    let missed = asked.limits_of(false).find(misses)?;
    Some(Trouble::Misses(*missed, value(missed.of)))
}

/// Every machine run with a controller, side by side where their structure allows it.
fn measured(machines: &[&Scenario], name: &str, spec: &ControllerSpec) -> Vec<Result<Measured, RunError>> {
    let with = |scenario: &Scenario| {
        let mut scenario = scenario.clone();
        if let Some(used) = scenario.controllers.get_mut(name) {
            used.spec = installed(&used.spec, spec);
        }
        PreparedRun::new(scenario)
    };
    let blocks = machines.par_chunks(LANES).map(|block| {
        let mut prepared: Vec<Result<PreparedRun, RunError>> = block.iter().map(|one| with(one)).collect();
        let ready: Vec<PreparedRun> = prepared.iter().flatten().cloned().collect();
        let mut results = measure(&ready, 0).into_iter();
        let each = prepared.drain(..).filter_map(|candidate| match candidate {
            Ok(_) => results.next(),
            Err(error) => Some(Err(error)),
        });
        each.collect::<Vec<_>>()
    });
    blocks.flatten().collect()
}
