//! The machine file of an arm along a contact normal.

use std::fmt::Write as _;

use feeler_analysis::{GainReport, Request, analyze};
use feeler_arm::{Agreement, Branch, Landmark, Others, Reduction};
use feeler_control::{Approach, ControllerSpec, ForceGains, Law, ReferenceSpec};
use feeler_engine::{ControllerUse, Scenario};
use feeler_files::{ArmFile, Document, FormatError, to_toml};
use feeler_plant::description::{
    Actuator, ActuatorKind, Body, Contact, GROUND, Machine, Quantity, Sensor, SignalName, Spring,
};
use feeler_plant::effects::{CoulombFriction, EffectUse};

use super::error::ArmFileError;

/// Gain in a written file, as a share of the largest stable gain.
const GAIN_SHARE: f64 = 0.25;
/// Gain of the machine while the largest stable gain is sought.
const TRIED_GAIN: f64 = 0.1;
/// Largest gain in a written file.
const LARGEST_GAIN: f64 = 2.0;

/// Names of the elements of a written file.
const MOTOR: &str = "motor";
const TIP: &str = "tip";
const TOOL: &str = "tool";
const DRIVE: &str = "drive";
const FORCE: &str = "force";
const ENCODER: &str = "encoder";
/// Gap between tool and workpiece, and how the loop closes it and presses.
const GAP_M: f64 = 1e-3;
const SPEED_M_PER_S: f64 = 0.01;
const TOUCH_N: f64 = 3.0;
const REFERENCE_N: f64 = 20.0;
const PERIOD_S: f64 = 1e-3;
const DURATION_S: f64 = 2.0;
const RECORD_RATE_HZ: f64 = 2e3;

/// Smallest share of the path from drive to tool at which a warning names a mode.
const SHARES: f64 = 0.1;

/// The contact at the tool: the force sensor in series with the workpiece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolContact {
    pub stiffness_n_per_m: f64,
    pub damping_n_s_per_m: f64,
}

/// The axis that represents an arm.
#[derive(Clone, Debug)]
pub struct AxisFile {
    /// The machine and scenario, as input of analyze, run, sweep and why.
    pub text: String,
    /// Its masses, stiffnesses and modes.
    pub reduction: Reduction,
    /// Its agreement with the whole arm in contact.
    pub agreement: Agreement,
    /// Largest stable proportional force gain at 1 kHz; zero if no gain is stable, infinite if all are.
    pub largest_gain: f64,
}

/// The error for an axis whose numbers make no valid machine file. The user did not write that file, so the
/// error names no place in it.
fn no_machine(error: &FormatError) -> ArmFileError {
    let why = error.problems.first().map_or_else(String::new, |problem| problem.message.clone());
    ArmFileError::Extreme { why }
}

/// The axis of an arm at a pose (rad, m) along a normal that points from the tool into the workpiece.
///
/// # Errors
/// [`ArmFileError`] for poses and directions in which the arm cannot move.
pub fn axis_file(
    file: &ArmFile,
    pose: &[f64],
    normal: [f64; 3],
    others: Others,
    contact: ToolContact,
) -> Result<AxisFile, ArmFileError> {
    let touch = [contact.stiffness_n_per_m, contact.damping_n_s_per_m];
    let (reduction, agreement) = file.arm.reduce_in_contact(pose, normal, others, touch)?;
    let mut written = scenario(&reduction, contact, TRIED_GAIN);
    let document = Document::parse(&to_toml(&written), "axis.toml").map_err(|error| no_machine(&error))?;
    let report = analyze(&document.scenario, &Request::default())?;
    let edge = largest_stable(report.gain());
    let gain = (GAIN_SHARE * edge).min(LARGEST_GAIN);
    let mut text = header(file, pose, normal, others, &agreement, touch[0]);
    text.push_str(&bodies_note(&reduction));
    if let Some(why) = distrust(&reduction, &agreement) {
        let _ = writeln!(text, "# Warning: {why}.");
    }
    let held = if others == Others::Held { "other directions held" } else { "other directions free" };
    written = scenario(&reduction, contact, gain);
    written.machine.name = format!("{}-axis", file.name);
    written.machine.about = format!("The axis of {} at one pose along one normal, {held}", file.name);
    text.push_str(&to_toml(&written));
    Ok(AxisFile { text, reduction, agreement, largest_gain: edge })
}

