//! Gains of control laws by the names they have in files.

use feeler_control::{ControllerSpec, Law};

use crate::error::AnalysisError;

/// Names of the gains of a law, the most telling one first.
pub fn gain_names(law: &Law) -> &'static [&'static str] {
    match law {
        Law::ExplicitForce(_) => &["kp", "ki", "kd", "damping", "feed_forward"],
        Law::Position(_) => &["kp", "ki", "kd", "damping"],
        Law::Impedance(_) => &["stiffness", "damping", "force_gain"],
        Law::Admittance(_) => &["kp", "kd", "velocity_feed_forward", "mass", "damping", "stiffness"],
        _ => &[],
    }
}

/// The value of a gain.
///
/// # Errors
/// [`AnalysisError::NoGain`].
pub fn gain(spec: &ControllerSpec, key: &str) -> Result<f64, AnalysisError> {
    slot(&mut spec.law.clone(), key).copied()
}

/// The same controller with another value of a gain.
///
/// # Errors
/// [`AnalysisError::NoGain`].
pub fn with_gain(spec: &ControllerSpec, key: &str, value: f64) -> Result<ControllerSpec, AnalysisError> {
    let mut changed = spec.clone();
    *slot(&mut changed.law, key)? = value;
    Ok(changed)
}

/// The first gain of a law that is not zero, else its first; `None` for a law without gains.
pub fn leading_gain(spec: &ControllerSpec) -> Option<&'static str> {
    let names = gain_names(&spec.law);
    names.iter().find(|name| gain(spec, name).is_ok_and(|value| value != 0.0)).or(names.first()).copied()
}

fn slot<'a>(law: &'a mut Law, key: &str) -> Result<&'a mut f64, AnalysisError> {
    let (name, known) = (law.name(), gain_names(law));
    let unknown = || AnalysisError::NoGain { law: name, key: key.into(), known: known.join(", ") };
    Ok(match law {
        Law::ExplicitForce(gains) => match key {
            "kp" => &mut gains.kp,
            "ki" => &mut gains.ki,
            "kd" => &mut gains.kd,
            "damping" => &mut gains.damping,
            "feed_forward" => &mut gains.feed_forward,
            _ => return Err(unknown()),
        },
        Law::Position(gains) => match key {
            "kp" => &mut gains.kp,
            "ki" => &mut gains.ki,
            "kd" => &mut gains.kd,
            "damping" => &mut gains.damping,
            _ => return Err(unknown()),
        },
        Law::Impedance(gains) => match key {
            "stiffness" => &mut gains.stiffness,
            "damping" => &mut gains.damping,
            "force_gain" => &mut gains.force_gain,
            _ => return Err(unknown()),
        },
        Law::Admittance(gains) => match key {
            "kp" => &mut gains.kp,
            "kd" => &mut gains.kd,
            "velocity_feed_forward" => &mut gains.velocity_feed_forward,
            "mass" => &mut gains.mass,
            "damping" => &mut gains.damping,
            "stiffness" => &mut gains.stiffness,
            _ => return Err(unknown()),
        },
        _ => return Err(unknown()),
    })
}
