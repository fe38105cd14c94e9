//! `feeler analyze`.

use std::f64::consts::TAU;
use std::io::Write as _;

use serde_json::Value;

use crate::bench::{Bench, DONE, json, printed, refused, shipped};
use crate::live::data_of;

#[test]
fn reference_analysis_of_the_flexible_axis_as_programs_read_it() {
    let found = json(&["analyze", "paper/flexible.toml", "--json"]);
    let near = |value: &Value, expected: f64| (value.as_f64().unwrap() - expected).abs() < 1e-3;
    assert!(
        near(&found["poles_hz"][0], 19.967)
            && near(&found["poles_hz"][1], 105.049)
            && near(&found["zeros_hz"][0], 1591.549)
    );
    assert!(near(&found["gain"]["continuous"]["stable"][1], 5.6083));
    assert_eq!(found["modes"][1]["class"], "noncolocated");
    for key in ["gain", "phase_deg", "delay_s", "crossover_hz"] {
        assert!(found["margins"][key].is_number(), "{key}");
    }
    assert!(found["limit"].is_string());
    assert_eq!(found["state_space"]["states"].as_array().unwrap().len(), 4);
    assert!(near(&found["gain"]["sampled"]["edges"][0]["gain"], -1.0) && found["zero_pole_gain"].is_number());
    let largest = found["sensitivities"][0]["bandwidth_relative"].as_f64().unwrap();
    assert!(largest.abs() > 0.01 && found["margins"]["sensitivity_peak_hz"].is_number());
}

