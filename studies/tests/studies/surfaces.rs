//! Contacts between shapes: their keys in files, the effect of travel over a surface on the force, and
//! mistakes in files.

use std::f64::consts::TAU;
use std::path::Path;

use feeler_files::Document;
use feeler_studies::run::run;

/// A mass on a clamped contact with the surface, driven by nothing.
const AXIS: &str = r#"
[bodies.tip]
mass = 8.0
[springs.guide]
between = ["ground", "tip"]
damping = 300.0
[contacts.tool]
between = ["tip", "ground"]
engagement = "clamped"
stiffness = 4e4
damping = 50.0
"#;

fn parse(folder: &Path, surface: &str) -> Result<Document, String> {
    let text = format!(
        "{AXIS}\n[contacts.tool.surface]\n{surface}\n[run]\nduration = 4.0\nrecord = \
         [\"tool.force\"]\nrecord_rate = 1000.0\n"
    );
    Document::parse(&text, &folder.join("axis.toml").to_string_lossy()).map_err(|error| error.to_string())
}

/// Amplitude of a record's part at `frequency_hz`, over whole periods.
fn amplitude(values: &[f64], spacing_s: f64, frequency_hz: f64) -> f64 {
    let angle = |i: usize| TAU * frequency_hz * spacing_s * i as f64;
    let [c, s] =
        [f64::cos, f64::sin].map(|f| values.iter().enumerate().map(|(i, x)| x * f(angle(i))).sum::<f64>());
    2.0 * c.hypot(s) / values.len() as f64
}

/// A ball of radius r over y = A cos(q s): its centre moves on the parallel curve, whose fundamental comes
/// from quadrature.
fn parallel_fundamental(a: f64, q: f64, r: f64) -> f64 {
    let n = 20_000;
    let mut sum = 0.0;
    let curve = |i: i32| {
        let s = TAU / q * f64::from(i) / f64::from(n);
        let (h, slope) = (a * (q * s).cos(), -a * q * (q * s).sin());
        let norm = slope.hypot(1.0);
        (s - r * slope / norm, h + r / norm)
    };
    for i in 0..n {
        let ((y0, h0), (y1, h1)) = (curve(i), curve(i + 1));
        sum += 0.5 * (h0 * (q * y0).cos() + h1 * (q * y1).cos()) * (y1 - y0);
    }
    sum * q / (TAU / 2.0)
}

#[test]
fn truth_travel_over_a_sine_is_the_analytic_disturbance_response() {
    let folder = tempfile::tempdir().unwrap();
    let (a, wavelength, r, speed) = (2e-4, 20e-3, 10e-3, 60e-3);
    let (columns, extent) = (801, 0.26);
    let line: Vec<String> = (0..columns)
        .map(|k| {
            let y = extent * (f64::from(k) / f64::from(columns - 1) - 0.5);
            (a * (TAU * y / wavelength).cos()).to_string()
        })
        .collect();
    std::fs::write(folder.path().join("sine.csv"), format!("{0}\n{0}\n", line.join(","))).unwrap();
    let surface = format!(
        "tip = {{ shape = \"ball\", radius = {r} }}\n\
         workpiece = {{ shape = \"height-field\", file = \"sine.csv\", extent_y = {extent}, extent_z = \
         0.04, x = 0.0102 }}\n\
         feed = {{ y = -0.12, velocity_y = {speed}, duration = 4.0 }}"
    );
    let document = parse(folder.path(), &surface).unwrap();
    let result = run(&document.scenario, &mut |_| {}).unwrap();
    let force = result.trace.column("tool.force").unwrap();
    let frequency_hz = speed / wavelength;
    // The transient has decayed (8 kg over 350 N s/m: 23 ms) and whole periods remain.
    let found = amplitude(&force[1000..4000], 1e-3, frequency_hz);
    // F = (k + c s) (x - w), m s^2 x + b s x = -F: |F| = |(k + c s)(m s^2 + b s) / (m s^2 + (b + c) s + k)|
    // |w|.
    let (m, b, k, c, w) = (8.0, 300.0, 4e4, 50.0, TAU * frequency_hz);
    let contact = (k, c * w);
    let free = (-m * w * w, b * w);
    let size = |(re, im): (f64, f64)| f64::hypot(re, im);
    let expected = size(contact) * size(free) / size((free.0 + contact.0, free.1 + contact.1))
        * parallel_fundamental(a, TAU / wavelength, r);
    // Chords of 0.325 mm lie up to A q^2 h^2 / 8 = 0.26 um under the waves' 200 um, on one side. In the mean
    // this is two thirds of that: 1.7e-3 with the ends.
    let chords = 2e-3;
    assert!((found / expected - 1.0).abs() < chords, "{found} N for {expected} N");
}

