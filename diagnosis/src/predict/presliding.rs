//! Presliding of dry friction: before a guide slides, it deflects like a spring by micrometres.
//!
//! A set-valued law holds a guide perfectly still, so that every small motion near a reversal or under a
//! preload would be an error. Here stiff damped springs connect sliding surfaces to their body, each with a
//! share of the friction (Maxwell slip). While the guide sticks, the body oscillates on these springs; while
//! it slides, the friction level acts as before. The springs are not an effect: they are part of how any dry
//! friction appears in records.

use std::f64::consts::TAU;

use feeler_plant::assembly::{Assembly, Friction, Link, Node};

/// Parameters of presliding.
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

/// Parallel bristles (Maxwell slip): the share of the stiffness and of the level that each has. A single
/// bristle yields linearly up to the whole level. Real friction yields ever more easily: its force approaches
/// the level exponentially (Dahl 1968). Two bristles stay within 5 % of that curve.
const BRISTLES: [[f64; 2]; 2] = [[0.749, 0.472], [0.251, 0.528]];

/// Share of a body's mass that is assigned to its sliding surface: small against the body, but large enough
/// that the surface needs no finer steps.
const SURFACE_SHARE: f64 = 0.02;

/// Guard evaluations in every period of a sticking guide, and their largest number in one row.
const CHECKS_PER_PERIOD: f64 = 4.0;
const MOST_CHECKS: usize = 16;

impl Presliding {
    /// Number of guard evaluations in a row. A row may be longer than the period of a sticking guide, which
    /// could otherwise slide and stick again between two evaluations.
    pub(super) fn checks(self, spacing_s: f64) -> usize {
        let checks = (CHECKS_PER_PERIOD * self.frequency_hz * spacing_s).ceil() as usize;
        // Repeated halves of a row share their exponentials.
        checks.clamp(1, MOST_CHECKS).next_power_of_two()
    }

    /// Adds a sliding surface to every guide with dry friction, and returns the new nodes.
    pub(super) fn soften(self, assembly: &mut Assembly) -> Vec<usize> {
        let mut surfaces = Vec::new();
        for i in 0..assembly.links.len() {
            let link = &assembly.links[i];
            if link.rigid || !link.friction.acts() {
                continue;
            }
            let (a, b) = (link.a, link.b);
            let on_b = assembly.rigid_mass_kg(b) <= assembly.rigid_mass_kg(a);
            let (body, other) = if on_b { (b, a) } else { (a, b) };
            let (mass, all) = (SURFACE_SHARE * assembly.nodes[body].mass_kg, assembly.rigid_mass_kg(body));
            if !(mass.is_finite() && mass > 0.0) {
                continue;
            }
            let omega = TAU * self.frequency_hz;
            let under = assembly.nodes[body].clone();
            assembly.nodes[body].mass_kg -= mass;
            let friction = std::mem::replace(&mut assembly.links[i].friction, Friction::NONE);
            for [stiff, level] in BRISTLES {
                let surface = assembly.nodes.len();
                let name = format!("{} surface", under.name);
                assembly.nodes.push(Node { name, mass_kg: stiff * mass, ..under.clone() });
                let (from, to) = if on_b { (other, surface) } else { (surface, other) };
                let bare = |a, b, stiffness, damping, friction: Friction| Link {
                    stiffness,
                    damping,
                    friction,
                    ..Link::between(assembly.links[i].name.clone(), a, b)
                };
                let damping = 2.0 * self.damping_ratio * all * omega;
                let added = [
                    bare(from, to, 0.0, 0.0, friction.scaled(level)),
                    bare(body, surface, stiff * all * omega * omega, stiff * damping, Friction::NONE),
                ];
                assembly.links.extend(added);
                surfaces.push(surface);
            }
        }
        surfaces
    }
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
        let drives = vec![Driven { drive: 0, column: "command".into(), hold_s: Some(spacing_s) }];
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

    /// While it yields, a guide follows Dahl's curve: the force is `1 - exp(-x)` of the level. Here `x` is
    /// the deflection over the length at which the initial stiffness alone would reach the level.
    #[test]
    fn truth_a_softened_guide_yields_as_dahls_law_does() {
        let mut assembly = assemble(&dataset(0.002, vec![0.0; ROWS]).machine).expect("it assembles");
        let surfaces = Presliding::default().soften(&mut assembly);
        let of = |surface: usize, what: fn(&Link) -> f64| {
            let own = assembly.links.iter().filter(|link| [link.a, link.b].contains(&surface));
            own.map(what).sum::<f64>()
        };
        let bristles: Vec<[f64; 2]> = (surfaces.iter())
            .map(|&surface| [of(surface, |link| link.stiffness), of(surface, |link| link.friction.forward)])
            .collect();
        let [stiffness, level] = [0, 1].map(|i| bristles.iter().map(|bristle| bristle[i]).sum::<f64>());
        assert!((stiffness / (32.0 * (TAU * 60.0).powi(2)) - 1.0).abs() < 1e-12);
        assert!((level / 0.58 - 1.0).abs() < 1e-12);
        // Both bristles together begin with 0.7 of the stiffness that the law has at first.
        let length = 0.7 * level / stiffness;
        for i in 0..100 {
            let x = 0.05 * f64::from(i);
            let force: f64 = bristles.iter().map(|[k, most]| (k * length * x).min(*most)).sum();
            assert!((force / level - (1.0 - (-x).exp())).abs() < 0.051, "{x}: {force}");
        }
    }
}