#[test]
fn truth_the_tables_of_an_analysis_have_both_edges_the_count_and_the_peaks() {
    let text = printed(&["analyze", "paper/flexible.toml"]);
    for part in [
        "oscillation at to (Hz)",
        "-1 ",
        "clockwise turns about -1",
        "|S|",
        "|T|",
        "times the product of (s - zero)",
        "1 % more of",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// The first sentence describes the loop as set: its margins, its limit and the cause of the limit.
#[test]
fn truth_an_analysis_begins_with_the_loop_as_set() {
    let text = printed(&["analyze", "paper/flexible-contact.toml"]);
    let first = text.lines().next().unwrap();
    assert!(
        first.starts_with("kp = 0.75 is stable but fragile (phase margin 5.791°, gain margin 2.009, "),
        "{first}"
    );
    let limit = "its limit is 1.507, set by sampling and delay, where the loop oscillates at 32.52 Hz.";
    assert!(first.ends_with(limit), "{first}");
    assert!(!first.contains(". "), "{first}");
    // The next sentences name what would raise the limit: the limit of continuous control over that at 1 kHz.
    let next: Vec<&str> = text.lines().skip(2).take(2).collect();
    let relief = "With continuous control, its limit would be 3.7 times as high.";
    assert!(next[0].starts_with("Sampling limits this loop") && next[0].contains(relief), "{next:?}");
    let raise = "Of masses, stiffnesses and dampings, these raise bandwidth and limit most: 1 % more \
                 contacts.tool.damping (bandwidth +0.13 %, limit +0.51 %)";
    assert!(next[1].starts_with(raise), "{next:?}");
}

/// For a loop with one gain both numbers are equal. The margin also scales a damping gain, the limit does
/// not.
#[test]
fn truth_a_gain_margin_that_differs_from_the_limit_is_explained() {
    let of = |owner: &str, key: &str| {
        format!(
            "The gain margin is a factor on the whole output of {owner}, all its gains together. The limit \
             is that of {key} alone."
        )
    };
    let text = printed(&["analyze", "control/impedance.toml"]);
    assert!(text.contains(&of("controllers.spring", "stiffness")), "{text}");
    let found = json(&["analyze", "control/impedance.toml", "--json"]);
    let (margin, gain) = (&found["margins"]["gain"], &found["gain"]);
    let alone = gain["sampled"]["stable"][1].as_f64().unwrap() / gain["present"].as_f64().unwrap();
    assert!(alone > 2.0 * margin.as_f64().unwrap(), "{found}");
    let text = printed(&["analyze", "paper/flexible-contact.toml"]);
    assert!(!text.contains("The gain margin is a factor"), "{text}");
    let text = printed(&["analyze", "paper/flexible-contact.toml", "--set", "controllers.force.damping=300"]);
    assert!(text.contains(&of("controllers.force", "kp")), "{text}");
}

/// The factor of an unstable loop scales all gains, so its damping too.
#[test]
fn truth_an_unstable_loop_says_how_far_all_gains_must_fall() {
    let text = printed(&["analyze", "limits/base-dip.toml"]);
    let sentence = "Its controller's whole output, all gains together, must fall to 0.5306 times its value.";
    assert!(text.contains(sentence), "{text}");
    let unstable_poles = |factor: f64| {
        let ki = format!("controllers.force.ki={}", 50.0 * factor);
        let damping = format!("controllers.force.damping={}", 1500.0 * factor);
        let found = json(&["analyze", "limits/base-dip.toml", "--set", &ki, "--set", &damping, "--json"]);
        found["margins"]["unstable_poles"].as_u64().unwrap()
    };
    assert_eq!([0.530, 0.531].map(unstable_poles), [0, 2]);
}

#[test]
fn truth_an_analysis_says_of_which_loop_it_speaks() {
    let text = printed(&["analyze", "paper/flexible.toml", "--output", "motor.position"]);
    assert!(
        text.contains("are those of the loop of controllers.force, from drive.command to tool.spring_force."),
        "{text}"
    );
    assert!(!printed(&["analyze", "paper/flexible.toml"]).contains("are those of the loop of"));
}

/// Poles of one machine by two methods: Newton's method leaves 1e-10 of the forces at the operating point.
const SAME_MACHINE: f64 = 1e-8;

#[test]
fn truth_a_contact_that_depends_on_force_is_taken_at_the_last_reference() {
    let poles = |arguments: &[&str]| -> Vec<f64> {
        let found = json(&[&["analyze"], arguments, &["--json"]].concat());
        found["poles"]
            .as_array()
            .unwrap()
            .iter()
            .flat_map(|pole| [pole[0].as_f64().unwrap(), pole[1].as_f64().unwrap()])
            .collect()
    };
    let same = |file: &str, setting: &str| {
        let (law, tangent) = (poles(&[file]), poles(&["effects/ideal.toml", "--set", setting]));
        let largest = tangent.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
        assert_eq!(law.len(), tangent.len());
        assert!(
            law.iter().zip(&tangent).all(|(a, b)| (a - b).abs() < SAME_MACHINE * largest),
            "{file}: {law:?} {tangent:?}"
        );
    };
    // k d + cubic d^3 = 30 N at d, where the slope is k + 3 cubic d^2.
    let (k, cubic) = (2e5, 1e13_f64);
    let mut d: f64 = 30.0 / k;
    for _ in 0..50 {
        d -= (k * d + cubic * d.powi(3) - 30.0) / (k + 3.0 * cubic * d * d);
    }
    same("effects/hardening-stiffness.toml", &format!("contacts.tool.stiffness={}", k + 3.0 * cubic * d * d));
    // k d (1 + alpha v) adds a damping of alpha times the force: 6 s/m times 30 N, in addition to 120 N s/m.
    same("effects/hunt-crossley-contact.toml", "contacts.tool.damping=300");
    let hardening = json(&["analyze", "effects/hardening-stiffness.toml", "--json"]);
    assert_eq!(hardening["preload_n"], 30.0);
    let hertz = json(&["analyze", "effects/hertz-contact.toml", "--json"]);
    assert_eq!(
        json(&["analyze", "effects/hertz-contact.toml", "--clamped", "--json"])["poles"],
        hertz["poles"]
    );
    let note = shipped().args(["analyze", "effects/hardening-stiffness.toml"]).output().unwrap().stderr;
    assert!(String::from_utf8(note).unwrap().contains("linearised at the final reference, 30 N"));
}

#[test]
fn truth_a_contact_without_stiffness_at_rest_asks_for_a_force() {
    let settings = [
        "analyze",
        "control/impedance.toml",
        "--set",
        "contacts.tool.law=hertz",
        "--set",
        "contacts.tool.stiffness=5e7",
    ];
    let said = refused(&settings);
    assert!(said.contains("no stiffness without force") && said.contains("--preload 30"), "{said}");
    printed(&[&settings[..], &["--preload", "30"]].concat());
}

#[test]
fn truth_the_loop_of_a_law_of_motion_is_that_of_its_motion_sensor() {
    let text = printed(&["analyze", "control/impedance.toml"]);
    assert!(
        text.contains("(loop from drive.command to motor.position)") && !text.contains("spring_force"),
        "{text}"
    );
    let closed =
        printed(&["analyze", "control/impedance.toml", "--set", "controllers.spring.force_gain=0.5"]);
    assert!(closed.contains("(loop from drive.command to tool.spring_force)"), "{closed}");
}

#[test]
fn truth_the_page_of_an_analysis_has_every_part_and_needs_no_network() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let text = printed(&["analyze", "paper/all-three.toml", "--out", out]);
    assert!(text.contains("limited by: ") && text.contains("report.html"));
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    let parts = [
        "What limits the bandwidth",
        "What to stiffen, lighten or damp first",
        "Modes",
        "Open loop,",
        "Closed loop,",
        "Plant,",
        "Nyquist",
        "Root locus of the continuous loop",
        "Root locus of the sampled loop",
        "The same near z = 1,",
        "Poles and zeros of the plant,",
    ];
    for part in parts {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("src=\"http") && !page.contains("href=\"http") && page.len() < 3_000_000);
    // The root that leaves the circle, at 31.04 Hz and 1 kHz, has its own view.
    let (sin, cos) = (TAU * 31.04e-3).sin_cos();
    let data = data_of(&page);
    let views = data["planes"].as_array().unwrap().iter().filter(|plane| plane["period_s"].is_number());
    let views: Vec<[f64; 4]> =
        views.map(|plane| [0, 1, 2, 3].map(|i| plane["view"][i].as_f64().unwrap())).collect();
    let holds =
        |[left, right, low, high]: &[f64; 4]| (left..right).contains(&&cos) && (low..high).contains(&&sin);
    let narrowest = views.iter().filter(|view| holds(view)).map(|[left, right, ..]| right - left);
    assert!(views.len() == 2 && narrowest.fold(f64::INFINITY, f64::min) < 1.5, "{views:?}");
    let kept: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("analyze.json")).unwrap()).unwrap();
    assert_eq!(kept["sensitivities"].as_array().unwrap().len(), 13);
}

