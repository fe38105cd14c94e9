//! The answer of a sweep in a sentence: the region over two axes in which variants come to rest, or the
//! random number that decides.

use feeler_studies::sweep::DrawnAxis;

use crate::numbers::{percent, with_unit};

/// A difference of shares counts if chance alone gives a smaller one in 99.7 % of cases.
const DEVIATIONS: f64 = 3.0;

/// Variants with one value on the other axis, along the whole axis in question.
struct Line {
    other: f64,
    /// The last value up to which each variant comes to rest; `None` if the first does not.
    limit: Option<f64>,
    is_whole: bool,
}

/// Region in which variants over two axes of a grid come to rest. `points` are values on both axes and
/// whether the run comes to rest; `None` for a run that failed or is undecided.
pub(super) fn over_two(axes: [&DrawnAxis; 2], points: &[([f64; 2], Option<bool>)]) -> Option<String> {
    if axes.iter().any(|axis| axis.points.is_none()) || points.is_empty() {
        return None;
    }
    if points.iter().all(|(_, rests)| *rests != Some(true)) {
        return Some("It settles nowhere on the map. ".into());
    }
    // The limit of a gain is the main question.
    let is_gain = |axis: &DrawnAxis| axis.key.starts_with("controllers.");
    let main = usize::from(is_gain(axes[1]) || !is_gain(axes[0]));
    let (axis, other) = (axes[main], axes[1 - main]);
    let mut along: Vec<(f64, f64, bool)> =
        points.iter().map(|(at, rests)| (at[1 - main], at[main], *rests == Some(true))).collect();
    along.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let ends = along
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], (_, at, _)| [low.min(*at), high.max(*at)]);
    // In an adaptive sweep some lines are known only near an edge.
    let whole: Vec<&[(f64, f64, bool)]> = (along.chunk_by(|a, b| a.0.total_cmp(&b.0).is_eq()))
        .filter(|line| line[0].1 <= ends[0] && line[line.len() - 1].1 >= ends[1])
        .collect();
    let rests_at = |end: fn(&[(f64, f64, bool)]) -> bool| whole.iter().filter(|line| end(line)).count();
    let upwards = rests_at(|line| line[0].2) >= rests_at(|line| line[line.len() - 1].2);
    let lines: Vec<Line> = whole.into_iter().map(|line| line_of(line, upwards)).collect();
    Some(sentence([axis, other], &lines, if upwards { ends[0] } else { ends[1] }, upwards))
}

fn line_of(line: &[(f64, f64, bool)], upwards: bool) -> Line {
    let rests = |(_, at, rests): &(f64, f64, bool)| rests.then_some(*at);
    let limit =
        if upwards { line.iter().map_while(rests).last() } else { line.iter().rev().map_while(rests).last() };
    Line { other: line[0].0, limit, is_whole: line.iter().all(|(.., rests)| *rests) }
}

/// The limits of all lines; `start` is the end of the axis at which counting begins.
fn sentence([axis, other]: [&DrawnAxis; 2], lines: &[Line], start: f64, upwards: bool) -> String {
    let on_axis = |value: f64| format!("{} = {}", axis.key, with_unit(value, &axis.unit));
    let on_other = |value: f64| format!("{} = {}", other.key, with_unit(value, &other.unit));
    let up_to = |value: f64| {
        if upwards { format!("up to {}", on_axis(value)) } else { format!("at {} and above", on_axis(value)) }
    };
    // A larger value is farther from the start.
    let reach =
        |line: &Line| line.limit.map_or(f64::NEG_INFINITY, |limit| if upwards { limit } else { -limit });
    let by_reach = |a: &&Line, b: &&Line| reach(a).total_cmp(&reach(b));
    let (Some(least), Some(most)) = (lines.iter().min_by(by_reach), lines.iter().max_by(by_reach)) else {
        return String::new();
    };
    if lines.iter().all(|line| line.is_whole) {
        return "It settles all over the map. ".into();
    }
    let Some(farthest) = most.limit else {
        return format!("It settles at neither end of {}. ", axis.key);
    };
    if reach(least).total_cmp(&reach(most)).is_eq() {
        return format!("It settles {} whatever {} is. ", up_to(farthest), other.key);
    }
    let best = if most.is_whole {
        format!("at every {} {}", axis.key, where_whole(lines, on_other))
    } else {
        format!("{} at {}", up_to(farthest), on_other(most.other))
    };
    match least.limit {
        Some(limit) => format!("It settles {} whatever {} is, and {best}. ", up_to(limit), other.key),
        None => {
            format!("It settles {best}, but not even at {} with {}. ", on_axis(start), on_other(least.other))
        }
    }
}

/// The values of the other axis for which every value of the first axis settles.
fn where_whole(lines: &[Line], on_other: impl Fn(f64) -> String) -> String {
    let whole: Vec<usize> = (0..lines.len()).filter(|&i| lines[i].is_whole).collect();
    let [first, last] = [whole[0], whole[whole.len() - 1]];
    let (from, to) = (on_other(lines[first].other), on_other(lines[last].other));
    if last - first + 1 != whole.len() || first == last {
        format!("with {from}")
    } else if last + 1 == lines.len() {
        format!("at {from} and above")
    } else if first == 0 {
        format!("up to {to}")
    } else {
        format!("from {from} to {to}")
    }
}

/// A random number of a sweep, and the numbers of variants that rest below and above the middle of its
/// values.
pub(super) struct Halves {
    pub(super) key: String,
    unit: String,
    middle: f64,
    below: f64,
    above: f64,
    /// Ratio of the difference of shares to its standard deviation by chance.
    weight: f64,
}

