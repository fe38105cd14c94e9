//! `feeler effects`.

use feeler_plant::effects::{Change, Definition, LIBRARY, Parameter, Trait, find};
use serde_json::{Value, json};

use crate::arguments::Effects;
use crate::numbers::plain;
use crate::terminal;
use crate::terminal::table;

pub(crate) fn run(arguments: &Effects) -> crate::Result<()> {
    let chosen = arguments.kind.as_deref().and_then(find);
    let text = match (chosen, arguments.json) {
        (Some(effect), true) => terminal::json(&as_json(effect))?,
        (None, true) => terminal::json(&LIBRARY.iter().map(|effect| as_json(effect)).collect::<Vec<_>>())?,
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
            parameter.dimension.to_string(),
            parameter.default.map_or_else(|| "required".to_owned(), plain),
            plain(parameter.typical),
            format!("{} to {}", bound(parameter.bounds.0), bound(parameter.bounds.1)),
            parameter.text.to_owned(),
        ]
    };
    let rows = effect.parameters.iter().map(row);
    let parameters = table(&["parameter", "unit", "default", "typical", "bounds", "what it is"], &[3], rows);
    format!(
        "{}: {}\nplace: {}    sits under: {}\n\n{parameters}\n\n{}",
        effect.kind,
        effect.summary,
        effect.place.name(),
        effect.sits_under(),
        effect.documentation.trim()
    )
}

fn bound(value: f64) -> String {
    match value {
        v if v == f64::INFINITY => "any".into(),
        v if v == f64::NEG_INFINITY => "any".into(),
        v if v > 0.0 && v <= f64::MIN_POSITIVE => "above 0".into(),
        v => plain(v),
    }
}

fn as_json(effect: &Definition) -> Value {
    let parameter = |parameter: &Parameter| {
        json!({
            "name": parameter.name,
            "unit": parameter.dimension.to_string(),
            "text": parameter.text,
            "null": parameter.null,
            "typical": parameter.typical,
            "bounds": [parameter.bounds.0, parameter.bounds.1],
            "default": parameter.default,
        })
    };
    json!({
        "kind": effect.name,
        "place": effect.place.name(),
        "sits_under": effect.hosts.iter().map(|host| host.phrase()).collect::<Vec<_>>(),
        "site": effect.site,
        "parameters": effect.parameters.iter().map(parameter).collect::<Vec<_>>(),
        "summary": effect.summary,
        "documentation": effect.documentation,
        "dissipative": effect.has(Trait::Dissipative),
        "disturbs": if matches!(effect.change, Change::Plant(_)) { "plant" } else { "controller" },
    })
}
