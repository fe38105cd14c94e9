//! A motion too fine to be followed: steps so short that a run would not end.

/// Steps within [`SPAN_S`] of simulated time after which a run is given up: some seconds of work for ten
/// milliseconds.
const MOST_STEPS: u64 = 3_000_000;
const SPAN_S: f64 = 0.01;
/// What a step of a nonlinear mode costs, in polynomials of a linear one.
pub(crate) const NONLINEAR: u64 = 10;

/// Counts steps over simulated time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Toil {
    since_s: f64,
    steps: u64,
}

impl Toil {
    /// Steps were taken, up to `t_s`: whether there are more than can be followed.
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
