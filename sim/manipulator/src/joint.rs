//! The drive of a URDF's joint as elements of the plant, so that every effect has a single definition.

use feeler_arm::JointDrive;
use feeler_catalogue::Tabled;
use feeler_plant::assembly::{Drive, Friction, Link, SensorPart, assemble};
use feeler_plant::description::{
    Actuator, ActuatorKind, Axis, Body, GROUND, Machine, Quantity, Sensor, SignalName, Spring,
};
use feeler_plant::effects::{CoulombFriction, EffectUse, HostKind, Kind};
use feeler_plant::motion::{ContactState, NonlinearLaw, NonlinearTerm, StopSide};
use feeler_plant::problem::Problem;

const MOTOR: &str = "motor";
const LINK: &str = "link";
const GUIDE: &str = "guide";
const GEAR: &str = "gear";
const DRIVE: &str = "drive";
const ENCODER: &str = "encoder";
/// Any value serves here: the inertia of the link belongs to the chain.
const ANY_INERTIA: f64 = 1.0;

/// The elements of a joint: guide, gear, drive and encoder. Each has its kind in the library and the effects
/// that it accepts.
const ELEMENTS: [(HostKind, &[Kind]); 4] = [
    (
        HostKind::Spring,
        &[
            Kind::CoulombFriction,
            Kind::StribeckFriction,
            Kind::ViscousFriction,
            Kind::AsymmetricFriction,
            Kind::ConstantLoad,
        ],
    ),
    (HostKind::Spring, &[Kind::Backlash, Kind::HardeningStiffness]),
    (
        HostKind::Actuator,
        &[
            Kind::ActuatorLag,
            Kind::CommandDelay,
            Kind::DriveGain,
            Kind::DriveDeadband,
            Kind::ForceLimit,
            Kind::ForceRipple,
            Kind::ThermalDerating,
        ],
    ),
    (HostKind::MotionSensor, &[Kind::EncoderResolution]),
];

/// The effects that a joint accepts.
pub fn joint_effects() -> impl Iterator<Item = Kind> {
    ELEMENTS.iter().flat_map(|(_, kinds)| kinds.iter().copied())
}

/// The joint's element that an effect acts on; `None` if a joint does not accept it.
fn element_of(kind: Kind) -> Option<usize> {
    ELEMENTS.iter().position(|(_, kinds)| kinds.contains(&kind))
}

/// Kind, in the library, of the element that such an effect acts on; `None` if a joint does not accept it.
pub fn joint_effect_host(kind: Kind) -> Option<HostKind> {
    element_of(kind).map(|element| ELEMENTS[element].0)
}

/// The motor's side of a joint, its gear, its drive and its encoder, with effects applied; all values at the
/// joint's side of the gear.
#[derive(Clone, Debug, PartialEq)]
pub struct JointPart {
    pub name: String,
    /// Inertia of the rotor at the joint, kg m² (kg for a prismatic joint).
    pub inertia: f64,
    /// Friction of the motor's side, and constant loads.
    pub guide: Link,
    /// The spring between motor and link.
    pub gear: Link,
    /// The drive, from command to torque.
    pub drive: Drive,
    /// The controller's reading of the motor position.
    pub encoder: SensorPart,
}

impl JointPart {
    /// The parts of a joint with a drive and effects.
    ///
    /// # Errors
    /// Every mistake of the effects; keys begin with `effects`.
    pub fn new(
        name: &str,
        drive: &JointDrive,
        slides: bool,
        effects: &[EffectUse],
    ) -> Result<Self, Vec<Problem>> {
        let inertia = drive.gear_ratio * drive.gear_ratio * drive.rotor_inertia_kg_m2;
        let machine = machine(name, drive, inertia, slides, effects)?;
        let mut assembly =
            assemble(&machine).map_err(|problems| problems.into_iter().map(of_joint).collect::<Vec<_>>())?;
        let [gear, guide] = [assembly.links.pop(), assembly.links.pop()];
        match (guide, gear, assembly.drives.pop(), assembly.sensors.pop()) {
            (Some(guide), Some(gear), Some(drive), Some(encoder)) => {
                Ok(Self { name: name.into(), inertia, guide, gear, drive, encoder })
            }
            _ => Err(vec![Problem::new("effects", "the joint has lost its parts", "remove the effects")]),
        }
    }

