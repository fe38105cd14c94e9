//! `base-flexibility`: guide, actuator reaction and workpiece are mounted on a base that moves.

use super::prelude::*;
use crate::assembly::GROUND_NODE;

parameters! { BaseFlexibility
    mass: log(Dimension::MASS, None, 180.0, (ABOVE_ZERO, 1e6), "mass of the base"),
    stiffness: log(Dimension::STIFFNESS, None, 1.0e6, (ABOVE_ZERO, 1e12), "stiffness of its mount"),
    damping: log(Dimension::DAMPING, None, 800.0, (0.0, 1e9), "damping of its mount"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: BaseFlexibility::KIND,
    name: "base-flexibility",
    place: Place::Base,
    order: 270,
    hosts: &[HostKind::RigidSpring, HostKind::Spring],
    site: "one end of the spring must be on ground",
    parameters: BaseFlexibility::PARAMETERS,
    summary: "guide, actuator reaction and workpiece ride on a base that moves",
    example: "\
[springs.mount.effects.base-flexibility]
mass = \"180 kg\"
stiffness = \"1.0232806 MN/m\"
damping = \"814.3 N s/m\"
",
    sections: "\
## Model
`mass x_b'' = -stiffness x_b - damping x_b' + (all that guide, drive and workpiece exert on the base)`. Under
a rigid mount (a spring between ground and a body), that body is the base: its mass becomes `mass`, and the
mount yields. Under a guide to ground, a base is put between: every spring, contact and drive end that was on
ground moves to it. Sensors stay where they are, so a reading relative to ground stays absolute. Where an
encoder rides on the base, describe the base as a body on a rigid mount and name it in `relative_to`.

## Where it comes from
Machine frames on rubber feet, robot columns, benches, floors.

## How it shows
A pole pair beside a zero pair, mostly at 5 to 20 Hz. The pair is colocated: drive and contact both act
between axis and base. In contact the phase dips and recovers if the contact mode lies above the base mode,
and rises and recovers if it lies below. With enough damping it hardly limits the gain. `workpiece-dynamics`
makes such a pair in contact only, mostly at higher frequency. In free motion the base shows in a position
read against it, where the phase rises and returns. There the poles are at `sqrt(stiffness / mass)` rad/s, and
the zeros at `sqrt(stiffness / (mass + moving mass))`. In contact the zeros are the same. A slow oscillation
after steps looks like that of a force loop with an `actuator-lag`.

## How it is recognised
The phase of the contact force swings, down or up, and returns near the base mode, mostly between 5 and 20 Hz.
In free motion it rises there in a position against the base, while an absolute position shows next to
nothing. An accelerometer on the base decides.

## Numerical treatment
The base is one more body; everything stays linear and exact. Linear theory has a pair of poles beside a
pair of zeros.

## Source
S. D. Eppinger and W. P. Seering, Three dynamic problems in robot force control, IEEE Transactions on
Robotics and Automation 8 (1992): robot base dynamics.
",
    law: LawDrawing {
        axes: ["time after a step of the drive force", "base position"],
        start: 0.0,
        with: &[Curve::Function(|t| -0.5 * (1.0 - (-4.0 * t).exp() * (25.0 * t).cos()))],
        without: &[Curve::Points(&[(0.0, 0.0), (1.0, 0.0)])],
        labels: &[(0.4, -0.9, "mass, stiffness, damping"), (0.55, 0.4, "in free motion")],
    },
    traits: &[Trait::Compliance],
    change: Change::plant::<BaseFlexibility>(),
};

impl ChangesPlant for BaseFlexibility {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { mass, stiffness, damping } = self;
        let Host::Spring(spring) = host else { return Err(machine.wrong_host(host, &DEFINITION)) };
        let link = &mut machine.links[spring];
        let body = match (Assembly::is_ground(link.a), Assembly::is_ground(link.b)) {
            (true, false) => link.b,
            (false, true) => link.a,
            _ => {
                return Err(EffectError::WrongSite {
                    kind: DEFINITION.kind,
                    needs: "a spring with one end on ground",
                });
            }
        };
        if link.rigid {
            link.set_flexible(stiffness, damping);
            machine.nodes[body].mass_kg = mass;
        } else {
            let name = format!("{}-base", link.name);
            let base = machine.add_node(name.clone(), mass, GROUND_NODE);
            machine.move_everything(GROUND_NODE, base);
            machine.add_link(name, GROUND_NODE, base, stiffness, damping);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::fixture::{self, GUIDE, TRANSMISSION};

    const PARAMETERS: [f64; 3] = [180.0, 1e6, 800.0];

    #[test]
    fn truth_all_that_stood_on_ground_rides_on_the_base() {
        let mut machine = fixture::flexible();
        DEFINITION.apply(&mut machine, GUIDE, &PARAMETERS).unwrap();
        let base = machine.nodes.len() - 1;
        let mut expected = fixture::flexible();
        expected.add_node("guide-base".into(), 180.0, GROUND_NODE);
        expected.links[0].a = base;
        expected.contacts[0].b = base;
        expected.drives[0].reacts_on = base;
        expected.add_link("guide-base".into(), GROUND_NODE, base, 1e6, 800.0);
        assert_eq!(machine, expected);
    }

    #[test]
    fn truth_a_rigid_mount_yields() {
        let mut machine = fixture::flexible();
        machine.links[0].rigid = true;
        DEFINITION.apply(&mut machine, GUIDE, &PARAMETERS).unwrap();
        let mut expected = fixture::flexible();
        expected.links[0].set_flexible(1e6, 800.0);
        expected.nodes[1].mass_kg = 180.0;
        assert_eq!(machine, expected);
    }

    #[test]
    fn prop_a_spring_away_from_ground_is_no_mount() {
        for mut machine in [fixture::rigid(), fixture::flexible()] {
            assert!(matches!(
                DEFINITION.apply(&mut machine, TRANSMISSION, &PARAMETERS),
                Err(EffectError::WrongSite { .. })
            ));
        }
    }
}
