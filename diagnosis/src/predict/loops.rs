//! The loops of sampled servos along a record, and those of controllers whose reference was recorded. They
//! are part of the prediction, as they are of the machine.

use feeler_control::Inputs;
use feeler_engine::parts::follow;
use feeler_engine::servo_spec;
use feeler_plant::assembly::{Assembly, Drive, SensorPart, Source, TargetChain};
use feeler_plant::description::Quantity;

use super::machine::Moving;
use super::sensor::{in_steps, reading};
use super::state::{LoopState, State};
use crate::dataset::Looped;
use crate::error::DiagnosisError;

/// Number of instants in a row at which a fit lets a servo sample. The spans between them recur, so that
/// their exponentials are computed once. A sample is at most 1/2000 of a row early or late.
const PARTS: f64 = 1000.0;

/// The constants of one loop.
#[derive(Clone, Debug)]
pub(super) struct PredictedLoop {
    pub(super) drive: usize,
    /// Whether the loop belongs to a controller, whose output passes through the chain of its drive.
    pub(super) is_controller: bool,
    period_s: f64,
    offset_s: f64,
    delay_s: f64,
    reads: Reads,
    /// Inputs in addition to the target: their drives, and force per unit.
    fed: Vec<(usize, f64)>,
    start: LoopState,
}

#[derive(Clone, Debug)]
enum Reads {
    /// The quantised stroke of the servo's drive, and the chain of its target.
    Stroke { resolution: f64, target: TargetChain },
    /// Sensors of the controlled quantity and of the motion that the law uses.
    Sensors { sensors: [Option<usize>; 2], motion_is_velocity: bool },
}

/// The sampled servos of a machine, whose first target is their position, and its controllers.
pub(super) fn loops(assembly: &Assembly, looped: &[Looped]) -> Result<Vec<PredictedLoop>, DiagnosisError> {
    let mut found =
        looped.iter().map(|own| PredictedLoop::of(own, assembly)).collect::<Result<Vec<_>, _>>()?;
    for (drive, part) in assembly.drives.iter().enumerate() {
        let (Some(spec), Some(sampling)) = (servo_spec(part), part.sampling()) else { continue };
        let (period_s, delay_s) = (spec.period_s, spec.delay_s);
        let stands = assembly.nodes[part.on].position_m - assembly.nodes[part.reacts_on].position_m;
        let resolution = sampling.resolution.unwrap_or(0.0);
        let fed = assembly
            .feeds_of(drive)
            .filter_map(|(input, feed)| Some((input, feed.gain(part.servo.as_ref()?))));
        found.push(PredictedLoop {
            drive,
            is_controller: false,
            period_s,
            offset_s: 0.0,
            delay_s,
            reads: Reads::Stroke { resolution, target: sampling.target },
            fed: fed.collect(),
            start: LoopState::of(spec, stands, &format!("actuators.{}", part.name))?,
        });
    }
    Ok(found)
}

/// States of the loops at the start of a record.
pub(super) fn at_start(loops: &[PredictedLoop]) -> Vec<LoopState> {
    loops.iter().map(|servo| servo.start.clone()).collect()
}

pub(super) struct RowSpan {
    pub(super) start_s: f64,
    /// Time until the next row, s.
    pub(super) span_s: f64,
    /// Whether instants are rounded, so that the spans between them recur.
    pub(super) rounds: bool,
}

impl RowSpan {
    /// Time from the start of the row to an instant, s. Zero if the instant has passed, `None` if it is after
    /// this row.
    pub(super) fn part_s(&self, t_s: f64) -> Option<f64> {
        let share = (t_s - self.start_s) / self.span_s;
        let share = if self.rounds { (share * PARTS).round() / PARTS } else { share };
        (share < 1.0 - 1e-9).then_some(share.max(0.0) * self.span_s)
    }
}

/// The next instant in a row at which a loop acts, as a time from the start of the row, s.
pub(super) fn next_s(loops: &[PredictedLoop], machine: &Moving, state: &State, row: &RowSpan) -> Option<f64> {
    let sensors = &machine.motion.assembly().sensors;
    let of = |(servo, held): (&PredictedLoop, &LoopState)| {
        let sample_s = row.part_s(servo.sample_s(held.samples));
        let arrival_s = held.pending.front().and_then(|(t_s, _)| row.part_s(*t_s));
        let takes = (0..2).filter_map(|which| row.part_s(servo.take_s(which, held, sensors)?));
        [sample_s, arrival_s].into_iter().flatten().chain(takes).min_by(f64::total_cmp)
    };
    loops.iter().zip(&state.loops).filter_map(of).min_by(f64::total_cmp)
}

