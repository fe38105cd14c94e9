//! Chatter, and limit cycles through saturation, that describing functions predict over one axis, and the
//! difference from the simulation.

use feeler_analysis::LimitCycle;
use feeler_studies::sweep::{CyclesAt, DrawnAxis};

use super::bifurcation::Prediction;
use super::report::Report;
use crate::numbers::{percent, plain};
use crate::pages::parts::Page;

/// Largest number of rows in the table of differences.
const MOST_ROWS: usize = 12;
/// Largest relative difference at which the first harmonic describes the motion.
const AGREES: f64 = 0.1;

/// Predictions at the rows of a sweep over one axis.
pub(super) struct Predicted<'a> {
    report: &'a Report<'a>,
    axis: &'a DrawnAxis,
    /// Predictions by increasing value.
    places: &'a [CyclesAt],
}

/// One variant that chatters or oscillates between limits, in simulation and in theory.
struct Pair {
    at: f64,
    /// Number of impacts per period of the motion; `None` without impacts, or if no two are alike.
    impacts: Option<f64>,
    /// Frequency of impacts: after a period doubling there are two in each period.
    frequency_hz: [f64; 2],
    peak_force_n: [f64; 2],
}

impl<'a> Predicted<'a> {
    pub(super) fn new(report: &'a Report<'a>, axis: &'a DrawnAxis, places: &'a [CyclesAt]) -> Self {
        Self { report, axis, places }
    }

    /// Peak forces over the axis: a line for each run of values with a cycle among `wanted`, either stable or
    /// unstable.
    pub(super) fn peaks(&self, wanted: impl Fn(&LimitCycle) -> bool) -> Vec<Prediction> {
        [true, false]
            .into_iter()
            .flat_map(|stable| self.lines(|cycle| cycle.stable == stable && wanted(cycle), !stable))
            .collect()
    }

    fn lines(&self, wanted: impl Fn(&LimitCycle) -> bool, dashed: bool) -> Vec<Prediction> {
        let mut lines: Vec<Vec<[f64; 2]>> = vec![Vec::new()];
        for CyclesAt { value, cycles, .. } in self.places {
            match cycles.iter().find(|cycle| wanted(cycle)) {
                Some(cycle) => {
                    lines.last_mut().into_iter().for_each(|line| line.push([*value, cycle.peak_force_n]));
                }
                None => lines.push(Vec::new()),
            }
        }
        lines.into_iter().filter(|line| line.len() > 1).map(|line| Prediction { line, dashed }).collect()
    }

    fn pairs(&self) -> Vec<Pair> {
        let column = |name: &str| self.report.table.reals(name).unwrap_or_default();
        let (frequencies, per_period) = (column("frequency_hz"), column("impacts_per_period"));
        let list = |name: &str| self.report.table.lists(name).unwrap_or_default();
        // If the tool stays in contact, the force once per cycle is its maximum.
        let (impacts, cycles_n) = (list("impact_peaks_n"), list("strobe_n"));
        let pair = |CyclesAt { value: at, row, cycles }: &CyclesAt| {
            let cycle = cycles.iter().find(|cycle| cycle.stable)?;
            let peaks = match self.report.outcomes[*row].as_str() {
                "chatter" => impacts,
                "limit-cycle" => cycles_n,
                _ => return None,
            };
            let peak = peaks.get(*row)?.iter().copied().reduce(f64::max)?;
            let frequency = (*frequencies.get(*row)?)?;
            let impacts = per_period.get(*row).copied().flatten();
            Some(Pair {
                at: *at,
                impacts,
                frequency_hz: [impacts.unwrap_or(1.0) * frequency, cycle.frequency_hz],
                peak_force_n: [peak, cycle.peak_force_n],
            })
        };
        self.places.iter().filter_map(pair).collect()
    }

    /// Reports the differences between theory and simulation, under the title of the panel.
    pub(super) fn compare(&self, title: &str, page: &mut Page) {
        let pairs = self.pairs();
        if pairs.is_empty() {
            return;
        }
        page.heading(&if title.is_empty() {
            "Theory beside it".into()
        } else {
            format!("Theory beside it, {title}")
        });
        page.paragraph(&summary(&pairs, &self.axis.key));
        let step = pairs.len().div_ceil(MOST_ROWS);
        let rows = pairs.iter().step_by(step).map(|pair| {
            let mut row = vec![plain(pair.at), pair.impacts.map_or_else(|| "-".to_owned(), plain)];
            for both in [pair.frequency_hz, pair.peak_force_n] {
                row.extend([plain(both[0]), plain(both[1]), percent(departure(both))]);
            }
            row
        });
        let unit = self.report.units.force;
        let peaks = ["simulated", "predicted"].map(|which| format!("{which} peak ({unit})"));
        let header = [
            &self.axis.key,
            "impacts per period",
            "simulated (Hz)",
            "predicted (Hz)",
            "apart (%)",
            &peaks[0],
            &peaks[1],
            "apart (%)",
        ];
        page.table(&header, &[0, 1, 2, 3, 4, 5, 6, 7], &rows.collect::<Vec<_>>());
    }
}

/// Difference of prediction and simulation, relative to the simulation.
fn departure([simulated, predicted]: [f64; 2]) -> f64 {
    predicted / simulated - 1.0
}

fn summary(pairs: &[Pair], key: &str) -> String {
    let of = |pick: fn(&Pair) -> [f64; 2]| -> [f64; 2] {
        let mut sizes: Vec<f64> = pairs.iter().map(|pair| departure(pick(pair)).abs()).collect();
        sizes.sort_by(f64::total_cmp);
        [sizes[sizes.len() / 2], sizes[sizes.len() - 1]]
    };
    let ([frequency, worst_frequency], [peak, worst_peak]) =
        (of(|pair| pair.frequency_hz), of(|pair| pair.peak_force_n));
    let agree = |pair: &&Pair| {
        [pair.frequency_hz, pair.peak_force_n].into_iter().all(|both| departure(both).abs() <= AGREES)
    };
    let agreeing: Vec<f64> = pairs.iter().filter(agree).map(|pair| pair.at).collect();
    let within = percent(AGREES);
    let where_they_agree = match agreeing.as_slice() {
        [] => format!("Nowhere are both within {within} %."),
        [only] => format!("Both are within {within} % at {key} = {} only.", plain(*only)),
        [first, .., last] => {
            format!("Both are within {within} % from {key} = {} to {}.", plain(*first), plain(*last))
        }
    };
    format!(
        "Describing functions replace the force by its mean and first harmonic. They predict a cycle for {} \
         variants that chatter or oscillate between limits. Its frequency is off by {} % in the median (at \
         most {} %), its peak by {} % (at most {} %). {where_they_agree} The longer the tool is away, the \
         more the motion is a series of impacts, of which the first harmonic says little.",
        pairs.len(),
        percent(frequency),
        percent(worst_frequency),
        percent(peak),
        percent(worst_peak),
    )
}
