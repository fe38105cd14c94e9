//! What to do about it, and what it costs in bandwidth.

use feeler_control::{AdmittanceGains, Law, LeadSpec};
use feeler_engine::Scenario;
use feeler_plant::description::ActuatorKind;
use feeler_plant::effects::{ActuatorLag, EffectUse};
use serde::Serialize;

use super::change::Cause;
use super::linear::{bandwidth_hz, gain_margin};
use super::roles::Roles;
use super::{Explanation, is_cured};
use crate::run::Candidate;

/// The share of the largest stable gain at which a loop is used.
const GAIN_SHARE: f64 = 0.5;
/// How much more stiffness or damping, or speed of a drive, a remedy takes.
const MORE: f64 = 4.0;

/// A way out, checked by simulation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Remedy {
    /// What to do.
    pub what: String,
    /// Factor on the loop's gain that goes with it: 1 where the gain can stay.
    pub gain_factor: f64,
    /// Frequency up to which the force then follows its reference, to 3 dB, Hz; absent where linear theory
    /// has no answer.
    pub bandwidth_hz: Option<f64>,
    /// What that costs, as a share of the bandwidth of the loop as it is; below zero where something is
    /// gained.
    pub cost: Option<f64>,
    /// Whether the force then settles in simulation.
    pub settles: bool,
}

/// Remedies against these causes that settle in simulation, cheapest in bandwidth first.
pub(super) fn remedies(scenario: &Scenario, found: &Explanation) -> Vec<Remedy> {
    let wanted_hz = bandwidth_hz(scenario);
    let mut remedies: Vec<Remedy> = candidates(scenario, found)
        .into_iter()
        .map(|(what, changed)| remedy(what, &changed, wanted_hz))
        .filter(|remedy| remedy.settles)
        .collect();
    remedies.sort_by(|a, b| a.cost.unwrap_or(f64::INFINITY).total_cmp(&b.cost.unwrap_or(f64::INFINITY)));
    remedies
}

/// The remedy with as much of the gain as linear theory leaves.
fn remedy(what: String, changed: &Scenario, wanted_hz: Option<f64>) -> Remedy {
    let gain_factor = gain_margin(changed).map_or(1.0, |margin| (GAIN_SHARE * margin).min(1.0)).max(1e-3);
    let scaled = with_gain(changed, gain_factor);
    let settles = Candidate::new(scaled.clone())
        .and_then(|candidate| candidate.measure(0))
        .is_ok_and(|measured| is_cured(&scaled, &measured));
    let bandwidth_hz = bandwidth_hz(&scaled);
    let cost = wanted_hz.zip(bandwidth_hz).map(|(wanted, found)| 1.0 - found / wanted);
    Remedy { what, gain_factor, bandwidth_hz, cost, settles }
}

/// The scenario with the gains on errors scaled; damping stays.
fn with_gain(scenario: &Scenario, factor: f64) -> Scenario {
    let mut scaled = scenario.clone();
    for used in scaled.controllers.values_mut() {
        match &mut used.spec.law {
            Law::ExplicitForce(gains) => {
                for gain in [&mut gains.kp, &mut gains.ki, &mut gains.kd] {
                    *gain *= factor;
                }
            }
            Law::Position(gains) => {
                for gain in [&mut gains.kp, &mut gains.ki, &mut gains.kd] {
                    *gain *= factor;
                }
            }
            Law::Impedance(gains) => {
                for gain in [&mut gains.stiffness, &mut gains.force_gain] {
                    *gain *= factor;
                }
            }
            // The loop's gain falls as the virtual body grows heavier.
            Law::Admittance(AdmittanceGains { mass, damping, .. }) => {
                for gain in [mass, damping] {
                    *gain /= factor;
                }
            }
            _ => {}
        }
    }
    scaled
}

