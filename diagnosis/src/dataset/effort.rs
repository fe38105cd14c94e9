//! Size of a command against the motion that it drives, in all experiments together. Friction, noise and slow
//! motion hide the acceleration in single rows. A balance of forces over whole swings shows it.

use feeler_plant::assembly::GROUND_NODE;
use feeler_plant::description::{Axis, Quantity};
use nalgebra::{DMatrix, DVector};

use super::compare::smoothed;
use super::consistency::{Body, NEAR, NEAR_FORCE, Odd, accused};
use super::fault::FaultKind;
use super::quantum::quantum;
use super::units::CURRENT;
use crate::filter::slope;
use crate::predict::pace;

/// Half of the smoothing triangle, in radians of the motion, and the number of averaged rows in it.
const SPAN_RAD: f64 = 0.35;
const SPAN_ROWS: usize = 8;
/// Blocks of a record whose errors count as independent.
const BLOCKS: usize = 4;
/// Smallest number of averaged rows.
const FEWEST: usize = 40;
/// Share of the root mean square command below which a drive is hardly at a limit.
const BELOW_LIMIT: f64 = 0.7;
/// Smallest correlation of command and acceleration, each without what the other terms explain.
const SEEN: f64 = 0.5;
/// Ratio of the mass that command and motion imply to the believed one, beyond which one of the two has
/// another unit. On 803 wild cases of seven seeds, rows with a small command imply between 0.35 and 3.7.
const BEYOND: f64 = 5.0;
/// Smallest sum of acceleration and spring force over mass, as a share of both sizes.
const LEAST_SUM: f64 = 0.5;
/// Standard deviations by which it must be beyond.
const SURE: f64 = 4.0;

impl Body<'_> {
    /// Reports a command and a position whose sizes do not belong together.
    pub(super) fn effort(&self, odd: &mut Vec<Odd>) {
        let is_turning = self.dataset.machine.axis == Axis::Rotational;
        for (c, channel) in self.dataset.channels.iter().enumerate() {
            let Some((node, to, Quantity::Position)) = self.assembly.node_read(channel.source) else {
                continue;
            };
            if self.groups[to] != self.groups[GROUND_NODE] {
                continue;
            }
            let (mut used, mut blocks, mut is_held) = (Vec::new(), Vec::new(), false);
            let records = self.dataset.records.iter().enumerate();
            for (r, record) in records.filter(|(_, record)| !record.silent[c]) {
                let found = self.free_drive_of(record, self.groups[node]);
                let Some(((command, column, mass), stiffness)) = found else { continue };
                let positions = self.without_gain(channel, record.series[c].clone());
                let accelerations: Vec<f64> = command.iter().map(|force| force / mass).collect();
                let held = stiffness / mass;
                is_held |= held > 0.0;
                let found = balanced([&accelerations, &positions], record.spacing_s, is_turning, held);
                used.extend(found.is_some().then_some((r, column)));
                blocks.extend(found.into_iter().flatten());
            }
            let (Some((_, command)), Some(factor)) = (used.first(), implied(&blocks)) else { continue };
            let is_named = |odd: &Odd| {
                matches!(odd.kind, FaultKind::Units { .. })
                    && [command, &channel.column].contains(&&odd.column)
            };
            if odd.iter().any(is_named) {
                return;
            }
            let moved = self.reading(&channel.column, Quantity::Position);
            let pushed = self.reading(command, Quantity::Command);
            let is_right = self.has_stated_steps(c);
            let named = |record: usize| {
                let named = if is_right {
                    accused(record, [pushed, moved], factor, NEAR_FORCE, true)
                } else {
                    accused(record, [moved, pushed], 1.0 / factor, NEAR_FORCE, false)
                };
                let other = channel.column.clone();
                let kind = FaultKind::Units { other, factor, what: CURRENT, experiments: 1 };
                // A spring may be softer or stiffer than believed, so only a factor of units counts.
                named.or((!is_held).then(|| Odd { record, column: command.clone(), kind }))
            };
            odd.extend(used.iter().filter_map(|(record, _)| named(*record)));
            return;
        }
    }

    /// Whether the readings of a channel have the steps that its sensor states, so that its unit is right.
    fn has_stated_steps(&self, c: usize) -> bool {
        let stated = self.dataset.channels[c].resolution;
        let step = self.dataset.records.iter().find_map(|record| quantum(&record.readings(c)));
        stated > 0.0 && step.is_some_and(|step| (step / stated).ln().abs() < NEAR.ln_1p())
    }
}

