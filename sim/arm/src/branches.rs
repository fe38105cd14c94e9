//! Bodies beside the motor, where one spring does not do.

use std::cmp::Ordering;

use nalgebra::DMatrix;

use crate::agreement::{Agreement, WholeArm, apart};
use crate::between::{between, linked, without_fast};
use crate::branch::Branch;
use crate::error::ArmError;
use crate::fit::Wanted;
use crate::flexible::{Arm, LinearArm, Others};
use crate::linear_system::{BENDS_NOTHING, eigen};
use crate::reduce::Reduction;

/// Most bodies of an axis that is fitted: with more, nothing is gained.
const MOST_FITTED: usize = 4;
/// Weights of landmarks that a fit has missed, one after the other.
const FACTORS: [f64; 3] = [10.0, 100.0, 1e3];
/// Frequency of a body, over the phase crossover, from which on it does nothing there.
const FAST: f64 = 12.0;
/// How far leaving bodies out may move the crossover.
const MOVED: f64 = 5e-3;
/// Part of the arm's mass below which a mode takes no part.
const NO_PART: f64 = 1e-9;

/// A branch, and its part of the tool's way; these parts add up to one.
struct Part {
    branch: Branch,
    way: f64,
}

/// What hangs on the drive: one branch per mode of the arm with the drive's way held. To the drive they are
/// the arm, but for damping that couples them.
fn parts(linear: &LinearArm) -> Vec<Part> {
    let system = &linear.system;
    let n = system.drive.len();
    // Householder's reflection of the drive's direction onto the first axis: its other columns span the
    // motions that leave the drive where it is.
    let mut v = system.drive.normalize();
    v[0] += v[0].signum();
    let reflection = DMatrix::identity(n, n) - &v * v.transpose() * (2.0 / v.norm_squared());
    let still = reflection.columns(1, n - 1).into_owned();
    let within = |matrix: &DMatrix<f64>| still.tr_mul(matrix) * &still;
    let Some((squares, shapes)) = eigen(&within(&system.mass), &within(&system.stiffness)) else {
        return Vec::new();
    };
    let shapes = &still * shapes;
    let carried = &system.mass * &linear.unbent;
    let largest = squares.amax();
    (squares.iter().zip(shapes.column_iter()))
        .filter_map(|(square, shape)| {
            let share = shape.dot(&carried);
            let mass_kg = share * share;
            let branch =
                Branch::beside(mass_kg, square * mass_kg, (&system.damping * shape).dot(&shape) * mass_kg);
            let takes_part = *square > BENDS_NOTHING * largest && mass_kg > NO_PART * system.mass_kg;
            takes_part.then(|| Part { branch, way: share * system.tip.dot(&shape) })
        })
        .collect()
}

/// The body that is the tool, the one whose part of the tool's way is largest, and the others, first those
/// that trail most.
fn tool_and_others(linear: &LinearArm) -> Option<(Branch, Vec<Branch>)> {
    let mut parts = parts(linear);
    parts.sort_by(|a, b| b.way.total_cmp(&a.way));
    let mut bodies = parts.into_iter().map(|part| part.branch);
    let tool = bodies.next()?;
    let mut others: Vec<Branch> = bodies.collect();
    others.sort_by(|a, b| b.lag().partial_cmp(&a.lag()).unwrap_or(Ordering::Equal));
    Some((tool, others))
}

/// An axis of motor, tool and branches; what is no branch moves with the motor.
fn branched(pair: &Reduction, tool: Branch, branches: &[Branch]) -> Reduction {
    let on_springs = tool.mass_kg + branches.iter().map(|branch| branch.mass_kg).sum::<f64>();
    Reduction {
        motor_mass_kg: pair.mass_kg - on_springs,
        tip_mass_kg: tool.mass_kg,
        stiffness_n_per_m: tool.stiffness_n_per_m,
        damping_n_s_per_m: tool.damping_n_s_per_m,
        branches: branches.to_vec(),
        ..pair.clone()
    }
}

