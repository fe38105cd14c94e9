//! A scenario prepared for running: the machine's motion, the wiring of its controllers, and the record.

use std::sync::Arc;

use feeler_catalogue::Tabled;
use feeler_control::{ControllerSpec, Reference, SampleClock};
use feeler_plant::assembly::{Assembly, ContactPart, Source, assemble, resolve};
use feeler_plant::description::{Elements, Profile, Quantity, SignalName};
use feeler_plant::effects::Change;
use feeler_plant::motion::Motion;
use feeler_plant::names::did_you_mean;
use feeler_plant::problem::Problem;

use crate::error::EngineError;
use crate::run::scenario::{ControllerUse, Scenario};
use crate::run::servo::{ServoWiring, impose, servos};
use crate::run::settings::RunSettings;
use crate::run::wanted::{Tapped, Wanted};

/// The source of a recorded value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Recorded {
    /// A row of the plant: index into the wanted signals.
    Plant(usize),
    /// One of the six numbers of the point at which the shapes of contact `i` touch.
    Touch(usize, usize),
    /// 1 while contact `i` pushes.
    Touching(usize),
    /// The command of drive `i` as issued.
    Command(usize),
    /// The reading of sensor `i`; its signal is the wanted one with this index.
    Reading(usize, usize),
    /// The output of controller `i`, as applied.
    Output(usize),
    /// The reference of controller `i`.
    Reference(usize),
}

/// How one controller is wired.
#[derive(Clone, Debug)]
pub(crate) struct Wiring {
    pub(crate) reading: Option<Tapped>,
    pub(crate) motion: Option<Tapped>,
    pub(crate) motion_is_velocity: bool,
    pub(crate) drive: usize,
    pub(crate) clock: SampleClock,
    pub(crate) reference: Reference,
}

/// A controller with its names resolved to indices of the assembly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopWiring<'a> {
    pub name: &'a str,
    /// Whether this is the loop of a sampled servo; its name is then that of the actuator.
    pub is_servo: bool,
    /// Law, gains, timing and reference, with effects applied.
    pub spec: &'a ControllerSpec,
    /// Sensor it controls.
    pub reading: Option<usize>,
    /// Sensor of position or velocity that it uses for damping.
    pub motion: Option<usize>,
    /// Whether that sensor reads velocity.
    pub motion_is_velocity: bool,
    pub drive: usize,
}

/// A scenario ready to run, in one variant.
#[derive(Clone, Debug)]
pub struct Program {
    pub(crate) motion: Motion,
    pub(crate) controllers: Elements<ControllerUse>,
    pub(crate) wiring: Vec<Wiring>,
    /// The loops of sampled servos.
    pub(crate) servos: Vec<ServoWiring>,
    pub(crate) run: RunSettings,
    /// Signals of the plant with a reader, as rows.
    pub(crate) wanted: Vec<Source>,
    pub(crate) recorded: Vec<Recorded>,
    pub(crate) names: Vec<String>,
}

impl Program {
    /// Checks and prepares a scenario.
    ///
    /// # Errors
    /// Every mistake of machine and wiring at once, by key.
    pub fn new(scenario: &Scenario) -> Result<Self, EngineError> {
        let mut scenario = scenario.clone();
        let mut problems = Vec::new();
        for (name, controller) in &mut scenario.controllers {
            for effect in &controller.effects {
                match effect.definition.change {
                    // Independent deviations add in square.
                    Change::SampleJitter(sigma) => {
                        controller.spec.jitter_s = controller.spec.jitter_s.hypot(sigma(&effect.values));
                    }
                    Change::Plant(_) => problems.push(Problem::new(
                        format!("{}.effects.{}", ControllerUse::place(name), effect.definition.kind),
                        "this effect disturbs the plant, not a controller",
                        "move it under the element that it disturbs",
                    )),
                }
            }
        }
        let motion = match assemble(&scenario.machine) {
            Ok(mut assembly) => {
                impose(&scenario, &mut assembly, &mut problems);
                Motion::new(assembly).map_err(|more| problems.extend(more)).ok()
            }
            Err(more) => {
                problems.extend(more);
                None
            }
        };
        let mut wanted = Wanted::default();
        let mut wiring = Vec::new();
        for (name, controller) in &scenario.controllers {
            if let Some(w) = wire(&scenario, name, controller, &mut wanted, &mut problems)? {
                wiring.push(w);
            }
        }
        let mut recorded = Vec::new();
        for signal in &scenario.run.record {
            match record(&scenario, signal, &mut wanted) {
                Ok(source) => recorded.push(source),
                Err(problem) => {
                    problems.push(Problem { key: RunSettings::key(&RunSettings::RECORD), ..problem });
                }
            }
        }
        let Some(motion) = motion.filter(|_| problems.is_empty()) else {
            return Err(EngineError::Problems { problems });
        };
        let servos = servos(motion.assembly(), &mut wanted)?;
        let names = scenario.run.record.iter().map(ToString::to_string).collect();
        Ok(Self {
            motion,
            controllers: scenario.controllers,
            wiring,
            servos,
            run: scenario.run,
            wanted: wanted.sources,
            recorded,
            names,
        })
    }