    /// Torque of the gear on the link for a twist (motor before link) and its rate. With play it depends on
    /// the states of the lower and upper flank.
    pub(crate) fn gear_torque(&self, twist: [f64; 2], flanks: [ContactState; 2]) -> f64 {
        if self.gear.play <= 0.0 {
            return self.law(twist, None)[1];
        }
        [StopSide::Lower, StopSide::Upper]
            .into_iter()
            .zip(flanks)
            .filter(|(_, flank)| *flank == ContactState::Pushing)
            .map(|(side, _)| self.law(twist, Some(side))[1])
            .sum()
    }

    /// Compression of a flank as the torque of its linear spring alone, and the whole torque of its law:
    /// positive when compressed and when pushing.
    pub(crate) fn pressed(&self, twist: [f64; 2], side: StopSide) -> [f64; 2] {
        self.law(twist, Some(side)).map(|torque| side.sign() * torque)
    }

    /// Torque of the linear spring, and of the whole law, of the gear or of one of its flanks.
    fn law(&self, [twist, rate]: [f64; 2], side: Option<StopSide>) -> [f64; 2] {
        let depth = twist - 0.5 * self.gear.play * side.map_or(0.0, StopSide::sign);
        let hardening = NonlinearTerm { law: NonlinearLaw::Cubic { link: 0, side, cubic: self.gear.cubic } };
        let linear = self.gear.stiffness * depth;
        [linear, linear + hardening.value(depth, 0.0) + self.gear.damping * rate]
    }

    /// Remaining dry friction of a motor at rest forward and backward, with the torque `net` on it.
    pub(crate) fn room(&self, net: f64) -> [f64; 2] {
        [self.friction(0.0, 1.0) - net, self.friction(0.0, -1.0) + net]
    }

    /// Cogging torque at a position of the motor.
    pub(crate) fn ripple(&self, position: f64) -> f64 {
        let term = |r: &feeler_plant::assembly::Ripple| {
            let law =
                NonlinearLaw::Ripple { drive: 0, amplitude: r.amplitude, pitch: r.pitch, phase: r.phase };
            NonlinearTerm { law }.value(position, 0.0)
        };
        self.drive.ripples.iter().map(term).sum()
    }

    /// Torque of the drive from that of the cold one, and the rate of its winding's heat.
    pub(crate) fn warmed(&self, cold: f64, heat: f64) -> [f64; 2] {
        let Some(winding) = self.drive.warming else { return [cold, 0.0] };
        let term = |law| NonlinearTerm { law }.value(cold, heat);
        let warms = term(NonlinearLaw::Heat { drive: 0, force: winding.force });
        [cold - term(NonlinearLaw::Derating { drive: 0 }), (warms - heat) / winding.time_constant]
    }

    /// Magnitude of the dry friction at a speed, sliding forward (`sign` above zero) or backward; at zero
    /// speed the largest holding torque.
    pub(crate) fn friction(&self, speed: f64, sign: f64) -> f64 {
        let Friction { forward, backward, stribeck_excess: excess, stribeck_velocity: velocity, .. } =
            self.guide.friction;
        let falling = if excess > 0.0 {
            NonlinearTerm { law: NonlinearLaw::Stribeck { link: 0, excess, velocity } }.value(speed, 0.0)
        } else {
            0.0
        };
        (if sign > 0.0 { forward } else { backward }) + falling
    }
}