/// A stretch of motion: the terms of a balance in each row, and command over mass. The first term is the
/// acceleration, with the force of a spring to the ground over the mass.
struct Block(Vec<(Vec<f64>, f64)>);

/// The stretches of a record of commands over mass and positions; `None` if it is too short for its motion.
/// `held` is the stiffness against the ground over the mass, 1/s².
fn balanced(
    [command, positions]: [&[f64]; 2],
    spacing_s: f64,
    is_turning: bool,
    held: f64,
) -> Option<Vec<Block>> {
    let [motion, _] = pace(positions, spacing_s)?;
    let rows = ((SPAN_RAD / (motion * spacing_s) / SPAN_ROWS as f64) as usize).max(1);
    let span = ((SPAN_RAD / (motion * spacing_s) / rows as f64) as usize).max(1);
    let spacing_s = rows as f64 * spacing_s;
    let averaged = |series: &[f64]| -> Vec<f64> {
        series.chunks_exact(rows).map(|chunk| chunk.iter().sum::<f64>() / rows as f64).collect()
    };
    let (command, positions) = (averaged(command), averaged(positions));
    if positions.len() < 8 * span + FEWEST / BLOCKS {
        return None;
    }
    let rate =
        |series: &[f64]| slope(series).into_iter().map(|slope| slope / spacing_s).collect::<Vec<f64>>();
    let lightly = smoothed(&positions, span);
    let directions: Vec<f64> = rate(&lightly).iter().map(|speed| speed.signum()).collect();
    let direction = smoothed(&directions, span);
    let place = smoothed(&lightly, span);
    let command = smoothed(&smoothed(&command, span), span);
    let speed = rate(&place);
    let acceleration = rate(&speed);
    if cancels(&acceleration, &place, held) {
        return None;
    }
    let row = |k: usize| {
        let mut terms = vec![acceleration[k] + held * place[k], speed[k], direction[k], 1.0];
        if is_turning {
            terms.extend([place[k].sin(), place[k].cos()]);
        }
        (terms, command[k])
    };
    // Slopes at the ends are one-sided.
    let kept: Vec<_> = (2..place.len() - 2).step_by((span / 2).max(1)).map(row).collect();
    Some(kept.chunks(kept.len().div_ceil(BLOCKS).max(1)).map(|rows| Block(rows.to_vec())).collect())
}

/// Whether acceleration and spring nearly cancel, as near the resonance. Small errors of either then change
/// their sum by a large factor.
fn cancels(acceleration: &[f64], place: &[f64], held: f64) -> bool {
    let mean = place.iter().sum::<f64>() / place.len().max(1) as f64;
    let rms = |of: &dyn Fn(f64, f64) -> f64| {
        let rows = acceleration.iter().zip(place);
        rows.map(|(a, x)| of(*a, held * (x - mean)).powi(2)).sum::<f64>().sqrt()
    };
    held > 0.0 && rms(&|a, spring| a + spring) < LEAST_SUM * (rms(&|a, _| a) + rms(&|_, spring| spring))
}

/// The ratio of the implied mass to the believed one, if it is surely beyond what a machine may hide. A drive
/// at its limit seems to move more mass, so the rows with a small command must show it too.
fn implied(blocks: &[Block]) -> Option<f64> {
    let commands = || blocks.iter().flat_map(|block| &block.0).map(|(_, command)| command);
    let limit =
        BELOW_LIMIT * (commands().map(|u| u * u).sum::<f64>() / commands().count().max(1) as f64).sqrt();
    let below =
        |block: &Block| Block(block.0.iter().filter(|(_, command)| command.abs() < limit).cloned().collect());
    let low: Vec<Block> = blocks.iter().map(below).collect();
    let [all, low] = [ratio(blocks)?, ratio(&low)?];
    let is_large = |[ratio, sd]: [f64; 2]| ratio - SURE * sd > BEYOND;
    let is_small = |[ratio, sd]: [f64; 2]| ratio > 0.0 && ratio + SURE * sd < 1.0 / BEYOND;
    (is_large(all) && is_large(low) || is_small(all) && is_small(low)).then_some(all[0])
}

