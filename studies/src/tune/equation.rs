//! A controller's difference equations as data.

use feeler_control::{Controller, ControllerSpec, Line, Listing};
use feeler_engine::{Program, Scenario};
use indexmap::IndexMap;
use serde::Serialize;

use super::code::Code;
use super::error::TuneError;
use crate::run::RunError;

/// Equations of a controller at each sample.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Equation {
    /// Time between samples, s.
    pub period_s: f64,
    /// From a sample to the instant at which its output acts, s.
    pub delay_s: f64,
    /// Constants by their names.
    pub constants: IndexMap<String, f64>,
    /// The equations, in order; `name[n-1]` is the value of the sample before.
    pub lines: Vec<String>,
    /// Arguments of a sample, of `t` (s), `reference`, `reading` and `motion`, in the order of the code.
    pub inputs: Vec<&'static str>,
    /// Name of the output.
    pub output: String,
    /// In contact and within limits: `x[n+1] = a x[n] + b in[n]`, `u[n] = c x[n] + d in[n]`, with the inputs
    /// reference, reading and motion.
    pub linear: Linear,
    /// The equations as source text.
    pub code: Code,
}

/// A linear law in matrices.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Linear {
    /// Matrix from state to next state.
    pub a: Vec<Vec<f64>>,
    /// Matrix from inputs to next state.
    pub b: Vec<[f64; 3]>,
    /// Matrix from state to output.
    pub c: Vec<f64>,
    /// Matrix from inputs to output.
    pub d: [f64; 3],
}

impl Equation {
    /// The equations of a controller of a scenario.
    ///
    /// # Errors
    /// A machine or wiring with mistakes.
    pub fn of(scenario: &Scenario, name: &str) -> Result<Option<Self>, TuneError> {
        let program = Program::new(scenario).map_err(RunError::from)?;
        let Some(wiring) = program.loops().find(|wiring| wiring.name == name) else { return Ok(None) };
        let spec: &ControllerSpec = wiring.spec;
        let is_velocity = wiring.motion.map(|_| wiring.motion_is_velocity);
        let failed =
            |source| RunError::from(feeler_engine::EngineError::Control { name: name.into(), source });
        let listing =
            Controller::<f64>::new(std::slice::from_ref(spec)).map_err(failed)?.listing(is_velocity);
        let linear = spec.linear(wiring.motion_is_velocity).map_err(failed)?;
        Ok(Some(Self {
            period_s: spec.period_s,
            delay_s: spec.delay_s,
            lines: listing
                .lines
                .iter()
                .filter(|line| !keeps(line))
                .map(|line| in_words(line, &listing))
                .collect(),
            inputs: listing.inputs(),
            output: listing.output.clone(),
            code: Code::of(&listing, name, spec),
            constants: listing.constants.into_iter().collect(),
            linear: Linear { a: linear.a, b: linear.b, c: linear.c, d: linear.d },
        }))
    }
}

/// Whether a line only keeps a number under its own name, since `name[n-1]` shows the same number.
fn keeps(line: &Line) -> bool {
    matches!(line, Line::Set(state, value) if state == value)
}

/// A line as an equation between samples.
fn in_words(line: &Line, listing: &Listing) -> String {
    let last = |text: &str| {
        let mut text = text.to_owned();
        // Longer names first, since one may begin another.
        let mut states: Vec<&String> = listing.numbers.iter().chain(&listing.truths).collect();
        states.sort_by_key(|state| std::cmp::Reverse(state.len()));
        for state in states {
            text = text.replace(&format!("s.{state}"), &format!("{state}[n-1]"));
        }
        text
    };
    match line {
        Line::Number(name, value) | Line::Truth(name, value) => format!("{name} = {}", last(value)),
        Line::Rounded(name, value) => format!("{name} = {}, to the nearest integer", last(value)),
        Line::Choice(name, [when, then, otherwise]) => {
            format!("{name} = {} if {}, else {}", last(then), last(when), last(otherwise))
        }
        Line::Set(state, value) => format!("{state}[n] = {}", last(value)),
    }
}
