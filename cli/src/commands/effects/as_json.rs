//! An effect of the library, for programs. The book shows the comments.

use feeler_plant::effects::{Change, Definition, Trait};
use serde::Serialize;

/// An effect.
#[derive(Serialize)]
pub(super) struct Effect {
    /// Name of the effect in files.
    kind: &'static str,
    /// Place of the effect on the machine.
    place: &'static str,
    /// Kinds of elements that can have the effect.
    sits_under: Vec<&'static str>,
    /// Further requirement on the element; empty if there is none.
    site: &'static str,
    /// Parameters of the effect.
    parameters: Vec<Parameter>,
    /// Meaning of the effect, in one line.
    summary: &'static str,
    /// Page of the effect, as Markdown.
    documentation: String,
    /// Whether the effect can only dissipate energy.
    dissipative: bool,
    /// The part of the model that the effect changes: `plant` or `controller`.
    disturbs: &'static str,
}

/// A parameter of an effect.
#[derive(Serialize)]
struct Parameter {
    /// Name of the parameter in files.
    name: &'static str,
    /// SI unit on a translational axis.
    unit: String,
    /// Meaning of the parameter, in one line.
    text: &'static str,
    /// Value in the ideal machine; `None` if there is none, or if it is infinite.
    null: Option<f64>,
    /// A typical value.
    typical: f64,
    /// Smallest and largest value in a file; `None` for no bound.
    bounds: [f64; 2],
    /// Value if a file omits the key; `None` if the key is required.
    default: Option<f64>,
}

impl Effect {
    pub(super) fn new(effect: &Definition) -> Self {
        let parameters = effect.parameters.iter().map(|parameter| Parameter {
            name: parameter.name,
            unit: parameter.dimension.to_string(),
            text: parameter.text,
            null: parameter.null,
            typical: parameter.typical,
            bounds: [parameter.bounds.0, parameter.bounds.1],
            default: parameter.default,
        });
        Self {
            kind: effect.name,
            place: effect.place.name(),
            sits_under: effect.hosts.iter().map(|host| host.phrase()).collect(),
            site: effect.site,
            parameters: parameters.collect(),
            summary: effect.summary,
            documentation: effect.documentation(),
            dissipative: effect.has(Trait::Dissipative),
            disturbs: if matches!(effect.change, Change::Plant(_)) { "plant" } else { "controller" },
        }
    }
}
