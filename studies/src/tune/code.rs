//! A controller's difference equations as C and as Rust.
//!
//! Both compute what the simulated controller computes, to the last bit, if the compiler does not contract a
//! product and a sum into one operation. Rust never does, C does not with `-ffp-contract=off`.

use std::fmt::Write as _;

use feeler_control::{ControllerSpec, Line, Listing};
use serde::Serialize;

/// A controller as source text.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Code {
    /// The controller in C99.
    pub c: String,
    /// The controller in Rust.
    pub rust: String,
}

impl Code {
    /// The code of a listed controller.
    pub fn of(listing: &Listing, name: &str, spec: &ControllerSpec) -> Self {
        let about = about(listing, name, spec);
        Self { c: c(listing, &about), rust: rust(listing, &about) }
    }
}

/// Notes for the user, as lines of a comment.
fn about(listing: &Listing, name: &str, spec: &ControllerSpec) -> Vec<String> {
    let inputs = listing.inputs().into_iter().map(|input| match input {
        "t" => "t: time of the sample, s",
        "reference" => "reference: the value that the reading is to reach",
        "reading" => "reading: what its sensor reads",
        _ => "motion: the reading of its position or velocity sensor",
    });
    let begin = format!("Controller `{name}`, written by `feeler tune`. SI units.");
    let when = format!("Sample every {} s; the output acts {} s later.", spec.period_s, spec.delay_s);
    [begin, when].into_iter().chain(inputs.map(str::to_owned)).collect()
}

fn c(listing: &Listing, about: &[String]) -> String {
    let mut text = String::from("/*\n");
    for line in about {
        let _ = writeln!(text, " * {line}");
    }
    text += " * Compile with -ffp-contract=off for the same bits as the simulation.\n */\n";
    text += "#include <math.h>\n#include <stdbool.h>\n\n";
    for (name, value) in &listing.constants {
        let _ = writeln!(text, "static const double {name} = {value:?};");
    }
    text += "\n/* State from one sample to the next; zero and false before the first. */\n";
    text += "typedef struct {\n";
    for state in &listing.numbers {
        let _ = writeln!(text, "    double {state};");
    }
    for state in &listing.truths {
        let _ = writeln!(text, "    bool {state};");
    }
    let inputs: Vec<String> = listing.inputs().iter().map(|input| format!(", double {input}")).collect();
    let inputs = inputs.concat();
    let _ = writeln!(text, "}} Controller;\n\ndouble controller_sample(Controller *controller{inputs}) {{");
    text += "    Controller s = *controller;\n";
    for line in &listing.lines {
        let _ = match line {
            Line::Number(name, value) => writeln!(text, "    double {name} = {value};"),
            Line::Truth(name, value) => writeln!(text, "    bool {name} = {value};"),
            Line::Choice(name, [when, then, otherwise]) => {
                writeln!(text, "    double {name} = {when} ? {then} : {otherwise};")
            }
            Line::Rounded(name, value) => writeln!(text, "    double {name} = rint({value});"),
            Line::Set(state, value) => writeln!(text, "    s.{state} = {value};"),
        };
    }
    let _ = write!(text, "    *controller = s;\n    return {};\n}}\n", listing.output);
    text
}

fn rust(listing: &Listing, about: &[String]) -> String {
    let mut text = String::new();
    for line in about {
        let _ = writeln!(text, "// {line}");
    }
    text += "\n";
    for (name, value) in &listing.constants {
        let _ = writeln!(text, "const {name}: f64 = {value:?};");
    }
    text += "\n/// State from one sample to the next.\n#[derive(Clone, Copy, Debug, Default)]\n";
    text += "pub struct Controller {\n";
    for state in &listing.numbers {
        let _ = writeln!(text, "    {state}: f64,");
    }
    for state in &listing.truths {
        let _ = writeln!(text, "    {state}: bool,");
    }
    let inputs: Vec<String> = listing.inputs().iter().map(|input| format!(", {input}: f64")).collect();
    let _ = write!(
        text,
        "}}\n\nimpl Controller {{\n    pub fn sample(&mut self{}) -> f64 {{\n        let s = self;\n",
        inputs.concat()
    );
    for line in &listing.lines {
        let _ = match line {
            Line::Number(name, value) | Line::Truth(name, value) => {
                writeln!(text, "        let {name} = {value};")
            }
            Line::Choice(name, [when, then, otherwise]) => {
                writeln!(text, "        let {name} = if {when} {{ {then} }} else {{ {otherwise} }};")
            }
            Line::Rounded(name, value) => writeln!(text, "        let {name} = ({value}).round_ties_even();"),
            Line::Set(state, value) => writeln!(text, "        s.{state} = {value};"),
        };
    }
    let _ = write!(text, "        {}\n    }}\n}}\n", listing.output);
    text
}