/// Live pages draw these curves too.
#[test]
fn truth_a_sampled_servo_has_a_page_of_theory_and_is_compared() {
    let bench = Bench::new();
    assert_eq!(bench.feeler(&["new", "servo", "--out", "servo.toml"]).code, DONE);
    let said = bench.feeler(&["analyze", "servo.toml", "--out", "theory"]);
    assert_eq!(said.code, DONE, "{}", said.err);
    let page = bench.read("theory/report.html");
    for part in
        ["from servo.force to link.position", "Nyquist's curve", "Root locus of the sampled loop over kp"]
    {
        assert!(page.contains(part) || page.contains(&part.replace('\'', "&#39;")), "{part}");
    }
    let said = bench.feeler(&["compare", "servo.toml", "--set", "actuators.servo.kp=20 N m/rad"]);
    assert_eq!(said.code, DONE, "{}", said.err);
    let margins = said.out.lines().find(|line| line.contains("phase margin")).unwrap();
    assert_eq!(margins.matches('°').count(), 2, "{}", said.out);
}

#[test]
fn truth_a_saturating_velocity_source_is_limited_by_its_force() {
    let with_limit = |limit: &str| {
        let setting = format!("actuators.drive.limit={limit}");
        json(&["analyze", "paper/rigid-source.toml", "--json", "--set", &setting])["limit"]
            .as_str()
            .unwrap()
            .to_owned()
    };
    assert_eq!(with_limit("1"), "saturation");
    assert_eq!(with_limit("1e6"), "rigid-body");
    // The advice refers to the saturation limit.
    let said = printed(&["analyze", "paper/rigid-source.toml", "--set", "actuators.drive.limit=9.5"]);
    let parts = ["at which the drive saturates most: ", "saturation frequency (%)", "actuators.drive.limit"];
    assert!(parts.iter().all(|part| said.contains(part)), "{said}");
    assert!(
        printed(&["analyze", "paper/rigid-source.toml", "--set", "actuators.drive.limit=1"])
            .contains("even at rest")
    );
}

