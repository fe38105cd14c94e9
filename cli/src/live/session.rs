//! State of a live page: the file with some numbers changed, its runs and its theory.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::replay::replay_record;
use feeler_engine::{RunSettings, Scenario};
use feeler_files::{Document, Draft, Edit, FormatError, Located, Setting};
use feeler_plant::description::Machine;
use feeler_problem::Problem;
use feeler_studies::glimpse::{Glimpse, Loci, beginning, outcomes, theory};
use feeler_studies::run::{Outcome, RunResult, run_once};
use feeler_studies::{Doubts, doubts};
use rayon::ThreadPool;
use rayon::prelude::*;
use serde_json::{Value, json};

use super::moves::Moves;

use crate::numbers::count;
use crate::pages::live::{self, Shown};
use crate::terminal;
use crate::terminal::failure;
use crate::watched::Watched;

/// Number of variants that one task simulates in parallel.
const BLOCK: usize = feeler_studies::run::LANES;
/// Largest number of map points in one request.
const MOST_POINTS: usize = 256;
/// Longest computation of a run while a slider moves, s. Drawing takes as long again within the 50 ms of a
/// move.
const MOST_RUN_S: f64 = 0.025;
/// Largest number of mistakes that a page shows.
const MOST_MISTAKES: usize = 5;
/// Smallest share of a longer run that is shown while a slider moves.
const LEAST_SHARE: f64 = 0.1;

/// Records for comparison with the machine.
pub(crate) struct Measured {
    dataset: Dataset,
    /// The machine of a diagnosis.
    repaired: Option<Machine>,
}

impl Measured {
    pub(crate) fn new(dataset: Dataset, repaired: Option<Machine>) -> Self {
        Self { dataset, repaired }
    }
}

/// A file whose numbers a page changes.
pub(crate) struct Session {
    path: PathBuf,
    file: Mutex<File>,
    measured: Option<Measured>,
    /// Seconds of computation for each simulated second, from the latest run; zero before the first.
    pace: Mutex<f64>,
    moves: Moves,
    /// The threads of the map. They rest while the other threads compute a move.
    background: ThreadPool,
}

/// The file as last read.
struct File {
    document: Document,
    /// Settings from `--set` of the command, until they are written to the file.
    settings: Vec<String>,
    /// The file and its base files as last read, and the number of changes since the start.
    watched: Watched,
    version: u64,
    /// The current mistake of the file. The last valid version is shown until it is corrected.
    problem: Option<String>,
}

impl Session {
    pub(crate) fn new(path: &Path, settings: &[String], measured: Option<Measured>) -> crate::Result<Self> {
        let document = Draft::load_with(path, settings)?.build()?;
        let settings = settings.to_vec();
        let watched = Watched::of(&document);
        let file = File { document, settings, watched, version: 0, problem: None };
        Ok(Self {
            path: path.to_owned(),
            file: Mutex::new(file),
            measured,
            pace: Mutex::new(0.0),
            moves: Moves::default(),
            background: failure::pool(0)?,
        })
    }

    /// The page.
    pub(crate) fn page(&self) -> String {
        let records = self.measured.iter().flat_map(|measured| &measured.dataset.records);
        let records: Vec<&str> = records.map(|record| record.name.as_str()).collect();
        let file = self.file();
        let chunk = (BLOCK * rayon::current_num_threads()).min(MOST_POINTS);
        live::page(&self.current().document, &self.path.display().to_string(), &records, &file, chunk)
    }

    /// The file now: its version, its numbers, and its mistake.
    pub(crate) fn file(&self) -> Value {
        let file = self.as_saved();
        // Steps, rates and seeds of a run are not shown, because they are not properties of the machine.
        let (duration, of_run) =
            (RunSettings::key(&RunSettings::DURATION), format!("{}.", RunSettings::TABLE));
        let is_shown = |key: &str| key == duration || !key.starts_with(&of_run);
        let numbers = file.document.numbers().into_iter().filter(|number| is_shown(&number.key));
        let numbers: Vec<Value> =
            numbers.map(|n| json!({ "key": n.key, "value": n.value, "unit": n.unit })).collect();
        json!({ "version": file.version, "problem": file.problem, "numbers": numbers })
    }

