//! Modes of vibration and their classes for an actuator and a sensor: the paper's two kinds of flexibility.

use std::f64::consts::TAU;

use feeler_lti::{C64, eigen};
use feeler_plant::assembly::Source;
use feeler_plant::description::Quantity;
use feeler_plant::motion::Row;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use crate::error::AnalysisError;
use crate::machine::channel::ResponseChannel;
use crate::machine::linearise::LinearMachine;

/// Displacements below this share of the largest one count as zero.
const NEGLIGIBLE: f64 = 1e-3;
/// Modes whose bodies move less than this share of the state vector belong to filters. In modes of drives and
/// plant, bodies move by 1e-7 or more.
const NO_MOTION: f64 = 1e-11;
/// Zeros are mirror images if they lie within this share of their size: damping moves both to the left.
const MIRRORED: f64 = 0.3;
/// Stiffness to ground, relative to the machine's largest, that holds free bodies during a quasi-static push.
const SLIGHT: f64 = 1e-12;

/// Damping ratios below this are rounding.
const UNDAMPED: f64 = 1e-9;

/// A mode of vibration of the machine.
#[derive(Clone, Debug, PartialEq)]
pub struct VibrationMode {
    /// Eigenvalue with positive imaginary part, rad/s.
    pub eigenvalue: C64,
    /// Eigenvector over all states of the machine.
    pub vector: DVector<C64>,
    /// Displacement of every body, the largest of them 1.
    pub shape: Vec<BodyMotion>,
}

/// How far a body moves in a mode.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodyMotion {
    /// Name of the body.
    pub body: String,
    /// Part in phase with the body that moves most.
    pub in_phase: f64,
    /// Part that is a quarter period ahead of that body.
    pub quadrature: f64,
}

impl VibrationMode {
    /// |s| / 2 pi, Hz.
    pub fn frequency_hz(&self) -> f64 {
        self.eigenvalue.norm() / TAU
    }

    /// -Re s / |s|.
    pub fn damping_ratio(&self) -> f64 {
        -self.eigenvalue.re / self.eigenvalue.norm()
    }
}

/// The oscillating modes of a machine in which bodies move, by rising frequency.
///
/// # Errors
/// [`AnalysisError::Lti`].
pub fn modes(plant: &LinearMachine) -> Result<Vec<VibrationMode>, AnalysisError> {
    let motion = plant.motion();
    let found = eigen(plant.a())?;
    let mut modes = Vec::new();
    for (value, vector) in found.values.iter().zip(&found.vectors) {
        if value.im <= 1e-9 * value.norm() {
            continue;
        }
        let nodes = motion.assembly().nodes.iter().enumerate().skip(1);
        let moves: Vec<(String, C64)> = nodes
            .map(|(i, node)| {
                let moved =
                    motion.coordinates().of(i).map_or(C64::new(0.0, 0.0), |g| vector[motion.layout().q(g)]);
                (node.name.clone(), moved)
            })
            .collect();
        let Some(largest) = moves.iter().map(|(_, x)| *x).max_by(|a, b| a.norm().total_cmp(&b.norm())) else {
            continue;
        };
        if largest.norm() <= NO_MOTION {
            continue;
        }
        let shape = moves.into_iter().map(|(body, x)| {
            let x = x / largest;
            BodyMotion { body, in_phase: x.re, quadrature: x.im }
        });
        modes.push(VibrationMode { eigenvalue: *value, vector: vector.clone(), shape: shape.collect() });
    }
    modes.sort_by(|a, b| a.eigenvalue.norm().total_cmp(&b.eigenvalue.norm()));
    Ok(modes)
}

/// The class of a mode for an actuator and a sensor (Eppinger and Seering, sections V and VI).
///
/// The class is relative to rigid-body motion, the phase is relative to the modes below. Between neighbouring
/// modes of one class there is a pair of zeros; between modes of different classes there is none. The first
/// noncolocated mode therefore lowers the phase by 180 degrees permanently. A second noncolocated mode above
/// it has zeros beside it and lowers the phase only by what they added. An example is the workpiece's mode
/// above that of the transmission, in the paper's machine with all three.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ModeClass {
    /// Actuator and sensor move in the phase relation of rigid-body motion.
    Colocated,
    /// Actuator and sensor move opposite to that relation.
    Noncolocated,
    /// Actuator or sensor does not take part.
    Uninvolved,
}

/// A mode as an actuator and a sensor observe it.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeInPair {
    pub class: ModeClass,
    /// Whether the mode is the rigid-body motion: it contributes most of the displacement under a slow push
    /// of the actuator.
    pub rigid_body: bool,
    /// The pair of zeros that belongs to the mode, the one with positive imaginary part; `None` for a mode
    /// that only costs phase.
    pub zero: Option<C64>,
    /// Phase change that remains beyond the mode. It is -180 for poles alone, 0 with a pair of zeros on the
    /// left, -360 with a pair on the right.
    pub phase_change_deg: f64,
    /// The largest phase lag near the mode.
    pub dip_deg: f64,
}

