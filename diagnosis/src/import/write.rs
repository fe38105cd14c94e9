//! Writes datasets: a folder for each joint, with a table for each run.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use feeler_files::{ColumnSpec, dataset_keys as keys};
use feeler_logs::{Pick, Run, Series, Table, on_one_grid};
use feeler_problem::short;

use super::axis::{AxisBelief, Beliefs, Model};
use super::files::{create, file_name, save, table};
use super::first::First;
use super::guess::{Chosen, Guess};
use super::load::Arm;
use super::role::ColumnRole;
use super::roles::words;
use super::seen::Seen;
use super::survey::{Options, Survey, Written};
use super::units::UnitGuess;
use crate::dataset::{breaks, quantum};
use crate::error::DiagnosisError;

/// Smallest number of rows of an experiment.
const FEWEST_ROWS: usize = 50;
/// The column of what gravity and other joints do.
const LOAD: &str = "load";

/// Datasets in progress, one for each joint.
pub(super) struct Writer {
    joints: Vec<Joint>,
}

struct Joint {
    name: String,
    guess: Guess,
    folder: PathBuf,
    experiments: Vec<String>,
    /// Runs in which its input never changes.
    still: Vec<String>,
    /// A machine that the user gives.
    given: Option<First>,
    belief: Option<AxisBelief>,
    /// Assumptions about the model.
    assumptions: Vec<String>,
    /// The arm that loads the joint, and its inertia there.
    arm: Option<(Arm, f64)>,
    seen: Seen,
}

/// Fits the units of a joint's columns to the axis of its model, and returns the assumptions. `believed` says
/// whether the model's joint moves along a line.
///
/// # Errors
/// If a stated unit contradicts the axis of a given machine.
fn fit_axis(
    guess: &mut Guess,
    options: &Options,
    given: Option<&First>,
    believed: Option<bool>,
) -> Result<Vec<String>, DiagnosisError> {
    let axis = given.map(|given| given.is_straight);
    if let (Some(is_straight), Some(Model::Machine(file))) = (axis, &options.model)
        && let Some(reason) = guess.stated_against(is_straight)
    {
        let remedy = "name a machine with the `axis` of this joint, or correct the unit of the column";
        return Err(DiagnosisError::Unreadable { file: file.clone(), reason, remedy });
    }
    let fitted = axis.or(believed).map(|is_straight| guess.fit_axis(is_straight));
    Ok(fitted.into_iter().flatten().collect())
}

impl Writer {
    /// Selects joints from the first run. `None` while none has a target and a position.
    pub(super) fn new(survey: &Survey, options: &Options) -> Result<Option<Self>, DiagnosisError> {
        let Some(out) = &options.out else { return Ok(None) };
        let is_whole = |guess: &Guess| {
            guess.columns.contains_key(&ColumnRole::Position)
                && (guess.columns.contains_key(&ColumnRole::Target)
                    || guess.columns.contains_key(&ColumnRole::Command))
        };
        let pairs: Vec<(&String, &Guess)> =
            survey.joints.iter().filter(|(_, guess)| is_whole(guess)).collect();
        if pairs.is_empty() {
            return Ok(None);
        }
        let names: Vec<String> = pairs.iter().map(|(name, _)| (*name).clone()).collect();
        let beliefs = options.model.as_ref().map(Beliefs::load).transpose()?;
        let mut joints = Vec::new();
        for (name, guess) in &pairs {
            let belief = beliefs.as_ref().and_then(|beliefs| beliefs.find(name, &names));
            let is_wanted = options.joint.as_ref().is_none_or(|wanted| {
                words(wanted) == words(name)
                    || belief.as_ref().is_some_and(|(belief, _)| belief.joint.name == *wanted)
            });
            if !is_wanted {
                continue;
            }
            let arm = beliefs.as_ref().and_then(|beliefs| Arm::around(name, beliefs, &survey.joints));
            let arm = arm.filter(|_| belief.is_some());
            let given = match &options.model {
                Some(Model::Machine(path)) => Some(First::given(path)?),
                _ => None,
            };
            let mut guess = (*guess).clone();
            let believed = belief.as_ref().map(|(belief, _)| belief.is_straight);
            let mut assumptions = fit_axis(&mut guess, options, given.as_ref(), believed)?;
            match (&belief, &beliefs) {
                (Some((belief, why)), beliefs) => {
                    assumptions
                        .push(format!("`{name}` is the joint `{}` of the model: {why}", belief.joint.name));
                    let remarks = beliefs.iter().flat_map(|beliefs| &beliefs.remarks);
                    assumptions.extend(remarks.map(|remark| format!("of the model, {remark}")));
                }
                (None, Some(beliefs)) if !beliefs.names().is_empty() => assumptions.push(format!(
                    "the model has no joint `{name}`, only {}: none of it is used",
                    beliefs.names().join(", ")
                )),
                _ => {}
            }
            let unknown: Vec<&str> = arm.iter().flat_map(Arm::unknown).collect();
            if !unknown.is_empty() {
                assumptions.push(format!("the log has no {}: taken to be zero", unknown.join(", ")));
            }
            let middle = arm.map(|arm| {
                let inertia = arm.inertia(|column| range(survey, column));
                (arm, inertia)
            });
            joints.push(Joint {
                name: (*name).clone(),
                seen: Seen::of(&guess),
                guess,
                folder: out.clone(),
                experiments: Vec::new(),
                still: Vec::new(),
                given,
                belief: belief.map(|(belief, _)| belief.clone()),
                assumptions,
                arm: middle,
            });
        }
        if joints.is_empty() {
            let wanted = options.joint.clone().unwrap_or_default();
            return Err(DiagnosisError::NoJoint { joint: wanted, known: names.join(", ") });
        }
        if joints.len() > 1 {
            for joint in &mut joints {
                joint.folder = out.join(file_name(&joint.name));
            }
        }
        for joint in &joints {
            create(&joint.folder)?;
        }
        Ok(Some(Self { joints }))
    }

