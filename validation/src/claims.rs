//! The paper's five claims (Eppinger and Seering 1992), each as checked rows.

use feeler_analysis::{ControlLoop, GainBands, Limit, LinearMachine, Mode, ModeClass, ModeInPair, View, classify, modes};
use feeler_control::{ControllerSpec, ForceGains, Law, PositionGains};
use feeler_engine::Scenario;
use feeler_plant::description::{ActuatorKind, Body, Engagement, GROUND, Machine, Quantity, SignalName};

use crate::error::ValidationError;
use crate::landmarks;
use crate::paper::{Axis, IDEAL, Model, SOURCE, spring};
use crate::table::Row;

/// Two edges found by bisection of eigenvalues of different matrices: 1e-12, with room.
const SAME_EDGE: f64 = 1e-9;

fn largest(bands: &GainBands) -> f64 {
    bands.bands.last().map_or(0.0, |band| band.upper.as_ref().map_or(f64::INFINITY, |edge| edge.gain))
}

fn force_limit(axis: &Axis) -> Result<f64, ValidationError> {
    let scenario = axis.force_loop(ForceGains { kp: 0.1, ..ForceGains::default() }, 1e-3, 0.0);
    Ok(largest(&ControlLoop::new(&scenario, &View::CLAMPED)?.continuous_bands("kp")?))
}

/// The same machine under proportional control of the motor's position.
fn position_loop(axis: &Axis) -> Scenario {
    let mut scenario = axis.force_loop(ForceGains::default(), 1e-3, 0.0);
    let gains = PositionGains { kp: 1.0, ..PositionGains::default() };
    for control in scenario.controllers.values_mut() {
        control.spec = ControllerSpec::new(Law::Position(gains), 1e-3);
        control.reads = Some("encoder".into());
    }
    scenario
}

fn position_limit(axis: &Axis) -> Result<f64, ValidationError> {
    Ok(largest(&ControlLoop::new(&position_loop(axis), &View::CLAMPED)?.continuous_bands("kp")?))
}

/// Modes of a machine with their class for drive and elastic contact force.
fn classified(machine: &Machine) -> Result<Vec<(Mode, ModeInPair)>, ValidationError> {
    let plant = LinearMachine::new(machine, &View::CLAMPED)?;
    let own = modes(&plant)?;
    let (input, output) = (SignalName::new("drive", Quantity::Command), SignalName::new("tool", Quantity::SpringForce));
    let channel = plant.channel(&input, &output)?;
    let pairs = classify(&plant, &own, plant.drive(&input)?, plant.source(&output)?, &channel)?;
    Ok(own.into_iter().zip(pairs).collect())
}

/// The flexible mode of a model that has one.
fn flexible_mode(axis: &Axis) -> Result<(Mode, ModeInPair), ValidationError> {
    let found = classified(&axis.machine("axis"))?.into_iter().find(|(_, pair)| !pair.rigid_body);
    found.ok_or_else(|| ValidationError::Reference { what: "a machine without a flexible mode".into() })
}

/// Rows for all five claims. The fourth needs the fitted machine and is as exact as its landmarks.
///
/// # Errors
/// [`ValidationError`] where a computation fails.
pub fn claim_rows() -> Result<Vec<Row>, ValidationError> {
    let mut rows = first()?;
    rows.extend(second()?);
    rows.extend(third()?);
    rows.extend(landmarks::rows(&landmarks::fitted(Engagement::Free)?)?);
    rows.extend(fifth()?);
    Ok(rows)
}

fn first() -> Result<Vec<Row>, ValidationError> {
    let claim = "claim 1: rigid-body bandwidth";
    let rigid = |drive| Axis::reference(Model::Rigid, drive);
    let source = |time_constant_s| ActuatorKind::VelocitySource { damping_n_s_per_m: 600.0, time_constant_s };
    let (slow, usual, fast) = (force_limit(&rigid(source(4e-3)))?, force_limit(&rigid(SOURCE))?, force_limit(&rigid(source(1e-3)))?);
    let k_s = rigid(SOURCE).contact.0;
    Ok(vec![
        Row::close("an ideal actuator is stable at every gain", claim, force_limit(&rigid(IDEAL))?, f64::INFINITY, 0.0),
        Row::holds("the actuator's pole bounds the gain", claim, usual.is_finite()),
        Row::holds("more actuator bandwidth raises the bound", claim, slow < usual && usual < fast),
        // f_s = k_s x_r: a gain on position is k_s times one on force, and meets the same limit.
        Row::relative(
            "position control meets the same limit, over the contact stiffness",
            claim,
            position_limit(&rigid(SOURCE))? / k_s,
            usual,
            SAME_EDGE,
        ),
    ])
}

fn second() -> Result<Vec<Row>, ValidationError> {
    let claim = "claim 2: transmission flexibility is dynamically noncolocated";
    let axis = Axis::reference(Model::Flexible, IDEAL);
    let (_, pair) = flexible_mode(&axis)?;
    Ok(vec![
        Row::holds("its mode is noncolocated", claim, pair.class == ModeClass::Noncolocated),
        Row::close("phase drop, degrees", claim, pair.phase_change_deg, -180.0, 0.0),
        Row::holds("roots in the right half plane at high gain", claim, force_limit(&axis)?.is_finite()),
        Row::close("motor feedback is stable at every gain", claim, position_limit(&axis)?, f64::INFINITY, 0.0),
    ])
}

