//! A tuned controller as code that others compile.

#![expect(clippy::unwrap_used, reason = "a file that cannot be read or run fails the test that asks for it")]

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use feeler_files::{Document, Setting};
use feeler_studies::run::run;
use feeler_studies::tune::Equation;

use crate::tune::file;

/// Samples over which code and simulation are compared: 10 s at 1 kHz.
const SAMPLES: usize = 10_000;

/// Inputs and outputs of a controller at each sample of a simulation.
struct Samples {
    inputs: Vec<Vec<f64>>,
    outputs: Vec<f64>,
}

fn simulated(document: &Document, name: &str, motion: &str, used: &[&str]) -> Samples {
    let mut scenario = document.scenario.clone();
    let spec = &scenario.controllers[name].spec;
    let (period_s, is_late) = (spec.period_s, spec.delay_s > 0.0);
    let reads = scenario.controllers[name].reads.clone().unwrap_or_else(|| "force".into());
    let columns = [format!("{reads}.reading"), format!("{motion}.reading"), format!("{name}.reference")];
    let output = format!("{name}.output");
    scenario.run.record = columns.iter().chain([&output]).map(|name| name.parse().unwrap()).collect();
    scenario.run.record_rate_hz = Some(1.0 / period_s);
    scenario.run.duration_s = SAMPLES as f64 * period_s;
    let trace = run(&scenario, &mut |_| {}).unwrap().trace;
    let column = |name: &str| trace.column(name).unwrap();
    let inputs = (0..SAMPLES).map(|k| {
        let of = |input: &&str| match *input {
            "t" => k as f64 * period_s,
            "reference" => column(&columns[2])[k],
            "reading" => column(&columns[0])[k],
            _ => column(&columns[1])[k],
        };
        used.iter().map(of).collect()
    });
    // A late output is seen at the next row.
    let from = usize::from(is_late);
    Samples { inputs: inputs.collect(), outputs: column(&output)[from..].to_vec() }
}

/// Outputs of a compiled controller.
fn answers(program: &Path, samples: &Samples) -> Vec<f64> {
    let mut child = Command::new(program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let bytes: Vec<u8> = samples.inputs.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    let mut stdin = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || stdin.write_all(&bytes).unwrap());
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    output.stdout.chunks_exact(8).map(|eight| f64::from_le_bytes(eight.try_into().unwrap())).collect()
}

const MAIN_IN_C: &str = "#include <stdio.h>
int main(void) {
    Controller controller = {0};
    double in[INPUTS], out;
    while (fread(in, 8, INPUTS, stdin) == INPUTS) {
        out = controller_sample(&controller, GIVEN);
        fwrite(&out, 8, 1, stdout);
    }
    return 0;
}
";

const MAIN_IN_RUST: &str = "fn main() {
    use std::io::{Read, Write};
    let mut controller = Controller::default();
    let mut bytes = [0u8; 8 * INPUTS];
    let (mut from, mut to) = (std::io::stdin().lock(), std::io::stdout().lock());
    while from.read_exact(&mut bytes).is_ok() {
        let at = |i: usize| f64::from_le_bytes(bytes[8 * i..8 * i + 8].try_into().unwrap());
        let out = controller.sample(GIVEN);
        to.write_all(&out.to_le_bytes()).unwrap();
    }
}
";