#[test]
fn truth_hertz_follows_from_materials_and_radii() {
    let material = "material = { youngs_modulus = 210e9, poisson_ratio = 0.3 }";
    let text = |law: &str, workpiece: &str| {
        format!(
            "[bodies.tip]\nmass = 8.0\n[contacts.tool]\nbetween = [\"tip\", \"ground\"]\nlaw \
             = \"{law}\"\n[contacts.tool.surface]\n\
             tip = {{ shape = \"ball\", radius = 5e-3, {material} }}\nworkpiece = {{ {workpiece}, x = 1.0, \
             {material} }}\nfeed = {{ duration = 1.0 }}\n"
        )
    };
    let parse = |law: &str, workpiece: &str| {
        Document::parse(&text(law, workpiece), "hertz.toml").map_err(|error| error.to_string())
    };
    let flat = parse("hertz", "shape = \"cuboid\", half_x = 0.1, half_y = 0.1, half_z = 0.1").unwrap();
    // 4/3 E* sqrt(R), E* = 210e9 / (2 (1 - 0.09)), R = 5 mm.
    let expected = 4.0 / 3.0 * 210e9 / 1.82 * f64::sqrt(5e-3);
    assert!((flat.scenario.machine.contacts["tool"].stiffness / expected - 1.0).abs() < 1e-12);
    let missing = parse("kelvin-voigt", "shape = \"ball\", radius = 0.1").unwrap_err();
    assert!(missing.contains("`stiffness` is missing"), "{missing}");
    let line = parse("hertz", "shape = \"cylinder\", radius = 0.1, half_length = 0.1").unwrap_err();
    assert!(line.contains("do not touch in a point"), "{line}");
}

#[test]
fn truth_bad_surfaces_are_one_clear_error_each() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("text.obj"), "v 0 0 0\nv 1 x 0\n").unwrap();
    std::fs::write(folder.path().join("part.step"), "ISO-10303-21;").unwrap();
    std::fs::write(folder.path().join("path.csv"), "t_s,y_m,z_m\n0,0,0\n1,0.5,0\n").unwrap();
    let ball = "tip = { shape = \"ball\", radius = 2e-3 }";
    let still = "feed = { duration = 1.0 }";
    let block = |x: f64| {
        format!("workpiece = {{ shape = \"cuboid\", half_x = 0.01, half_y = 0.01, half_z = 0.01, x = {x} }}")
    };
    let mesh = |file: &str| format!("{ball}\nworkpiece = {{ shape = \"mesh\", file = \"{file}\" }}\n{still}");
    let cases: [(String, &[&str]); 8] = [
        (mesh("absent.stl"), &["absent.stl", "No such file"]),
        (mesh("text.obj"), &["text.obj", "line 2"]),
        (mesh("part.step"), &["`step` is not a mesh format", "STL or OBJ"]),
        (
            format!("{ball}\n{}\nfeed = {{ velocity_y = 0.1, duration = 1.0 }}", block(0.1)),
            &["does not meet the workpiece", "move the workpiece"],
        ),
        (
            format!("{ball}\n{}\nfeed = {{ kind = \"path\", file = \"path.csv\" }}", block(0.1)),
            &["does not meet the workpiece"],
        ),
        (
            format!("tip = {{ shape = \"bal\", radius = 2e-3 }}\n{}\n{still}", block(0.1)),
            &["no shape `bal`", "did you mean `ball`"],
        ),
        (format!("tip = {{ shape = \"ball\", radius = \"2 kg\" }}\n{}\n{still}", block(0.1)), &["radius"]),
        (format!("{ball}\n{still}"), &["`workpiece` is missing"]),
    ];
    for (surface, said) in cases {
        let error = parse(folder.path(), &surface).unwrap_err();
        assert!(said.iter().all(|part| error.contains(part)), "{surface}\n{error}");
        assert!(error.contains("1 mistake"), "{error}");
    }
    let inside = format!("{AXIS}\n[contacts.tool.surface]\n{ball}\n{}\n{still}\n", block(0.011))
        .replace("clamped", "unilateral");
    let error = Document::parse(&inside, "inside.toml").unwrap_err().to_string();
    assert!(error.contains("inside the workpiece") && error.contains("move the workpiece away"), "{error}");
    let rotary =
        format!("axis = \"rotational\"\n{AXIS}\n[contacts.tool.surface]\n{ball}\n{}\n{still}\n", block(0.1));
    let error = Document::parse(&rotary, "rotary.toml").unwrap_err().to_string();
    assert!(error.contains("this axis is rotational"), "{error}");
}

