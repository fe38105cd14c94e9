//! Keeps the rigid motion of a prediction on the measured motion.
//!
//! The bodies that carry an encoder, and all bodies connected to them by springs, are corrected together. The
//! correction has two parts:
//!
//! - Accelerometers correct by the difference between reading and prediction, so that a force missing in the
//!   model does not spoil the motion.
//! - The encoder corrects slowly, so that the noise of accelerometers does not accumulate.
//!
//! Relative motion inside the chain keeps its prediction. So do bodies outside it (base, workpiece), and a
//! hidden mode needs no restart. The gains are those of the steady Kalman filter of a mass whose acceleration
//! and position are measured with noise. They form an observer with `omega = (q / r)^(1/4)` and damping ratio
//! `1/sqrt(2)`, where `q` and `r` are the two noise densities.

use feeler_plant::assembly::{Assembly, GROUND_NODE, Link, Source};
use feeler_plant::description::Quantity;
use feeler_plant::motion::Motion;

use super::begin::{beginning, first_value, is_in_motion, pace};
use super::bristle::Bristle;
use super::machine::Moving;
use super::state::State;
use crate::dataset::{Channel, Record};

/// Lowest and highest natural frequency of the observer correction, rad/s.
const OMEGA_RANGE: (f64, f64) = (6.0, 320.0);
/// Highest natural frequency without accelerometers, rad/s: slow against vibration, so that forces of the
/// model remain visible, but fast against drift.
const OMEGA_WITHOUT_ACCELEROMETERS: f64 = 40.0;
/// Largest apparent acceleration from an encoder's noise and steps, over that of the motion. An error of the
/// corrected position is an acceleration times the squared time constant of the correction. With a fast
/// correction the encoder's steps hide the forces of a slow motion. With a slow one, friction reverses at
/// other instants than in the measured motion.
const NOISE_SHARE: f64 = 0.05;
/// Smallest ratio of the observer's natural frequency without accelerometers to the frequency of the motion.
const ABOVE_MOTION: f64 = 6.0;
/// Lowest natural frequency of the observer without accelerometers, rad/s.
const SLOWEST: f64 = 2.0;
/// A spring is deflected if the readings at its ends differ by more than this many of their steps.
const BENT_STEPS: f64 = 8.0;
/// Ratio of a step to the noise above which the step dominates the error of a reading.
const COARSE: f64 = 4.0;

/// Whether predictions are corrected toward the measured motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchoring {
    /// Corrected at every row.
    Continuous,
    /// Never corrected: the prediction runs freely from its start.
    Never,
}

/// Meaning of a difference between the first readings of two bodies, beyond their steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Beside {
    /// The spring between them is deflected: the record begins under load.
    Bent,
    /// Their sensors have different zeros.
    Shifted,
}

/// How a record begins.
pub(super) struct Placed {
    pub(super) is_in_motion: bool,
    /// Whether readings show a deflected spring.
    pub(super) is_bent: bool,
}

/// A channel that corrects the prediction.
#[derive(Clone, Debug)]
struct Tap {
    channel: usize,
    weight: f64,
    gain: f64,
    bias: f64,
    /// Half the step if it is coarse against the noise, otherwise zero.
    dead_zone: f64,
    /// Delay of the reading, rows.
    late: usize,
}

impl Tap {
    /// The corrections by channel `number`, with a weight.
    fn of(assembly: &Assembly, channel: &Channel, spacing_s: f64, (number, weight): (usize, f64)) -> Self {
        let (gain, bias) = channel.scale(assembly);
        let (late, step) = match channel.source {
            Source::Sensor(s) => {
                let sensor = &assembly.sensors[s];
                let step = sensor.resolutions.iter().copied().fold(0.0, f64::max);
                ((sensor.delay / spacing_s).round() as usize, step)
            }
            _ => (0, 0.0),
        };
        let dead_zone = if step > COARSE * channel.noise { 0.5 * step } else { 0.0 };
        Self { channel: number, weight, gain, bias, dead_zone, late }
    }

