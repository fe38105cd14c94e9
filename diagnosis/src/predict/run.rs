//! Prediction along a whole record.

use feeler_lanes::dispatch;
use feeler_plant::assembly::{Assembly, Source};

use super::anchor::{Anchor, Anchoring, Beside, pace_of, place};
use super::imposed::impose;
use super::leeway::{Leeway, means_between_rows};
use super::loops::{PredictedLoop, RowSpan, loops, next_s, serve};
use super::machine::{Moving, Precision};
use super::prediction::Prediction;
use super::presliding::checks;
use super::sensor::readings;
use super::state::State;
use super::warm::by_commands;
use crate::budget::{Budget, Stage};
use crate::dataset::{Dataset, Driven, Record};
use crate::error::DiagnosisError;

/// Ratio of a step to the noise above which predictions are quantised. A finer step counts as noise.
const COARSE: f64 = 4.0;
/// Number of time constants after which the heat of a winding has decayed to 2 %.
const FORGOTTEN: f64 = 4.0;
/// A command that arrives within this share of a row arrives with the row.
const NEGLIGIBLE_PART: f64 = 1e-6;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Start {
    /// Start from the measurements of the first row.
    FirstRow,
    /// Restart from the anchored state after every given number of rows.
    Windows(usize),
}

/// A machine prepared to follow one record.
#[derive(Debug)]
pub struct Predictor<'a> {
    pub(super) dataset: &'a Dataset,
    pub(super) record: &'a Record,
    pub(super) machine: Moving,
    pub(super) servos: Vec<PredictedLoop>,
    pub(super) surfaces: Vec<usize>,
    /// Natural frequency of the anchoring without accelerometers, rad/s.
    pub(super) pace: f64,
    /// Whether the record begins in motion.
    pub(super) is_in_motion: bool,
    /// Meaning of a difference between the first readings of two bodies, and whether there is one.
    pub(super) beside: Beside,
    is_bent: bool,
    /// See [`Leeway::late_rows`].
    late_rows: f64,
    /// The stage whose end stops a prediction.
    until: Option<(Budget, Stage)>,
}

impl<'a> Predictor<'a> {
    /// Prepares an assembled machine for one record of a dataset. Its motion equals that of
    /// [`feeler_studies`].
    ///
    /// # Errors
    /// If the machine has no motion.
    pub fn new(
        mut assembly: Assembly,
        dataset: &'a Dataset,
        record: &'a Record,
    ) -> Result<Self, DiagnosisError> {
        let surfaces = assembly.soften();
        Self::following(assembly, &surfaces, Precision::Rounding, dataset, record, 0.0)
    }

    /// Prepares a machine for a fit. Sticking guides deflect slightly, so that small motion in a record is
    /// not evidence against dry friction. The motion advances row by row.
    pub(crate) fn with(
        mut assembly: Assembly,
        leeway: Leeway,
        dataset: &'a Dataset,
        record: &'a Record,
    ) -> Result<Self, DiagnosisError> {
        leeway.presliding.state(&mut assembly);
        let checks = checks(&assembly, record.spacing_s);
        let surfaces = assembly.soften();
        Self::following(assembly, &surfaces, Precision::Rows(checks), dataset, record, leeway.late_rows)
    }

    /// Prepares a machine whose windings have the heat that the previous records and the pauses have left.
    fn following(
        mut assembly: Assembly,
        surfaces: &[usize],
        precision: Precision,
        dataset: &'a Dataset,
        record: &'a Record,
        late_rows: f64,
    ) -> Result<Self, DiagnosisError> {
        let windings = assembly.drives.iter().filter_map(|drive| drive.warming);
        let mut known_s = FORGOTTEN * windings.map(|winding| winding.time_constant).fold(0.0, f64::max);
        // Each record with the pause after it, in which the drive rests.
        let pauses = std::iter::once(record).chain(record.earlier()).map(Record::pause_s);
        let is_known = |(earlier, pause_s): &(&Record, f64)| {
            known_s -= pause_s;
            let is_known = known_s > 0.0;
            known_s -= earlier.duration_s();
            is_known
        };
        let earlier: Vec<(&Record, f64)> = record.earlier().zip(pauses).take_while(is_known).collect();
        for &(record, pause_s) in earlier.iter().rev() {
            let heats = if let Some(heats) = by_commands(&assembly, dataset, record) {
                heats
            } else {
                Self::as_warm(assembly.clone(), surfaces, precision, dataset, record, late_rows)?
                    .anchored()?
                    .heats
            };
            for (drive, heat) in assembly.drives.iter_mut().zip(heats) {
                if let Some(winding) = &mut drive.warming {
                    winding.heat = heat * (-pause_s / winding.time_constant).exp();
                }
            }
        }
        Self::as_warm(assembly, surfaces, precision, dataset, record, late_rows)
    }