impl Halves {
    /// Counts on both sides of the middle; `None` if fewer than two variants have a value and an outcome.
    pub(super) fn of(key: &str, unit: &str, points: impl Iterator<Item = (f64, bool)>) -> Option<Self> {
        let mut points: Vec<(f64, bool)> = points.collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (low, high) = points.split_at(points.len() / 2);
        let middle = high.first().filter(|_| !low.is_empty())?.0;
        let share =
            |half: &[(f64, bool)]| half.iter().filter(|(_, rests)| *rests).count() as f64 / half.len() as f64;
        let (below, above) = (share(low), share(high));
        let all = share(&points);
        let by_chance = (all * (1.0 - all) * (1.0 / low.len() as f64 + 1.0 / high.len() as f64)).sqrt();
        let weight = if by_chance > 0.0 { (above - below).abs() / by_chance } else { 0.0 };
        Some(Self { key: key.into(), unit: unit.into(), middle, below, above, weight })
    }

    /// Cells of a table: the number, its middle, and the shares on both sides in percent.
    pub(super) fn cells(&self) -> Vec<String> {
        let share = |share: f64| format!("{} %", percent(share));
        vec![self.key.clone(), with_unit(self.middle, &self.unit), share(self.below), share(self.above)]
    }
}

/// Sorts so that the number with the strongest effect comes first.
pub(super) fn by_weight(mut halves: Vec<Halves>) -> Vec<Halves> {
    halves.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    halves
}

/// Names the number with the strongest effect, the first in the list.
pub(super) fn decisive(halves: &[Halves]) -> Option<String> {
    let first = halves.first()?;
    if first.weight < DEVIATIONS {
        return Some("No number of these decides by itself whether it settles. ".into());
    }
    let (key, middle) = (&first.key, with_unit(first.middle, &first.unit));
    let (below, above) = (percent(first.below), percent(first.above));
    Some(format!("{key} matters most: below {middle}, {below} % settle; above it, {above} %. "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(key: &str) -> DrawnAxis {
        DrawnAxis { key: key.into(), unit: String::new(), range: [1.0, 4.0], points: Some(4), log: false }
    }

    /// The answer if `rests` says whether a variant rests, from damping and gain of 1 to 4.
    fn told(rests: impl Fn(i32, i32) -> Option<bool>) -> String {
        let points: Vec<([f64; 2], Option<bool>)> = (1..=4)
            .flat_map(|damping| (1..=4).map(move |gain| (damping, gain)))
            .map(|(damping, gain)| ([f64::from(damping), f64::from(gain)], rests(damping, gain)))
            .collect();
        over_two([&axis("springs.mount.damping"), &axis("controllers.force.kp")], &points).unwrap()
    }

    #[test]
    fn truth_a_map_says_up_to_which_gain_it_settles() {
        type Rests = fn(i32, i32) -> Option<bool>;
        let cases: [(Rests, &str); 8] = [
            (|d, k| Some(k <= d), "up to GAIN = 1 whatever DAMPING is, and at every GAIN with DAMPING = 4"),
            (
                |d, k| Some(d >= 3 || k <= 2),
                "up to GAIN = 2 whatever DAMPING is, and at every GAIN at DAMPING = 3 and above",
            ),
            (|_, k| (k != 3).then_some(k < 3), "up to GAIN = 2 whatever DAMPING is"),
            (
                |d, k| Some(d > 1 && k < 4),
                "up to GAIN = 3 at DAMPING = 4, but not even at GAIN = 1 with DAMPING = 1",
            ),
            (|_, k| Some(k >= 3), "at GAIN = 3 and above whatever DAMPING is"),
            (|_, k| Some(k == 2), "at neither end of GAIN"),
            (|_, _| Some(true), "all over the map"),
            (|_, _| None, "nowhere on the map"),
        ];
        for (rests, where_it_does) in cases {
            let named = where_it_does.replace("GAIN", "controllers.force.kp");
            let named = named.replace("DAMPING", "springs.mount.damping");
            assert_eq!(told(rests), format!("It settles {named}. "));
        }
    }

    #[test]
    fn truth_random_axes_have_no_line_and_adaptive_ones_only_whole_lines() {
        let random = DrawnAxis { points: None, ..axis("x") };
        assert!(over_two([&random, &axis("y")], &[([1.0, 1.0], Some(true))]).is_none());
        // A line with a single variant beside an edge does not show the values below it.
        let points = [
            ([1.0, 1.0], Some(true)),
            ([1.0, 4.0], Some(false)),
            ([2.0, 3.0], Some(false)),
            ([4.0, 1.0], Some(true)),
            ([4.0, 4.0], Some(false)),
        ];
        let told = over_two([&axis("x"), &axis("y")], &points).unwrap();
        assert_eq!(told, "It settles up to y = 1 whatever x is. ");
    }

    /// Only one of two numbers decides.
    #[test]
    fn truth_the_number_that_decides_is_named() {
        let points = |of: fn(i32) -> f64| (0..64).map(move |i| (of(i), i < 32));
        let gain = Halves::of("kp", "", points(f64::from)).unwrap();
        let mass = Halves::of("mass", "kg", points(|i| f64::from(i % 32))).unwrap();
        assert_eq!(gain.cells(), ["kp", "32", "100.0 %", "0.0 %"]);
        let both = by_weight(vec![mass, gain]);
        let told = decisive(&both).unwrap();
        assert_eq!(told, "kp matters most: below 32, 100.0 % settle; above it, 0.0 %. ");
        assert_eq!(both[1].key, "mass");
        let told = decisive(&both[1..]).unwrap();
        assert!(told.starts_with("No number"), "{told}");
        assert!(Halves::of("kp", "", std::iter::once((1.0, true))).is_none());
    }
}
