//! Measured responses against the linear one.

use crate::common::machine;
use feeler_analysis::frf::{Excitation, FrfExperiment, MeasuredResponse, NoiseMethod};
use feeler_lti::C64;
use feeler_lti::spectral::{Estimator, LocalPolynomialSettings};
use feeler_plant::description::ActuatorKind;
use feeler_plant::effects::{EffectUse, find};

/// Periodic excitation of a linear machine at rest leaves no leakage. Only the transient remains, which
/// decays at 7/s over some seconds.
const PERIODIC: f64 = 1e-6;
/// Leakage left by local parabolas over 0.2 Hz of a resonance that is 2 Hz wide: the third power of that
/// ratio, with a margin for the sharpest lines.
const LOCAL: f64 = 3e-3;
/// Error of the mean of three neighbouring lines of a chirp: curvature of a resonance 2 Hz wide over 0.05 Hz.
const CHIRP: f64 = 1e-2;
/// Error of Welch's method with segments of 4 s: leakage, and scatter of some sixty averages.
const WELCH: f64 = 5e-2;

fn experiment() -> FrfExperiment {
    FrfExperiment {
        machine: machine(),
        actuator: "drive".into(),
        output: "tool.spring_force".parse().unwrap_or_else(|error| panic!("{error}")),
        hold_s: 1e-3,
        offset: 0.0,
        seed: 2,
    }
}

fn worst(measured: &MeasuredResponse) -> f64 {
    let pairs = measured.estimate.response.iter().zip(&measured.linear);
    pairs.map(|(g, linear)| (g - linear).norm() / linear.norm()).fold(0.0, f64::max)
}

#[test]
fn truth_every_excitation_finds_the_linear_response() {
    let noise = |method| Excitation::WhiteNoise { duration_s: 120.0, method };
    let cases = [
        (
            Excitation::Multisine { period_s: 1.0, periods: 2, transient_periods: 4, realisations: 1 },
            PERIODIC,
        ),
        (Excitation::SteppedSine { points: 12, settle_s: 4.0, measure_s: 1.0 }, PERIODIC),
        (noise(NoiseMethod::LocalPolynomial(LocalPolynomialSettings::default())), LOCAL),
        (Excitation::Chirp { sweep_s: 56.0, rest_s: 4.0, half_width: 1 }, CHIRP),
        (noise(NoiseMethod::Welch { segment_s: 4.0, estimator: Estimator::H1 }), WELCH),
        (noise(NoiseMethod::Welch { segment_s: 4.0, estimator: Estimator::Hv }), WELCH),
    ];
    for (excitation, tolerance) in cases {
        let measured = experiment().measure(&excitation, 1.0, (2.0, 300.0)).unwrap();
        assert!(measured.linear.len() >= 12);
        let found = worst(&measured);
        assert!(found < tolerance, "{excitation:?}: {found}");
    }
}

#[test]
fn truth_friction_shows_as_distortion_and_sensor_noise_does_not() {
    let excitation =
        Excitation::Multisine { period_s: 1.0, periods: 6, transient_periods: 4, realisations: 4 };
    let distortion_over_noise = |experiment: &FrfExperiment| {
        let measured = experiment.measure(&excitation, 20.0, (2.0, 100.0)).unwrap();
        let distortion: f64 = measured.distortion_variance.unwrap().iter().sum();
        distortion / measured.estimate.variance.iter().sum::<f64>()
    };
    let mut noisy = experiment();
    noisy.machine.sensors["force"].noise = 0.5;
    noisy.output = "force.reading".parse().unwrap();
    let mut rubbing = noisy.clone();
    let definition = find("coulomb-friction").unwrap();
    let values = vec![8.0; definition.parameters.len()];
    rubbing.machine.springs["guide"].effects.push(EffectUse { definition, values });
    let (noise, friction) = (distortion_over_noise(&noisy), distortion_over_noise(&rubbing));
    // With four realisations, distortion alone gives four times the variance of their mean. Noise alone
    // leaves the excess of its own spread.
    assert!(friction > 3.0 && noise < 0.5 * friction, "{friction} with friction, {noise} with noise alone");
}

#[test]
fn regress_far_below_a_resonance_a_linear_machine_has_no_distortion() {
    // A slow filter lowers the response by 120 dB from its resonance to the end of the band. Rounding of the
    // whole record exceeds the line there.
    let mut falling = experiment();
    falling.machine.actuators["drive"].kind = ActuatorKind::Force { bandwidth_hz: Some(2.0) };
    falling.output = "tip.position".parse().unwrap();
    let excitation =
        Excitation::Multisine { period_s: 1.0, periods: 4, transient_periods: 6, realisations: 4 };
    let measured = falling.measure(&excitation, 1.0, (1.0, 450.0)).unwrap();
    let size = |g: &C64| 20.0 * g.norm().log10();
    let (largest, smallest) =
        measured.linear.iter().map(size).fold((f64::MIN, f64::MAX), |(a, b), g| (a.max(g), b.min(g)));
    assert!(largest - smallest > 120.0, "{largest} {smallest}");
    assert!(!measured.evidence.unwrap().is_beyond_noise);
    // A band without noise still includes rounding.
    let bands = measured.estimate.confidence(0.95);
    let inside = (0..bands.len()).filter(|&i| {
        let radius = bands[i].magnitude_high - measured.estimate.response[i].norm();
        (measured.estimate.response[i] - measured.linear[i]).norm() <= radius
    });
    assert!(inside.count() * 10 >= 9 * bands.len());
}
