//! The paper's five claims (Eppinger and Seering 1992), each as checked rows.

use feeler_analysis::{
    ControlLoop, Edge, GainBands, Limit, LinearMachine, ModeClass, ModeInPair, VibrationMode, View, classify,
    modes,
};
use feeler_control::{ControllerSpec, ForceGains, Law, PositionGains};
use feeler_engine::Scenario;
use feeler_lti::unwrapped_phase_rad;
use feeler_plant::description::{ActuatorKind, Body, Engagement, Machine, Quantity, SignalName, Spring};

use crate::error::ValidationError;
use crate::landmarks;
use crate::paper::{IDEAL, PaperAxis, PaperModel, SOURCE, gain_of};
use crate::table::CheckRow;

/// Tolerance of two edges found by bisection of eigenvalues of different matrices: 1e-12, with a margin.
const SAME_EDGE: f64 = 1e-9;

/// Precision of the workpiece's edges from the Routh-Hurwitz determinants of its characteristic polynomial.
const THREE_DECIMALS: f64 = 5e-4;
/// The transmission's own damper raises the phase by atan(w c / k), 14 degrees at 400 Hz. Guides and contact
/// change it by a few degrees.
const DAMPERS_DEG: f64 = 20.0;

/// A pair of zeros on a pair of poles, up to their rounding of 1e-16 over a damping ratio of 0.005.
const NO_DIP_DEG: f64 = 1e-9;
/// Far above every mode of the reference axis, Hz.
const FAR_HZ: f64 = 400.0;

/// Whether no gain is too large: one interval without an end.
fn is_unbounded(bands: &GainBands) -> bool {
    matches!(bands.bands.as_slice(), [band] if band.lower.is_none() && band.upper.is_none())
}

fn force_bands(axis: &PaperAxis) -> Result<GainBands, ValidationError> {
    let whole = axis.kp_loop(1e-3, 0.0)?;
    Ok(whole.continuous_bands(gain_of(&whole))?)
}

/// The gain up to which the loop is stable.
fn force_limit(axis: &PaperAxis) -> Result<f64, ValidationError> {
    Ok(force_bands(axis)?.first_upper())
}

/// The same machine under proportional control of the motor's position.
fn position_loop(axis: &PaperAxis) -> Scenario {
    let mut scenario = axis.force_loop(ForceGains::default(), 1e-3, 0.0);
    let gains = PositionGains { kp: 1.0, ..PositionGains::default() };
    for control in scenario.controllers.values_mut() {
        control.spec = ControllerSpec::new(Law::Position(gains), 1e-3);
        control.reads = Some("encoder".into());
    }
    scenario
}

fn position_bands(axis: &PaperAxis) -> Result<GainBands, ValidationError> {
    let whole = ControlLoop::new(&position_loop(axis), &View::CLAMPED)?;
    Ok(whole.continuous_bands(gain_of(&whole))?)
}

/// Phase of the sensed force against the drive at a frequency, degrees, continued from low frequency.
fn phase_deg(axis: &PaperAxis, frequency_hz: f64) -> Result<f64, ValidationError> {
    let plant = LinearMachine::new(&axis.machine("axis"), &View::CLAMPED)?;
    let (input, output) =
        (SignalName::new("drive", Quantity::Command), SignalName::new("tool", Quantity::SpringForce));
    let channel = plant.channel(&input, &output)?;
    let points = 20_000;
    let frequencies_hz: Vec<f64> =
        (0..=points).map(|i| frequency_hz * 1e-4_f64.powf(1.0 - f64::from(i) / f64::from(points))).collect();
    let response: Vec<_> =
        channel.system.frequency_response(&frequencies_hz)?.iter().map(|value| value[(0, 0)]).collect();
    Ok(unwrapped_phase_rad(&response).last().map_or(f64::NAN, |phase| phase.to_degrees()))
}