    /// Prepares a machine whose windings have the heat that its assembly states. Where the first readings of
    /// two bodies differ, the spring between them is deflected, or their zeros differ: whichever lets the
    /// first rows swing less.
    fn as_warm(
        mut assembly: Assembly,
        surfaces: &[usize],
        precision: Precision,
        dataset: &'a Dataset,
        record: &'a Record,
        late_rows: f64,
    ) -> Result<Self, DiagnosisError> {
        if let Some(engagement) = record.engagement {
            assembly.contacts.iter_mut().for_each(|contact| contact.engagement = engagement);
        }
        let begin = |mut assembly: Assembly, beside: Beside| {
            let pace = pace_of(&assembly, &dataset.channels, record);
            let placed = place(&mut assembly, &dataset.channels, record, pace, beside);
            impose(&mut assembly, dataset, record);
            let servos = loops(&assembly, &dataset.loops)?;
            let sources = dataset.channels.iter().map(|channel| channel.source).collect();
            Ok::<_, DiagnosisError>(Self {
                dataset,
                record,
                machine: Moving::new(assembly, sources, record.spacing_s, precision)?,
                servos,
                surfaces: surfaces.to_vec(),
                pace,
                is_in_motion: placed.is_in_motion,
                beside,
                is_bent: placed.is_bent,
                late_rows,
                until: None,
            })
        };
        let mut bent = begin(assembly.clone(), Beside::Bent)?;
        if !bent.is_bent {
            return Ok(bent);
        }
        let mut shifted = begin(assembly, Beside::Shifted)?;
        Ok(if shifted.first_swing()? < bent.first_swing()? { shifted } else { bent })
    }

    /// The same, with predictions that fail when a stage of a diagnosis is over.
    pub(crate) fn until(self, budget: Budget, stage: Stage) -> Self {
        Self { until: Some((budget, stage)), ..self }
    }

    /// Predicts freely from the first row to the last.
    ///
    /// # Errors
    /// If an exponential fails.
    pub fn free(&mut self) -> Result<Prediction, DiagnosisError> {
        self.follow(Anchoring::Never, Start::FirstRow)
    }

    /// Predicts row by row, corrected toward the measured motion.
    ///
    /// # Errors
    /// If an exponential fails.
    pub(crate) fn anchored(&mut self) -> Result<Prediction, DiagnosisError> {
        self.follow(Anchoring::Continuous, Start::FirstRow)
    }

