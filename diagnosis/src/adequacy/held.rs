//! The free run of a servo, which holds its place: errors do not add up as those of a force do.

use feeler_plant::description::ActuatorKind;

use crate::dataset::Dataset;

/// Error of a servo's free run over the signal above which an answer leaves something. On servo joints right
/// answers left 1 to 4 %. A limit that was named for a drive that sags left 25 %, with 3 % over 50 ms.
const MOST_STRAYED: f64 = 0.1;

/// The reason why the answer for a servo is not called explained: a free run that is off by more than a
/// tenth of the signal.
pub(super) fn strayed(dataset: &Dataset, off: Option<f64>) -> Option<String> {
    let is_servo =
        |drive: usize| matches!(dataset.machine.actuators[drive].kind, ActuatorKind::PositionServo(_));
    told(off).filter(|_| dataset.drives.iter().any(|driven| is_servo(driven.drive)))
}

fn told(off: Option<f64>) -> Option<String> {
    let percent = 100.0 * off.filter(|off| *off > MOST_STRAYED)?;
    Some(format!("the servo corrects its position, yet a free run is off by {percent:.1} % of the signal"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_free_run_counts_beyond_a_tenth() {
        assert!(told(Some(0.09)).is_none() && told(None).is_none());
        assert!(told(Some(0.246)).is_some_and(|text| text.contains("24.6 %")));
    }
}
