//! Describing functions against the simulation, where their assumption holds: nearly harmonic motion.

#![expect(
    clippy::unwrap_used,
    reason = "a scenario of this repository that cannot be read or run fails the test that asks for it"
)]

use std::path::Path;

use feeler_analysis::{LimitCycle, limit_cycles};
use feeler_files::{Document, Setting};
use feeler_studies::run::{Summary, run};

/// Error from the neglected higher harmonics. The spring is one-sided and left for less than half of the
/// time. Then the second harmonic of the force is about a third of the first. The machine passes about a
/// third of that.
const FIRST_HARMONIC: f64 = 0.1;
/// Saturation is odd, so its first neglected harmonic is the third: at most a ninth, of which the machine
/// passes less than a tenth.
const ODD: f64 = 0.04;

fn scenario(name: &str, settings: &[(&str, f64)]) -> Document {
    let document =
        Document::load(&Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")).join(name)).unwrap();
    document.with(settings.iter().map(|(key, value)| (*key, Setting::Number(*value)))).unwrap()
}

fn both(document: &Document) -> (LimitCycle, Summary) {
    let cycles = limit_cycles(&document.scenario).unwrap();
    let cycle = *cycles.iter().find(|cycle| cycle.stable).unwrap();
    (cycle, run(&document.scenario, &mut |_| {}).unwrap().summary)
}

fn assert_near(what: &str, predicted: f64, simulated: f64, tolerance: f64) {
    assert!(
        (predicted / simulated - 1.0).abs() <= tolerance,
        "{what}: predicted {predicted}, simulated {simulated}"
    );
}

/// The linear limit is kp = 0.9027.
#[test]
fn truth_chatter_just_beyond_the_limit_is_predicted() {
    let document = scenario("chatter/sustained.toml", &[("controllers.force.kp", 0.92)]);
    let (cycle, simulated) = both(&document);
    let chatter = simulated.oscillation.unwrap();
    assert_near("frequency", cycle.frequency_hz, chatter.frequency_hz, FIRST_HARMONIC);
    assert_near("peak", cycle.peak_force_n, 2.0 * chatter.amplitude_n, FIRST_HARMONIC);
    assert_near("time in contact", cycle.contact_share, chatter.contact_share, FIRST_HARMONIC);
}

#[test]
fn truth_a_cycle_through_saturation_is_predicted() {
    let (cycle, simulated) = both(&scenario("chatter/saturation.toml", &[]));
    let chatter = simulated.oscillation.unwrap();
    assert!(cycle.drive_share < 1.0 && cycle.contact_share >= 1.0, "{cycle:?}");
    assert_near("frequency", cycle.frequency_hz, chatter.frequency_hz, ODD);
    assert_near("peak", cycle.peak_force_n, simulated.peak_force_n, ODD);
}

#[test]
fn truth_a_loop_stable_at_every_amplitude_has_no_cycle() {
    let document = scenario("chatter/sustained.toml", &[("controllers.force.kp", 0.3)]);
    assert_eq!(limit_cycles(&document.scenario).unwrap(), []);
}
