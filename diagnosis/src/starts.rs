//! Where the fit of an effect starts. An effect's cost is often far from quadratic in its parameters, so each
//! is started from several places, spread over what the record can show: its sampling, its forces, its
//! strokes.

use std::f64::consts::TAU;

use feeler_plant::assembly::{GROUND_NODE, assemble};
use feeler_plant::description::{Machine, Table};

use crate::fit::candidates::Candidate;

/// Waves per stroke tried for a ripple: from half a wave on in quarters, so that the phase over the stroke
/// moves by less than half a turn from one to the next.
const WAVES_STEP: f64 = 0.25;
/// Steps tried.
const PITCHES: usize = 400;
/// Pitches handed on to the fit.
const BEST_PITCHES: usize = 4;
/// Points of the missing force that are looked at per record.
const POINTS: usize = 1500;

/// Range in which the mode of a joint is looked for, and that of a base, Hz.
const JOINT_HZ: (f64, f64) = (10.0, 400.0);
const BASE_HZ: (f64, f64) = (4.0, 45.0);
/// Damping ratio at which modes are started, and the ratio of one frequency to the next: a fit finds a
/// resonance only from within its width, and the next start must be there.
const NARROW: f64 = 0.05;
const STEP: f64 = 1.08;

/// Levels of a force that a fit starts from, of the largest command: in slow drives friction takes most of
/// it.
const LEVELS: [f64; 5] = [0.01, 0.04, 0.15, 0.4, 0.8];

/// What the records show at a glance.
#[derive(Clone, Debug, Default)]
pub(crate) struct Glance {
    /// Largest command, N.
    pub(crate) command: f64,
    /// Largest change of a command between rows, N.
    pub(crate) command_change: f64,
    /// Row spacing, s.
    pub(crate) spacing_s: f64,
    /// Largest contact force measured, N.
    pub(crate) force: f64,
    /// Fastest motion, m/s.
    pub(crate) speed: f64,
    /// Steps found in the values of channels, by sensor.
    pub(crate) quanta: Vec<(usize, f64)>,
    /// Missing force against position, `(x, F)`.
    pub(crate) missing: Vec<(f64, f64)>,
    /// How much farther away surfaces seem to be, by contact: from where the bodies stand when a force is
    /// measured.
    pub(crate) surfaces: Vec<(usize, f64)>,
}

fn scaled(value: f64, factors: &[f64]) -> Vec<f64> {
    factors.iter().map(|f| f * value).collect()
}

/// Every combination.
fn grid(axes: &[Vec<f64>]) -> Vec<Vec<f64>> {
    axes.iter().fold(vec![Vec::new()], |points, axis| {
        points
            .iter()
            .flat_map(|point| axis.iter().map(move |&value| point.iter().copied().chain([value]).collect()))
            .collect()
    })
}

/// Spring of a mode: stiffness at these frequencies for a mass, and damping at a ratio.
fn modes(mass: f64, fixed: &[f64], frequencies_hz: &[f64], ratio: f64) -> Vec<Vec<f64>> {
    frequencies_hz
        .iter()
        .map(|f| {
            let omega = TAU * f;
            let mut values = fixed.to_vec();
            values.extend([mass * omega * omega, 2.0 * ratio * mass * omega]);
            values
        })
        .collect()
}

/// Frequencies across a range.
fn every((low, high): (f64, f64)) -> Vec<f64> {
    std::iter::successors(Some(low), |f| Some(STEP * f)).take_while(|f| *f <= high).collect()
}

