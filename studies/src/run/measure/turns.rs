//! Separates oscillation from monotonic motion.

/// Part of its own range by which a value must return to count as a turn, so that ripple does not count.
const TURN: f64 = 0.25;

/// Number of turns of the values.
pub(in crate::run) fn turns(values: &[f64]) -> usize {
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)));
    let least = TURN * (high - low);
    let Some(&first) = values.first() else { return 0 };
    let (mut lowest, mut highest) = (first, first);
    // Present direction; unknown before the value has moved far enough.
    let mut rising: Option<bool> = None;
    let mut turns = 0;
    for &value in values {
        (lowest, highest) = (lowest.min(value), highest.max(value));
        let now = match rising {
            Some(true) | None if highest - value > least => false,
            Some(false) | None if value - lowest > least => true,
            _ => continue,
        };
        turns += usize::from(rising.is_some());
        rising = Some(now);
        (lowest, highest) = (value, value);
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn truth_a_sine_turns_twice_per_cycle_and_a_ramp_never() {
        let values = |of: fn(f64) -> f64| (0..1000).map(|i| of(f64::from(i) * 1e-3)).collect::<Vec<_>>();
        assert_eq!(turns(&values(|t| 20.0 + 3.0 * (TAU * 7.0 * t).sin())), 14);
        assert_eq!(turns(&values(|t| 20.0 - 3.0 * t)), 0);
        assert_eq!(turns(&values(|t| t + 0.01 * (TAU * 50.0 * t).sin())), 0);
        assert_eq!(turns(&values(|_| 20.0)), 0);
        assert_eq!(turns(&[]), 0);
    }
}