    /// Predicts row by row, corrected toward the measured motion, or in free windows that start from it.
    ///
    /// # Errors
    /// If an exponential fails.
    pub(crate) fn follow(
        &mut self,
        anchoring: Anchoring,
        start: Start,
    ) -> Result<Prediction, DiagnosisError> {
        let dt = self.record.spacing_s;
        let rows = self.record.len();
        let anchor = self.anchor();
        let commands = self.effective_commands();
        let mut state = self.start(anchor.as_ref(), &commands)?;
        let anchor = anchor.filter(|_| anchoring == Anchoring::Continuous);
        let mut window: Option<State> = None;
        let mut signals = vec![Vec::with_capacity(rows); self.dataset.channels.len()];
        let omega = anchor.as_ref().map_or(0.0, Anchor::omega);
        let mut seen = Vec::new();
        let (channels, contacts) =
            (self.dataset.channels.len(), self.machine.motion.assembly().contacts.len());
        let mut prediction = Prediction::blank(rows, contacts, omega);
        dispatch(
            #[inline(always)]
            || -> Result<(), DiagnosisError> {
                for k in 0..rows {
                    if self.until.is_some_and(|(budget, stage)| budget.is_over(stage)) {
                        return Err(DiagnosisError::Late);
                    }
                    if let Start::Windows(length) = start
                        && k % length == 0
                    {
                        window = Some(state.clone());
                    }
                    // At a row, the rate of an imposed motion is that of the time after the row.
                    for state in window.iter_mut().chain([&mut state]) {
                        self.machine.impose(state, k as f64 * dt);
                    }
                    self.machine.evaluate_signals(window.as_ref().unwrap_or(&state), &mut seen);
                    for (signal, &value) in signals.iter_mut().zip(&seen) {
                        signal.push(value);
                    }
                    let [x, v, force] = [0, 1, 2].map(|i| seen[channels + i]);
                    prediction.stroke.push([x, v, force]);
                    let (forces, depths) = seen[channels + 3..channels + 3 + 2 * contacts].split_at(contacts);
                    prediction.touching.push(forces.iter().any(|force| *force != 0.0));
                    for (series, &depth) in prediction.compressions.iter_mut().zip(depths) {
                        series.push(depth);
                    }
                    if let Some(anchor) = &anchor {
                        if window.is_some() {
                            self.machine.evaluate_signals(&state, &mut seen);
                        }
                        anchor.correct(&self.machine, &mut state, &seen, &self.record.series, k, dt);
                        self.machine.impose(&mut state, k as f64 * dt);
                    }
                    self.drive_on(&mut state, &commands, k, dt)?;
                    if let Some(window) = &mut window {
                        self.drive_on(window, &commands, k, dt)?;
                    }
                }
                Ok(())
            },
        )?;
        let layout = self.machine.motion.layout();
        let heat = |drive| layout.heat(drive).map_or(0.0, |heat| state.xi[heat]);
        prediction.heats = (0..self.machine.motion.assembly().drives.len()).map(heat).collect();
        for (channel, signal) in self.dataset.channels.iter().zip(&signals) {
            let (read, smooth, dead_zone) = match channel.source {
                Source::Sensor(i) => {
                    let sensor = &self.machine.motion.assembly().sensors[i];
                    let smooth = readings(sensor, signal, dt, false);
                    let step = sensor.resolutions.iter().copied().fold(0.0, f64::max);
                    if step > COARSE * channel.noise {
                        (readings(sensor, signal, dt, true), smooth, 0.5 * step)
                    } else {
                        (smooth.clone(), smooth, 0.0)
                    }
                }
                _ => (signal.clone(), signal.clone(), 0.0),
            };
            prediction.series.push(read);
            prediction.smooth.push(smooth);
            prediction.dead_zone.push(dead_zone);
        }
        Ok(prediction)
    }

    /// Commands after the static part of each drive's chain: dead band, gain and limit. For a servo, its
    /// targets.
    pub(super) fn effective_commands(&self) -> Vec<Vec<f64>> {
        let drives = &self.machine.motion.assembly().drives;
        self.dataset
            .drives
            .iter()
            .zip(&self.record.commands)
            .enumerate()
            .map(|(i, (driven, commands))| {
                let drive = driven.drive;
                let is_reference = self.has_controller(drive);
                let of =
                    |&command: &f64| if is_reference { command } else { drives[drive].received(command) };
                let commands: Vec<f64> = commands.iter().map(of).collect();
                if self.dataset.is_sampled(i) {
                    means_between_rows(&commands, self.late_rows)
                } else {
                    commands
                }
            })
            .collect()
    }

    /// Whether a controller commands a drive. The recorded command is then the reference of the controller.
    fn has_controller(&self, drive: usize) -> bool {
        self.servos.iter().any(|servo| servo.is_controller && servo.drive == drive)
    }

    /// Advances from row `k` to the next, through the commands that arrive in between because of a delay.
    #[inline(always)]
    pub(super) fn drive_on(
        &mut self,
        state: &mut State,
        commands: &[Vec<f64>],
        k: usize,
        dt: f64,
    ) -> Result<(), DiagnosisError> {
        if !self.servos.is_empty() {
            return self.drive_on_sampled(state, commands, k, dt);
        }
        let mut is_delayed = false;
        for (&Driven { drive, .. }, commands) in self.dataset.drives.iter().zip(commands) {
            let delay = self.machine.motion.assembly().drives[drive].delay / dt;
            let whole = delay.floor() as usize;
            // A negligible part of a row would only prevent reusing exponentials.
            let is_part = delay - whole as f64 > NEGLIGIBLE_PART;
            is_delayed |= is_part;
            let back = whole + usize::from(is_part);
            self.machine.set_input(state, drive, self.command_at(drive, commands, k.checked_sub(back)));
        }
        if is_delayed {
            self.drive_on_delayed(state, commands, k, dt)
        } else {
            self.machine.advance(state, dt)
        }
    }