#[test]
fn truth_a_delay_of_hundreds_of_samples_is_analysed_or_refused_with_the_arithmetic() {
    let text = printed(&["analyze", "paper/flexible.toml", "--set", "controllers.force.delay=0.5"]);
    assert!(text.contains("limited by: sampling"), "{text}");
    let said = refused(&[
        "analyze",
        "paper/flexible.toml",
        "--set",
        "sensors.force.delay=0.5",
        "--set",
        "controllers.force.damping=10",
    ]);
    assert!(said.contains("hold 500 samples") && said.contains("lengthen the period"), "{said}");
}

#[test]
fn regress_what_an_analysis_leaves_out_is_listed() {
    for (file, of, property, taken) in [
        ("backlash", "springs.transmission", "backlash", "closed"),
        ("coulomb-friction", "springs.guide", "dry friction", "sliding"),
        ("drive-deadband", "actuators.drive", "deadband", "crossed"),
        ("timing-jitter", "controllers.force", "timing jitter", "a period apart"),
        ("force-limit", "actuators.drive", "force limit", "never reached"),
        ("slew-limit", "actuators.drive", "rate limit", "never reached"),
        ("force-resolution", "sensors.force", "quantisation", "continuous"),
        ("hertz-contact", "contacts.tool", "nonlinear contact law", "tangent at 30 N"),
    ] {
        let path = format!("effects/{file}.toml");
        let found = json(&["analyze", &path, "--json"]);
        let listed = found["assumptions"].as_array().unwrap().iter().any(|assumption| {
            assumption["of"] == of
                && assumption["property"] == property
                && assumption["taken"].as_str().unwrap().contains(taken)
        });
        assert!(listed, "{file}: {}", found["assumptions"]);
        let text = printed(&["analyze", &path]);
        assert!(
            text.lines().any(|line| line.contains(of) && line.contains(property) && line.contains(taken)),
            "{text}"
        );
    }
    // Linear theory covers a linear machine completely.
    assert_eq!(json(&["analyze", "paper/flexible.toml", "--json"])["assumptions"], serde_json::json!([]));
    let folder = tempfile::tempdir().unwrap();
    printed(&["analyze", "effects/backlash.toml", "--out", folder.path().to_str().unwrap()]);
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("What the linear model leaves out") && page.contains("taken as closed"));
}

