//! Unknowns of a fit beyond the values of a machine: presliding of guides, and the instants at which commands
//! act.

use super::presliding::Presliding;

/// Largest time between a row and the instant at which its command acts, if no hold is stated, rows.
pub(crate) const MOST_LATE_ROWS: f64 = 0.5;

/// Values of the unknowns beyond the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Leeway {
    pub(crate) presliding: Presliding,
    /// Time from a row to the instant at which its command acts, in rows, for commands without a stated hold.
    pub(crate) late_rows: f64,
}

/// Mean over each row of commands that are linear between rows and `late` rows delayed. Before the first row
/// and after the last they are constant.
///
/// The mean moves a mass as far as the linear command does, up to the third power of the spacing.
pub(super) fn means_between_rows(commands: &[f64], late: f64) -> Vec<f64> {
    let whole = late.floor();
    let part = late - whole;
    let last = commands.len().saturating_sub(1);
    // Each mean covers the end of one line and the start of the next.
    let rest = 0.5 * (1.0 - part).powi(2);
    let mean = |k: usize| {
        let at = |by: isize| commands[k.saturating_add_signed(by - whole as isize).min(last)];
        let [before, here, after] = [-1, 0, 1].map(at);
        here + (before - here) * 0.5 * part * part + (after - here) * rest
    };
    (0..commands.len()).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_means_of_a_ramp_lie_half_a_row_ahead_and_come_as_late_as_asked() {
        let ramp: Vec<f64> = (0..12).map(f64::from).collect();
        for late in [-1.3, -0.5, 0.0, 0.2, 0.5, 1.0, 2.7] {
            let means = means_between_rows(&ramp, late);
            for (k, mean) in means.iter().enumerate().take(8).skip(4) {
                assert!((mean - (k as f64 + 0.5 - late)).abs() < 1e-12, "{late} {k}: {mean}");
            }
        }
    }

    #[test]
    fn truth_means_of_a_corner_are_its_areas() {
        let corner = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        // From 0.7 rows before row 3 to 0.3 after it: 0.7 of a line that rises from 0.3 to 1, and 0.3 of the
        // value one.
        let mean = means_between_rows(&corner, 0.7)[3];
        assert!((mean - (0.7 * 0.65 + 0.3)).abs() < 1e-12, "{mean}");
    }
}
