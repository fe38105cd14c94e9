//! A machine with a table of the force that its guide lacks.

use feeler_plant::assembly::{Assembly, NodeId, POINTS, Table};
use feeler_plant::description::Site;
use feeler_plant::effects::{ForceTable, Kind, Parameters};
use nalgebra::{DMatrix, DVector};

use crate::fit::candidates::of_kind;
use crate::fit::least_squares::Task;
use crate::fit::model::Model;
use crate::fit::scored::Scored;
use crate::fit::search::score;
use crate::gap::unknown::portrait;

/// Rows averaged into one point of the missing force, and the smallest number of such points.
const AVERAGE: usize = 8;
const FEWEST: usize = 20 * POINTS;
/// Weight of the bends between points, over that of the missing force: it decides only where hardly any
/// motion was.
const SMOOTH: f64 = 1e-8;
/// Steps of the fit: the force is linear in its values.
const STEPS: usize = 6;

/// A fitted machine with a table, and the element that has it.
pub(crate) struct Tabled {
    pub(crate) scored: Scored,
    pub(crate) site: Site,
    pub(crate) table: ForceTable,
}

/// Fits a table to the force that a fitted model lacks over the position of a guide, together with all that
/// is free in the model. `None` if no guide moves with the first drive, or if one has a table already.
pub(crate) fn tabled(task: &Task<'_>, base: &Scored) -> Option<Tabled> {
    let assembly = base.fitted.model.assembly(&base.fitted.theta, None)?;
    let drive = &assembly.drives[task.dataset.drives.first()?.drive];
    let (candidate, along) =
        of_kind(&task.dataset.machine, Kind::ForceTable).into_iter().find_map(|one| {
            let link = &assembly.links[one.site.index];
            Some((one, Along::of(&assembly, [link.b, link.a], [drive.on, drive.reacts_on])?))
        })?;
    let element = task.dataset.machine.element(candidate.site)?.1;
    if element.effects().iter().any(|effect| effect.definition.kind == Kind::ForceTable) {
        return None;
    }
    let missing: Vec<[f64; 2]> = portrait(task, base, &task.fitted, AVERAGE, Some(false))
        .into_iter()
        .map(|[x, _, _, force]| [along.sign * x + along.offset, along.sign * force])
        .collect();
    let start = regressed(&missing)?;
    let (model, theta) = base.fitted.model.with_table(&base.fitted.theta, candidate.site, start);
    let fitted = task.fit(&model, &theta, STEPS);
    let last = fitted.model.tried.len() - 1;
    let table = ForceTable::of(&fitted.model.parameters(last, &fitted.theta));
    Some(Tabled { scored: score(task, base.causes.clone(), fitted), site: candidate.site, table })
}

/// How the position of a guide follows from that of a drive: `sign x + offset`.
struct Along {
    sign: f64,
    offset: f64,
}

impl Along {
    /// `None` if the two ends of the guide do not move as the two of the drive.
    fn of(assembly: &Assembly, guide: [NodeId; 2], drive: [NodeId; 2]) -> Option<Self> {
        let moves_with =
            |a: NodeId, b: NodeId| assembly.reached(vec![a], &[], |link| link.rigid).contains(&b);
        let follows = |[a, b]: [NodeId; 2]| moves_with(guide[0], a) && moves_with(guide[1], b);
        let apart = |[a, b]: [NodeId; 2]| assembly.nodes[a].position_m - assembly.nodes[b].position_m;
        let sign = match (follows(drive), follows([drive[1], drive[0]])) {
            (true, false) => 1.0,
            (false, true) => -1.0,
            _ => return None,
        };
        Some(Self { sign, offset: apart(guide) - sign * apart(drive) })
    }
}

