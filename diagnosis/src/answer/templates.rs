//! Commands of possible next experiments, with the travel and speed that they may cause. Both stay below
//! those of the records.

use std::f64::consts::TAU;

use feeler_plant::description::{Axis, Engagement, Machine};
use feeler_plant::units::Dimension;

use crate::dataset::{Dataset, Record};
use crate::predict::Prediction;

/// Length of a template, s.
pub(crate) const SECONDS: f64 = 2.0;
/// Commands of templates, as shares of the largest recorded one.
const LEVELS: [f64; 3] = [0.05, 0.3, 0.9];
/// Number of lines of a multisine.
const LINES: usize = 24;
/// Permitted share of the records' travel and speed: a prediction that is a quarter too small still stays
/// within the records.
const ALLOWED: f64 = 0.8;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Multisine { low_hz: f64, high_hz: f64 },
    SlowStrokes,
}

/// A possible experiment.
#[derive(Clone, Debug)]
pub(crate) struct Template {
    /// Engagement as stated in the records; `None` for that of the machine file.
    pub(crate) engagement: Option<Engagement>,
    /// The engagement that applies.
    pub(crate) place: Engagement,
    shape: Shape,
    /// Largest command, N.
    pub(crate) peak_n: f64,
    /// A larger command than this is needed, because another template has the same effect below it, N.
    pub(crate) least_n: f64,
    /// Reading of each channel at the start: the first row of the records with this engagement.
    pub(crate) start: Vec<f64>,
}

/// Travel and speed of the first drive's body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reach {
    /// Farthest back and farthest ahead of the start, m.
    pub(crate) travel_m: [f64; 2],
    pub(crate) top_speed_m_per_s: f64,
}

impl Reach {
    /// At rest.
    pub(crate) const NONE: Self = Self { travel_m: [0.0; 2], top_speed_m_per_s: 0.0 };

    pub(crate) fn of(prediction: &Prediction) -> Self {
        let start = prediction.stroke.first().map_or(0.0, |stroke| stroke[0]);
        let reached = |reach: Self, [x, v, _]: &[f64; 3]| Self {
            travel_m: [reach.travel_m[0].min(x - start), reach.travel_m[1].max(x - start)],
            top_speed_m_per_s: reach.top_speed_m_per_s.max(v.abs()),
        };
        prediction.stroke.iter().fold(Self::NONE, reached)
    }

    /// The smallest range that contains both.
    pub(crate) fn with(self, other: Self) -> Self {
        Self {
            travel_m: [self.travel_m[0].min(other.travel_m[0]), self.travel_m[1].max(other.travel_m[1])],
            top_speed_m_per_s: self.top_speed_m_per_s.max(other.top_speed_m_per_s),
        }
    }

    /// Ratio of this range to the permitted share of the range `seen` in the records; at most one is
    /// permitted.
    pub(crate) fn excess(self, seen: Self) -> f64 {
        let over = |own: f64, seen: f64| if own == 0.0 { 0.0 } else { own / (ALLOWED * seen) };
        over(self.travel_m[0], seen.travel_m[0])
            .max(over(self.travel_m[1], seen.travel_m[1]))
            .max(over(self.top_speed_m_per_s, seen.top_speed_m_per_s))
    }
}

impl Template {
    /// The command, N at every row.
    pub(crate) fn command(&self, spacing_s: f64) -> Vec<f64> {
        let rows = (SECONDS / spacing_s).round() as usize;
        let (mean, swing) = self.mean_and_swing();
        let unit = match self.shape {
            Shape::Multisine { low_hz, high_hz } => multisine(rows, spacing_s, low_hz, high_hz),
            Shape::SlowStrokes => (0..rows).map(|k| (TAU * k as f64 * spacing_s).sin()).collect(),
        };
        unit.into_iter().map(|x| mean + swing * x).collect()
    }

    /// Pressing needs a mean force larger than the excitation.
    fn mean_and_swing(&self) -> (f64, f64) {
        if self.place == Engagement::Unilateral {
            (0.6 * self.peak_n, 0.4 * self.peak_n)
        } else {
            (0.0, self.peak_n)
        }
    }

    /// Instructions and expected result, in a sentence.
    pub(crate) fn what(&self, machine: &Machine, reach: Reach, seen: Reach) -> String {
        let unit = |dimension: Dimension| dimension.si_unit(machine.axis == Axis::Rotational);
        let (force, length, speed) =
            (unit(Dimension::FORCE), unit(Dimension::LENGTH), unit(Dimension::VELOCITY));
        let what = match self.shape {
            Shape::Multisine { low_hz, high_hz } => {
                format!("a multisine from {low_hz:.0} to {high_hz:.0} Hz")
            }
            Shape::SlowStrokes => "slow strokes at 1 Hz".to_owned(),
        };
        let mean = match self.mean_and_swing().0 {
            0.0 => String::new(),
            mean => format!(" about a mean of {} {force}", three_digits(mean)),
        };
        let place = match self.place {
            Engagement::Free => "out of contact",
            Engagement::Clamped => "with the tool clamped",
            Engagement::Unilateral => "pressed against the work",
        };
        let moves = |reach: Reach| {
            let [back, ahead] = reach.travel_m;
            let (factor, prefix) = prefix(ahead.max(-back));
            format!("{} to {} {prefix}{length}", three_digits(back * factor), three_digits(ahead * factor))
        };
        let fast = |reach: Reach| {
            let (factor, prefix) = prefix(reach.top_speed_m_per_s);
            format!("{} {prefix}{speed}", three_digits(reach.top_speed_m_per_s * factor))
        };
        format!(
            "{what} with peaks of {} {force}{mean}, {place}: from where the records started it travels {} \
             at up to {}, within what they did \
             ({}, up to {})",
            three_digits(self.peak_n),
            moves(reach),
            fast(reach),
            moves(seen),
            fast(seen)
        )
    }
}

