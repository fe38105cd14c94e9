//! How friction reverses: a guide gives way before it slides, as the force around reversals shows.

/// Trial presliding lengths, as shares of the stroke, and their limits.
const LENGTHS: [f64; 6] = [1e-6, 1e-4, 2.5e-4, 6e-4, 1.5e-3, 4e-3];
const LENGTH_LIMITS: [f64; 2] = [1e-6, 1e-2];
/// Least and largest lead, over `sqrt(length mass / command)`. With friction of a third of the largest
/// command, 2 is a damping ratio of presliding of 0.7.
const LEAD_LIMITS: [f64; 2] = [0.1, 8.0];
/// Usual lead, over the least one.
const USUAL_LEAD: f64 = 10.0;
/// Ratio of two trials, at first and at last.
const STEP: f64 = 1.6;
const FINEST: f64 = 1.02;
/// Least reduction of a residual that counts, and largest number of steps.
const LEAST_GAIN: f64 = 1e-4;
const MOST_STEPS: usize = 30;

/// How friction reverses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Reversal {
    /// Dahl's presliding length, m.
    pub(crate) length_m: f64,
    /// Ratio of the damping to the stiffness of the bristles, s: by this their force leads.
    pub(crate) lead_s: f64,
    /// Index of the sharpness with which reversals are seen: corners of the speed that double.
    pub(crate) sharpness: usize,
}

/// Limits of reversals.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Limits {
    stroke_m: f64,
    /// Believed mass over the largest command, s²/m.
    mass_per_command: f64,
    sharpest: usize,
}

impl Limits {
    /// The limits of a stroke, of a believed mass over the largest command, and of the sharpness.
    pub(super) fn new(stroke_m: f64, mass_per_command: f64, sharpest: usize) -> Self {
        Self { stroke_m, mass_per_command, sharpest }
    }

    pub(super) fn sharpest(&self) -> usize {
        self.sharpest
    }

    fn lead_s(&self, length_m: f64) -> [f64; 2] {
        let slow_s = (length_m * self.mass_per_command).sqrt();
        LEAD_LIMITS.map(|times| times * slow_s)
    }

    /// The reversal within the limits; a lead below the least one is zero.
    pub(super) fn within(&self, found: Reversal) -> Reversal {
        let [shortest, longest] = LENGTH_LIMITS.map(|share| share * self.stroke_m);
        let length_m = found.length_m.clamp(shortest, longest);
        let [least, most] = self.lead_s(length_m);
        let lead_s = if found.lead_s < least { 0.0 } else { found.lead_s.min(most) };
        Reversal { length_m, lead_s, sharpness: found.sharpness.min(self.sharpest) }
    }

    /// The neighbours in which the length, the lead or the sharpness differs by a step.
    fn near(&self, of: Reversal, by: f64) -> impl Iterator<Item = Reversal> {
        let longer = if of.lead_s > 0.0 { of.lead_s * by } else { self.lead_s(of.length_m)[0] };
        let all = [
            Reversal { length_m: of.length_m / by, ..of },
            Reversal { length_m: of.length_m * by, ..of },
            Reversal { lead_s: of.lead_s / by, ..of },
            Reversal { lead_s: longer, ..of },
            Reversal { sharpness: of.sharpness.saturating_sub(1), ..of },
            Reversal { sharpness: of.sharpness + 1, ..of },
        ];
        all.map(|near| self.within(near)).into_iter().filter(move |near| *near != of)
    }

    /// Trials over all lengths, with the usual lead.
    pub(super) fn all(self) -> impl Iterator<Item = Reversal> {
        LENGTHS.into_iter().map(move |share| {
            let length_m = share * self.stroke_m;
            self.within(Reversal { length_m, lead_s: USUAL_LEAD * self.lead_s(length_m)[0], sharpness: 0 })
        })
    }

    /// The reversal near another one that leaves least, with what both leave: steps shrink where no neighbour
    /// leaves less.
    pub(super) fn refined(&self, begun: (f64, Reversal), left: impl Fn(Reversal) -> f64) -> (f64, Reversal) {
        let mut best = begun;
        let mut by = STEP;
        for _ in 0..MOST_STEPS {
            let next = least(self.near(best.1, by), &left);
            if next.0 < best.0 * (1.0 - LEAST_GAIN) {
                best = next;
            } else if by > FINEST {
                by = by.sqrt();
            } else {
                break;
            }
        }
        best
    }
}

/// The reversal that leaves least, with what it leaves.
pub(super) fn least(
    trials: impl Iterator<Item = Reversal>,
    left: impl Fn(Reversal) -> f64,
) -> (f64, Reversal) {
    lowest(trials.map(|reversal| (left(reversal), reversal)))
}

/// The reversal that leaves least of those for which this is known.
pub(super) fn lowest(tried: impl Iterator<Item = (f64, Reversal)>) -> (f64, Reversal) {
    let finite = tried.filter(|(left, _)| left.is_finite());
    finite.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, Reversal::default()))
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    const LIMITS: Limits = Limits { stroke_m: 1.0, mass_per_command: 0.1, sharpest: 2 };

    /// A residual of which a hundredth depends on the logarithms of length and lead.
    #[test]
    fn truth_a_search_ends_at_the_least_residual() {
        let of = |r: Reversal| {
            let squares = (r.length_m / 1e-4).ln().powi(2) + (r.lead_s / 3e-3).ln().powi(2);
            1.0 + 0.01 * squares + 0.01 * (r.sharpness as f64 - 2.0).powi(2)
        };
        let from = Reversal { length_m: 3e-4, lead_s: 1e-2, sharpness: 0 };
        let (_, found) = LIMITS.refined((of(from), from), of);
        assert_eq!(found.sharpness, 2);
        // A step counts if it gains a ten-thousandth, which a distance of a tenth in the logarithm costs. A
        // step of twice that distance gains nothing.
        for ratio in [found.length_m / 1e-4, found.lead_s / 3e-3] {
            assert!(ratio.ln().abs() < 0.2, "{found:?}");
        }
    }

    #[test]
    fn truth_a_search_ends_where_nothing_is_finite_or_better() {
        let from = Reversal { length_m: 1e-4, lead_s: 0.0, sharpness: 1 };
        for left in [f64::INFINITY, f64::NAN, 1.0] {
            let calls = Cell::new(0);
            let (_, found) = LIMITS.refined((left, from), |_| {
                calls.set(calls.get() + 1);
                left
            });
            assert_eq!(found, from);
            // Six neighbours at each of six steps.
            assert!(calls.get() <= 1 + 6 * 6, "{}", calls.get());
        }
        // A residual that falls forever ends at the limit.
        let (_, longest) = LIMITS.refined((2.0, from), |r| 1.0 + 1e-4 / r.length_m);
        assert!((longest.length_m / 1e-2 - 1.0).abs() < 0.3, "{longest:?}");
    }
}