    /// Adds a run to every dataset with columns in it.
    pub(super) fn run(&mut self, run: &Run, notes: &mut Vec<String>) -> Result<(), DiagnosisError> {
        for joint in &mut self.joints {
            joint.run(run, notes)?;
        }
        Ok(())
    }

    /// Writes the description files of the datasets.
    pub(super) fn finish(self, survey: &mut Survey) -> Result<(), DiagnosisError> {
        for joint in self.joints {
            survey.notes.extend(joint.left_out());
            if joint.experiments.is_empty() {
                survey.notes.push(format!(
                    "nothing was written{}: record at least {FEWEST_ROWS} rows in which the {} changes",
                    if joint.name.is_empty() { String::new() } else { format!(" for `{}`", joint.name) },
                    joint.input().noun()
                ));
                continue;
            }
            let middle = joint.arm.as_ref().map(|(_, inertia)| *inertia);
            let first = joint.given.clone();
            let first =
                first.unwrap_or_else(|| First::of(joint.input(), joint.belief.as_ref(), middle, &joint.seen));
            save(&joint.folder.join("dataset.toml"), &joint.dataset(&first))?;
            let assumptions = [joint.assumptions, first.assumptions].concat();
            let mut machine =
                String::from("# A first machine, written by `feeler import`. Its assumptions:\n");
            for assumption in &assumptions {
                let _ = writeln!(machine, "# - {}", one_line(assumption));
            }
            machine.push_str(&first.text);
            save(&joint.folder.join("machine.toml"), &machine)?;
            survey.datasets.push(Written {
                folder: joint.folder,
                joint: joint.name,
                assumptions,
                experiments: joint.experiments,
            });
        }
        Ok(())
    }
}

impl Joint {
    /// The columns in the order of the file: the input, the position, and additional ones.
    fn columns(&self) -> Vec<(ColumnRole, &Chosen)> {
        let of = |role: ColumnRole| self.guess.columns.get(&role).map(|chosen| (role, chosen));
        let input = of(ColumnRole::Target).or_else(|| of(ColumnRole::Command));
        let others = [
            ColumnRole::Position,
            ColumnRole::TargetVelocity,
            ColumnRole::FeedForward,
            ColumnRole::Velocity,
            ColumnRole::Effort,
        ];
        input.into_iter().chain(others.into_iter().filter_map(of)).collect()
    }

    /// The role of the column that drives the machine.
    fn input(&self) -> ColumnRole {
        if self.guess.columns.contains_key(&ColumnRole::Target) {
            ColumnRole::Target
        } else {
            ColumnRole::Command
        }
    }

    /// The runs without information, in one sentence.
    fn left_out(&self) -> Option<String> {
        let runs: Vec<String> = self.still.iter().map(|run| format!("`{run}`")).collect();
        (!runs.is_empty()).then(|| {
            format!(
                "`{}`: left out where the {} never changes, in {}",
                if self.name.is_empty() { "joint" } else { &self.name },
                self.input().noun(),
                runs.join(", ")
            )
        })
    }

    /// Whether no run can do without a column of this role.
    fn needs(&self, role: ColumnRole) -> bool {
        match role {
            ColumnRole::Velocity | ColumnRole::Effort => false,
            ColumnRole::TargetVelocity | ColumnRole::FeedForward => {
                self.given.as_ref().is_none_or(|given| given.signal(role).is_some())
            }
            ColumnRole::Target | ColumnRole::Command | ColumnRole::Position => true,
        }
    }

