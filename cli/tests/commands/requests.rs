//! Requests of linear theory and experiments that cannot be met.

use crate::bench::refused;

#[test]
fn truth_bad_requests_are_refused_with_what_to_do() {
    let cases: [(&[&str], &str); 22] = [
        (
            &["frf", "paper/rigid.toml", "--output", "tol.force"],
            "no signal `tol.force`\n  help: did you mean `tool.force`? there is `motor.position`",
        ),
        (&["frf", "paper/rigid.toml", "--input", "force.reading"], "is not an input"),
        (&["frf", "paper/rigid.toml", "--to", "600"], "frequencies end at 500 Hz"),
        (
            &["frf", "paper/rigid.toml", "--excitation", "multisine", "--period", "0.0137772"],
            "not a whole number of holds",
        ),
        (&["frf", "paper/rigid.toml", "--experiment", "a.csv"], "this is a scenario"),
        (&["analyze", "paper/rigid.toml", "--gain", "controllers.force.kq"], "has no gain `kq`"),
        (&["frf", "paper/rigid.toml", "--segment", "4"], "averages nothing"),
        (&["frf", "paper/rigid.toml", "--segment", "4", "--excitation", "chirp"], "averages nothing"),
        (
            &["frf", "datasets/bench-axis", "--set", "bodies.tip.mass=6"],
            "--set applies to a simulated experiment",
        ),
        (&["frf", "datasets/bench-axis", "--offset", "1"], "--offset applies to a simulated experiment"),
        (&["frf", "datasets/bench-axis", "--periods", "3"], "--periods applies to a simulated experiment"),
        (
            &["frf", "datasets/bench-axis", "--realisations", "3"],
            "--realisations applies to a simulated experiment",
        ),
        (&["frf", "datasets/bench-axis", "--points", "3"], "--points applies to a simulated experiment"),
        (
            &["frf", "paper/rigid.toml", "--points", "3"],
            "--points has no meaning for --excitation white-noise",
        ),
        (&["frf", "paper/rigid.toml", "--from", "-3"], "no band from -3"),
        (
            &["frf", "paper/rigid.toml", "--excitation", "stepped-sine", "--points", "100000"],
            "at most 1e8 are possible",
        ),
        (
            &["frf", "paper/rigid.toml", "--free", "--output", "tool.force"],
            "drive.command does not reach tool.force",
        ),
        (
            &["frf", "datasets/bench-axis", "--output", "force_n"],
            "drive.command does not reach force.reading",
        ),
        (&["frf", "sweeps/boundary.toml"], "this is a sweep file"),
        (&["why", "sweeps/boundary.toml"], "`feeler sweep` takes it"),
        (&["analyze", "arms/six-joint.toml"], "`feeler reduce` takes it"),
        (&["run", "datasets/bench-axis/dataset.toml"], "`feeler diagnose` takes it"),
    ];
    for (arguments, expected) in cases {
        let said = refused(arguments);
        assert!(said.contains(expected) && said.contains("help:"), "{arguments:?}: {said}");
    }
}

#[test]
fn regress_mistakes_of_a_request_name_what_there_is() {
    for (arguments, parts) in [
        (
            &["analyze", "paper/flexible.toml", "--gain", "nope.kp"][..],
            &["no controller `nope`", "being `force`"][..],
        ),
        (&["analyze", "paper/flexible.toml", "--gain", "force.kq"], &["no gain `kq`", "kp, ki, kd"]),
        (
            &["analyze", "paper/flexible.toml", "--preload", "-3"],
            &["--preload must be a force above zero (got -3 N)", "--preload 30"],
        ),
        (&["frf", "paper/flexible.toml", "--from", "0"], &["no band from 0", "must be above zero"]),
        (&["frf", "paper/flexible.toml", "--from", "50", "--to", "5"], &["ends before it begins"]),
        (
            &["fit-landmarks", "--start", "paper/machines/flexible.toml"],
            &["paper/machines/flexible.toml", "not a velocity source", "--out FILE"],
        ),
    ] {
        let said = refused(arguments);
        assert!(parts.iter().all(|part| said.contains(part)), "{arguments:?}: {said}");
    }
}
