//! `feeler validate engines`: Rapier against the exact engine, by step size.

use std::path::Path;

use feeler_validation::engines::{EngineAgreement, agreements, default_steps_s, engine_rows};

use crate::numbers::plain;
use crate::terminal;
use crate::terminal::failure::Failure;
use crate::terminal::table;

/// Compares the engines; `scenarios` is the folder with the paper's machines.
pub(super) fn run(scenarios: Option<&Path>, as_json: bool) -> crate::Result<()> {
    let steps_s = default_steps_s();
    let found = agreements(scenarios, &steps_s)?;
    if as_json {
        terminal::print(&terminal::json(&found)?)?;
    } else {
        terminal::print(&format!(
            "Largest difference of the tip's position between Rapier and the exact engine over the tip's \
             travel, by Rapier's step; order by regression.\n\n{}",
            lines(&found, &steps_s)
        ))?;
    }
    if engine_rows(&found).iter().all(|row| row.pass) { Ok(()) } else { Err(Failure::CheckFailed) }
}

fn lines(found: &[EngineAgreement], steps_s: &[f64]) -> String {
    let mut header = vec!["machine".to_owned()];
    header.extend(steps_s.iter().map(|step| format!("{} us", plain(step * 1e6))));
    header.push("order".to_owned());
    let line = |one: &EngineAgreement| {
        let errors = one.points.iter().map(|point| format!("{:.2e}", point.relative_error));
        std::iter::once(one.machine.clone())
            .chain(errors)
            .chain([format!("{:.2}", one.order)])
            .collect::<Vec<_>>()
    };
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let columns: Vec<usize> = (1..header.len()).collect();
    table(&header, &columns, found.iter().map(line).collect::<Vec<_>>())
}