/// Starting values of a candidate, in the order of its definition.
pub(crate) fn starts(candidate: Candidate, machine: &Machine, glance: &Glance) -> Vec<Vec<f64>> {
    let definition = candidate.definition;
    let i = candidate.site.index;
    let levels = |largest: f64| scaled(largest, &LEVELS);
    let wide = |value: f64| scaled(value, &[0.4, 0.7, 1.4, 2.5]);
    let times = || grid(&[scaled(glance.spacing_s, &[0.6, 2.0, 6.0])]);
    let assembly = assemble(machine).ok();
    let mass_of = |node: usize| assembly.as_ref().map_or(1.0, |a| a.nodes[node].mass_kg);
    match definition.kind {
        // Readings between two rows cannot see where between them a held command arrives, and jump where the
        // arrival passes a row: every row is a valley of its own.
        "command-delay" => {
            grid(&[scaled(glance.spacing_s, &[0.3, 0.5, 0.8, 1.2, 1.5, 1.8, 2.5, 3.5, 4.5, 5.5, 7.5, 10.5])])
        }
        "actuator-lag" | "force-lag" | "force-delay" => times(),
        "drive-gain" | "force-gain" => vec![vec![0.6], vec![0.8], vec![1.25], vec![1.6]],
        "drive-deadband" | "coulomb-friction" => grid(&[levels(glance.command)]),
        "constant-load" => [-1.0, 1.0]
            .iter()
            .flat_map(|s| scaled(s * glance.command, &[0.01, 0.1, 0.5]))
            .map(|v| vec![v])
            .collect(),
        "force-limit" => grid(&[scaled(glance.command, &[0.9, 0.7, 0.5, 0.3, 0.15])]),
        "slew-limit" => grid(&[scaled(glance.command_change / glance.spacing_s, &[0.5, 0.2, 0.08, 0.03])]),
        "force-ripple" => ripples(&glance.missing),
        "stribeck-friction" => levels(glance.command)
            .iter()
            .flat_map(|&c| {
                scaled(glance.speed, &[0.01, 0.05, 0.2]).into_iter().map(move |v| vec![c, 1.8 * c, v])
            })
            .collect(),
        "viscous-friction" => {
            let own = machine.springs[i].damping_n_s_per_m.max(0.1 * glance.command / glance.speed.max(1e-9));
            grid(&[scaled(own, &[0.5, 2.0, 6.0])])
        }
        "load-friction" => vec![vec![0.02], vec![0.08], vec![0.25]],
        "asymmetric-friction" => grid(&[levels(glance.command), vec![-0.3, 0.3]]),
        "added-mass" => grid(&[scaled(machine.bodies[i].mass_kg, &[0.15, 0.5, 1.5])]),
        "transmission-flexibility" => {
            let Some(assembly) = &assembly else { return Vec::new() };
            // A body that is split hides how: a third or two thirds may hang on the spring.
            let split: Vec<[f64; 2]> = match candidate.site.table {
                Table::Springs => vec![[mass_of(assembly.links[i].a), mass_of(assembly.links[i].b)]],
                _ => [1.0 / 3.0, 2.0 / 3.0]
                    .iter()
                    .map(|share| [(1.0 - share) * mass_of(i + 1), share * mass_of(i + 1)])
                    .collect(),
            };
            let frequencies = every(JOINT_HZ);
            let of = |[a, b]: [f64; 2]| {
                modes(a * b / (a + b), &[], &frequencies, NARROW)
                    .into_iter()
                    .map(move |m| vec![m[0], m[1], b])
            };
            split.into_iter().flat_map(of).collect()
        }
        "backlash" => {
            let Some(assembly) = &assembly else { return Vec::new() };
            let link = &assembly.links[i];
            let (a, b) = (mass_of(link.a), mass_of(link.b));
            let widths = scaled(definition.parameters[0].typical, &[1.0, 4.0, 15.0]);
            let flanks = modes(a * b / (a + b), &[], &[100.0, 250.0, 600.0], 0.05);
            widths
                .iter()
                .flat_map(|&width| flanks.iter().map(move |flank| vec![width, flank[0], flank[1]]))
                .collect()
        }
        "hardening-stiffness" => {
            let (k, force) = match candidate.site.table {
                Table::Contacts => (machine.contacts[i].stiffness, glance.force),
                _ => (machine.springs[i].stiffness_n_per_m, glance.command),
            };
            grid(&[scaled(k.powi(3) / force.max(1e-9).powi(2), &[0.05, 0.5, 5.0])])
        }
        "base-flexibility" => {
            let mass = match assembly.as_ref().map(|a| &a.links[i]) {
                Some(link) if link.rigid => mass_of(if link.a == GROUND_NODE { link.b } else { link.a }),
                _ => definition.parameters[0].typical,
            };
            modes(mass, &[mass], &every(BASE_HZ), NARROW)
        }
        "workpiece-dynamics" => {
            // How much softer the contact looks is known well, so that a wrong stiffness hides a right
            // frequency: both are spread, and the mass follows.
            let softest =
                machine.contacts.values().map(|contact| contact.stiffness).fold(f64::INFINITY, f64::min);
            let stiffness = if softest.is_finite() { softest } else { definition.parameters[1].typical };
            grid(&[scaled(stiffness, &[3.0, 7.0, 16.0]), vec![40.0, 70.0, 110.0, 170.0, 260.0]])
                .into_iter()
                .map(|point| {
                    let (k, omega) = (point[0], TAU * point[1]);
                    vec![k / (omega * omega), k, 2.0 * 0.06 * k / omega]
                })
                .collect()
        }
        "contact-stiffness" => grid(&[wide(machine.contacts[i].stiffness)]),
        "contact-damping" => {
            grid(&[scaled(machine.contacts[i].damping_n_s_per_m.max(1.0), &[0.2, 4.0, 12.0])])
        }
        "hertz-contact" => {
            // The same force at the depth of part of the largest one.
            let (k, force) = (machine.contacts[i].stiffness, glance.force.max(1e-9));
            [1.5]
                .iter()
                .flat_map(|&n| [0.15, 0.4, 1.0].map(|share| (n, share)))
                .map(|(n, share)| vec![n, k * (share * force / k).powf(1.0 - n)])
                .collect()
        }
        // A surface believed beyond where the tool gets makes no force that could lead to it: where it stands
        // is read off.
        "surface-offset" => {
            let read = glance.surfaces.iter().filter(|(contact, _)| *contact == i).map(|(_, offset)| *offset);
            scaled(definition.parameters[0].typical, &[-2.0, -0.6, -0.2, 0.2, 0.6, 2.0])
                .into_iter()
                .chain(read)
                .map(|v| vec![v])
                .collect()
        }
        "force-bias" => [-1.0, 1.0].iter().map(|s| vec![s * 0.03 * glance.force.max(1e-9)]).collect(),
        "force-resolution" | "encoder-resolution" => {
            glance.quanta.iter().filter(|(sensor, _)| *sensor == i).map(|(_, step)| vec![*step]).collect()
        }
        "tool-inertia" => vec![vec![0.1], vec![0.5], vec![2.0]],
        _ => grid(
            &definition
                .parameters
                .iter()
                .map(|p| p.default.map_or_else(|| scaled(p.typical, &[0.3, 1.0, 3.0]), |d| vec![d]))
                .collect::<Vec<_>>(),
        ),
    }
}