    fn run(&mut self, run: &Run, notes: &mut Vec<String>) -> Result<(), DiagnosisError> {
        let columns = self.columns();
        let here: Vec<(ColumnRole, &Chosen)> =
            columns.iter().copied().filter(|(_, chosen)| run.find(&chosen.column).is_some()).collect();
        let missing: Vec<&str> = columns
            .iter()
            .filter(|(role, chosen)| self.needs(*role) && run.find(&chosen.column).is_none())
            .map(|(_, chosen)| chosen.column.as_str())
            .collect();
        if !missing.is_empty() {
            notes.push(format!(
                "run `{}` has no {}, and is left out for `{}`",
                run.name,
                missing.join(", "),
                self.name
            ));
            return Ok(());
        }
        let own = here.iter().map(|(role, chosen)| Pick {
            name: &chosen.column,
            is_held: matches!(role, ColumnRole::Target | ColumnRole::Command) || role.feeds_servo(),
        });
        let picks: Vec<Pick<'_>> = own.chain(self.arm.iter().flat_map(|(arm, _)| arm.picks(run))).collect();
        let file = run.tables.first().map_or_else(PathBuf::new, |table| table.file.clone());
        let whole = in_order(&file, run, &picks)?;
        let starts = [vec![0], breaks(&whole.times_s)].concat();
        if let Some(&first) = starts.get(1) {
            notes.push(format!(
                "run `{name}`: {} s are missing before row {}: its {} parts without such breaks are \
                 experiments of their own, `{name}-1` and so on",
                short(whole.times_s[first] - whole.times_s[first - 1]),
                whole.rows_before + first + 1,
                starts.len(),
                name = run.name
            ));
        }
        let roles: Vec<ColumnRole> = here.iter().map(|(role, _)| *role).collect();
        let names: Vec<String> = picks.iter().map(|pick| pick.name.to_owned()).collect();
        for (i, series) in whole.parts(&starts).into_iter().enumerate() {
            let name = if starts.len() > 1 { format!("{}-{}", run.name, i + 1) } else { run.name.clone() };
            self.experiment(run, &name, (&roles, &names), series, notes)?;
        }
        Ok(())
    }

    /// Adds rows without a break as an experiment. `columns` are their roles, and the names of all series.
    fn experiment(
        &mut self,
        run: &Run,
        named: &str,
        (here, picks): (&[ColumnRole], &[String]),
        mut series: Series,
        notes: &mut Vec<String>,
    ) -> Result<(), DiagnosisError> {
        if series.times_s.len() < FEWEST_ROWS {
            notes.push(format!("run `{named}` has only {} rows, and is left out", series.times_s.len()));
            return Ok(());
        }
        // The first column is the input.
        let mut asked = series.values[0].iter().filter(|x| x.is_finite());
        let held = asked.next();
        if asked.all(|x| Some(x) == held) {
            self.still.push(named.to_owned());
            return Ok(());
        }
        notes.extend(series.notes.iter().map(|note| format!("run `{named}`: {note}")));
        for (pick, bad) in picks.iter().zip(&series.bad) {
            if let Some((first, cells)) = bad {
                let alike = if *cells == 1 { String::new() } else { format!(" ({cells} such cells)") };
                notes.push(format!(
                    "run `{named}`: `{pick}` holds no number in row {}{alike}: left empty",
                    series.rows_before + first + 1
                ));
            }
        }
        let name = self.unused(named);
        let mut header: Vec<&str> = here.iter().map(|role| role.noun()).collect();
        let mut held = self.seen.held;
        if let Some((arm, _)) = &self.arm {
            let load = arm.load(run, &series.times_s, &series.values[here.len()..]);
            series.values.truncate(here.len());
            series.bridged.truncate(here.len());
            let each = |role| self.guess.columns.get(&role).map_or(1.0, Chosen::in_si);
            let (target, position) = (each(ColumnRole::Target), each(ColumnRole::Position));
            if here[0] == ColumnRole::Target && here[1] == ColumnRole::Position {
                let lead = here.iter().position(|role| *role == ColumnRole::FeedForward);
                for (row, load) in load.iter().enumerate() {
                    let lead = lead.map_or(0.0, |i| series.values[i][row]);
                    let [wanted, is] = [0, 1].map(|i| series.values[i][row]);
                    held.add(load + lead, target * wanted - position * is);
                }
            }
            series.values.push(load);
            header.push(LOAD);
        }
        empty_between_readings(&mut series);
        table(&self.folder.join(&name), &header, &series)?;
        let at = here.iter().position(|role| *role == ColumnRole::Position);
        let each = self.guess.columns.get(&ColumnRole::Position).map_or(1.0, Chosen::in_si);
        self.seen.held = held;
        if self.experiments.is_empty() {
            let of_column = |i: usize| series.values[i].iter().copied().filter(|x| x.is_finite()).collect();
            let readings: Vec<f64> = at.map(of_column).unwrap_or_default();
            let step = if readings.is_empty() { None } else { quantum(&readings) };
            self.seen.step = step.map(|step| step * each);
        }
        self.experiments.push(name);
        Ok(())
    }

