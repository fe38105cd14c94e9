//! Chooses gains, and a filter, lead or notch, for the largest bandwidth under limits.
//!
//! Linear theory proposes: a grid over the knobs, a finer one, and a pattern search. The full
//! simulation confirms, best proposal first, on every machine that the uncertainty allows. Where machines are
//! many, the search looks at a few of them, and at each that a proposal fails on from then on.

mod code;
mod draws;
mod equation;
mod error;
mod knobs;
mod order;
mod search;
mod simulated;
mod spec;
mod theory;

use std::sync::atomic::Ordering;

use feeler_control::{ControllerSpec, Law};
use feeler_engine::Scenario;
use feeler_files::{Document, Setting, assignment};
use indexmap::IndexMap;
use rayon::prelude::*;
use serde::Serialize;

pub use code::Code;
pub use draws::{Uncertain, machines};
pub use equation::{Equation, Linear};
pub use error::TuneError;
pub use order::Step;
pub use simulated::Runs;
pub use spec::{Limit, Measure, Part, Spec};
pub use theory::Figures;

use crate::run::ForceLoop;
use error::refused;
use knobs::Knobs;
use search::{FINEST, Point, Scored, Search};
use simulated::Trouble;
use theory::LinearPlant;

/// Proposals that are simulated beside each other.
const BESIDE: usize = 16;
/// What theory alone allows is worth a word from this many times the bandwidth found on.
const WORTH_TELLING: f64 = 1.01;
/// Machines that join the search after each proposal that fails on some.
const JOINING: usize = 4;

/// A tuned controller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tuned {
    /// The controller.
    pub controller: String,
    /// What was asked for.
    pub spec: Spec,
    /// On how many machines: the most probable one and those drawn.
    pub machines: usize,
    /// Linear theory of the file as it is, on the most probable machine; absent if the loop is unstable.
    pub before: Option<Figures>,
    /// The same as tuned.
    pub after: Figures,
    /// Smallest bandwidth over the machines as tuned, Hz.
    pub bandwidth_hz: f64,
    /// What the runs of all machines come to.
    pub runs: Runs,
    /// What `--set` takes to make the tuned file of the file.
    pub settings: Vec<String>,
    /// In which order to try the gains on the robot.
    pub steps: Vec<Step>,
    /// What the controller computes.
    pub equation: Equation,
    /// Loops looked at by linear theory, and controllers by simulation.
    pub evaluations: [usize; 2],
    /// Bandwidth that limits of theory alone would allow, Hz, where the simulation allows less.
    pub theory_alone_hz: Option<f64>,
}

/// Tunes a controller of a file on some machines, the most probable first ([`machines`]). `progress` gets
/// the name of what is under way.
///
/// # Errors
/// A specification that this controller cannot have or no gains meet, and the mistakes of the machine.
pub fn tune(
    document: &Document,
    spec: &Spec,
    machines: &[Scenario],
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Tuned, TuneError> {
    let scenario = &document.scenario;
    let name = controller(scenario, spec)?;
    let base = &scenario.controllers[name.as_str()].spec;
    let knobs = Knobs::new(scenario, base, spec)?;
    let at_work = knobs.all_at_work();
    let with_step = spec.limits.iter().any(|limit| limit.of == Measure::StepOvershoot);
    let plants = machines
        .iter()
        .map(|machine| LinearPlant::new(machine, &name, &at_work, with_step))
        .collect::<Result<Vec<_>, _>>()?;
    let before = plants[0].figures(base)?;
    let tuning = Tuning {
        spec,
        name: &name,
        machines,
        knobs: &knobs,
        search: Search::new(spec, &knobs, &plants),
        progress,
    };
    let found = tuning.best()?;
    let tuned = knobs.spec(&Search::sizes(&found.point));
    let all: Vec<&Scenario> = machines.iter().collect();
    progress("order of steps");
    let steps = order::steps(&all, &plants, &name, &tuned, spec, &|to| changes(&name, base, to));
    let settings = changes(&name, base, std::slice::from_ref(&tuned)).concat();
    let written = document.with(
        settings.iter().filter_map(|words| words.split_once('=')).map(|(key, value)| (key, setting(value))),
    )?;
    let equation = Equation::of(&written.scenario, &name)?
        .ok_or_else(|| refused("the tuned controller closes no loop", "name another by --spec"))?;
    let after = tuning.search.figures(&found.point, 0).ok_or_else(|| nothing_meets(spec, None))?;
    Ok(Tuned {
        controller: name.clone(),
        spec: spec.clone(),
        machines: machines.len(),
        before,
        after,
        bandwidth_hz: found.score,
        runs: found.runs,
        settings,
        steps,
        equation,
        evaluations: [tuning.search.evaluations.load(Ordering::Relaxed), found.simulated],
        theory_alone_hz: found.theory_alone_hz,
    })
}

/// The name of the controller that is tuned.
fn controller(scenario: &Scenario, spec: &Spec) -> Result<String, TuneError> {
    let known: Vec<&str> = scenario.controllers.keys().map(String::as_str).collect();
    let add = || refused("the file has no controller that closes a loop", "add one, as `feeler new` shows");
    if let Some(name) = &spec.controller {
        return if known.contains(&name.as_str()) {
            Ok(name.clone())
        } else {
            Err(refused(
                format!("--spec: there is no controller `{name}`"),
                format!("name one of {}", known.join(", ")),
            ))
        };
    }
    let of_force = ForceLoop::find(scenario).map(|found| found.name);
    let closing = scenario.controllers.iter().find(|(_, used)| !matches!(used.spec.law, Law::OpenLoop));
    of_force.or_else(|| closing.map(|(name, _)| name.clone())).ok_or_else(add)
}

/// What was found, confirmed on every machine.
struct Found {
    point: Point,
    score: f64,
    runs: Runs,
    simulated: usize,
    theory_alone_hz: Option<f64>,
}

struct Tuning<'a> {
    spec: &'a Spec,
    name: &'a str,
    machines: &'a [Scenario],
    knobs: &'a Knobs,
    search: Search<'a>,
    progress: &'a (dyn Fn(&str) + Sync),
}

