//! Bodies at the motor, for arms that one spring does not represent.

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

/// Largest number of bodies of a fitted axis: more of them bring no improvement.
const MOST_FITTED: usize = 4;
/// Weights of landmarks that a fit has missed, one after the other.
const FACTORS: [f64; 3] = [10.0, 100.0, 1e3];
/// Frequency of a body, over the phase crossover, above which it has no effect there.
const FAST: f64 = 12.0;
/// Largest shift of the crossover by omitting bodies.
const MOVED: f64 = 5e-3;
/// Share of the arm's mass below which a mode does not take part.
const NO_PART: f64 = 1e-9;

/// A branch and its share of the tool's displacement; the shares add up to one.
struct Part {
    branch: Branch,
    way: f64,
}

/// The branches on the drive: one per mode of the arm with the drive's displacement held. To the drive they
/// equal the arm, except for damping that couples them.
fn parts(linear: &LinearArm) -> Vec<Part> {
    let system = &linear.system;
    let n = system.drive.len();
    // Householder's reflection of the drive's direction onto the first axis: its other columns span the
    // motions that leave the drive at rest.
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

/// The body that represents the tool (the one with the largest share of its displacement), and the others,
/// those with the largest lag first.
fn tool_and_others(linear: &LinearArm) -> Option<(Branch, Vec<Branch>)> {
    let mut parts = parts(linear);
    parts.sort_by(|a, b| b.way.total_cmp(&a.way));
    let mut bodies = parts.into_iter().map(|part| part.branch);
    let tool = bodies.next()?;
    let mut others: Vec<Branch> = bodies.collect();
    others.sort_by(|a, b| b.lag().partial_cmp(&a.lag()).unwrap_or(Ordering::Equal));
    Some((tool, others))
}

/// An axis of motor, tool and branches; the remaining mass moves with the motor.
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
    /// The axis of the arm along `normal` at pose `q` with at most `most` bodies at the motor.
    ///
    /// With the drive's displacement held, every mode of the arm is a mass on a spring attached to the drive.
    /// These are the effective masses of modes with a fixed interface (R. R. Craig, M. C. C. Bampton, AIAA J.
    /// 6 (1968)). To the motor this equals the arm. The tool's displacement is a weighted sum of theirs, in
    /// which one body nearly always has nearly all the weight: it becomes the tool. Of the others, those with
    /// the largest lag behind an accelerating motor are kept. If no mode takes part, the axis is that of
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

    /// The axis with the arm's contact mode and phase crossover, on a contact with this stiffness (N/m) and
    /// damping (N s/m), and its agreement. The crossover is where the phase from drive force to contact force
    /// passes -180 degrees.
    ///
    /// The first choice is the pair of masses of [`Self::reduce`], if both landmarks are within 1 % of the
    /// whole arm's. The second is the axis of [`Self::reduce_with_branches`] with the fewest branches that
    /// keep the crossover within 0.5 % of its value with all of them. If several modes share the tool's
    /// displacement, this may miss the 1 %, too. Then bodies are joined to the tool as well, and all numbers
    /// except mass and friction are fitted to the arm's response. This is done with one body first, then two,
    /// then three. The result is the nearest axis in any case; [`Agreement::is_trusted`] reports whether the
    /// difference exceeds 5 %.
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
        let mut starts = Vec::new();
        for count in 1..=MOST_FITTED {
            let Some(wanted) = wanted.as_ref().filter(|_| open(&found)) else { break };
            let held = between(&linear, &pair, count);
            let own = beside
                .iter()
                .map(|(tool, others)| linked(&branched(&pair, *tool, &others[..count.min(others.len())])));
            let begun: Vec<Reduction> = own.chain(held).collect();
            found.extend(begun.iter().map(|start| fitted(wanted, start)));
            starts.extend(begun);
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
            // The valley that a first fit has led to need not be the one of the landmarks.
            found.extend(starts.iter().map(|start| fitted(&closer, start)));
        }
        let best = found.into_iter().min_by(|(_, a), (_, b)| a.distance().total_cmp(&b.distance()));
        Ok(best.unwrap_or((pair, of_pair)))
    }
}