    /// The machine's motion.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Settings of its runs.
    pub fn settings(&self) -> &RunSettings {
        &self.run
    }

    /// Names of the recorded signals, in the order of the file.
    pub fn record_names(&self) -> &[String] {
        &self.names
    }

    /// The wiring of the controllers in the order of the file, then the loops of sampled servos.
    pub fn loops(&self) -> impl Iterator<Item = LoopWiring<'_>> {
        let servos = self.servos.iter().map(|servo| LoopWiring {
            name: &servo.name,
            is_servo: true,
            spec: &servo.spec,
            reading: Some(servo.encoder.sensor),
            motion: None,
            motion_is_velocity: false,
            drive: servo.drive,
        });
        let controllers =
            self.controllers.iter().zip(&self.wiring).map(|((name, used), wiring)| LoopWiring {
                name,
                is_servo: false,
                spec: &used.spec,
                reading: wiring.reading.map(|tapped| tapped.sensor),
                motion: wiring.motion.map(|tapped| tapped.sensor),
                motion_is_velocity: wiring.motion_is_velocity,
                drive: wiring.drive,
            });
        controllers.chain(servos)
    }

    /// The shared property in which two variants differ; `None` if they can run side by side.
    pub fn difference(&self, other: &Self) -> Option<&'static str> {
        let (a, b) = (self.motion.assembly(), other.motion.assembly());
        let bits = f64::to_bits;
        let same_loop = |(a, b): (&ControllerUse, &ControllerUse)| {
            let timing = |c: &ControllerUse| {
                [c.spec.period_s, c.spec.delay_s, c.spec.offset_s, c.spec.jitter_s].map(bits)
            };
            timing(a) == timing(b)
                && std::mem::discriminant(&a.spec.law) == std::mem::discriminant(&b.spec.law)
        };
        let wires = |p: &Self| {
            p.wiring.iter().map(|w| (w.reading, w.motion, w.motion_is_velocity, w.drive)).collect::<Vec<_>>()
        };
        let starts = |profile: Option<&Arc<Profile>>| {
            let of = |profile: &Arc<Profile>| {
                profile.pieces().iter().map(|piece| bits(piece.start_s)).collect::<Vec<_>>()
            };
            profile.map(of)
        };
        let knots = |contact: &ContactPart| starts(contact.profile.as_ref());
        let servo_timing = |servo: &ServoWiring, assembly: &Assembly| {
            let target = assembly.drives[servo.drive].sampling().map(|sampling| bits(sampling.target.delay));
            (servo.drive, [servo.spec.period_s, servo.spec.delay_s].map(bits), target)
        };
        let same_run = {
            let [x, y] = [&self.run, &other.run];
            let numbers =
                |r: &RunSettings| [r.duration_s, r.step_s, r.record_rate_hz.unwrap_or(0.0)].map(bits);
            numbers(x) == numbers(y) && (x.integrator, x.seed, x.energy) == (y.integrator, y.seed, y.energy)
        };
        let checks = [
            (self.motion.layout() == other.motion.layout(), "its states"),
            (self.motion.switches() == other.motion.switches(), "what can switch"),
            (self.motion.terms().len() == other.motion.terms().len(), "its nonlinear laws"),
            (self.wanted == other.wanted && self.recorded == other.recorded, "what is recorded"),
            (
                self.controllers.len() == other.controllers.len() && wires(self) == wires(other),
                "how controllers are wired",
            ),
            (
                self.controllers.values().zip(other.controllers.values()).all(same_loop),
                "the law or timing of a controller",
            ),
            (
                a.contacts.iter().map(knots).eq(b.contacts.iter().map(knots)),
                "when pieces of a moving gap begin",
            ),
            (
                a.drives.iter().map(|d| bits(d.delay)).eq(b.drives.iter().map(|d| bits(d.delay))),
                "the delay of a drive",
            ),
            (
                a.drives.iter().map(|d| d.feeds).eq(b.drives.iter().map(|d| d.feeds)),
                "which servo an input feeds",
            ),
            (
                a.sensors
                    .iter()
                    .map(|s| (bits(s.delay), s.resolutions.len()))
                    .eq(b.sensors.iter().map(|s| (bits(s.delay), s.resolutions.len()))),
                "the delay or quantisation of a sensor",
            ),
            (
                self.servos
                    .iter()
                    .map(|s| servo_timing(s, a))
                    .eq(other.servos.iter().map(|s| servo_timing(s, b))),
                "the timing of a servo",
            ),
            (
                a.drives
                    .iter()
                    .map(|d| starts(d.imposed.as_ref()))
                    .eq(b.drives.iter().map(|d| starts(d.imposed.as_ref()))),
                "when pieces of an imposed motion begin",
            ),
            (same_run, "duration, step, integrator or seed"),
        ];
        checks.iter().find(|(same, _)| !same).map(|(_, what)| *what)
    }

    /// Spacing of the record, s.
    pub fn record_spacing_s(&self) -> f64 {
        self.run.record_rate_hz.map_or(self.run.step_s, |rate| 1.0 / rate)
    }
}

