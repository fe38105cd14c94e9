//! `transmission-flexibility`: splits one body into two with a spring in between.

use super::prelude::*;
use crate::assembly::NodeId;

parameters! { TransmissionFlexibility
    stiffness: log(Dimension::STIFFNESS, None, 1.2e6, (ABOVE_ZERO, 1e12), "stiffness between motor and tip"),
    damping: log(Dimension::DAMPING, None, 120.0, (0.0, 1e9), "damping between motor and tip"),
    tip_mass: log(
        Dimension::MASS, None, 5.0, (ABOVE_ZERO, 1e5), "mass on the tip's side, taken from the total"
    ),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: TransmissionFlexibility::KIND,
    name: "transmission-flexibility",
    place: Place::Transmission,
    order: 240,
    hosts: &[HostKind::RigidSpring, HostKind::Spring, HostKind::Body],
    site: "a spring must have a body at each end, not ground",
    parameters: TransmissionFlexibility::PARAMETERS,
    summary: "splits one body into two, with a spring between",
    example: "\
[springs.transmission.effects.transmission-flexibility]
stiffness = \"300 kN/m\"
damping = \"60 N s/m\"
tip_mass = \"4 kg\"
",
    sections: "\
## Model
Two bodies with the force `stiffness e + damping de/dt` between them, `e` their elongation. Under a spring
(rigid or not) these replace its own stiffness and damping. The second body then weighs `tip_mass`, and the
first the rest of what the two weighed together. Under a body, the body is split: its contacts move to a new
one of `tip_mass`, and guides, drives and sensors of motion stay. The ideal machine is the limit of great
stiffness. Weight hangs on the load's side. Where a rigid spring gives way or a body is split, the `gravity`
of a guide of the first body moves to the second. A `constant-load` stays at the guide, on the first body. A
body's own key `gravity` stays with that body. Friction under the spring, such as `lugre-friction`, gives it a
hysteresis.

## Where it comes from
Belts, gears, screws, harmonic drives, couplings, bending links, the mount of a tool.

## How it shows
A mode appears in which motor and tip move against each other. From drive to contact force the phase drops by
180 degrees there and does not return (the noncolocated mode). Force feedback destabilises it above a gain
that the damping of the mode sets. Seen from the motor alone the mode is a zero pair below a pole pair, and
the phase returns. In free motion the zeros are at `sqrt(stiffness / tip_mass)` rad/s, the poles at
`sqrt(stiffness / mu)`, `mu` the reduced mass of the two bodies. That is 43.6 and 53.4 Hz in the example. In
the contact force, `workpiece-dynamics` and `base-flexibility` are such pairs, too. Far below the mode it is a
smaller contact stiffness: `contact-stiffness` looks the same there.

## How it is recognised
Compare the motion of motor and tip over a wide band: they part at the mode, with a drop of 180 degrees in
phase. Below it, only the static stiffness shows.

## Numerical treatment
The machine gets one more body and one more spring, both linear and exact. Linear theory has one more pair
of poles.

## Source
S. D. Eppinger and W. P. Seering, Three dynamic problems in robot force control, IEEE Transactions on
Robotics and Automation 8 (1992): transmission dynamics. Also M. W. Spong, Modeling and control of elastic
joint robots, ASME Journal of Dynamic Systems, Measurement, and Control 109 (1987).
",
    law: LawDrawing {
        axes: ["time, with a step of the motor", "tip position"],
        start: 0.0,
        with: &[Curve::Function(|t| {
            0.6 * (1.0 - (-5.0 * (t - 0.1).max(0.0)).exp() * (30.0 * (t - 0.1).max(0.0)).cos())
        })],
        without: &[Curve::STEP],
        labels: &[(0.35, 0.2, "stiffness, damping, tip_mass")],
    },
    traits: &[Trait::Compliance],
    change: Change::plant::<TransmissionFlexibility>(),
};

impl ChangesPlant for TransmissionFlexibility {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { stiffness, damping, tip_mass } = self;
        match host {
            Host::Body(body) => split_body(machine, body, [stiffness, damping, tip_mass]),
            Host::Spring(spring) => {
                let (a, b) = (machine.links[spring].a, machine.links[spring].b);
                if Assembly::is_ground(a) || Assembly::is_ground(b) {
                    return Err(EffectError::WrongSite {
                        kind: DEFINITION.kind,
                        needs: "a body, or a spring between two bodies",
                    });
                }
                let rest = rest_kg(machine.nodes[a].mass_kg + machine.nodes[b].mass_kg, tip_mass)?;
                machine.nodes[a].mass_kg = rest;
                machine.nodes[b].mass_kg = tip_mass;
                let was_rigid = machine.links[spring].rigid;
                machine.links[spring].set_flexible(stiffness, damping);
                if was_rigid {
                    machine.hang_behind(spring);
                }
                Ok(())
            }
            _ => Err(machine.wrong_host(host, &DEFINITION)),
        }
    }
}

