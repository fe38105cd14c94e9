//! `hunt-crossley-contact`: damping grows with compression.

use super::prelude::*;

parameters! { HuntCrossleyContact
    alpha: log(
        Dimension::INVERSE_VELOCITY, Some(0.0), 2.0, (0.0, 1e3),
        "relative growth of the force per unit of closing speed"
    ),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: HuntCrossleyContact::KIND,
    name: "hunt-crossley-contact",
    place: Place::Contact,
    order: 310,
    hosts: &[HostKind::Contact],
    site: "",
    parameters: HuntCrossleyContact::PARAMETERS,
    summary: "damping grows with compression",
    example: "\
[contacts.tool.effects.hunt-crossley-contact]
alpha = \"6 s/m\"
",
    sections: "\
## Model
The force is `k d^n (1 + alpha d') + c d'`, `d` the compression. This is the law of the contact with `alpha`
more, so that the loss sets in with the force and not at the first touch. Where the law would pull, a contact
that only pushes has no force. A clamped contact has the loss in push and pull. A diagnosis leaves the effect
out of clamped records. The linear damping `c` that the contact has stays, and with it the step that it makes
at touch-down.

## Where it comes from
Most solid contacts: material loss happens in the volume that is deformed, which grows as the bodies approach.
`alpha` is about 0.1 to 0.5 s/m for metals, 0.5 to 2 s/m for wood and hard plastics, more for rubber.

## How it shows
The restitution falls with impact speed, by about `2 alpha v / 3` for small `alpha v`. Linear damping makes a
step at touch-down; this loss makes none: with `c` zero the force rises from zero. About one contact force and
for small motion it is `contact-damping` of `c + alpha k d^n`; another force level separates them. The rise of
force with speed resembles `hertz-contact` and `hardening-stiffness`, which lose nothing.

## How it is recognised
Drop the tool at several speeds: the restitution falls with speed, and the loss adds no step of force at
touch-down.

## Numerical treatment
The law is nonlinear, so an extrapolation method integrates modes in contact to machine precision; flight
stays exact. Linear theory takes stiffness and damping at the operating force.

## Source
K. H. Hunt and F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact, ASME
Journal of Applied Mechanics 42 (1975).
",
    law: LawDrawing {
        axes: ["compression during an impact", "contact force"],
        start: 0.0,
        with: &[
            Curve::Function(|d| 0.6 * d * (1.0 + 0.7 * (1.0 - d * d).sqrt())),
            Curve::Function(|d| 0.6 * d * (1.0 - 0.5 * (1.0 - d * d).sqrt())),
        ],
        without: &[Curve::Points(&[(0.0, 0.0), (1.0, 0.6)])],
        labels: &[(0.3, 0.8, "alpha"), (0.2, 0.47, "closing"), (0.65, 0.06, "parting")],
    },
    traits: &[Trait::Dissipative, Trait::SurfacesPart],
    change: Change::plant::<HuntCrossleyContact>(),
};

impl ChangesPlant for HuntCrossleyContact {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { alpha } = self;
        machine.contact_mut(host, &DEFINITION)?.law.alpha += alpha;
        Ok(())
    }
}
