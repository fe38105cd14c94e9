//! A linearised machine with its controllers.

use feeler_catalogue::{GainPart, Tabled};
use feeler_control::{ControllerSpec, Law};
use feeler_engine::{LoopWiring, Program, Scenario};
use feeler_plant::assembly::{Assembly, Source};
use feeler_plant::description::Actuator;
use nalgebra::DMatrix;

use crate::error::AnalysisError;
use crate::loops::gain_key::{leading_gain, with_gain};
use crate::machine::channel::{Reduction, reduce};
use crate::machine::linearise::{LinearMachine, OutputRow};
use crate::machine::prepare::View;

/// One controller, with the signals that it reads and drives.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopController {
    /// Name as in the file.
    pub name: String,
    /// Whether this is the loop of a sampled servo; its name is then that of the actuator.
    pub is_servo: bool,
    /// Law, gains and timing.
    pub spec: ControllerSpec,
    /// Sensor that it controls.
    pub reading: Option<usize>,
    /// Sensor of position or velocity.
    pub motion: Option<usize>,
    /// Whether the motion sensor measures velocity rather than position.
    pub motion_is_velocity: bool,
    /// Drive that it commands.
    pub drive: usize,
    /// Index of the sampled servo's loop whose target this controller gives. The controller's output then
    /// reaches the drive through that loop only.
    pub aims_at: Option<usize>,
}

impl LoopController {
    /// The sensor through which the law closes its loop: the controlled quantity, or the motion if the law
    /// does not use that quantity.
    pub fn fed_back(&self) -> Option<usize> {
        let unused = matches!(self.spec.law, Law::Impedance(gains) if gains.force_gain == 0.0);
        self.reading.filter(|_| !unused).or(self.motion)
    }

    /// The sensor through which the loop of a gain closes. For an impedance's force gain it is the force
    /// sensor, even if the gain is zero; otherwise [`Self::fed_back`].
    pub(crate) fn sensor_of_gain(&self, gain: &str) -> Option<usize> {
        let on_reading = self.spec.law.gain(GainPart::Reading);
        let closes_there = on_reading.is_some_and(|own| own.key.name == gain);
        if closes_there { self.reading.or(self.motion) } else { self.fed_back() }
    }

    /// The sensor of the quantity that the reference prescribes and whose bandwidth is reported. Under an
    /// impedance it is the motion, since its reference is a position; otherwise the reading.
    pub fn controlled(&self) -> Option<usize> {
        if matches!(self.spec.law, Law::Impedance(_)) {
            self.motion.or(self.reading)
        } else {
            self.reading.or(self.motion)
        }
    }
}

/// A machine at an operating point with its controllers.
#[derive(Clone, Debug)]
pub struct ControlLoop {
    plant: LinearMachine,
    assembly: Assembly,
    view: View,
    controllers: Vec<LoopController>,
}

/// The plant from drives to the sensors in use, without idle states.
#[derive(Clone, Debug)]
pub(crate) struct LoopPlant {
    pub(crate) reduced: Reduction,
    /// Per controller: its reading and its motion sensor, over the reduced states.
    pub(crate) reading: Vec<Option<OutputRow>>,
    pub(crate) motion: Vec<Option<OutputRow>>,
}

/// The output of a broken loop.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Probe {
    /// The controller's output, negated by the convention of negative feedback.
    Law,
    Reading,
}

impl ControlLoop {
    /// Linearises a scenario.
    ///
    /// # Errors
    /// The mistakes of the scenario; [`AnalysisError::NoEquilibrium`].
    pub fn new(scenario: &Scenario, view: &View) -> Result<Self, AnalysisError> {
        Self::build(scenario, view, false)
    }

    /// Linearises a scenario, with the open-loop commands of sampled servos as targets of the servos' loops.
    pub(crate) fn with_targets(scenario: &Scenario, view: &View) -> Result<Self, AnalysisError> {
        Self::build(scenario, view, true)
    }

