//! What a reduction found, for programs.

use feeler_arm::{Agreement, Measured};
use feeler_studies::arm::{AxisFile, MapPoint, NoAxis, distrust};
use serde_json::{Value, json};

pub(super) fn measured(found: &Measured) -> Value {
    json!({
        "contact_mode_hz": pair(found.contact_mode_hz), "phase_crossover_hz": pair(found.phase_crossover_hz),
        "frequencies_hz": found.frequencies_hz,
        "real": found.response.iter().map(|z| number(z.re)).collect::<Vec<_>>(),
        "imaginary": found.response.iter().map(|z| number(z.im)).collect::<Vec<_>>(),
        "simulated_s": found.simulated_s,
    })
}

/// A number for JSON, which has no infinities.
fn number(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { Value::Null }
}

fn pair([arm, axis]: [f64; 2]) -> Value {
    json!({ "arm": number(arm), "axis": number(axis) })
}

pub(super) fn axis(axis: &AxisFile, pose: &[f64]) -> Value {
    let one = &axis.reduction;
    let agreement = &axis.agreement;
    let modes = one.modes.iter().map(|mode| {
        json!({
            "frequency_hz": mode.frequency_hz, "damping_ratio": mode.damping_ratio,
            "drive_share": mode.drive_share, "tip_share": mode.tip_share,
        })
    });
    let branches = one.branches.iter().map(|branch| {
        json!({
            "mass_kg": branch.mass_kg,
            "stiffness_n_per_m": branch.stiffness_n_per_m,
            "damping_n_s_per_m": branch.damping_n_s_per_m,
            "to_tool_n_per_m": branch.to_tool_n_per_m,
            "to_tool_n_s_per_m": branch.to_tool_n_s_per_m,
            "frequency_hz": branch.frequency_hz(),
        })
    });
    json!({
        "pose": pose,
        "mass_kg": one.mass_kg,
        "motor_mass_kg": one.motor_mass_kg,
        "tip_mass_kg": one.tip_mass_kg,
        "link_mass_kg": one.link_mass_kg,
        "stiffness_n_per_m": one.stiffness_n_per_m,
        "damping_n_s_per_m": one.damping_n_s_per_m,
        "static_stiffness_n_per_m": one.static_stiffness_n_per_m,
        "guide_damping_n_s_per_m": one.guide_damping_n_s_per_m,
        "dry_friction_n": one.dry_friction_n,
        "force_limit_n": one.force_limit_n,
        "bandwidth_hz": one.bandwidth_hz,
        "branches": branches.collect::<Vec<_>>(),
        "direction": one.direction,
        "modes": modes.collect::<Vec<_>>(),
        "contact_mode_hz": pair(agreement.contact_mode_hz),
        "phase_crossover_hz": pair(agreement.phase_crossover_hz),
        "stable_kp": pair(agreement.largest_kp),
        "stable_ki_per_s": pair(agreement.largest_ki_per_s),
        "force_bandwidth_hz": number(agreement.force_bandwidth_hz[0]),
        "axis_force_bandwidth_hz": number(agreement.force_bandwidth_hz[1]),
        "motor_damping_n_s_per_m": agreement.motor_damping_n_s_per_m,
        "misfit": misfit(agreement),
        "warning": distrust(one, agreement),
        "largest_stable_kp": number(axis.largest_gain),
    })
}

/// Differences of the axis from the arm, relative to the arm; null if only one of them has the landmark.
fn misfit(agreement: &Agreement) -> Value {
    let [mode, crossover, kp, ki] = agreement.misfits().map(number);
    json!({
        "contact_mode": mode,
        "phase_crossover": crossover,
        "stable_kp": kp,
        "stable_ki": ki,
        "trusted": agreement.is_trusted(),
    })
}

pub(super) fn place(point: &MapPoint) -> Value {
    let found = point.found.as_ref().ok().map(|found| {
        json!({
            "pose": found.pose,
            "mass_kg": found.mass_kg,
            "stiffness_n_per_m": found.stiffness_n_per_m,
            "largest_ki_per_s": number(found.agreement.largest_ki_per_s[0]),
            "force_bandwidth_hz": number(found.agreement.force_bandwidth_hz[0]),
            "axis_force_bandwidth_hz": number(found.agreement.force_bandwidth_hz[1]),
            "misfit": misfit(&found.agreement),
        })
    });
    let reason = point.found.as_ref().err().map(NoAxis::reason);
    json!({ "place_m": point.place_m, "found": found, "reason": reason })
}
