//! Position and velocity from one motion sensor.

use feeler_lanes::Lane;

use crate::listing::Listing;

/// Velocity by differentiation of a position.
#[derive(Clone, Copy)]
pub(crate) struct MotionConfig<L> {
    period: L,
    /// `tau / (tau + T)`, the pole of the filter on the differentiated velocity.
    pole: L,
    /// `1 / (tau + T)`.
    gain: L,
}

/// The last sample of a motion sensor, and the values derived from it.
#[derive(Clone, Copy, Default)]
pub(crate) struct MotionState<L> {
    started: bool,
    reading: L,
    position: L,
    velocity: L,
}

impl<L: Lane> MotionState<L> {
    /// A state some samples into a run: last reading, position, velocity.
    pub(crate) fn from_array([reading, position, velocity]: [L; 3]) -> Self {
        Self { started: true, reading, position, velocity }
    }

    pub(crate) fn to_array(self) -> [L; 3] {
        [self.reading, self.position, self.velocity]
    }
}

impl<L: Lane> MotionConfig<L> {
    pub(crate) fn new(period_s: f64, filter_s: L) -> Self {
        let period = L::splat(period_s);
        Self { period, pole: filter_s / (filter_s + period), gain: L::splat(1.0) / (filter_s + period) }
    }

    /// Position and velocity at this sample.
    ///
    /// A position sensor is differentiated: `v[n] = pole v[n-1] + gain (x[n] - x[n-1])`, the backward-Euler
    /// form of `s / (tau s + 1)`; zero at the first sample. A velocity sensor is integrated by the
    /// trapezoidal rule from zero at the first sample, and drifts with its bias like any such estimate.
    #[inline(always)]
    pub(crate) fn update(&self, state: &mut MotionState<L>, reading: L, is_velocity: bool) -> (L, L) {
        let last = if state.started { reading - state.reading } else { L::zero() };
        if is_velocity {
            let mean = L::splat(0.5) * (reading + state.reading);
            state.position = if state.started { state.position + self.period * mean } else { L::zero() };
            state.velocity = reading;
        } else {
            state.position = reading;
            state.velocity = self.pole * state.velocity + self.gain * last;
        }
        state.started = true;
        state.reading = reading;
        (state.position, state.velocity)
    }
}

impl MotionConfig<f64> {
    /// [`Self::update`] as lines of a program; gives the names of position and velocity. The position of a
    /// velocity sensor is left out where nothing `integrates` it.
    pub(crate) fn list(
        &self,
        l: &mut Listing,
        reading: &str,
        is_velocity: bool,
        integrates: bool,
    ) -> (String, String) {
        if is_velocity && !integrates {
            return (String::new(), reading.into());
        }
        l.truth_state("started");
        l.number_state("motion");
        if is_velocity {
            l.constant("PERIOD", self.period);
            l.number_state("position");
            let moved = format!("s.position + PERIOD * (0.5 * ({reading} + s.motion))");
            l.choice("position", "s.started", &moved, "0.0");
            l.set("position", "position");
            l.set("motion", reading);
            return ("position".into(), reading.into());
        }
        l.constant("VELOCITY_POLE", self.pole);
        l.constant("VELOCITY_GAIN", self.gain);
        l.number_state("velocity");
        l.choice("moved", "s.started", &format!("{reading} - s.motion"), "0.0");
        l.number("velocity", "VELOCITY_POLE * s.velocity + VELOCITY_GAIN * moved");
        l.set("velocity", "velocity");
        l.set("motion", reading);
        (reading.into(), "velocity".into())
    }
}