impl Tuning<'_> {
    fn best(&self) -> Result<Found, TuneError> {
        let mut active = vec![0];
        let mut simulated = 0;
        loop {
            (self.progress)(&format!("linear theory, {} of {} machines", active.len(), self.machines.len()));
            let (ranked, step) = self.search.ranked(&active);
            let best = ranked.first().filter(|best| best.score > 0.0);
            let Some(best) = best else {
                let nearest = ranked.first().and_then(|near| {
                    let score = |i: &usize| self.search.score(&near.point, &[*i]);
                    let worst = active.iter().min_by(|a, b| score(a).total_cmp(&score(b)))?;
                    self.search.figures(&near.point, *worst)
                });
                return Err(nothing_meets(self.spec, nearest));
            };
            let theory_hz = best.score;
            (self.progress)("simulation");
            let found = self.confirmed(&ranked, step, &active, &mut simulated)?;
            let failing = self.failing(&found.point, &active, &mut simulated);
            match failing {
                Ok(runs) => {
                    let asks = self.spec.limits.iter().any(|limit| limit.of == Measure::Overshoot);
                    if asks && runs.overshoot.is_none() {
                        return Err(refused(
                            "--spec: there is no overshoot: no force has a reference above zero that rests",
                            "leave `overshoot` out, or limit `step overshoot`",
                        ));
                    }
                    let all: Vec<usize> = (0..self.machines.len()).collect();
                    let score = self.search.score(&found.point, &all);
                    let slower = |i: &usize| self.search.score(&found.point, &[*i]);
                    let slowest = all.into_iter().min_by(|a, b| slower(a).total_cmp(&slower(b)));
                    if let Some(slowest) = slowest
                        && found.score > score * WORTH_TELLING
                        && !active.contains(&slowest)
                    {
                        active.push(slowest);
                        continue;
                    }
                    let is_refused = ranked.first().is_none_or(|best| best.point != found.point);
                    let theory_alone_hz =
                        Some(theory_hz).filter(|theory| is_refused && *theory > score * WORTH_TELLING);
                    return Ok(Found { point: found.point, score, runs, simulated, theory_alone_hz });
                }
                Err(worst) => active.extend(worst),
            }
        }
    }

    /// The best of a ranking that the simulation confirms on the machines in use.
    fn confirmed(
        &self,
        ranked: &[Scored],
        step: f64,
        active: &[usize],
        simulated: &mut usize,
    ) -> Result<Scored, TuneError> {
        let meeting: Vec<&Scored> = ranked.iter().filter(|scored| scored.score > 0.0).collect();
        let mut first_trouble = None;
        // The best alone first: most often it passes.
        let (best, others) = meeting.split_at(1.min(meeting.len()));
        for some in std::iter::once(best).chain(others.chunks(BESIDE)) {
            *simulated += some.len();
            let troubles: Vec<Option<Trouble>> = (some.par_iter())
                .map(|scored| self.simulate(&scored.point, active).1.map(|(_, trouble)| trouble))
                .collect();
            let passed = some.iter().zip(&troubles).find(|(_, trouble)| trouble.is_none());
            if let Some((found, _)) = passed {
                if best.contains(found) {
                    return Ok((*found).clone());
                }
                let mut passes = |scored: &Scored| {
                    *simulated += 1;
                    self.simulate(&scored.point, active).1.is_none()
                };
                return Ok(self.search.climb((*found).clone(), step.max(FINEST), active, &mut passes));
            }
            first_trouble = first_trouble.or(troubles.into_iter().flatten().next());
        }
        Err(nothing_settles(first_trouble))
    }

    fn simulate(&self, point: &[f64], machines: &[usize]) -> (Runs, Option<(usize, Trouble)>) {
        let machines: Vec<&Scenario> = machines.iter().map(|&i| &self.machines[i]).collect();
        Runs::of(&machines, self.name, &self.knobs.spec(&Search::sizes(point)), self.spec)
    }

    /// What all runs come to, or machines not in use yet on which a point fails: those that miss limits of
    /// theory by most, else the first whose run does not pass.
    fn failing(&self, point: &[f64], active: &[usize], simulated: &mut usize) -> Result<Runs, Vec<usize>> {
        let others: Vec<usize> = (0..self.machines.len()).filter(|i| !active.contains(i)).collect();
        let mut missed: Vec<(usize, f64)> = others
            .par_iter()
            .map(|&i| (i, self.search.score(point, &[i])))
            .filter(|(_, score)| *score <= 0.0)
            .collect();
        missed.sort_by(|a, b| a.1.total_cmp(&b.1));
        if !missed.is_empty() {
            return Err(missed.into_iter().take(JOINING).map(|(i, _)| i).collect());
        }
        *simulated += 1;
        let all: Vec<usize> = (0..self.machines.len()).collect();
        match self.simulate(point, &all) {
            (runs, None) => Ok(runs),
            (_, Some((machine, _))) => Err(vec![machine]),
        }
    }
}

