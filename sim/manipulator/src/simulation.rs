//! Simulation of an arm and its controller over time.

use feeler_arm::{JointDrive, Reduction};
use feeler_catalogue::Tabled;
use feeler_engine::parts::{Sensing, Tap, due};
use feeler_engine::{Program, RunEnd, RunSettings, Trace};
use feeler_plant::assembly::{Assembly, Source};
use feeler_plant::description::{Contact, Quantity};
use nalgebra::{DVector, Vector3};

use crate::bodies::numbers;
use crate::cell::{Cell, farthest_m};
use crate::error::ManipulatorError;
use crate::evaluation::Plant;
use crate::mode::CellMode;
use crate::record::{CellRecord, names, note, note_limits, put};
use crate::sampling::{Control, Drives};
use crate::state::{CellLayout, filtered};
use crate::stepping::{advance, settle};

/// Step over the time in which the fastest mode turns by a radian or decays by 1/e.
const STEP_SHARE: f64 = 0.4;
/// The share for the longest step; classical Runge-Kutta is stable up to 2.78.
const LONGEST_SHARE: f64 = 2.5;
/// Compression at which a nonlinear contact is linearised, m.
const TYPICAL_DEPTH_M: f64 = 1e-4;
/// Joint positions beyond which a motion has diverged, rad or m.
const BOUND: f64 = 1e6;

/// End of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finished {
    /// How the run ended; `None` while it goes on.
    pub end: Option<RunEnd>,
    /// Simulated time reached, s.
    pub end_s: f64,
    pub steps: u64,
}

/// A running simulation of a cell.
#[derive(Debug)]
pub struct CellSimulation {
    plant: Plant,
    assembly: Assembly,
    x: DVector<f64>,
    mode: CellMode,
    inputs: Vec<f64>,
    control: Control,
    drives: Drives,
    encoders: Vec<Sensing<f64>>,
    sensors: Vec<Sensing<f64>>,
    home_m: Vector3<f64>,
    t_s: f64,
    duration_s: f64,
    step_s: f64,
    steps: u64,
    record_taps: Vec<Tap<f64>>,
    rate_hz: f64,
    every: u64,
    rows: u64,
    record: CellRecord,
    /// Per link, the position limit that it exceeds: -1 the lower, 1 the upper, 0 none.
    beyond: Vec<i8>,
}

/// Largest number of steps of a run: about ten minutes of work.
const MOST_STEPS: f64 = 1e7;
/// Shortest step, s: ten milliseconds are then some seconds of work.
const SHORTEST_S: f64 = 1e-7;

impl CellSimulation {
    /// A cell at its start. It records the measures at `rate_hz` and the motion at every `every`th of its
    /// rows.
    ///
    /// # Errors
    /// Mistakes of arm, shapes, wiring and controller; see [`ManipulatorError`].
    pub fn new(cell: &Cell, rate_hz: f64, every: u64) -> Result<Self, ManipulatorError> {
        let program = Program::new(&cell.scenario)?;
        let assembly = program.motion().assembly().clone();
        let contact = match assembly.contacts.as_slice() {
            [contact] => contact.clone(),
            more => return Err(ManipulatorError::Count { what: "contact", count: more.len() }),
        };
        let reduction = cell.reduction()?;
        let (seed, start) = (program.settings().seed, &cell.start);
        let layout = CellLayout::new(&cell.joints, &assembly.sensors);
        let plant = Plant {
            arm: cell.arm.clone(),
            joints: cell.joints.clone(),
            pair: cell.pair()?,
            law: contact.law,
            gap_m: contact.gap,
            sensors: assembly.sensors.clone(),
            normal: cell.unit_normal(),
            layout,
        };
        let step_s = step_s(cell, &plant, &reduction)?;
        let n = cell.joints.len();
        let mut x = DVector::zeros(plant.layout.length);
        for i in 0..n {
            let speed = reduction.direction[i] * start.speed_m_per_s;
            for (at, value) in
                [(i, start.pose[i]), (n + i, start.pose[i]), (2 * n + i, speed), (3 * n + i, speed)]
            {
                x[at] = value;
            }
        }
        let inputs = vec![0.0; n];
        let mut mode = plant.first_mode(&x, &inputs);
        settle(&plant, &mut x, &mut mode, &inputs, |_, _| {});
        let names = names(cell, &assembly);
        let sensing = |parts: &[&feeler_plant::assembly::SensorPart], seed| {
            parts.iter().map(|part| Sensing::new(&[*part], seed)).collect::<Vec<_>>()
        };
        let sensors = sensing(&assembly.sensors.iter().collect::<Vec<_>>(), seed);
        Ok(Self {
            control: Control::new(cell, &program, &sensors)?,
            drives: Drives::new(cell, seed),
            encoders: sensing(&cell.joints.iter().map(|joint| &joint.encoder).collect::<Vec<_>>(), seed),
            sensors,
            record_taps: assembly
                .sensors
                .iter()
                .enumerate()
                .map(|(i, sensor)| Tap::new(i, sensor.delay, 0.0))
                .collect(),
            home_m: cell.arm.chain().tool_place(&start.pose).translation.vector,
            record: CellRecord {
                measures: Trace::new(&names[0]),
                motion: Trace::new(&names.concat()),
                joint_events: Vec::new(),
            },
            plant,
            assembly,
            x,
            mode,
            inputs,
            t_s: 0.0,
            duration_s: cell.scenario.run.duration_s,
            step_s,
            steps: 0,
            rate_hz,
            every: every.max(1),
            rows: 0,
            beyond: vec![0; n],
        })
    }

