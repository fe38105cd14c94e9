//! The free run of a servo: position control keeps its errors from adding up.

use feeler_plant::description::ActuatorKind;

use super::horizons::share;
use crate::dataset::Dataset;

/// Largest ratio of the error of a servo's free run to the signal in a complete answer. Right answers left 1
/// to 4 % on servo joints. A wrong one named a limit for a drive that sags: it left 25 %, but only 3 % over
/// 50 ms.
const MOST_STRAYED: f64 = 0.1;

/// The reason why the answer for a servo is not called explained: a free run that is off by more than a
/// tenth of the signal.
pub(super) fn strayed(dataset: &Dataset, off: Option<f64>) -> Option<String> {
    let is_servo =
        |drive: usize| matches!(dataset.machine.actuators[drive].kind, ActuatorKind::PositionServo(_));
    told(off).filter(|_| dataset.drives.iter().any(|driven| is_servo(driven.drive)))
}

fn told(off: Option<f64>) -> Option<String> {
    let off = share(off.filter(|off| *off > MOST_STRAYED)?);
    Some(format!("the servo corrects its position, yet a free run is off by {off} of the signal"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_free_run_counts_beyond_a_tenth() {
        assert!(told(Some(0.09)).is_none() && told(None).is_none());
        assert!(told(Some(0.246)).is_some_and(|text| text.contains("24.6 %")));
        assert!(told(Some(1e24)).is_some_and(|text| text.contains("more than 1000 %")));
    }
}