/// Amplitude, pitch and phase of the sines in position that take most out of the missing force.
pub(crate) fn ripples(missing: &[(f64, f64)]) -> Vec<Vec<f64>> {
    let (low, high) =
        missing.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (x, _)| (l.min(*x), h.max(*x)));
    let stroke = high - low;
    if missing.len() < 50 || stroke <= 0.0 {
        return Vec::new();
    }
    let thin = (missing.len() / (8 * POINTS)).max(1);
    let points: Vec<(f64, f64)> = missing.iter().step_by(thin).copied().collect();
    let mean = points.iter().map(|(_, f)| f).sum::<f64>() / points.len() as f64;
    let mut found: Vec<(f64, Vec<f64>)> = (0..PITCHES)
        .map(|k| {
            let pitch = stroke / (WAVES_STEP * (k + 2) as f64);
            let (mut ss, mut cc, mut sc, mut sf, mut cf) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for (x, f) in &points {
                let (s, c) = (TAU * x / pitch).sin_cos();
                let f = f - mean;
                ss += s * s;
                cc += c * c;
                sc += s * c;
                sf += s * f;
                cf += c * f;
            }
            let det = ss * cc - sc * sc;
            let (a, b) = ((cc * sf - sc * cf) / det, (ss * cf - sc * sf) / det);
            let gain = a * sf + b * cf;
            (gain, vec![a.hypot(b), pitch, b.atan2(a)])
        })
        .filter(|(gain, _)| gain.is_finite())
        .collect();
    found.sort_by(|x, y| y.0.total_cmp(&x.0));
    let mut best: Vec<Vec<f64>> = Vec::new();
    for (_, values) in found {
        if best.len() < BEST_PITCHES
            && best.iter().all(|other| (stroke / other[1] - stroke / values[1]).abs() > 1.0)
        {
            best.push(values);
        }
    }
    best
}