impl ModeInPair {
    /// The mode's factor on the loop at `s`: 1 at zero frequency.
    pub fn factor(&self, mode: &VibrationMode, s: C64) -> C64 {
        let pair = |root: C64| (s - root) * (s - root.conj()) / root.norm_sqr();
        self.zero.map_or(C64::new(1.0, 0.0), pair) / pair(mode.eigenvalue)
    }
}

/// The displacement that a signal measures, as a row over the states.
fn displacement_row(plant: &LinearMachine, source: Source) -> Option<Row> {
    let (motion, equations) = (plant.motion(), plant.equations());
    match source {
        Source::Sensor(i) => {
            let sensor = &motion.assembly().sensors[i];
            let own = displacement_row(plant, sensor.source)?;
            let Source::Node(..) = sensor.source else { return Some(own) };
            let base = motion.signal(equations, Source::Node(sensor.relative_to, Quantity::Position))?;
            Some(own.iter().zip(&base).map(|(a, b)| a - b).collect())
        }
        Source::Node(node, _) => motion.signal(equations, Source::Node(node, Quantity::Position)),
        Source::Contact(i, _) => Some(equations.compression[i][0].clone()),
        Source::Link(i, _) => Some(equations.elongation[i][0].clone()),
        Source::Drive(i, _) => Some(equations.stroke[i][0].clone()),
    }
}

/// Classifies every mode for a drive and a signal.
///
/// The rigid-body relation is that of a slow push of the drive, with unheld bodies free to move. Its sign is
/// that of the displacement of the driven body against the reacting one, times the displacement that the
/// sensor measures.
///
/// # Errors
/// [`AnalysisError::NotLinear`] for a signal that measures no displacement; [`AnalysisError::Lti`].
pub fn classify(
    plant: &LinearMachine,
    modes: &[VibrationMode],
    drive: usize,
    output: Source,
    channel: &ResponseChannel,
) -> Result<Vec<ModeInPair>, AnalysisError> {
    let layout = plant.motion().layout();
    let nc = layout.coordinates();
    let stroke = &plant.equations().stroke[drive][0];
    let sensed = displacement_row(plant, output)
        .ok_or_else(|| AnalysisError::NotLinear { name: format!("{output:?}") })?;
    let along = |row: &Row, mode: &VibrationMode| {
        (0..nc).map(|g| mode.vector[layout.q(g)] * row[layout.q(g)]).sum::<C64>()
    };

    let mass = |g: usize| plant.motion().coordinates().mass_kg(g);
    let mut stiffness = DMatrix::from_fn(nc, nc, |g, h| -mass(g) * plant.a()[(layout.v(g), layout.q(h))]);
    let slight =
        SLIGHT * (0..nc).map(|g| stiffness[(g, g)].abs() / mass(g)).fold(f64::MIN_POSITIVE, f64::max);
    for g in 0..nc {
        stiffness[(g, g)] += slight * mass(g);
    }
    let push = DVector::from_fn(nc, |g, _| stroke[layout.q(g)]);
    let slow = stiffness.lu().solve(&push).unwrap_or_else(|| push.clone());
    let slow_way = |row: &Row| (0..nc).map(|g| row[layout.q(g)] * slow[g]).sum::<f64>();
    let rigid_sign = (slow_way(stroke) * slow_way(&sensed)).signum();

    let share = |mode: &VibrationMode| {
        let energy: f64 = (0..nc).map(|g| mass(g) * mode.vector[layout.q(g)].norm_sqr()).sum();
        (along(stroke, mode).conj() * along(&sensed, mode)).re.abs() / (energy * mode.eigenvalue.norm_sqr())
    };
    // If the push moves the whole machine away, no mode is the rigid-body motion.
    let given: f64 = modes.iter().map(share).sum();
    let carried_away = (slow_way(stroke) * slow_way(&sensed)).abs().sqrt() > 1e3 * given.sqrt();
    let rigid = (0..modes.len())
        .filter(|_| !carried_away)
        .max_by(|&i, &j| share(&modes[i]).total_cmp(&share(&modes[j])));

    let class = |mode: &VibrationMode| {
        let largest = (0..nc).map(|g| mode.vector[layout.q(g)].norm()).fold(0.0, f64::max);
        let (a, s) = (along(stroke, mode), along(&sensed, mode));
        if a.norm().min(s.norm()) < NEGLIGIBLE * largest {
            ModeClass::Uninvolved
        } else if (a.conj() * s).re * rigid_sign > 0.0 {
            ModeClass::Colocated
        } else {
            ModeClass::Noncolocated
        }
    };
    let classes: Vec<ModeClass> = modes.iter().map(class).collect();
    let zeros = pair_zeros(modes, &classes, rigid, &channel.zeros()?);
    let reaches = channel.system.c().amax() > 0.0 || channel.system.d().amax() > 0.0;
    let described = modes.iter().zip(&classes).zip(zeros).enumerate().map(|(i, ((mode, &class), zero))| {
        let mut pair =
            ModeInPair { class, rigid_body: rigid == Some(i), zero, phase_change_deg: 0.0, dip_deg: 0.0 };
        if reaches && (class != ModeClass::Uninvolved || zero.is_some()) {
            pair.phase_change_deg = match zero {
                None => -180.0,
                Some(zero) if zero.re > 0.0 => -360.0,
                Some(_) => 0.0,
            };
            pair.dip_deg = dip_deg(&pair, mode);
        }
        pair
    });
    Ok(described.collect())
}

