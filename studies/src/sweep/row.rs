//! One row per variant.

use indexmap::IndexMap;

use super::table::{SweepColumn, SweepTable};
use crate::run::{Measured, Summary};
use feeler_files::{Setting, SweepAxis, SweepFile};

/// The result of a variant with its settings.
#[derive(Clone, Debug)]
pub(super) struct VariantRow {
    pub(super) variant: u64,
    pub(super) settings: Vec<Setting>,
    pub(super) result: Result<Measured, String>,
}

/// A measure: its name in files, and its function of a summary.
type Measure = (&'static str, fn(&Summary) -> Option<f64>);

/// All numeric measures.
const MEASURES: &[Measure] = &[
    ("peak_force_n", |s| Some(s.peak_force_n)),
    ("overshoot", |s| s.overshoot),
    ("settling_time_s", |s| s.settling_time_s),
    ("steady_error_n", |s| s.response.and_then(|r| r.steady_error_n)),
    ("bounces", |s| Some(s.bounces as f64)),
    ("first_contact_s", |s| s.main_contact.and_then(|i| s.contacts[i].first_contact_s)),
    ("contact_time_s", |s| Some(s.contact_time_s)),
    ("contact_share", |s| Some(s.contact_share)),
    ("saturation_share", |s| Some(s.saturation_share)),
    ("frequency_hz", |s| s.oscillation.map(|o| o.frequency_hz)),
    ("amplitude_n", |s| s.oscillation.map(|o| o.amplitude_n)),
    ("spectral_hz", |s| s.oscillation.and_then(|o| o.spectral_hz)),
    ("spectral_amplitude_n", |s| s.oscillation.and_then(|o| o.spectral_amplitude_n)),
    ("impacts_per_s", |s| s.oscillation.map(|o| o.impacts_per_s)),
    ("impacts_per_period", |s| s.oscillation.and_then(|o| o.impacts_per_period).map(|n| n as f64)),
    ("chatter_contact_share", |s| s.oscillation.map(|o| o.contact_share)),
    ("growth_per_s", |s| s.verdict.growth_per_s),
    ("first_amplitude_n", |s| Some(s.verdict.amplitudes_n[0])),
    ("middle_amplitude_n", |s| Some(s.verdict.amplitudes_n[1])),
    ("last_amplitude_n", |s| Some(s.verdict.amplitudes_n[2])),
    ("simulated_s", |s| Some(s.simulated_s)),
];

pub(super) fn table(sweep: &SweepFile, rows: &[VariantRow]) -> SweepTable {
    let mut columns = IndexMap::new();
    columns.insert(
        "variant".to_owned(),
        SweepColumn::Whole(rows.iter().map(|row| row.variant.cast_signed()).collect()),
    );
    for (i, (key, axis)) in sweep.axes.iter().enumerate() {
        columns.insert(key.clone(), axis_column(axis, rows.iter().map(|row| &row.settings[i])));
    }
    let summary = |row: &VariantRow| row.result.as_ref().ok().map(|measured| measured.summary.clone());
    let summaries: Vec<Option<Summary>> = rows.iter().map(summary).collect();
    if sweep.keep.outcome {
        let outcome = summaries.iter().map(|s| s.as_ref().map(|s| s.outcome.name().to_owned()));
        columns.insert("outcome".to_owned(), SweepColumn::Text(outcome.collect()));
        let undecided =
            summaries.iter().map(|s| s.as_ref()?.verdict.undecided.map(|why| why.name().to_owned()));
        columns.insert("undecided".to_owned(), SweepColumn::Text(undecided.collect()));
        for (name, of) in MEASURES {
            let values = summaries.iter().map(|s| s.as_ref().and_then(of).filter(|value| value.is_finite()));
            columns.insert((*name).to_owned(), SweepColumn::Real(values.collect()));
        }
    }
    if sweep.keep.tail > 0 {
        let lists = |of: fn(&Measured) -> &Vec<f64>| {
            SweepColumn::List(
                rows.iter()
                    .map(|row| {
                        row.result.as_ref().map_or_else(|_| Vec::new(), |measured| of(measured).clone())
                    })
                    .collect(),
            )
        };
        columns.insert("impact_peaks_n".to_owned(), lists(|measured| &measured.impact_peaks_n));
        columns.insert("strobe_n".to_owned(), lists(|measured| &measured.strobe_n));
    }
    columns.insert(
        "error".to_owned(),
        SweepColumn::Text(rows.iter().map(|row| row.result.as_ref().err().cloned()).collect()),
    );
    SweepTable { columns, rows: rows.len() }
}

fn axis_column<'a>(axis: &SweepAxis, settings: impl Iterator<Item = &'a Setting>) -> SweepColumn {
    let numeric = match axis {
        SweepAxis::List(values) => values.iter().all(|value| matches!(value, Setting::Number(_))),
        _ => true,
    };
    if numeric {
        let number =
            |setting: &Setting| if let Setting::Number(value) = setting { Some(*value) } else { None };
        return SweepColumn::Real(settings.map(number).collect());
    }
    let text = |setting: &Setting| match setting {
        Setting::Number(value) => value.to_string(),
        Setting::Text(text) => text.clone(),
        Setting::Flag(flag) => flag.to_string(),
    };
    SweepColumn::Text(settings.map(|setting| Some(text(setting))).collect())
}
