//! Presliding of dry friction in fits: before a guide slides, it deflects like a spring by micrometres.
//!
//! A set-valued law holds a guide perfectly still, so that every small motion near a reversal or under a
//! preload would be an error. Any dry friction shows it in records, so it is not a cause.

use std::f64::consts::TAU;

use feeler_plant::assembly::{Assembly, Link};

/// Presliding of all guides that state none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Presliding {
    /// Natural frequency of the moving mass on the sticking guide, Hz.
    pub(crate) frequency_hz: f64,
    /// Damping ratio of that oscillation.
    pub(crate) damping_ratio: f64,
}

impl Default for Presliding {
    /// Presliding of some micrometres under some newtons of friction.
    fn default() -> Self {
        Self { frequency_hz: 60.0, damping_ratio: 0.5 }
    }
}

/// Guard evaluations in every period of a sticking guide, and their largest number in one row.
const CHECKS_PER_PERIOD: f64 = 4.0;
const MOST_CHECKS: usize = 16;

impl Presliding {
    /// States this presliding at every guide with dry friction that states none.
    pub(super) fn state(self, assembly: &mut Assembly) {
        let bare = assembly.dry_guides().filter(|(_, link)| link.presliding.is_none());
        let bare: Vec<_> = bare.map(|(i, link)| (i, assembly.sliding_mass_kg(link))).collect();
        for (i, mass_kg) in bare {
            assembly.links[i].presliding = Some(self.of_mass(mass_kg));
        }
    }

    /// The presliding of a guide on which this mass slides.
    pub(crate) fn of_mass(self, mass_kg: f64) -> feeler_plant::assembly::Presliding {
        let omega = TAU * self.frequency_hz;
        let (stiffness, damping_ratio) = (mass_kg * omega * omega, self.damping_ratio);
        feeler_plant::assembly::Presliding { stiffness, damping_ratio }
    }
}

/// Number of guard evaluations in a row. A row may be longer than the period of a sticking guide, which could
/// otherwise slide and stick again between two evaluations.
pub(super) fn checks(assembly: &Assembly, spacing_s: f64) -> usize {
    let of = |link: &Link| Some((link.presliding?.stiffness / assembly.sliding_mass_kg(link)).sqrt() / TAU);
    let fastest_hz = assembly.dry_guides().filter_map(|(_, link)| of(link)).fold(0.0, f64::max);
    let checks = (CHECKS_PER_PERIOD * fastest_hz * spacing_s).ceil() as usize;
    // Repeated halves of a row share their exponentials.
    checks.clamp(1, MOST_CHECKS).next_power_of_two()
}

#[cfg(test)]
mod tests {
    #![expect(clippy::expect_used, reason = "helpers of tests fail as tests do")]

    use feeler_files::Document;
    use feeler_plant::assembly::{Source, assemble};

    use super::*;
    use crate::dataset::{Channel, Dataset, Driven, Record};
    use crate::predict::{Anchoring, Leeway, Prediction, Predictor, Start};

    const MACHINE: &str = r#"
    name = "axis"
    [bodies.motor]
    mass = 32.0
    [springs.guide]
    between = ["ground", "motor"]
    damping = 8.0
    effects.coulomb-friction = { level = 0.58 }
    [actuators.drive]
    on = "motor"
    reacts_on = "ground"
    kind = "force"
    [sensors.encoder]
    reads = "motor.position"
    resolution = 2.7e-5
    "#;
    const ROWS: usize = 2000;
    const STEP_M: f64 = 2.7e-5;
    /// A third of the step, over the variation of the motion of about 20 mm.
    const MOST: f64 = 5e-4;

    fn dataset(spacing_s: f64, positions: Vec<f64>) -> Dataset {
        let command = |k: usize| {
            let t_s = k as f64 * spacing_s;
            // Noise of the command, which also moves the machine.
            let noise = ((k * 7919) % 1009) as f64 / 504.0 - 1.0;
            0.9 * (TAU * 0.11 * t_s).sin() + 0.35 * (TAU * 0.37 * t_s + 1.0).sin() + 0.05 * noise
        };
        let machine = Document::parse(MACHINE, "axis.toml").expect("it is a machine").scenario.machine;
        let drives =
            vec![Driven { drive: 0, column: "command".into(), hold_s: Some(spacing_s), noise: None }];
        let channel =
            Channel { column: "encoder".into(), source: Source::Sensor(0), noise: 1e-6, resolution: STEP_M };
        let commands = vec![(0..ROWS).map(command).collect()];
        let record = Record::even("axis.csv", spacing_s, commands, vec![positions]);
        Dataset::new("axis", machine, drives, vec![channel], vec![Record { is_check: true, ..record }])
    }