/// The ratio of the implied mass to the believed one, and its standard deviation from the errors of whole
/// blocks. `None` if command and acceleration hardly correlate.
fn ratio(blocks: &[Block]) -> Option<[f64; 2]> {
    let rows = || blocks.iter().flat_map(|block| &block.0);
    let n = rows().next()?.0.len();
    if rows().count() < FEWEST {
        return None;
    }
    // Columns of one size keep the matrix regular.
    let size =
        |i: usize| rows().map(|(terms, _)| terms[i].powi(2)).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    let sizes: Vec<f64> = (0..n).map(size).collect();
    let scaled =
        |terms: &[f64]| DVector::from_iterator(n, terms.iter().zip(&sizes).map(|(x, size)| x / size));
    let (mut a, mut b) = (DMatrix::zeros(n, n), DVector::zeros(n));
    for (terms, command) in rows() {
        let terms = scaled(terms);
        a += &terms * terms.transpose();
        b += *command * terms;
    }
    let inverse = a.try_inverse()?;
    let found = &inverse * b;
    let error = |terms: &DVector<f64>, command: f64| command - found.dot(terms);
    let (mut left, mut variance) = (0.0, 0.0);
    for block in blocks {
        let mut pull = 0.0;
        for (terms, command) in &block.0 {
            let terms = scaled(terms);
            let error = error(&terms, *command);
            left += error * error;
            pull += inverse.column(0).dot(&terms) * error;
        }
        variance += pull * pull;
    }
    // The acceleration's share in the balance.
    let own = found[0].powi(2) / inverse[(0, 0)];
    let is_seen = own > SEEN * SEEN * (own + left);
    is_seen.then(|| [found[0] / sizes[0], variance.sqrt() / sizes[0]])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The balance of two records of a mass of one, held by a spring of stiffness `held`, with the command
    /// that `ask` makes of the needed force.
    fn blocks(held: f64, ask: impl Fn(f64) -> f64) -> Vec<Block> {
        let waves = [(3.0_f64, 0.3), (7.0, 0.1), (17.0, 0.04), (31.0, 0.01)];
        let record = |start_s: f64| {
            let times = (0..3000).map(|k| start_s + 1e-3 * f64::from(k));
            let of = |t: f64| {
                waves.iter().fold([0.0; 2], |[place, force], (omega, size)| {
                    let (sin, cos) = (omega * t + omega).sin_cos();
                    let force = force + size * (held - omega * omega) * sin + 4.0 * size * omega * cos;
                    [place + size * sin, force]
                })
            };
            let (places, commands): (Vec<f64>, Vec<f64>) =
                times.map(of).map(|[place, force]| ((500.0 * place).round() / 500.0, ask(force))).unzip();
            balanced([&commands, &places], 1e-3, false, held).unwrap()
        };
        [0.0, 40.0].into_iter().flat_map(record).collect()
    }

    /// Share by which encoder steps and the smoothing of the fastest wave shift the ratio.
    const OFF: f64 = 0.1;

    #[test]
    fn truth_a_factor_is_read_off_and_a_limit_is_not_a_factor() {
        // Free, and held by a spring that is stiff against most of the motion.
        for held in [0.0, 400.0] {
            for factor in [0.02, 0.1, 10.0, 57.3, 1e3] {
                let found = implied(&blocks(held, |force| factor * force)).unwrap();
                assert!((found / factor - 1.0).abs() < OFF, "{held}: {found} {factor}");
            }
            for factor in [0.3, 1.0, 3.5] {
                assert_eq!(implied(&blocks(held, |force| factor * force)), None, "{held}: {factor}");
            }
        }
        // Far more is asked of a drive at its limit than it gives. By itself this looks like a larger mass.
        let limited = blocks(0.0, |force| force + 24.0 * (force - force.clamp(-12.0, 12.0)));
        let [all, deviation] = ratio(&limited).unwrap();
        assert!(all - SURE * deviation > BEYOND, "{all} {deviation}");
        assert_eq!(implied(&limited), None);
    }

    #[test]
    fn truth_a_motion_that_does_not_follow_the_command_says_nothing() {
        let mut noise = crate::chance::Chance::seeded(3);
        let rows = (0..3000).map(|_| noise.deviate()).collect::<Vec<f64>>();
        let places: Vec<f64> = (0..3000).map(|k| (0.003 * f64::from(k)).sin()).collect();
        assert_eq!(implied(&balanced([&rows, &places], 1e-3, true, 0.0).unwrap()), None);
    }
}
