//! Standard deviations of fitted values under lasting residuals: the errors of a model are not white noise.
//!
//! The normal matrix gives the change of the values per residual. The effect of the actual residuals is
//! estimated from the fit itself, block by block of motion. This is the sandwich of Huber and White, with
//! blocks as clusters (Cameron and Miller, A Practitioner's Guide to Cluster-Robust Inference, Journal of
//! Human Resources 50, 2015).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::fit::curvature::{add_curvature, add_gradient, times};
use crate::fit::least_squares::{Fitted, Task, slopes};

/// Smallest number of blocks over all fitted records together.
const BLOCKS: usize = 12;

/// One standard deviation of every unknown of a fitted model. `None` if it does not predict or the records
/// hold no information.
pub(crate) fn deviations(task: &Task<'_>, fitted: &Fitted) -> Option<Vec<f64>> {
    let n = fitted.theta.len();
    let each = BLOCKS.div_ceil(task.fitted.len().max(1));
    let parts: Option<Vec<_>> = task.fitted.par_iter().map(|&r| pulls(task, fitted, r, each)).collect();
    let (mut bread, mut filling) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    let mut blocks = 0.0;
    for (curvature, pulls) in parts? {
        bread += curvature;
        for pull in pulls {
            filling += &pull * pull.transpose();
            blocks += 1.0;
        }
    }
    for (i, unknown) in fitted.model.unknowns.iter().enumerate() {
        // Unknowns without influence keep their values.
        bread[(i, i)] += unknown.prior.map_or(0.0, |(_, sigma)| sigma.powi(-2)) + 1e-9;
        filling[(i, i)] += unknown.prior.map_or(0.0, |(_, sigma)| sigma.powi(-2));
    }
    let inverse = bread.try_inverse()?;
    let covariance = &inverse * filling * &inverse * (blocks / (blocks - 1.0_f64).max(1.0));
    let deviations: Vec<f64> = (0..n).map(|i| covariance[(i, i)].max(0.0).sqrt()).collect();
    deviations.iter().all(|deviation| deviation.is_finite()).then_some(deviations)
}

/// Curvature of the cost of one record, and the gradient from the residuals of each block.
fn pulls(
    task: &Task<'_>,
    fitted: &Fitted,
    r: usize,
    blocks: usize,
) -> Option<(DMatrix<f64>, Vec<DVector<f64>>)> {
    let n = fitted.theta.len();
    let here = task.predict(&fitted.model, &fitted.theta, r)?;
    let moved: Vec<_> = (0..n).map(|i| task.moved(&fitted.model, &fitted.theta, i, r)).collect();
    let mut curvature = DMatrix::zeros(n, n);
    let mut pulls = vec![DVector::zeros(n); blocks];
    for (c, measured) in task.dataset.records[r].series.iter().enumerate() {
        let sigma = task.weights.sigma[r][c];
        if sigma.is_infinite() {
            continue;
        }
        let slopes = slopes(&here, &moved, c, sigma);
        let residuals = task.residuals(r, c, &here);
        let weights = task.robust_weights(r, c, &residuals);
        let factor = task.share(r, c);
        add_curvature(&mut curvature, factor, &slopes, &weights);
        let weighted = times(&residuals, &weights);
        let rows = measured.len().div_ceil(blocks).max(1);
        for (pull, block) in pulls.iter_mut().zip((0..measured.len()).step_by(rows)) {
            let end = (block + rows).min(measured.len());
            let own: Vec<Vec<f64>> = slopes.iter().map(|slope| slope[block..end].to_vec()).collect();
            add_gradient(pull, factor, &own, &weighted[block..end]);
        }
    }
    Some((curvature, pulls))
}