    /// Longest step that is taken, s.
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// Simulated time, s.
    pub fn time_s(&self) -> f64 {
        self.t_s
    }

    /// Joint positions of the links, rad or m.
    pub fn links(&self) -> &[f64] {
        self.plant.layout.links(&self.x)
    }

    /// The axis along the normal, effects applied.
    pub fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// Whether the controller is still in its approach and waits for its contact force.
    pub fn is_approaching(&self) -> bool {
        self.control.is_approaching()
    }

    /// Whether the tool can reach the workpiece by continuing along the normal. The workpiece is on its path,
    /// and no joint is at the end of its travel.
    pub fn has_a_way(&self) -> bool {
        let tool = self.plant.arm.chain().tool_place(self.plant.layout.links(&self.x));
        let (position, turn) = numbers(&tool);
        let ahead = self.plant.pair.travel_m(
            position,
            turn,
            self.plant.normal.into(),
            farthest_m(self.plant.arm.chain()),
        );
        matches!(ahead, Ok(Some(_))) && self.beyond.iter().all(|side| *side == 0)
    }

    /// Penetration of tip and workpiece at the present time, m (negative across a gap), and its rate, m/s.
    /// Also its acceleration, m/s2 (without the rotation of the normal). `None` if they are far apart.
    pub fn compression(&self) -> Option<[f64; 3]> {
        self.plant.compression(&self.x, &self.mode, &self.inputs)
    }

    /// The record so far.
    pub fn into_record(self) -> CellRecord {
        self.record
    }

    /// Continues to an instant; actions due there are executed at the next call, or at the end of the run.
    pub fn run_to(&mut self, until_s: f64) -> Finished {
        let end = loop {
            self.serve();
            let next_s = self.next_instant_s().min(until_s);
            if next_s > self.t_s && self.span(next_s - self.t_s).is_none() {
                break Some(RunEnd::Diverged { t_s: self.t_s });
            }
            self.t_s = next_s.max(self.t_s);
            if due(until_s, self.t_s) {
                break due(self.duration_s, self.t_s).then_some(RunEnd::Completed);
            }
        };
        Finished { end, end_s: self.t_s, steps: self.steps }
    }

    /// Executes the actions that are due at the end of a run.
    pub fn finish(&mut self) {
        self.serve();
    }

    fn next_record_s(&self) -> f64 {
        self.rows as f64 / self.rate_hz
    }

    fn next_instant_s(&self) -> f64 {
        let taps = self.record_taps.iter().map(|tap| tap.next_s);
        taps.fold(
            self.next_record_s().min(self.control.next_instant_s()).min(self.drives.next_instant_s()),
            f64::min,
        )
    }

