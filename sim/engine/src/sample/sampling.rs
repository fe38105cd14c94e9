//! Actions at instants: gaps advance, delayed readings are taken, controllers sample, commands arrive.

use feeler_lanes::Lane;

use crate::carry::lanes::Lanes;
use crate::error::EngineError;
use crate::run::program::Program;
use crate::sample::clock::{GapClock, due};
use crate::sample::control_loop::SampledController;
use crate::sample::drive::DriveChain;
use crate::sample::sampler::Sampler;
use crate::sample::sensing::Sensing;
use crate::sample::servo_loop::ServoLoop;

/// Controllers, drives and sensors of every lane.
#[derive(Debug)]
pub(crate) struct Sampling<L: Lane> {
    loops: Vec<SampledController<L>>,
    drives: Vec<DriveChain<L>>,
    servos: Vec<ServoLoop<L>>,
    sensors: Vec<Sensing<L>>,
    /// One per moving gap or body.
    gaps: Vec<GapClock>,
    /// Whether any output or command has a delay.
    any_late: bool,
    /// Whether any controller reads a delayed sensor.
    any_delayed: bool,
}

impl<L: Lane> Sampling<L> {
    pub(crate) fn new(programs: &[Program]) -> Result<Self, EngineError> {
        let first = &programs[0];
        let assembly = first.motion.assembly();
        let parts = |i: usize| programs.iter().map(|p| &p.motion.assembly().drives[i]).collect::<Vec<_>>();
        let drives: Vec<DriveChain<L>> =
            (0..assembly.drives.len()).map(|i| DriveChain::new(&parts(i), first.run.seed)).collect();
        let parts = |i: usize| programs.iter().map(|p| &p.motion.assembly().sensors[i]).collect::<Vec<_>>();
        let sensors: Vec<Sensing<L>> =
            (0..assembly.sensors.len()).map(|i| Sensing::new(&parts(i), first.run.seed)).collect();
        let loops = (0..first.controllers.len())
            .map(|i| SampledController::new(programs, i, &sensors))
            .collect::<Result<Vec<_>, _>>()?;
        let servos = (0..first.servos.len())
            .map(|i| ServoLoop::new(programs, i, &sensors))
            .collect::<Result<Vec<_>, _>>()?;
        let gaps = assembly.contacts.iter().filter_map(|contact| contact.profile.as_deref());
        let profiles = gaps.chain(assembly.drives.iter().filter_map(|drive| drive.imposed.as_deref()));
        Ok(Self {
            gaps: profiles.map(GapClock::new).collect(),
            any_late: loops.iter().any(|control| control.sampler.is_late())
                || servos.iter().any(|servo| servo.sampler.is_late())
                || drives.iter().any(|drive| drive.delay_s > 0.0),
            any_delayed: loops.iter().any(|control| control.sampler.is_delayed()),
            loops,
            drives,
            servos,
            sensors,
        })
    }

    /// When something is due that changes the motion or reads it, s.
    #[inline(always)]
    pub(crate) fn next_instant_s(&self) -> f64 {
        let mut next = f64::INFINITY;
        for control in &self.loops {
            next = earlier(next, control.sampler.next_sample_s);
        }
        for servo in &self.servos {
            next = earlier(next, servo.sampler.next_sample_s);
        }
        if self.any_late {
            next = self.servos.iter().fold(next, |next, servo| earlier(next, servo.sampler.next_arrival_s()));
            next =
                self.loops.iter().fold(next, |next, control| earlier(next, control.sampler.next_arrival_s()));
            next = self.drives.iter().fold(next, |next, drive| earlier(next, drive.next_arrival_s()));
        }
        self.gaps.iter().fold(next, |next, gap| earlier(next, gap.next_s()))
    }

    /// When the next signal for a delayed reading is due, s.
    #[inline(always)]
    pub(crate) fn next_take_s(&self) -> f64 {
        self.earliest_take(Sampler::next_take_s)
    }

    /// When the first of these signals later than `t_s` is due, s; not later if that is not known yet.
    #[inline(always)]
    pub(crate) fn take_after_s(&self, t_s: f64) -> f64 {
        self.earliest_take(|sampler| sampler.take_after_s(t_s))
    }

    #[inline(always)]
    fn earliest_take(&self, of: impl Fn(&Sampler<L>) -> f64) -> f64 {
        let takes = self.loops.iter().map(|control| of(&control.sampler));
        if self.any_delayed { takes.fold(f64::INFINITY, earlier) } else { f64::INFINITY }
    }

    /// The signals that delayed readings take.
    pub(crate) fn delayed_signals(&self) -> impl Iterator<Item = usize> {
        self.loops.iter().flat_map(|control| control.sampler.delayed_signals())
    }

    /// Gaps whose pieces end now continue with the next.
    #[inline(always)]
    pub(crate) fn move_gaps(&mut self, lanes: &mut Lanes<L>) {
        let mut moved = false;
        for gap in &mut self.gaps {
            moved |= gap.advance(lanes.time_s());
        }
        if moved {
            lanes.move_gaps();
        }
    }