    /// Difference between reading and prediction.
    #[inline(always)]
    fn beyond(&self, predicted: &[f64], series: &[Vec<f64>], row: usize) -> f64 {
        let measured = series[self.channel][(row + self.late).min(series[self.channel].len() - 1)];
        (measured - self.bias) / self.gain - predicted[self.channel]
    }
}

/// The corrections of one chain of bodies.
#[derive(Clone, Debug)]
pub(super) struct Anchor {
    coordinates: Vec<usize>,
    /// The coordinates of the chain, with those of sliding surfaces.
    whole: Vec<usize>,
    /// The coordinate of the first measured body of the chain, and those that no sensor of position shows.
    pub(super) lead: usize,
    pub(super) hidden: Vec<usize>,
    /// Noise or step of the measured position, m.
    pub(super) finest_m: f64,
    positions: Vec<Tap>,
    accelerations: Vec<Tap>,
    bristles: Vec<Bristle>,
    omega: f64,
}

/// Nodes that move with `node` in rigid motion: connected rigidly or by stiffness, without passing through
/// ground or `stop`.
pub(crate) fn chain(assembly: &Assembly, node: usize, stop: usize) -> Vec<usize> {
    let holds = |link: &Link| link.rigid || link.stiffness > 0.0 || link.cubic > 0.0;
    assembly.reached(vec![node], &[GROUND_NODE, stop], holds)
}

/// Natural frequency of the observer without accelerometers, rad/s, from the motion of the first measured
/// position.
pub(super) fn pace_of(assembly: &Assembly, channels: &[Channel], record: &Record) -> f64 {
    let is_position = |c: &usize| {
        let nodes = assembly.node_read(channels[*c].source);
        nodes.is_some_and(|(_, _, quantity)| quantity == Quantity::Position) && !record.silent[*c]
    };
    let of = |c: usize| {
        let [motion, excursion] = pace(&record.series[c], record.spacing_s)?;
        let noise = channels[c].sigma().max(f64::MIN_POSITIVE);
        let as_noise_allows = (NOISE_SHARE * excursion / noise).sqrt();
        Some(as_noise_allows.max(ABOVE_MOTION) * motion)
    };
    (0..channels.len())
        .find(is_position)
        .and_then(of)
        .map_or(OMEGA_WITHOUT_ACCELEROMETERS, |omega| omega.clamp(SLOWEST, OMEGA_WITHOUT_ACCELEROMETERS))
}

/// Sets position and speed of the first measured chain from the first rows of its encoder. `omega` is the
/// natural frequency of the observer, rad/s.
///
/// `beside` says what other readings mean that show a deflected spring.
pub(super) fn place(
    assembly: &mut Assembly,
    channels: &[Channel],
    record: &Record,
    omega: f64,
    beside: Beside,
) -> Placed {
    for (channel, series) in channels.iter().zip(&record.series) {
        let Some((node, relative_to, Quantity::Position)) = assembly.node_read(channel.source) else {
            continue;
        };
        // An imposed motion is given; bodies attached to it start as the machine file states.
        if assembly.drives.iter().any(|drive| drive.imposed.is_some() && drive.on == node) {
            continue;
        }
        let step = channel.resolution.max(channel.noise);
        let (gain, bias) = channel.scale(assembly);
        let speed_of = |node: usize| assembly.nodes[node].velocity_m_per_s;
        let believed = gain * (speed_of(node) - speed_of(relative_to));
        let (value, rate) = first_row(channel, series, record.spacing_s, omega, believed);
        let shift =
            (value - bias) / gain + assembly.nodes[relative_to].position_m - assembly.nodes[node].position_m;
        for member in chain(assembly, node, relative_to) {
            assembly.nodes[member].position_m += shift;
            if let Some(speed) = rate {
                assembly.nodes[member].velocity_m_per_s =
                    assembly.nodes[relative_to].velocity_m_per_s + speed / gain;
            }
        }
        let is_bent = place_beside(assembly, channels, record, omega, (node, beside));
        return Placed { is_in_motion: rate.is_some() || is_in_motion(series, step), is_bent };
    }
    Placed { is_in_motion: false, is_bent: false }
}