/// Two bodies on 1e12 N/m, with 1e-6 N/m to the third body: the rounding errors of the stiff springs are far
/// larger.
#[test]
fn regress_poles_of_a_spring_that_rounding_loses_are_not_determined() {
    let springs =
        [("ground", "b0", "1e12"), ("b0", "b1", "1e-6"), ("b1", "b2", "1e12")].map(|(from, to, k)| {
            let between = format!("between = [\"{from}\", \"{to}\"]");
            format!("[bodies.{to}]\nmass = 1.0\n[springs.{to}]\n{between}\nstiffness = {k}\n")
        });
    let text =
        "[actuators.d]\non = \"b0\"\n[sensors.p]\nreads = \"b2.position\"\n".to_owned() + &springs.concat();
    let mut file = tempfile::NamedTempFile::with_suffix(".toml").unwrap();
    file.write_all(text.as_bytes()).unwrap();
    let text = printed(&["analyze", file.path().to_str().unwrap()]);
    let poles = text.lines().skip_while(|line| !line.contains("poles (1/s)")).skip(1);
    let poles: Vec<&str> = poles.take_while(|line| line.starts_with(' ')).collect();
    let lost = poles.iter().filter(|line| line.contains("not determined")).count();
    assert_eq!((poles.len(), lost), (6, 2), "{text}");
}

#[test]
fn regress_the_reason_is_told_where_no_problem_is_named() {
    let text = printed(&[
        "analyze",
        "control/two-rates.toml",
        "--gain",
        "damper.damping",
        "--set",
        "controllers.damper.period=1 ms",
    ]);
    assert!(
        text.contains("controllers.damper samples every 1 ms") && !text.contains("no continuous counterpart"),
        "{text}"
    );
}

#[test]
fn regress_a_row_of_the_account_says_why_it_differs_from_the_one_above() {
    let jump = [
        "analyze",
        "paper/flexible.toml",
        "--set",
        "controllers.force.ki=3",
        "--set",
        "controllers.force.feed_forward=0",
    ];
    let text = printed(&jump);
    let row = text.lines().find(|line| line.trim_start().starts_with("hold")).unwrap();
    assert!(row.contains("integral action ends there: beyond,"), "{text}");
    assert!(
        text.contains("the first limit of the gain")
            && text.contains("lower: the gain above is unstable here"),
        "{text}"
    );
}

#[test]
fn regress_a_number_of_tiny_effect_is_not_recommended() {
    // The integrator has so much delay that the machine behind it has no effect.
    let settings = [
        "controllers.force.kp=0",
        "controllers.force.ki=2",
        "controllers.force.delay=0.2",
        "sensors.force.low_pass=2",
        "springs.guide.damping=1500",
    ];
    let settings = settings.into_iter().flat_map(|setting| ["--set", setting]);
    let text = printed(&["analyze", "paper/rigid.toml"].into_iter().chain(settings).collect::<Vec<_>>());
    assert!(
        !text.contains(", first: ") && text.contains("No single mass, stiffness or damping helps much"),
        "{text}"
    );
}

#[test]
fn regress_a_fit_of_the_landmarks_says_how_many_starts_reach_them() {
    let text = printed(&["fit-landmarks", "--starts", "2"]);
    assert!(
        text.contains("of 2 starts reach every landmark")
            && text.contains("No start depends on an earlier fit."),
        "{text}"
    );
    assert!(!text.contains("Missed by more than"), "{text}");
    let stuck = printed(&["fit-landmarks", "--starts", "1", "--iterations", "0"]);
    assert!(
        stuck.contains("0 of 1 start reaches every landmark") && stuck.contains("Missed by more than 1 Hz"),
        "{stuck}"
    );
}

/// At one sample per common period, a motion of 502.8 Hz appears as 2.8 Hz. If both controllers have the same
/// period, there is no aliasing.
#[test]
fn regress_an_edge_of_two_rates_has_the_frequency_at_which_the_bodies_move() {
    let asked = [
        "analyze",
        "control/two-rates.toml",
        "--gain",
        "damper.damping",
        "--set",
        "controllers.damper.period=0.5 ms",
    ];
    let swings = |hz: &str| format!("oscillates at {hz} Hz");
    let text = printed(&asked);
    assert!(text.contains(&swings("502.9")), "{text}");
    let text = printed(&[&asked[..], &["--set", "controllers.force.period=0.5 ms"]].concat());
    assert!(text.contains(&swings("502.8")), "{text}");
}
