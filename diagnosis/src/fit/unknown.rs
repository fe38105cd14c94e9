//! One unknown of a fit.

use feeler_plant::description::Site;

/// Number of standard deviations that correspond to a tolerance.
pub(super) const SIGMAS: f64 = 2.0;
/// A value this close to an end, as a share of the width of its tolerance, counts as being at the end.
const AT_END: f64 = 5e-3;

/// The quantity that one unknown represents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// A believed number: its element, and its index among the element's keys.
    Value(Site, usize),
    /// A parameter of a believed effect: the element, and the indices of the effect and the parameter.
    Belief(Site, usize, usize),
    /// A parameter of a trial effect: the index of the effect in the model, and of the parameter in its
    /// definition.
    Effect(usize, usize),
    /// Natural frequency of presliding in sticking guides.
    PreslidingFrequency,
    /// Damping ratio of presliding in sticking guides.
    PreslidingDamping,
    /// Time from a row to the instant at which its command acts, in rows.
    CommandTiming,
}

/// One unknown of a fit. The fit changes `theta`: the logarithm of the value, or the value in units of
/// `unit`.
#[derive(Clone, Debug)]
pub(crate) struct Unknown {
    pub(super) target: Target,
    pub(super) log: bool,
    pub(super) unit: f64,
    /// Centre and standard deviation of the prior in `theta`; `None` for a parameter of an effect.
    pub(crate) prior: Option<(f64, f64)>,
    pub(crate) bounds: (f64, f64),
    /// Step of finite differences in `theta`.
    pub(crate) difference: f64,
}

impl Unknown {
    pub(crate) fn value(&self, theta: f64) -> f64 {
        if self.log { theta.exp() } else { theta * self.unit }
    }

    pub(crate) fn theta(&self, value: f64) -> f64 {
        if self.log { value.max(f64::MIN_POSITIVE).ln() } else { value / self.unit }
    }

    /// Standard deviation of the value from that of `theta`.
    pub(crate) fn spread(&self, theta: f64, sigma: f64) -> f64 {
        if self.log { theta.exp() * sigma } else { self.unit * sigma }
    }

    /// Whether the value lies at the limit of its tolerance. Its range may end elsewhere: damping may be much
    /// smaller, and some kinds of values have bounds of their own.
    pub(super) fn is_at_limit(&self, theta: f64) -> bool {
        let (low, high) = self.bounds;
        let Some((centre, sigma)) = self.prior else { return false };
        let is_limit = |end: f64| ((end - centre).abs() - SIGMAS * sigma).abs() < AT_END * SIGMAS * sigma;
        [low, high].iter().any(|end| is_limit(*end) && (theta - end).abs() < AT_END * (high - low))
    }

    /// Whether the value lies at an end of its range.
    pub(super) fn is_at_end(&self, theta: f64) -> bool {
        let (low, high) = self.bounds;
        (theta - low).min(high - theta) < AT_END * (high - low)
    }

    pub(super) fn is_presliding(&self) -> bool {
        matches!(self.target, Target::PreslidingFrequency | Target::PreslidingDamping)
    }

    /// Whether the unknown is a parameter of a trial effect.
    pub(super) fn is_of_effect(&self) -> bool {
        matches!(self.target, Target::Effect(..))
    }

    /// The parameter's index if the unknown belongs to effect `effect`.
    pub(crate) fn parameter_of(&self, effect: usize) -> Option<usize> {
        match self.target {
            Target::Effect(e, parameter) if e == effect => Some(parameter),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_only_ends_of_the_tolerance_are_its_limits() {
        let of = |bounds| Unknown {
            target: Target::PreslidingDamping,
            log: true,
            unit: 1.0,
            prior: Some((1.0, 0.35)),
            bounds,
            difference: 1e-3,
        };
        let both = of((0.3, 1.7));
        assert!(both.is_at_limit(0.3) && both.is_at_limit(1.7) && !both.is_at_limit(1.0));
        // Damping may be much smaller than believed; other ranges may begin at the believed value.
        let lower = of((-1.1, 1.7));
        assert!(!lower.is_at_limit(-1.1) && lower.is_at_limit(1.7));
        let clipped = of((1.0, 1.7));
        assert!(!clipped.is_at_limit(1.0) && clipped.is_at_limit(1.7));
    }
}
