//! The machine with the paper's measured landmarks.

use feeler_plant::description::Engagement;
use feeler_validation::landmarks::{Chain, fit, fitted, landmarks, rows, simulated_landmarks};

/// Crossings of a measured phase and of the computed one, Hz: a hold of 0.1 ms turns 50 Hz by 0.9 degrees, the estimate is good to some tenths of one,
/// and the flattest of these phases falls by 1.8 degrees per hertz. It is also what a landmark may be off.
const MEASURED_HZ: f64 = 0.8;
/// The file has six digits; a fit stops when a step improves by 1e-7.
const SIX_DIGITS: f64 = 1e-3;

#[test]
fn reference_the_fit_finds_every_landmark_again() {
    let found = fit(&Chain::START, 2000).unwrap();
    let rows = rows(&found.chain.machine(Engagement::Free)).unwrap();
    assert!(rows.iter().all(|row| row.pass), "{rows:#?}");
    let file = fitted(Engagement::Free).unwrap();
    for (name, body) in found.chain.machine(Engagement::Free).bodies {
        assert!((file.bodies[&name].mass_kg / body.mass_kg - 1.0).abs() < SIX_DIGITS, "{name}");
    }
    // Peaks belong to poles, so that there are ten landmarks for twenty-one parameters.
    assert!(found.undetermined.iter().filter(|(_, share)| *share > 0.9).count() >= 3, "{:?}", found.undetermined);
}

#[test]
fn truth_a_white_noise_experiment_shows_the_landmarks() {
    let machine = fitted(Engagement::Free).unwrap();
    let (computed, measured) = (landmarks(&machine).unwrap(), simulated_landmarks(&machine, 40.0).unwrap());
    let both = computed.against_paper().into_iter().zip(measured.against_paper());
    for ((name, computed, _), (_, measured, _)) in both {
        assert!((computed - measured).abs() < MEASURED_HZ, "{name}: {measured} Hz measured, {computed} Hz computed");
    }
}
