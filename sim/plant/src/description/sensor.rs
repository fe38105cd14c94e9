//! Sensors and their imperfections.

use feeler_catalogue::{
    Bound, CORNER, Content, DAMPING_RATIO, Dimension, Field, KeyKind, KeyRole, Keyed, LONGEST_DELAY, Slot,
    Unit, field, low_pass, number, optional, required,
};

use super::{Quantity, SignalName};
use crate::effects::EffectUse;

/// The signal of a sensor and its errors:
/// `reading = round_to(resolution, gain * low_pass(signal(t - delay)) + bias + noise)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    pub reads: SignalName,
    /// The body on which it is mounted, for motion sensors; `None` for an absolute reading.
    pub relative_to: Option<String>,
    pub gain: f64,
    /// Offset, in units of the signal.
    pub bias: f64,
    /// Analogue filter before sampling.
    pub low_pass: Option<LowPass>,
    /// Pure delay, >= 0.
    pub delay_s: f64,
    /// Quantisation step, > 0.
    pub resolution: Option<f64>,
    /// Standard deviation of white Gaussian noise per reading.
    pub noise: f64,
    /// Departures from the ideal sensor.
    pub effects: Vec<EffectUse>,
}

impl Sensor {
    /// A sensor without errors.
    pub fn ideal(reads: SignalName) -> Self {
        Self {
            reads,
            relative_to: None,
            gain: 1.0,
            bias: 0.0,
            low_pass: None,
            delay_s: 0.0,
            resolution: None,
            noise: 0.0,
            effects: Vec::new(),
        }
    }
}

/// A continuous low-pass filter of unit gain at zero frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LowPass {
    /// `1 / (1 + s / (2 pi f))`.
    FirstOrder { corner_hz: f64 },
    /// `w^2 / (s^2 + 2 zeta w s + w^2)`, `w = 2 pi f`.
    SecondOrder {
        /// Natural frequency.
        corner_hz: f64,
        /// Damping ratio `zeta`.
        damping_ratio: f64,
    },
}

impl Sensor {
    /// The signal that it reads.
    pub const READS: Field<Self> = field!(Sensor: reads,
        required("reads", KeyKind::Signal,
            "the signal, as in motor.position, tip.acceleration or tool.spring_force"));
    /// The body on which it is mounted.
    pub const RELATIVE_TO: Field<Self> = field!(Sensor: relative_to,
        optional("relative_to", KeyKind::Name("a body or `ground`"),
            "the body it rides on, for position and velocity; absolute if absent"));
    /// Its filter.
    pub const LOW_PASS: Field<Self> = field!(Sensor: low_pass,
        low_pass("analogue filter before sampling: a corner frequency, or a table"));
    /// Its scale factor.
    pub const GAIN: Field<Self> = field!(Sensor: gain,
        number("gain", Unit::Of(Dimension::NONE), Bound::Any, 1.0, "scale"), KeyRole::Believed);
    /// Its pure delay.
    pub const DELAY: Field<Self> = field!(Sensor: delay_s,
        number("delay", Unit::Of(Dimension::TIME), LONGEST_DELAY, 0.0, "pure delay"));
    /// Its step.
    pub const RESOLUTION: Field<Self> = field!(Sensor: resolution,
        optional("resolution", KeyKind::Quantity(Unit::Signal, Bound::Positive), "quantisation step"));
    /// Its noise.
    pub const NOISE: Field<Self> = field!(Sensor: noise,
        number("noise", Unit::Signal, Bound::NotNegative, 0.0,
            "one sigma of white Gaussian noise per reading"));
}

impl Keyed for Sensor {
    const FIELDS: &'static [Field<Self>] = &[
        Sensor::READS,
        Sensor::RELATIVE_TO,
        Sensor::GAIN,
        field!(Sensor: bias, number("bias", Unit::Signal, Bound::Any, 0.0, "offset")),
        Sensor::LOW_PASS,
        Sensor::DELAY,
        Sensor::RESOLUTION,
        Sensor::NOISE,
    ];

    fn blank() -> Option<Self> {
        Some(Self::ideal(SignalName::new("", Quantity::Position)))
    }
}

impl Slot for SignalName {
    fn content(&self) -> Option<Content> {
        Some(Content::Text(self.to_string()))
    }

    fn of(content: &Content) -> Option<Self> {
        if let Content::Text(text) = content { text.parse().ok() } else { None }
    }
}

/// A filter with a damping ratio is of second order.
impl Keyed for LowPass {
    const FIELDS: &'static [Field<Self>] = &[
        Field {
            key: CORNER,
            role: KeyRole::Structure,
            get: |(Self::FirstOrder { corner_hz } | Self::SecondOrder { corner_hz, .. })| corner_hz.content(),
            set: |(Self::FirstOrder { corner_hz } | Self::SecondOrder { corner_hz, .. }), content| {
                *corner_hz = f64::of(content).unwrap_or(*corner_hz);
            },
        },
        Field {
            key: DAMPING_RATIO,
            role: KeyRole::Structure,
            get: |filter| match filter {
                Self::FirstOrder { .. } => None,
                Self::SecondOrder { damping_ratio, .. } => Some(Content::Number(*damping_ratio)),
            },
            set: |filter, content| {
                let (Self::FirstOrder { corner_hz } | Self::SecondOrder { corner_hz, .. }) = *filter;
                if let Content::Number(damping_ratio) = *content {
                    *filter = Self::SecondOrder { corner_hz, damping_ratio };
                }
            },
        },
    ];

    fn blank() -> Option<Self> {
        Some(Self::FirstOrder { corner_hz: 1.0 })
    }
}
