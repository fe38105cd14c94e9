//! Whether an effect's fitted value is a finding, or within what was believed anyway.

use feeler_plant::description::{Machine, Site};
use indexmap::IndexMap;

use crate::fit::model::Model;

/// Default tolerance of masses, stiffnesses and gains.
const TOLERANCE: f64 = 0.10;

/// What the records cover.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    /// The longest way, m.
    pub(crate) stroke_m: f64,
    /// The largest command, N.
    pub(crate) command_n: f64,
}

/// Whether effect `effect` of a fitted model only moves a believed value within its tolerance, or is no
/// instance of its kind.
pub(crate) fn is_within(
    model: &Model,
    theta: &[f64],
    effect: usize,
    tolerance: &IndexMap<String, f64>,
    seen: Seen,
) -> bool {
    let tried = &model.tried[effect];
    let values = model.parameters(effect, theta);
    let machine = &model.believed;
    let stated = |site: Site, name: &str, default: f64| {
        tolerance.get(&format!("{}.{name}", site.key(machine))).copied().unwrap_or(default)
    };
    let i = tried.site.index;
    let off = |value: f64, believed: f64| (value / believed - 1.0).abs();
    match tried.effect.definition.kind {
        "drive-gain" | "force-gain" => off(values[0], 1.0) <= stated(tried.site, "gain", TOLERANCE),
        "contact-stiffness" => {
            off(values[0], machine.contacts[i].stiffness) <= stated(tried.site, "stiffness", TOLERANCE)
        }
        "contact-damping" => {
            let believed = machine.contacts[i].damping_n_s_per_m;
            believed > 0.0 && (values[0] / believed).ln().abs() <= stated(tried.site, "damping", 1.0).ln_1p()
        }
        "added-mass" => values[0] <= stated(tried.site, "mass", TOLERANCE) * chain_mass(machine, i),
        "viscous-friction" => {
            values[0] <= stated(tried.site, "damping", 1.0) * machine.springs[i].damping_n_s_per_m
        }
        "surface-offset" => {
            values[0].abs() <= stated(tried.site, "gap", GAP_TOLERANCE) * machine.contacts[i].gap_m.abs()
        }
        // A guide that its load holds harder than the load presses would keep the tool in contact without a
        // drive.
        "load-friction" => values[0] >= SELF_LOCKING,
        // A sine of which the stroke shows hardly more than one period is some force over position, not a
        // ripple.
        "force-ripple" => seen.stroke_m < PERIODS * values[1],
        // A law with an exponent of one is a spring, levels that hardly differ are one level, and a mode that
        // cannot swing is a damper.
        "backlash" => values[0] * values[1] < LEAST_PLAY * seen.command_n,
        "hertz-contact" => values[0] < LEAST_EXPONENT,
        "asymmetric-friction" => values[1].abs() < LEAST_ASYMMETRY,
        "base-flexibility" | "workpiece-dynamics" => values[2] > 2.0 * (values[0] * values[1]).sqrt(),
        "transmission-flexibility" => values[1] > 2.0 * (values[0] * values[2]).sqrt(),
        _ => false,
    }
}

/// Friction over contact force from which on a guide locks itself.
const SELF_LOCKING: f64 = 1.0;
/// Free play that this share of the largest command would take up in a spring of the flanks' stiffness is
/// none.
const LEAST_PLAY: f64 = 0.01;
/// Exponents below this are a spring's, within its calibration.
const LEAST_EXPONENT: f64 = 1.1;
/// Asymmetries below this are none.
const LEAST_ASYMMETRY: f64 = 0.02;

/// Periods of a ripple within the stroke that make it one.
const PERIODS: f64 = 1.6;

/// Default tolerance of a gap.
const GAP_TOLERANCE: f64 = 0.05;

fn chain_mass(machine: &Machine, body: usize) -> f64 {
    feeler_plant::assembly::assemble(machine).map_or(0.0, |assembly| assembly.rigid_mass_kg(body + 1))
}