    /// The results of the scenario with some numbers set: the requested part, `run` or `theory`, or both.
    /// `without_loci` omits root loci, which take up to a third of the time of theory. A run `in_motion` of a
    /// slider is shortened if it would take too long.
    pub(crate) fn state(&self, asked: &Value) -> Value {
        let _move = self.moves.begin();
        let mut document = match self.document(asked) {
            Ok(document) => document,
            Err(error) => return json!({ "problem": plainly(&error) }),
        };
        let (mut cut_from_s, mut has_all) = (None, true);
        let (run, theory) = match asked["part"].as_str() {
            Some("run") => {
                let duration_s = &mut document.scenario.run.duration_s;
                let affordable_s = self.affordable_s(*duration_s);
                if asked["in_motion"].as_bool().unwrap_or(false) && affordable_s < *duration_s {
                    cut_from_s = Some(std::mem::replace(duration_s, affordable_s));
                }
                let run = run_once(&document.scenario);
                if let Ok(RunResult { summary, .. }) = &run
                    && summary.simulated_s > 0.0
                {
                    *self.pace.lock().unwrap_or_else(PoisonError::into_inner) =
                        summary.wall_s / summary.simulated_s;
                }
                (Some(run), None)
            }
            Some("theory") => {
                has_all = !asked["without_loci"].as_bool().unwrap_or(false);
                let loci = if has_all { Loci::Drawn } else { Loci::Omitted };
                (None, Some(theory(&document.scenario, loci)))
            }
            _ => {
                let Glimpse { run, theory } = Glimpse::of(&document.scenario);
                (Some(run), Some(theory))
            }
        };
        let is_undecided = |run: &RunResult| run.summary.outcome == Outcome::Undecided;
        let may_be_wrong = cut_from_s.is_none() && run.iter().flatten().any(is_undecided);
        let doubts = if may_be_wrong { doubts(&document.scenario) } else { Doubts::default() };
        Shown { document: &document, run, theory, cut_from_s, doubts, has_all }.to_json()
    }

    /// The simulated time that fits into [`MOST_RUN_S`], from the speed of the latest run.
    fn affordable_s(&self, duration_s: f64) -> f64 {
        let pace = *self.pace.lock().unwrap_or_else(PoisonError::into_inner);
        if pace * duration_s <= MOST_RUN_S {
            duration_s
        } else {
            duration_s * LEAST_SHARE.max(MOST_RUN_S / (pace * duration_s))
        }
    }

    /// The outcomes of the scenario at some points of two numbers. `guess` requests outcomes estimated from
    /// the starts of the runs, at a fraction of the time. The map rests while a move is computed.
    pub(crate) fn map(&self, asked: &Value) -> Value {
        let document = match self.document(asked) {
            Ok(document) => document,
            Err(error) => return json!({ "problem": plainly(&error) }),
        };
        let is_guess = asked["guess"].as_bool().unwrap_or(false);
        let key = |of: &str| asked["keys"][of].as_str().unwrap_or_default().to_owned();
        let keys = [key("x"), key("y")];
        let points = asked["points"].as_array().map_or(&[][..], Vec::as_slice);
        let at = |point: &Value| -> Option<Scenario> {
            let values = [point[0].as_f64()?, point[1].as_f64()?];
            let settings = keys.iter().map(String::as_str).zip(values.map(Setting::Number));
            let scenario = document.with(settings).ok()?.scenario;
            Some(if is_guess { beginning(&scenario) } else { scenario })
        };
        let points: Vec<&Value> = points.iter().take(MOST_POINTS).collect();
        let rest = || self.moves.rest();
        let of_block = |block: &[&Value]| {
            let scenarios: Vec<Option<Scenario>> = block.iter().map(|point| at(point)).collect();
            let mut next_outcome = outcomes(scenarios.iter().flatten().cloned().collect(), &rest).into_iter();
            let outcome = |scenario: Option<Scenario>| scenario.and_then(|_| next_outcome.next().flatten());
            scenarios.into_iter().map(outcome).map(|o| o.map(Outcome::name)).collect::<Vec<_>>()
        };
        let found: Vec<Option<&str>> =
            self.background.install(|| points.par_chunks(BLOCK).flat_map_iter(of_block).collect());
        json!({ "outcomes": found })
    }

    /// Predictions of the machine with some numbers set, for the commands of a record.
    pub(crate) fn replay(&self, asked: &Value) -> Value {
        let Some(Measured { dataset, repaired }) = &self.measured else { return json!({ "charts": [] }) };
        let document = match self.document(asked) {
            Ok(document) => document,
            Err(error) => return json!({ "problem": plainly(&error) }),
        };
        let index = asked["record"].as_u64().map_or(0, |i| i as usize).min(dataset.records.len().max(1) - 1);
        let machine = &document.scenario.machine;
        let replays = [Some(machine), repaired.as_ref()]
            .map(|machine| machine.and_then(|machine| replay_record(machine, dataset, index).ok()));
        let [believed, repaired] = &replays;
        json!({ "charts": live::records(machine, dataset, index, believed.as_ref(), repaired.as_ref()) })
    }