fn machine(
    name: &str,
    drive: &JointDrive,
    inertia: f64,
    slides: bool,
    effects: &[EffectUse],
) -> Result<Machine, Vec<Problem>> {
    let axis = if slides { Axis::Translational } else { Axis::Rotational };
    let mut machine = Machine { name: name.into(), axis, ..Machine::default() };
    machine.bodies.insert(MOTOR.into(), Body::new(inertia));
    machine.bodies.insert(LINK.into(), Body::new(ANY_INERTIA));
    let mut under = [const { Vec::new() }; ELEMENTS.len()];
    let mut problems = Vec::new();
    if drive.dry_friction_n_m > 0.0 {
        under[0].push(EffectUse::of(CoulombFriction { level: drive.dry_friction_n_m }));
    }
    for effect in effects {
        let kind = effect.definition.kind;
        let Some(element) = element_of(kind) else {
            let taken: Vec<&str> = joint_effects().map(Kind::name).collect();
            let remedy = format!("joints take {}", taken.join(", "));
            problems.push(Problem::new(
                format!("effects.{kind}"),
                format!("`{kind}` is not simulated in a joint"),
                remedy,
            ));
            continue;
        };
        under[element].push(effect.clone());
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let [on_guide, on_gear, on_drive, on_encoder] = under;
    let guide = Spring::new(GROUND, MOTOR, 0.0, drive.viscous_friction_n_m_s_per_rad);
    let guide = Spring { effects: on_guide, ..guide };
    let gear = Spring::new(MOTOR, LINK, drive.stiffness_n_m_per_rad, drive.damping_n_m_s_per_rad);
    let gear = Spring { effects: on_gear, ..gear };
    machine.springs.insert(GUIDE.into(), guide);
    machine.springs.insert(GEAR.into(), gear);
    let kind = ActuatorKind::Force { bandwidth_hz: drive.bandwidth_hz };
    let actuator = Actuator {
        kind,
        limit_n: drive.effort_limit_n_m,
        effects: on_drive,
        ..Actuator::ideal(MOTOR, GROUND)
    };
    machine.actuators.insert(DRIVE.into(), actuator);
    let encoder = Sensor { effects: on_encoder, ..Sensor::ideal(SignalName::new(MOTOR, Quantity::Position)) };
    machine.sensors.insert(ENCODER.into(), encoder);
    Ok(machine)
}

/// Converts the key of a mistake from an element to the joint: `springs.gear.effects.backlash` becomes
/// `effects.backlash`.
fn of_joint(problem: Problem) -> Problem {
    let elements =
        [Spring::place(GUIDE), Spring::place(GEAR), Actuator::place(DRIVE), Sensor::place(ENCODER)];
    let of_element = |element: &String| problem.key.strip_prefix(element)?.strip_prefix('.');
    let own = elements.iter().find_map(of_element).filter(|own| own.starts_with("effects"));
    let key = own.unwrap_or(&problem.key).to_owned();
    Problem { key, ..problem }
}

#[cfg(test)]
mod tests {
    use feeler_plant::effects::{AddedMass, Backlash, HardeningStiffness, StribeckFriction};

    use super::*;

    fn drive() -> JointDrive {
        JointDrive {
            gear_ratio: 100.0,
            rotor_inertia_kg_m2: 1e-4,
            stiffness_n_m_per_rad: 2e4,
            damping_n_m_s_per_rad: 5.0,
            viscous_friction_n_m_s_per_rad: 3.0,
            dry_friction_n_m: 2.0,
            effort_limit_n_m: Some(100.0),
            bandwidth_hz: Some(400.0),
        }
    }

    /// A few products.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn truth_effects_change_the_parts_that_they_disturb() {
        let effects = [
            EffectUse::of(Backlash { width: 0.02, stiffness: 0.0, damping: 0.0 }),
            EffectUse::of(HardeningStiffness { cubic: 1e6 }),
            EffectUse::of(StribeckFriction { coulomb: 4.0, static_level: 7.0, velocity: 0.1 }),
        ];
        let joint = JointPart::new("elbow", &drive(), false, &effects).unwrap();
        let near = |a: f64, b: f64| assert!((a - b).abs() < ROUNDING * (1.0 + b.abs()), "{a} {b}");
        near(joint.inertia, 1.0);
        // No torque within the play; beyond it only the depth counts.
        let [lower, upper] =
            [[ContactState::Pushing, ContactState::Open], [ContactState::Open, ContactState::Pushing]];
        near(joint.gear_torque([0.005, 1.0], [ContactState::Open; 2]), 0.0);
        near(joint.gear_torque([0.011, 0.0], upper), 2e4 * 1e-3 + 1e6 * 1e-9);
        near(joint.gear_torque([-0.011, -0.2], lower), -20.0 - 1e-3 - 1.0);
        // Dry friction of the drive and of the effect add; the static excess falls by 1/e at the Stribeck
        // speed.
        near(joint.friction(0.0, 1.0), 9.0);
        near(joint.friction(0.1, -1.0), 6.0 + 3.0 * (-1.0_f64).exp());
        assert_eq!(joint.drive.lags.len(), 1);
    }

    #[test]
    fn truth_effects_of_other_places_are_refused() {
        let problems =
            JointPart::new("elbow", &drive(), false, &[EffectUse::of(AddedMass { mass: 1.0 })]).unwrap_err();
        assert_eq!(problems[0].key, "effects.added-mass");
        assert!(problems[0].remedy.contains("backlash"));
    }

    #[test]
    fn truth_a_mistake_of_an_effect_has_its_place_in_the_joint() {
        let wide = Backlash { width: -1.0, stiffness: 0.0, damping: 0.0 };
        let problems = JointPart::new("elbow", &drive(), false, &[EffectUse::of(wide)]).unwrap_err();
        assert_eq!(problems[0].key, "effects.backlash");
        let other = Problem::new("sensors.effects.resolution", "", "");
        assert_eq!(of_joint(other.clone()).key, other.key);
    }
}
