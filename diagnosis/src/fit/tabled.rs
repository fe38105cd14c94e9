//! A machine with a table of the force that its guide lacks, over position, speed or direction.

use feeler_plant::assembly::{Assembly, NodeId, POINTS, TabulatedForce};
use feeler_plant::description::Site;
use feeler_plant::effects::{Kind, LIBRARY};
use nalgebra::{DMatrix, DVector};

use crate::fit::bounded::minimise;
use crate::fit::candidates::of_kind;
use crate::fit::least_squares::Task;
use crate::fit::model::Model;
use crate::fit::scored::Scored;
use crate::fit::search::score;
use crate::gap::unknown::portrait;
use crate::kinds::{Over, dossier};

/// Rows averaged into one point of the missing force, and the smallest number of such points.
const AVERAGE: usize = 8;
const FEWEST: usize = 20 * POINTS;
/// Weight of the curvature between points, relative to the missing force. It matters only where there was
/// hardly any motion.
const SMOOTH: f64 = 1e-8;
/// Steps of the fit: the force is linear in its values.
const STEPS: usize = 6;
/// Speed, over the root mean square speed, below which a guide may still be presliding.
const SLIDES: f64 = 0.1;

/// A fitted machine with a table, and the element that has it.
pub(crate) struct Tabled {
    pub(crate) scored: Scored,
    pub(crate) site: Site,
    pub(crate) kind: Kind,
    pub(crate) over: Over,
    pub(crate) table: TabulatedForce,
}

/// Every kind of table.
fn tables() -> impl Iterator<Item = (Kind, Over)> {
    LIBRARY.iter().filter_map(|one| Some((one.kind, dossier(one.kind).table_over?)))
}

/// Fits a table to the force that a fitted model lacks at a guide, together with all unknowns of the model.
/// The kind of table is the one that, estimated from the fitted records, comes closest to the missing force
/// of `checks`. `None` if no guide moves with the first drive, or if a guide already has a table.
pub(crate) fn tabled(task: &Task<'_>, base: &Scored, checks: &[usize]) -> Option<Tabled> {
    let assembly = base.fitted.model.assembly(&base.fitted.theta, None)?;
    let drive = &assembly.drives[task.dataset.drives.first()?.drive];
    let (first, _) = tables().next()?;
    let (site, along) = of_kind(&task.dataset.machine, first).into_iter().find_map(|one| {
        let link = &assembly.links[one.site.index];
        let along = Along::of(&assembly, [link.b, link.a], [drive.on, drive.reacts_on])?;
        Some((one.site, along))
    })?;
    let element = task.dataset.machine.element(site)?.1;
    if element.effects().iter().any(|effect| dossier(effect.definition.kind).table_over.is_some()) {
        return None;
    }
    let missing = |records: &[usize]| portrait(task, base, records, AVERAGE, Some(false));
    let (fitted, checked) = (missing(&task.fitted), missing(checks));
    let read = |(kind, over): (Kind, Over)| {
        let values = regressed(over, &along.seen(over, &fitted))?;
        let table = TabulatedForce::of(&values);
        Some(((kind, over), left(&along.seen(over, &checked), &table)?, values))
    };
    let found = tables().filter_map(read).min_by(|a, b| a.1.total_cmp(&b.1));
    let ((kind, over), _, start) = found.filter(|(_, left, _)| *left < 1.0)?;
    let (model, theta) = base.fitted.model.with_table(&base.fitted.theta, site, kind, &start);
    let fitted = task.fit(&model, &theta, STEPS);
    let last = fitted.model.tried.len() - 1;
    let table = TabulatedForce::of(&fitted.model.parameters(last, &fitted.theta));
    Some(Tabled { scored: score(task, base.causes.clone(), fitted), site, kind, over, table })
}

/// A missing force: the position or speed at which the table is read, and the factor on the table's force.
struct Missing {
    at: f64,
    factor: f64,
    force: f64,
}

impl Along {
    /// Points of a portrait in the coordinate of this kind of table.
    fn seen(&self, over: Over, portrait: &[[f64; 4]]) -> Vec<Missing> {
        let mean = portrait.iter().map(|[_, v, ..]| v * v).sum::<f64>() / portrait.len().max(1) as f64;
        let seen = |[x, v, _, force]: &[f64; 4]| {
            let (x, v, force) = (self.sign * x + self.offset, self.sign * v, self.sign * force);
            match over {
                Over::Position => Some(Missing { at: x, factor: 1.0, force }),
                Over::Speed => Some(Missing { at: v, factor: 1.0, force }),
                Over::PositionAndDirection if v.abs() < SLIDES * mean.sqrt() => None,
                Over::PositionAndDirection => Some(Missing { at: x, factor: -v.signum(), force }),
            }
        };
        portrait.iter().filter_map(seen).collect()
    }
}

/// Share of the mean square missing force that a table leaves; `None` if no force is missing.
fn left(missing: &[Missing], table: &TabulatedForce) -> Option<f64> {
    let sum = |of: &dyn Fn(&Missing) -> f64| missing.iter().map(|one| of(one).powi(2)).sum::<f64>();
    let all = sum(&|one| one.force);
    (all > 0.0).then(|| sum(&|one| one.force - one.factor * table.force(one.at)) / all)
}

/// Position of a guide from that of a drive: `sign x + offset`.
struct Along {
    sign: f64,
    offset: f64,
}

