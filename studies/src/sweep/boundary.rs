//! The limit of stability on a map by linear theory: of the sampled loop, and of the continuous one.
//!
//! The machine is in contact. If an axis is a gain, its stable values are computed exactly at each value of
//! the other axis. Otherwise the rate of growth is computed on a grid and its zero level is drawn.

use feeler_analysis::{AnalysisError, Band, ContinuousLoop, ControlLoop, SampledLoop, gain_names};
use feeler_catalogue::Tabled;
use feeler_engine::{ControllerUse, Scenario};
use feeler_lti::{Continuous, TimeDomain, eigenvalues};
use rayon::prelude::*;

use super::axes::DrawnAxis;
use super::contour::zero_level;
use crate::operating_point::contact_view;
use feeler_files::{Document, Setting};

/// Values of an axis at which stable gains are computed.
const SECTIONS: usize = 65;
/// Values of each axis at which rates of growth are computed.
const GRID: usize = 33;

/// A line on a map, in values of the two axes.
pub type BoundaryLine = Vec<[f64; 2]>;

/// The limits that linear theory gives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinearLimits {
    /// Limits of the sampled loop, with its delays, filters and hold.
    pub sampled: Vec<BoundaryLine>,
    /// Limits of the loop in continuous time.
    pub continuous: Vec<BoundaryLine>,
}

/// The limits on the map of two axes, with `fixed` settings. Parts for which theory has no result are
/// omitted.
pub(super) fn linear_limits(
    document: &Document,
    [x, y]: [&DrawnAxis; 2],
    fixed: &[(String, Setting)],
) -> LinearLimits {
    let fixed: Vec<(&str, Setting)> =
        fixed.iter().map(|(key, value)| (key.as_str(), value.clone())).collect();
    let base = document.with(fixed).unwrap_or_else(|_| document.clone());
    if is_gain(&base.scenario, &y.key) {
        return along(&base, x, y, |section, gain| [section, gain]);
    }
    if is_gain(&base.scenario, &x.key) {
        return along(&base, y, x, |section, gain| [gain, section]);
    }
    by_growth(&base, x, y)
}

/// Whether a key names a gain of a controller.
fn is_gain(scenario: &Scenario, key: &str) -> bool {
    let Some((name, gain)) = ControllerUse::within(key).and_then(|path| path.split_once('.')) else {
        return false;
    };
    scenario.controllers.get(name).is_some_and(|used| gain_names(&used.spec.law).contains(&gain))
}

fn with(document: &Document, settings: &[(&str, f64)]) -> Option<Scenario> {
    document
        .with(settings.iter().map(|(key, value)| (*key, Setting::Number(*value))))
        .ok()
        .map(|document| document.scenario)
}

/// Intervals of stable values of the gain that a key names.
type Intervals = fn(&ControlLoop, &str) -> Result<Vec<Band>, AnalysisError>;

/// Stable values of the gain on `along` at each value of `across`.
fn along(
    document: &Document,
    across: &DrawnAxis,
    along: &DrawnAxis,
    place: impl Fn(f64, f64) -> [f64; 2],
) -> LinearLimits {
    let sections = across.values(SECTIONS);
    let reaches_below_zero = along.values(2).iter().any(|gain| *gain < 0.0);
    let bands: Vec<[Option<Vec<Band>>; 2]> = (sections.par_iter())
        .map(|&value| {
            let whole = with(document, &[(&across.key, value)]).and_then(|scenario| {
                ControlLoop::varying(&scenario, &contact_view(&scenario), &along.key).ok()
            });
            let of: [Intervals; 2] = if reaches_below_zero {
                [ControlLoop::sampled_intervals, ControlLoop::continuous_intervals]
            } else {
                [
                    |whole, key| Ok(whole.sampled_bands(key)?.bands),
                    |whole, key| Ok(whole.continuous_bands(key)?.bands),
                ]
            };
            of.map(|intervals| intervals(whole.as_ref()?, &along.key).ok())
        })
        .collect();
    let lines = |which: usize| {
        let of_sections: Vec<Vec<f64>> = bands
            .iter()
            .map(|found| found[which].as_ref().map_or_else(Vec::new, |bands| edges(bands)))
            .collect();
        let lines = joined(&of_sections);
        lines
            .into_iter()
            .map(|line| line.into_iter().map(|(i, gain)| place(sections[i], gain)).collect())
            .collect()
    };
    LinearLimits { sampled: lines(0), continuous: lines(1) }
}

fn edges(bands: &[Band]) -> Vec<f64> {
    bands.iter().flat_map(|band| [&band.lower, &band.upper]).flatten().map(|edge| edge.gain).collect()
}

