//! Load of gravity and of the motion of other joints on one joint of an arm, along a run.

use feeler_arm::Chain;
use feeler_logs::{Pick, Run};
use indexmap::IndexMap;

use super::axis::Beliefs;
use super::guess::Guess;
use super::role::ColumnRole;
use super::units::UnitGuess;

/// Half of the time over which a position is smoothed for its speed and acceleration, s. Other joints couple
/// by motions that last longer, and steps of encoders average out.
const HALF_SPAN_S: f64 = 0.08;
/// Readings on either side within that time.
const HALF_ROWS: usize = 4;

/// An arm around one of its joints.
pub(super) struct Arm {
    chain: Chain,
    /// The joint's place in the chain.
    at: usize,
    /// For each joint of the chain its column of positions, and one of its numbers in SI. `None` if the log
    /// has none; the joint then counts as zero.
    positions: Vec<Option<(String, f64)>>,
}

impl Arm {
    /// The arm around the joint `name` of the log. `None` if the model has no such joint.
    pub(super) fn around(name: &str, beliefs: &Beliefs, joints: &IndexMap<String, Guess>) -> Option<Self> {
        // Counts begin anywhere: no pose follows from them.
        let in_counts = |guess: &Guess| {
            let position = guess.columns.get(&ColumnRole::Position);
            position.is_some_and(|chosen| matches!(chosen.unit, Some((UnitGuess::Counts(_), _))))
        };
        if joints.values().any(in_counts) {
            return None;
        }
        let with_position =
            joints.iter().filter(|(_, guess)| guess.columns.contains_key(&ColumnRole::Position));
        let logged: Vec<String> = with_position.map(|(name, _)| name.clone()).collect();
        let (belief, _) = beliefs.find(name, &logged)?;
        let (chain, at) = beliefs.chain_through(&belief.joint.name)?;
        let position = |joint: &feeler_arm::Joint| {
            let named = |name: &&String| {
                beliefs.find(name, &logged).is_some_and(|(found, _)| found.joint.name == joint.name)
            };
            let chosen = joints[logged.iter().find(named)?].columns.get(&ColumnRole::Position)?;
            Some((chosen.column.clone(), chosen.in_si()))
        };
        let positions = chain.joints.iter().map(position).collect();
        Some(Self { chain, at, positions })
    }

    /// Inertia at the joint with every joint at the middle of what `range` says of its column.
    pub(super) fn inertia(&self, range: impl Fn(&str) -> Option<[f64; 2]>) -> f64 {
        let middle =
            |(column, each): &(String, f64)| range(column).map_or(0.0, |[a, b]| 0.5 * each * (a + b));
        let pose: Vec<f64> = self.positions.iter().map(|of| of.as_ref().map_or(0.0, middle)).collect();
        self.chain.mass_matrix(&pose)[(self.at, self.at)]
    }

    /// Joints that the log does not hold.
    pub(super) fn unknown(&self) -> impl Iterator<Item = &str> {
        let of = self.chain.joints.iter().zip(&self.positions);
        of.filter(|(_, column)| column.is_none()).map(|(joint, _)| joint.name.as_str())
    }

    /// The columns of a run that it needs.
    pub(super) fn picks<'a>(&'a self, run: &'a Run) -> impl Iterator<Item = Pick<'a>> {
        let known = self.positions.iter().flatten().filter(|(column, _)| run.find(column).is_some());
        known.map(|(name, _)| Pick { name, is_held: false })
    }

    /// The effort of gravity and of the other joints' motion on the joint, by the columns of [`Self::picks`].
    pub(super) fn load(&self, run: &Run, times_s: &[f64], columns: &[Vec<f64>]) -> Vec<f64> {
        let mut columns = columns.iter();
        let motions: Vec<Vec<[f64; 3]>> = (self.positions.iter())
            .map(|position| {
                let (name, each) = position.as_ref()?;
                run.find(name)?;
                Some(motion(times_s, columns.next()?, *each))
            })
            .map(|motion| motion.unwrap_or_else(|| vec![[0.0; 3]; times_s.len()]))
            .collect();
        let n = motions.len();
        let mut state = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        (0..times_s.len())
            .map(|row| {
                for (joint, motion) in motions.iter().enumerate() {
                    (0..3).for_each(|order| state[order][joint] = motion[row][order]);
                }
                // The machine has the joint's own inertia.
                state[2][self.at] = 0.0;
                -self.chain.inverse_dynamics(&state[0], &state[1], &state[2])[self.at]
            })
            .collect()
    }
}

/// Position, speed and acceleration in each row: those of a parabola through the readings around it.
fn motion(times_s: &[f64], readings: &[f64], each: f64) -> Vec<[f64; 3]> {
    let rows = times_s.len();
    let usual_s = (times_s[rows - 1] - times_s[0]) / (rows.max(2) - 1) as f64;
    let stride = (HALF_SPAN_S / (usual_s * HALF_ROWS as f64)).round().max(1.0) as usize;
    let around = |row: usize| {
        let steps = -HALF_ROWS.cast_signed()..=HALF_ROWS.cast_signed();
        let near = steps.filter_map(move |k| row.checked_add_signed(k * stride.cast_signed()));
        let points = near.filter(|i| readings.get(*i).is_some_and(|x| x.is_finite()));
        points.map(|i| (times_s[i] - times_s[row], each * readings[i])).collect::<Vec<_>>()
    };
    (0..rows).map(|row| parabola(&around(row))).collect()
}

/// Value, slope and curvature at zero of the parabola nearest to some points; of a constant where they are
/// too few.
fn parabola(points: &[(f64, f64)]) -> [f64; 3] {
    let mean = points.iter().map(|(_, x)| x).sum::<f64>() / points.len() as f64;
    let span = points.iter().map(|(t, _)| t.abs()).fold(0.0, f64::max);
    let (mut matrix, mut right) = (nalgebra::Matrix3::zeros(), nalgebra::Vector3::zeros());
    for (t, x) in points {
        let powers = nalgebra::Vector3::new(1.0, t / span, (t / span).powi(2));
        matrix += powers * powers.transpose();
        right += powers * (x - mean);
    }
    let solved = matrix.cholesky().filter(|_| points.len() > 3).map(|factor| factor.solve(&right));
    solved.map_or([mean, 0.0, 0.0], |c| [mean + c[0], c[1] / span, 2.0 * c[2] / span.powi(2)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_parabola_is_found_from_its_points_at_any_spacing() {
        for spacing_s in [1e-3, 0.02] {
            let times_s: Vec<f64> = (0..400).map(|k| f64::from(k) * spacing_s).collect();
            let readings: Vec<f64> = times_s.iter().map(|t| 10.0 + 20.0 * t - 15.0 * t * t).collect();
            for (t, [x, v, a]) in times_s.iter().zip(motion(&times_s, &readings, 0.1)) {
                let expected = [1.0 + 2.0 * t - 1.5 * t * t, 2.0 - 3.0 * t, -3.0];
                // Roundings of positions up to 100, over the square of the shortest span, 16 ms.
                for (found, expected) in [x, v, a].into_iter().zip(expected) {
                    assert!((found - expected).abs() < 1e-9, "{found} {expected} at {t} s");
                }
            }
        }
    }
}
