//! The axes of a sweep, for maps and diagrams.

use feeler_files::{Sampling, Setting, SweepAxis, SweepFile};

/// An axis that can be drawn: its numbers rise evenly or by a ratio, or are a list.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnAxis {
    pub key: String,
    /// SI unit; empty for a number without one.
    pub unit: String,
    /// First and last value.
    pub range: [f64; 2],
    /// Values of a grid; `None` if they are drawn at random.
    pub points: Option<u64>,
    /// Whether the values are spaced by ratio.
    pub log: bool,
}

impl DrawnAxis {
    /// Every axis of a sweep over numbers, in the order of the file. Lists are excluded, since their values
    /// need not be in order.
    pub fn of(sweep: &SweepFile) -> Vec<Self> {
        let drawn = |(key, axis): (&String, &SweepAxis)| {
            let (range, points, log) = match *axis {
                SweepAxis::Linear { from, to, points } if points > 1 => ([from, to], Some(points), false),
                SweepAxis::Log { from, to, points } if points > 1 => ([from, to], Some(points), true),
                SweepAxis::Uniform { from, to } => ([from, to], None, false),
                SweepAxis::LogUniform { from, to } => ([from, to], None, true),
                SweepAxis::Linear { .. } | SweepAxis::Log { .. } | SweepAxis::List(_) => return None,
            };
            Some(Self {
                key: key.clone(),
                unit: sweep.units.get(key).cloned().unwrap_or_default(),
                range,
                points,
                log,
            })
        };
        sweep.axes.iter().filter_map(drawn).collect()
    }

    /// Position of a value between the ends, 0 to 1.
    pub fn share(&self, value: f64) -> f64 {
        share_between(self.range, self.log, value)
    }

    /// The value at a share of the way.
    pub fn value(&self, share: f64) -> f64 {
        let [from, to] = self.range;
        if self.log { from * (to / from).powf(share) } else { from + share * (to - from) }
    }

    /// Index of the last value of a grid, in the finest steps of an adaptive sweep; `None` if the values are
    /// drawn at random.
    pub(crate) fn last_index(&self, sweep: &SweepFile) -> Option<u64> {
        self.points.map(|points| (points - 1) * self.stride(sweep))
    }

    /// Distance of values of the coarsest grid, in the finest steps of an adaptive sweep.
    pub fn stride(&self, sweep: &SweepFile) -> u64 {
        let index = sweep.axes.get_index_of(&self.key).unwrap_or_default();
        sweep.refine.map_or(1, |refine| refine.stride(index))
    }

    /// `count` values at even distances, ends included.
    pub fn values(&self, count: usize) -> Vec<f64> {
        (0..count).map(|i| self.value(i as f64 / count.saturating_sub(1).max(1) as f64)).collect()
    }
}

/// A setting as in tables.
pub fn shown(setting: &Setting) -> String {
    match setting {
        Setting::Number(value) => value.to_string(),
        Setting::Text(text) => text.clone(),
        Setting::Flag(flag) => flag.to_string(),
    }
}

/// Position of a value between the ends of a range, 0 to 1: by ratio if `log`.
pub fn share_between([from, to]: [f64; 2], log: bool, value: f64) -> f64 {
    if log { (value / from).ln() / (to / from).ln() } else { (value - from) / (to - from) }
}

/// Combinations of values, each with its own map or diagram. Their axes are lists, or follow the first two
/// numeric axes of a grid.
#[derive(Clone, Debug)]
pub struct Panels<'a> {
    axes: Vec<(&'a String, &'a SweepAxis)>,
}

impl<'a> Panels<'a> {
    /// The panels of a sweep.
    pub fn of(sweep: &'a SweepFile) -> Self {
        let drawn: Vec<String> = DrawnAxis::of(sweep).into_iter().take(2).map(|axis| axis.key).collect();
        let is_grid = sweep.sampling == Sampling::Grid;
        let apart = |(key, axis): &(&String, &SweepAxis)| {
            matches!(axis, SweepAxis::List(_)) || (is_grid && !drawn.contains(key))
        };
        Self { axes: sweep.axes.iter().filter(apart).collect() }
    }

    /// Whether a key has one value in each panel.
    pub fn has(&self, key: &str) -> bool {
        self.axes.iter().any(|(axis, _)| *axis == key)
    }

    /// Number of panels; one if no axis is separate.
    pub fn count(&self) -> u64 {
        self.axes.iter().filter_map(|(_, axis)| axis.count()).product()
    }

    /// The settings of each, in order of the variants.
    pub fn settings(&self) -> impl Iterator<Item = Vec<(String, Setting)>> {
        (0..self.count()).map(|panel| {
            let mut rest = panel;
            // The last axis runs fastest.
            let mut settings: Vec<(String, Setting)> = (self.axes.iter().rev())
                .map(|(key, axis)| {
                    let count = axis.count().unwrap_or(1);
                    let setting = axis.point(rest % count);
                    rest /= count;
                    ((*key).clone(), setting)
                })
                .collect();
            settings.reverse();
            settings
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(text: &str) -> SweepFile {
        let place = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios"))
            .join("sweeps/panels.toml");
        SweepFile::parse(&format!("scenario = \"../paper/rigid.toml\"\n{text}"), &place.display().to_string())
            .unwrap()
    }

    #[test]
    fn truth_a_grid_has_a_panel_for_each_value_beyond_two_axes() {
        let three = "[axes]\n\"run.seed\" = [1, 2]\n\"controllers.force.kp\" = { linear = [0.1, 1.0], \
                     points = 4 }\n\
            \"contacts.tool.stiffness\" = { log = [1e4, 1e6], points = 5 }\n\"bodies.motor.mass\" = { \
            linear = [10.0, 12.0], points = 3 }\n";
        let file = sweep(three);
        let panels = Panels::of(&file);
        let found: Vec<Vec<(String, Setting)>> = panels.settings().collect();
        assert_eq!((panels.count(), found.len()), (6, 6));
        let number = |key: &str, value| (key.to_owned(), Setting::Number(value));
        assert_eq!(found[1], [number("run.seed", 1.0), number("bodies.motor.mass", 11.0)]);
        let drawn = sweep(
            "samples = 9\n[axes]\n\"controllers.force.kp\" = { uniform = [0.1, 1.0] }\n\"run.seed\" = [1, \
             2]\n",
        );
        assert!(Panels::of(&drawn).has("run.seed") && !Panels::of(&drawn).has("controllers.force.kp"));
    }
}