    fn build(scenario: &Scenario, view: &View, with_targets: bool) -> Result<Self, AnalysisError> {
        let program = Program::new(scenario)?;
        let mut assembly = program.motion().stated().clone();
        for (i, drive) in assembly.drives.iter_mut().enumerate() {
            let mut commanding = program.loops().filter(|wiring| !wiring.is_servo && wiring.drive == i);
            drive.linearise_interpolation(commanding.next().map(|wiring| wiring.spec.period_s));
        }
        // A command for the target of a sampled servo acts on the servo's loop and not on the drive.
        let aims =
            |wiring: &LoopWiring<'_>| !wiring.is_servo && assembly.drives[wiring.drive].sampling().is_some();
        // A closed loop around the servo, and a response to another input than its target, are beyond linear
        // theory.
        let around = |wiring: &LoopWiring<'_>| {
            let drive = &assembly.drives[wiring.drive];
            let servo = drive.feeds.map_or(drive, |feed| &assembly.drives[feed.servo]);
            let is_beside = with_targets && drive.feeds.is_some();
            let is_outer = !wiring.is_servo && (wiring.spec.law != Law::OpenLoop || is_beside);
            (is_outer && servo.sampling().is_some())
                .then(|| AnalysisError::Cascade { name: wiring.name.into(), servo: servo.name.clone() })
        };
        if let Some(error) = program.loops().find_map(|wiring| around(&wiring)) {
            return Err(error);
        }
        let kept: Vec<_> = program.loops().filter(|wiring| with_targets || !aims(wiring)).collect();
        let loop_of = |drive: usize| kept.iter().position(|other| other.is_servo && other.drive == drive);
        let controllers = kept.iter().map(|wiring| LoopController {
            name: wiring.name.into(),
            is_servo: wiring.is_servo,
            spec: wiring.spec.clone(),
            reading: wiring.reading,
            motion: wiring.motion,
            motion_is_velocity: wiring.motion_is_velocity,
            drive: wiring.drive,
            aims_at: if aims(wiring) { loop_of(wiring.drive) } else { None },
        });
        let controllers = controllers.collect();
        let plant = LinearMachine::of_assembly(&scenario.machine, &assembly, view)?;
        Ok(Self { plant, assembly, view: *view, controllers })
    }

    /// Linearises a scenario so that the gain of a key can be varied. A controller that needs a motion sensor
    /// for that gain gets one, even if the gain is zero in the scenario.
    ///
    /// # Errors
    /// Those of [`Self::new`], [`AnalysisError::NoController`], [`AnalysisError::NoGain`], and a machine
    /// without such a sensor.
    pub fn varying(scenario: &Scenario, view: &View, key: &str) -> Result<Self, AnalysisError> {
        let mut whole = Self::new(scenario, view)?;
        let (controller, gain) = whole.gain_of_key(key)?;
        let own = &mut whole.controllers[controller];
        let with_one = with_gain(&own.spec, &gain, 1.0)?;
        if own.motion.is_none() && with_one.law.needs_motion() {
            let mut varied = scenario.clone();
            if let Some(varied) = varied.controllers.get_mut(&own.name) {
                varied.spec = with_one;
            }
            if let Some(wiring) = Program::new(&varied)?.loops().find(|wiring| wiring.name == own.name) {
                (own.motion, own.motion_is_velocity) = (wiring.motion, wiring.motion_is_velocity);
            }
        }
        Ok(whole)
    }

    /// The same controllers around another machine or with other timing.
    ///
    /// # Errors
    /// [`AnalysisError::NoEquilibrium`], and the mistakes of the new machine.
    pub fn altered(
        &self,
        change: impl FnOnce(&mut Assembly, &mut Vec<LoopController>),
    ) -> Result<Self, AnalysisError> {
        let (mut assembly, mut controllers) = (self.assembly.clone(), self.controllers.clone());
        change(&mut assembly, &mut controllers);
        let plant = LinearMachine::of_assembly(self.plant.machine(), &assembly, &self.view)?;
        Ok(Self { plant, assembly, view: self.view, controllers })
    }

    /// The machine.
    pub fn plant(&self) -> &LinearMachine {
        &self.plant
    }

    /// The machine's numbers before it was linearised.
    pub fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// The controllers, in the order of the file.
    pub fn controllers(&self) -> &[LoopController] {
        &self.controllers
    }

    /// The controller of this name.
    ///
    /// # Errors
    /// [`AnalysisError::NoController`].
    pub fn controller(&self, name: &str) -> Result<usize, AnalysisError> {
        let found = self.controllers.iter().position(|c| c.name == name);
        found.ok_or_else(|| self.no_controller(name))
    }

    fn no_controller(&self, name: &str) -> AnalysisError {
        if self.assembly.drives.iter().any(|drive| drive.name == name && drive.servo.is_some()) {
            return AnalysisError::ContinuousServo { name: name.into() };
        }
        let known = self.controllers.iter().map(|controller| controller.name.clone()).collect();
        AnalysisError::NoController { name: name.into(), known }
    }

    /// Controller and gain of a key such as `controllers.force.kp` (or `force.kp`, or `kp` for the first
    /// controller).
    ///
    /// # Errors
    /// [`AnalysisError::NoController`]; the gain itself is checked when it is set.
    pub(crate) fn gain_of_key(&self, key: &str) -> Result<(usize, String), AnalysisError> {
        let (path, gain) = key.rsplit_once('.').unwrap_or(("", key));
        let of_servo = Actuator::within(path);
        let name = of_servo.or(ControllerSpec::within(path)).unwrap_or(path);
        let controller = if name.is_empty() { 0 } else { self.controller(name)? };
        let own = self.controllers.get(controller).ok_or_else(|| self.no_controller(name))?;
        // The gain on speed of a servo is the damping of a position law.
        let damping = own.spec.law.gain(GainPart::Damping);
        let is_damping = of_servo.is_some() && gain == Actuator::SERVO_KD.key.name;
        let gain = damping.filter(|_| is_damping).map_or(gain, |damping| damping.key.name);
        Ok((controller, gain.into()))
    }

    /// The gain to analyse by default: the first nonzero gain of the first controller that closes a loop.
    pub(crate) fn default_gain_key(&self) -> Option<String> {
        let closes = |c: &&LoopController| !matches!(c.spec.law, Law::OpenLoop);
        let controller = self.controllers.iter().find(closes)?;
        let place = if controller.is_servo { Actuator::place } else { ControllerSpec::place };
        leading_gain(&controller.spec).map(|gain| format!("{}.{gain}", place(&controller.name)))
    }

    /// The same machine with another law, gains or timing of one controller, with the same sensors.
    #[must_use]
    pub fn with_spec(&self, controller: usize, spec: ControllerSpec) -> Self {
        let mut changed = self.clone();
        changed.set_spec(controller, spec);
        changed
    }

    pub(crate) fn set_spec(&mut self, controller: usize, spec: ControllerSpec) {
        self.controllers[controller].spec = spec;
    }

    pub(crate) fn specs(&self) -> Vec<ControllerSpec> {
        self.controllers.iter().map(|c| c.spec.clone()).collect()
    }

    /// The specifications of all controllers with one gain changed.
    pub(crate) fn specs_with(
        &self,
        controller: usize,
        gain: &str,
        value: f64,
    ) -> Result<Vec<ControllerSpec>, AnalysisError> {
        let mut specs = self.specs();
        specs[controller] = with_gain(&specs[controller], gain, value)?;
        Ok(specs)
    }

    /// Delay from the output of a controller to the drive or the loop of a servo, s.
    pub(crate) fn output_delay_s(&self, controller: &LoopController) -> f64 {
        let drive = &self.assembly.drives[controller.drive];
        let late_s = if controller.aims_at.is_some() { drive.received_late() } else { drive.delay };
        controller.spec.delay_s + late_s
    }

    /// The plant between drives and sensors. `outputs` may replace the readings of controllers.
    pub(crate) fn loop_plant(
        &self,
        replaced: Option<(usize, OutputRow)>,
    ) -> Result<LoopPlant, AnalysisError> {
        let plant = &self.plant;
        let sensor = |index: Option<usize>| index.map(|i| plant.output(Source::Sensor(i))).transpose();
        let mut reading: Vec<Option<OutputRow>> =
            self.controllers.iter().map(|c| sensor(c.reading)).collect::<Result<_, _>>()?;
        let mut motion: Vec<Option<OutputRow>> =
            self.controllers.iter().map(|c| sensor(c.motion)).collect::<Result<_, _>>()?;
        if let Some((controller, output)) = replaced {
            reading[controller] = Some(output);
        }
        let rows: Vec<&mut OutputRow> = reading.iter_mut().chain(&mut motion).flatten().collect();
        let n = plant.a().nrows();
        let mut c = DMatrix::zeros(rows.len(), n);
        for (i, row) in rows.iter().enumerate() {
            c.row_mut(i).copy_from(&row.c);
        }
        let mut b = plant.b().clone();
        for drive in 0..b.ncols() {
            if !self.controllers.iter().any(|controller| controller.drive == drive) {
                b.column_mut(drive).fill(0.0);
            }
        }
        let reduced = reduce(plant.a(), &b, &c, plant.motion().layout().coordinates());
        for (i, row) in rows.into_iter().enumerate() {
            row.c = reduced.c.row(i).into_owned();
        }
        Ok(LoopPlant { reduced, reading, motion })
    }
}
