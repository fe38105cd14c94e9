//! `feeler effects`.

mod as_json;
mod drawing;

use feeler_plant::effects::{Definition, LIBRARY, Parameter, find};

use crate::arguments::Effects;
use crate::numbers::plain;
use crate::terminal;
use crate::terminal::table;

pub(crate) fn run(arguments: &Effects) -> crate::Result<()> {
    let chosen = arguments.kind.as_deref().and_then(find);
    if let (Some(effect), Some(path)) = (chosen, &arguments.out) {
        path.parent().map_or(Ok(()), terminal::make_folder)?;
        terminal::write(path, drawing::svg(&effect.law).as_bytes())?;
        terminal::complain(&format!("wrote {}", path.display()));
        return Ok(());
    }
    let text = match (chosen, arguments.json) {
        (Some(effect), true) => terminal::json(&as_json::Effect::new(effect))?,
        (None, true) => {
            terminal::json(&LIBRARY.iter().map(|effect| as_json::Effect::new(effect)).collect::<Vec<_>>())?
        }
        (Some(effect), false) => explain(effect),
        (None, false) => list(),
    };
    terminal::print(&text)
}

fn list() -> String {
    let row = |effect: &&Definition| {
        let parameters: Vec<&str> = effect.parameters.iter().map(|parameter| parameter.name).collect();
        vec![
            effect.name.to_owned(),
            effect.place.name().to_owned(),
            parameters.join(", "),
            effect.summary.to_owned(),
        ]
    };
    let table = table(&["effect", "place", "parameters", "what it is"], &[], LIBRARY.iter().map(row));
    format!("{table}\n\n{} effects. `feeler effects KIND` explains one.", LIBRARY.len())
}

fn explain(effect: &Definition) -> String {
    let row = |parameter: &Parameter| {
        vec![
            parameter.name.to_owned(),
            unit(parameter),
            parameter.default.map_or_else(|| "required".to_owned(), plain),
            plain(parameter.typical),
            format!("{} to {}", bound(parameter.bounds.0), bound(parameter.bounds.1)),
            parameter.text.to_owned(),
        ]
    };
    let rows = effect.parameters.iter().map(row);
    let parameters = table(&["parameter", "unit", "default", "typical", "bounds", "what it is"], &[3], rows);
    format!(
        "{}: {}\nplace in a diagnosis: {}    sits under: {}\n\n{parameters}\n\n{}",
        effect.kind,
        effect.summary,
        effect.place.name(),
        effect.sits_under(),
        effect.documentation().trim()
    )
}

/// SI unit of a parameter; that of a rotational axis follows in parentheses if it differs.
fn unit(parameter: &Parameter) -> String {
    let [straight, rotary] = [false, true].map(|rotational| parameter.dimension.si_unit(rotational));
    if straight == rotary { straight.into() } else { format!("{straight} ({rotary})") }
}

fn bound(value: f64) -> String {
    match value {
        v if v == f64::INFINITY => "any".into(),
        v if v == f64::NEG_INFINITY => "any".into(),
        v if v > 0.0 && v <= f64::MIN_POSITIVE => "above 0".into(),
        v => plain(v),
    }
}
