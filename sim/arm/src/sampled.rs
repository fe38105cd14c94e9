//! Stable gains of a sampled force loop on a linear arm or axis in contact.
//!
//! Sampling and hold are exact: the matrix exponential carries the plant over one period. Where the open loop
//! `L(z)` crosses the negative real axis on the unit circle, `-1 / L` is a gain with a pole on the circle.
//! The smallest of these gains bounds the stable gains from zero onwards, since the plant alone only
//! dissipates energy and is stable.

use std::f64::consts::{PI, TAU};

use feeler_lti::{C64, LtiError, StateSpace, TransferEvaluator};
use nalgebra::{DMatrix, DVector};

use crate::linear_system::LinearSystem;

/// Period of the analysed force loops, s.
pub const PERIOD_S: f64 = 1e-3;
/// Points of the unit circle per decade of frequency, and their start relative to the first given frequency.
const PER_DECADE: f64 = 200.0;
const FROM: f64 = 0.05;
/// Points about each mode in half widths of its peak, and the smallest half width of the search over its
/// frequency.
const ABOUT: [f64; 8] = [-6.0, -2.5, -1.2, -0.4, 0.4, 1.2, 2.5, 6.0];
const NARROWEST: f64 = 1e-6;
/// Angle on the unit circle below which no crossover is searched: a microhertz.
const SLOWEST: f64 = 1e-6 * TAU * PERIOD_S;
/// Bisections of the step with a crossing: to rounding of a gain.
const HALVINGS: u32 = 40;

/// Share of a frequency on each side for a slope, and the largest accepted slope.
const BESIDE: f64 = 2e-3;
const STEEPEST: f64 = 20.0;

/// Drive forces: those of the motors with a common bandwidth, Hz, per force along the normal.
pub(crate) type Lag = (Option<f64>, DVector<f64>);

/// The mechanics on the drive with a contact, sampled: spring force of the contact and displacement of the
/// drive, on the unit circle.
pub(crate) struct SampledPlant {
    plant: TransferEvaluator,
    /// Angles on the unit circle, rising to half a turn, and the plant's response there.
    circle: Vec<(f64, [C64; 2])>,
}

/// The end of the stable gains.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    /// Zero if no gain is stable, infinite if all are.
    pub(crate) gain: f64,
    /// Frequency of the motion that grows beyond the edge; NaN if every gain is stable.
    pub(crate) frequency_hz: f64,
    /// Change of the logarithm of the open loop's modulus per change of its phase along the frequency there,
    /// 1/rad.
    pub(crate) size_per_phase: f64,
}

impl Edge {
    /// No edge could be found.
    pub(crate) const UNKNOWN: Self = Self { gain: f64::NAN, frequency_hz: f64::NAN, size_per_phase: 0.0 };
}

/// A law of force control with one gain on a signal.
#[derive(Clone, Copy)]
pub(crate) enum Law {
    /// The gain on the force.
    Proportional,
    /// Gain on the sum of all forces times the period, with this damping of the drive's speed, N s/m.
    Integral(f64),
    /// The damping itself: the gain on the difference of the drive's last two positions over the period.
    Damping,
}

impl SampledPlant {
    /// A system on a contact (N/m, N s/m), driven through lags.
    pub(crate) fn new(
        system: &LinearSystem,
        lags: &[Lag],
        contact: [f64; 2],
        first_hz: f64,
    ) -> Result<Self, LtiError> {
        let plant = TransferEvaluator::new(&state_space(system, lags, contact)?.zero_order_hold(PERIOD_S)?);
        let last = PI / PERIOD_S / TAU;
        let from = (FROM * first_hz).min(0.5 * last);
        let steps = (PER_DECADE * (last / from).log10()).ceil();
        let mut frequencies: Vec<f64> =
            (0..steps as u32).map(|i| from * (last / from).powf(f64::from(i) / steps)).collect();
        for mode in system.modes(contact[0]) {
            let width = mode.frequency_hz * mode.damping_ratio.max(NARROWEST);
            frequencies.extend(
                ABOUT
                    .iter()
                    .map(|about| mode.frequency_hz + about * width)
                    .filter(|f| *f > from && *f < last),
            );
        }
        frequencies.push(last);
        frequencies.sort_by(f64::total_cmp);
        let mut sampled = Self { plant, circle: Vec::with_capacity(frequencies.len()) };
        sampled.circle =
            frequencies.iter().map(|f| TAU * f * PERIOD_S).map(|angle| (angle, sampled.at(angle))).collect();
        Ok(sampled)
    }

    /// Largest proportional gain up to which every gain is stable.
    pub(crate) fn largest_kp(&self) -> Edge {
        self.largest(Law::Proportional)
    }

    /// Largest integral gain up to which every gain is stable, 1/s, with this damping of the drive's speed, N
    /// s/m. Zero if that damping alone is unstable.
    pub(crate) fn largest_ki_per_s(&self, damping_n_s_per_m: f64) -> Edge {
        let damping = self.largest(Law::Damping);
        if damping_n_s_per_m < damping.gain {
            self.largest(Law::Integral(damping_n_s_per_m))
        } else {
            Edge { gain: 0.0, ..damping }
        }
    }

