//! The axes of a sweep: the values of a key.

use feeler_catalogue::{Contents, Slot};
use indexmap::IndexMap;

use super::super::draft::Setting;
use super::super::keys::sweep::{AXES, AXIS_TOLERANCE, POINTS};
use super::super::keys::{AXIS, EXAMPLE_KEY};
use super::super::read::{Reader, join};
use super::super::source::Origin;
use super::super::tree::{Entry, Node, Table, Value};
use super::super::units;

/// Values of an axis, in SI.
#[derive(Clone, Debug, PartialEq)]
pub enum SweepAxis {
    /// Evenly spaced, both ends included.
    Linear { from: f64, to: f64, points: u64 },
    /// With a constant ratio; both ends are included and have the same sign.
    Log { from: f64, to: f64, points: u64 },
    /// The listed values.
    List(Vec<Setting>),
    /// Drawn uniformly.
    Uniform { from: f64, to: f64 },
    /// Drawn with a uniform logarithm.
    LogUniform { from: f64, to: f64 },
}

impl SweepAxis {
    /// Number of values; `None` for a distribution.
    pub fn count(&self) -> Option<u64> {
        match self {
            Self::Linear { points, .. } | Self::Log { points, .. } => Some(*points),
            Self::List(values) => Some(values.len() as u64),
            Self::Uniform { .. } | Self::LogUniform { .. } => None,
        }
    }

    /// The value at `share` of the axis, from 0 to 1; for a list, the value whose slice contains `share`.
    pub fn at(&self, share: f64) -> Setting {
        let ratio = |from: f64, to: f64| from * (to / from).powf(share);
        match self {
            Self::Linear { from, to, .. } | Self::Uniform { from, to } => {
                Setting::Number(from + share * (to - from))
            }
            Self::Log { from, to, .. } | Self::LogUniform { from, to } => Setting::Number(ratio(*from, *to)),
            Self::List(values) => {
                values[((share * values.len() as f64) as usize).min(values.len() - 1)].clone()
            }
        }
    }

    /// The value of a grid at `index`, which is below [`SweepAxis::count`]. The first and the last are
    /// exactly those in the file.
    pub fn point(&self, index: u64) -> Setting {
        match self {
            Self::List(values) => values[(index as usize).min(values.len() - 1)].clone(),
            Self::Linear { to, points, .. } | Self::Log { to, points, .. }
                if index > 0 && index + 1 >= *points =>
            {
                Setting::Number(*to)
            }
            Self::Log { from, .. } if index == 0 => Setting::Number(*from),
            // A weighted sum is an integer for integer steps between integer ends.
            Self::Linear { from, to, points } => {
                let (steps, after) = ((points.max(&2) - 1) as f64, index as f64);
                Setting::Number((from * (steps - after) + to * after) / steps)
            }
            Self::Log { points, .. } => self.at(index as f64 / (points.max(&2) - 1) as f64),
            Self::Uniform { .. } | Self::LogUniform { .. } => self.at(0.5),
        }
    }
}

/// An axis as read, with data for its refinement.
#[derive(Clone, Debug)]
pub(super) struct ReadAxis {
    pub(super) axis: SweepAxis,
    /// Tolerance of an edge as a share of the axis, and its place in the file.
    pub(super) tolerance: Option<(f64, Origin)>,
}

pub(super) fn read_axes(reader: &mut Reader<'_>, root: &Table) -> IndexMap<String, ReadAxis> {
    let remedy =
        format!("add [axes] with lines such as \"{EXAMPLE_KEY}\" = {{ log = [0.05, 5.0], points = 64 }}");
    let mut axes = IndexMap::new();
    let Some(node) = reader.problems.required(root, AXES, &remedy) else { return axes };
    let table = reader.problems.table(node, AXES, format!("write [{AXES}]"));
    if table.is_some_and(Table::is_empty) {
        reader.problems.add(&node.origin, AXES, "there are no axes", remedy);
    }
    for (key, entry) in table.into_iter().flatten() {
        if let Some(axis) = read_axis(reader, key, entry) {
            axes.insert(key.clone(), axis);
        }
    }
    axes
}

fn read_axis(reader: &mut Reader<'_>, key: &str, entry: &Entry) -> Option<ReadAxis> {
    let path = join(AXES, &format!("\"{key}\""));
    let node = &entry.node;
    let table = match &node.value {
        Value::Array(items) => {
            return read_list(reader, items, node, &path).map(|axis| ReadAxis { axis, tolerance: None });
        }
        Value::Table(table) => table,
        _ => {
            let remedy = "write [...], or { linear = [from, to], points = n }";
            reader.problems.mistyped(node, &path, "a list or a table", remedy);
            return None;
        }
    };
    // An unquoted dotted key is read as nested tables.
    if table.values().all(|entry| entry.node.as_table().is_some()) && !table.is_empty() {
        reader.problems.add(
            &entry.key,
            path,
            "an axis's key needs quotes",
            format!("write \"{EXAMPLE_KEY}\" = {{ ... }}"),
        );
        return None;
    }
    let fields = reader.fields(&AXIS, &[], table, &node.origin, &path);
    let variant = fields.variant?;
    let [from, to] = fields.get(variant).and_then(<[f64; 2]>::of)?;
    check_ends(reader, node, &path, variant, [from, to])?;
    let tolerance = axis_tolerance(reader, table, &path, &fields, [from, to]);
    if let Some((written, 1)) = table.get(POINTS.name).zip(fields.value::<u64>(&POINTS))
        && (to - from).abs() > 0.0
    {
        let remedy = format!(
            "write `{} = 2` or more, or a list of the value that is meant, as in [{from}]",
            POINTS.name
        );
        reader.problems.add(
            &written.node.origin,
            join(&path, POINTS.name),
            format!("with one point the end, {to}, is left out"),
            remedy,
        );
    }
    // Missing or wrong points are already recorded; the ends are still tried.
    let points = fields.value(&POINTS).unwrap_or(1);
    let axis = match variant {
        "linear" => SweepAxis::Linear { from, to, points },
        "log" => SweepAxis::Log { from, to, points },
        "uniform" => SweepAxis::Uniform { from, to },
        _ => SweepAxis::LogUniform { from, to },
    };
    Some(ReadAxis { axis, tolerance })
}