/// Modes of a machine with their class for drive and elastic contact force.
fn classified(machine: &Machine) -> Result<Vec<(VibrationMode, ModeInPair)>, ValidationError> {
    let plant = LinearMachine::new(machine, &View::CLAMPED)?;
    let own = modes(&plant)?;
    let (input, output) =
        (SignalName::new("drive", Quantity::Command), SignalName::new("tool", Quantity::SpringForce));
    let channel = plant.channel(&input, &output)?;
    let pairs = classify(&plant, &own, plant.drive(&input)?, plant.source(&output)?, &channel)?;
    Ok(own.into_iter().zip(pairs).collect())
}

/// The flexible mode of a model that has one.
fn flexible_mode(axis: &PaperAxis) -> Result<(VibrationMode, ModeInPair), ValidationError> {
    let found = classified(&axis.machine("axis"))?.into_iter().find(|(_, pair)| !pair.rigid_body);
    found.ok_or_else(|| ValidationError::Reference { what: "a machine without a flexible mode".into() })
}

/// Rows for all five claims. The fourth needs the fitted machine and is as exact as its landmarks.
///
/// # Errors
/// [`ValidationError`] if a computation fails.
pub fn claim_rows() -> Result<Vec<CheckRow>, ValidationError> {
    let mut rows = first()?;
    rows.extend(second()?);
    rows.extend(third()?);
    rows.extend(landmarks::rows(&landmarks::fitted(Engagement::Free)?)?);
    rows.extend(fifth()?);
    Ok(rows)
}

fn first() -> Result<Vec<CheckRow>, ValidationError> {
    let claim = "claim 1: rigid-body bandwidth";
    let rigid = |drive| PaperAxis::reference(PaperModel::Rigid, drive);
    let source = |time_constant_s| ActuatorKind::VelocitySource { damping_n_s_per_m: 600.0, time_constant_s };
    let (slow, usual, fast) = (
        force_limit(&rigid(source(4e-3)))?,
        force_limit(&rigid(SOURCE))?,
        force_limit(&rigid(source(1e-3)))?,
    );
    let k_s = rigid(SOURCE).contact.0;
    Ok(vec![
        CheckRow::holds(
            "an ideal actuator is stable at every gain",
            claim,
            is_unbounded(&force_bands(&rigid(IDEAL))?),
        ),
        CheckRow::holds(
            "its phase stays above -180 degrees",
            claim,
            phase_deg(&rigid(IDEAL), FAR_HZ)? > -180.0,
        ),
        CheckRow::holds("the actuator's falls below", claim, phase_deg(&rigid(SOURCE), FAR_HZ)? < -180.0),
        CheckRow::holds("the actuator's pole bounds the gain", claim, usual.is_finite()),
        CheckRow::holds("more actuator bandwidth raises the bound", claim, slow < usual && usual < fast),
        // f_s = k_s x_r: a gain on position is k_s times one on force, and reaches the same limit.
        CheckRow::relative(
            "position control meets the same limit, over the contact stiffness",
            claim,
            position_bands(&rigid(SOURCE))?.first_upper() / k_s,
            usual,
            SAME_EDGE,
        ),
    ])
}

fn second() -> Result<Vec<CheckRow>, ValidationError> {
    let claim = "claim 2: transmission flexibility is dynamically noncolocated";
    let axis = PaperAxis::reference(PaperModel::Flexible, IDEAL);
    let (_, pair) = flexible_mode(&axis)?;
    Ok(vec![
        CheckRow::holds("its mode is noncolocated", claim, pair.class == ModeClass::Noncolocated),
        CheckRow::close(
            "phase drop against the rigid body, read from the response at 400 Hz, degrees",
            claim,
            phase_deg(&axis, FAR_HZ)? - phase_deg(&PaperAxis::reference(PaperModel::Rigid, IDEAL), FAR_HZ)?,
            pair.phase_change_deg,
            DAMPERS_DEG,
        ),
        CheckRow::close(
            "phase drop by its poles and zeros, degrees",
            claim,
            pair.phase_change_deg,
            -180.0,
            0.0,
        ),
        CheckRow::holds("roots in the right half plane at high gain", claim, force_limit(&axis)?.is_finite()),
        CheckRow::holds(
            "motor feedback is stable at every gain",
            claim,
            is_unbounded(&position_bands(&axis)?),
        ),
    ])
}