/// Runs all loops at `now_s` into a row: outputs arrive, then samples are taken.
pub(super) fn serve(
    loops: &[PredictedLoop],
    machine: &mut Moving,
    state: &mut State,
    row: &RowSpan,
    now_s: f64,
) {
    let is_due = |t_s: f64| row.part_s(t_s).is_some_and(|part_s| part_s <= now_s);
    for (i, servo) in loops.iter().enumerate() {
        while let Some(&(_, output)) = state.loops[i].pending.front().filter(|(t_s, _)| is_due(*t_s)) {
            state.loops[i].pending.pop_front();
            machine.set_input(state, servo.drive, output);
        }
        for which in 0..2 {
            while let Some((sensor, _)) = servo
                .sensor(which)
                .zip(servo.take_s(which, &state.loops[i], &machine.motion.assembly().sensors))
                .filter(|(_, take_s)| is_due(*take_s))
            {
                let signal = machine.value(state, Source::Sensor(sensor));
                let (taken, count) = &mut state.loops[i].taken[which];
                taken.push_back(signal);
                *count += 1;
            }
        }
        while is_due(servo.sample_s(state.loops[i].samples)) {
            let sample_s = servo.sample_s(state.loops[i].samples);
            let output = match &servo.reads {
                Reads::Stroke { resolution, target } => {
                    let stroke = machine.value(state, Source::Drive(servo.drive, Quantity::Position));
                    servo.follow(&mut state.loops[i], sample_s, stroke, *resolution, target)
                }
                Reads::Sensors { motion_is_velocity, .. } => {
                    let [reading, motion] = [0, 1].map(|which| servo.read(which, i, machine, state));
                    let inputs = Inputs { reading, motion, motion_is_velocity: *motion_is_velocity };
                    let held = &mut state.loops[i];
                    held.samples += 1;
                    let output = held.controller.sample(sample_s, &inputs, held.target);
                    machine.motion.assembly().drives[servo.drive].held(output)
                }
            };
            if servo.delay_s > 0.0 {
                state.loops[i].pending.push_back((sample_s + servo.delay_s, output));
            } else {
                machine.set_input(state, servo.drive, output);
            }
        }
    }
}

impl PredictedLoop {
    /// The loop of a controller from the machine's file.
    fn of(looped: &Looped, assembly: &Assembly) -> Result<Self, DiagnosisError> {
        let Looped { name, drive, spec, motion_is_velocity, .. } = looped;
        let part: &Drive = &assembly.drives[*drive];
        let sensors = [looped.reading, looped.motion];
        Ok(Self {
            drive: *drive,
            is_controller: true,
            period_s: spec.period_s,
            offset_s: spec.offset_s,
            delay_s: spec.delay_s + part.received_late(),
            reads: Reads::Sensors { sensors, motion_is_velocity: *motion_is_velocity },
            fed: Vec::new(),
            start: LoopState::of(spec.clone(), 0.0, &format!("controllers.{name}"))?,
        })
    }

    /// Stores the command of a drive if it is the target or another input of this loop. Returns whether it
    /// is.
    pub(super) fn takes(&self, held: &mut LoopState, drive: usize, value: f64) -> bool {
        if drive == self.drive {
            let is_new = held.target.to_bits() != value.to_bits();
            if let (Reads::Stroke { target, .. }, true) = (&self.reads, is_new) {
                held.pace = target.pace(value - held.followed);
            }
            held.target = value;
            return true;
        }
        let Some((_, gain)) = self.fed.iter().find(|(input, _)| *input == drive) else { return false };
        held.fed.retain(|(input, _)| *input != drive);
        held.fed.push((drive, gain * value));
        true
    }

    fn sample_s(&self, sample: u64) -> f64 {
        self.offset_s + sample as f64 * self.period_s
    }

    fn sensor(&self, which: usize) -> Option<usize> {
        match &self.reads {
            Reads::Stroke { .. } => None,
            Reads::Sensors { sensors, .. } => sensors[which],
        }
    }

    /// Next instant at which the signal of a delayed sensor is stored; `None` for a sensor without delay.
    fn take_s(&self, which: usize, held: &LoopState, sensors: &[SensorPart]) -> Option<f64> {
        let delay_s = sensors[self.sensor(which)?].delay;
        (delay_s > 0.0).then(|| self.sample_s(held.taken[which].1) - delay_s)
    }

    /// The reading of a sensor at a sample; zero without a sensor.
    fn read(&self, which: usize, own: usize, machine: &Moving, state: &mut State) -> f64 {
        let Some(sensor) = self.sensor(which) else { return 0.0 };
        let part = &machine.motion.assembly().sensors[sensor];
        let taken = if part.delay > 0.0 { state.loops[own].taken[which].0.pop_front() } else { None };
        let signal = taken.unwrap_or_else(|| machine.value(state, Source::Sensor(sensor)));
        reading(part, signal, &part.resolutions)
    }

    fn follow(
        &self,
        held: &mut LoopState,
        sample_s: f64,
        stroke: f64,
        step: f64,
        target: &TargetChain,
    ) -> f64 {
        let reading = in_steps(stroke, step);
        let most = held.pace * self.period_s;
        let reference = follow(&mut held.followed, held.target, reading, most, target.error_deadband);
        held.samples += 1;
        let inputs = Inputs { reading, motion: 0.0, motion_is_velocity: false };
        let fed = held.fed.iter().map(|(_, force)| force).sum();
        held.controller.sample_fed(sample_s, &inputs, reference, fed)
    }
}
