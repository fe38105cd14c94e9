//! Chooses gains, and a filter, lead or notch, for the largest bandwidth under limits.
//!
//! Linear theory proposes points: a grid over the knobs, a finer one, and a pattern search. The full
//! simulation confirms them, the best first, on every machine that the uncertainty allows. A confirmed point
//! comes to rest, and so do its neighbours and every share of its gains on the way to it. With many machines
//! the search uses a few of them, and then adds each one on which a proposal fails.

mod code;
mod draws;
mod equation;
mod error;
mod further;
mod knobs;
mod neighbours;
mod nothing;
mod order;
mod search;
mod simulated;
mod spec;
mod theory;

use std::sync::atomic::{AtomicUsize, Ordering};

use feeler_analysis::gain;
use feeler_catalogue::{Content, Field, KeyKind, Keyed, Slot, Tabled};
use feeler_control::{ControllerSpec, Law};
use feeler_engine::Scenario;
use feeler_files::{Document, Setting, assignment};
use feeler_plant::description::ActuatorKind;
use indexmap::IndexMap;
use rayon::prelude::*;
use serde::Serialize;

pub use code::Code;
pub use draws::{Uncertain, machines};
pub use equation::{Equation, Linear};
pub use error::TuneError;
pub use further::further;
pub use order::Step;
pub use simulated::Runs;
pub use spec::{Spec, TuneLimit, TuneMeasure, TunedPart};
pub use theory::Figures;

use crate::run::{ForceLoop, Outcome};
use error::refused;
use knobs::Knobs;
use neighbours::neighbours;
use nothing::{nothing_meets, nothing_settles};
use search::{FINEST, Point, Scored, TuneSearch};
use simulated::{Ran, Trouble};
use theory::LinearPlant;

/// Proposals that are simulated beside each other.
const BESIDE: usize = 16;
/// The bandwidth that theory alone allows is reported from this multiple of the bandwidth found.
const WORTH_TELLING: f64 = 1.01;
/// Machines that join the search after each proposal that fails on some.
const JOINING: usize = 4;

/// A tuned controller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tuned {
    /// Name of the controller that is tuned.
    pub controller: String,
    /// The specification that was asked for.
    pub spec: Spec,
    /// Number of machines: the most probable one and those drawn.
    pub machines: usize,
    /// Linear theory of the file as it is, on the most probable machine; `None` if the loop
    /// is unstable.
    pub before: Option<Figures>,
    /// Linear theory of the tuned file on the same machine.
    pub after: Figures,
    /// Smallest bandwidth over the machines as tuned, Hz.
    pub bandwidth_hz: f64,
    /// Outcomes of the runs of all machines.
    pub runs: Runs,
    /// Values for `--set` that turn the file into the tuned one.
    pub settings: Vec<String>,
    /// Order in which to try the gains on the robot.
    pub steps: Vec<Step>,
    /// Difference equation and code of the controller.
    pub equation: Equation,
    /// Number of loops evaluated by linear theory, and of controllers simulated.
    pub evaluations: [usize; 2],
    /// Bandwidth that linear theory alone would allow, Hz; `None` unless the simulation allows less.
    pub theory_alone_hz: Option<f64>,
}

/// Tunes a controller of a file on some machines, the most probable first ([`machines`]). `progress` gets
/// the name of the stage under way.
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
    knobs::leading(base, spec)?;
    let spec = &spec.clone().in_si(|gain, text| gain_in_si(document, &name, gain, text))?;
    let knobs = Knobs::new(scenario, base, spec)?;
    let at_work = knobs.all_at_work();
    let with_step = spec.limits.iter().any(|limit| limit.of == TuneMeasure::StepOvershoot);
    let plants: Vec<_> =
        machines.par_iter().map(|machine| LinearPlant::new(machine, &name, &at_work, with_step)).collect();
    let plants = plants.into_iter().collect::<Result<Vec<_>, _>>()?;
    let before = plants[0].figures(base)?;
    let tuning = Tuning {
        spec,
        name: &name,
        machines,
        knobs: &knobs,
        search: TuneSearch::new(spec, &knobs, &plants),
        progress,
    };
    let found = tuning.best()?;
    let tuned = knobs.spec(&TuneSearch::sizes(&found.point));
    let runs = found.runs.last().cloned().unwrap_or_default();
    let steps = order::steps(&plants, &tuned, found.runs, spec, &|to| changes(&name, base, to));
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
        runs,
        settings,
        steps,
        equation,
        evaluations: [tuning.search.evaluations.load(Ordering::Relaxed), found.simulated],
        theory_alone_hz: found.theory_alone_hz,
    })
}