/// No gains meet the limits of theory.
fn nothing_meets(spec: &Spec, nearest: Option<Figures>) -> TuneError {
    let asked: Vec<&str> = spec.limits_of(true).map(|limit| limit.of.name()).collect();
    let near = nearest.map_or_else(
        || "every loop tried is unstable".to_owned(),
        |figures| {
            let gain_db =
                figures.gain_margin.map_or("no end of".into(), |m| format!("{:.1} dB", 20.0 * m.log10()));
            let phase = figures.phase_margin_deg.map_or("any".into(), |phase| format!("{phase:.1} deg"));
            format!("the nearest has a phase margin of {phase}, a gain margin of {gain_db}")
        },
    );
    refused(
        format!("no gains meet --spec ({}): {near}", asked.join(", ")),
        "lower a limit, free more gains as in gains = kp+damping, or add +lead, +filter or +notch",
    )
}

/// Gains meet the limits of theory, and no run does.
fn nothing_settles(trouble: Option<Trouble>) -> TuneError {
    match trouble {
        Some(Trouble::Misses(limit, value)) => refused(
            format!(
                "no gains meet --spec in simulation: the {} is {} where {} is allowed",
                limit.of.name(),
                value.map_or("none".into(), |value| format!("{value:.4}")),
                limit.bound
            ),
            "lower this limit, or slow the approach: an impact passes any reference",
        ),
        Some(Trouble::Ends(outcome)) => refused(
            format!(
                "no gains that theory allows come to rest in simulation: the best ends as {}",
                outcome.name()
            ),
            "see `feeler why FILE` for the cause and its remedy",
        ),
        Some(Trouble::Fails(why)) => refused(format!("no run succeeds: {why}"), "see `feeler run FILE`"),
        None => refused("no gains were tried", "widen the limits on gains"),
    }
}

/// The keys of a controller that tuning may change, with their values.
fn values(name: &str, spec: &ControllerSpec) -> IndexMap<String, f64> {
    let gains =
        spec.law.gains().into_iter().filter_map(|field| Some((field.key.name, field.number(&spec.law)?)));
    let lead = if let Law::ExplicitForce(gains) = &spec.law { gains.lead } else { None };
    let lead = lead.map(|lead| [("lead.zero", lead.zero_hz), ("lead.pole", lead.pole_hz)]);
    let low_pass = spec.reading_low_pass.map(|filter| {
        // A filter of first order is a plain number.
        (if filter.damping_ratio.is_some() { "low_pass.corner" } else { "low_pass" }, filter.cutoff_hz)
    });
    let notch = spec.reading_notch.map(|notch| ("notch.frequency", notch.frequency_hz));
    let all = gains.chain(lead.into_iter().flatten()).chain(low_pass).chain(notch);
    all.map(|(key, value)| (format!("controllers.{name}.{key}"), value)).collect()
}

/// What `--set` takes to make one controller of each of others: the keys that any of them changes.
fn changes(name: &str, from: &ControllerSpec, to: &[ControllerSpec]) -> Vec<Vec<String>> {
    let before = values(name, from);
    let after: Vec<IndexMap<String, f64>> = to.iter().map(|to| values(name, to)).collect();
    let changes = |key: &String| after.iter().any(|after| after.get(key) != before.get(key));
    let words = |after: &IndexMap<String, f64>| {
        let changed = after.iter().filter(|(key, _)| changes(key));
        changed.map(|(key, value)| assignment(key, &Setting::Number(*value))).collect()
    };
    after.iter().map(words).collect()
}

fn setting(value: &str) -> Setting {
    value.parse().map_or_else(|_| Setting::Text(value.into()), Setting::Number)
}
