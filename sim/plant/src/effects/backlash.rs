//! `backlash`: free play in a spring; a rigid joint becomes a stiff spring.

use std::f64::consts::TAU;

use super::prelude::*;

/// Selects a derived stiffness or damping.
const DERIVED: f64 = 0.0;
/// Frequency of the two bodies on derived flanks: well above the excitation of a force loop, low enough for
/// steps of 0.1 ms.
const FLANK_FREQUENCY_HZ: f64 = 1000.0;
const FLANK_DAMPING_RATIO: f64 = 0.1;

parameters! { Backlash
    width: log(Dimension::LENGTH, Some(0.0), 2e-5, (0.0, 1.0), "free play from one flank to the other"),
    stiffness: log(
        Dimension::STIFFNESS, None, DERIVED, (0.0, 1e12), "of the flanks of a rigid spring; 0: derived"
    ) or DERIVED,
    damping: log(
        Dimension::DAMPING, None, DERIVED, (0.0, 1e9), "of the flanks of a rigid spring; 0: derived"
    ) or DERIVED,
}

pub(super) static DEFINITION: Definition = Definition {
    kind: Backlash::KIND,
    name: "backlash",
    place: Place::Transmission,
    order: 250,
    hosts: &[HostKind::Spring, HostKind::RigidSpring],
    site: "the spring must have stiffness or be rigid, and a free body at one end at least",
    parameters: Backlash::PARAMETERS,
    summary: "free play in a spring, with a stiff transmission where there was none",
    example: "\
[springs.transmission.effects.backlash]
width = \"50 um\"
",
    sections: "\
## Model
Within `|e| < width / 2` neither stiffness nor damping acts; beyond it the force is
`k (e - sign(e) width / 2) + c de/dt`, and the flanks only push. A rigid spring must first yield: `stiffness`
and `damping` are those of its flanks. By default (or if zero), the two bodies, free otherwise, would ring at
1000 Hz with a damping ratio of 0.1. That is `k = mu (2 pi 1000)^2`, `c = 0.2 sqrt(k mu)`, `mu` their reduced
mass, or the mass of the free one if the other is fixed. So with a width of zero a very stiff spring replaces
the rigid one. Weight hangs on the load's side: the `gravity` of a guide of the first body then moves to the
second. A `constant-load` stays at the guide, on the first body. A spring that has its own stiffness keeps it
and takes neither.

## Where it comes from
Gears, splines, nuts, keys, worn couplings.

## How it shows
At every reversal of the force in the transmission the tip waits and then is hit. Small oscillations see a
softer transmission: the smaller the amplitude, the lower the resonance frequency. With an integrator or a
high gain a limit cycle of the size of the gap remains. While contact preloads the gap it is invisible.
`coulomb-friction` also loses motion at reversals, but of the velocity, and it damps; `hardening-stiffness`
also stiffens with amplitude, but smoothly.

## How it is recognised
Reverse the force in free motion, or with the tool clamped: the tip waits, then is hit. With encoders on motor
and tip, their difference jumps by `width` at each reversal. Two accelerometers, on motor and tip, show the
impacts of the flanks.

## Numerical treatment
Free, left flank and right flank are modes; meeting and parting of flanks are events. Each mode is linear
and exact. Linear theory takes the play as closed.

## Source
M. Nordin and P.-O. Gutman, Controlling mechanical systems with backlash: a survey, Automatica 38 (2002):
the dead-zone model with damping.
",
    law: LawDrawing {
        axes: ["elongation", "force in the transmission"],
        start: -1.0,
        with: &[
            Curve::Points(&[(-0.9, -0.6), (-0.3, 0.0), (0.3, 0.0), (0.9, 0.6)]),
            Curve::Dimension([-0.3, 0.3], -0.2),
        ],
        without: &[Curve::UNCHANGED],
        labels: &[(0.05, -0.45, "width")],
    },
    traits: &[Trait::Compliance, Trait::FreePlay],
    change: Change::plant::<Backlash>(),
};

impl ChangesPlant for Backlash {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { width, stiffness, damping } = self;
        let Host::Spring(spring) = host else { return Err(machine.wrong_host(host, &DEFINITION)) };
        if machine.links[spring].rigid {
            set_flanks(machine, spring, stiffness, damping)?;
        } else {
            for (parameter, value) in [("stiffness", stiffness), ("damping", damping)] {
                if value > 0.0 {
                    return Err(EffectError::Value {
                        parameter,
                        value,
                        reason: "this spring has its own",
                        remedy: "leave it out",
                    });
                }
            }
            if machine.links[spring].stiffness <= 0.0 {
                return Err(EffectError::WrongSite {
                    kind: DEFINITION.kind,
                    needs: "a spring with stiffness, or a rigid one",
                });
            }
        }
        machine.links[spring].play += width;
        Ok(())
    }
}

