//! The machine with the paper's measured landmarks.

use feeler_validation::landmarks::{Chain, fit, landmarks, rows, simulated_landmarks};

/// Crossings of a measured phase and of the computed one, Hz: a hold of 0.1 ms turns 50 Hz by 0.9 degrees, and phases fall by some degrees per hertz.
const MEASURED_HZ: f64 = 0.5;
/// The fitted chain is written down to six digits.
const SIX_DIGITS: f64 = 1e-3;

#[test]
fn reference_the_fit_finds_every_landmark_again() {
    let found = fit(&Chain::START, 250).unwrap();
    let rows = rows(&found.chain).unwrap();
    assert!(rows.iter().all(|row| row.pass), "{rows:#?}");
    assert!((found.chain.motor_kg / Chain::FITTED.motor_kg - 1.0).abs() < SIX_DIGITS);
    // Ten landmarks cannot tell twenty-one parameters.
    assert!(found.undetermined.iter().filter(|(_, share)| *share > 0.9).count() >= 3, "{:?}", found.undetermined);
}

#[test]
fn truth_a_white_noise_experiment_shows_the_landmarks() {
    let (computed, measured) = (landmarks(&Chain::FITTED).unwrap(), simulated_landmarks(&Chain::FITTED, 40.0).unwrap());
    let both = computed.against_paper().into_iter().zip(measured.against_paper());
    for ((name, computed, _), (_, measured, _)) in both {
        assert!((computed - measured).abs() < MEASURED_HZ, "{name}: {measured} Hz measured, {computed} Hz computed");
    }
}