/// The largest stable gain of a report: zero if no gain is stable, infinite if all are.
fn largest_stable(gain: Option<&GainReport>) -> f64 {
    match gain.map(|gain| (gain.sampled.all.bands.is_empty(), gain.sampled.stable[1])) {
        Some((true, _)) => 0.0,
        Some((false, Some(edge))) => edge,
        _ => f64::INFINITY,
    }
}

/// The reason not to trust an axis: a landmark differs from the whole arm's by more than 5 %. `None` if none
/// does.
pub fn distrust(axis: &Reduction, agreement: &Agreement) -> Option<String> {
    if agreement.is_trusted() {
        return None;
    }
    let off: Vec<String> = (Landmark::ALL.iter().zip(agreement.misfits()).zip(agreement.landmarks()))
        .filter(|((_, misfit), _)| *misfit > Agreement::TRUSTED)
        .map(|((landmark, misfit), [arm, own])| match misfit.is_finite() {
            true => format!("{:.1} % in the {}", 100.0 * misfit, landmark.name()),
            false if landmark.is_gain() && own <= 0.0 => {
                format!("in the {}, which only the arm has", landmark.name())
            }
            false if landmark.is_gain() && arm <= 0.0 => {
                format!("in the {}, which only the axis has", landmark.name())
            }
            false => format!("without bound in the {}", landmark.name()),
        })
        .collect();
    let sharing: Vec<String> = axis
        .modes
        .iter()
        .filter(|mode| mode.drive_share.abs() > SHARES)
        .map(|mode| format!("{:.1}", mode.frequency_hz))
        .collect();
    Some(format!(
        "this axis differs from the arm by {}, more than {:.0} %. Modes of the arm at {} Hz share the path \
         from drive to tool, which a few masses on springs cannot represent. Choose another pose, or do not \
         rely on these values of the axis",
        off.join(" and "),
        100.0 * Agreement::TRUSTED,
        sharing.join(", ")
    ))
}

/// A largest stable gain in words, if it is not a number: `none` if no gain is stable, `every gain` if all
/// are.
pub fn gain_in_words(gain: f64) -> Option<&'static str> {
    match gain {
        gain if gain.is_nan() => Some("unknown"),
        gain if gain <= 0.0 => Some("none"),
        gain if gain.is_infinite() => Some("every gain"),
        _ => None,
    }
}

fn header(
    file: &ArmFile,
    pose: &[f64],
    normal: [f64; 3],
    others: Others,
    agreement: &Agreement,
    stiffness: f64,
) -> String {
    let pose: Vec<String> = pose.iter().map(|x| format!("{x:.5}")).collect();
    let [nx, ny, nz] = normal;
    let said = |landmark: &Landmark, [arm, own]: [f64; 2], misfit: f64| {
        let number = |value: f64| match landmark.is_gain() {
            true => gain_in_words(value).map_or_else(|| format!("{value:.4}"), str::to_owned),
            false if value.is_nan() => "none".to_owned(),
            false => format!("{value:.3}"),
        };
        let unit = match landmark {
            Landmark::ContactMode | Landmark::PhaseCrossover => " Hz",
            Landmark::StableKp => "",
            Landmark::StableKi => " 1/s",
        };
        let name = landmark.name();
        if [arm, own].iter().all(|value| value.is_nan()) {
            return format!("#   {name}: neither has one\n");
        }
        if landmark.is_gain() && number(arm) == number(own) && gain_in_words(arm).is_some() {
            return format!("#   {name}: {} for both\n", number(arm));
        }
        let with_unit =
            |value: f64| if value.is_finite() { format!("{}{unit}", number(value)) } else { number(value) };
        format!("#   {name}: {} and {}: off by {}\n", with_unit(arm), with_unit(own), percent(misfit))
    };
    let landmarks: String = (Landmark::ALL.iter().zip(agreement.landmarks()).zip(agreement.misfits()))
        .map(|((name, pair), misfit)| said(name, pair, misfit))
        .collect();
    format!(
        "# The axis of {} at the pose {} (rad) along [{nx}, {ny}, {nz}], with the tool's other directions \
         {}; made by `feeler reduce`.\n\
         # Whole arm and this axis on a contact of {stiffness:.4e} N/m. The phase crossover is that of the \
         whole contact force, without\n\
         # the drives' bandwidths. Stable gains are those of loops on its spring's force at 1 kHz, with \
         these bandwidths; ki with\n\
         # {:.4} N s/m of motor damping from differenced encoder positions.\n{landmarks}",
        file.name,
        pose.join(", "),
        if others == Others::Held { "held" } else { "free" },
        agreement.motor_damping_n_s_per_m,
    )
}

