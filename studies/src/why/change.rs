//! One thing about a scenario made ideal.

use feeler_engine::{Integrator, Scenario};
use feeler_plant::description::{ActuatorKind, Engagement, MotorInput, PositionServo, Quantity};
use feeler_plant::effects::{Change, Definition, EffectUse, Place, Trait};
use serde::Serialize;

use super::roles::Roles;
use crate::run::Measured;

/// Factor by which the period of a controller is reduced to represent a continuous one.
const CONTINUOUS: f64 = 20.0;
/// Factor by which a fixed step is reduced.
const FINE_STEP: f64 = 32.0;
/// Factor by which an approach is slowed down, and the factors of its further reductions.
pub(super) const SLOWER: f64 = 4.0;
pub(super) const SLOWER_STILL: [f64; 4] = [16.0, 64.0, 256.0, 1024.0];
/// Remaining time constant of a drive that must have one, as a share of the controller's period.
const QUICK_DRIVE: f64 = 1e-3;

/// A counterfactual: the scenario without one of its nonideal properties.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Counterfactual {
    HalveStep,
    /// A fixed step 32 times shorter.
    FineStep,
    /// Controllers at 20 times the rate, without delay, with exact motion sensors.
    ContinuousController,
    /// No delay and no filter from sensor to drive.
    NoDelay,
    /// A contact that pulls as well as it pushes.
    BilateralContact,
    /// The robot's bodies joined to one.
    RigidTransmission,
    /// The base fixed to the ground.
    FrozenBase,
    /// The workpiece fixed.
    FrozenWorkpiece,
    /// A drive without lag, deadband or ripple.
    IdealActuator,
    /// No limit on efforts, rates and outputs.
    NoSaturation,
    /// Readings and outputs without steps.
    NoQuantiser,
    NoFriction,
    NoFreePlay,
    /// A quarter of the speed before contact, or less if necessary.
    SlowerApproach,
    NoNoise,
}

/// Name of a cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChatterCause {
    /// The integrator's step.
    NumericalArtefact,
    /// Hold, delay and filters.
    SamplingAndDelay,
    /// A mode in which drive and sensor move in opposition.
    NoncolocatedMode,
    /// A mode of base or workpiece.
    ColocatedMode,
    /// The drive's own dynamics.
    ActuatorLag,
    /// A contact that only pushes.
    LossOfContact,
    /// Limits on efforts, rates and outputs.
    Saturation,
    /// Dry friction, or the resolution of sensors and outputs.
    StictionOrQuantiser,
    /// Free play between drive and load.
    FreePlay,
    /// Sensor noise, in a loop that is at rest without it.
    SensorNoise,
}

impl ChatterCause {
    /// The change or cause in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::NumericalArtefact => "a numerical artefact",
            Self::SamplingAndDelay => "sampling and delay",
            Self::NoncolocatedMode => "a noncolocated mode",
            Self::ColocatedMode => "a colocated mode",
            Self::ActuatorLag => "actuator lag",
            Self::LossOfContact => "loss of contact",
            Self::Saturation => "saturation",
            Self::StictionOrQuantiser => "stiction or quantiser",
            Self::FreePlay => "free play",
            Self::SensorNoise => "sensor noise",
        }
    }
}

impl Counterfactual {
    /// Every change, in the order of the trials.
    pub const ALL: [Self; 15] = [
        Self::HalveStep,
        Self::FineStep,
        Self::ContinuousController,
        Self::NoDelay,
        Self::BilateralContact,
        Self::RigidTransmission,
        Self::FrozenBase,
        Self::FrozenWorkpiece,
        Self::IdealActuator,
        Self::NoSaturation,
        Self::NoQuantiser,
        Self::NoFriction,
        Self::NoFreePlay,
        Self::SlowerApproach,
        Self::NoNoise,
    ];

