//! Steps, straight lines and tables.

use std::sync::Arc;

use super::keys::FOLLOWED;
use super::prbs::TIME_TOLERANCE_S;
use super::spec::Between;
use crate::error::{ControlError, finite};

/// Values at increasing times.
#[derive(Clone, Debug)]
pub(super) struct Points {
    times_s: Arc<[f64]>,
    values: Arc<[f64]>,
    between: Between,
    before: f64,
}

impl Points {
    pub(super) fn steps(points: &[(f64, f64)]) -> Result<Self, ControlError> {
        let (times_s, values) = unzip(points);
        Self::new("steps", times_s, values, Between::Hold, Some(0.0))
    }

    pub(super) fn lines(points: &[(f64, f64)]) -> Result<Self, ControlError> {
        let (times_s, values) = unzip(points);
        Self::new("piecewise-linear", times_s, values, Between::Linear, None)
    }

    pub(super) fn table(times_s: &[f64], values: &[f64], between: Between) -> Result<Self, ControlError> {
        if times_s.len() != values.len() {
            return Err(ControlError::TableLengths { times: times_s.len(), values: values.len() });
        }
        Self::new("file", times_s.to_vec(), values.to_vec(), between, None)
    }

    fn new(
        kind: &'static str,
        times_s: Vec<f64>,
        values: Vec<f64>,
        between: Between,
        before: Option<f64>,
    ) -> Result<Self, ControlError> {
        let first = *values.first().ok_or(ControlError::EmptyReference { kind })?;
        times_s.iter().try_for_each(|&t| finite(FOLLOWED.name, t).map(drop))?;
        values.iter().try_for_each(|&v| finite(FOLLOWED.name, v).map(drop))?;
        if let Some(i) = times_s.windows(2).position(|pair| pair[1] <= pair[0]) {
            return Err(ControlError::TimesNotIncreasing {
                index: i + 1,
                time_s: times_s[i + 1],
                previous_s: times_s[i],
            });
        }
        Ok(Self { times_s: times_s.into(), values: values.into(), between, before: before.unwrap_or(first) })
    }

    pub(super) fn value(&self, t_s: f64) -> f64 {
        let next = self.times_s.partition_point(|&time| time <= t_s + TIME_TOLERANCE_S);
        let Some(last) = next.checked_sub(1) else { return self.before };
        match self.between {
            Between::Linear if next < self.times_s.len() => {
                let share = (t_s - self.times_s[last]) / (self.times_s[next] - self.times_s[last]);
                self.values[last] + share * (self.values[next] - self.values[last])
            }
            Between::Hold | Between::Linear => self.values[last],
        }
    }
}

fn unzip(points: &[(f64, f64)]) -> (Vec<f64>, Vec<f64>) {
    points.iter().copied().unzip()
}
