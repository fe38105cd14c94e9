//! Gains of control laws, by their names in files.

use feeler_catalogue::Field;
use feeler_control::{ControllerSpec, Law};

use crate::error::AnalysisError;

/// Names of the gains of a law, the most important first.
pub fn gain_names(law: &Law) -> Vec<&'static str> {
    law.gains().iter().map(|gain| gain.key.name).collect()
}

/// The value of a gain.
///
/// # Errors
/// [`AnalysisError::NoGain`].
pub fn gain(spec: &ControllerSpec, key: &str) -> Result<f64, AnalysisError> {
    find(&spec.law, key).map(|gain| gain.number(&spec.law).unwrap_or_default())
}

/// The same controller with another value of a gain.
///
/// # Errors
/// [`AnalysisError::NoGain`].
pub fn with_gain(spec: &ControllerSpec, key: &str, value: f64) -> Result<ControllerSpec, AnalysisError> {
    let mut changed = spec.clone();
    find(&spec.law, key)?.set_number(&mut changed.law, value);
    Ok(changed)
}

/// The first nonzero gain of a law, else its first; `None` for a law without gains.
pub fn leading_gain(spec: &ControllerSpec) -> Option<&'static str> {
    let gains = spec.law.gains();
    let in_use = gains.iter().find(|gain| gain.number(&spec.law).is_some_and(|value| value != 0.0));
    in_use.or(gains.first()).map(|gain| gain.key.name)
}

fn find(law: &Law, key: &str) -> Result<&'static Field<Law>, AnalysisError> {
    law.gains().into_iter().find(|gain| gain.key.name == key).ok_or_else(|| AnalysisError::NoGain {
        law: law.name(),
        key: key.into(),
        known: gain_names(law).join(", "),
    })
}
