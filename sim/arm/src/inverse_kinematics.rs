//! A pose that brings the tool to a target.

use nalgebra::{DMatrix, DVector, Isometry3, Vector3};

use crate::chain::Chain;
use crate::error::ArmError;

/// Target position of the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// Position of the tool only.
    Position(Vector3<f64>),
    /// Position of the tool, and the direction of its x axis.
    Pointing(Vector3<f64>, Vector3<f64>),
    /// Position and orientation.
    Place(Isometry3<f64>),
}

/// Steps of one attempt.
const STEPS: usize = 200;
/// Damping of the first step over the largest singular value: Levenberg's.
const DAMPING: f64 = 1e-2;
/// Largest joint motion of one step, rad.
const LARGEST_STEP: f64 = 0.3;
/// Largest remaining error of a solution, m and rad.
const CLOSE: f64 = 1e-9;

impl Target {
    /// Error of a pose, and the rows of the Jacobian that it belongs to.
    fn error(&self, at: &Isometry3<f64>) -> DVector<f64> {
        let turn = |from: Vector3<f64>, to: Vector3<f64>| {
            let axis = from.cross(&to);
            let angle = axis.norm().atan2(from.dot(&to));
            axis.try_normalize(1e-12).map_or(Vector3::zeros(), |axis| axis * angle)
        };
        let stack =
            |p: Vector3<f64>, r: Vector3<f64>| DVector::from_iterator(6, p.iter().chain(r.iter()).copied());
        match self {
            Self::Position(p) => DVector::from_column_slice((p - at.translation.vector).as_slice()),
            Self::Pointing(p, x) => stack(p - at.translation.vector, turn(at.rotation * Vector3::x(), *x)),
            Self::Place(place) => stack(
                place.translation.vector - at.translation.vector,
                (place.rotation * at.rotation.inverse()).scaled_axis(),
            ),
        }
    }

    fn position(&self) -> Vector3<f64> {
        match self {
            Self::Position(p) | Self::Pointing(p, _) => *p,
            Self::Place(place) => place.translation.vector,
        }
    }
}

/// A pose within the limits that brings the tool to a target, near one of the starts: damped least squares,
/// C. W. Wampler, IEEE Trans. SMC 16 (1986).
///
/// # Errors
/// [`ArmError::Unreachable`] if no start leads there.
pub fn inverse_kinematics(chain: &Chain, target: &Target, starts: &[Vec<f64>]) -> Result<Vec<f64>, ArmError> {
    let mut left_m = f64::INFINITY;
    for start in starts {
        let mut q = DVector::from_column_slice(start);
        let mut damping = DAMPING;
        let mut error = target.error(&chain.tool_place(q.as_slice()));
        for _ in 0..STEPS {
            if error.norm() < CLOSE {
                return Ok(q.iter().copied().collect());
            }
            let jacobian = chain.jacobian(q.as_slice()).rows(0, error.len()).into_owned();
            let size = jacobian.norm();
            let normal: DMatrix<f64> = jacobian.transpose() * &jacobian
                + DMatrix::identity(q.len(), q.len()) * (damping * size).powi(2);
            let Some(mut step) = normal.cholesky().map(|c| c.solve(&(jacobian.transpose() * &error))) else {
                break;
            };
            let largest = step.amax();
            if largest > LARGEST_STEP {
                step *= LARGEST_STEP / largest;
            }
            let mut next = &q + step;
            for (x, joint) in next.iter_mut().zip(&chain.joints) {
                *x = x.clamp(joint.limits[0], joint.limits[1]);
            }
            let next_error = target.error(&chain.tool_place(next.as_slice()));
            if next_error.norm() < error.norm() {
                (q, error) = (next, next_error);
                damping = (0.3 * damping).max(1e-8);
            } else if damping > 1e3 {
                break;
            } else {
                damping *= 5.0;
            }
        }
        let missing = (target.position() - chain.tool_place(q.as_slice()).translation.vector).norm();
        left_m = left_m.min(missing);
    }
    Err(ArmError::Unreachable { target_m: target.position().into(), left_m })
}

/// Starting poses for an upright arm: turned towards the target, with joints bent either way
/// by various amounts.
pub fn usual_starts(chain: &Chain, place_m: [f64; 3]) -> Vec<Vec<f64>> {
    let middle = |[lower, upper]: [f64; 2]| {
        if lower.is_finite() && upper.is_finite() { 0.5 * (lower + upper) } else { 0.0 }
    };
    let facing = place_m[1].atan2(place_m[0]);
    (0..16)
        .map(|i| {
            let bend = 0.4 + 0.5 * f64::from(i / 2);
            let sign = if i % 2 == 0 { -1.0 } else { 1.0 };
            let start = |j: usize, limits: [f64; 2]| {
                let wanted = match j {
                    0 => facing,
                    1 => sign * bend,
                    2 => -sign * 1.5 * bend,
                    3 => -sign * 0.5 * bend,
                    _ => 0.0,
                };
                if (limits[0]..=limits[1]).contains(&wanted) { wanted } else { middle(limits) }
            };
            chain.joints.iter().enumerate().map(|(j, joint)| start(j, joint.limits)).collect()
        })
        .collect()
}
