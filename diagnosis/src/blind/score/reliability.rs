//! Stated probabilities compared with the frequency of right answers.

use super::answered::Calibration;

const BINS: usize = 5;

/// Frequency of right answers against their stated probability, bin by bin.
pub(super) fn bins(stated: &[(f64, bool)]) -> Vec<Calibration> {
    (0..BINS)
        .filter_map(|i| {
            let edges = [i, i + 1].map(|edge| edge as f64 / BINS as f64);
            let is_last = i + 1 == BINS;
            let inside: Vec<_> =
                stated.iter().filter(|(p, _)| *p >= edges[0] && (*p < edges[1] || is_last)).collect();
            let n = inside.len();
            let mean = |sum: f64| sum / n as f64;
            (n > 0).then(|| Calibration {
                stated: edges,
                mean_stated: mean(inside.iter().map(|(p, _)| p).sum()),
                frequency: mean(inside.iter().filter(|(_, right)| *right).count() as f64),
                count: n,
            })
        })
        .collect()
}

/// Mean distance between stated probability and frequency, weighted by the number of answers.
pub(super) fn error(bins: &[Calibration]) -> f64 {
    let count = bins.iter().map(|bin| bin.count).sum::<usize>().max(1) as f64;
    bins.iter().map(|bin| bin.count as f64 / count * (bin.mean_stated - bin.frequency).abs()).sum()
}