/// The value at the first row of a channel, and its rate if that differs from the believed one. `omega` is
/// the natural frequency of the observer, rad/s.
fn first_row(
    channel: &Channel,
    series: &[f64],
    spacing_s: f64,
    omega: f64,
    believed: f64,
) -> (f64, Option<f64>) {
    let step = channel.resolution.max(channel.noise);
    match beginning(series, spacing_s, 1.0 / omega, step, believed) {
        Some([value, rate]) => (value, Some(rate)),
        None => (first_value(series, spacing_s, 1.0 / omega, channel.sigma()), None),
    }
}

/// Sets the other measured bodies of the chain of `first` to their own readings, or shifts the zeros of
/// these, where they show a deflected spring between them. Returns whether any do.
fn place_beside(
    assembly: &mut Assembly,
    channels: &[Channel],
    record: &Record,
    omega: f64,
    (first, beside): (usize, Beside),
) -> bool {
    let mut is_bent = false;
    for (channel, series) in channels.iter().zip(&record.series) {
        let Some((node, relative_to, Quantity::Position)) = assembly.node_read(channel.source) else {
            continue;
        };
        let as_one = assembly.reached(vec![node], &[GROUND_NODE, relative_to], |link| link.rigid);
        if as_one.contains(&first) || !chain(assembly, first, relative_to).contains(&node) {
            continue;
        }
        let (gain, bias) = channel.scale(assembly);
        let step = channel.resolution.max(channel.noise);
        let [speed, own] = [relative_to, node].map(|node| assembly.nodes[node].velocity_m_per_s);
        let (value, _) = first_row(channel, series, record.spacing_s, omega, gain * (own - speed));
        let read = (value - bias) / gain + assembly.nodes[relative_to].position_m;
        let bent = read - assembly.nodes[node].position_m;
        if bent.abs() <= BENT_STEPS * step / gain.abs() {
            continue;
        }
        is_bent = true;
        match (beside, channel.source) {
            (Beside::Shifted, Source::Sensor(sensor)) => assembly.sensors[sensor].bias += gain * bent,
            _ => as_one.into_iter().for_each(|member| assembly.nodes[member].position_m += bent),
        }
    }
    is_bent
}

