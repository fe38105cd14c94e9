//! `hertz-contact`: the force grows with a power of the compression.

use super::prelude::*;

parameters! { HertzContact
    exponent: linear(Dimension::NONE, None, 1.5, (1.0, 5.0), "1.5 for smooth spheres, 1 for a spring"),
    stiffness: log(
        Dimension::POWER_STIFFNESS, None, 2e7, (ABOVE_ZERO, 1e15), "force at a compression of one metre"
    ),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: HertzContact::KIND,
    name: "hertz-contact",
    place: Place::Contact,
    order: 320,
    hosts: &[HostKind::Contact],
    site: "",
    parameters: HertzContact::PARAMETERS,
    summary: "the force grows with a power of the compression",
    example: "\
[contacts.tool.effects.hertz-contact]
exponent = 1.5
stiffness = \"20 MN/m^1.5\"
",
    sections: "\
## Model
The elastic force is `stiffness d^exponent`, `d` the compression, in place of the believed one and of a
`contact-stiffness`; the damping of the contact stays. A ball of radius `R` on a flat has
`stiffness = 4/3 E sqrt(R)`, with `1/E = (1 - nu1^2)/E1 + (1 - nu2^2)/E2`. With 10 mm, steel on steel has
1.5e10 N/m^1.5, on polyamide 5e8, on hard polyurethane (0.11 GPa) 2e7. If the materials are known, write the
contact with `law = \"hertz\"` and the `material` of its `surface` instead. On a linear contact the effect is
absent at `exponent = 1` and the stiffness that the contact has. A clamped contact pulls by the same law as it
pushes; a diagnosis leaves the effect out of clamped records.

## Where it comes from
Curved surfaces: the area of contact grows as they are pressed together. Rough flat surfaces have an exponent
of about 2 to 3, until they close.

## How it shows
The stiffness grows with force as `F^((n - 1) / n)`, `n` the exponent. A force loop that is stable at a light
touch turns unstable when pressing, and touch-down is soft. About one force level `contact-stiffness` looks
the same; two levels separate them. `hardening-stiffness` is nearly linear at small force, where this effect
changes most.

## How it is recognised
Press at two forces: the contact mode is higher at the larger force. A force loop may be stable at a light
touch and unstable when pressing.

## Numerical treatment
The power law has no exponential, so an extrapolation method integrates modes in contact to machine precision;
flight stays exact. Linear theory takes the stiffness at the operating force.

## Source
K. L. Johnson, Contact Mechanics, Cambridge University Press (1985), chapter 4.
",
    law: LawDrawing {
        axes: ["compression", "elastic contact force"],
        start: 0.0,
        with: &[Curve::Function(|d| 0.9 * d.powf(1.5))],
        without: &[Curve::Points(&[(0.0, 0.0), (1.0, 0.6)])],
        labels: &[(0.25, 0.6, "exponent, stiffness")],
    },
    traits: &[Trait::SurfacesPart],
    change: Change::plant::<HertzContact>(),
};

impl ChangesPlant for HertzContact {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { exponent, stiffness } = self;
        let law = &mut machine.contact_mut(host, &DEFINITION)?.law;
        law.exponent = exponent;
        law.stiffness = stiffness;
        Ok(())
    }
}
