//! Runs the diagnosis over a folder of cases with known truth and says, case by case and in sum, what it got right.
//!
//! `cargo run --release --example score -- FOLDER [CASE ...] [--hold-back]`; the folder holds one dataset per case and a `truth.json`. With
//! `--hold-back` the last check experiment is kept from the diagnosis, and what it claims to close is held against what closes there.
#![expect(clippy::print_stdout, reason = "a table is what this example is for")]

use std::path::Path;
use std::time::Instant;

use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::report::Verdict;
use feeler_diagnosis::{Diagnosis, closing, diagnose};
use serde::Deserialize;
use std::collections::BTreeMap;

#[derive(Deserialize)]
struct Case {
    case: String,
    effects: Vec<Effect>,
}

#[derive(Deserialize)]
struct Effect {
    kind: String,
    place: String,
    parameters: BTreeMap<String, f64>,
    #[serde(default)]
    outside_library: bool,
}

#[derive(Default)]
struct Tally {
    right: usize,
    of: usize,
}

impl Tally {
    fn add(&mut self, right: bool) -> &'static str {
        self.of += 1;
        self.right += usize::from(right);
        if right { "ok" } else { "MISS" }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().ok_or("name a folder of cases")?;
    let (flags, only): (Vec<String>, Vec<String>) = arguments.partition(|argument| argument.starts_with("--"));
    let hold_back = flags.iter().any(|flag| flag == "--hold-back");
    let truth: Vec<Case> = serde_json::from_str(&std::fs::read_to_string(Path::new(&folder).join("truth.json"))?)?;
    let mut table: BTreeMap<&str, Tally> = BTreeMap::new();
    let (mut errors, mut closed, mut times, mut apart) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for case in truth.iter().filter(|case| only.is_empty() || only.iter().any(|name| case.case.ends_with(name.as_str()))) {
        let begun = Instant::now();
        let mut dataset = Dataset::load(&Path::new(&folder).join(&case.case))?;
        let last = dataset.records.iter().rposition(|record| record.is_check).filter(|_| hold_back);
        let held = last.map(|i| {
            let record = dataset.records.remove(i);
            Dataset { records: vec![record], ..dataset.clone() }
        });
        let answer = diagnose(&dataset, &|_| {})?;
        let seconds = begun.elapsed().as_secs_f64();
        times.push(seconds);
        let accepted: Vec<_> = answer.effects.iter().filter(|effect| effect.accepted).collect();
        let marks = judge(case, &answer, &mut table, &mut errors);
        if !case.effects.is_empty() && !case.effects[0].outside_library {
            closed.push(answer.gap.closed);
            let truth = held.as_ref().and_then(|held| closing(held, &answer.calibrated, &answer.machine));
            apart.extend(truth.map(|truth| (truth - answer.gap.closed).abs()));
        }
        let said: Vec<String> = accepted
            .iter()
            .map(|e| {
                let values: Vec<String> = e.parameters.iter().map(|(k, v)| format!("{k} {:.4e}", v.value)).collect();
                format!("{} p={:.2} ({})", e.kind, e.probability, values.join(", "))
            })
            .collect();
        let rivals: Vec<String> = answer
            .attempts
            .iter()
            .take(if only.len() == 1 { 40 } else { 3 })
            .map(|a| format!("{} {:.0}/{:.0} ({})", a.causes, a.gain_check, a.gain_all, a.why))
            .collect();
        let kinds: Vec<&str> = case.effects.iter().map(|e| e.kind.as_str()).collect();
        let g = answer.gap;
        println!(
            "{} {marks} truth [{}] {:?} [{}] gap {:.4} {:.4} {:.4} {:.4} closed {:.3} alike {:?} {seconds:.0} s\n      where {:?}\n      tried {}",
            case.case,
            kinds.join(", "),
            answer.verdict,
            said.join("; "),
            g.before,
            g.refit,
            g.after,
            g.floor,
            g.closed,
            answer.look_alikes,
            answer.places.iter().map(|p| format!("{} {:.2} {}", p.place, p.probability, p.evidence)).collect::<Vec<_>>(),
            rivals.join(" | "),
        );
    }
    for (what, tally) in &table {
        println!("{what:32} {:3} of {:3}", tally.right, tally.of);
    }
    for (what, mut values) in [
        ("parameter error, median", errors),
        ("closed, median", closed),
        ("claimed less true closing, median", apart),
        ("wall time, median, s", times),
    ] {
        values.sort_by(f64::total_cmp);
        if let Some(median) = values.get(values.len() / 2) {
            println!("{what:32} {median:.4}");
        }
    }
    Ok(())
}

fn judge(case: &Case, answer: &Diagnosis, table: &mut BTreeMap<&'static str, Tally>, errors: &mut Vec<f64>) -> String {
    let accepted: Vec<_> = answer.effects.iter().filter(|effect| effect.accepted).collect();
    let mut mark = |what: &'static str, right: bool| format!("{what}: {}", table.entry(what).or_default().add(right));
    let place = answer.places.first().map(|p| p.place);
    let mut marks = Vec::new();
    match case.effects.as_slice() {
        [] => marks.push(mark("no false alarm", answer.verdict == Verdict::NoGap)),
        [one] if one.outside_library => {
            marks
                .push(mark("outside library refused, place", answer.verdict == Verdict::UnknownCause && place == Some(one.place.as_str())));
        }
        [one] => {
            let first = accepted.first();
            let alike = answer.look_alikes.iter().flatten().any(|kind| *kind == one.kind);
            marks.push(mark("place right", place == Some(one.place.as_str())));
            marks.push(mark("kind right", first.is_some_and(|e| e.kind == one.kind)));
            marks.push(mark("kind right or look-alike", first.is_some_and(|e| e.kind == one.kind) || alike));
        }
        several => {
            marks.push(mark("both found", several.iter().all(|truth| accepted.iter().any(|e| e.kind == truth.kind))));
        }
    }
    for truth in &case.effects {
        if let Some(found) = accepted.iter().find(|e| e.kind == truth.kind) {
            for (name, value) in truth.parameters.iter().filter(|(name, _)| *name != "phase") {
                if let Some(estimate) = found.parameters.get(name.as_str()) {
                    errors.push((estimate.value / value - 1.0).abs());
                }
            }
        }
    }
    marks.join(", ")
}