/// Assigns each pair of zeros to a mode: the nearest first, colocated modes before noncolocated ones, the
/// rigid-body motion last.
fn pair_zeros(
    modes: &[VibrationMode],
    classes: &[ModeClass],
    rigid: Option<usize>,
    zeros: &[C64],
) -> Vec<Option<C64>> {
    let mut given = vec![None; modes.len()];
    let mut left = without_quadruples(zeros);
    let rank = |i: usize| match classes[i] {
        _ if rigid == Some(i) => 2,
        ModeClass::Noncolocated => 1,
        ModeClass::Colocated | ModeClass::Uninvolved => 0,
    };
    for stage in 0..3 {
        loop {
            let distance = |z: &C64, i: usize| (z.norm() / modes[i].eigenvalue.norm()).ln().abs();
            let open = (0..modes.len()).filter(|&i| rank(i) == stage && given[i].is_none());
            let candidates = open.flat_map(|i| (0..left.len()).map(move |j| (i, j)));
            let Some((i, j)) =
                candidates.min_by(|a, b| distance(&left[a.1], a.0).total_cmp(&distance(&left[b.1], b.0)))
            else {
                break;
            };
            given[i] = Some(left.swap_remove(j));
        }
    }
    given
}

/// Pairs of zeros that are not half of a quadruple, each by its zero above the axis. A zero on the right
/// lowers the phase as much as its mirror image on the left raises it, so a quadruple belongs to no mode.
fn without_quadruples(zeros: &[C64]) -> Vec<C64> {
    let pairs = zeros.iter().copied().filter(|z| z.im > 1e-9 * z.norm());
    let (right, mut left): (Vec<C64>, Vec<C64>) = pairs.partition(|z| z.re > 0.0);
    let alone = right.into_iter().filter(|z| {
        let image = |other: &C64| (other + z.conj()).norm();
        let nearest = (0..left.len()).min_by(|&i, &j| image(&left[i]).total_cmp(&image(&left[j])));
        let Some(found) = nearest.filter(|&i| image(&left[i]) < MIRRORED * z.norm()) else { return true };
        left.swap_remove(found);
        false
    });
    let alone: Vec<C64> = alone.collect();
    alone.into_iter().chain(left).collect()
}

/// Largest lag of a mode's factor: the smallest phase, continued from zero frequency.
fn dip_deg(pair: &ModeInPair, mode: &VibrationMode) -> f64 {
    let ends = [mode.eigenvalue, pair.zero.unwrap_or(mode.eigenvalue)];
    let low = ends.iter().map(|r| r.norm()).fold(f64::INFINITY, f64::min);
    let high = ends.iter().map(|r| r.norm()).fold(0.0, f64::max);
    // Steps of a tenth of the smallest damping, from a third of the lower root to three times the higher.
    let width = ends.iter().map(|r| (r.re / r.norm()).abs()).fold(f64::INFINITY, f64::min).clamp(1e-5, 0.1);
    let count = ((9.0 * high / low).ln() / (0.1 * width)).ceil().min(2e5) as usize;
    let response = (0..=count).map(|i| {
        let w = low / 3.0 * (9.0 * high / low).powf(i as f64 / count as f64);
        pair.factor(mode, C64::new(0.0, w))
    });
    let phase = feeler_lti::unwrapped_phase_rad(&response.collect::<Vec<_>>());
    phase.into_iter().fold(0.0, f64::min).to_degrees()
}

/// Frequencies of undamped modes that a pair of actuator and sensor observes, Hz.
pub(crate) fn undamped_hz(modes: &[VibrationMode], pairs: &[ModeInPair]) -> Vec<f64> {
    let seen = modes.iter().zip(pairs).filter(|(_, pair)| pair.class != ModeClass::Uninvolved);
    seen.filter(|(mode, _)| mode.damping_ratio().abs() < UNDAMPED)
        .map(|(mode, _)| mode.frequency_hz())
        .collect()
}
