//! The result of a reduction, for programs. The book shows the comments.

use feeler_arm::{Agreement, MeasuredArm};
use feeler_studies::arm::{AxisFile, MapPoint, NoAxis, distrust};
use serde::Serialize;

/// The axis of an arm along a normal.
#[expect(clippy::struct_field_names, reason = "keys of the output")]
#[derive(Serialize)]
pub(super) struct Axis<'a> {
    /// Joint positions, rad or m.
    pose: &'a [f64],
    /// Mass of the rigid arm along the normal.
    mass_kg: f64,
    /// Part of the mass on the motors' side of the spring.
    motor_mass_kg: f64,
    /// Part of the mass on the tool's side of the spring.
    tip_mass_kg: f64,
    /// Mass of the links alone, which a sudden impact on the tool encounters.
    link_mass_kg: f64,
    /// The spring between the two masses.
    stiffness_n_per_m: f64,
    /// Damping of that spring.
    damping_n_s_per_m: f64,
    /// Stiffness against a slow force on the tool, with locked motors.
    static_stiffness_n_per_m: f64,
    /// Viscous friction of the motors.
    guide_damping_n_s_per_m: f64,
    /// Dry friction of the motors.
    dry_friction_n: f64,
    /// Largest force within the limit of every motor; `None` without limits.
    force_limit_n: Option<f64>,
    /// Bandwidth of the slowest drive that moves along the normal; `None` if no drive has one.
    bandwidth_hz: Option<f64>,
    /// Further bodies; empty if two masses are enough.
    branches: Vec<Branch>,
    /// Joint motion per metre of the tool along the normal, rad/m or m/m.
    direction: &'a [f64],
    /// Modes that bend joints, with the tool free, slowest first.
    modes: Vec<Mode>,
    /// Frequency of the mode in which the arm moves on the contact.
    contact_mode_hz: Pair,
    /// Frequency at which the phase from drive force to contact force falls through -180 degrees.
    phase_crossover_hz: Pair,
    /// Largest stable gain of proportional force control, sampled at 1 kHz.
    stable_kp: Pair,
    /// Largest stable gain of integral force control, sampled at 1 kHz.
    stable_ki_per_s: Pair,
    /// Force bandwidth of the arm under integral control with a gain margin of 2.
    force_bandwidth_hz: f64,
    /// Force bandwidth of the axis under the same control.
    axis_force_bandwidth_hz: f64,
    /// Damping of the motors in the integral loop.
    motor_damping_n_s_per_m: f64,
    /// Differences of the axis from the arm.
    misfit: Misfit,
    /// Reason why the axis should not be trusted; `None` if it agrees with the arm to 5 %.
    warning: Option<String>,
    /// Largest stable proportional gain of the written axis at 1 kHz; `None` if every gain is stable.
    largest_stable_kp: f64,
    /// The arm measured in simulation; absent without `--measure`.
    #[serde(skip_serializing_if = "Option::is_none")]
    measured: Option<Measurement<'a>>,
    /// The places of the map; absent without `--map`.
    #[serde(skip_serializing_if = "Option::is_none")]
    map: Option<Vec<Place<'a>>>,
}

/// A number of the whole arm and of its axis.
#[derive(Serialize)]
struct Pair {
    /// Value of the whole arm; `None` if there is no such value, or if it is unlimited.
    arm: f64,
    /// Value of the axis; `None` likewise.
    axis: f64,
}

/// A body on a spring of its own.
#[derive(Serialize)]
struct Branch {
    /// Mass of the body.
    mass_kg: f64,
    /// Stiffness of the spring to the motor.
    stiffness_n_per_m: f64,
    /// Damping of that spring.
    damping_n_s_per_m: f64,
    /// Stiffness of the spring to the tool; zero if there is none.
    to_tool_n_per_m: f64,
    /// Damping of that spring.
    to_tool_n_s_per_m: f64,
    /// Natural frequency of the body with motor and tool held.
    frequency_hz: f64,
}

/// A mode that bends joints.
#[derive(Serialize)]
struct Mode {
    /// Frequency of the mode.
    frequency_hz: f64,
    /// Damping ratio of the mode.
    damping_ratio: f64,
    /// Contribution of the mode to the response from drive force to tool, relative to the arm's mass. It is
    /// negative for a noncolocated mode.
    drive_share: f64,
    /// Contribution of the mode to the response of the tool to a force there, relative to the arm's mass.
    tip_share: f64,
}

/// Differences of the axis from the arm, as shares of the arm's values; `None` if only one has the value.
#[derive(Serialize)]
struct Misfit {
    /// Difference of the contact mode.
    contact_mode: f64,
    /// Difference of the phase crossover.
    phase_crossover: f64,
    /// Difference of the largest stable proportional gain.
    stable_kp: f64,
    /// Difference of the largest stable integral gain.
    stable_ki: f64,
    /// Whether all differences are at most 5 %.
    trusted: bool,
}

/// The arm measured in simulation.
#[derive(Serialize)]
struct Measurement<'a> {
    /// Frequency at which the phase falls below -90 degrees.
    contact_mode_hz: Pair,
    /// Frequency at which the phase falls below -180 degrees.
    phase_crossover_hz: Pair,
    /// Lines of the multisine.
    frequencies_hz: &'a [f64],
    /// Real part of contact force over drive force at each line.
    real: Vec<f64>,
    /// Imaginary part of contact force over drive force at each line.
    imaginary: Vec<f64>,
    /// Length of the simulation.
    simulated_s: f64,
}

