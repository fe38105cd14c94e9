//! Peak forces of contacts shorter than the spacing of the record's rows, against closed forms.

use feeler_scenarios::format::Document;
use feeler_scenarios::run::run;

const MASS_KG: f64 = 2.0;
const SPEED_M_PER_S: f64 = 0.3;
/// Of a half sine met by twenty rows or more, a parabola finds the peak within `(pi / 20)^4 / 128 = 5e-6`.
const BETWEEN_ROWS: f64 = 5e-6;

fn peak_n(stiffness: f64, damping: f64, gap_m: f64) -> f64 {
    let text = format!(
        "[bodies.tip]\nmass = {MASS_KG}\nvelocity = {SPEED_M_PER_S}\n[contacts.tool]\nbetween = [\"tip\", \"ground\"]\nstiffness = {stiffness}\n\
         damping = {damping}\ngap = {gap_m}\n[run]\nduration = 0.1\nrecord = [\"tool.force\"]\n"
    );
    let document = Document::parse(&text, "impact.toml").unwrap_or_else(|mistakes| panic!("{mistakes}"));
    run(&document.scenario, &mut |_| {}).unwrap_or_else(|error| panic!("{error}")).summary.peak_force_n
}

/// Contact lasts from 4.4 ms down to 44 us, less than half of the spacing of the record's first rows.
#[test]
fn truth_an_undamped_impact_peaks_at_speed_times_the_root_of_stiffness_and_mass() {
    for stiffness in [1e6, 1e8, 1e9, 1e10_f64] {
        let expected = SPEED_M_PER_S * (stiffness * MASS_KG).sqrt();
        for gap_m in [0.01, 0.010_011] {
            let found = peak_n(stiffness, 0.0, gap_m);
            assert!((found / expected - 1.0).abs() < BETWEEN_ROWS, "{stiffness} N/m, gap {gap_m} m: {found} N, not {expected} N");
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
            assert!((found / expected - 1.0).abs() < BETWEEN_ROWS, "{ratio}, gap {gap_m} m: {found} N, not {expected} N");
        }
    }
}