    /// Takes the signals of `t_s` that delayed readings will need.
    #[inline(always)]
    pub(crate) fn take_delayed(&mut self, t_s: f64, signals: &[L]) {
        if self.any_delayed {
            // A loop and no closure, so that it is inlined into the kernel.
            for control in &mut self.loops {
                control.sampler.take_delayed(t_s, signals);
            }
        }
    }

    /// Samples the controllers that are due; returns whether there was one.
    #[inline(always)]
    pub(crate) fn sample(&mut self, lanes: &mut Lanes<L>) -> Result<bool, EngineError> {
        let mut sampled = false;
        for i in 0..self.loops.len() {
            while due(self.loops[i].sampler.next_sample_s, lanes.time_s()) {
                let output = self.loops[i].sample(lanes.time_s(), lanes.signals(), &self.sensors);
                if let Some(output) = output {
                    self.apply(i, output, lanes)?;
                }
                sampled = true;
            }
        }
        Ok(sampled)
    }

    /// Applies outputs and delayed commands that arrive now.
    #[inline(always)]
    pub(crate) fn arrivals(&mut self, lanes: &mut Lanes<L>) -> Result<(), EngineError> {
        if !self.any_late {
            return Ok(());
        }
        for i in 0..self.loops.len() {
            while let Some(output) = self.loops[i].sampler.arrive(lanes.time_s()) {
                self.apply(i, output, lanes)?;
            }
        }
        for i in 0..self.drives.len() {
            while due(self.drives[i].next_arrival_s(), lanes.time_s()) {
                if let Some(input) = self.drives[i].arrive() {
                    self.take(i, input, lanes)?;
                }
            }
        }
        for servo in &mut self.servos {
            while let Some(output) = servo.sampler.arrive(lanes.time_s()) {
                lanes.set_input(servo.drive, output)?;
            }
        }
        Ok(())
    }

    /// Samples the servos that are due, with the targets of this instant.
    #[inline(always)]
    pub(crate) fn sample_servos(&mut self, lanes: &mut Lanes<L>) -> Result<(), EngineError> {
        for servo in &mut self.servos {
            while due(servo.sampler.next_sample_s, lanes.time_s()) {
                if let Some(output) = servo.sample(lanes.time_s(), lanes.signals(), &self.sensors) {
                    lanes.set_input(servo.drive, output)?;
                }
            }
        }
        Ok(())
    }

    /// Applies a command of drive `i`: a sampled servo gets a new target or another input of its loop, any
    /// other drive a new input.
    #[inline(always)]
    fn take(&mut self, i: usize, input: L, lanes: &mut Lanes<L>) -> Result<(), EngineError> {
        if self.servos.iter_mut().any(|servo| servo.takes(i, input)) {
            return Ok(());
        }
        lanes.set_input(i, input)
    }

    /// Applies the output of controller `i`; outputs of several controllers on one drive add.
    #[inline(always)]
    fn apply(&mut self, i: usize, output: L, lanes: &mut Lanes<L>) -> Result<(), EngineError> {
        self.loops[i].output = output;
        let drive = self.loops[i].drive;
        let command = if self.loops.len() == 1 { output } else { self.wanted_of(drive) };
        match self.drives[drive].issue(lanes.time_s(), command) {
            Some(input) => self.take(drive, input, lanes),
            None => Ok(()),
        }
    }

    /// Sum of the outputs of all controllers of a drive.
    fn wanted_of(&self, drive: usize) -> L {
        let mut command = L::zero();
        for control in self.loops.iter().filter(|control| control.drive == drive) {
            command += control.output;
        }
        command
    }

    pub(crate) fn sensors(&self) -> &[Sensing<L>] {
        &self.sensors
    }

    /// The command of drive `i` as issued.
    pub(crate) fn command(&self, i: usize) -> L {
        self.drives[i].command
    }

    /// The output of controller `i` as applied.
    pub(crate) fn output(&self, i: usize) -> L {
        self.loops[i].output
    }

    /// The reference of controller `i` at its last sample.
    pub(crate) fn reference(&self, i: usize) -> L {
        self.loops[i].reference
    }

    pub(crate) fn names(&self) -> Vec<String> {
        self.loops.iter().map(|control| control.name.clone()).collect()
    }

    /// Whether some controller of lane `l` was in its approach at its last sample.
    pub(crate) fn is_approaching(&self, l: usize) -> bool {
        self.loops.iter().any(|control| control.sampler.is_approaching(l))
    }

    /// Charges each controller with its command times the stroke of the interval; `before` are the strokes at
    /// its start.
    pub(crate) fn charge(&self, before: &[Vec<f64>], lanes: &mut Lanes<L>) {
        let after = lanes.strokes();
        for (l, (before, after)) in before.iter().zip(&after).enumerate() {
            let works_j = self.loops.iter().map(|control| {
                let stroke_m = after[control.drive] - before[control.drive];
                if control.drives_force { control.output.lane(l) * stroke_m } else { 0.0 }
            });
            lanes.charge(l, works_j);
        }
    }
}

#[inline(always)]
pub(crate) fn earlier(next_s: f64, other_s: f64) -> f64 {
    if other_s < next_s { other_s } else { next_s }
}
