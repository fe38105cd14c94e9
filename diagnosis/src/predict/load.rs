//! Records that begin under load: springs that no sensor shows are then deflected.

use feeler_plant::assembly::Assembly;
use feeler_plant::motion::{Row, dot};
use nalgebra::{DMatrix, DVector};

use super::begin::Parabola;
use super::machine::Moving;
use super::state::State;
use crate::dataset::{Channel, Record};

/// Number of steps towards the loaded state: contacts may close on the way, and weights turn.
const STEPS: usize = 4;

impl Moving {
    /// Moves the `hidden` coordinates to where they accelerate with coordinate `lead`, and the lags of drives
    /// to rest. Springs then carry what hangs on them. Returns whether there is such a state.
    pub(super) fn load(&mut self, state: &mut State, hidden: &[usize], lead: usize) -> bool {
        for _ in 0..STEPS {
            let (layout, equations) = (self.motion.layout(), &self.flows[state.flow].equations);
            let rate = |of: usize| &equations.derivative[of];
            let beside = |&g: &usize| -> Row {
                rate(layout.v(g)).iter().zip(rate(layout.v(lead))).map(|(own, lead)| own - lead).collect()
            };
            let lags: Vec<usize> = layout.lags().collect();
            let rows: Vec<Row> =
                hidden.iter().map(beside).chain(lags.iter().map(|&lag| rate(lag).clone())).collect();
            let unknowns: Vec<usize> =
                hidden.iter().map(|&g| layout.q(g)).chain(lags.iter().copied()).collect();
            let n = unknowns.len();
            let matrix = DMatrix::from_fn(n, n, |i, j| rows[i][unknowns[j]]);
            let left = DVector::from_fn(n, |i, _| -dot(&rows[i], &state.xi));
            let Some(step) = matrix.lu().solve(&left).filter(|step| step.iter().all(|x| x.is_finite()))
            else {
                return false;
            };
            for (&unknown, step) in unknowns.iter().zip(&step) {
                state.xi[unknown] += step;
            }
            let held = equations.mode;
            let Ok(beginning) = self.motion.begin(&mut self.flows, held, &mut state.xi);
            state.flow = beginning.index;
        }
        self.motion.settle_filters(&self.flows[state.flow].equations, &mut state.xi);
        true
    }
}

/// Sum over the channels of the squared errors of a prediction from the first row on, in noise. Parabolas are
/// left out, which a small error of the initial speed or of a force adds to positions. `predicted` holds the
/// signals of each row before gain and bias.
pub(super) fn swing(
    predicted: &[Vec<f64>],
    channels: &[Channel],
    assembly: &Assembly,
    record: &Record,
) -> f64 {
    let of = |(c, channel): (usize, &Channel)| {
        let (gain, bias) = channel.scale(assembly);
        let beyond: Vec<f64> = (predicted.iter().zip(&record.series[c]))
            .map(|(seen, read)| (read - bias) / gain - seen[c])
            .collect();
        let left = Parabola::through(&beyond).map_or(f64::INFINITY, |fit| fit.left());
        (left * gain / channel.noise.max(channel.resolution).max(f64::MIN_POSITIVE)).powi(2)
    };
    (channels.iter().enumerate()).filter(|(c, _)| !record.silent[*c]).map(of).sum()
}