fn controller(scenario: &Scenario, spec: &Spec) -> Result<String, TuneError> {
    let known: Vec<&str> = scenario.controllers.keys().map(String::as_str).collect();
    let servo =
        scenario.machine.actuators.iter().find(|(_, a)| matches!(a.kind, ActuatorKind::PositionServo(_)));
    let add = || match servo {
        Some((name, _)) => refused(
            format!(
                "only the position servo `{name}` closes a loop here, and tune chooses gains of controllers"
            ),
            "see its limits with `feeler analyze`, and move its gains with `feeler live`",
        ),
        None => refused("the file has no controller that closes a loop", "add one, as `feeler new` shows"),
    };
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

/// The result, confirmed on every machine.
struct Found {
    point: Point,
    score: f64,
    /// Runs of each share of the gains, the whole last.
    runs: Vec<Runs>,
    simulated: usize,
    theory_alone_hz: Option<f64>,
}

/// Results of the runs of each share of the gains, or the first machine with a trouble.
type Confirmed = Result<Vec<Runs>, (usize, Trouble)>;

struct Tuning<'a> {
    spec: &'a Spec,
    name: &'a str,
    machines: &'a [Scenario],
    knobs: &'a Knobs,
    search: TuneSearch<'a>,
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
            let (found, known) = self.confirmed(&ranked, step, &active, &mut simulated)?;
            let failing = self.failing(&found.point, &active, known, &mut simulated);
            match failing {
                Ok(runs) => {
                    let asks = self.spec.limits.iter().any(|limit| limit.of == TuneMeasure::Overshoot);
                    if asks && runs.last().is_none_or(|runs| runs.overshoot.is_none()) {
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

    /// The best of a ranking that the simulation confirms on the machines in use, and the runs of its shares.
    fn confirmed(
        &self,
        ranked: &[Scored],
        step: f64,
        active: &[usize],
        simulated: &mut usize,
    ) -> Result<(Scored, Vec<Runs>), TuneError> {
        let meeting: Vec<&Scored> = ranked.iter().filter(|scored| scored.score > 0.0).collect();
        let mut first_trouble = None;
        // The best alone first: most often it passes.
        let (best, others) = meeting.split_at(1.min(meeting.len()));
        for some in std::iter::once(best).chain(others.chunks(BESIDE)) {
            *simulated += some.len();
            let alone: Vec<Ran> = (some.par_iter())
                .map(|scored| self.run(&self.at(&scored.point), self.spec, active))
                .collect();
            for (&scored, ran) in some.iter().zip(alone) {
                match self.with_those_around(&scored.point, ran, active, simulated) {
                    Ok(runs) if best.contains(&scored) => return Ok((scored.clone(), runs)),
                    Ok(mut runs) => {
                        let mut rests = |scored: &Scored| {
                            let found = self.at_rest(&scored.point, active, simulated);
                            found.map(|found| runs = found).is_ok()
                        };
                        let found = self.search.climb(scored.clone(), step.max(FINEST), active, &mut rests);
                        return Ok((found, runs));
                    }
                    Err((_, trouble)) => first_trouble = first_trouble.or(Some(trouble)),
                }
            }
        }
        Err(nothing_settles(first_trouble, self.spec, self.machines[0].machine.axis))
    }

    fn at(&self, point: &[f64]) -> ControllerSpec {
        self.knobs.spec(&TuneSearch::sizes(point))
    }

    fn run(&self, controller: &ControllerSpec, asked: &Spec, machines: &[usize]) -> Ran {
        let machines: Vec<&Scenario> = machines.iter().map(|&i| &self.machines[i]).collect();
        Runs::of(&machines, self.name, controller, asked)
    }

    /// Results of the runs of controllers, up to and with the first that has a trouble.
    fn run_all(&self, around: &[(String, ControllerSpec)], asked: &Spec, machines: &[usize]) -> Vec<Ran> {
        // Runs after a trouble are not needed.
        let first = AtomicUsize::new(usize::MAX);
        let runs = around.par_iter().enumerate().map(|(i, (_, controller))| {
            (i <= first.load(Ordering::Relaxed)).then(|| {
                let ran = self.run(controller, asked, machines);
                if ran.1.is_some() {
                    first.fetch_min(i, Ordering::Relaxed);
                }
                ran
            })
        });
        let mut runs: Vec<Option<Ran>> = runs.collect();
        runs.truncate(first.into_inner().saturating_add(1));
        runs.into_iter().flatten().collect()
    }

    /// Results of the runs of each share of the gains, the whole last. Else the first machine on which a
    /// point, a share or a neighbour fails.
    fn at_rest(&self, point: &[f64], machines: &[usize], simulated: &mut usize) -> Confirmed {
        *simulated += 1;
        let alone = self.run(&self.at(point), self.spec, machines);
        self.with_those_around(point, alone, machines, simulated)
    }

    /// The results for a point that has been run already. Limits apply to the point alone; its shares and
    /// neighbours must only come to rest.
    fn with_those_around(
        &self,
        point: &[f64],
        (alone, trouble): Ran,
        machines: &[usize],
        simulated: &mut usize,
    ) -> Confirmed {
        if let Some(failing) = trouble {
            return Err(failing);
        }
        let asked = Spec { limits: Vec::new(), ..Spec::default() };
        let tuned = self.at(point);
        let near = |what: &str, trouble| Trouble::Near(what.into(), Box::new(trouble));
        let mut runs = Vec::new();
        let shares = order::on_the_way(&tuned);
        for (what, spec) in &shares {
            let falls = |&machine: &usize| !self.search.is_stable(spec, machine);
            if let Some(i) = machines.par_iter().position_first(falls) {
                return Err((i, near(what, Trouble::Ends(Outcome::Unstable))));
            }
        }
        let steps = shares.len();
        let around: Vec<(String, ControllerSpec)> = shares.into_iter().chain(neighbours(&tuned)).collect();
        for ((what, _), (of_this, trouble)) in around.iter().zip(self.run_all(&around, &asked, machines)) {
            *simulated += 1;
            if let Some((machine, trouble)) = trouble {
                return Err((machine, near(what, trouble)));
            }
            runs.push(of_this);
        }
        runs.truncate(steps);
        runs.push(alone);
        Ok(runs)
    }

    /// Results of all runs, `known` if all machines are in use; otherwise machines not in use yet on which a
    /// point fails. These are the ones that miss limits of theory by most, else the first whose runs do not
    /// pass.
    fn failing(
        &self,
        point: &[f64],
        active: &[usize],
        known: Vec<Runs>,
        simulated: &mut usize,
    ) -> Result<Vec<Runs>, Vec<usize>> {
        let others: Vec<usize> = (0..self.machines.len()).filter(|i| !active.contains(i)).collect();
        if others.is_empty() {
            return Ok(known);
        }
        let mut missed: Vec<(usize, f64)> = others
            .par_iter()
            .map(|&i| (i, self.search.score(point, &[i])))
            .filter(|(_, score)| *score <= 0.0)
            .collect();
        missed.sort_by(|a, b| a.1.total_cmp(&b.1));
        if !missed.is_empty() {
            return Err(missed.into_iter().take(JOINING).map(|(i, _)| i).collect());
        }
        let all: Vec<usize> = (0..self.machines.len()).collect();
        self.at_rest(point, &all, simulated).map_err(|(machine, _)| vec![machine])
    }
}

/// The keys of a controller that tuning may change, with their values.
fn values(name: &str, spec: &ControllerSpec) -> IndexMap<String, f64> {
    let gains =
        spec.law.gains().into_iter().filter_map(|field| Some((field.key.name, field.number(&spec.law)?)));
    let gains = gains.map(|(key, value)| (key.to_owned(), value));
    let all = gains.chain(of_filters(&spec.law)).chain(of_filters(spec));
    all.map(|(key, value)| (format!("{}.{key}", ControllerSpec::place(name)), value)).collect()
}

/// The numbers of the filters of a record, each with its key.
fn of_filters<T: Keyed>(record: &T) -> Vec<(String, f64)> {
    let of_field = |field: &'static Field<T>| {
        let Some(Content::Table(table)) = (field.get)(record) else { return Vec::new() };
        let key = field.key.name;
        let name = |inner: &str| match field.key.kind {
            // A filter of first order is a plain number.
            KeyKind::QuantityOrTable(plain, ..) if plain == inner && table.iter().count() == 1 => {
                key.to_owned()
            }
            _ => format!("{key}.{inner}"),
        };
        let numbers = table.iter().filter_map(|(inner, content)| Some((name(inner), f64::of(content)?)));
        numbers.collect::<Vec<_>>()
    };
    record.fields().flat_map(of_field).collect()
}

/// Values of `--set` that change a controller to each of others: the keys that any of them changes.
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

/// Value of a gain that a text gives with its unit, SI.
fn gain_in_si(document: &Document, controller: &str, name: &str, text: &str) -> Result<f64, TuneError> {
    let key = format!("{}.{name}", ControllerSpec::place(controller));
    let with = document.with([(key.as_str(), Setting::Text(text.to_owned()))])?;
    Ok(gain(&with.scenario.controllers[controller].spec, name)?)
}

fn setting(value: &str) -> Setting {
    value.parse().map_or_else(|_| Setting::Text(value.into()), Setting::Number)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn truth_a_limit_of_a_gain_has_the_unit_of_its_key() {
        let scenarios = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios"));
        let document = Document::load(&scenarios.join("chatter/settles.toml")).unwrap();
        let read = |text| gain_in_si(&document, "force", "damping", text);
        assert_eq!(read("2 kN s/m").unwrap().to_bits(), 2000_f64.to_bits());
        let refused = read("2 kg").unwrap_err();
        assert!(refused.to_string().contains("controllers.force.damping"), "{refused}");
    }
}