fn third() -> Result<Vec<Row>, ValidationError> {
    let claim = "claim 3: base and workpiece are dynamically colocated";
    let mut rows = Vec::new();
    for model in [Model::Base, Model::Workpiece] {
        let axis = Axis::reference(model, IDEAL);
        let (_, pair) = flexible_mode(&axis)?;
        let name = model.name();
        rows.push(Row::holds(format!("{name}: the mode is colocated"), claim, pair.class == ModeClass::Colocated));
        rows.push(Row::holds(format!("{name}: a pair of zeros beside it"), claim, pair.zero.is_some()));
        rows.push(Row::close(format!("{name}: phase lost for good, degrees"), claim, pair.phase_change_deg, 0.0, 0.0));
        rows.push(Row::close(format!("{name}: no gain is too large"), claim, force_limit(&axis)?, f64::INFINITY, 0.0));
        let twice = |part: Option<(f64, f64, f64)>| part.map(|(m, k, b)| (m, k, 2.0 * b));
        let damped = Axis { base: twice(axis.base), workpiece: twice(axis.workpiece), ..axis };
        rows.push(Row::holds(
            format!("{name}: more damping shrinks the dip"),
            claim,
            phase_excursion_deg(&damped)? < phase_excursion_deg(&axis)?,
        ));
    }
    let axis = Axis::reference(Model::Workpiece, IDEAL);
    let stiffer = Axis { workpiece: axis.workpiece.map(|(m, k, b)| (m, 2.0 * k, b)), ..axis };
    let raised = flexible_mode(&stiffer)?.0.frequency_hz() > flexible_mode(&axis)?.0.frequency_hz();
    rows.push(Row::holds("workpiece: higher stiffness raises the mode", claim, raised));

    // A mode in which actuator and sensor do not take part: something that swings on the floor beside the machine.
    let base = Axis::reference(Model::Rigid, IDEAL);
    let mut scenario = base.force_loop(ForceGains { kp: 0.1, ..ForceGains::default() }, 1e-3, 0.0);
    scenario.machine.bodies.insert("bystander".into(), Body { mass_kg: 4.0, ..Body::default() });
    scenario.machine.springs.insert("stand".into(), spring(GROUND, "bystander", 4e4, 1.0));
    let harmless = classified(&scenario.machine)?.iter().any(|(_, pair)| pair.class == ModeClass::Uninvolved && pair.dip_deg == 0.0);
    rows.push(Row::holds("a mode without relative motion is uninvolved", claim, harmless));
    let with = ControlLoop::new(&scenario, &View::CLAMPED)?.sampled_bands("kp")?.first_upper();
    let alone = base.force_loop(ForceGains { kp: 0.1, ..ForceGains::default() }, 1e-3, 0.0);
    let without = ControlLoop::new(&alone, &View::CLAMPED)?.sampled_bands("kp")?.first_upper();
    rows.push(Row::relative("and changes no limit", claim, with, without, SAME_EDGE));
    Ok(rows)
}

/// Largest turn of the phase that the flexible mode's poles and zeros cause, degrees.
fn phase_excursion_deg(axis: &Axis) -> Result<f64, ValidationError> {
    let (mode, pair) = flexible_mode(axis)?;
    let f0 = mode.frequency_hz();
    let turn = |i: u32| {
        let w = std::f64::consts::TAU * f0 * (0.7 + 0.6 * f64::from(i) / 20_000.0);
        pair.factor(&mode, feeler_lti::C64::new(0.0, w)).arg().abs()
    };
    Ok((0..=20_000).map(turn).fold(0.0, f64::max).to_degrees())
}

fn fifth() -> Result<Vec<Row>, ValidationError> {
    let claim = "claim 5: three dynamic problems in one machine";
    let axis = Axis::reference(Model::AllThree, SOURCE);
    let found = classified(&axis.machine("axis"))?;
    let flexible = || found.iter().filter(|(_, pair)| !pair.rigid_body);
    let lost: f64 = flexible().map(|(_, pair)| pair.phase_change_deg).sum();
    let drops = flexible().find(|(_, pair)| pair.phase_change_deg < 0.0);
    let lowest_is_base =
        found.first().is_some_and(|(mode, pair)| pair.class == ModeClass::Colocated && (mode.frequency_hz() - 12.0).abs() < 1.5);
    // At a sample rate that costs nothing the machine itself decides, at a low one the sampling.
    let limit = |drive, period_s: f64, axis: &Axis| -> Result<Option<Limit>, ValidationError> {
        let axis = Axis { drive, ..*axis };
        let scenario = axis.force_loop(ForceGains { kp: 1e-4, ..ForceGains::default() }, period_s, 0.0);
        Ok(feeler_analysis::analyze(&scenario, &feeler_analysis::Request { view: View::CLAMPED, ..Default::default() })?.limit)
    };
    Ok(vec![
        Row::close("phase lost for good to flexible modes, degrees", claim, lost, -180.0, 0.0),
        Row::holds("a noncolocated mode takes it", claim, drops.is_some_and(|(_, pair)| pair.class == ModeClass::Noncolocated)),
        Row::holds("the lowest is the base's dip", claim, lowest_is_base),
        Row::holds("transmission limits a fast loop", claim, limit(IDEAL, 2e-5, &axis)? == Some(Limit::NoncolocatedMode)),
        Row::holds("sampling limits a slow one", claim, limit(IDEAL, 2e-3, &axis)? == Some(Limit::Sampling)),
        Row::holds(
            "the actuator limits a rigid one",
            claim,
            limit(SOURCE, 2e-5, &Axis::reference(Model::Rigid, SOURCE))? == Some(Limit::RigidBody),
        ),
    ])
}