impl Along {
    /// `None` if the two ends of the guide do not move with the two ends of the drive.
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

/// Values of the table closest to the missing forces, over the range where there are any. A friction level is
/// not negative.
fn regressed(over: Over, missing: &[Missing]) -> Option<Vec<f64>> {
    let ends = |(low, high): (f64, f64), one: &Missing| (low.min(one.at), high.max(one.at));
    let (from, to) = missing.iter().fold((f64::INFINITY, f64::NEG_INFINITY), ends);
    if missing.len() < FEWEST || from >= to {
        return None;
    }
    let alone =
        |i: usize| TabulatedForce::between(from, to, std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let shapes: [TabulatedForce; POINTS] = std::array::from_fn(alone);
    let mut a = DMatrix::<f64>::zeros(POINTS, POINTS);
    let mut b = DVector::<f64>::zeros(POINTS);
    for Missing { at, factor, force } in missing {
        let values = DVector::from_iterator(POINTS, shapes.iter().map(|shape| factor * shape.force(*at)));
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
    let least = if over == Over::PositionAndDirection { 0.0 } else { f64::NEG_INFINITY };
    let forces = minimise(&a, &b, &[least; POINTS], &[f64::INFINITY; POINTS])?;
    let values: Vec<f64> = [from, to].into_iter().chain(forces.iter().copied()).collect();
    values.iter().all(|value| value.is_finite()).then_some(values)
}

impl Model {
    /// The model with a table of unknown forces, and a point that continues `theta`. The range of the table
    /// comes from the records.
    fn with_table(&self, theta: &[f64], site: Site, kind: Kind, values: &[f64]) -> (Self, Vec<f64>) {
        let definition = kind.definition();
        let mut model = self.with(site, definition, values);
        let effect = model.tried.len() - 1;
        model.unknowns.retain(|unknown| {
            let parameter = unknown.parameter_of(effect).map(|p| &definition.parameters[p]);
            parameter.is_none_or(|parameter| parameter.null.is_some())
        });
        // A step of a fit is at most one unit, so the unit is the largest force.
        let unit = values[2..].iter().fold(f64::MIN_POSITIVE, |most, force| most.max(force.abs()));
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
        // The drive moves the motor at 0.3 m; the tip, rigidly joined to it, starts at zero.
        assert_eq!(along("[\"ground\", \"motor\"]", "rigid = true"), Some([1.0, 0.0]));
        assert_eq!(along("[\"motor\", \"ground\"]", "rigid = true"), Some([-1.0, 0.0]));
        assert_eq!(along("[\"ground\", \"tip\"]", "rigid = true"), Some([1.0, -0.3]));
        assert_eq!(along("[\"ground\", \"tip\"]", "stiffness = 1e5"), None);
    }

    /// Ratio of the curvature's weight to the share of one point in the trace.
    const OFF: f64 = 1e-4;
    const AXIS: Along = Along { sign: 1.0, offset: 0.0 };

    /// A portrait of 402 points along the stroke, forward and back at all speeds, with a force that depends
    /// on position and speed.
    fn portrait_of(force: impl Fn(f64, f64) -> f64) -> Vec<[f64; 4]> {
        let at = |k: u32| (-0.1 + 0.4 * f64::from(k) / 200.0, 0.2 * (0.05 * f64::from(k)).cos());
        let way = (0..=200).map(at).flat_map(|(x, v)| [[x, v], [x, -v]]);
        way.map(|[x, v]| [x, v, 0.0, force(x, v)]).collect()
    }

    #[test]
    fn truth_a_table_is_read_off_its_own_forces() {
        let forces = [0.0, 1.0, 5.0, 2.0, 3.0, 0.0, 0.0, 4.0, 1.0];
        let (place, speed) =
            (TabulatedForce::between(-0.1, 0.3, forces), TabulatedForce::between(-0.2, 0.2, forces));
        let made: [(Over, &TabulatedForce, Vec<[f64; 4]>); 3] = [
            (Over::Position, &place, portrait_of(|x, _| place.force(x))),
            (Over::Speed, &speed, portrait_of(|_, v| speed.force(v))),
            (Over::PositionAndDirection, &place, portrait_of(|x, v| -v.signum() * place.force(x))),
        ];
        for (own, table, portrait) in &made {
            let found = regressed(*own, &AXIS.seen(*own, portrait)).unwrap();
            let read = TabulatedForce::of(&found);
            // Only the curvature decides where there was no motion.
            for Missing { at, .. } in AXIS.seen(*own, portrait) {
                assert!((read.force(at) - table.force(at)).abs() < OFF, "{own:?} {at} {found:?}");
            }
            // Estimated from half of the points, no other kind is as close to the other half.
            let half = |odd: usize| portrait.iter().skip(odd).step_by(2).copied().collect::<Vec<_>>();
            let left = |over: Over| {
                let values = regressed(over, &AXIS.seen(over, portrait)).unwrap();
                left(&AXIS.seen(over, &half(1)), &TabulatedForce::of(&values)).unwrap()
            };
            let others = tables().map(|(_, over)| over).filter(|over| over != own);
            assert!(left(*own) < 1e-6 && others.map(left).all(|left| left > 0.1), "{own:?}");
        }
        assert!(regressed(Over::Position, &AXIS.seen(Over::Position, &made[0].2[..100])).is_none());
    }

    #[test]
    fn truth_no_level_of_friction_is_below_zero() {
        let portrait = portrait_of(|x, v| -v.signum() * (x - 0.1));
        let found =
            regressed(Over::PositionAndDirection, &AXIS.seen(Over::PositionAndDirection, &portrait)).unwrap();
        assert!(found[2..].iter().all(|level| *level >= 0.0) && found[10] > 0.1, "{found:?}");
    }
}
