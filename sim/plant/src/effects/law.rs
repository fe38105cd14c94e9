//! The law of an effect as its page draws it.

/// A curve in the box from -1 to 1.
#[derive(Clone, Copy, Debug)]
pub enum Curve {
    /// Height over the horizontal axis, from [`LawDrawing::start`] to 1.
    Function(fn(f64) -> f64),
    /// A line through these points.
    Points(&'static [(f64, f64)]),
    /// A level dimension line: its two ends and its height.
    Dimension([f64; 2], f64),
}

impl Curve {
    /// The output is the input.
    pub(super) const UNCHANGED: Self = Self::Points(&[(-0.9, -0.9), (0.9, 0.9)]);
    /// A step in time.
    pub(super) const STEP: Self = Self::Points(&[(0.0, 0.0), (0.1, 0.0), (0.1, 0.6), (1.0, 0.6)]);
    /// The same, late.
    pub(super) const LATE_STEP: Self = Self::Points(&[(0.0, 0.0), (0.4, 0.0), (0.4, 0.6), (1.0, 0.6)]);
    /// The same, behind a first-order lag.
    pub(super) const LAGGED_STEP: Self =
        Self::Function(|time| 0.6 * (1.0 - (-(time - 0.1).max(0.0) / 0.2).exp()));
    /// The nearest of evenly spaced values.
    pub(super) const ROUNDED: Self = Self::Function(|value| (4.0 * value).round() / 4.0);
    /// The damping that a guide has by itself, over its speed.
    pub(super) const GUIDE: Self = Self::Points(&[(-1.0, -0.3), (1.0, 0.3)]);

    /// Its points, if the horizontal axis begins at `start`.
    pub fn points(self, start: f64) -> Vec<(f64, f64)> {
        match self {
            Self::Points(points) => points.to_vec(),
            Self::Function(height) => (0..=PIECES)
                .map(|piece| start + (1.0 - start) * f64::from(piece) / f64::from(PIECES))
                // A step at zero is upright: both zeros have the sign of their side.
                .flat_map(|across| if across.abs() < f64::EPSILON { vec![-0.0, 0.0] } else { vec![across] })
                .map(|across| (across, height(across)))
                .collect(),
            Self::Dimension([from, to], up) => {
                [(from, TICK), (from, -TICK), (from, 0.0), (to, 0.0), (to, TICK), (to, -TICK)]
                    .map(|(across, off)| (across, up + off))
                    .to_vec()
            }
        }
    }

    /// Width of its line in pixels: a dimension line is thin.
    pub fn width(self) -> u32 {
        if matches!(self, Self::Dimension(..)) { 1 } else { 2 }
    }
}

/// As many straight pieces as draw a function; even, so that one of their ends is zero.
const PIECES: u32 = 160;
/// Half the height of the strokes that end a dimension line.
const TICK: f64 = 0.06;

/// A law as curves over axes without numbers.
#[derive(Clone, Copy, Debug)]
pub struct LawDrawing {
    /// Quantities on the horizontal and the vertical axis.
    pub axes: [&'static str; 2],
    /// Start of the horizontal axis: -1, or 0 if nothing is negative.
    pub start: f64,
    /// The machine with the effect.
    pub with: &'static [Curve],
    /// The machine without it; may be empty.
    pub without: &'static [Curve],
    /// Texts that name parameters and directions, each with the point at which it begins.
    pub labels: &'static [(f64, f64, &'static str)],
}
