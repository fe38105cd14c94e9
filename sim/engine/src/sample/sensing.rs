//! From the filtered signal of a sensor to the number that a controller or a recorder reads.

use feeler_catalogue::Tabled;
use feeler_control::{Draws, Stream};
use feeler_lanes::Lane;
use feeler_plant::assembly::SensorPart;
use feeler_plant::description::Sensor;

/// Picoseconds per second: the time grid of the noise.
const PICOSECONDS: f64 = 1e12;

/// Index of the noise value of an instant.
#[inline(always)]
pub(crate) fn noise_index(t_s: f64) -> u64 {
    (t_s * PICOSECONDS).round() as u64
}

/// One sensor of every lane. The noise of a reading depends on sensor and instant, and not on the reader or
/// the number of readings.
#[derive(Clone, Debug)]
pub struct Sensing<L> {
    gain: L,
    bias: L,
    noise: L,
    /// Quantisation steps in order; zero for none.
    resolutions: Vec<L>,
    noisy: bool,
    stream: Stream,
    pub delay_s: f64,
}

impl<L: Lane> Sensing<L> {
    /// The sensors must have the same delay and the same number of quantisations.
    pub fn new(of_lane: &[&SensorPart], seed: u64) -> Self {
        let number = |f: &dyn Fn(&SensorPart) -> f64| L::from_fn(|lane| f(of_lane[lane]));
        Self {
            gain: number(&|sensor| sensor.gain),
            bias: number(&|sensor| sensor.bias),
            noise: number(&|sensor| sensor.noise),
            resolutions: (0..of_lane[0].resolutions.len())
                .map(|k| number(&|sensor| sensor.resolutions[k]))
                .collect(),
            noisy: of_lane.iter().any(|sensor| sensor.noise > 0.0),
            stream: Stream::new(seed, &Sensor::place(&of_lane[0].name)),
            delay_s: of_lane[0].delay,
        }
    }

    /// The reading at `t_s` of a (delayed, filtered) signal.
    pub fn read(&self, t_s: f64, signal: L) -> L {
        self.read_with(signal, || self.stream.normal_at(noise_index(t_s)))
    }

    /// The reading at `t_s`, with noise values that one reader has drawn ahead.
    #[inline(always)]
    pub(crate) fn read_ahead(&self, t_s: f64, signal: L, draws: &mut Draws) -> L {
        self.read_with(signal, || draws.normal_at(noise_index(t_s)))
    }

    /// The noise values of this sensor for one reader.
    pub(crate) fn draws(&self) -> Draws {
        Draws::new(self.stream.clone())
    }

    #[inline(always)]
    fn read_with(&self, signal: L, normal: impl FnOnce() -> f64) -> L {
        let mut reading = self.gain * signal + self.bias;
        if self.noisy {
            reading += self.noise * L::splat(normal());
        }
        for &step in &self.resolutions {
            reading = reading.zip(
                step,
                #[inline(always)]
                |x, q| if q > 0.0 { (x / q).round() * q } else { x },
            );
        }
        reading
    }
}
