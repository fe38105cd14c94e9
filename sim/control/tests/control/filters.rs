//! Discrete filters against their continuous originals.

use std::f64::consts::TAU;

use feeler_control::filter::{Section, SectionState};

const PERIOD_S: f64 = 1e-3;
const NYQUIST_HZ: f64 = 500.0;
const ROUNDING: f64 = 1e-12;

fn magnitude(section: &Section<f64>, frequency_hz: f64) -> f64 {
    let [re, im] = section.response(frequency_hz, PERIOD_S);
    re.hypot(im)
}

#[test]
fn truth_gain_at_zero_frequency_is_one() {
    for section in [
        Section::IDENTITY,
        Section::low_pass_first(40.0, PERIOD_S),
        Section::low_pass_second(40.0, 0.3, PERIOD_S),
        Section::lead(15.0, 90.0, PERIOD_S),
    ] {
        assert!((magnitude(&section, 0.0) - 1.0).abs() < ROUNDING);
        let mut state = section.settled(3.0);
        for _ in 0..10 {
            assert!(
                (section.update(&mut state, 3.0) - 3.0).abs() < ROUNDING,
                "a settled filter stays settled"
            );
        }
    }
}

#[test]
fn truth_lead_ends_at_the_ratio_of_its_frequencies() {
    let lead = Section::lead(15.0, 90.0, PERIOD_S);
    assert!((magnitude(&lead, NYQUIST_HZ) - 6.0).abs() < 6.0 * ROUNDING);
    // Well below the Nyquist frequency the filter matches the continuous lead: the bilinear transform moves
    // 30 Hz by (pi f T)^2 / 3 = 0.3 %.
    let [re, im] = lead.response(30.0, PERIOD_S);
    let (over_zero, over_pole): (f64, f64) = (30.0 / 15.0, 30.0 / 90.0);
    assert!((im.atan2(re) - (over_zero.atan() - over_pole.atan())).abs() < 3e-3);
}

#[test]
fn truth_low_passes_at_their_own_frequency() {
    let first = Section::low_pass_first(120.0, PERIOD_S);
    assert!((magnitude(&first, 120.0) - 0.5_f64.sqrt()).abs() < ROUNDING);
    let second = Section::low_pass_second(120.0, 0.4, PERIOD_S);
    let [re, im] = second.response(120.0, PERIOD_S);
    assert!(re.abs() < ROUNDING && (im + 1.0 / 0.8).abs() < ROUNDING);
    for section in [first, second] {
        assert!(magnitude(&section, NYQUIST_HZ) < ROUNDING);
    }
}

/// A sine of long duration leaves the filter as the frequency response predicts.
#[test]
fn truth_running_the_filter_gives_its_response() {
    let section = Section::low_pass_second(60.0, 0.5, PERIOD_S);
    let frequency_hz = 50.0;
    let [re, im] = section.response(frequency_hz, PERIOD_S);
    let mut state = SectionState::default();
    for k in 0..1000 {
        let phase = TAU * frequency_hz * f64::from(k) * PERIOD_S;
        let y = section.update(&mut state, phase.cos());
        // The transient falls by exp(-0.5 * 2 pi 60) per second: e^-113 over 0.6 s, far below the tolerance.
        if k > 600 {
            assert!((y - (re * phase.cos() - im * phase.sin())).abs() < 1e-11);
        }
    }
}