    /// The changes that linear theory of the loop knows.
    pub(super) const OF_THE_LOOP: [Self; 6] = [
        Self::ContinuousController,
        Self::NoDelay,
        Self::RigidTransmission,
        Self::FrozenBase,
        Self::FrozenWorkpiece,
        Self::IdealActuator,
    ];

    /// The cause that it removes.
    pub fn cause(self) -> ChatterCause {
        match self {
            Self::HalveStep | Self::FineStep => ChatterCause::NumericalArtefact,
            Self::ContinuousController | Self::NoDelay => ChatterCause::SamplingAndDelay,
            Self::RigidTransmission => ChatterCause::NoncolocatedMode,
            Self::FrozenBase | Self::FrozenWorkpiece => ChatterCause::ColocatedMode,
            Self::IdealActuator => ChatterCause::ActuatorLag,
            Self::BilateralContact | Self::SlowerApproach => ChatterCause::LossOfContact,
            Self::NoSaturation => ChatterCause::Saturation,
            Self::NoQuantiser | Self::NoFriction => ChatterCause::StictionOrQuantiser,
            Self::NoFreePlay => ChatterCause::FreePlay,
            Self::NoNoise => ChatterCause::SensorNoise,
        }
    }

    /// The change or cause in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::HalveStep => "half the step",
            Self::FineStep => "a step 32 times shorter",
            Self::ContinuousController => "a continuous controller",
            Self::NoDelay => "no delay",
            Self::BilateralContact => "a contact that also pulls",
            Self::RigidTransmission => "a rigid transmission",
            Self::FrozenBase => "a frozen base",
            Self::FrozenWorkpiece => "a frozen workpiece",
            Self::IdealActuator => "an ideal actuator",
            Self::NoSaturation => "no saturation",
            Self::NoQuantiser => "no quantiser",
            Self::NoFriction => "no friction",
            Self::NoFreePlay => "no free play",
            Self::SlowerApproach => "a slower approach",
            Self::NoNoise => "no sensor noise",
        }
    }

    /// The scenario with the change; unchanged if the change does not apply.
    pub fn applied(self, scenario: &Scenario) -> Scenario {
        let mut changed = scenario.clone();
        let roles = Roles::of(&scenario.machine);
        match self {
            Self::HalveStep | Self::FineStep if scenario.run.integrator == Integrator::Exact => {}
            Self::HalveStep => changed.run.step_s /= 2.0,
            Self::FineStep => changed.run.step_s /= FINE_STEP,
            Self::ContinuousController => continuous(&mut changed),
            Self::NoDelay => without_delay(&mut changed),
            Self::BilateralContact => {
                let unilateral = changed
                    .machine
                    .contacts
                    .values_mut()
                    .filter(|contact| contact.engagement == Engagement::Unilateral);
                unilateral.for_each(|contact| contact.engagement = Engagement::Clamped);
            }
            Self::RigidTransmission => {
                rigid(&mut changed, &roles.transmissions);
                drop_effects(&mut changed, |effect| yields(effect, Place::Transmission));
            }
            Self::FrozenBase => {
                rigid(&mut changed, &roles.mounts[..roles.mounts.len().min(1)]);
                drop_effects(&mut changed, |effect| yields(effect, Place::Base));
            }
            Self::FrozenWorkpiece => {
                rigid(&mut changed, &roles.fixtures[..roles.fixtures.len().min(1)]);
                drop_effects(&mut changed, |effect| yields(effect, Place::Workpiece));
            }
            Self::IdealActuator => ideal_actuators(&mut changed),
            Self::NoSaturation => {
                for actuator in changed.machine.actuators.values_mut() {
                    (actuator.limit_n, actuator.rate_limit_per_s) = (None, None);
                    drop_limits(&mut actuator.kind);
                }
                changed.controllers.values_mut().for_each(|used| used.spec.output_limit = None);
                drop_effects(&mut changed, |effect| effect.has(Trait::Saturation));
            }
            Self::NoQuantiser => {
                changed.machine.sensors.values_mut().for_each(|sensor| sensor.resolution = None);
                changed.controllers.values_mut().for_each(|used| used.spec.output_resolution = None);
                servos(&mut changed)
                    .for_each(|servo| (servo.resolution_m, servo.output_resolution_n) = (None, None));
                drop_effects(&mut changed, |effect| effect.has(Trait::Quantisation));
            }
            Self::NoFriction => drop_effects(&mut changed, |effect| effect.has(Trait::DryFriction)),
            Self::NoFreePlay => drop_effects(&mut changed, |effect| effect.has(Trait::FreePlay)),
            Self::SlowerApproach => slow_down(&mut changed, SLOWER),
            Self::NoNoise => {
                changed.machine.sensors.values_mut().for_each(|sensor| sensor.noise = 0.0);
                drop_effects(&mut changed, |effect| effect.has(Trait::Noise));
            }
        }
        changed
    }
}