    /// Steps over a span with held inputs.
    fn span(&mut self, span_s: f64) -> Option<()> {
        let count = (span_s / self.step_s - 1e-9).ceil().max(1.0) as u64;
        let h = span_s / count as f64;
        let Self { plant, x, mode, inputs, record, t_s, beyond, .. } = self;
        settle(plant, x, mode, inputs, |change, states| note(record, *t_s, change, states));
        for i in 0..count {
            let begins_s = *t_s + i as f64 * h;
            advance(plant, x, h, mode, inputs, |after, change, states| {
                note(record, begins_s + after, change, states);
            })?;
            let now = plant.beyond(x);
            note_limits(record, begins_s + h, beyond, &now);
            *beyond = now;
        }
        self.steps += count;
        let bounded = self
            .plant
            .layout
            .motors(&self.x)
            .iter()
            .chain(self.plant.layout.links(&self.x))
            .all(|q| q.abs() < BOUND);
        bounded.then_some(())
    }

    /// Serves every instant that is due, in the order of the engine: readings, samples of the controller,
    /// records, arrivals of commands.
    fn serve(&mut self) {
        let t_s = self.t_s;
        let samples = due(self.control.next_s(), t_s);
        let recorded = due(self.next_record_s(), t_s);
        let taken = due(self.control.next_instant_s(), t_s)
            || self.record_taps.iter().any(|tap| due(tap.next_s, t_s));
        if taken || recorded {
            let motors: Vec<f64> = self
                .encoders
                .iter()
                .zip(self.plant.layout.motors(&self.x))
                .map(|(encoder, position)| encoder.read(t_s, *position))
                .collect();
            let signals = self.signals(&motors);
            self.control.take(t_s, &signals);
            let rate_hz = self.rate_hz;
            for tap in &mut self.record_taps {
                tap.take(t_s, signals[tap.signal], |k| k as f64 / rate_hz);
            }
            if samples
                && let Some(torques) =
                    self.control.sample(t_s, &self.plant.arm, [&signals, &motors], &self.sensors)
            {
                self.drives.issue(t_s, &torques, &mut self.inputs);
            }
        }
        while let Some(torques) = self.control.arrive(t_s) {
            self.drives.issue(t_s, &torques, &mut self.inputs);
        }
        self.drives.arrivals(t_s, &mut self.inputs);
        if recorded {
            self.put_row();
        }
    }

    /// Signal of each sensor after its filters and before its delay.
    fn signals(&self, motors: &[f64]) -> Vec<f64> {
        let plant = &self.plant;
        let now = plant.evaluate(&self.x, &self.mode, &self.inputs);
        let way =
            || plant.normal.dot(&(plant.arm.chain().tool_place(motors).translation.vector - self.home_m));
        let speed = || {
            let jacobian = plant.arm.chain().jacobian(plant.layout.motors(&self.x));
            let speeds = DVector::from_column_slice(plant.layout.motor_speeds(&self.x));
            plant.normal.dot(&(jacobian.rows(0, 3) * speeds))
        };
        (plant.sensors.iter().zip(&plant.layout.filters))
            .map(|(sensor, &first)| match sensor.source {
                Source::Node(_, Quantity::Velocity) => speed(),
                Source::Node(..) => way(),
                _ => filtered(&sensor.filters, first, &self.x, plant.source(sensor, &now), None),
            })
            .collect()
    }