    fn predicted(
        dataset: &Dataset,
        with: impl Fn(feeler_plant::assembly::Assembly) -> Result<Prediction, crate::error::DiagnosisError>,
    ) -> Vec<f64> {
        let assembly = assemble(&dataset.machine).expect("it assembles");
        with(assembly).expect("it moves").series.swap_remove(0)
    }

    /// Friction takes half of the force, and the guide sticks at every reversal. Rows are longer than the
    /// period of the sticking guide. It deflects by a tenth of a micrometre.
    #[test]
    fn truth_friction_is_followed_through_rows_longer_than_the_swing_of_a_sticking_guide() {
        for spacing_s in [0.02, 0.005] {
            let blank = dataset(spacing_s, vec![0.0; ROWS]);
            let exact =
                predicted(&blank, |assembly| Predictor::new(assembly, &blank, &blank.records[0])?.free());
            let seen = dataset(spacing_s, exact.iter().map(|x| (x / STEP_M).round() * STEP_M).collect());
            let window = Start::Windows((0.25 / spacing_s) as usize);
            let quick = predicted(&seen, |assembly| {
                Predictor::with(assembly, Leeway::default(), &seen, &seen.records[0])?
                    .follow(Anchoring::Continuous, window)
            });
            let rms = |of: &dyn Fn(usize) -> f64| ((0..ROWS).map(|k| of(k).powi(2)).sum::<f64>()).sqrt();
            let mean = exact.iter().sum::<f64>() / ROWS as f64;
            let off = rms(&|k| quick[k] - exact[k]) / rms(&|k| exact[k] - mean);
            assert!(off < MOST, "rows of {spacing_s} s: off by {off} of the motion");
        }
    }

    /// A correction by one encoder step would stretch the bristles of a stiff guide by thousands of newtons.
    /// Its surfaces follow instead. Each window starts from a position that is rounded to a step.
    #[test]
    fn truth_a_guide_of_any_stiffness_follows_corrections_without_blows() {
        let blank = dataset(0.002, vec![0.0; ROWS]);
        let exact = predicted(&blank, |assembly| Predictor::new(assembly, &blank, &blank.records[0])?.free());
        let seen = dataset(0.002, exact.iter().map(|x| (x / STEP_M).round() * STEP_M).collect());
        let rms = |of: &dyn Fn(usize) -> f64| ((0..ROWS).map(|k| of(k).powi(2)).sum::<f64>()).sqrt();
        let mean = exact.iter().sum::<f64>() / ROWS as f64;
        for frequency_hz in [60.0, 600.0, 6000.0] {
            let leeway =
                Leeway { presliding: Presliding { frequency_hz, damping_ratio: 0.5 }, late_rows: 0.0 };
            let followed = predicted(&seen, |assembly| {
                Predictor::with(assembly, leeway, &seen, &seen.records[0])?
                    .follow(Anchoring::Continuous, Start::Windows(25))
            });
            let off = rms(&|k| followed[k] - exact[k]) / rms(&|k| exact[k] - mean);
            assert!(off < 2.0 * MOST, "{frequency_hz} Hz: off by {off} of the motion");
        }
    }

    /// A guide with too much friction sticks while corrections move its body. The prediction then stays
    /// near the measured motion: no bristle gains energy from a correction against its direction.
    #[test]
    fn truth_a_guide_with_too_much_friction_is_corrected_and_gains_no_energy() {
        let blank = dataset(0.002, vec![0.0; ROWS]);
        let exact = predicted(&blank, |assembly| Predictor::new(assembly, &blank, &blank.records[0])?.free());
        let mean = exact.iter().sum::<f64>() / ROWS as f64;
        let seen = dataset(0.002, exact.clone());
        for times in [1.4, 1.7, 2.2] {
            let followed = predicted(&seen, |mut assembly| {
                for link in assembly.links.iter_mut().filter(|link| link.friction.acts()) {
                    link.friction = link.friction.scaled(times);
                }
                Predictor::with(assembly, Leeway::default(), &seen, &seen.records[0])?
                    .follow(Anchoring::Continuous, Start::Windows(25))
            });
            let rms = |of: &dyn Fn(usize) -> f64| ((0..ROWS).map(|k| of(k).powi(2)).sum::<f64>()).sqrt();
            let off = rms(&|k| followed[k] - exact[k]) / rms(&|k| exact[k] - mean);
            // The observer holds the error at the surplus of friction over its stiffness, 3 to 5 % here. A
            // prediction that gains energy is off by more than the motion itself.
            assert!(off < 0.1, "{times} times the friction: off by {off} of the motion");
        }
    }
}
