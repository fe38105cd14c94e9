//! A diagnosis: which effects of its machine does a machine file lack?
//!
//! The folder holds six records of an axis and the file that its designer believes. Two effects are hidden in
//! the records, and every believed value is some per cent off. The diagnosis sees neither. The records were
//! made by a bench that shares no code with the simulator. The last section of
//! `scenarios/datasets/bench-axis/README.md` says what was hidden: dry friction of 7.53 N in the guide, and
//! commands that are 1.92 ms late.
//!
//! ```console
//! cargo run --release --example 05_diagnose        # half a minute on two cores
//! ```
#![expect(clippy::print_stdout, reason = "a program that tells what it found")]

use std::path::Path;

use feeler_sim::diagnosis::Examination;
use feeler_sim::diagnosis::dataset::Dataset;

/// The hidden effects: the element of each, and its parameter in SI.
const HIDDEN: [(&str, f64); 2] = [("springs.guide", 7.53), ("actuators.drive", 1.92e-3)];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Reading checks the records first: units, clocks, columns that hang. A fault is an error with a
    // remedy; an oddity is a warning.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/datasets/bench-axis");
    let dataset = Dataset::load(&folder)?;
    println!("{}: {} experiments", dataset.name, dataset.records.len());
    for warning in &dataset.warnings {
        println!("warning: {warning}");
    }

    // Calibrates the values of the file, then tries causes one by one and in pairs. Experiments that are set
    // aside score the causes: an effect that explains nothing in them is not believed.
    let found = Examination::of(dataset, &|step| println!("... {step}"))?;
    let gap = &found.diagnosis.gap;
    println!(
        "prediction error over each channel's own variation: {:.1} % as believed, {:.1} % calibrated, {:.1} \
         % with the effects found, {:.1} % of noise",
        100.0 * gap.before,
        100.0 * gap.refit,
        100.0 * gap.after,
        100.0 * gap.floor
    );

    // Each cause with its first parameter, and the value that was hidden within its interval.
    for (on, hidden) in HIDDEN {
        let cause = found.diagnosis.effects.iter().find(|effect| effect.accepted && effect.on == on);
        let cause = cause.ok_or("a hidden effect was not found")?;
        let (name, estimate) = cause.parameters.first().ok_or("the effect has no parameter")?;
        let [low, high] = estimate.ci90;
        if !(low..=high).contains(&hidden) {
            return Err(format!("{on}: {hidden} is not within {low} to {high}").into());
        }
        println!(
            "{on}: {name} = {:.4e} {unit} (90 %: {low:.4e} to {high:.4e}), hidden {hidden:.4e} {unit}",
            estimate.value,
            unit = estimate.unit
        );
    }

    // The changes to make in the file, line by line.
    println!("{}", found.difference.to_string().trim_end());
    Ok(())
}
