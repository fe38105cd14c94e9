//! Bodies between motor and tool, as starting points of fits.
//!
//! Motor and tool are joined by a spring, and every further body by one spring to each of the two. With both
//! of them held, each such body is a mode of the arm. Source: R. R. Craig, M. C. C. Bampton, AIAA J. 6
//! (1968), with two ends. With as many bodies as modes, and if all springs are positive, the axis is exactly
//! the arm.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::branch::Branch;
use crate::flexible::LinearArm;
use crate::linear_system::eigen;
use crate::reduce::Reduction;

/// Initial spring to the tool of a body without one, over its own spring.
const FIRST_LINK: f64 = 0.2;

/// Motor, tool and this number of bodies: those with the largest lag. Negative springs are omitted.
pub(crate) fn between(linear: &LinearArm, pair: &Reduction, count: usize) -> Option<Reduction> {
    let system = &linear.system;
    let ends = DMatrix::from_columns(&[system.drive.clone(), system.tip.clone()]);
    let still = complement(&ends)?;
    let within = |matrix: &DMatrix<f64>| still.tr_mul(matrix) * &still;
    let (squares, shapes) = eigen(&within(&system.mass), &within(&system.stiffness))?;
    let shapes = &still * shapes;
    // Motion of each end alone, orthogonal to all bodies.
    let mut alone = system.mass.clone().cholesky()?.solve(&ends);
    let masses: Vec<f64> = (0..2).map(|end| ends.column(end).dot(&alone.column(end)).recip()).collect();
    for (mut column, mass) in alone.column_iter_mut().zip(&masses) {
        column *= *mass;
    }
    let carried = &system.mass * &linear.unbent;
    let mut bodies: Vec<(Branch, f64)> = (squares.iter().zip(shapes.column_iter()))
        .map(|(square, shape)| {
            let share = shape.dot(&carried);
            let joined = |matrix: &DMatrix<f64>, end: usize| {
                (-share * (matrix * shape).dot(&alone.column(end))).max(0.0)
            };
            let branch = Branch {
                mass_kg: share * share,
                stiffness_n_per_m: joined(&system.stiffness, 0),
                damping_n_s_per_m: joined(&system.damping, 0),
                to_tool_n_per_m: joined(&system.stiffness, 1),
                to_tool_n_s_per_m: joined(&system.damping, 1),
            };
            (branch, share * share / square)
        })
        .collect();
    bodies.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    let across = |matrix: &DMatrix<f64>| (-(matrix * alone.column(0)).dot(&alone.column(1))).max(0.0);
    let mut axis = Reduction {
        motor_mass_kg: masses[0],
        tip_mass_kg: masses[1],
        stiffness_n_per_m: across(&system.stiffness),
        damping_n_s_per_m: across(&system.damping),
        ..pair.clone()
    };
    for (i, (body, _)) in bodies.into_iter().enumerate() {
        if i < count {
            axis.branches.push(body);
        } else {
            fold(&mut axis, &body);
        }
    }
    (axis.stiffness_n_per_m > 0.0).then_some(axis)
}

/// Omits a fast body: it follows both ends as its springs determine.
fn fold(axis: &mut Reduction, body: &Branch) {
    let sum = body.stiffness_n_per_m + body.to_tool_n_per_m;
    if sum > 0.0 {
        let [motor, tool] = [body.stiffness_n_per_m / sum, body.to_tool_n_per_m / sum];
        axis.motor_mass_kg += motor * body.mass_kg;
        axis.tip_mass_kg += tool * body.mass_kg;
        axis.stiffness_n_per_m += motor * body.to_tool_n_per_m;
        axis.damping_n_s_per_m +=
            tool * tool * body.damping_n_s_per_m + motor * motor * body.to_tool_n_s_per_m;
    }
}

/// The same axis without bodies above a frequency, which would only make it stiff to simulate.
pub(crate) fn without_fast(axis: Reduction, above_hz: f64) -> Reduction {
    let (kept, fast): (Vec<Branch>, Vec<Branch>) =
        axis.branches.iter().partition(|body| body.frequency_hz() <= above_hz);
    let mut slow = Reduction { branches: kept, ..axis };
    for body in &fast {
        fold(&mut slow, body);
    }
    slow
}

/// A basis of the orthogonal complement of all columns.
fn complement(columns: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = columns.nrows();
    let away =
        DMatrix::identity(n, n) - columns * columns.tr_mul(columns).cholesky()?.solve(&columns.transpose());
    // A projection: its eigenvalues are one and zero.
    let eigen = SymmetricEigen::new(0.5 * (&away + away.transpose()));
    let kept: Vec<_> =
        (0..n).filter(|&i| eigen.eigenvalues[i] > 0.5).map(|i| eigen.eigenvectors.column(i)).collect();
    Some(DMatrix::from_columns(&kept))
}

/// The same axis with a weak spring to the tool for each body without one.
pub(crate) fn linked(axis: &Reduction) -> Reduction {
    let mut linked = axis.clone();
    for branch in &mut linked.branches {
        branch.to_tool_n_per_m = branch.to_tool_n_per_m.max(FIRST_LINK * branch.stiffness_n_per_m);
        branch.to_tool_n_s_per_m = branch.to_tool_n_s_per_m.max(FIRST_LINK * branch.damping_n_s_per_m);
    }
    linked
}
