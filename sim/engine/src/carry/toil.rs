//! Detects motions that are too fast to follow: steps so short that a run would not end.

/// Largest number of steps within [`SPAN_S`] of simulated time; beyond it the run ends. These steps take some
/// seconds of computation.
const MOST_STEPS: u64 = 3_000_000;
const SPAN_S: f64 = 0.01;
/// Cost of a polynomial of a linear mode with the ledger, in polynomials without it.
pub(crate) const WITH_ENERGY: u64 = 3;
/// Cost of a step of a nonlinear mode, in polynomials of a linear one.
pub(crate) const NONLINEAR: u64 = 20;

/// Counts steps over simulated time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Toil {
    since_s: f64,
    steps: u64,
}

impl Toil {
    /// Counts steps up to `t_s` and returns whether there are too many.
    pub(crate) fn took(&mut self, steps: u64, t_s: f64) -> bool {
        if t_s - self.since_s > SPAN_S {
            *self = Self { since_s: t_s, steps: 0 };
        }
        self.steps += steps;
        self.steps > MOST_STEPS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_only_steps_that_lead_nowhere_are_too_many() {
        let mut toil = Toil::default();
        assert!((0..10_000_000_u64).all(|i| !toil.took(1, 1e-8 * i as f64)), "a hundred million a second");
        let mut toil = Toil::default();
        assert!((0..10_000_000_u64).any(|i| toil.took(1, 1e-10 * i as f64)), "ten thousand million a second");
    }
}