/// Slows the tool down before contact.
pub(super) fn slow_down(scenario: &mut Scenario, times: f64) {
    // A surface moves at its own time: a later tool would meet another part of it.
    if !scenario.machine.profiles.is_empty() {
        return;
    }
    let approaches = scenario.controllers.values_mut().filter_map(|used| used.spec.approach.as_mut());
    approaches.for_each(|approach| approach.speed /= times);
    scenario.machine.bodies.values_mut().for_each(|body| body.velocity_m_per_s /= times);
}

/// Time of the first touch, s.
fn first_contact_s(baseline: &Measured) -> f64 {
    let contacts = baseline.summary.contacts.iter().filter_map(|contact| contact.first_contact_s);
    contacts.fold(0.0, f64::max)
}

/// Largest extension of a run with a slower approach, as a multiple of the scenario's duration.
const MOST_LONGER: f64 = 8.0;

/// Whether a run in which the tool arrives later by a factor is not too long.
pub(super) fn affords(times: f64, scenario: &Scenario, baseline: &Measured) -> bool {
    (times - 1.0) * first_contact_s(baseline) < MOST_LONGER * scenario.run.duration_s
}

/// A scenario whose tool arrives later by a factor, with a run that is longer by the same delay.
pub(super) fn arriving_later(slower: &Scenario, baseline: &Measured, times: f64) -> Scenario {
    let mut longer = slower.clone();
    longer.run.duration_s += (times - 1.0) * first_contact_s(baseline);
    longer
}

/// The scenario with its controllers at a multiple of their rate.
pub(super) fn sampled_faster(scenario: &Scenario, times: f64) -> Scenario {
    let mut faster = scenario.clone();
    sample_faster(&mut faster, times);
    faster
}

/// Shortens the periods of controllers and sampled servos.
pub(super) fn sample_faster(scenario: &mut Scenario, times: f64) {
    scenario.controllers.values_mut().for_each(|used| used.spec.period_s /= times);
    servos(scenario).for_each(|servo| servo.period_s = servo.period_s.map(|period_s| period_s / times));
}

/// The loops of position servos, whose numbers are those of a controller in the drive.
pub(super) fn servos(scenario: &mut Scenario) -> impl Iterator<Item = &mut PositionServo> {
    scenario.machine.actuators.values_mut().filter_map(|actuator| match &mut actuator.kind {
        ActuatorKind::PositionServo(servo) => Some(servo),
        _ => None,
    })
}

/// Removes the limits of a drive's own speed, current and voltage. A duty cycle is a share of a voltage,
/// which stays.
fn drop_limits(kind: &mut ActuatorKind) {
    match kind {
        ActuatorKind::PositionServo(servo) => servo.velocity_limit_m_per_s = None,
        ActuatorKind::DcMotor(motor) => {
            motor.current_limit_a = None;
            if motor.input != MotorInput::Duty {
                motor.supply_voltage_v = None;
            }
        }
        _ => {}
    }
}

