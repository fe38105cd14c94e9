//! The layout of the state.

use feeler_plant::assembly::SensorPart;
use feeler_plant::description::LowPass;
use nalgebra::DVector;

use crate::joint::JointPart;

/// Positions of the numbers in the state: motors, links, their speeds, lags of drives, heats of windings,
/// filters of sensors.
#[derive(Clone, Debug)]
pub(crate) struct CellLayout {
    pub(crate) joints: usize,
    /// First lag of each drive.
    pub(crate) lags: Vec<usize>,
    /// Heat of each drive's winding, if it weakens the drive.
    pub(crate) heats: Vec<Option<usize>>,
    /// First number of each sensor's filters.
    pub(crate) filters: Vec<usize>,
    pub(crate) length: usize,
}

impl CellLayout {
    pub(crate) fn new(joints: &[JointPart], sensors: &[SensorPart]) -> Self {
        let n = joints.len();
        let mut next = 4 * n;
        let mut take = |count: usize| {
            next += count;
            next - count
        };
        let lags = joints.iter().map(|joint| take(joint.drive.lags.len())).collect();
        let heats = joints.iter().map(|joint| joint.drive.warming.map(|_| take(1))).collect();
        let filters = sensors.iter().map(|sensor| take(sensor.filters.iter().map(order).sum())).collect();
        Self { joints: n, lags, heats, filters, length: next }
    }

    pub(crate) fn motors<'a>(&self, x: &'a DVector<f64>) -> &'a [f64] {
        &x.as_slice()[..self.joints]
    }

    pub(crate) fn links<'a>(&self, x: &'a DVector<f64>) -> &'a [f64] {
        &x.as_slice()[self.joints..2 * self.joints]
    }

    pub(crate) fn motor_speeds<'a>(&self, x: &'a DVector<f64>) -> &'a [f64] {
        &x.as_slice()[2 * self.joints..3 * self.joints]
    }

    pub(crate) fn link_speeds<'a>(&self, x: &'a DVector<f64>) -> &'a [f64] {
        &x.as_slice()[3 * self.joints..4 * self.joints]
    }
}

/// Numbers that a filter needs.
pub(crate) fn order(filter: &LowPass) -> usize {
    match filter {
        LowPass::FirstOrder { .. } => 1,
        LowPass::SecondOrder { .. } => 2,
    }
}

/// The signal after a series of filters whose states begin at `first`; their derivatives go into `slope`.
pub(crate) fn filtered(
    filters: &[LowPass],
    first: usize,
    x: &DVector<f64>,
    signal: f64,
    mut slope: Option<&mut DVector<f64>>,
) -> f64 {
    let (mut input, mut at) = (signal, first);
    for filter in filters {
        let tau = std::f64::consts::TAU;
        match *filter {
            LowPass::FirstOrder { corner_hz } => {
                if let Some(slope) = slope.as_deref_mut() {
                    slope[at] = tau * corner_hz * (input - x[at]);
                }
            }
            LowPass::SecondOrder { corner_hz, damping_ratio } => {
                let w = tau * corner_hz;
                if let Some(slope) = slope.as_deref_mut() {
                    slope[at] = x[at + 1];
                    slope[at + 1] = w * w * (input - x[at]) - 2.0 * damping_ratio * w * x[at + 1];
                }
            }
        }
        input = x[at];
        at += order(filter);
    }
    input
}
