//! The predicted readings of a machine along a record.

/// The predicted readings of a machine.
#[derive(Clone, Debug, Default)]
pub struct Prediction {
    /// One series per channel.
    pub series: Vec<Vec<f64>>,
    /// The series without coarse quantisation, for slopes.
    pub(crate) smooth: Vec<Vec<f64>>,
    /// Half the step of each channel if its quantisation is coarse against its noise, otherwise zero. A
    /// reading carries no finer information.
    pub(crate) dead_zone: Vec<f64>,
    /// Predicted position and speed of the first drive relative to its reaction body, and its force.
    pub(crate) stroke: Vec<[f64; 3]>,
    /// Whether any contact carries a force, in each row.
    pub(crate) touching: Vec<bool>,
    /// Indentation of every contact, one series each; negative while open.
    pub(crate) compressions: Vec<Vec<f64>>,
    /// Natural frequency of the anchoring, rad/s; zero without anchoring.
    pub(crate) omega: f64,
    /// Heat of every drive's winding after the last row; zero for drives without a winding.
    pub(super) heats: Vec<f64>,
}

impl Prediction {
    /// A prediction without rows, with room for them.
    pub(super) fn blank(rows: usize, contacts: usize, omega: f64) -> Self {
        Self {
            stroke: Vec::with_capacity(rows),
            touching: Vec::with_capacity(rows),
            compressions: (0..contacts).map(|_| Vec::with_capacity(rows)).collect(),
            omega,
            ..Self::default()
        }
    }
}
