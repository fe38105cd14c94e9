//! Files that name other files: base machines, references, sweeps, datasets.

use std::fs;
use std::io::Write as _;
use std::path::Path;

use feeler_control::ReferenceSpec;
use feeler_files::{
    DatasetFile, Document, Draft, ExperimentRole, FormatError, Sampling, Setting, SweepAxis, SweepFile,
    followed_by,
};

use crate::COMPLETE;

#[expect(clippy::unwrap_used, reason = "without its files the test has failed")]
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

#[test]
#[expect(clippy::float_cmp, reason = "values are taken over, not computed")]
fn truth_a_file_builds_on_a_machine() {
    let over = "machine = \"base.toml\"\nname = \"soft\"\n[contacts.tool]\nstiffness = \
                1e4\n[springs.guide.effects.viscous-friction]\ndamping = 3.0\n\
                [controllers.force]\nreference = 5.0\n";
    let folder = folder(&[("base.toml", COMPLETE), ("over.toml", over)]);
    let scenario = Document::load(&folder.path().join("over.toml")).unwrap().scenario;
    assert_eq!(scenario.machine.name, "soft");
    assert_eq!(scenario.machine.contacts["tool"].stiffness, 1e4);
    assert_eq!(scenario.machine.contacts["tool"].damping_n_s_per_m, 120.0);
    assert_eq!(scenario.machine.springs["guide"].effects.len(), 2);
    assert_eq!(scenario.controllers["force"].spec.reference, ReferenceSpec::Constant(5.0));
}

/// Two files of one name would share a folder of results.
#[test]
fn truth_the_name_of_a_base_is_not_that_of_the_file() {
    let folder = folder(&[("base.toml", COMPLETE), ("over.toml", "machine = \"base.toml\"\n")]);
    let mut draft = Draft::load(&folder.path().join("over.toml")).unwrap();
    let name = |draft: &Draft| draft.clone().build().unwrap().scenario.machine.name;
    assert_eq!(name(&draft), "over");
    draft.set("name=other").unwrap();
    assert_eq!(name(&draft), "other");
}

#[test]
fn truth_a_mistake_in_the_base_names_the_base() {
    let folder = folder(&[
        ("base.toml", &COMPLETE.replace("mass = 7.0", "mass = -7.0")),
        ("over.toml", "machine = \"base.toml\"\n"),
    ]);
    let error = Document::load(&folder.path().join("over.toml")).unwrap_err();
    assert!(error.problems[0].file.ends_with("base.toml"), "{error}");
    let line = COMPLETE.lines().position(|line| line == "mass = 7.0").unwrap() + 1;
    assert_eq!(error.problems[0].line, line);
}

#[test]
fn truth_files_that_build_on_themselves_are_refused() {
    let folder = folder(&[("loop.toml", "machine = \"loop.toml\"\n")]);
    let error = Document::load(&folder.path().join("loop.toml")).unwrap_err();
    assert!(error.to_string().contains("more than 8 files build on each other"), "{error}");
    let error = Document::parse("machine = \"absent.toml\"\n", "here.toml").unwrap_err();
    assert_eq!((error.problems[0].line, error.problems[0].column), (1, 11), "{error}");
}

#[test]
fn truth_a_reference_is_read_from_its_file() {
    let text = COMPLETE.replace(
        "reference = [[0.0, 20.0], [1.2, 30.0]]",
        "reference = { kind = \"file\", file = \"force.csv\" }",
    );
    let good = folder(&[("run.toml", &text), ("force.csv", "t_s,value\n0,1.5\n0.25, 2\n")]);
    let scenario = Document::load(&good.path().join("run.toml")).unwrap().scenario;
    let ReferenceSpec::Table { times_s, values, .. } = &scenario.controllers["force"].spec.reference else {
        panic!()
    };
    assert_eq!((times_s.as_slice(), values.as_slice()), ([0.0, 0.25].as_slice(), [1.5, 2.0].as_slice()));
    for (csv, expected) in [
        ("time,f\n0,1\n", "its header is"),
        ("t_s,value\n0,1\n0,2\n", "line 3"),
        ("t_s,value\n", "no samples"),
        ("t_s,value\n0,nan\n", "finite"),
    ] {
        let bad = folder(&[("run.toml", &text), ("force.csv", csv)]);
        let error = Document::load(&bad.path().join("run.toml")).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
        assert_eq!(error.problems[0].key, "controllers.force.reference.file");
    }
}