    fn put_row(&mut self) {
        let now = self.plant.evaluate(&self.x, &self.mode, &self.inputs);
        let touch = now.touch.as_ref();
        let mut row = vec![
            now.force_n,
            now.spring_n,
            touch.map_or(f64::NAN, |touch| touch.depth),
            f64::from(u8::from(self.mode.touches())),
            self.control.output,
            self.control.output,
            self.control.wanted,
            f64::from(u8::from(self.drives.limited())),
        ];
        for (sensor, tap) in self.sensors.iter().zip(&mut self.record_taps) {
            row.push(sensor.read(self.t_s, tap.pop()));
        }
        put(&mut self.record.measures, self.t_s, &row);
        if self.rows.is_multiple_of(self.every) {
            let layout = &self.plant.layout;
            for (i, torque) in now.drive.iter().enumerate() {
                let of = |values: &[f64]| values[i];
                row.extend([
                    of(layout.links(&self.x)),
                    of(layout.motors(&self.x)),
                    of(layout.link_speeds(&self.x)),
                    *torque,
                ]);
            }
            let tool = now.posture.tool();
            let (place, turn) = (tool.translation.vector, tool.rotation.scaled_axis());
            let point = touch.map_or([f64::NAN; 3], |touch| touch.point_m);
            let normal = touch.map_or([f64::NAN; 3], |touch| touch.normal.into());
            row.extend(place.iter().chain(turn.iter()).chain(&point).chain(&normal));
            put(&mut self.record.motion, self.t_s, &row);
        }
        self.rows += 1;
    }
}

/// The longest step: as requested, or a share of the fastest mode's time.
fn step_s(cell: &Cell, plant: &Plant, reduction: &Reduction) -> Result<f64, ManipulatorError> {
    let law = plant.law;
    let stiffness = law.stiffness * law.exponent * TYPICAL_DEPTH_M.powf(law.exponent - 1.0);
    let modes = cell.arm.modes_in_contact(
        &cell.start.pose,
        cell.start.normal,
        feeler_arm::Others::Free,
        stiffness,
    )?;
    let of_modes = modes
        .iter()
        .map(|mode| std::f64::consts::TAU * mode.frequency_hz * (1.0 + 2.0 * mode.damping_ratio))
        .fold(0.0, f64::max);
    let drives = || plant.joints.iter().map(|joint| &joint.drive);
    let heats = drives().filter_map(|drive| drive.warming).map(|winding| winding.time_constant);
    let lags = drives().flat_map(|drive| drive.lags.iter().copied());
    let of_drives = lags.chain(heats).map(|tau| 1.0 / tau).fold(0.0, f64::max);
    let of_contact = law.damping / reduction.link_mass_kg;
    let rate_per_s = of_modes.max(of_drives).max(of_contact).max(1.0);
    let step_s = match cell.step_s {
        None => STEP_SHARE / rate_per_s,
        Some(step_s) if step_s * rate_per_s <= LONGEST_SHARE => step_s,
        Some(step_s) => {
            return Err(ManipulatorError::Step { step_s, rate_per_s, most_s: LONGEST_SHARE / rate_per_s });
        }
    };
    let duration_s = cell.scenario.run.duration_s;
    let steps = duration_s / step_s;
    let most = MOST_STEPS.min(duration_s / SHORTEST_S);
    if steps > most {
        let (what, key) = fastest(cell, [of_modes, of_drives, of_contact]);
        return Err(ManipulatorError::Work { what, key, step_s, duration_s, steps, most });
    }
    Ok(step_s)
}

/// The cause of short steps, in words and as a key.
fn fastest(cell: &Cell, [of_modes, of_drives, of_contact]: [f64; 3]) -> (String, String) {
    if cell.step_s.is_some() {
        let key = RunSettings::key(&RunSettings::STEP);
        return (format!("`{key}`"), key);
    }
    if of_contact > of_modes.max(of_drives) {
        return ("the damping of the contact".into(), Contact::TABLE.into());
    }
    let reflected = cell.arm.reflected_inertia_kg_m2();
    // The rate of a rotor on its gear, which identifies a joint's own motion.
    let rate = |i: usize| {
        let drive = &cell.arm.drives()[i];
        (drive.stiffness_n_m_per_rad / reflected[i]).sqrt().max(drive.damping_n_m_s_per_rad / reflected[i])
    };
    let joint = (0..cell.joints.len()).max_by(|a, b| rate(*a).total_cmp(&rate(*b))).unwrap_or(0);
    let name = cell.arm.chain().joints[joint].name.clone();
    if of_drives > of_modes {
        return ("the fastest drive".into(), JointDrive::TABLE.into());
    }
    (format!("joint `{name}`, the lightest rotor on its gear,"), JointDrive::ROTOR_INERTIA.of(&name))
}