/// Factor that scales a magnitude to between one and a thousand, and the unit prefix.
fn prefix(size: f64) -> (f64, &'static str) {
    match size {
        size if size >= 1.0 => (1.0, ""),
        size if size >= 1e-3 => (1e3, "m"),
        _ => (1e6, "µ"),
    }
}

fn three_digits(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let decimals = (2 - value.abs().log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

pub(crate) fn place_of(dataset: &Dataset, record: &Record) -> Engagement {
    let own = || dataset.machine.contacts.values().next().map(|contact| contact.engagement);
    record.engagement.or_else(own).unwrap_or(Engagement::Free)
}

/// Multisines of three levels in two bands and slow strokes, in free motion; also clamped and in contact if
/// the records have these.
pub(crate) fn templates(dataset: &Dataset, spacing_s: f64) -> Vec<Template> {
    let largest = dataset
        .records
        .iter()
        .flat_map(|record| record.commands.iter().flatten())
        .fold(0.0_f64, |m, u| m.max(u.abs()));
    let top = 0.25 / spacing_s;
    let mut found: Vec<Template> = Vec::new();
    for record in &dataset.records {
        let place = place_of(dataset, record);
        if found.iter().any(|template| template.place == place) {
            continue;
        }
        let bands = [(1.0, 0.04 * top), (0.04 * top, top)]
            .map(|(low_hz, high_hz)| Shape::Multisine { low_hz, high_hz });
        let strokes = (place != Engagement::Clamped).then_some(Shape::SlowStrokes);
        for shape in bands.into_iter().chain(strokes) {
            for (i, level) in LEVELS.into_iter().enumerate() {
                found.push(Template {
                    engagement: record.engagement,
                    place,
                    shape,
                    peak_n: level * largest,
                    least_n: if i == 0 { 0.0 } else { LEVELS[i - 1] * largest },
                    start: record
                        .series
                        .iter()
                        .map(|series| series.first().copied().unwrap_or(0.0))
                        .collect(),
                });
            }
        }
    }
    found
}

/// A multisine of unit peak on a logarithmic grid, phases after Schroeder.
fn multisine(rows: usize, spacing_s: f64, low_hz: f64, high_hz: f64) -> Vec<f64> {
    let line = |i: usize| low_hz * (high_hz / low_hz).powf(i as f64 / (LINES - 1) as f64);
    let phase = |i: usize| -std::f64::consts::PI * (i * i) as f64 / LINES as f64;
    let raw: Vec<f64> = (0..rows)
        .map(|k| (0..LINES).map(|i| (TAU * line(i) * k as f64 * spacing_s + phase(i)).sin()).sum::<f64>())
        .collect();
    let peak = raw.iter().fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs()));
    raw.into_iter().map(|x| x / peak).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEEN: Reach = Reach { travel_m: [-0.05, 0.04], top_speed_m_per_s: 0.2 };

    /// The limit is [`ALLOWED`] of the records, in each direction separately.
    #[test]
    fn truth_the_side_that_is_too_far_or_the_speed_decides() {
        let excess = |back: f64, ahead: f64, speed: f64| {
            Reach { travel_m: [back, ahead], top_speed_m_per_s: speed }.excess(SEEN)
        };
        assert!((excess(-0.01, 0.064, 0.1) - 2.0).abs() < 1e-12);
        assert!((excess(-0.04, 0.0, 0.1) - 1.0).abs() < 1e-12);
        assert!((excess(-0.01, 0.01, 0.48) - 3.0).abs() < 1e-12);
        // Without forward motion in the records, nothing is known about obstacles there.
        let back_only = Reach { travel_m: [-0.05, 0.0], ..SEEN };
        assert!(Reach { travel_m: [0.0, 1e-3], top_speed_m_per_s: 0.0 }.excess(back_only).is_infinite());
        assert!(Reach::NONE.excess(SEEN) <= 0.0);
    }

    #[test]
    fn truth_numbers_have_three_digits_and_a_fitting_unit() {
        assert_eq!(
            [0.0, 12.345, -0.9876, 284.4, 1234.0].map(three_digits),
            ["0", "12.3", "-0.988", "284", "1234"]
        );
        assert_eq!([2.0, 0.05, 2e-6].map(|size| prefix(size).1), ["", "m", "µ"]);
    }
}