const SWEEP: &str = "scenario = \"chatter.toml\"\n[axes]\n\"controllers.force.kp\" = { log = [0.05, 5.0], \
                     points = 64 }\n\
    \"contacts.tool.stiffness\" = { log = [\"10 kN/m\", 1e7], points = 64 }\n\"run.integrator\" = \
    [\"exact\", \"rk4\"]\n[keep]\noutcome = true\n";

#[test]
fn truth_a_sweep_is_read() {
    let folder = folder(&[("sweep.toml", SWEEP), ("chatter.toml", COMPLETE)]);
    let sweep = SweepFile::load(&folder.path().join("sweep.toml")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(sweep.sampling, Sampling::Grid);
    assert_eq!(sweep.samples, 64 * 64 * 2);
    assert_eq!(sweep.axes["contacts.tool.stiffness"], SweepAxis::Log { from: 1e4, to: 1e7, points: 64 });
    assert_eq!(sweep.axes["contacts.tool.stiffness"].point(0), Setting::Number(1e4));
    assert_eq!(sweep.axes["contacts.tool.stiffness"].point(63), Setting::Number(1e7));
    assert_eq!(sweep.axes["run.integrator"].point(1), Setting::Text("rk4".into()));
    assert!(sweep.keep.outcome && !sweep.keep.traces);
}

#[test]
fn truth_mistakes_of_a_sweep_are_reported_together() {
    let sweep = "scenario = \"chatter.toml\"\nsampling = \"grid\"\nsamples = \
                 10\n[axes]\n\"controllers.force.kp\" = { log = [-1.0, 5.0], points = 64 }\n\
        \"run.seed\" = { uniform = [1, 9] }\n\"contacts.tool.gap\" = { linear = [0, 1], point = 3 \
        }\n\"bodies.tip.mass\" = []\n\
        \"bodies.base.mass\" = { linear = [1, 2], uniform = [1, 2], points = 2 }\n[kep]\n";
    insta::assert_snapshot!(SweepFile::parse(sweep, "sweep.toml").unwrap_err().report(false));
}

#[test]
fn truth_the_ends_of_axes_are_tried() {
    let sweep = "scenario = \"chatter.toml\"\n[axes]\n\"bodies.tip.mass\" = { linear = [-1, 5], points = 3 \
                 }\n\"contacts.tool.gap\" = [\"1 mm\", \"1 kg\"]\n\
        \"controllers.forse.kp\" = [1.0]\n";
    let folder = folder(&[("sweep.toml", sweep), ("chatter.toml", COMPLETE)]);
    let error = SweepFile::load(&folder.path().join("sweep.toml")).unwrap_err();
    let messages: Vec<String> = error
        .problems
        .iter()
        .map(|p| format!("{}:{} {} | {}", p.line, p.column, p.message, p.remedy))
        .collect();
    insta::assert_snapshot!(messages.join("\n"));
}

/// One level must stay above the other. The axes are overlapping ranges, lists and ranges that never overlap,
/// and a value that is wrong by itself.
#[test]
fn regress_a_value_that_needs_another_axis_is_refused_only_where_no_combination_is_right() {
    let refused = |coulomb: &str, at_rest: &str| {
        let sweep = format!(
            "scenario = \"chatter.toml\"\n[axes]\n\"springs.guide.effects.stribeck-friction.coulomb\" = \
             {coulomb}\n\
             \"springs.guide.effects.stribeck-friction.static\" = \
             {at_rest}\n\"springs.guide.effects.stribeck-friction.velocity\" = [0.01]\n"
        );
        let folder = folder(&[("sweep.toml", &sweep), ("chatter.toml", COMPLETE)]);
        SweepFile::load(&folder.path().join("sweep.toml"))
            .map_or_else(|error| error.report(false), |_| String::new())
    };
    assert_eq!(refused("{ linear = [1.0, 10.0], points = 10 }", "{ linear = [2.0, 8.0], points = 10 }"), "");
    let never = refused("[10.0, 12.0]", "[2.0, 8.0]");
    assert!(never.contains("below") && !never.contains("missing"), "{never}");
    let range = refused("{ linear = [10.0, 12.0], points = 3 }", "{ linear = [2.0, 8.0], points = 3 }");
    for refused in [&range, &never] {
        assert!(
            refused.contains("every combination of the ends is invalid; the first: with 10")
                && refused.contains("1 mistake"),
            "{refused}"
        );
    }
    let listed = refused("[1.0, 12.0]", "[2.0, 8.0]");
    assert!(listed.contains("coulomb\": with 12") && listed.contains("1 mistake"), "{listed}");
    let own = refused("[-1.0, 1.0]", "[2.0, 8.0]");
    assert!(own.contains("with -1") && !own.contains("missing"), "{own}");
}

/// The report of a sweep of the complete scenario; empty without mistakes.
fn report_of(text: &str) -> String {
    let folder = folder(&[
        ("sweep.toml", &format!("scenario = \"chatter.toml\"\n{text}")),
        ("chatter.toml", COMPLETE),
    ]);
    SweepFile::load(&folder.path().join("sweep.toml"))
        .map_or_else(|error| error.report(false), |_| String::new())
}

#[test]
fn regress_a_distribution_the_wrong_way_round_is_refused() {
    for kind in ["uniform", "log_uniform"] {
        let report = |ends: &str| {
            report_of(&format!("samples = 5\n[axes]\n\"controllers.force.kp\" = {{ {kind} = {ends} }}\n"))
        };
        assert_eq!(report("[1.0, 2.0]"), "");
        let reversed = report("[2.0, 1.0]");
        assert!(
            reversed.contains(&format!("axes.\"controllers.force.kp\".{kind}"))
                && reversed.contains("write [1, 2]"),
            "{reversed}"
        );
        assert!(report("[2.0, 2.0]").contains("nothing to draw from"));
    }
}

#[test]
fn regress_spaced_values_are_not_drawn_from() {
    let report = |sampling: &str| {
        let head = if sampling == "grid" {
            String::new()
        } else {
            format!("sampling = \"{sampling}\"\nsamples = 10\n")
        };
        report_of(&format!(
            "{head}[axes]\n\"controllers.force.kp\" = {{ linear = [0.1, 1.0], points = 10 }}\n\"run.seed\" \
             = [1, 2]\n"
        ))
    };
    assert_eq!(report("grid"), "");
    for sampling in ["random", "latin-hypercube", "sobol"] {
        let report = report(sampling);
        assert!(
            report.contains("controllers.force.kp") && report.contains("uniform = [from, to]"),
            "{report}"
        );
    }
}

#[test]
fn regress_an_element_is_no_axis() {
    let report = report_of("[axes]\n\"controllers.force\" = [1.0, 2.0]\n");
    assert!(
        report.contains("is a whole table")
            && report.contains("name one of its keys")
            && report.contains("1 mistake"),
        "{report}"
    );
}

#[test]
fn truth_diagrams_over_one_axis_of_numbers_keep_their_impacts_for_every_value_of_a_list() {
    let tail = |axes: &str| {
        let text = format!(
            "scenario = \"chatter.toml\"\n[axes]\n\"controllers.force.kp\" = {{ linear = [0.1, 1.0], points \
             = 3 }}\n{axes}"
        );
        let folder = folder(&[("sweep.toml", &text), ("chatter.toml", COMPLETE)]);
        SweepFile::load(&folder.path().join("sweep.toml")).unwrap_or_else(|error| panic!("{error}")).keep.tail
    };
    assert_eq!(
        (tail(""), tail("\"run.seed\" = [1, 2]\n"), tail("\"run.seed\" = { linear = [1, 2], points = 2 }\n")),
        (64, 64, 0)
    );
}

#[test]
fn regress_one_point_between_two_ends_is_refused() {
    for kind in ["linear", "log"] {
        let sweep = format!(
            "scenario = \"chatter.toml\"\n[axes]\n\"bodies.tip.mass\" = {{ {kind} = [4, 6], points = 1 }}\n"
        );
        let folder = folder(&[("sweep.toml", &sweep), ("chatter.toml", COMPLETE)]);
        let report = SweepFile::load(&folder.path().join("sweep.toml")).unwrap_err().report(false);
        assert!(
            report.contains("axes.\"bodies.tip.mass\".points: with one point the end, 6, is left out")
                && report.contains("[4]"),
            "{report}"
        );
    }
    let same = "scenario = \"chatter.toml\"\n[axes]\n\"bodies.tip.mass\" = { linear = [4, 4], points = 1 }\n";
    let folder = folder(&[("sweep.toml", same), ("chatter.toml", COMPLETE)]);
    assert!(SweepFile::load(&folder.path().join("sweep.toml")).is_ok());
}

/// `axes` of a sweep over the complete machine, and the rest of the file.
fn refined(axes: &str) -> Result<SweepFile, FormatError> {
    let sweep = format!("scenario = \"chatter.toml\"\n[axes]\n{axes}");
    let folder = folder(&[("sweep.toml", &sweep), ("chatter.toml", COMPLETE)]);
    SweepFile::load(&folder.path().join("sweep.toml"))
}

#[test]
fn truth_a_tolerance_tells_how_often_spacings_are_halved() {
    let kp = |tolerance: &str| {
        format!("\"controllers.force.kp\" = {{ log = [0.1, 10.0], points = 5{tolerance} }}\n")
    };
    let wall = |tolerance: &str| {
        format!(
            "\"contacts.tool.stiffness\" = {{ linear = [\"10 kN/m\", \"100 kN/m\"], points = 4{tolerance} \
             }}\n"
        )
    };
    for (axes, levels) in [
        // ln 100 / 4 / ln 1.02 = 58.1.
        (kp(", tolerance = \"2 %\"") + "[refine]\n", [6, 4]),
        // 30 kN/m / 2 kN/m = 15.
        (wall(", tolerance = \"2 kN/m\"") + "[refine]\n", [4, 4]),
        // Each axis has its own tolerance.
        (kp(", tolerance = 0.02") + &wall(", tolerance = \"2 N/mm\"") + "[refine]\n", [6, 4]),
        // A spacing of a quarter and of a third of an axis, bisected down to a hundredth.
        (kp("") + &wall("") + "[refine]\ntolerance = 0.01\n", [5, 6]),
        (kp("") + "[refine]\ntolerance = \"12.5 %\"\n", [1, 4]),
        (kp("") + "[refine]\n", [4, 4]),
        (kp("") + "[refine]\nlevels = 2\n", [2, 2]),
    ] {
        let refine = refined(&axes).unwrap_or_else(|error| panic!("{error}")).refine.unwrap();
        assert_eq!(refine.levels, levels, "{axes}");
    }
    for (axes, expected) in [
        (kp(", tolerance = 0.02") + "[refine]\nlevels = 2\n", "say the same thing"),
        (kp(", tolerance = 0.02"), "add [refine]"),
        (kp(", tolerance = \"2 N\"") + "[refine]\n", "as in \"2 %\""),
        (wall(", tolerance = \"2 mm\"") + "[refine]\n", "another kind than the ends"),
        (wall(", tolerance = \"2 mN/m\"") + "[refine]\n", "24 halvings"),
        (wall(", tolerance = -2") + "[refine]\n", "is out of range"),
    ] {
        let error = refined(&axes).unwrap_err();
        assert_eq!(error.problems.len(), 1, "{error}");
        assert!(error.to_string().contains(expected) && error.problems[0].line > 2, "{error}");
    }
}

/// Mistakes in the form of one axis do not hide wrong keys and values of others.
#[test]
fn regress_mistakes_of_form_and_of_meaning_are_reported_together() {
    let axes = "\"controllers.force.kpp\" = { log = [0.05, 5.0] }\n\"contacts.tool.gap\" = [\"1 kg\", [2]]\n\
        \"contacts.tool.stiffness\" = { log = [\"10 kN\", \"1 MN/m\"], points = 9 }\n\"bodies.tip.mass\" = \
        { linear = [-1, -2], points = 3 }\n\
        \"run.seed\" = { linear = [1, 9] }\n";
    let error = refined(axes).unwrap_err();
    let messages: Vec<String> =
        error.problems.iter().map(|p| format!("{}:{} {}", p.line, p.column, p.message)).collect();
    insta::assert_snapshot!(messages.join("\n"));
    assert!(error.problems.iter().all(|problem| !problem.remedy.is_empty()), "{error}");
}

#[test]
fn truth_a_dataset_is_read() {
    let dataset = "name = \"bench\"\nmachine = \"machine.toml\"\n[columns.command_n]\nsignal \
                   = \"drive.command\"\nhold = \"1 ms\"\n[columns.force_n]\n\
        signal = \"force.reading\"\nnoise = \"0.2 N\"\n[[experiments]]\nfile = \"a.csv\"\nengagement \
        = \"free\"\nrole = \"fit\"\n[[experiments]]\nfile = \"b.csv\"\nrepeat = \"again\"\n";
    let files =
        [("dataset.toml", dataset), ("machine.toml", COMPLETE), ("a.csv", "t_s\n"), ("b.csv", "t_s\n")];
    let good = folder(&files);
    let read = DatasetFile::load(good.path()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(read.columns["command_n"].hold_s, Some(1e-3));
    assert_eq!(read.columns["force_n"].noise, Some(0.2));
    assert_eq!(read.experiments[0].role, Some(ExperimentRole::Fit));
    assert_eq!(read.experiments[1].repeat.as_deref(), Some("again"));

    let wrong = dataset
        .replace("force.reading", "forse.reading")
        .replace("b.csv", "c.csv")
        .replace("\"fit\"", "\"fitt\"")
        .replace("0.2 N", "0.2 m");
    let bad = folder(&[("dataset.toml", &wrong), files[1], files[2]]);
    let error = DatasetFile::load(bad.path()).unwrap_err();
    let lines: Vec<String> =
        error.problems.iter().map(|p| format!("{}:{} {}", p.line, p.column, p.key)).collect();
    assert_eq!(
        lines,
        [
            "7:10 columns.force_n.signal",
            "8:9 columns.force_n.noise",
            "12:8 experiments[0].role",
            "14:8 experiments[1].file"
        ],
        "{error}"
    );
}

#[test]
fn truth_a_column_may_be_what_a_controller_followed() {
    let dataset = "machine = \"machine.toml\"\n[columns.wanted]\nsignal = \"controllers.force.reference\"\n\
        unit = \"kN\"\n[[experiments]]\nfile = \"a.csv\"\n";
    let read = |text: &str, machine: &str| {
        let files = folder(&[("dataset.toml", text), ("machine.toml", machine), ("a.csv", "t_s\n")]);
        DatasetFile::load(files.path())
    };
    let found = read(dataset, COMPLETE).unwrap_or_else(|error| panic!("{error}"));
    let column = &found.columns["wanted"];
    assert_eq!((followed_by(&column.signal), column.scale), (Some("force"), 1e3));
    let second = format!(
        "{COMPLETE}\n[controllers.second]\nlaw = \"open-loop\"\ndrives = \"drive\"\nperiod = \"1 ms\"\n"
    );
    for (text, machine, said) in [
        (dataset.replace("force.ref", "forse.ref"), COMPLETE, "has no controller `forse`"),
        (dataset.into(), &*second, "`second` drives `drive` too"),
        (dataset.replace("kN", "mm"), COMPLETE, "mm"),
        (dataset.replace("unit = \"kN\"", "scale = 0.0"), COMPLETE, "a factor of zero"),
    ] {
        let error = read(&text, machine).unwrap_err();
        assert!(error.problems.len() == 1 && error.problems[0].message.contains(said), "{said}: {error}");
        assert!(!error.problems[0].remedy.is_empty());
    }
}

#[test]
fn truth_practice_datasets_are_read() {
    let practice = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/blind/practice");
    let Ok(cases) = fs::read_dir(&practice) else {
        // `eprintln!` would not be shown, because a passing test captures its output.
        let _ = writeln!(std::io::stderr(), "skipped: {} is absent", practice.display());
        return;
    };
    for case in cases.map(|case| case.unwrap().path()).filter(|case| case.is_dir()) {
        let read = DatasetFile::load(&case).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(read.columns.len(), 5);
    }
}