    /// Crossover of integral control with this damping of the drive's speed, N s/m: where the loop gain first
    /// falls to one, Hz. NaN unless `ki`, 1/s, is positive and finite.
    pub(crate) fn crossover_hz(&self, damping_n_s_per_m: f64, ki: f64) -> f64 {
        if !(ki > 0.0 && ki.is_finite()) {
            return f64::NAN;
        }
        let law = Law::Integral(damping_n_s_per_m);
        let is_below =
            |angle: f64, [force, way]: [C64; 2]| ki * law.open(C64::cis(angle), force, way).norm() < 1.0;
        let Some(below) = self.circle.iter().position(|&(angle, answer)| is_below(angle, answer)) else {
            return f64::NAN;
        };
        let mut high = self.circle[below].0;
        let mut low = if below == 0 { 0.5 * high } else { self.circle[below - 1].0 };
        // Below the circle's first point the loop is an integrator.
        while below == 0 && low > SLOWEST && is_below(low, self.at(low)) {
            (low, high) = (0.5 * low, low);
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if is_below(middle, self.at(middle)) { high = middle } else { low = middle }
        }
        low / PERIOD_S / TAU
    }

    fn at(&self, angle: f64) -> [C64; 2] {
        let nowhere = C64::new(f64::NAN, f64::NAN);
        self.plant.at(C64::cis(angle)).map_or([nowhere; 2], |response| [response[(0, 0)], response[(1, 0)]])
    }

    /// The smallest gain that puts a pole on the unit circle.
    fn largest(&self, law: Law) -> Edge {
        let open = |(angle, [force, way]): &(f64, [C64; 2])| law.open(C64::cis(*angle), *force, *way);
        let mut smallest = Edge { gain: f64::INFINITY, ..Edge::UNKNOWN };
        let mut take = |angle: f64, crossing: C64| {
            if crossing.re < 0.0 && -crossing.re.recip() < smallest.gain {
                smallest =
                    Edge { gain: -crossing.re.recip(), frequency_hz: angle / PERIOD_S / TAU, ..smallest };
            }
        };
        for pair in self.circle.windows(2) {
            let (a, b) = (open(&pair[0]), open(&pair[1]));
            if a.im * b.im > 0.0 || (a.re > 0.0 && b.re > 0.0) || (a + b).is_nan() {
                continue;
            }
            let (mut low, mut high) = (pair[0].0, pair[1].0);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                let same = open(&(middle, self.at(middle))).im * a.im > 0.0;
                if same { low = middle } else { high = middle }
            }
            take(low, open(&(low, self.at(low))));
        }
        if let Some(last) = self.circle.last() {
            take(last.0, open(last));
        }
        let angle = TAU * smallest.frequency_hz * PERIOD_S;
        let [before, after] =
            [1.0 - BESIDE, 1.0 + BESIDE].map(|factor| open(&(factor * angle, self.at(factor * angle))));
        let turned = (after / before).ln();
        let slope = turned.re / turned.im;
        Edge {
            size_per_phase: if slope.is_finite() { slope.clamp(-STEEPEST, STEEPEST) } else { 0.0 },
            ..smallest
        }
    }
}

/// The hold and the drives' lag at a frequency.
fn held(frequency_hz: f64, bandwidth_hz: Option<f64>) -> C64 {
    let half = PI * frequency_hz * PERIOD_S;
    let lag = bandwidth_hz.map_or(C64::new(1.0, 0.0), |corner| C64::new(1.0, frequency_hz / corner).inv());
    C64::from_polar(half.sin() / half, -half) * lag
}

impl Law {
    /// The open loop per gain, from continuous responses of force and drive. Frequencies beyond half the
    /// sample rate are omitted.
    pub(crate) fn open_at(self, frequency_hz: f64, bandwidth_hz: Option<f64>, [force, way]: [C64; 2]) -> C64 {
        let through = held(frequency_hz, bandwidth_hz);
        self.open(C64::cis(TAU * frequency_hz * PERIOD_S), through * force, through * way)
    }

    fn open(self, z: C64, force: C64, way: C64) -> C64 {
        let speed = (1.0 - 1.0 / z) / PERIOD_S * way;
        match self {
            Self::Proportional => force,
            Self::Integral(damping) => PERIOD_S * z / (z - 1.0) * force / (1.0 + damping * speed),
            Self::Damping => speed,
        }
    }
}

/// From the commanded drive force to the contact's spring force and the drive's displacement.
fn state_space(system: &LinearSystem, lags: &[Lag], [k, c]: [f64; 2]) -> Result<StateSpace, LtiError> {
    let n = system.drive.len();
    let touch = &system.tip * system.tip.transpose();
    let singular = LtiError::NotFinite { quantity: "inverse of the mass" };
    let mobility = system.mass.clone().cholesky().ok_or(singular)?.inverse();
    let slow: Vec<(f64, &DVector<f64>)> =
        lags.iter().filter_map(|(hz, force)| Some((TAU * (*hz)?, force))).collect();
    let order = 2 * n + slow.len();
    let mut a = DMatrix::zeros(order, order);
    let mut b = DMatrix::zeros(order, 1);
    a.view_mut((0, n), (n, n)).fill_with_identity();
    a.view_mut((n, 0), (n, n)).copy_from(&(-&mobility * (&system.stiffness + k * &touch)));
    a.view_mut((n, n), (n, n)).copy_from(&(-&mobility * (&system.damping + c * &touch)));
    for (_, force) in lags.iter().filter(|(hz, _)| hz.is_none()) {
        let mut pushed = b.view_mut((n, 0), (n, 1));
        pushed += &mobility * force;
    }
    for (i, (corner, force)) in (2 * n..).zip(slow) {
        a.view_mut((n, i), (n, 1)).copy_from(&(&mobility * force));
        a[(i, i)] = -corner;
        b[(i, 0)] = corner;
    }
    let mut seen = DMatrix::zeros(2, order);
    seen.view_mut((0, 0), (1, n)).copy_from(&(k * system.tip.transpose()));
    seen.view_mut((1, 0), (1, n)).copy_from(&system.drive.transpose());
    StateSpace::new(a, b, seen, DMatrix::zeros(2, 1))
}