/// A program that answers samples from its standard input, compiled; `None` if there is no compiler.
fn compiled(folder: &Path, language: &str, code: &str, inputs: usize) -> Option<std::path::PathBuf> {
    let source = folder.join(format!("controller.{language}"));
    let program = folder.join(format!("of-{language}"));
    let each = |of: &dyn Fn(usize) -> String| (0..inputs).map(of).collect::<Vec<_>>().join(", ");
    let (main, given, compiler, flags): (&str, String, &str, &[&str]) = if language == "c" {
        let flags = ["-std=c99", "-O2", "-Wall", "-Werror", "-ffp-contract=off"].as_slice();
        (MAIN_IN_C, each(&|i| format!("in[{i}]")), "cc", flags)
    } else {
        let flags = ["--edition=2021", "-O", "-Dwarnings"].as_slice();
        (MAIN_IN_RUST, each(&|i| format!("at({i})")), "rustc", flags)
    };
    let main = main.replace("INPUTS", &inputs.to_string()).replace("GIVEN", &given);
    std::fs::write(&source, format!("{code}\n{main}")).unwrap();
    let mut command = Command::new(compiler);
    command.args(flags).arg(&source).arg("-o").arg(&program);
    if language == "c" {
        command.arg("-lm");
    }
    match command.output() {
        Ok(done) => {
            let said = String::from_utf8_lossy(&done.stderr);
            assert!(done.status.success(), "{compiler}: {said}\n{code}");
            Some(program)
        }
        Err(error) => {
            // Not by a macro for printing, whose output a passing test hides.
            let _ = writeln!(std::io::stderr(), "skipped: no `{compiler}` here ({error})");
            None
        }
    }
}

#[test]
fn prop_the_code_of_a_controller_gives_the_bits_of_the_simulation() {
    let number = Setting::Number;
    let filters = [
        ("controllers.force.low_pass", number(150.0)),
        ("controllers.force.notch.frequency", number(105.0)),
        ("controllers.force.lead.zero", number(40.0)),
        ("controllers.force.lead.pole", number(160.0)),
        ("controllers.force.ki", number(8.0)),
        ("controllers.force.kd", number(2e-4)),
        ("controllers.force.derivative_filter", number(3e-3)),
        ("controllers.force.damping", number(300.0)),
        ("controllers.force.velocity_filter", number(1e-3)),
        ("controllers.force.output_limit", number(60.0)),
        ("controllers.force.output_resolution", number(0.01)),
    ];
    // Chatter runs through the approach, its release and the limits again and again.
    let releases = [("controllers.force.approach.release", number(1.0))];
    for (name, controller, motion, settings) in [
        ("chatter/sustained.toml", "force", "encoder", &[][..]),
        ("chatter/sustained.toml", "force", "encoder", &filters),
        ("chatter/sustained.toml", "force", "encoder", &releases),
        ("control/anti-windup.toml", "force", "encoder", &[]),
        ("control/windup.toml", "force", "encoder", &[]),
        ("control/impedance.toml", "spring", "encoder", &[]),
        ("control/admittance-soft-wall.toml", "force", "encoder", &[]),
        ("limits/motor-feedback.toml", "position", "encoder", &[]),
    ] {
        let document = file(name, settings);
        let controller = match document.scenario.controllers.first() {
            Some((first, _)) if !document.scenario.controllers.contains_key(controller) => first.clone(),
            _ => controller.to_owned(),
        };
        let equation = Equation::of(&document.scenario, &controller).unwrap().unwrap();
        let used = equation.inputs.clone();
        let samples = simulated(&document, &controller, motion, &used);
        let folder = tempfile::tempdir().unwrap();
        for (language, code) in [("c", &equation.code.c), ("rs", &equation.code.rust)] {
            let Some(program) = compiled(folder.path(), language, code, used.len()) else { continue };
            let answers = answers(&program, &samples);
            assert_eq!(answers.len(), SAMPLES, "{name}, {language}");
            let differs = samples.outputs.iter().zip(&answers).position(|(a, b)| a.to_bits() != b.to_bits());
            if let Some(k) = differs {
                panic!("{name}, {language}: sample {k}: {} {}\n{code}", samples.outputs[k], answers[k]);
            }
        }
        let moves =
            samples.outputs.iter().filter(|output| output.to_bits() != samples.outputs[0].to_bits()).count();
        assert!(moves > SAMPLES / 100, "{name}: an output that stands still tells nothing");
    }
}