/// Edges of consecutive sections, by rising gain, as lines of section and gain. If the next section has fewer
/// or more edges, the nearest ones belong together. Two neighbouring edges without partners are both ends of
/// a line that turns back between the sections. A single one is where a line leaves or enters.
fn joined(sections: &[Vec<f64>]) -> Vec<Vec<(usize, f64)>> {
    let mut lines: Vec<Vec<(usize, f64)>> = Vec::new();
    // The lines of the last section's edges.
    let mut open: Vec<usize> = Vec::new();
    let mut before: &[f64] = &[];
    for (i, edges) in sections.iter().enumerate() {
        let partner = partners(before, edges);
        let mut next: Vec<usize> = Vec::new();
        for (&gain, partner) in edges.iter().zip(&partner) {
            next.push(partner.map_or(lines.len(), |k| open[k]));
            if partner.is_none() {
                lines.push(Vec::new());
            }
            lines[next[next.len() - 1]].push((i, gain));
        }
        let ended: Vec<usize> = (0..before.len()).filter(|k| !partner.contains(&Some(*k))).collect();
        let begun: Vec<usize> = (0..edges.len()).filter(|k| partner[*k].is_none()).collect();
        for pair in neighbours(&ended) {
            let (line, from) = (open[pair[0]], open[pair[1]]);
            let other = std::mem::take(&mut lines[from]);
            lines[line].extend(other.into_iter().rev());
        }
        // At the first section lines come from beyond the axis. Later the line begins on the other branch, so
        // that both are drawn as one.
        for pair in neighbours(&begun).into_iter().filter(|_| i > 0) {
            let start = (i, edges[pair[0]]);
            lines[next[pair[1]]].insert(0, start);
        }
        (open, before) = (next, edges);
    }
    lines.retain(|line| !line.is_empty());
    lines
}

/// Pairs of indices that follow one another.
fn neighbours(indices: &[usize]) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    let mut rest = indices;
    while let [a, b, others @ ..] = rest {
        if b - a == 1 {
            pairs.push([*a, *b]);
            rest = others;
        } else {
            rest = &rest[1..];
        }
    }
    pairs
}

/// For each edge of a section its partner in the previous section: in order, as many as possible, the nearest
/// by ratio.
fn partners(before: &[f64], edges: &[f64]) -> Vec<Option<usize>> {
    let apart = |a: f64, b: f64| if a * b > 0.0 { (a / b).ln().abs() } else { (a - b).abs() };
    // cost[i][j]: for the last i of one and the last j of the other; all of the shorter list are matched.
    let (n, m) = (before.len(), edges.len());
    let mut cost = vec![vec![0.0; m + 1]; n + 1];
    for i in (0..n).rev() {
        for j in (0..m).rev() {
            let matched = cost[i + 1][j + 1] + apart(before[i], edges[j]);
            let skipped = match (n - i).cmp(&(m - j)) {
                std::cmp::Ordering::Less => cost[i][j + 1],
                std::cmp::Ordering::Greater => cost[i + 1][j],
                std::cmp::Ordering::Equal => f64::INFINITY,
            };
            cost[i][j] = matched.min(skipped);
        }
    }
    let (mut i, mut j) = (0, 0);
    let mut found = vec![None; m];
    while i < n && j < m {
        let matched = cost[i + 1][j + 1] + apart(before[i], edges[j]);
        if matched <= cost[i][j] {
            found[j] = Some(i);
            (i, j) = (i + 1, j + 1);
        } else if n - i > m - j {
            i += 1;
        } else {
            j += 1;
        }
    }
    found
}

fn by_growth(document: &Document, x: &DrawnAxis, y: &DrawnAxis) -> LinearLimits {
    let rates_at = |column: f64, row: f64| {
        let whole = with(document, &[(&x.key, column), (&y.key, row)])
            .and_then(|scenario| ControlLoop::new(&scenario, &contact_view(&scenario)).ok());
        whole.map_or([f64::NAN; 2], |whole| {
            [sampled_growth_per_s(&whole), continuous_growth_per_s(&whole)].map(|r| r.unwrap_or(f64::NAN))
        })
    };
    let (columns, rows) = (x.values(GRID), y.values(GRID));
    let rates: Vec<Vec<[f64; 2]>> =
        (rows.par_iter()).map(|&row| columns.iter().map(|&column| rates_at(column, row)).collect()).collect();
    let share = |at: f64| at / (GRID - 1) as f64;
    let lines = |which: usize| {
        let values: Vec<Vec<f64>> =
            rates.iter().map(|row| row.iter().map(|rate| rate[which]).collect()).collect();
        let centre = |i: usize, j: usize| {
            rates_at(x.value(share(i as f64 + 0.5)), y.value(share(j as f64 + 0.5)))[which]
        };
        let place = |[i, j]: [f64; 2]| [x.value(share(i)), y.value(share(j))];
        zero_level(&values, &centre).into_iter().map(|line| line.into_iter().map(place).collect()).collect()
    };
    LinearLimits { sampled: lines(0), continuous: lines(1) }
}

/// Rate at which the sampled loop's fastest growing motion grows, 1/s; negative if all motions decay.
///
/// # Errors
/// As [`SampledLoop::new`].
pub(crate) fn sampled_growth_per_s(whole: &ControlLoop) -> Result<f64, AnalysisError> {
    let sampled = SampledLoop::new(whole)?;
    let domain = sampled.domain()?;
    Ok(sampled
        .eigenvalues()?
        .into_iter()
        .map(|pole| domain.growth_per_s(pole))
        .fold(f64::NEG_INFINITY, f64::max))
}