fn third() -> Result<Vec<CheckRow>, ValidationError> {
    let claim = "claim 3: base and workpiece are dynamically colocated";
    let mut rows = Vec::new();
    for model in [PaperModel::Base, PaperModel::Workpiece] {
        let axis = PaperAxis::reference(model, IDEAL);
        let (_, pair) = flexible_mode(&axis)?;
        let name = model.name();
        rows.push(CheckRow::holds(
            format!("{name}: the mode is colocated"),
            claim,
            pair.class == ModeClass::Colocated,
        ));
        rows.push(CheckRow::holds(format!("{name}: a pair of zeros beside it"), claim, pair.zero.is_some()));
        let lost =
            phase_deg(&axis, FAR_HZ)? - phase_deg(&PaperAxis::reference(PaperModel::Rigid, IDEAL), FAR_HZ)?;
        rows.push(CheckRow::close(
            format!("{name}: phase lost, read from the response at 400 Hz, degrees"),
            claim,
            lost,
            pair.phase_change_deg,
            DAMPERS_DEG,
        ));
        let twice = |part: Option<(f64, f64, f64)>| part.map(|(m, k, b)| (m, k, 2.0 * b));
        let damped = PaperAxis { base: twice(axis.base), workpiece: twice(axis.workpiece), ..axis };
        rows.push(CheckRow::holds(
            format!("{name}: more damping shrinks the dip"),
            claim,
            phase_excursion_deg(&damped)? < phase_excursion_deg(&axis)?,
        ));
        rows.push(CheckRow::holds(
            format!("{name}: with twice the damping no gain is too large"),
            claim,
            is_unbounded(&force_bands(&damped)?),
        ));
    }
    let base = force_bands(&PaperAxis::reference(PaperModel::Base, IDEAL))?;
    rows.push(CheckRow::holds(
        "base: with the reference damping no gain is too large",
        claim,
        is_unbounded(&base),
    ));
    let axis = PaperAxis::reference(PaperModel::Workpiece, IDEAL);
    // The dip of the workpiece's mode costs more phase than the margin between these gains.
    let bands = force_bands(&axis)?.bands;
    let edge = |edge: Option<&Edge>| edge.map_or(f64::NAN, |edge| edge.gain);
    let (up_to, from) = (
        edge(bands.first().and_then(|b| b.upper.as_ref())),
        edge(bands.last().and_then(|b| b.lower.as_ref())),
    );
    rows.push(CheckRow::close(
        "workpiece: with the reference damping, gains are too large from",
        claim,
        up_to,
        11.743,
        THREE_DECIMALS,
    ));
    rows.push(CheckRow::close("workpiece: up to", claim, from, 40.657, THREE_DECIMALS));
    rows.push(CheckRow::holds(
        "workpiece: no larger gain is too large",
        claim,
        bands.len() == 2 && bands[1].upper.is_none(),
    ));
    let stiffer = PaperAxis { workpiece: axis.workpiece.map(|(m, k, b)| (m, 2.0 * k, b)), ..axis };
    let raised = flexible_mode(&stiffer)?.0.frequency_hz() > flexible_mode(&axis)?.0.frequency_hz();
    rows.push(CheckRow::holds("workpiece: higher stiffness raises the mode", claim, raised));

    rows.extend(bystanders()?);
    Ok(rows)
}

