//! `added-mass`: payload or error of the inertia.

use super::prelude::*;

parameters! { AddedMass
    mass: linear(Dimension::MASS, Some(0.0), 2.0, (-1e5, 1e5), "beyond the believed one; may be negative"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: AddedMass::KIND,
    name: "added-mass",
    place: Place::Transmission,
    order: 230,
    hosts: &[HostKind::Body],
    site: "",
    parameters: AddedMass::PARAMETERS,
    summary: "payload or inertia error",
    example: "\
[bodies.tip.effects.added-mass]
mass = \"3 kg\"
",
    sections: "\
## Model
The mass of the body is larger by `mass`, or smaller if `mass` is negative. The sum must be positive. Its
weight is a separate effect: a `constant-load` on a vertical axis, `gravity` on a joint that turns.

## Where it comes from
Payloads, grippers and cables that nobody entered, inertia of motor and gear that departs from the data
sheet.

## How it shows
Free acceleration is lower by one factor at all frequencies below the first mode, which moves down. Static
force in contact is as predicted. Free acceleration alone cannot tell it from `drive-gain`; a steady speed
against friction or a static force can. `tool-inertia` shows in the force reading only, and the motion stays
as it was.

## How it is recognised
Free acceleration is too small by one factor while the static contact force is right. The first mode moves
down.

## Numerical treatment
The body's mass changes; everything stays exact. Linear theory uses the changed mass.

## Source
C. G. Atkeson, C. H. An and J. M. Hollerbach, Estimation of inertial parameters of manipulator loads and
links, International Journal of Robotics Research 5 (1986).
",
    law: LawDrawing {
        axes: ["drive force", "acceleration"],
        start: -1.0,
        with: &[Curve::Points(&[(-0.9, -0.54), (0.9, 0.54)])],
        without: &[Curve::UNCHANGED],
        labels: &[(0.5, 0.12, "mass")],
    },
    traits: &[Trait::PlainNumber],
    change: Change::plant::<AddedMass>(),
};

impl ChangesPlant for AddedMass {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { mass } = self;
        let node = machine.node_mut(host, &DEFINITION)?;
        if node.mass_kg + mass <= 0.0 {
            return Err(EffectError::MassExceeded {
                parameter: "mass",
                value_kg: mass,
                available_kg: node.mass_kg,
            });
        }
        node.mass_kg += mass;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::fixture::{self, MOTOR};

    #[test]
    fn prop_a_body_keeps_some_mass() {
        let mut machine = fixture::flexible();
        let all = machine.nodes[1].mass_kg;
        let error = DEFINITION.apply(&mut machine, MOTOR, &[-all]).unwrap_err();
        assert_eq!(error, EffectError::MassExceeded { parameter: "mass", value_kg: -all, available_kg: all });
        DEFINITION.apply(&mut machine, MOTOR, &[-0.5 * all]).unwrap();
        assert!(machine.nodes[1].mass_kg > 0.0);
    }
}