impl Anchor {
    /// The corrections of the first chain with a measured position, from the channels that are not silent.
    /// `None` if there is no such chain. A sliding surface moves only if its bristle would exceed its level.
    /// Without accelerometers the natural frequency is `pace`, rad/s. If zeros are shifted, only the first
    /// sensor shows where its body is.
    pub(super) fn new(
        motion: &Motion,
        channels: &[Channel],
        silent: &[bool],
        surfaces: &[usize],
        (spacing_s, pace): (f64, f64),
        beside: Beside,
    ) -> Option<Self> {
        let assembly = motion.assembly();
        let of_kind = |wanted: Quantity| {
            channels.iter().enumerate().filter_map(move |(i, channel)| {
                let (node, relative_to, quantity) = assembly.node_read(channel.source)?;
                (quantity == wanted && !silent[i]).then_some((i, channel, node, relative_to))
            })
        };
        let (_, _, first, stop) = of_kind(Quantity::Position).next()?;
        let members = chain(assembly, first, stop);
        let coordinates_of = |counts: &dyn Fn(&usize) -> bool| {
            let mut all: Vec<usize> = members
                .iter()
                .filter(|node| counts(node))
                .filter_map(|&node| motion.coordinates().of(node))
                .collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        let coordinates = coordinates_of(&|node| !surfaces.contains(node));
        let whole = coordinates_of(&|_| true);
        let shown = of_kind(Quantity::Position).map(|(_, _, node, _)| node);
        let shown = shown.take(if beside == Beside::Shifted { 1 } else { usize::MAX });
        let hidden = without(&coordinates, shown.filter_map(|node| motion.coordinates().of(node)));
        let lead = motion.coordinates().of(first)?;
        let tap =
            |i: usize, channel: &Channel, weight: f64| Tap::of(assembly, channel, spacing_s, (i, weight));
        let mut positions = Vec::new();
        let mut variance = 0.0;
        for (i, channel, _, _) in of_kind(Quantity::Position)
            .filter(|(_, _, node, to)| members.contains(node) && !members.contains(to))
            .take(1)
        {
            positions.push(tap(i, channel, 1.0));
            let step = match channel.source {
                Source::Sensor(s) => {
                    assembly.sensors[s].resolutions.iter().copied().fold(channel.resolution, f64::max)
                }
                _ => channel.resolution,
            };
            variance += channel.noise.powi(2) + step * step / 12.0;
        }
        let mut accelerations: Vec<Tap> = Vec::new();
        let mut density = 0.0;
        let readable: Vec<_> = of_kind(Quantity::Acceleration)
            .filter(|(_, _, node, to)| members.contains(node) && *to == GROUND_NODE)
            .collect();
        let share = |node: usize| {
            let g = motion.coordinates().of(node)?;
            let together =
                readable.iter().filter(|(_, _, other, _)| motion.coordinates().of(*other) == Some(g)).count();
            Some(motion.coordinates().mass_kg(g) / together as f64)
        };
        let total: f64 = readable.iter().filter_map(|(_, _, node, _)| share(*node)).sum();
        for (i, channel, node, _) in &readable {
            let weight = share(*node).unwrap_or(0.0) / total;
            accelerations.push(tap(*i, channel, weight));
            density += (weight * channel.noise).powi(2);
        }
        let omega = if accelerations.is_empty() || variance <= 0.0 || density <= 0.0 {
            pace
        } else {
            (density / variance).powf(0.25).clamp(OMEGA_RANGE.0, OMEGA_RANGE.1).min(0.2 / spacing_s)
        };
        Some(Self {
            coordinates,
            whole,
            lead,
            hidden,
            finest_m: variance.sqrt(),
            positions,
            accelerations,
            bristles: Bristle::all(motion, surfaces),
            omega,
        })
    }

    /// Difference between the position's reading and its prediction, before the dead zone.
    pub(super) fn beyond(&self, predicted: &[f64], series: &[Vec<f64>], row: usize) -> Option<f64> {
        self.positions.first().map(|tap| tap.beyond(predicted, series, row))
    }

    /// Shifts the position and the speed of the whole chain.
    pub(super) fn shift(&self, machine: &Moving, xi: &mut [f64], by: [f64; 2]) {
        shift(machine, xi, &self.whole, by);
    }

    /// Natural frequency of the observer, rad/s.
    pub(super) fn omega(&self) -> f64 {
        self.omega
    }

    /// Corrects a state at row `row`, over the time until the next row.
    #[inline(always)]
    pub(super) fn correct(
        &self,
        machine: &Moving,
        state: &mut State,
        predicted: &[f64],
        series: &[Vec<f64>],
        row: usize,
        spacing_s: f64,
    ) {
        let innovation = |tap: &Tap| {
            let beyond = tap.beyond(predicted, series, row);
            tap.weight * (beyond - beyond.clamp(-tap.dead_zone, tap.dead_zone))
        };
        let position: f64 = self.positions.iter().map(innovation).sum();
        let acceleration: f64 = self.accelerations.iter().map(innovation).sum();
        let dx = std::f64::consts::SQRT_2 * self.omega * spacing_s * position;
        let dv = spacing_s * (acceleration + self.omega.powi(2) * position);
        shift(machine, &mut state.xi, &self.coordinates, [dx, dv]);
        if dx.abs() + dv.abs() > 0.0 {
            self.bristles.iter().for_each(|bristle| bristle.slide(machine, state));
        }
    }
}

/// The numbers that are not among others.
fn without(all: &[usize], others: impl Iterator<Item = usize>) -> Vec<usize> {
    let others: Vec<usize> = others.collect();
    all.iter().copied().filter(|number| !others.contains(number)).collect()
}

fn shift(machine: &Moving, xi: &mut [f64], coordinates: &[usize], [distance, speed]: [f64; 2]) {
    for &g in coordinates {
        xi[machine.motion.layout().q(g)] += distance;
        xi[machine.motion.layout().v(g)] += speed;
    }
}
