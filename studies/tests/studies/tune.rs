//! Tuned controllers: against brute force, over uncertain machines, and as code that others compile.

#![expect(clippy::print_stdout, reason = "figures that a documentation quotes")]
#![expect(clippy::unwrap_used, reason = "a file that cannot be read or run fails the test that asks for it")]

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use feeler_analysis::{ClosedLoop, ControlLoop, MarginReport};
use feeler_engine::Scenario;
use feeler_files::{Document, Setting};
use feeler_problem::Remedy as _;
use feeler_studies::operating_point::contact_view;
use feeler_studies::run::{Candidate, Outcome, measure, run};
use feeler_studies::tune::{Equation, Spec, Tuned, Uncertain, machines, tune};

fn file(name: &str, settings: &[(&str, Setting)]) -> Document {
    let scenarios = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios"));
    let document = Document::load(&scenarios.join(name)).and_then(|file| file.with(settings.iter().cloned()));
    document.unwrap_or_else(|mistakes| panic!("{mistakes}"))
}

/// What is promised of the bandwidth that brute force finds.
const PROMISED: f64 = 0.95;

fn tuned(document: &Document, spec: &str) -> Tuned {
    let alone = [document.scenario.clone()];
    tune(document, &Spec::parse(spec).unwrap(), &alone, &|_| {}).unwrap_or_else(|error| panic!("{error}"))
}

fn with(document: &Document, settings: &[(String, f64)]) -> Scenario {
    document
        .with(settings.iter().map(|(key, value)| (key.as_str(), Setting::Number(*value))))
        .unwrap()
        .scenario
}

/// The bandwidth of a loop that keeps 45 degrees and 6 dB either way.
fn allowed_hz(scenario: &Scenario, controller: &str) -> Option<f64> {
    let whole = ControlLoop::new(scenario, &contact_view(scenario)).ok()?;
    let controller = whole.controller(controller).ok()?;
    let margins = MarginReport::new(&whole.open_loop(controller).ok()?.transfer().ok()?).ok()?;
    let keeps = margins.unstable_poles == 0
        && margins.phase_deg.is_none_or(|phase| phase >= 45.0)
        && margins.gain.is_none_or(|factor| factor >= 2.0)
        && margins.gain_decrease.is_none_or(|factor| factor <= 0.5);
    let bandwidth_hz = ClosedLoop::sampled(&whole, controller).ok()??.bandwidth_hz().ok()?;
    keeps.then(|| bandwidth_hz.unwrap_or(0.5 / whole.controllers()[controller].spec.period_s))
}

/// Whether a run comes to rest.
fn rests(scenario: Scenario) -> bool {
    let measured = Candidate::new(scenario).and_then(|candidate| candidate.measure(0));
    measured.is_ok_and(|measured| measured.summary.outcome.is_stable())
}

/// Whether a loop with some settings comes to rest, and so do each share of its gains in the order of trying,
/// and its neighbours. These have 5 % less and more of the gains, and of each frequency that is set.
fn rests_around(
    document: &Document,
    controller: &str,
    gains: &[&str],
    settings: &[(String, f64)],
) -> Result<(), String> {
    let key = |name: &str| format!("controllers.{controller}.{name}");
    let gains: Vec<String> = gains.iter().map(|name| key(name)).collect();
    let mut around: Vec<(&[String], f64)> =
        [1.0, 0.125, 0.25, 0.5, 0.75, 0.95, 1.05].map(|times| (gains.as_slice(), times)).to_vec();
    let frequencies = ["low_pass", "notch.frequency"].map(|name| [key(name)]);
    for frequency in frequencies.iter().filter(|of| settings.iter().any(|(key, _)| *key == of[0])) {
        around.extend([0.95, 1.05].map(|times| (frequency.as_slice(), times)));
    }
    for (keys, times) in around {
        let moved: Vec<(String, f64)> = (settings.iter())
            .map(|(key, value)| (key.clone(), if keys.contains(key) { times * value } else { *value }))
            .collect();
        if !rests(with(document, &moved)) {
            return Err(format!("no rest at {moved:?}"));
        }
    }
    Ok(())
}

/// The settings of a tuned controller.
fn tuned_settings(tuned: &Tuned) -> Vec<(String, f64)> {
    let pairs = tuned.settings.iter().map(|words| words.split_once('=').unwrap());
    pairs.map(|(key, value)| (key.to_owned(), value.parse().unwrap())).collect()
}

