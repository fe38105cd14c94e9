//! Quick views of a scenario.

use std::cell::Cell;

use feeler_control::ReferenceSpec;
use feeler_engine::Scenario;
use feeler_files::Setting;
use feeler_studies::glimpse::{beginning, outcomes};
use feeler_studies::run::Outcome;

use crate::common::file;

fn sustained(kp: f64) -> Scenario {
    file("chatter/sustained.toml", &[("controllers.force.kp", Setting::Number(kp))]).scenario
}

/// A beginning includes a quarter of the time after the last change.
#[test]
fn truth_a_beginning_has_every_change_of_a_reference() {
    let of = |reference| {
        let mut scenario = sustained(0.3);
        scenario.run.duration_s = 2.0;
        scenario.controllers[0].spec.reference = reference;
        beginning(&scenario).run.duration_s
    };
    assert_eq!(of(ReferenceSpec::Constant(20.0)).to_bits(), 0.5_f64.to_bits());
    assert_eq!(of(ReferenceSpec::Steps(vec![(0.0, 20.0), (1.0, 25.0)])).to_bits(), 1.25_f64.to_bits());
    assert_eq!(of(ReferenceSpec::Steps(vec![(0.0, 20.0), (3.0, 25.0)])).to_bits(), 2.0_f64.to_bits());
    let noise = ReferenceSpec::WhiteNoise { low_hz: 1.0, high_hz: 40.0, rms: 1.0, offset: 20.0 };
    assert_eq!(of(noise).to_bits(), 2.0_f64.to_bits());
}

/// The limit of the gain is 0.903. At two thirds of it a beginning still rings, and its guess may be wrong.
#[test]
fn truth_beginnings_suggest_what_whole_runs_tell() {
    let gains = [0.2, 0.4, 1.1, 1.4, 1.8];
    let whole = outcomes(gains.map(sustained).to_vec(), &|| {});
    assert_eq!(outcomes(gains.map(|kp| beginning(&sustained(kp))).to_vec(), &|| {}), whole);
    assert!(whole.contains(&Some(Outcome::Chatter)) && whole[0].is_some_and(Outcome::is_stable));
}

/// A run of 1 s under a controller of 1 kHz can rest at each of its thousand samples at least, alone and
/// beside others.
#[test]
fn truth_runs_in_the_background_may_rest_at_each_row() {
    for count in [1, 8] {
        let rests = Cell::new(0);
        let mut scenarios = vec![sustained(0.2); count];
        for scenario in &mut scenarios {
            scenario.run.duration_s = 1.0;
        }
        let found = outcomes(scenarios, &|| rests.set(rests.get() + 1));
        assert!(found.iter().all(Option::is_some));
        assert!(rests.get() >= 1000, "{count}: {}", rests.get());
    }
}
