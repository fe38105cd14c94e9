//! The state of rest about which a machine is linearised.

use feeler_plant::description::Engagement;
use feeler_plant::motion::{Equations, Motion, Row, dot};
use nalgebra::{DMatrix, DVector};

use crate::error::AnalysisError;

/// Newton steps; contact laws are smooth and convex, so a few suffice.
const MAX_STEPS: usize = 60;
/// Accelerations below this share of the largest single contribution are rounding.
const BALANCED: f64 = 1e-10;
/// Singular values below this share of the largest belong to directions in which nothing holds the machine.
const FREE_DIRECTION: f64 = 1e-11;

/// The operating point: extended vector at rest, with the drive inputs that hold the machine there.
#[derive(Clone, Debug, PartialEq)]
pub struct OperatingPoint {
    /// The extended vector of [`feeler_plant::motion::Layout`], with the values of the nonlinear terms.
    pub xi: Vec<f64>,
    /// Whether all forces balance there.
    pub balanced: bool,
}

/// Gradients of the nonlinear terms at `xi`, as rows over states, inputs and the constant.
pub(crate) fn term_gradients(motion: &Motion, equations: &Equations, xi: &[f64]) -> Vec<Row> {
    let gradient = |(term, arguments): (&feeler_plant::motion::NonlinearTerm, &Option<[Row; 2]>)| {
        let Some([a, b]) = arguments else { return motion.layout().zero() };
        let [da, db] = term.gradient(dot(a, xi), dot(b, xi));
        a.iter().zip(b).map(|(a, b)| da * a + db * b).collect()
    };
    motion.terms().iter().zip(&equations.arguments).map(gradient).collect()
}

/// A row with the nonlinear terms replaced by their gradients.
pub(crate) fn eliminate(motion: &Motion, gradients: &[Row], row: &Row) -> Row {
    let layout = motion.layout();
    let mut linear = row.clone();
    for (j, gradient) in gradients.iter().enumerate() {
        let factor = std::mem::take(&mut linear[layout.term(j)]);
        linear.iter_mut().zip(gradient).for_each(|(l, g)| *l += factor * g);
    }
    linear
}

/// Inputs that hold a machine at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Holding {
    /// Drives hold the machine so that the first contact carries this force, N.
    Preload(f64),
    /// One drive has this command, the others zero.
    Drive {
        drive: usize,
        /// Input of that drive, in its unit.
        effort: f64,
    },
}

/// Finds the state of rest nearest to the start: positions, drive and filter states, and the inputs that are
/// not given.
pub(crate) fn equilibrium(
    motion: &Motion,
    equations: &Equations,
    holding: Holding,
) -> Result<OperatingPoint, AnalysisError> {
    let layout = motion.layout();
    let mut xi = motion.initial_state();
    xi.resize(layout.width(), 0.0);
    xi[layout.one()] = 1.0;
    let nc = layout.coordinates();
    // Speeds are zero and given inputs are fixed; everything else may change.
    let last = match holding {
        Holding::Preload(_) => layout.states() + layout.inputs(),
        Holding::Drive { .. } => layout.states(),
    };
    let unknowns: Vec<usize> = (0..nc).chain(2 * nc..last).collect();
    let mut conditions: Vec<(Row, f64)> =
        (nc..layout.states()).map(|i| (equations.derivative[i].clone(), 0.0)).collect();
    let engaged =
        motion.assembly().contacts.first().is_some_and(|contact| contact.engagement != Engagement::Free);
    match holding {
        Holding::Preload(preload_n) if preload_n != 0.0 && !equations.contact_force.is_empty() => {
            conditions.push((equations.contact_force[0].clone(), preload_n));
            start_in_contact(motion, equations, preload_n, &mut xi);
        }
        // The place of rest matters, and without preload the contact just touches.
        Holding::Preload(_) if engaged && motion.assembly().depends_on_position() => {
            conditions.push((equations.compression[0][0].clone(), 0.0));
        }
        Holding::Preload(_) => {}
        Holding::Drive { drive, effort } => {
            xi[layout.input(drive)] = effort;
            if engaged && effort != 0.0 {
                start_in_contact(motion, equations, effort, &mut xi);
            }
        }
    }
    let size = |row: &Row, xi: &[f64]| row.iter().zip(xi).map(|(r, x)| (r * x).abs()).sum::<f64>();
    let mut residual = f64::INFINITY;
    for _ in 0..MAX_STEPS {
        motion.fill_terms(equations, &mut xi);
        let error = DVector::from_iterator(
            conditions.len(),
            conditions.iter().map(|(row, value)| dot(row, &xi) - value),
        );
        let scale = conditions
            .iter()
            .map(|(row, value)| size(row, &xi) + value.abs())
            .fold(f64::MIN_POSITIVE, f64::max);
        residual = error.amax();
        if residual <= BALANCED * scale {
            return Ok(OperatingPoint { xi, balanced: true });
        }
        let gradients = term_gradients(motion, equations, &xi);
        let rows: Vec<Row> = conditions.iter().map(|(row, _)| eliminate(motion, &gradients, row)).collect();
        let step = least_step(&rows, &unknowns, &error);
        for (&i, d) in unknowns.iter().zip(step.iter()) {
            xi[i] -= d;
        }
    }
    motion.fill_terms(equations, &mut xi);
    // The linearisation of a linear machine does not depend on its position.
    if motion.terms().is_empty() {
        return Ok(OperatingPoint { xi, balanced: false });
    }
    Err(AnalysisError::NoEquilibrium { residual_m_per_s2: residual })
}

/// Moves everything in front of the first contact until the contact carries about this force: a power law has
/// no slope at zero.
fn start_in_contact(motion: &Motion, equations: &Equations, preload_n: f64, xi: &mut [f64]) {
    let part = &motion.assembly().contacts[0];
    let depth = (preload_n.abs() / part.law.stiffness).powf(1.0 / part.law.exponent) * preload_n.signum();
    let missing = depth - dot(&equations.compression[0][0], xi);
    // Coordinates on the tip's side move, those on the workpiece's side stay.
    let rows = equations.compression[0][0].iter().take(motion.layout().coordinates());
    for (x, _) in xi.iter_mut().zip(rows).filter(|(_, row)| **row > 0.0) {
        *x += missing;
    }
}

/// The smallest step that removes `error`; each unknown is weighted by its own effect.
fn least_step(rows: &[Row], unknowns: &[usize], error: &DVector<f64>) -> DVector<f64> {
    let mut jacobian = DMatrix::from_fn(rows.len(), unknowns.len(), |i, j| rows[i][unknowns[j]]);
    let mut error = error.clone();
    for i in 0..rows.len() {
        let norm = jacobian.row(i).norm();
        if norm > 0.0 {
            jacobian.row_mut(i).scale_mut(1.0 / norm);
            error[i] /= norm;
        }
    }
    let columns: Vec<f64> = (0..unknowns.len())
        .map(|j| Some(jacobian.column(j).norm()).filter(|n| *n > 0.0).unwrap_or(1.0))
        .collect();
    for (j, norm) in columns.iter().enumerate() {
        jacobian.column_mut(j).scale_mut(1.0 / norm);
    }
    let decomposition = jacobian.svd(true, true);
    let tolerance = FREE_DIRECTION * decomposition.singular_values.max();
    let scaled = decomposition.solve(&error, tolerance).unwrap_or_else(|_| DVector::zeros(unknowns.len()));
    DVector::from_fn(unknowns.len(), |j, _| scaled[j] / columns[j])
}