impl Arm {
    /// The axis of the arm along `normal` at pose `q` with at most `most` bodies beside the motor.
    ///
    /// With the drive's way held, every mode of the arm is a mass on a spring that hangs on the drive (the
    /// effective masses of modes with a fixed interface: R. R. Craig, M. C. C. Bampton, AIAA J. 6 (1968)).
    /// That is how the motor feels the arm, with nothing lost. The tool's way is a weighted sum of theirs, in
    /// which one body nearly always has nearly all the weight: it becomes the tool. Of the others those are
    /// kept that trail most behind a motor that accelerates. Where no mode takes part the axis is that of
    /// [`Self::reduce`].
    ///
    /// # Errors
    /// Those of [`Self::reduce`].
    pub fn reduce_with_branches(
        &self,
        q: &[f64],
        normal: [f64; 3],
        others: Others,
        most: usize,
    ) -> Result<Reduction, ArmError> {
        let linear = self.linear(q, normal, others)?;
        let pair = self.pair(&linear)?;
        Ok(match tool_and_others(&linear) {
            Some((tool, others)) => branched(&pair, tool, &others[..most.min(others.len())]),
            None => pair,
        })
    }

    /// The axis whose contact mode and phase crossover (-180 degrees from drive force to contact force) are
    /// the arm's, on a contact of so much stiffness (N/m) and damping (N s/m), and how well it agrees.
    ///
    /// That is the pair of masses of [`Self::reduce`] where both are within 1 % of the whole arm's; else the
    /// axis of [`Self::reduce_with_branches`] with as few branches as leave the crossover within 0.5 % of
    /// where all of them put it. Where the tool's way is shared by several modes, so that this is no closer
    /// than 1 % either, bodies are joined to the tool as well, and all numbers but mass and friction are
    /// fitted to the arm's response: one body first, then two, then three. The axis that is nearest is given,
    /// whatever is left: [`Agreement::is_trusted`] tells whether that is more than 5 %.
    ///
    /// # Errors
    /// Those of [`Self::reduce`].
    pub fn reduce_in_contact(
        &self,
        q: &[f64],
        normal: [f64; 3],
        others: Others,
        contact: [f64; 2],
    ) -> Result<(Reduction, Agreement), ArmError> {
        let linear = self.linear(q, normal, others)?;
        let pair = self.pair(&linear)?;
        let whole = WholeArm::new(&linear, contact);
        let of_pair = whole.agreement(&pair);
        if of_pair.farthest() <= 1.0 {
            return Ok((pair, of_pair));
        }
        let mut found = vec![(pair.clone(), of_pair)];
        let beside = tool_and_others(&linear);
        if let Some((tool, others)) = &beside {
            let mut tried: Vec<(Reduction, Agreement)> = (0..=others.len())
                .map(|count| whole.judged(branched(&pair, *tool, &others[..count])))
                .collect();
            let [_, of_all] = tried[others.len()].1.phase_crossover_hz;
            let settled = tried
                .iter()
                .rposition(|(_, one)| apart([of_all, one.phase_crossover_hz[1]]) > MOVED)
                .map_or(0, |last| last + 1);
            let settled = settled.min(others.len());
            let is_close = |count: &usize| tried[*count].1.farthest() <= 1.0;
            let enough = std::iter::once(settled).chain(0..=others.len()).find(is_close).unwrap_or(settled);
            found.push(tried.swap_remove(enough));
        }
        let wanted = Wanted::new(&linear, &pair, contact, &whole);
        let highest_hz = whole.frequencies_hz().into_iter().fold(0.0, f64::max);
        let fitted = |wanted: &Wanted, start: &Reduction| {
            whole.judged(without_fast(wanted.fit(start), FAST * highest_hz))
        };
        let open = |found: &[(Reduction, Agreement)]| found.iter().all(|(_, one)| one.farthest() > 1.0);
        for count in 1..=MOST_FITTED {
            let Some(wanted) = wanted.as_ref().filter(|_| open(&found)) else { break };
            let held = between(&linear, &pair, count);
            let own = beside
                .iter()
                .map(|(tool, others)| linked(&branched(&pair, *tool, &others[..count.min(others.len())])));
            found.extend(own.chain(held).map(|start| fitted(wanted, &start)));
        }
        let mut chains: Vec<Reduction> = found
            .iter()
            .filter(|(axis, _)| axis.branches.iter().any(Branch::is_linked))
            .map(|(axis, _)| axis.clone())
            .collect();
        for factor in FACTORS {
            let Some(wanted) = wanted.as_ref().filter(|_| open(&found)) else { break };
            let closer = wanted.closer(factor);
            let again: Vec<_> = chains.iter().map(|axis| fitted(&closer, axis)).collect();
            chains = again.iter().map(|(axis, _)| axis.clone()).collect();
            found.extend(again);
        }
        let best = found.into_iter().min_by(|(_, a), (_, b)| a.distance().total_cmp(&b.distance()));
        Ok(best.unwrap_or((pair, of_pair)))
    }
}