fn missing<T>(key: String, what: &str, name: &str, table: &Elements<T>) -> Problem {
    Problem::new(
        key,
        format!("there is no {what} `{name}`"),
        did_you_mean(name, table.keys().map(String::as_str)),
    )
}

fn wire(
    scenario: &Scenario,
    name: &str,
    controller: &ControllerUse,
    wanted: &mut Wanted,
    problems: &mut Vec<Problem>,
) -> Result<Option<Wiring>, EngineError> {
    let machine = &scenario.machine;
    let found = controller.wiring_problems(machine);
    let is_sound = found.is_empty();
    problems.extend(found.into_iter().map(|problem| Problem {
        key: format!("{}.{}", ControllerUse::place(name), problem.key),
        ..problem
    }));
    let mut tap = |sensor: Option<&str>| Some(wanted.tap(machine.sensors.get_index_of(sensor?)?));
    let reading = tap(controller.reads.as_deref());
    let motion_name = controller.motion_sensor(machine);
    let motion = tap(motion_name);
    let is_velocity = motion_name
        .and_then(|name| machine.sensors.get(name))
        .is_some_and(|sensor| sensor.reads.quantity == Quantity::Velocity);
    let control = |source| EngineError::Control { name: name.into(), source };
    let clock = SampleClock::new(&controller.spec, scenario.run.seed, &ControllerUse::place(name))
        .map_err(control)?;
    let reference =
        Reference::new(&controller.spec.reference, scenario.run.seed, &ControllerUse::place(name))
            .map_err(control)?;
    let drive = machine.actuators.get_index_of(&controller.drives).filter(|_| is_sound);
    Ok(drive.map(|drive| Wiring {
        reading,
        motion,
        motion_is_velocity: is_velocity,
        drive,
        clock,
        reference,
    }))
}

fn record(scenario: &Scenario, signal: &SignalName, wanted: &mut Wanted) -> Result<Recorded, Problem> {
    if let Quantity::Output | Quantity::Reference = signal.quantity {
        let Some(i) = scenario.controllers.get_index_of(&signal.element) else {
            return Err(missing(String::new(), "controller", &signal.element, &scenario.controllers));
        };
        return Ok(if signal.quantity == Quantity::Output {
            Recorded::Output(i)
        } else {
            Recorded::Reference(i)
        });
    }
    Ok(match resolve(&scenario.machine, signal)? {
        Source::Contact(i, Quantity::Contact) => Recorded::Touching(i),
        Source::Contact(i, quantity) if let Some(which) = quantity.of_touch() => Recorded::Touch(i, which),
        Source::Drive(i, Quantity::Command) => Recorded::Command(i),
        Source::Sensor(i) => Recorded::Reading(i, wanted.tap(i).signal),
        source => Recorded::Plant(wanted.index(source)),
    })
}