fn percent(misfit: f64) -> String {
    if misfit.is_finite() { format!("{:.2} %", 100.0 * misfit) } else { "an undefined share".into() }
}

/// The reason for bodies besides motor and tool, as a comment of the file; empty if there are none.
fn bodies_note(axis: &Reduction) -> String {
    let frequencies: Vec<String> =
        axis.branches.iter().map(|branch| format!("{:.2}", branch.frequency_hz())).collect();
    let (bodies, verb) =
        if frequencies.len() == 1 { ("A body", "represents") } else { ("Bodies", "represent") };
    let linked = axis.branches.iter().any(Branch::is_linked);
    let (place, held) = if linked {
        ("beside motor and tool, fitted to the arm's response,", "motor and tool")
    } else {
        ("beside the motor", "motors")
    };
    if frequencies.is_empty() {
        return String::new();
    }
    format!(
        "# {bodies} {place} {verb} modes at {} Hz (with {held} held), which load the drive too. Two masses \
         alone miss these.\n",
        frequencies.join(", ")
    )
}

/// The machine and its force loop.
fn scenario(axis: &Reduction, contact: ToolContact, gain: f64) -> Scenario {
    let mut guide = Spring::new(GROUND, MOTOR, 0.0, axis.guide_damping_n_s_per_m);
    if axis.dry_friction_n > 0.0 {
        guide.effects.push(EffectUse::of(CoulombFriction { level: axis.dry_friction_n }));
    }
    let transmission = Spring::new(MOTOR, TIP, axis.stiffness_n_per_m, axis.damping_n_s_per_m);
    let mut machine = Machine::default()
        .with_body(MOTOR, Body::new(axis.motor_mass_kg))
        .with_body(TIP, Body::new(axis.tip_mass_kg))
        .with_spring("guide", guide)
        .with_spring("transmission", transmission);
    for (number, branch) in (1..).zip(&axis.branches) {
        let name = format!("branch-{number}");
        let held = Spring::new(MOTOR, &name, branch.stiffness_n_per_m, branch.damping_n_s_per_m);
        let to_tool = Spring::new(&name, TIP, branch.to_tool_n_per_m, branch.to_tool_n_s_per_m);
        machine = machine.with_body(&name, Body::new(branch.mass_kg)).with_spring(&name, held);
        if branch.is_linked() {
            machine = machine.with_spring(format!("{name}-tool"), to_tool);
        }
    }
    let touched = Contact::kelvin_voigt(TIP, GROUND, contact.stiffness_n_per_m, contact.damping_n_s_per_m);
    let drive = Actuator {
        limit_n: axis.force_limit_n,
        kind: ActuatorKind::Force { bandwidth_hz: axis.bandwidth_hz },
        ..Actuator::ideal(MOTOR, GROUND)
    };
    let position = SignalName::new(MOTOR, Quantity::Position);
    let machine = machine
        .with_contact(TOOL, Contact { gap_m: GAP_M, ..touched })
        .with_actuator(DRIVE, drive)
        .with_sensor(FORCE, Sensor::ideal(SignalName::new(TOOL, Quantity::SpringForce)))
        .with_sensor(ENCODER, Sensor::ideal(position.clone()));
    let law = Law::ExplicitForce(ForceGains { feed_forward: 1.0, kp: gain, ..ForceGains::default() });
    let spec = ControllerSpec {
        approach: Some(Approach::new(SPEED_M_PER_S, TOUCH_N, 0.0)),
        reference: ReferenceSpec::Constant(REFERENCE_N),
        ..ControllerSpec::new(law, PERIOD_S)
    };
    let controller =
        ControllerUse { motion: Some(ENCODER.into()), ..ControllerUse::new(spec, DRIVE).reading(FORCE) };
    let recorded = [
        SignalName::new(TOOL, Quantity::Force),
        position,
        SignalName::new(TIP, Quantity::Position),
        SignalName::new(DRIVE, Quantity::Command),
        SignalName::new(FORCE, Quantity::Reading),
    ];
    Scenario::new(machine)
        .with_controller(FORCE, controller)
        .lasting(DURATION_S)
        .recording(recorded, RECORD_RATE_HZ)
}
