//! A controller as a linear system, for the analysis of the sampled loop.

use crate::controller::STATE_LENGTH;
use crate::controller::{Controller, Inputs};
use crate::error::ControlError;
use crate::spec::ControllerSpec;

/// A control law in contact, without its limit and resolution: `x[n+1] = A x[n] + B in[n]`, `u[n] = C x[n] +
/// D in[n]` with `in = [reference, reading, motion]`. Delay and hold are not included; they belong to the
/// loop.
///
/// It comes from running the controller itself on unit vectors, so it cannot differ from the simulated law.
/// States that no input reaches, or that do not reach the output, are omitted: a proportional law has none.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearLaw {
    /// `a[i][j]`: from state j to the next state i.
    pub a: Vec<Vec<f64>>,
    /// `b[i][j]`: from input j to the next state i.
    pub b: Vec<[f64; 3]>,
    /// `c[j]`: from state j to the output.
    pub c: Vec<f64>,
    /// `d[j]`: from input j to the output.
    pub d: [f64; 3],
}

impl ControllerSpec {
    /// The law as a linear system, sampled every `period_s`, for a motion sensor of velocity or position.
    ///
    /// # Errors
    /// Those of [`Self::check`].
    pub fn linear(&self, motion_is_velocity: bool) -> Result<LinearLaw, ControlError> {
        let spec = Self { approach: None, output_limit: None, output_resolution: None, ..self.clone() };
        let mut controller = Controller::<f64>::new(&[spec])?;
        let mut column = |x: [f64; STATE_LENGTH], [reference, reading, motion]: [f64; 3]| {
            controller.step_from(x, &Inputs { reading, motion, motion_is_velocity }, reference)
        };
        let of_state: [_; STATE_LENGTH] = std::array::from_fn(|j| column(unit(j), [0.0; 3]));
        let of_input: [_; 3] = std::array::from_fn(|j| column([0.0; STATE_LENGTH], unit(j)));

        let leads_to = |j: usize, i: usize| of_state[j].0[i] != 0.0;
        let reached = closure(|i| of_input.iter().any(|(next, _)| next[i] != 0.0), leads_to);
        let seen = closure(|j| of_state[j].1 != 0.0, |i, j| leads_to(j, i));
        let kept: Vec<usize> = (0..STATE_LENGTH).filter(|&i| reached[i] && seen[i]).collect();
        Ok(LinearLaw {
            a: kept.iter().map(|&i| kept.iter().map(|&j| of_state[j].0[i]).collect()).collect(),
            b: kept.iter().map(|&i| std::array::from_fn(|j| of_input[j].0[i])).collect(),
            c: kept.iter().map(|&j| of_state[j].1).collect(),
            d: std::array::from_fn(|j| of_input[j].1),
        })
    }
}

fn unit<const N: usize>(j: usize) -> [f64; N] {
    std::array::from_fn(|i| f64::from(u8::from(i == j)))
}

/// The states given by `from`, and all states that these lead to.
fn closure(from: impl Fn(usize) -> bool, leads_to: impl Fn(usize, usize) -> bool) -> [bool; STATE_LENGTH] {
    let mut member: [bool; STATE_LENGTH] = std::array::from_fn(from);
    // A path visits each state once at most.
    for _ in 0..STATE_LENGTH {
        let last = member;
        member = std::array::from_fn(|i| last[i] || (0..STATE_LENGTH).any(|j| last[j] && leads_to(j, i)));
    }
    member
}
