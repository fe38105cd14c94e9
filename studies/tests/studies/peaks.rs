//! Peak forces between the record's rows: against closed forms, against very fine records, and in groups
//! against single runs.

use feeler_files::{Document, Setting};
use feeler_studies::run::{LANES, PreparedRun, measure, run};

use crate::common::{file, result_of};

const MASS_KG: f64 = 2.0;
const SPEED_M_PER_S: f64 = 0.3;
/// The engine finds a maximum where the slope is zero to machine precision. The rest is the rounding of
/// speed, stiffness and the instant of the touch.
const LOCATED: f64 = 1e-11;
/// A parabola finds the peak of a half sine with a thousand rows within `(pi / 1000)^4 / 128 = 1e-12`. Laws
/// with a steeper start leave a larger error.
const FINE_ROWS: f64 = 1e-7;

fn impact(law: &str, gap_m: f64, run: &str) -> Document {
    let text = format!(
        "[bodies.tip]\nmass = {MASS_KG}\nvelocity = {SPEED_M_PER_S}\n[contacts.tool]\nbetween = \
         [\"tip\", \"ground\"]\n{law}\n\
         gap = {gap_m}\n[run]\nrecord = [\"tool.force\"]\n{run}\n"
    );
    Document::parse(&text, "impact.toml").unwrap_or_else(|mistakes| panic!("{mistakes}"))
}

fn peak_of(document: &Document) -> f64 {
    result_of(document).summary.peak_force_n
}

fn peak_n(stiffness: f64, damping: f64, gap_m: f64) -> f64 {
    peak_of(&impact(&format!("stiffness = {stiffness}\ndamping = {damping}"), gap_m, "duration = 0.1"))
}

/// The largest of rows so fine that they represent the motion.
fn largest_row(document: &Document) -> f64 {
    result_of(document).record.column("tool.force").unwrap_or_default().iter().copied().fold(0.0, f64::max)
}

/// Contact lasts from 4.4 ms down to 44 us, less than half of the spacing of the record's first rows.
#[test]
fn truth_an_undamped_impact_peaks_at_speed_times_the_root_of_stiffness_and_mass() {
    for stiffness in [1e6, 1e8, 1e9, 1e10_f64] {
        let expected = SPEED_M_PER_S * (stiffness * MASS_KG).sqrt();
        for gap_m in [0.01, 0.010_011] {
            let found = peak_n(stiffness, 0.0, gap_m);
            assert!(
                (found / expected - 1.0).abs() < LOCATED,
                "{stiffness} N/m, gap {gap_m} m: {found} N, not {expected} N"
            );
        }
    }
}

/// Above half of critical damping the force only falls from `c v`, with which it begins.
#[test]
fn truth_a_heavily_damped_impact_is_hardest_as_it_begins() {
    let stiffness = 1e5_f64;
    for ratio in [0.6, 1.0, 2.0] {
        let damping = 2.0 * ratio * (stiffness * MASS_KG).sqrt();
        for gap_m in [0.0, 0.003, 0.01, 0.010_017] {
            let (found, expected) = (peak_n(stiffness, damping, gap_m), damping * SPEED_M_PER_S);
            assert!(
                (found / expected - 1.0).abs() < LOCATED,
                "{ratio}, gap {gap_m} m: {found} N, not {expected} N"
            );
        }
    }
}

/// Hertz and Hunt-Crossley contacts. Some are hardest just after they begin, where a usual record has no row.
#[test]
fn truth_impacts_of_nonlinear_laws_peak_where_fine_records_do() {
    for law in [
        "law = \"hertz\"\nstiffness = 1e9",
        "law = \"hunt-crossley\"\nstiffness = 1e6\nalpha = \"0.5 s/m\"",
        "law = \"hunt-crossley\"\nstiffness = 1e6\nalpha = \"10 s/m\"",
        "law = \"hunt-crossley\"\nstiffness = 1e6\nalpha = \"100 s/m\"",
        "law = \"hunt-crossley\"\nstiffness = 1e6\nalpha = \"1000 s/m\"",
    ] {
        let found = peak_of(&impact(law, 0.0, "duration = 0.02"));
        let expected = largest_row(&impact(law, 0.0, "duration = 0.004\nrecord_rate = 1e7"));
        assert!((found / expected - 1.0).abs() < FINE_ROWS, "{law}: {found} N, not {expected} N");
    }
}

/// The hardest of many contacts is a short one between long ones.
#[test]
fn regress_the_hardest_contact_is_found_however_short() {
    let settings =
        |rate: f64| [("run.duration", Setting::Number(0.2)), ("run.record_rate", Setting::Number(rate))];
    let found = peak_of(&file("why/loss-fast.toml", &settings(2e3)));
    let expected = largest_row(&file("why/loss-fast.toml", &settings(1e6)));
    // The force begins with its damper and falls within microseconds: rows of one microsecond miss part of
    // it.
    assert!(found >= expected && found < 1.001 * expected, "{found} N, not {expected} N");
}

/// Variants of a sweep have the same peaks as single runs, although they travel in groups between rows at a
/// fifth of the rate.
#[test]
fn prop_a_variant_of_a_sweep_has_the_peaks_of_a_run() {
    for (name, key, from, step) in [
        ("chatter/settles.toml", "controllers.force.kp", 0.2, 0.02),
        ("paper/flexible-contact.toml", "contacts.tool.stiffness", 2e5, 5e4),
        ("reference/m4.toml", "contacts.tool.stiffness", 4e5, 2e4),
        ("paper/rigid.toml", "bodies.motor.mass", 8.0, 1.0),
    ] {
        let documents: Vec<Document> = (0..LANES)
            .map(|i| {
                file(
                    name,
                    &[(key, Setting::Number(from + step * i as f64)), ("run.duration", Setting::Number(0.3))],
                )
            })
            .collect();
        let candidates: Vec<PreparedRun> =
            documents.iter().map(|document| PreparedRun::new(document.scenario.clone()).unwrap()).collect();
        for (document, measured) in documents.iter().zip(measure(&candidates, 0)) {
            let scenario = {
                let mut scenario = document.scenario.clone();
                scenario.run.duration_s = measured.as_ref().unwrap().summary.simulated_s;
                scenario
            };
            let (alone, abreast) = (run(&scenario, &mut |_| {}).unwrap().summary, measured.unwrap().summary);
            for (a, b) in alone.contacts.iter().zip(&abreast.contacts) {
                // Alone and in groups, times are summed in another order: a difference of rounding that
                // impacts may amplify.
                assert!(
                    (a.peak_force_n / b.peak_force_n - 1.0).abs() < 1e-6,
                    "{name} {}: {a:?} {b:?}",
                    abreast.simulated_s
                );
            }
        }
    }
}

/// A contact of 44 us lies between two rows of the record, and on 44 of the steps.
#[test]
fn regress_fixed_steps_between_rows_have_their_peaks() {
    let expected = SPEED_M_PER_S * (1e10 * MASS_KG).sqrt();
    let found = peak_of(&impact(
        "stiffness = 1e10",
        0.010_01,
        "duration = 0.05\nintegrator = \"rk4\"\nstep = 1e-6\nrecord_rate = 1e4",
    ));
    // The touch is detected up to a step late, against 14 us from touch to peak.
    assert!((found / expected - 1.0).abs() < 0.02, "{found} N, not {expected} N");
}
