//! `tool-inertia`: the mass beyond the sensor adds mass times tip acceleration to the reading.

use super::{Change, ChangesPlant, Curve, Definition, EffectError, Host, HostKind, Law, Parameters, Place};
use crate::assembly::{Assembly, Source};
use crate::units::Dimension;

parameters! { ToolInertia
    mass: log(Dimension::MASS, Some(0.0), 1.0, (0.0, 1e5), "mass between the sensor and the surface"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ToolInertia::KIND,
    name: "tool-inertia",
    place: Place::ForceSensor,
    hosts: &[HostKind::ForceSensor],
    site: "what the sensor reads must have a body at its end",
    parameters: ToolInertia::PARAMETERS,
    summary: "the mass beyond the sensor adds mass times tip acceleration to the reading",
    documentation: "\
## Example
```toml
[sensors.force.effects.tool-inertia]
mass = \"1.5 kg\"
```
`feeler run scenarios/effects/tool-inertia.toml` runs it.

## Model
The reading is `F + mass x''`, `x''` the acceleration of the tip. The tip is the first body of the contact
that the sensor reads, or the second of a spring. The motion of the machine stays as it was: the mass is part
of the tip's. A spring carries all of its second body already, so there `mass` is counted on top of it.

## Where it comes from
Grippers, tools and adapter plates between a wrist sensor and the part.

## How it shows
Free motion gives readings in proportion to acceleration, with no contact at all. In contact a zero pair
appears at `sqrt(k / mass)`, `k` the stiffness of the contact, and the phase leads above it. An impact reads
too low while the tip decelerates. `added-mass` changes the motion and not the reading. While the machine
rings at one frequency, acceleration and force are proportional, and `force-gain` looks the same.

## How it is recognised
Shake the tool in free motion: the reading follows the acceleration, in proportion.

## Numerical treatment
The reading contains the acceleration of the same equations that move the machine, so it is exact. Linear
theory has a direct term from acceleration to reading.

## Source
D. Kubus, T. Kröger and F. M. Wahl, On-line estimation of inertial parameters using a recursive total
least-squares approach, IEEE/RSJ International Conference on Intelligent Robots and Systems (2008).
",
    law: Law {
        axes: ["acceleration in free motion", "force reading"],
        start: -1.0,
        with: &[Curve::Points(&[(-1.0, -0.7), (1.0, 0.7)])],
        without: &[Curve::Points(&[(-1.0, 0.0), (1.0, 0.0)])],
    },
    traits: &[],
    change: Change::plant::<ToolInertia>(),
};

impl ChangesPlant for ToolInertia {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { mass } = self;
        let Host::Sensor(i) = host else { return Err(machine.wrong_host(host, &DEFINITION)) };
        let tip = match machine.sensors[i].source {
            Source::Contact(contact, _) => machine.contacts[contact].a,
            Source::Link(link, _) if !Assembly::is_ground(machine.links[link].b) => machine.links[link].b,
            _ => {
                return Err(EffectError::WrongSite {
                    kind: DEFINITION.kind,
                    needs: "a sensor of a contact, or of a spring whose second body can move",
                });
            }
        };
        if mass > 0.0 {
            let carried = machine.sensors[i].tool_inertia.0;
            machine.sensors[i].tool_inertia = (carried + mass, tip);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::Quantity;
    use crate::effects::fixture::{self, FORCE};

    #[test]
    fn truth_the_tip_of_a_contact_and_the_far_end_of_a_spring_count() {
        let tip = 2;
        for source in [Source::Contact(0, Quantity::SpringForce), Source::Link(1, Quantity::Force)] {
            let mut machine = fixture::flexible();
            machine.sensors[0].source = source;
            DEFINITION.apply(&mut machine, FORCE, &[0.5]).unwrap();
            DEFINITION.apply(&mut machine, FORCE, &[0.25]).unwrap();
            assert_eq!(machine.sensors[0].tool_inertia, (0.75, tip));
        }
    }

    #[test]
    fn prop_a_drive_has_no_tip_and_neither_has_ground() {
        for source in [Source::Drive(0, Quantity::Force), Source::Link(0, Quantity::Force)] {
            let mut machine = fixture::flexible();
            machine.sensors[0].source = source;
            (machine.links[0].a, machine.links[0].b) = (1, 0);
            assert!(matches!(
                DEFINITION.apply(&mut machine, FORCE, &[0.5]),
                Err(EffectError::WrongSite { .. })
            ));
        }
    }
}
