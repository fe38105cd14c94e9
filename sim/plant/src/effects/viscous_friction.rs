//! `viscous-friction`: additional damping of the guide.

use super::prelude::*;

parameters! { ViscousFriction
    damping: log(Dimension::DAMPING, Some(0.0), 60.0, (0.0, 1e9), "beyond the damping of the guide"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ViscousFriction::KIND,
    name: "viscous-friction",
    place: Place::Guide,
    order: 160,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: ViscousFriction::PARAMETERS,
    summary: "damping on top of the guide's own",
    example: "\
[springs.guide.effects.viscous-friction]
damping = \"300 N s/m\"
",
    sections: "\
## Model
The guide resists with `damping v` on top of the damping it has.

## Where it comes from
Grease and oil, eddy currents, back-EMF of a motor that is not modelled, air in a bellows.

## How it shows
The missing force is proportional to velocity. Free motion reaches less speed for the same force, and modes
in which the guide slides are better damped. At one speed `coulomb-friction` resists as much; over a range
of speeds a line and a step differ. In contact `contact-damping` damps the contact mode alike, but it leaves
free motion as it was.

## How it is recognised
Plot the missing force against velocity: it is a straight line through zero. Motion at several speeds shows
the slope.

## Numerical treatment
It adds to the damping of the guide and is exact, in simulation and in linear theory.

## Source
B. Armstrong-Hélouvry, Control of Machines with Friction, Kluwer (1991).
",
    law: LawDrawing {
        axes: ["sliding speed", "resistance of the guide"],
        start: -1.0,
        with: &[Curve::Points(&[(-1.0, -0.8), (1.0, 0.8)])],
        without: &[Curve::GUIDE],
        labels: &[(0.05, 0.6, "damping")],
    },
    traits: &[Trait::Dissipative],
    change: Change::plant::<ViscousFriction>(),
};

impl ChangesPlant for ViscousFriction {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { damping } = self;
        machine.link_mut(host, &DEFINITION)?.damping += damping;
        Ok(())
    }
}
