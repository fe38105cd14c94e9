//! The machine with the paper's measured landmarks.

use feeler_plant::description::Engagement;
use feeler_validation::ValidationError;
use feeler_validation::landmarks::{
    LandmarkChain, StartSearch, fit, fitted, landmarks, rows, simulated_landmarks,
};

/// Crossings of a measured phase and of the computed one, Hz. A hold of 0.1 ms gives 0.9 degrees at 50 Hz,
/// and the estimate is accurate to some tenths of one. The flattest of these phases falls by 1.8 degrees per
/// hertz. It is also the tolerance of a landmark.
const MEASURED_HZ: f64 = 0.8;
/// The file has six digits; a fit stops when a step improves by 1e-7.
const SIX_DIGITS: f64 = 1e-3;
/// Smallest distance (Hz) from some landmark at which a start is not a solution itself.
const FAR_HZ: f64 = 3.0;

#[test]
fn reference_the_fit_finds_every_landmark_from_the_neutral_start() {
    let found = fit(&LandmarkChain::start(0), 2000).unwrap();
    assert!(found.reached);
    let rows = rows(&found.chain.machine(Engagement::Free)).unwrap();
    assert!(rows.iter().all(|row| row.pass), "{rows:#?}");
    let file = fitted(Engagement::Free).unwrap();
    for (name, body) in found.chain.machine(Engagement::Free).bodies {
        assert!((file.bodies[&name].mass_kg / body.mass_kg - 1.0).abs() < SIX_DIGITS, "{name}");
    }
    // Peaks belong to poles, so that there are ten landmarks for twenty-one parameters.
    assert!(
        found.undetermined.iter().filter(|(_, share)| *share > 0.9).count() >= 3,
        "{:?}",
        found.undetermined
    );
}

#[test]
fn regress_no_start_is_an_answer_already_and_most_find_one() {
    let starts: Vec<LandmarkChain> = (0..6).map(LandmarkChain::start).collect();
    for start in &starts {
        let off = landmarks(&start.machine(Engagement::Free)).unwrap().against_paper();
        assert!(off.iter().any(|(_, got, paper)| got.is_nan() || (got - paper).abs() > FAR_HZ), "{off:?}");
    }
    let search = StartSearch::from_starts(&starts, 2000).unwrap();
    assert!(search.reached() >= 4, "{} of 6", search.reached());
    // A start without permitted steps stays unchanged, and reports that.
    let stuck = StartSearch::from_starts(&starts[..1], 0).unwrap();
    assert!(!stuck.fit().reached && stuck.fit().iterations == 0 && stuck.ranges[0].is_none());
}

#[test]
fn truth_a_chain_is_read_back_from_its_machine() {
    let chain = LandmarkChain::start(3);
    let back = LandmarkChain::of_machine(&chain.machine(Engagement::Clamped)).unwrap();
    for ((value, _), (read, _)) in chain.parameters().into_iter().zip(back.parameters()) {
        assert!((value / read - 1.0).abs() < 1e-14, "{value} {read}");
    }
    let mut other = chain.machine(Engagement::Free);
    other.springs["guide"].damping_n_s_per_m = 0.0;
    let refused = LandmarkChain::of_machine(&other);
    assert!(
        matches!(&refused, Err(ValidationError::Chain { what }) if what.contains("guide damping is 0")),
        "{refused:?}"
    );
}

#[test]
fn truth_a_white_noise_experiment_shows_the_landmarks() {
    let machine = fitted(Engagement::Free).unwrap();
    let (computed, measured) = (landmarks(&machine).unwrap(), simulated_landmarks(&machine, 40.0).unwrap());
    let both = computed.against_paper().into_iter().zip(measured.against_paper());
    for ((name, computed, _), (_, measured, _)) in both {
        assert!(
            (computed - measured).abs() < MEASURED_HZ,
            "{name}: {measured} Hz measured, {computed} Hz computed"
        );
    }
}