/// Whether a spacing or distribution is possible between two ends; otherwise records the reason.
fn check_ends(
    reader: &mut Reader<'_>,
    node: &Node,
    path: &str,
    variant: &str,
    [from, to]: [f64; 2],
) -> Option<()> {
    if is_ratio(variant) && from * to <= 0.0 {
        let remedy = "give two numbers of the same sign, or a linear axis";
        reader.problems.add(&node.origin, path, format!("from {from} to {to} there is no ratio"), remedy);
        return None;
    }
    if variant.ends_with("uniform") && from >= to {
        let remedy = if from > to {
            format!("write [{to}, {from}]")
        } else {
            format!("write a list of the value that is meant, as in [{from}]")
        };
        reader.problems.add(
            &node.origin,
            join(path, variant),
            format!("from {from} to {to} there is nothing to draw from"),
            remedy,
        );
        return None;
    }
    Some(())
}

/// Whether the values of a kind of axis have a constant ratio.
fn is_ratio(variant: &str) -> bool {
    variant.starts_with("log")
}

/// Tolerance of edges on an axis, as a share of it, and its place in the file.
fn axis_tolerance(
    reader: &mut Reader<'_>,
    table: &Table,
    path: &str,
    fields: &Contents,
    [from, to]: [f64; 2],
) -> Option<(f64, Origin)> {
    let variant = fields.variant?;
    let ratio = is_ratio(variant);
    let written = &table.get(AXIS_TOLERANCE.name)?.node;
    let tolerance: f64 = fields.value(&AXIS_TOLERANCE)?;
    if !alike(written, if ratio { None } else { first_end(table, variant) }) {
        let [message, remedy] = if ratio {
            [
                "on an axis of equal ratios a tolerance is a ratio",
                "write a plain number or per cent, as in \"2 %\"",
            ]
        } else {
            [
                "this is of another kind than the ends of the axis",
                "write the tolerance with a unit such as the ends have",
            ]
        };
        reader.problems.add(&written.origin, join(path, AXIS_TOLERANCE.name), message, remedy);
        return None;
    }
    let share =
        if ratio { tolerance.ln_1p() / (to / from).ln().abs() } else { tolerance / (to - from).abs() };
    Some((share, written.origin.clone()))
}

fn first_end<'a>(table: &'a Table, variant: &str) -> Option<&'a Node> {
    if let Value::Array(ends) = &table.get(variant)?.node.value { ends.first() } else { None }
}

/// Whether two quantities, one of them perhaps a plain number, have the same bases.
fn alike(one: &Node, other: Option<&Node>) -> bool {
    let text = |node: Option<&Node>| node.and_then(Node::as_text).unwrap_or("1").to_owned();
    units::are_alike(&text(Some(one)), &text(other))
}

fn read_list(reader: &mut Reader<'_>, items: &[Node], node: &Node, path: &str) -> Option<SweepAxis> {
    if items.is_empty() {
        reader.problems.add(&node.origin, path, "the list is empty", "give at least one value");
        return None;
    }
    // All items are checked, and the valid ones are tried, so that every mistake is reported.
    let values = items.iter().filter_map(|item| {
        let value = setting(item);
        if value.is_none() {
            let message = format!("an axis has no {}", item.value.kind().trim_start_matches("a "));
            reader.problems.add(&item.origin, path, message, "give numbers, texts with units, or words");
        }
        value
    });
    let values: Vec<Setting> = values.collect();
    (!values.is_empty()).then_some(SweepAxis::List(values))
}

/// A value as written.
pub(super) fn setting(item: &Node) -> Option<Setting> {
    match &item.value {
        Value::Float(value) => Some(Setting::Number(*value)),
        Value::Integer(value) => Some(Setting::Number(*value as f64)),
        Value::Text(text) => Some(Setting::Text(text.clone())),
        Value::Flag(flag) => Some(Setting::Flag(*flag)),
        Value::Date | Value::Array(_) | Value::Table(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_whole_steps_between_whole_ends_are_whole() {
        let seeds = SweepAxis::Linear { from: 1.0, to: 300.0, points: 300 };
        assert!((0..300).all(|i| seeds.point(i) == Setting::Number((i + 1) as f64)));
    }
}
