//! Periodic records: differences between periods (laps) show the part that does not repeat, like differences
//! between repeated experiments.

use crate::dataset::Record;

/// Number of rows that are compared at each lag: enough to separate periods from similar motions.
const PROBES: usize = 2000;
/// Largest difference between periods, as a share of the variation. A closed loop repeats far better, an open
/// one drifts.
const SAME: f64 = 0.05;
/// Smallest difference from the start at which a period is under way.
const APART: f64 = 0.5;

/// Rows of a period, if all measurements and commands repeat at least once; otherwise `None`.
pub(crate) fn lap(record: &Record) -> Option<usize> {
    let all = || record.series.iter().chain(&record.commands);
    let leader = record.series.first()?;
    let most = leader.len() / 2;
    let mut lags = (1..most).skip_while(|&lag| differs(leader, lag) < APART);
    let first = lags.next()?;
    let best = (first..most).map(|lag| (lag, differs(leader, lag))).min_by(|a, b| a.1.total_cmp(&b.1))?.0;
    all().all(|series| differs(series, best) < SAME).then_some(best)
}

/// Root mean square difference between a series and the same series some rows later, over that of unrelated
/// rows. Zero for a constant.
fn differs(series: &[f64], lag: usize) -> f64 {
    let rows = series.len() - lag;
    let step = rows.div_ceil(PROBES).max(1);
    let probes: Vec<[f64; 2]> = (0..rows).step_by(step).map(|k| [series[k], series[k + lag]]).collect();
    let n = probes.len() as f64;
    let mean = probes.iter().flatten().sum::<f64>() / (2.0 * n);
    let (mut difference, mut variation) = (0.0, 0.0);
    for [a, b] in probes {
        difference += (a - b).powi(2);
        variation += (a - mean).powi(2) + (b - mean).powi(2);
    }
    if variation > 0.0 { (difference / variation).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(series: Vec<f64>) -> Record {
        Record::even("a.csv", 1.0, vec![series.clone()], vec![series])
    }

    #[test]
    fn truth_laps_are_counted_and_drift_is_none() {
        let lapped = |k: usize| {
            (std::f64::consts::TAU * k as f64 / 310.0).sin()
                + 0.4 * (std::f64::consts::TAU * k as f64 / 155.0).cos()
        };
        assert_eq!(lap(&record((0..1000).map(lapped).collect())), Some(310));
        assert_eq!(lap(&record((0..1000).map(|k| lapped(k) * (1.0 + 1e-3 * k as f64)).collect())), None);
        assert_eq!(lap(&record((0..1000).map(|k| f64::from(k).powi(2)).collect())), None);
        assert_eq!(lap(&record(vec![1.0; 1000])), None);
    }
}