/// The largest allowed bandwidth of a dense grid that comes to rest with all around it. The grid is over
/// factors on some gains of the file together, and over values of another number.
fn by_brute_force(
    document: &Document,
    controller: &str,
    together: &[&str],
    other: Option<(&str, [f64; 2])>,
    count: i32,
) -> f64 {
    let key = |name: &str| format!("controllers.{controller}.{name}");
    let numbers = document.numbers();
    let present = |name: &str| numbers.iter().find(|number| number.key == key(name)).unwrap().value;
    let share = |i: i32| f64::from(i) / f64::from(count - 1);
    let mut found: Vec<(f64, Vec<(String, f64)>)> = Vec::new();
    for i in 0..count {
        let factor = 10.0_f64.powf(6.0 * share(i) - 3.0);
        let scaled: Vec<(String, f64)> =
            together.iter().map(|name| (key(name), factor * present(name))).collect();
        for j in 0..if other.is_some() { count } else { 1 } {
            let mut settings = scaled.clone();
            if let Some((name, [low, high])) = other {
                settings.push((key(name), low * (high / low).powf(share(j))));
            }
            found.extend(allowed_hz(&with(document, &settings), controller).map(|hz| (hz, settings)));
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let is_safe = |settings: &Vec<(String, f64)>| rests_around(document, controller, together, settings);
    found.into_iter().find(|(_, settings)| is_safe(settings).is_ok()).map_or(0.0, |(hz, _)| hz)
}

/// Tunes by a specification, and compares with a grid over the gains on errors that the file has, and another
/// number.
fn compare(name: &str, spec: &str, other: Option<(&str, [f64; 2])>, count: i32) {
    let document = file(name, &[]);
    let (controller, used) = document.scenario.controllers.first().unwrap();
    let together: Vec<&str> = ["kp", "ki", "kd"]
        .into_iter()
        .filter(|gain| feeler_analysis::gain(&used.spec, gain).is_ok_and(|value| value != 0.0))
        .collect();
    let tuned = tuned(&document, spec);
    let brute_hz = by_brute_force(&document, controller, &together, other, count);
    println!(
        "{name}: {:.3} Hz, by brute force {brute_hz:.3} Hz, {:?}",
        tuned.bandwidth_hz, tuned.evaluations
    );
    assert!(brute_hz > 0.0, "{name}: brute force finds nothing");
    assert!(tuned.bandwidth_hz >= PROMISED * brute_hz, "{name}: {} Hz, {brute_hz} Hz", tuned.bandwidth_hz);
    // What is written down is what was promised.
    let written = with(&document, &tuned_settings(&tuned));
    let hz = allowed_hz(&written, controller).unwrap();
    assert!((hz / tuned.bandwidth_hz - 1.0).abs() < 1e-9, "{name}: {hz} Hz written");
}

#[test]
fn prop_the_bandwidth_is_that_of_brute_force() {
    compare("paper/flexible-contact.toml", "", None, 150);
    compare("control/lead.toml", "", None, 150);
}

/// The paper's machines and twelve others, with damping where the file has some; damping by itself; a notch
/// and a low-pass: `cargo test -p feeler-studies --test studies -- --ignored --nocapture brute`.
#[test]
#[ignore = "takes minutes"]
fn prop_the_bandwidth_is_that_of_brute_force_everywhere() {
    for name in [
        "paper/rigid-contact.toml",
        "paper/flexible-contact.toml",
        "paper/workpiece-contact.toml",
        "paper/base-contact.toml",
        "paper/all-three-contact.toml",
        "chatter/sustained.toml",
        "chatter/bounces.toml",
        "control/lead.toml",
        "limits/sampled-delay.toml",
        "limits/noncolocated.toml",
        "limits/workpiece-lead.toml",
        "limits/integral-delay.toml",
        "reference/m2.toml",
    ] {
        compare(name, "", None, 500);
    }
    // Without `gains`, damping is tuned where the file has some.
    let damping = Some(("damping", [10.0, 2e4]));
    for name in
        ["control/windup.toml", "chatter/settles.toml", "contact/hard-wall.toml", "limits/base-dip.toml"]
    {
        compare(name, "", damping, 60);
    }
    for name in ["chatter/sustained.toml", "paper/flexible-contact.toml"] {
        compare(name, "gains = kp+damping", damping, 60);
    }
    let band = [2.0, 450.0];
    compare("chatter/sustained.toml", "structure = gains+notch", Some(("notch.frequency", band)), 60);
    compare("paper/flexible-contact.toml", "structure = gains+filter", Some(("low_pass", band)), 60);
}

/// By theory alone the best notch lies at the edge of chatter. A run settles at 20.45 Hz, and chatters at
/// 20.5 Hz, and at three quarters of the gain.
#[test]
fn regress_a_proposal_at_the_edge_of_chatter_is_refused() {
    let document = file("chatter/sustained.toml", &[("run.duration", Setting::Number(2.0))]);
    let at = |kp: f64, hz: f64| {
        let [gain, notch] = ["kp", "notch.frequency"].map(|name| format!("controllers.force.{name}"));
        rests_around(&document, "force", &["kp"], &[(gain, kp), (notch, hz)])
    };
    at(1.768, 20.45).unwrap_err();
    let tuned = tuned(&document, "structure = gains+notch");
    rests_around(&document, "force", &["kp"], &tuned_settings(&tuned)).unwrap();
    let shares: Vec<f64> = tuned.steps.iter().map(|step| step.share).collect();
    assert!(shares.windows(2).all(|pair| pair[1] <= 2.0 * pair[0]) && shares[0] <= 0.125, "{shares:?}");
    // Without a notch, 34 Hz; by theory alone with one, 66 Hz.
    assert!((50.0..66.0).contains(&tuned.bandwidth_hz), "{} Hz", tuned.bandwidth_hz);
}

/// A wall and a guide that are known within half and twice, and a delay.
fn uncertain() -> Vec<Uncertain> {
    let of = |key: &str, value: f64, interval| Uncertain { key: key.into(), value, interval };
    vec![
        of("contacts.tool.stiffness", 2e5, [1e5, 4e5]),
        of("springs.guide.effects.coulomb-friction.level", 3.0, [0.0, 6.0]),
        of("controllers.force.delay", 0.4e-3, [0.2e-3, 0.8e-3]),
    ]
}

/// Tuned on some draws, it comes to rest on those and on as many others of the same intervals.
fn over_draws(draws: usize) {
    let document = file("chatter/sustained.toml", &[("controllers.force.damping", Setting::Number(300.0))]);
    let drawn = machines(&document, &uncertain(), draws, 0).unwrap();
    let tuned = tune(&document, &Spec::default(), &drawn, &|_| {}).unwrap();
    assert_eq!(tuned.machines, draws + 1);
    assert_eq!(tuned.runs.outcomes.values().sum::<usize>(), draws + 1);
    let rests = |name: &str| Outcome::ALL.iter().any(|(outcome, own)| *own == name && outcome.is_stable());
    assert!(tuned.runs.outcomes.keys().all(|name| rests(name)), "{:?}", tuned.runs.outcomes);
    let settings = tuned_settings(&tuned);
    let set =
        document.with(settings.iter().map(|(key, value)| (key.as_str(), Setting::Number(*value)))).unwrap();
    let fresh = machines(&set, &uncertain(), draws, 1 << 16).unwrap();
    let candidates: Vec<Candidate> = fresh.into_iter().map(|one| Candidate::new(one).unwrap()).collect();
    let mut chatters = 0;
    for measured in measure(&candidates, 0) {
        let outcome = measured.unwrap().summary.outcome;
        chatters += usize::from(!outcome.is_stable());
    }
    println!("{draws} draws: {:.2} Hz, {chatters} of as many others chatter", tuned.bandwidth_hz);
    assert_eq!(chatters, 0);
}

#[test]
fn prop_no_draw_of_an_uncertain_machine_chatters() {
    over_draws(7);
}

/// `cargo test -p feeler-studies --test studies -- --ignored --nocapture draws`.
#[test]
#[ignore = "takes minutes"]
fn prop_none_of_200_draws_of_an_uncertain_machine_chatters() {
    over_draws(200);
}

#[test]
fn truth_steps_begin_low_and_each_says_when_to_stop() {
    let tuned = tuned(&file("paper/flexible-contact.toml", &[("run.duration", Setting::Number(1.0))]), "");
    let shares: Vec<f64> = tuned.steps.iter().map(|step| step.share).collect();
    assert_eq!(shares, [0.125, 0.25, 0.5, 0.75, 1.0]);
    assert_eq!(tuned.steps[4].settings, tuned.settings);
    for step in &tuned.steps {
        assert!(step.stop_force_n > step.expected.peak_force_n && step.swing_hz > 0.0);
        assert!(step.gain_margin.is_none_or(|factor| factor >= 2.0));
    }
}

#[test]
fn truth_what_cannot_be_met_is_refused_with_a_way_out() {
    let document = file("paper/flexible-contact.toml", &[("run.duration", Setting::Number(1.0))]);
    let alone = [document.scenario.clone()];
    for (spec, what, remedy) in [
        ("peak force <= 1 N", "peak force", "slow the approach"),
        ("phase margin >= 179 deg, gain margin >= 200 dB", "no gains meet", "lower a limit"),
        ("gains = kq", "no gain `kq`", "name one of kp"),
        ("gains =", "names none", "name some of"),
        ("kp >= 5", "not tuned by itself", "gains = kp"),
        ("controller = arm", "no controller `arm`", "force"),
    ] {
        let error = tune(&document, &Spec::parse(spec).unwrap(), &alone, &|_| {}).unwrap_err();
        assert!(error.to_string().contains(what) && error.remedy().contains(remedy), "{spec}: {error}");
    }
}

/// Samples over which code and simulation are compared: 10 s at 1 kHz.
const SAMPLES: usize = 10_000;

/// What a controller was given at each sample in a simulation, and what it put out.
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

/// What a compiled controller puts out.
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