/// A place of a map.
#[expect(clippy::struct_field_names, reason = "keys of the output")]
#[derive(Serialize)]
struct Place<'a> {
    /// Position of the tool.
    place_m: [f64; 3],
    /// The axis there; `None` if there is none.
    found: Option<AxisThere<'a>>,
    /// Why there is no axis; `None` if there is one.
    reason: Option<&'a str>,
}

/// The axis at a place of a map.
#[derive(Serialize)]
struct AxisThere<'a> {
    /// Joint positions, rad or m.
    pose: &'a [f64],
    /// Mass along the normal.
    mass_kg: f64,
    /// Stiffness along the normal, with locked motors.
    stiffness_n_per_m: f64,
    /// Largest stable gain of integral force control of the whole arm.
    largest_ki_per_s: f64,
    /// Force bandwidth of the arm under integral control with a gain margin of 2.
    force_bandwidth_hz: f64,
    /// Force bandwidth of the axis under the same control.
    axis_force_bandwidth_hz: f64,
    /// Differences of the axis from the arm there.
    misfit: Misfit,
}

impl<'a> Axis<'a> {
    pub(super) fn new(
        axis: &'a AxisFile,
        pose: &'a [f64],
        measured: Option<&'a MeasuredArm>,
        map: Option<&'a [MapPoint]>,
    ) -> Self {
        let one = &axis.reduction;
        let agreement = &axis.agreement;
        let modes = one.modes.iter().map(|mode| Mode {
            frequency_hz: mode.frequency_hz,
            damping_ratio: mode.damping_ratio,
            drive_share: mode.drive_share,
            tip_share: mode.tip_share,
        });
        let branches = one.branches.iter().map(|branch| Branch {
            mass_kg: branch.mass_kg,
            stiffness_n_per_m: branch.stiffness_n_per_m,
            damping_n_s_per_m: branch.damping_n_s_per_m,
            to_tool_n_per_m: branch.to_tool_n_per_m,
            to_tool_n_s_per_m: branch.to_tool_n_s_per_m,
            frequency_hz: branch.frequency_hz(),
        });
        Self {
            pose,
            mass_kg: one.mass_kg,
            motor_mass_kg: one.motor_mass_kg,
            tip_mass_kg: one.tip_mass_kg,
            link_mass_kg: one.link_mass_kg,
            stiffness_n_per_m: one.stiffness_n_per_m,
            damping_n_s_per_m: one.damping_n_s_per_m,
            static_stiffness_n_per_m: one.static_stiffness_n_per_m,
            guide_damping_n_s_per_m: one.guide_damping_n_s_per_m,
            dry_friction_n: one.dry_friction_n,
            force_limit_n: one.force_limit_n,
            bandwidth_hz: one.bandwidth_hz,
            branches: branches.collect(),
            direction: &one.direction,
            modes: modes.collect(),
            contact_mode_hz: Pair::new(agreement.contact_mode_hz),
            phase_crossover_hz: Pair::new(agreement.phase_crossover_hz),
            stable_kp: Pair::new(agreement.largest_kp),
            stable_ki_per_s: Pair::new(agreement.largest_ki_per_s),
            force_bandwidth_hz: agreement.force_bandwidth_hz[0],
            axis_force_bandwidth_hz: agreement.force_bandwidth_hz[1],
            motor_damping_n_s_per_m: agreement.motor_damping_n_s_per_m,
            misfit: Misfit::new(agreement),
            warning: distrust(one, agreement),
            largest_stable_kp: axis.largest_gain,
            measured: measured.map(Measurement::new),
            map: map.map(|points| points.iter().map(Place::new).collect()),
        }
    }
}

impl Pair {
    fn new([arm, axis]: [f64; 2]) -> Self {
        Self { arm, axis }
    }
}

impl Misfit {
    fn new(agreement: &Agreement) -> Self {
        let [contact_mode, phase_crossover, stable_kp, stable_ki] = agreement.misfits();
        Self { contact_mode, phase_crossover, stable_kp, stable_ki, trusted: agreement.is_trusted() }
    }
}

impl<'a> Measurement<'a> {
    fn new(found: &'a MeasuredArm) -> Self {
        Self {
            contact_mode_hz: Pair::new(found.contact_mode_hz),
            phase_crossover_hz: Pair::new(found.phase_crossover_hz),
            frequencies_hz: &found.frequencies_hz,
            real: found.response.iter().map(|z| z.re).collect(),
            imaginary: found.response.iter().map(|z| z.im).collect(),
            simulated_s: found.simulated_s,
        }
    }
}

impl<'a> Place<'a> {
    fn new(point: &'a MapPoint) -> Self {
        let found = point.found.as_ref().ok().map(|found| AxisThere {
            pose: &found.pose,
            mass_kg: found.mass_kg,
            stiffness_n_per_m: found.stiffness_n_per_m,
            largest_ki_per_s: found.agreement.largest_ki_per_s[0],
            force_bandwidth_hz: found.agreement.force_bandwidth_hz[0],
            axis_force_bandwidth_hz: found.agreement.force_bandwidth_hz[1],
            misfit: Misfit::new(&found.agreement),
        });
        Self { place_m: point.place_m, found, reason: point.found.as_ref().err().map(NoAxis::reason) }
    }
}