fn split_body(
    machine: &mut Assembly,
    body: NodeId,
    [stiffness, damping, tip_mass]: [f64; 3],
) -> Result<(), EffectError> {
    let rest = rest_kg(machine.nodes[body].mass_kg, tip_mass)?;
    let name = machine.nodes[body].name.clone();
    let tip = machine.add_node(format!("{name}-tip"), tip_mass, body);
    machine.nodes[body].mass_kg = rest;
    machine.move_contacts(body, tip);
    let spring = machine.add_link(format!("{name}-transmission"), body, tip, stiffness, damping);
    machine.hang_behind(spring);
    Ok(())
}

/// Remaining mass on the motor's side.
fn rest_kg(total_kg: f64, tip_mass: f64) -> Result<f64, EffectError> {
    if tip_mass >= total_kg {
        return Err(EffectError::MassExceeded {
            parameter: "tip_mass",
            value_kg: tip_mass,
            available_kg: total_kg,
        });
    }
    Ok(total_kg - tip_mass)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::{POINTS, PositionForce, Pull, TabulatedForce, Weight};
    use crate::effects::fixture::{self, GUIDE, MOTOR, TRANSMISSION};

    const PARAMETERS: [f64; 3] = [3e5, 40.0, 4.0];

    #[test]
    fn truth_a_rigid_and_a_flexible_spring_become_the_same() {
        let (mut rigid, mut flexible) = (fixture::rigid(), fixture::flexible());
        DEFINITION.apply(&mut rigid, TRANSMISSION, &PARAMETERS).unwrap();
        DEFINITION.apply(&mut flexible, TRANSMISSION, &PARAMETERS).unwrap();
        assert_eq!(rigid, flexible);
        let masses: Vec<f64> = rigid.nodes[1..].iter().map(|node| node.mass_kg).collect();
        assert_eq!(masses, [8.0, 4.0]);
    }

    #[test]
    fn truth_a_split_body_hands_its_contacts_to_the_tip() {
        let mut machine = fixture::rigid();
        // The tip of the fixture carries the contact.
        DEFINITION.apply(&mut machine, Host::Body(2), &PARAMETERS).unwrap();
        let ideal = fixture::rigid();
        let tip = machine.nodes.len() - 1;
        assert_eq!(machine.nodes[tip].name, "tip-tip");
        assert_eq!((machine.nodes[2].mass_kg, machine.nodes[tip].mass_kg), (1.0, 4.0));
        assert_eq!((machine.contacts[0].a, machine.contacts[0].b), (tip, 0));
        assert_eq!((&machine.drives, &machine.sensors), (&ideal.drives, &ideal.sensors));
        assert_eq!(machine.links[..2], ideal.links[..]);
        let link = &machine.links[2];
        assert_eq!((link.a, link.b, link.rigid), (2, tip, false));
    }

    #[test]
    fn truth_an_arm_hangs_behind_a_joint_that_gives_way() {
        let arm = |host: Host, flexible: bool| {
            let mut machine = if flexible { fixture::flexible() } else { fixture::rigid() };
            let pull = PositionForce::Pull(Pull { amplitude: 3.0, period: 1.0, phase: 0.0 });
            let table = PositionForce::Table(TabulatedForce::between(0.0, 1.0, [1.0; POINTS]));
            let name = || String::from("guide");
            let weight =
                |is_of_earth, course| Weight { name: name(), on: 1, reacts_on: 0, is_of_earth, course };
            // Loads of a guide stay at the guide.
            machine.weights = vec![weight(false, pull), weight(true, pull), weight(false, table)];
            DEFINITION.apply(&mut machine, host, &PARAMETERS).unwrap();
            machine.weights.iter().map(|weight| machine.nodes[weight.on].name.clone()).collect::<Vec<_>>()
        };
        assert_eq!(arm(TRANSMISSION, false), ["tip", "motor", "motor"]);
        // The file says on which side of a spring it hangs.
        assert_eq!(arm(TRANSMISSION, true), ["motor", "motor", "motor"]);
        assert_eq!(arm(MOTOR, false), ["motor-tip", "motor", "motor"]);
    }

    #[test]
    fn prop_the_motor_keeps_some_mass() {
        for (host, available_kg) in [(TRANSMISSION, 12.0), (MOTOR, 7.0)] {
            let mut machine = fixture::rigid();
            let error = DEFINITION.apply(&mut machine, host, &[3e5, 40.0, 12.0]).unwrap_err();
            assert_eq!(
                error,
                EffectError::MassExceeded { parameter: "tip_mass", value_kg: 12.0, available_kg }
            );
            assert_eq!(machine, fixture::rigid());
        }
    }

    #[test]
    fn prop_a_spring_to_ground_is_no_transmission() {
        let mut machine = fixture::rigid();
        assert!(matches!(
            DEFINITION.apply(&mut machine, GUIDE, &PARAMETERS),
            Err(EffectError::WrongSite { .. })
        ));
    }
}