    /// The command of a row. Before the first row, a servo has its first target and other drives have zero.
    fn command_at(&self, drive: usize, commands: &[f64], row: Option<usize>) -> f64 {
        let is_servo = self.machine.motion.assembly().drives[drive].servo.is_some();
        let before = if is_servo { commands[0] } else { 0.0 };
        row.map_or(before, |row| commands[row])
    }

    /// Advances from row `k` to the next with servos: through their samples and outputs, and the commands
    /// that arrive in between.
    fn drive_on_sampled(
        &mut self,
        state: &mut State,
        commands: &[Vec<f64>],
        k: usize,
        dt: f64,
    ) -> Result<(), DiagnosisError> {
        let row = RowSpan {
            start_s: k as f64 * dt,
            span_s: dt,
            rounds: self.machine.precision != Precision::Rounding,
        };
        let mut arrivals: Vec<(f64, usize, f64)> = Vec::new();
        for (&Driven { drive, .. }, commands) in self.dataset.drives.iter().zip(commands) {
            let part = &self.machine.motion.assembly().drives[drive];
            let late = if self.has_controller(drive) { 0.0 } else { part.received_late() / dt };
            let whole = late.floor();
            let part_s = row.part_s(row.start_s + (late - whole) * dt);
            let back = whole as usize + usize::from(part_s.is_none_or(|part_s| part_s > 0.0));
            arrivals.push((0.0, drive, self.command_at(drive, commands, k.checked_sub(back))));
            if let Some(part_s) = part_s.filter(|part_s| *part_s > 0.0) {
                arrivals.push((
                    part_s,
                    drive,
                    self.command_at(drive, commands, k.checked_sub(whole as usize)),
                ));
            }
        }
        let mut now_s = 0.0;
        loop {
            for &(_, drive, value) in arrivals.iter().filter(|(at_s, ..)| *at_s <= now_s) {
                let mut loops = self.servos.iter().zip(&mut state.loops);
                if !loops.any(|(servo, held)| servo.takes(held, drive, value)) {
                    self.machine.set_input(state, drive, value);
                }
            }
            arrivals.retain(|(at_s, ..)| *at_s > now_s);
            serve(&self.servos, &mut self.machine, state, &row, now_s);
            let arrival_s = arrivals.iter().map(|(at_s, ..)| *at_s).min_by(f64::total_cmp);
            let next = [next_s(&self.servos, &self.machine, state, &row), arrival_s];
            let Some(next_s) = next.into_iter().flatten().min_by(f64::total_cmp) else { break };
            self.machine.advance(state, next_s - now_s)?;
            now_s = next_s;
        }
        self.machine.advance(state, dt - now_s)
    }

    #[inline(always)]
    fn drive_on_delayed(
        &mut self,
        state: &mut State,
        commands: &[Vec<f64>],
        k: usize,
        dt: f64,
    ) -> Result<(), DiagnosisError> {
        let mut arrivals: Vec<(f64, usize, f64)> = Vec::new();
        for (&Driven { drive, .. }, commands) in self.dataset.drives.iter().zip(commands) {
            let delay = self.machine.motion.assembly().drives[drive].delay / dt;
            let whole = delay.floor() as usize;
            let part = delay - whole as f64;
            if part > NEGLIGIBLE_PART {
                arrivals.push((part * dt, drive, self.command_at(drive, commands, k.checked_sub(whole))));
            }
        }
        arrivals.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut now, mut arrivals) = (0.0, arrivals.into_iter());
        loop {
            let next = arrivals.next();
            let until = next.map_or(dt, |(at, ..)| at);
            if until > now {
                self.machine.advance(state, until - now)?;
                now = until;
            }
            let Some((_, drive, value)) = next else { return Ok(()) };
            self.machine.set_input(state, drive, value);
        }
    }
}