/// Makes a rigid spring stiff.
fn set_flanks(
    machine: &mut Assembly,
    spring: usize,
    stiffness: f64,
    damping: f64,
) -> Result<(), EffectError> {
    let (a, b) = (machine.links[spring].a, machine.links[spring].b);
    // Each side moves with everything rigidly joined to it, but no longer with the other side.
    machine.links[spring].rigid = false;
    let mu = 1.0 / (1.0 / machine.rigid_mass_kg(a) + 1.0 / machine.rigid_mass_kg(b));
    if !mu.is_finite() {
        machine.links[spring].rigid = true;
        return Err(EffectError::WrongSite {
            kind: DEFINITION.kind,
            needs: "a spring with a free body at one end at least",
        });
    }
    let k = if stiffness > 0.0 { stiffness } else { mu * (TAU * FLANK_FREQUENCY_HZ).powi(2) };
    let c = if damping > 0.0 { damping } else { 2.0 * FLANK_DAMPING_RATIO * (k * mu).sqrt() };
    machine.links[spring].set_flexible(k, c);
    machine.hang_behind(spring);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::fixture::{self, GUIDE, TRANSMISSION};

    /// A product, a quotient and a root, each rounded once.
    const ROUNDING: f64 = 1e-14;

    #[test]
    fn truth_a_rigid_spring_rings_at_1000_hz() {
        let mut machine = fixture::rigid();
        DEFINITION.apply(&mut machine, TRANSMISSION, &[3e-5, DERIVED, DERIVED]).unwrap();
        let link = &machine.links[1];
        let mu = 7.0 * 5.0 / 12.0;
        let frequency_hz = (link.stiffness / mu).sqrt() / TAU;
        let damping_ratio = link.damping / (2.0 * (link.stiffness * mu).sqrt());
        assert!((frequency_hz / 1000.0 - 1.0).abs() < ROUNDING, "{frequency_hz}");
        assert!((damping_ratio / 0.1 - 1.0).abs() < ROUNDING, "{damping_ratio}");
        assert!(!link.rigid && link.play > 0.0);
    }

    #[test]
    fn truth_against_ground_the_reduced_mass_is_that_of_the_body() {
        let mut machine = fixture::rigid();
        machine.links[0].rigid = true;
        DEFINITION.apply(&mut machine, GUIDE, &[3e-5, DERIVED, DERIVED]).unwrap();
        // The motor moves as one with the tip: 12 kg.
        let frequency_hz = (machine.links[0].stiffness / 12.0).sqrt() / TAU;
        assert!((frequency_hz / 1000.0 - 1.0).abs() < ROUNDING, "{frequency_hz}");
    }

    #[test]
    fn truth_given_flanks_are_kept() {
        let mut machine = fixture::rigid();
        DEFINITION.apply(&mut machine, TRANSMISSION, &[3e-5, 1e6, 50.0]).unwrap();
        let mut expected = fixture::rigid();
        expected.links[1].set_flexible(1e6, 50.0);
        expected.links[1].play = 3e-5;
        assert_eq!(machine, expected);
    }

    #[test]
    fn prop_a_flexible_spring_keeps_its_stiffness() {
        let mut machine = fixture::flexible();
        assert!(matches!(
            DEFINITION.apply(&mut machine, TRANSMISSION, &[3e-5, 1e6, DERIVED]),
            Err(EffectError::Value { parameter: "stiffness", .. })
        ));
        DEFINITION.apply(&mut machine, TRANSMISSION, &[3e-5, DERIVED, DERIVED]).unwrap();
        let mut expected = fixture::flexible();
        expected.links[1].play = 3e-5;
        assert_eq!(machine, expected);
    }

    #[test]
    fn prop_a_viscous_guide_has_no_flanks() {
        let mut machine = fixture::flexible();
        assert!(matches!(
            DEFINITION.apply(&mut machine, GUIDE, &[3e-5, DERIVED, DERIVED]),
            Err(EffectError::WrongSite { .. })
        ));
    }
}