    /// The name of a file for a run that no other run has.
    fn unused(&self, run: &str) -> String {
        let of = |copy: usize| {
            let end = if copy > 1 { format!("-{copy}") } else { String::new() };
            format!("{}{end}.csv", file_name(run))
        };
        let mut copy = 1;
        while self.experiments.contains(&of(copy)) {
            copy += 1;
        }
        of(copy)
    }

    fn dataset(&self, first: &First) -> String {
        let mut text = String::from(
            "# Written by `feeler import`. Remarks give the reason of each guess. Change what is wrong,\n\
             # then run `feeler check`.\n",
        );
        let _ = writeln!(text, "{} = {:?}", keys::NAME.name, file_name(&self.name));
        let _ = writeln!(text, "{} = \"machine.toml\"", keys::MACHINE.name);
        let column = |name: &str, signal: &str| {
            format!("[{}.{name}]\n{} = \"{signal}\"", keys::COLUMNS, keys::SIGNAL.name)
        };
        for (role, chosen) in self.columns() {
            let name = role.noun();
            let Some(signal) = first.signal(role) else {
                let lacks = if role.feeds_servo() { "actuator" } else { "sensor" };
                let _ = writeln!(
                    text,
                    "\n# The column `{name}` ({}) is not used: the machine has no {lacks} for it.",
                    one_line(&chosen.column)
                );
                continue;
            };
            let _ = writeln!(text, "\n# {}: {}", one_line(&chosen.column), one_line(&chosen.why));
            let _ = writeln!(text, "{}", column(name, signal));
            if let Some((unit, why)) = &chosen.unit {
                let _ = match unit {
                    UnitGuess::Symbol(symbol) if unit.is_of_the_signal() => {
                        writeln!(text, "{} = \"{symbol}\" # guess: {}", keys::UNIT.name, one_line(why))
                    }
                    _ => {
                        let scale = ColumnSpec::SCALE.key.name;
                        writeln!(text, "{scale} = {:?} # guess: {}", unit.in_si(), one_line(why))
                    }
                };
            }
        }
        if let Some(signal) = self.arm.as_ref().and(first.load.as_ref()) {
            let _ = writeln!(
                text,
                "\n# The load of the weight and of the other joints' motion, from the model's masses.\n{}",
                column(LOAD, signal)
            );
        }
        if let Some(follow) = self.guess.follow {
            let _ = writeln!(
                text,
                "\n# In the first run the position follows {} ms later (correlation {:.4}).",
                short(1e3 * follow.lag_s),
                follow.correlation
            );
        }
        for name in &self.experiments {
            let _ = writeln!(text, "\n[[{}]]\n{} = {name:?}", keys::EXPERIMENTS, keys::FILE.name);
        }
        text
    }
}

/// A text for a remark: names of columns may hold anything.
fn one_line(text: &str) -> String {
    text.replace(char::is_control, " ")
}

/// Smallest and largest value of a column in the first run.
fn range(survey: &Survey, column: &str) -> Option<[f64; 2]> {
    let columns = survey.runs.first()?.tables.iter().flat_map(|table| &table.columns);
    columns.into_iter().find(|other| other.name == column).map(|found| found.range)
}

/// The columns of a run on common instants, which advance.
fn in_order(file: &Path, run: &Run, picks: &[Pick<'_>]) -> Result<Series, DiagnosisError> {
    let tables: Vec<&Table> =
        picks.iter().filter_map(|pick| run.find(pick.name)).map(|(table, _)| table).collect();
    let first = |row_of: fn(&Table) -> Option<usize>| {
        tables.iter().find_map(|table| Some(table.out_of_order(row_of(table)?)))
    };
    if let Some(error) = first(Table::goes_back_at) {
        return Err(error.into());
    }
    let mut series = on_one_grid(file, run, picks)?;
    match series.leave_out_repeats() {
        0 => {}
        repeats => series
            .notes
            .push(format!("rows that repeat the one before, time and all, are left out: {repeats}")),
    }
    // Two readings of a slower column may share an instant.
    let advances = series.times_s.windows(2).all(|pair| pair[1] > pair[0]);
    match first(Table::stays_at).filter(|_| !advances) {
        Some(error) => Err(error.into()),
        None => Ok(series),
    }
}

/// Empties the cells between the readings of a column: an interpolated value is not a reading.
fn empty_between_readings(series: &mut Series) {
    for (values, gaps) in series.values.iter_mut().zip(&series.bridged) {
        values.iter_mut().zip(gaps).filter(|(_, is_gap)| **is_gap).for_each(|(x, _)| *x = f64::NAN);
    }
}