fn continuous(scenario: &mut Scenario) {
    drop_effects(scenario, |effect| matches!(effect.change, Change::SampleJitter(_)));
    let motion: Vec<String> = scenario.controllers.values().filter_map(|used| used.motion.clone()).collect();
    for used in scenario.controllers.values_mut() {
        used.spec.period_s /= CONTINUOUS;
        used.spec.jitter_s = 0.0;
    }
    for servo in servos(scenario) {
        (servo.period_s, servo.compute_delay_s) = (None, 0.0);
        (servo.resolution_m, servo.output_resolution_n) = (None, None);
    }
    // Differences of quantisation steps over so short a period would be noise.
    for (name, sensor) in &mut scenario.machine.sensors {
        if sensor.reads.quantity == Quantity::Position || motion.contains(name) {
            (sensor.resolution, sensor.noise) = (None, 0.0);
            sensor.effects.retain(|effect| !effect.definition.has(Trait::Quantisation));
        }
    }
}

fn without_delay(scenario: &mut Scenario) {
    for used in scenario.controllers.values_mut() {
        used.spec.delay_s = 0.0;
        (used.spec.reading_low_pass, used.spec.reading_notch) = (None, None);
        used.spec.velocity_filter_s = 0.0;
    }
    for sensor in scenario.machine.sensors.values_mut() {
        (sensor.delay_s, sensor.low_pass) = (0.0, None);
    }
    servos(scenario).for_each(|servo| (servo.delay_s, servo.compute_delay_s) = (0.0, 0.0));
    drop_effects(scenario, |effect| effect.has(Trait::Delay));
}

fn ideal_actuators(scenario: &mut Scenario) {
    let period_s =
        scenario.controllers.values().map(|used| used.spec.period_s).fold(scenario.run.step_s, f64::min);
    for actuator in scenario.machine.actuators.values_mut() {
        match &mut actuator.kind {
            ActuatorKind::Force { bandwidth_hz } => *bandwidth_hz = None,
            ActuatorKind::VelocitySource { time_constant_s, .. } => {
                *time_constant_s = time_constant_s.min(QUICK_DRIVE * period_s);
            }
            ActuatorKind::PositionServo(servo) => (servo.delay_s, servo.error_deadband_m) = (0.0, 0.0),
            ActuatorKind::DcMotor(motor) => motor.inductance_h = 0.0,
            ActuatorKind::Imposed | ActuatorKind::TargetVelocity | ActuatorKind::FeedForward => {}
        }
    }
    drop_effects(scenario, |effect| effect.has(Trait::DriveFlaw));
}

fn rigid(scenario: &mut Scenario, springs: &[String]) {
    for name in springs {
        let Some(spring) = scenario.machine.springs.get_mut(name) else { continue };
        spring.rigid = true;
        (spring.stiffness_n_per_m, spring.damping_n_s_per_m) = (0.0, 0.0);
        spring.effects.clear();
    }
}

/// Whether an effect makes a rigid connection at this place flexible.
fn yields(effect: &Definition, place: Place) -> bool {
    effect.place == place && effect.has(Trait::Compliance)
}

fn drop_effects(scenario: &mut Scenario, is_dropped: impl Fn(&Definition) -> bool) {
    let keep = |effects: &mut Vec<EffectUse>| effects.retain(|effect| !is_dropped(effect.definition));
    let machine = &mut scenario.machine;
    machine.bodies.values_mut().for_each(|body| keep(&mut body.effects));
    machine.springs.values_mut().for_each(|spring| keep(&mut spring.effects));
    machine.contacts.values_mut().for_each(|contact| keep(&mut contact.effects));
    machine.actuators.values_mut().for_each(|actuator| keep(&mut actuator.effects));
    machine.sensors.values_mut().for_each(|sensor| keep(&mut sensor.effects));
    scenario.controllers.values_mut().for_each(|used| keep(&mut used.effects));
}