/// A mode in which actuator and sensor do not take part: two equal bodies that swing on the tip against each
/// other. Together they equal one of twice the size.
fn bystanders() -> Result<Vec<CheckRow>, ValidationError> {
    let claim = "claim 3: base and workpiece are dynamically colocated";
    let carrying = |count: usize, share: f64| {
        let axis = PaperAxis::reference(PaperModel::Rigid, IDEAL);
        let mut scenario = axis.force_loop(ForceGains { kp: 0.1, ..ForceGains::default() }, 1e-3, 0.0);
        for i in 0..count {
            let name = format!("bystander-{i}");
            let stalk = Spring::new("tip", name.as_str(), 4e4 * share, 4.0 * share);
            scenario.machine.bodies.insert(name, Body::new(4.0 * share));
            scenario.machine.springs.insert(format!("stalk-{i}"), stalk);
        }
        scenario
    };
    let (two, one) = (carrying(2, 1.0), carrying(1, 2.0));
    let uninvolved = classified(&two.machine)?
        .iter()
        .any(|(_, pair)| pair.class == ModeClass::Uninvolved && pair.dip_deg.abs() < NO_DIP_DEG);
    let limit = |scenario: &Scenario| -> Result<f64, ValidationError> {
        let whole = ControlLoop::new(scenario, &View::CLAMPED)?;
        Ok(whole.sampled_bands(gain_of(&whole))?.first_upper())
    };
    Ok(vec![
        CheckRow::holds("a mode without motion of actuator and sensor is uninvolved", claim, uninvolved),
        CheckRow::relative("and changes no limit", claim, limit(&two)?, limit(&one)?, SAME_EDGE),
    ])
}

/// Largest phase change by the poles and zeros of the flexible mode, degrees.
fn phase_excursion_deg(axis: &PaperAxis) -> Result<f64, ValidationError> {
    let (mode, pair) = flexible_mode(axis)?;
    let f0 = mode.frequency_hz();
    let turn = |i: u32| {
        let w = std::f64::consts::TAU * f0 * (0.7 + 0.6 * f64::from(i) / 20_000.0);
        pair.factor(&mode, feeler_lti::C64::new(0.0, w)).arg().abs()
    };
    Ok((0..=20_000).map(turn).fold(0.0, f64::max).to_degrees())
}

fn fifth() -> Result<Vec<CheckRow>, ValidationError> {
    let claim = "claim 5: three dynamic problems in one machine";
    let axis = PaperAxis::reference(PaperModel::AllThree, SOURCE);
    let found = classified(&axis.machine("axis"))?;
    let flexible = || found.iter().filter(|(_, pair)| !pair.rigid_body);
    let lost: f64 = flexible().map(|(_, pair)| pair.phase_change_deg).sum();
    let drops = flexible().find(|(_, pair)| pair.phase_change_deg < 0.0);
    let lowest_is_base = found.first().is_some_and(|(mode, pair)| {
        pair.class == ModeClass::Colocated && (mode.frequency_hz() - 12.0).abs() < 1.5
    });
    // At a very high sample rate the machine itself limits the loop; at a low one the sampling does.
    let limit = |drive, period_s: f64, axis: &PaperAxis| -> Result<Option<Limit>, ValidationError> {
        let axis = PaperAxis { drive, ..*axis };
        let scenario = axis.force_loop(ForceGains { kp: 1e-4, ..ForceGains::default() }, period_s, 0.0);
        Ok(feeler_analysis::analyze(
            &scenario,
            &feeler_analysis::Request { view: View::CLAMPED, ..Default::default() },
        )?
        .limit())
    };
    Ok(vec![
        CheckRow::close("phase lost to flexible modes, degrees", claim, lost, -180.0, 0.0),
        CheckRow::holds(
            "a noncolocated mode takes it",
            claim,
            drops.is_some_and(|(_, pair)| pair.class == ModeClass::Noncolocated),
        ),
        CheckRow::holds("the lowest is the base's dip", claim, lowest_is_base),
        CheckRow::holds(
            "transmission limits a fast loop",
            claim,
            limit(IDEAL, 2e-5, &axis)? == Some(Limit::NoncolocatedMode),
        ),
        CheckRow::holds(
            "sampling limits a slow one",
            claim,
            limit(IDEAL, 2e-3, &axis)? == Some(Limit::Sampling),
        ),
        CheckRow::holds(
            "the actuator limits a rigid one",
            claim,
            limit(SOURCE, 2e-5, &PaperAxis::reference(PaperModel::Rigid, SOURCE))? == Some(Limit::RigidBody),
        ),
    ])
}
