//! `feeler run` with Rapier, and with the integrator that takes less time.

use serde_json::Value;

use crate::bench::{BAD_INPUT, Bench, DONE, PRESS};
use crate::run::summary;

#[test]
fn truth_another_engine_moves_the_bodies_and_agrees() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    assert_eq!(bench.feeler(&["run", "press.toml", "--out", "own"]).code, DONE);
    assert_eq!(
        bench
            .feeler(&["run", "press.toml", "--engine", "rapier", "--set", "run.step=25 us", "--out", "other"])
            .code,
        DONE
    );
    let [own, other] = ["own", "other"].map(|folder| summary(&bench, folder));
    assert_eq!(own["outcome"], other["outcome"]);
    let peak = |summary: &Value| summary["peak_force_n"].as_f64().unwrap();
    assert!((peak(&other) / peak(&own) - 1.0).abs() < 0.02, "{} {}", peak(&own), peak(&other));
    let unknown = bench.feeler(&["run", "press.toml", "--engine", "bullet"]);
    assert_eq!(unknown.code, BAD_INPUT);
    bench.write("bad.toml", &(PRESS.to_owned() + "engine = \"bullet\"\n"));
    let said = bench.feeler(&["run", "bad.toml"]);
    assert_eq!(said.code, BAD_INPUT);
    assert!(said.err.contains("rapier"), "{}", said.err);
    let stepped = PRESS.to_owned() + "integrator = \"rk4\"\n";
    bench.write("both.toml", &stepped);
    let said = bench.feeler(&["run", "both.toml", "--engine", "rapier"]);
    assert!(
        said.code == BAD_INPUT
            && said.err.contains("run.integrator")
            && said.err.contains("leave one of them out"),
        "{}",
        said.err
    );
}

/// 5 N m act on 1 g m² for 0.16 s. After that, the body rotates by more than an eighth of a turn per step of
/// 1 ms.
#[test]
fn regress_a_body_that_becomes_too_fast_for_rapier_is_no_instability() {
    let bench = Bench::new();
    let turning = "axis = \"rotational\"\n[bodies.tip]\nmass = \"0.001 kg m2\"\n[springs.guide]\nbetween = \
                   [\"ground\", \"tip\"]\n\
        damping = \"0.005 N m s/rad\"\n[actuators.drive]\non = \"tip\"\n[controllers.torque]\nlaw \
        = \"open-loop\"\ndrives = \"drive\"\n\
        period = \"1 ms\"\nreference = 5\n[run]\nduration = \"0.5 s\"\nstep = \"1 ms\"\n";
    bench.write("turning.toml", turning);
    let said = bench.feeler(&["run", "turning.toml", "--engine", "rapier"]);
    assert_eq!(said.code, BAD_INPUT, "{}", said.out);
    assert!(
        said.err.contains("run.step")
            && said.err.contains("Rapier follows a turn of at most 0.785 rad per step"),
        "{}",
        said.err
    );
    assert_eq!(bench.feeler(&["run", "turning.toml"]).code, DONE);
}

#[test]
fn truth_a_long_chain_is_stepped_by_what_takes_less_time_and_told_so() {
    let bench = Bench::new();
    let chain = |bodies: usize, stiffness: f64| {
        let body = |i: usize| format!("[bodies.b{i}]\nmass = 1.0\n");
        let spring = |i: usize| {
            format!("[springs.s{i}]\nbetween = [\"b{i}\", \"b{}\"]\nstiffness = {stiffness:?}\n", i + 1)
        };
        let bodies_text: String = (0..bodies).map(body).collect();
        let springs: String = (0..bodies - 1).map(spring).collect();
        format!("{bodies_text}{springs}[run]\nduration = \"1 ms\"\n")
    };
    bench.write("long.toml", &chain(33, 1e3));
    bench.write("stiff.toml", &chain(33, 1e9));
    bench.write("short.toml", &chain(32, 1e3));
    let less = "With 33 bodies RK4 takes less time than the exact integrator";
    let long = bench.feeler(&["run", "long.toml"]).out;
    assert!(long.contains(&format!("{less}. This run has steps of")), "{long}");
    // Each body has two springs: |s|^2 <= 2 * 2e9 / 1, and a step is at most the inverse of |s|.
    let stiff = bench.feeler(&["run", "stiff.toml"]).out;
    assert!(
        stiff.contains(&format!("{less}, but not with steps of 100 µs")) && stiff.contains("15.81 µs"),
        "{stiff}"
    );
    for arguments in
        [["run", "short.toml", "--out", "a"].as_slice(), &["run", "long.toml", "--integrator", "exact"]]
    {
        let said = bench.feeler(arguments);
        assert_eq!(said.code, DONE, "{}", said.err);
        assert!(!said.out.contains("takes less time"), "{}", said.out);
    }
}
