//! `tool-inertia`: the mass beyond the sensor adds mass times tip acceleration to the reading.

use super::prelude::*;
use crate::assembly::Source;

parameters! { ToolInertia
    mass: log(Dimension::MASS, Some(0.0), 1.0, (0.0, 1e5), "mass between the sensor and the surface"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ToolInertia::KIND,
    name: "tool-inertia",
    place: Place::ForceSensor,
    order: 390,
    hosts: &[HostKind::ForceSensor],
    site: "what the sensor reads must have a body at its end",
    parameters: ToolInertia::PARAMETERS,
    summary: "the mass beyond the sensor adds mass times tip acceleration to the reading",
    example: "\
[sensors.force.effects.tool-inertia]
mass = \"1.5 kg\"
",
    sections: "\
## Model
The reading is `F + mass x''`. `F` is the force that the sensor would read without the effect, and `x''` the
acceleration of the tip. The tip is the first body of the contact that the sensor reads, or the second body of
a spring. `mass` belongs to the mass of the tip's body, so it is at most that: the effect adds none to the
machine. A spring transmits the inertia of its second body already, and `mass` comes on top of that. The
weight of the tool is a `force-bias`, and it turns with the tool: calibrate in each pose.

## Where it comes from
Grippers, tools and adapter plates between a wrist sensor and the part.

## How it shows
Free motion gives readings in proportion to acceleration, with no contact at all. On a fixed wall of
stiffness `k` the reading has a pair of zeros at `sqrt(k / mass)` in rad/s; above it the phase is 180 degrees
higher. An impact reads too low while the tip decelerates.

If a drive without lag acts on the tip's own body of mass `M`, the sensor shows `mass / M` of its force at
once. A fast sampled proportional loop then needs `kp mass / M` below 1, unless a filter removes this part.

For the same command `added-mass` changes the motion; this effect changes only the reading. While the machine
rings at one frequency, acceleration and force are proportional, and `force-gain` looks the same.

## How it is recognised
Shake the tool in free motion. Plot the reading over the measured acceleration: the slope is `mass`.

## Numerical treatment
The acceleration is that of the equations of motion, not a difference of velocities, so the reading has no
error of its own. Linear theory includes it, and the direct part from a drive to the reading too.

## Source
D. Kubus, T. Kröger and F. M. Wahl, On-line estimation of inertial parameters using a recursive total
least-squares approach, IEEE/RSJ International Conference on Intelligent Robots and Systems (2008).
",
    law: LawDrawing {
        axes: ["acceleration in free motion", "force reading"],
        start: -1.0,
        with: &[Curve::Points(&[(-1.0, -0.7), (1.0, 0.7)])],
        without: &[Curve::Points(&[(-1.0, 0.0), (1.0, 0.0)])],
        labels: &[(0.1, 0.6, "slope: mass")],
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
