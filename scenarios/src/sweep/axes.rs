//! What the axes of a sweep are, for maps and diagrams.

use feeler_plant::effects;

use crate::format::{Axis, Setting, SweepFile, unit_of_key};

/// An axis that can be drawn: its numbers rise evenly, by ratio, or are a list.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnAxis {
    /// Key path.
    pub key: String,
    /// SI unit; empty for a number without one.
    pub unit: String,
    /// Ends.
    pub range: [f64; 2],
    /// Values of a grid; none where they are drawn at random.
    pub points: Option<u64>,
    /// By ratio.
    pub log: bool,
}

impl DrawnAxis {
    /// Every axis of a sweep that runs over numbers, in order of the file. A list is none, since its values need not be in order.
    pub fn of(sweep: &SweepFile) -> Vec<Self> {
        let drawn = |(key, axis): (&String, &Axis)| {
            let (range, points, log) = match *axis {
                Axis::Linear { from, to, points } if points > 1 => ([from, to], Some(points), false),
                Axis::Log { from, to, points } if points > 1 => ([from, to], Some(points), true),
                Axis::Uniform { from, to } => ([from, to], None, false),
                Axis::LogUniform { from, to } => ([from, to], None, true),
                _ => return None,
            };
            Some(Self { key: key.clone(), unit: unit_of_key(key), range, points, log })
        };
        sweep.axes.iter().filter_map(drawn).collect()
    }

    /// Where a value lies between the ends, 0 to 1.
    pub fn share(&self, value: f64) -> f64 {
        let [from, to] = self.range;
        if self.log { (value / from).ln() / (to / from).ln() } else { (value - from) / (to - from) }
    }

    /// The value at a share of the way.
    pub fn value(&self, share: f64) -> f64 {
        let [from, to] = self.range;
        if self.log { from * (to / from).powf(share) } else { from + share * (to - from) }
    }

    /// So many values at even distances, ends included.
    pub fn values(&self, count: usize) -> Vec<f64> {
        (0..count).map(|i| self.value(i as f64 / count.saturating_sub(1).max(1) as f64)).collect()
    }
}

/// Combinations of the axes that are lists, each with the settings that choose it: a map is drawn for each. One empty one where there are no lists.
pub fn panels(sweep: &SweepFile) -> Vec<Vec<(String, Setting)>> {
    let lists = sweep.axes.iter().filter_map(|(key, axis)| if let Axis::List(values) = axis { Some((key, values)) } else { None });
    let mut panels = vec![Vec::new()];
    for (key, values) in lists {
        let with = |panel: &Vec<(String, Setting)>| {
            let panel = panel.clone();
            values.iter().map(move |value| panel.iter().cloned().chain([(key.clone(), value.clone())]).collect()).collect::<Vec<_>>()
        };
        panels = panels.iter().flat_map(with).collect();
    }
    panels
}

/// The unit of an effect's parameter by its key path.
pub(crate) fn unit_of_effect(kind: &str, parameter: &str) -> Option<&'static str> {
    let parameter = effects::find(kind)?.parameters.iter().find(|known| known.name == parameter)?;
    Some(parameter.dimension.si_unit(false))
}
