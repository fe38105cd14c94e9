//! Text under the pointer on a map or diagram: the variant, and the command that runs it.

use std::collections::BTreeMap;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use feeler_studies::run::Outcome;
use feeler_studies::sweep::{DrawnAxis, SweepColumn};
use serde_json::{Value, json};

use super::palette::{labels, of_outcome};
use super::report::Report;
use crate::terminal;

/// Unit of what is judged, a force or a motion.
const JUDGED: &str = "judged";
/// Measures under the pointer: column, words, unit. `N` stands for the unit of force of the machine.
pub(super) const SHOWN: [(&str, &str, &str); 7] = [
    ("peak_force_n", "peak force", "N"),
    ("settling_time_s", "settling time", "s"),
    ("frequency_hz", "frequency", "Hz"),
    ("amplitude_n", "amplitude", JUDGED),
    ("impacts_per_period", "impacts per period", ""),
    ("chatter_contact_share", "share of time in contact", ""),
    ("growth_per_s", "growth", "1/s"),
];
/// Smallest number of places per distinct value at which a column has the short form: its distinct values,
/// and an index for each place.
const PLACES_PER_VALUE: usize = 4;

impl Report<'_> {
    /// Input of the page's script: the places of the variants, the shown columns (those of the axes first),
    /// and the command.
    pub(super) fn hover(&self, places: &[[f64; 5]]) -> Value {
        let rows: Vec<usize> = places.iter().map(|place| place[4] as usize).collect();
        let of_rows =
            |values: Vec<Option<f64>>| rows.iter().map(|&row| json!(values[row])).collect::<Vec<Value>>();
        let mut columns: Vec<Value> = Vec::new();
        for key in self.sweep.file.axes.keys() {
            // A text includes its unit.
            let (values, unit) = match self.table.columns.get(key) {
                Some(SweepColumn::Text(texts)) => {
                    (rows.iter().map(|&row| json!(texts[row])).collect(), String::new())
                }
                _ => (
                    self.table.reals(key).map(of_rows).unwrap_or_default(),
                    self.sweep.file.units.get(key).cloned().unwrap_or_default(),
                ),
            };
            columns.push(json!([key, packed(values), unit]));
        }
        columns.push(json!([
            "",
            packed(rows.iter().map(|&row| json!(label(&self.outcomes[row]))).collect()),
            ""
        ]));
        for (name, words, unit) in SHOWN {
            let unit = match unit {
                JUDGED => self.judged.1,
                "N" => self.units.force,
                _ => unit,
            };
            let short = |v: f64| format!("{v:.4e}").parse::<f64>().ok();
            if let Some(values) = self.table.reals(name) {
                let values = values.into_iter().map(|value| value.and_then(short)).collect();
                columns.push(json!([words, packed(of_rows(values)), unit]));
            }
        }
        let command = format!("feeler run {} --as-sweep", terminal::quoted_path(&self.sweep.file.scenario));
        let places: Vec<&[f64]> = places.iter().map(|place| &place[..4]).collect();
        let settings = self.sweep.file.axes.len();
        json!({ "places": places, "columns": columns, "settings": settings, "command": command })
    }

    /// Every variant in a panel of a thinned map, for zooming: a byte for each cell, row by row from below,
    /// with colours and words. `null` if all are drawn, or if they are too many for a page.
    pub(super) fn whole(&self, axes: [&DrawnAxis; 2], panel: usize) -> Value {
        let codes = &self.tally.codes;
        if !self.sweep.file.keep.outcome || codes.len() < self.tally.rows {
            return Value::Null;
        }
        let keys = axes.map(|axis| axis.key.as_str());
        let Some(([columns, rows], cells)) = self.drawn.panel(keys, panel as u64, codes) else {
            return Value::Null;
        };
        let (colours, words): (Vec<&str>, Vec<&str>) =
            labels().map(|(name, words)| (of_outcome(name), words)).unzip();
        json!({
            "keys": keys, "columns": columns, "rows": rows, "outcomes": STANDARD.encode(cells),
            "colours": colours, "labels": words,
        })
    }
}

/// An outcome in words.
fn label(name: &str) -> &str {
    let known = Outcome::ALL.iter().find(|(_, known)| *known == name);
    let otherwise = if name == "done" { "done" } else { "failed" };
    known.map_or(otherwise, |(outcome, _)| outcome.words())
}

/// A column; in short form if it has few distinct values.
fn packed(values: Vec<Value>) -> Value {
    let mut different: BTreeMap<String, usize> = BTreeMap::new();
    let mut of: Vec<Value> = Vec::new();
    let mut at: Vec<usize> = Vec::with_capacity(values.len());
    for value in &values {
        let next = of.len();
        let number = *different.entry(value.to_string()).or_insert(next);
        if number == next {
            of.push(value.clone());
        }
        at.push(number);
    }
    if of.len() * PLACES_PER_VALUE > values.len() {
        Value::Array(values)
    } else {
        json!({ "of": of, "at": at })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_packed_columns_hold_the_same_values() {
        let few: Vec<Value> = (0..40).map(|i| json!(f64::from(i % 3) / 7.0)).collect();
        let Value::Object(short) = packed(few.clone()) else {
            panic!("three values in forty places are packed")
        };
        let at = |i: usize| short["at"][i].as_u64().unwrap() as usize;
        assert_eq!((0..40).map(|i| short["of"][at(i)].clone()).collect::<Vec<_>>(), few);
        let many: Vec<Value> = (0..40).map(|i| json!(i)).collect();
        assert_eq!(packed(many.clone()), Value::Array(many));
    }
}
