//! The loops of sampled servos along a record: they run inside the prediction, as they do in the machine.

use std::collections::VecDeque;

use feeler_control::{Controller, Inputs};
use feeler_engine::servo_spec;
use feeler_plant::assembly::{Assembly, Source, TargetChain};
use feeler_plant::description::Quantity;
use feeler_plant::motion::dot;
use feeler_problem::{Problem, Remedy};

use super::machine::{Moving, State};
use crate::error::DiagnosisError;

/// Parts of a row at which a fit lets a servo sample. Spans between them recur, so that their exponentials
/// are computed once. A sample is at most 1/2000 of a row early or late.
const PARTS: f64 = 1000.0;

/// What never changes of one servo.
#[derive(Clone, Debug)]
pub(super) struct ServoLoop {
    pub(super) drive: usize,
    period_s: f64,
    delay_s: f64,
    resolution: f64,
    target: TargetChain,
    start: LoopState,
}

/// Where one servo is.
#[derive(Clone, Debug)]
pub(super) struct LoopState {
    controller: Controller<f64>,
    target: f64,
    followed: f64,
    samples: u64,
    /// Outputs under way: when they arrive, and what they are.
    pending: VecDeque<(f64, f64)>,
}

impl LoopState {
    /// A target arrives.
    pub(super) fn aim(&mut self, target: f64) {
        self.target = target;
    }
}

/// The sampled servos of a machine, whose first targets are where they stand.
pub(super) fn loops(assembly: &Assembly) -> Result<Vec<ServoLoop>, DiagnosisError> {
    let mut found = Vec::new();
    for (drive, part) in assembly.drives.iter().enumerate() {
        let (Some(spec), Some(sampling)) = (servo_spec(part), part.sampling()) else { continue };
        let (period_s, delay_s) = (spec.period_s, spec.delay_s);
        let controller = Controller::new(&[spec]).map_err(|error| {
            let key = format!("actuators.{}", part.name);
            DiagnosisError::Machine { problems: vec![Problem::new(key, error.to_string(), error.remedy())] }
        })?;
        let stands = assembly.nodes[part.on].position_m - assembly.nodes[part.reacts_on].position_m;
        let pending = VecDeque::new();
        found.push(ServoLoop {
            drive,
            period_s,
            delay_s,
            resolution: sampling.resolution.unwrap_or(0.0),
            target: sampling.target,
            start: LoopState { controller, target: stands, followed: stands, samples: 0, pending },
        });
    }
    Ok(found)
}

/// The servos at the start of a record.
pub(super) fn at_start(loops: &[ServoLoop]) -> Vec<LoopState> {
    loops.iter().map(|servo| servo.start.clone()).collect()
}

/// A row, on its way.
pub(super) struct Row {
    /// When it began, s.
    pub(super) start_s: f64,
    /// Until the next one, s.
    pub(super) span_s: f64,
    /// Whether its parts are rounded, so that they recur.
    pub(super) rounds: bool,
}

impl Row {
    /// How far into the row an instant is, s. Zero if it is due already, `None` if it is not in this row.
    pub(super) fn part_s(&self, t_s: f64) -> Option<f64> {
        let share = (t_s - self.start_s) / self.span_s;
        let share = if self.rounds { (share * PARTS).round() / PARTS } else { share };
        (share < 1.0 - 1e-9).then_some(share.max(0.0) * self.span_s)
    }
}

/// The next instant of a row at which a servo does something, how far into the row it is, s.
pub(super) fn next_s(loops: &[ServoLoop], state: &State, row: &Row) -> Option<f64> {
    let of = |(servo, held): (&ServoLoop, &LoopState)| {
        let sample_s = row.part_s(held.samples as f64 * servo.period_s);
        let arrival_s = held.pending.front().and_then(|(t_s, _)| row.part_s(*t_s));
        [sample_s, arrival_s].into_iter().flatten().min_by(f64::total_cmp)
    };
    loops.iter().zip(&state.loops).filter_map(of).min_by(f64::total_cmp)
}

/// Everything that the servos do `now_s` into a row: outputs arrive, then samples are taken.
pub(super) fn serve(loops: &[ServoLoop], machine: &mut Moving, state: &mut State, row: &Row, now_s: f64) {
    let is_due = |t_s: f64| row.part_s(t_s).is_some_and(|part_s| part_s <= now_s);
    for (i, servo) in loops.iter().enumerate() {
        while let Some(&(_, output)) = state.loops[i].pending.front().filter(|(t_s, _)| is_due(*t_s)) {
            state.loops[i].pending.pop_front();
            machine.set_input(state, servo.drive, output);
        }
        while is_due(state.loops[i].samples as f64 * servo.period_s) {
            let sample_s = state.loops[i].samples as f64 * servo.period_s;
            let stroke = machine.signal(state, Source::Drive(servo.drive, Quantity::Position));
            let output = servo.sample(&mut state.loops[i], sample_s, dot(&stroke, &state.xi));
            if servo.delay_s > 0.0 {
                state.loops[i].pending.push_back((sample_s + servo.delay_s, output));
            } else {
                machine.set_input(state, servo.drive, output);
            }
        }
    }
}

impl ServoLoop {
    fn sample(&self, held: &mut LoopState, sample_s: f64, stroke: f64) -> f64 {
        let step = self.resolution;
        let reading = if step > 0.0 { (stroke / step).round() * step } else { stroke };
        let most = self.target.rate_limit * self.period_s;
        held.followed += (held.target - held.followed).clamp(-most, most);
        let error = held.followed - reading;
        let unseen = self.target.error_deadband;
        let reference = reading + (error - error.clamp(-unseen, unseen));
        held.samples += 1;
        let inputs = Inputs { reading, motion: 0.0, motion_is_velocity: false };
        held.controller.sample(sample_s, &inputs, reference)
    }
}