/// The table over all positions that comes nearest to missing forces, `[position, force]`.
fn regressed(missing: &[[f64; 2]]) -> Option<ForceTable> {
    let ends = |(low, high): (f64, f64), [x, _]: &[f64; 2]| (low.min(*x), high.max(*x));
    let (from, to) = missing.iter().fold((f64::INFINITY, f64::NEG_INFINITY), ends);
    if missing.len() < FEWEST || from >= to {
        return None;
    }
    let alone = |i: usize| Table::between(from, to, std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let shapes: [Table; POINTS] = std::array::from_fn(alone);
    let mut a = DMatrix::<f64>::zeros(POINTS, POINTS);
    let mut b = DVector::<f64>::zeros(POINTS);
    for [x, force] in missing {
        let values = DVector::from_iterator(POINTS, shapes.iter().map(|shape| shape.force(*x)));
        a += &values * values.transpose();
        b += *force * values;
    }
    let weight = SMOOTH * a.trace();
    for i in 1..POINTS - 1 {
        let bend = [(i - 1, 1.0), (i, -2.0), (i + 1, 1.0)];
        for ((i, by_i), (j, by_j)) in bend.iter().flat_map(|one| bend.iter().map(move |two| (one, two))) {
            a[(*i, *j)] += weight * by_i * by_j;
        }
    }
    let forces = a.cholesky()?.solve(&b);
    let values: Vec<f64> = [from, to].into_iter().chain(forces.iter().copied()).collect();
    values.iter().all(|value| value.is_finite()).then(|| ForceTable::of(&values))
}

impl Model {
    /// The model with a table whose forces are free, and a point that continues `theta`. The records decide
    /// where the table begins and ends.
    fn with_table(&self, theta: &[f64], site: Site, table: ForceTable) -> (Self, Vec<f64>) {
        let mut model = self.with(site, Kind::ForceTable.definition(), &table.values());
        let effect = model.tried.len() - 1;
        model.unknowns.retain(|unknown| {
            let parameter = unknown.parameter_of(effect).map(|p| &ForceTable::PARAMETERS[p]);
            parameter.is_none_or(|parameter| parameter.null.is_some())
        });
        // Steps of a fit are at most one unit: the largest force.
        let unit = table.forces().iter().fold(f64::MIN_POSITIVE, |most, force| most.max(force.abs()));
        for unknown in model.unknowns.iter_mut().filter(|unknown| unknown.parameter_of(effect).is_some()) {
            let factor = unknown.unit / unit;
            unknown.bounds = (unknown.bounds.0 * factor, unknown.bounds.1 * factor);
            unknown.unit = unit;
        }
        let mut start = model.start();
        start[..theta.len()].copy_from_slice(theta);
        (model, start)
    }
}

#[cfg(test)]
mod tests {
    use feeler_files::Document;
    use feeler_plant::assembly::{GROUND_NODE, assemble};

    use super::*;

    #[test]
    fn truth_a_guide_follows_the_drive_from_either_end() {
        let along = |between: &str, more: &str| {
            let text = format!(
                "[bodies.motor]\nmass = 1.0\nposition = 0.3\n[bodies.tip]\nmass = 1.0\n\
                 [springs.guide]\nbetween = {between}\ndamping = 1.0\n\
                 [springs.joint]\nbetween = [\"motor\", \"tip\"]\n{more}\n"
            );
            let machine = Document::parse(&text, "axis.toml").unwrap().scenario.machine;
            let assembly = assemble(&machine).unwrap();
            let link = &assembly.links[0];
            let found = Along::of(&assembly, [link.b, link.a], [1, GROUND_NODE]);
            found.map(|Along { sign, offset }| [sign, offset])
        };
        // The drive pushes the motor, at 0.3 m; the tip is joined to it at zero.
        assert_eq!(along("[\"ground\", \"motor\"]", "rigid = true"), Some([1.0, 0.0]));
        assert_eq!(along("[\"motor\", \"ground\"]", "rigid = true"), Some([-1.0, 0.0]));
        assert_eq!(along("[\"ground\", \"tip\"]", "rigid = true"), Some([1.0, -0.3]));
        assert_eq!(along("[\"ground\", \"tip\"]", "stiffness = 1e5"), None);
    }

    /// The weight of the bends, over the share of one point in the trace.
    const OFF: f64 = 1e-4;

    #[test]
    fn truth_a_table_is_read_off_its_own_forces() {
        let table = Table::between(-0.1, 0.3, [0.0, 1.0, 5.0, 2.0, -3.0, 0.0, 0.0, 4.0, 1.0]);
        let at = |k: u32| -0.1 + 0.4 * f64::from(k) / 400.0;
        let points: Vec<[f64; 2]> = (0..=400).map(|k| [at(k), table.force(at(k))]).collect();
        let found = regressed(&points).unwrap();
        for x in [-0.1, -0.03, 0.02, 0.11, 0.25, 0.3] {
            assert!((found.table().force(x) - table.force(x)).abs() < OFF, "{x} {found:?}");
        }
        assert!(regressed(&points[..100]).is_none());
    }
}
