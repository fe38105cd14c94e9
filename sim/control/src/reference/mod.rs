//! References and excitations: the desired value of a loop, as a pure function of time.
//!
//! [`Reference::value`] accepts any instants in any order, and always gives the same answer, since it changes
//! no random state. An excitation of the drive itself is an open-loop controller with such a reference.

mod chirp;
mod keys;
mod multisine;
mod points;
mod prbs;
mod spec;
mod white_noise;

use chirp::Chirp;
use keys::{AMPLITUDE, CLOCK_PERIOD, OFFSET, key};
use multisine::Multisine;
use points::Points;
use prbs::Prbs;
use white_noise::WhiteNoise;

pub use keys::{FOLLOWED, REFERENCE, SAMPLES_FILE, SAMPLES_PATH};
pub use spec::{Between, ChirpSweep, Lines, ReferenceSpec};

use crate::error::{ControlError, finite, positive};
use crate::noise::Stream;

/// A [`ReferenceSpec`] ready for evaluation. Cloning is cheap: long tables are shared.
#[derive(Clone, Debug)]
pub struct Reference {
    shape: Shape,
    offset: f64,
}

#[derive(Clone, Debug)]
enum Shape {
    Constant,
    Points(Points),
    Chirp(Chirp),
    Multisine(Multisine),
    WhiteNoise(WhiteNoise),
    Prbs(Prbs),
}

impl Reference {
    /// Compiles `spec` for the element `name` in a run with `seed`; both matter for random shapes only.
    ///
    /// # Errors
    /// A number out of its range, points out of order, or a multisine without lines.
    pub fn new(spec: &ReferenceSpec, seed: u64, name: &str) -> Result<Self, ControlError> {
        let stream = || Stream::new(seed, &format!("{name}/reference"));
        let (shape, offset) = match *spec {
            ReferenceSpec::Constant(value) => (Shape::Constant, finite(FOLLOWED.name, value)?),
            ReferenceSpec::Steps(ref points) => (Shape::Points(Points::steps(points)?), 0.0),
            ReferenceSpec::PiecewiseLinear(ref points) => (Shape::Points(Points::lines(points)?), 0.0),
            ReferenceSpec::Chirp { sweep, amplitude, start_hz, end_hz, duration_s, offset } => {
                (Shape::Chirp(Chirp::new(sweep, amplitude, start_hz, end_hz, duration_s)?), offset)
            }
            ReferenceSpec::Multisine { lines, low_hz, high_hz, period_s, rms, offset } => (
                Shape::Multisine(Multisine::new(lines, [low_hz, high_hz], period_s, rms, &stream())?),
                offset,
            ),
            ReferenceSpec::WhiteNoise { low_hz, high_hz, rms, offset } => {
                (Shape::WhiteNoise(WhiteNoise::new([low_hz, high_hz], rms, stream())?), offset)
            }
            ReferenceSpec::Prbs { order, clock_period_s, amplitude, offset } => {
                let clock_period_s = positive(key(&CLOCK_PERIOD), clock_period_s)?;
                let amplitude = finite(key(&AMPLITUDE), amplitude)?;
                (Shape::Prbs(Prbs::new(order, clock_period_s, amplitude, &stream())?), offset)
            }
            ReferenceSpec::Table { ref times_s, ref values, between, offset } => {
                (Shape::Points(Points::table(times_s, values, between)?), offset)
            }
        };
        Ok(Self { shape, offset: finite(key(&OFFSET), offset)? })
    }

    /// The reference at `t_s`.
    #[inline]
    pub fn value(&self, t_s: f64) -> f64 {
        if matches!(self.shape, Shape::Constant) { self.offset } else { self.offset + self.about_mean(t_s) }
    }

    fn about_mean(&self, t_s: f64) -> f64 {
        match &self.shape {
            Shape::Constant => 0.0,
            Shape::Points(points) => points.value(t_s),
            Shape::Chirp(chirp) => chirp.value(t_s),
            Shape::Multisine(multisine) => multisine.value(t_s),
            Shape::WhiteNoise(noise) => noise.value(t_s),
            Shape::Prbs(prbs) => prbs.value(t_s),
        }
    }
}