fn continuous_growth_per_s(whole: &ControlLoop) -> Result<f64, AnalysisError> {
    let poles = eigenvalues(&ContinuousLoop::new(whole)?.closed_loop()?)?;
    Ok(poles.into_iter().map(|pole| Continuous.growth_per_s(pole)).fold(f64::NEG_INFINITY, f64::max))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flexible() -> Document {
        Document::load(
            &std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios"))
                .join("paper/flexible.toml"),
        )
        .unwrap()
    }

    fn axis(key: &str, range: [f64; 2]) -> DrawnAxis {
        DrawnAxis { key: key.into(), unit: String::new(), range, points: Some(9), log: true }
    }

    /// At the machine's own stiffness of 2e5 N/m, the middle of the axis, the limits are 1.5068 sampled and
    /// 5.6083 continuous.
    #[test]
    fn reference_the_lines_pass_through_the_known_limits() {
        let (kp, wall) =
            (axis("controllers.force.kp", [0.1, 10.0]), axis("contacts.tool.stiffness", [2e4, 2e6]));
        let limits = linear_limits(&flexible(), [&wall, &kp], &[]);
        let middle = |lines: &[BoundaryLine]| {
            lines.iter().flatten().find(|point| (point[0] / 2e5 - 1.0).abs() < 1e-9).unwrap()[1]
        };
        assert!((middle(&limits.sampled) - 1.5068).abs() < 1e-3, "{}", middle(&limits.sampled));
        assert!((middle(&limits.continuous) - 5.6083).abs() < 1e-3, "{}", middle(&limits.continuous));
        let turned = linear_limits(&flexible(), [&kp, &wall], &[]);
        assert_eq!(turned.sampled.iter().flatten().count(), limits.sampled.iter().flatten().count());
    }

    /// At kp = -1 the loop has no stiffness left, whatever the wall's: the lower end of the stable range.
    #[test]
    fn truth_a_limit_below_zero_is_drawn_too() {
        let kp = DrawnAxis { log: false, ..axis("controllers.force.kp", [-2.0, 0.2]) };
        let limits = linear_limits(&flexible(), [&kp, &axis("contacts.tool.stiffness", [2e4, 2e6])], &[]);
        for lines in [&limits.sampled, &limits.continuous] {
            let below: Vec<f64> =
                lines.iter().flatten().map(|point| point[0]).filter(|kp| *kp < 0.0).collect();
            assert!(below.len() == SECTIONS && below.iter().all(|kp| (kp + 1.0).abs() < 1e-6), "{below:?}");
        }
    }

    /// The same limit as a level of the growth rate, over two keys that are not gains: it agrees with the
    /// exact search.
    #[test]
    fn truth_limits_over_keys_that_are_no_gains_are_those_of_the_gain() {
        let document = flexible().with([("controllers.force.kp", Setting::Number(0.5641))]).unwrap();
        let (delay, wall) = (
            DrawnAxis { log: false, ..axis("controllers.force.delay", [0.0, 2e-3]) },
            axis("contacts.tool.stiffness", [2e4, 2e6]),
        );
        let limits = linear_limits(&document, [&delay, &wall], &[]);
        // kp = 0.5641 is the limit at one sample of delay on the wall of 2e5 N/m. Cells are 0.06 ms by 15 %.
        let near = |p: &&[f64; 2]| (p[0] - 1e-3).abs() < 0.1e-3 && (p[1] / 2e5).ln().abs() < 0.3;
        assert!(limits.sampled.iter().flatten().any(|point| near(&point)), "{:?}", limits.sampled);
    }

    /// A stable band that opens and closes beyond an edge that continues: one line across, and one around the
    /// band.
    #[test]
    fn regress_edges_that_come_and_go_in_pairs_are_the_ends_of_one_line() {
        let sections =
            [vec![1.0], vec![1.1], vec![1.2, 5.0, 8.0], vec![1.3, 4.0, 9.0], vec![1.4, 5.0, 8.0], vec![1.5]];
        let lines = joined(&sections);
        assert_eq!(lines.len(), 2, "{lines:?}");
        assert_eq!(lines[0], [(0, 1.0), (1, 1.1), (2, 1.2), (3, 1.3), (4, 1.4), (5, 1.5)]);
        assert_eq!(lines[1].len(), 7);
        // Also below the edge that continues.
        let below = joined(&[vec![8.0], vec![1.0, 2.0, 8.1], vec![8.2]]);
        assert_eq!(below[0], [(0, 8.0), (1, 8.1), (2, 8.2)]);
        assert_eq!(below.len(), 2);
        // A single additional edge enters from beyond the search.
        assert_eq!(joined(&[vec![1.0], vec![1.0, 50.0]]).iter().map(Vec::len).collect::<Vec<_>>(), [2, 1]);
    }
}