/// What can be done about each cause, and about any.
fn candidates(scenario: &Scenario, found: &Explanation) -> Vec<(String, Scenario)> {
    let roles = Roles::of(&scenario.machine);
    let mut all: Vec<(String, Scenario)> = Vec::new();
    let mut add = |what: &str, change: &dyn Fn(&mut Scenario)| {
        let mut changed = scenario.clone();
        change(&mut changed);
        if changed != *scenario {
            all.push((what.to_owned(), changed));
        }
    };
    let has = |cause| found.causes.contains(&cause);
    if found.wrong_sign {
        add("the gains with the other sign", &|s| *s = with_gain(s, -1.0));
    }
    if has(Cause::NumericalArtefact) {
        add("integrate exactly (run.integrator = \"exact\")", &|s| {
            s.run.integrator = feeler_engine::Integrator::Exact;
        });
    }
    if has(Cause::SamplingAndDelay) {
        add("halve every delay", &|s| {
            s.controllers.values_mut().for_each(|used| used.spec.delay_s /= 2.0);
            s.machine.sensors.values_mut().for_each(|sensor| sensor.delay_s /= 2.0);
        });
        add("sample twice as fast", &|s| {
            s.controllers.values_mut().for_each(|used| used.spec.period_s /= 2.0);
        });
    }
    if has(Cause::NoncolocatedMode) {
        add("a transmission four times as stiff", &|s| scale_springs(s, &roles.transmissions, MORE, 1.0));
        add("a transmission with four times the damping", &|s| {
            scale_springs(s, &roles.transmissions, 1.0, MORE);
        });
    }
    if has(Cause::ColocatedMode) {
        add("four times the damping of base and fixture", &|s| {
            scale_springs(s, &roles.mounts, 1.0, MORE);
            scale_springs(s, &roles.fixtures, 1.0, MORE);
        });
        add("base and fixture four times as stiff", &|s| {
            scale_springs(s, &roles.mounts, MORE, 1.0);
            scale_springs(s, &roles.fixtures, MORE, 1.0);
        });
    }
    if has(Cause::ActuatorLag) {
        add("a drive four times as fast", &|s| {
            for actuator in s.machine.actuators.values_mut() {
                match &mut actuator.kind {
                    ActuatorKind::Force { bandwidth_hz } => {
                        *bandwidth_hz = bandwidth_hz.map(|bandwidth| bandwidth * MORE);
                    }
                    ActuatorKind::VelocitySource { time_constant_s, .. } => *time_constant_s /= MORE,
                }
                for effect in &mut actuator.effects {
                    if let Some(ActuatorLag { time_constant }) = effect.parameters() {
                        *effect = EffectUse::of(ActuatorLag { time_constant: time_constant / MORE });
                    }
                }
            }
        });
    }
    if has(Cause::Saturation) {
        add("a drive without the limit", &|s| *s = super::Change::NoSaturation.applied(s));
    }
    if has(Cause::StictionOrQuantiser) {
        add("friction compensated, or a guide without it", &|s| *s = super::Change::NoFriction.applied(s));
        add("sensors and outputs with a fine resolution", &|s| *s = super::Change::NoQuantiser.applied(s));
    }
    if has(Cause::SensorNoise) {
        add("sensors with a quarter of the noise", &|s| {
            s.machine.sensors.values_mut().for_each(|sensor| sensor.noise /= MORE);
        });
    }
    if has(Cause::LossOfContact) {
        add("approach at a quarter of the speed", &|s| *s = super::Change::SlowerApproach.applied(s));
    }
    add("joint damping for half of critical", &|s| add_damping(s));
    add("a lead from the loop's own bandwidth on", &|s| add_lead(s));
    add("a pad on the tool, a quarter of the stiffness", &|s| {
        s.machine.contacts.values_mut().for_each(|contact| contact.stiffness /= MORE);
    });
    all.push(("a lower gain".into(), scenario.clone()));
    all
}

fn scale_springs(scenario: &mut Scenario, names: &[String], stiffness: f64, damping: f64) {
    for name in names {
        if let Some(spring) = scenario.machine.springs.get_mut(name) {
            spring.stiffness_n_per_m *= stiffness;
            spring.damping_n_s_per_m *= damping;
        }
    }
}

/// Damping of `m w`, half of critical, where the loop reads the motion of its own drive.
fn add_damping(scenario: &mut Scenario) {
    let stiffness = scenario.machine.contacts.values().map(|contact| contact.stiffness).fold(0.0, f64::max);
    let mass: f64 = scenario
        .machine
        .actuators
        .values()
        .filter_map(|a| scenario.machine.bodies.get(&a.on))
        .map(|body| body.mass_kg)
        .sum();
    let sensed = scenario
        .machine
        .sensors
        .values()
        .any(|sensor| scenario.machine.actuators.values().any(|a| a.on == sensor.reads.element));
    for used in scenario.controllers.values_mut() {
        if let Law::ExplicitForce(gains) = &mut used.spec.law
            && sensed
        {
            gains.damping += (mass * stiffness).sqrt();
        }
    }
}

fn add_lead(scenario: &mut Scenario) {
    let Some(bandwidth) = bandwidth_hz(scenario) else { return };
    for used in scenario.controllers.values_mut() {
        if let Law::ExplicitForce(gains) = &mut used.spec.law {
            gains.lead.get_or_insert(LeadSpec { zero_hz: bandwidth, pole_hz: MORE * bandwidth });
        }
    }
}
