//! `coulomb-friction`: dry friction, set-valued at rest.

use super::prelude::*;

parameters! { CoulombFriction
    level: log(Dimension::FORCE, Some(0.0), 10.0, (0.0, 1e6), "force while sliding, and the most at rest"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: CoulombFriction::KIND,
    name: "coulomb-friction",
    place: Place::Guide,
    order: 140,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: CoulombFriction::PARAMETERS,
    summary: "dry friction, set-valued at rest",
    example: "\
[springs.guide.effects.coulomb-friction]
level = \"6 N\"
",
    sections: "\
## Model
Sliding at speed `v`, the guide resists with `level sign(v)`; at rest it takes whatever value up to `level`
keeps it at rest. `v` is the speed of the second body of the spring against the first. Stick and slip are
separate modes of the machine, and the instants between them are located.

## Where it comes from
Seals, plain bearings, preloaded guides and screws, brushes.

## How it shows
The missing force is a step at every reversal of the velocity, of a size that does not depend on speed. It
matters less the larger the motion. Near rest the axis sticks, and an integrating controller creeps to its
reference and stays. Hunting lasts only if the breakaway force exceeds the sliding one, as with
`stribeck-friction`. Well above the `velocity` of that law the two are the same. `drive-deadband` removes
the same force, but with the sign of the command. At a single speed `viscous-friction` looks alike.

## How it is recognised
Plot the missing force against velocity: it is a step at zero, flat on either side. Slow strokes and two
amplitudes show it best.

## Numerical treatment
Sliding and sticking are modes. Sliding has a constant force, sticking joins two bodies, and both are exact;
the instants between them are events. Linear theory takes friction as sliding one way, so it drops out.

## Source
H. Olsson, K. J. Åström, C. Canudas de Wit, M. Gäfvert and P. Lischinsky, Friction models and friction
compensation, European Journal of Control 4 (1998).
",
    law: LawDrawing {
        axes: ["sliding speed", "resistance of the guide"],
        start: -1.0,
        with: &[Curve::Function(|v| 0.3 * v + 0.4 * v.signum())],
        without: &[Curve::GUIDE],
        labels: &[(-0.4, 0.4, "level")],
    },
    traits: &[Trait::Dissipative, Trait::DryFriction],
    change: Change::plant::<CoulombFriction>(),
};

impl ChangesPlant for CoulombFriction {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { level } = self;
        let friction = &mut machine.link_mut(host, &DEFINITION)?.friction;
        friction.forward += level;
        friction.backward += level;
        Ok(())
    }
}