    /// Writes the numbers, and those of `--set`, into the file, after copying the file. Writes nothing if the
    /// numbers are unchanged.
    pub(crate) fn write(&self, asked: &Value) -> Value {
        // Keeps changes that an editor has saved in the meantime.
        let mut file = self.as_saved();
        if let Some(problem) = &file.problem {
            return json!({ "problem": problem });
        }
        let moved: Vec<(String, f64)> = values(asked).collect();
        let key_of = |setting: &str| setting.split_once('=').map(|(key, _)| key.trim().to_owned());
        let set: Vec<String> = file.settings.iter().filter_map(|setting| key_of(setting)).collect();
        let is_set_only = |key: &String| {
            set.iter().any(|set| is_within(key, set)) && moved.iter().all(|(other, _)| other != key)
        };
        let numbers = file.document.numbers().into_iter().filter(|number| is_set_only(&number.key));
        let edits: Vec<Edit> = numbers
            .map(|number| Edit { key: number.key, value: number.value })
            .chain(moved.iter().map(|(key, value)| Edit { key: key.clone(), value: *value }))
            .collect();
        let settings = moved.iter().map(|(key, value)| (key.as_str(), Setting::Number(*value)));
        // An invalid machine is not written.
        let checked = file.document.with(settings).and_then(|_| file.document.edited(&edits));
        let edited = checked.map_err(|error| plainly(&error));
        if edited.as_ref().is_ok_and(|text| text == file.document.text()) {
            return json!({ "written": null });
        }
        let written =
            edited.and_then(|text| terminal::rewrite(&self.path, &text).map_err(|error| error.to_string()));
        match written {
            Ok(backup) => {
                let is_left = |key: String| edits.iter().all(|edit| !is_within(&edit.key, &key));
                file.settings.retain(|setting| key_of(setting).is_none_or(is_left));
                json!({ "written": self.path.display().to_string(), "backup": backup.display().to_string() })
            }
            Err(problem) => json!({ "problem": problem }),
        }
    }

    /// The file with the numbers of a request.
    fn document(&self, asked: &Value) -> Result<Document, FormatError> {
        let file = self.current();
        let settings: Vec<(String, f64)> = values(asked).collect();
        file.document.with(settings.iter().map(|(key, value)| (key.as_str(), Setting::Number(*value))))
    }

    /// The file, read again if it has changed.
    fn as_saved(&self) -> MutexGuard<'_, File> {
        let mut file = self.current();
        let now = file.watched.now();
        if now != file.watched {
            file.watched = now;
            file.version += 1;
            let read = Draft::load_with(&self.path, &file.settings).and_then(Draft::build);
            match read {
                Ok(document) => {
                    // The file may now name another base.
                    if !file.watched.is_of(&document) {
                        file.watched = Watched::of(&document);
                    }
                    (file.document, file.problem) = (document, None);
                }
                Err(error) => file.problem = Some(in_file(&error)),
            }
        }
        file
    }

    /// If a previous holder of the lock failed, the file is still complete.
    fn current(&self) -> MutexGuard<'_, File> {
        self.file.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Whether the key of a number equals `key`, or belongs to its list.
fn is_within(number: &str, key: &str) -> bool {
    number.strip_prefix(key).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// The numbers of a request.
fn values(asked: &Value) -> impl Iterator<Item = (String, f64)> {
    let settings = asked["settings"].as_object();
    settings.into_iter().flatten().filter_map(|(key, value)| Some((key.clone(), value.as_f64()?)))
}

/// Mistakes of numbers that a page has set: with their keys, without places in a file.
fn plainly(error: &FormatError) -> String {
    let described = |found: &Located| {
        Problem::new(found.key.as_str(), found.message.as_str(), found.remedy.as_str()).to_string()
    };
    in_few_lines(error, described)
}

/// Mistakes of the file: their lines and keys.
fn in_file(error: &FormatError) -> String {
    in_few_lines(error, ToString::to_string)
}

fn in_few_lines(error: &FormatError, described: impl Fn(&Located) -> String) -> String {
    let mut lines: Vec<String> = error.problems.iter().take(MOST_MISTAKES).map(described).collect();
    let more = error.problems.len() + error.omitted - lines.len();
    lines.extend((more > 0).then(|| format!("and {}", count(more, "further mistake", "further mistakes"))));
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;

    /// All threads of the map rest while other threads compute a move. Then the map continues, and gives the
    /// same outcomes as without a rest.
    #[test]
    fn truth_the_map_rests_while_a_slider_moves() {
        const BLOCKS: usize = 2;
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/chatter/sustained.toml");
        let session = Session::new(&file, &[], None).unwrap();
        let points: Vec<[f64; 2]> =
            (0..BLOCKS * BLOCK).map(|i| [0.3 + 0.1 * i as f64, 4.0 + 0.1 * i as f64]).collect();
        let keys = json!({ "x": "controllers.force.kp", "y": "bodies.tip.mass" });
        let asked = json!({ "settings": {}, "keys": keys, "points": points });
        let alone = session.map(&asked);
        let (moves, over) = (&session.moves, AtomicBool::new(false));
        std::thread::scope(|scope| {
            let moved = moves.begin();
            let map = scope.spawn(|| {
                let found = session.map(&asked);
                moves.is_over(&over);
                found
            });
            assert!(moves.wait_for(BLOCKS.min(session.background.current_num_threads()), &over));
            let state = session.state(&json!({ "settings": {} }));
            assert!(state["charts"]["force"].is_object() && state["planes"]["locus"].is_object());
            assert!(!map.is_finished());
            drop(moved);
            assert_eq!(map.join().unwrap(), alone);
        });
    }
}