/// Linear interpolation between knots that are 0.6 mm apart on a ball of 53 mm: (0.6 / 53)^2 / 8 of the
/// normal.
const STRAIGHT: f64 = 2e-5;

#[test]
fn truth_gap_rate_point_and_normal_are_recorded() {
    let (r, radius, ahead, back, speed) = (3e-3, 50e-3, 60e-3, -20e-3, 40e-3);
    let signals = [
        "gap",
        "gap_rate",
        "compression",
        "point_x",
        "point_y",
        "point_z",
        "normal_x",
        "normal_y",
        "normal_z",
    ];
    let record: Vec<String> = signals.iter().map(|signal| format!("\"tool.{signal}\"")).collect();
    let text = |surface: &str, record: &str| {
        format!(
            "[bodies.tip]\nmass = 1.0\n[springs.guide]\nbetween = [\"ground\", \"tip\"]\nstiffness = \
             1.0\n[contacts.tool]\nbetween = [\"tip\", \"ground\"]\n\
             stiffness = 1e4\n{surface}\n[run]\nduration = 1.0\nrecord = [{record}]\nrecord_rate = 1000.0\n"
        )
    };
    let surface = format!(
        "[contacts.tool.surface]\ntip = {{ shape = \"ball\", radius = {r} }}\nworkpiece = {{ shape \
         = \"ball\", radius = {radius}, x = {ahead} }}\n\
         feed = {{ y = {back}, velocity_y = {speed}, duration = 1.0 }}"
    );
    let document = Document::parse(&text(&surface, &record.join(", ")), "axis.toml")
        .unwrap_or_else(|error| panic!("{error}"));
    let found = run(&document.scenario, &mut |_| {}).unwrap().record;
    let column = |signal: &str| found.column(&format!("tool.{signal}")).unwrap().to_vec();
    let columns = signals.map(column);
    for (i, t) in found.t_s.iter().enumerate() {
        let y = back + speed * t;
        let (sine, cosine) = (y / (r + radius), f64::sqrt(1.0 - (y / (r + radius)).powi(2)));
        let gap = ahead - (r + radius) * cosine;
        let expected = [
            gap,
            speed * sine / cosine,
            -gap,
            ahead - radius * cosine,
            radius * sine,
            0.0,
            cosine,
            -sine,
            0.0,
        ];
        for ((signal, column), expected) in signals.iter().zip(&columns).zip(expected) {
            // After the last knot the gap holds still.
            let ends = *signal == "gap_rate" && *t >= 1.0;
            assert!(
                ends || (column[i] - expected).abs() < STRAIGHT,
                "{t} {signal}: {} {expected}",
                column[i]
            );
        }
    }
    // A contact with a wall has a gap, and no point.
    let plain = Document::parse(&text("gap = 1e-3", "\"tool.gap\", \"tool.gap_rate\""), "axis.toml").unwrap();
    let found = run(&plain.scenario, &mut |_| {}).unwrap().record;
    assert!(found.column("tool.gap").unwrap().iter().all(|gap| (gap - 1e-3).abs() < 1e-12));
    let error = Document::parse(&text("gap = 1e-3", "\"tool.point_y\""), "axis.toml")
        .map_err(|error| error.to_string())
        .unwrap_err();
    assert!(error.contains("no shapes") && error.contains("run.record"), "{error}");
}
