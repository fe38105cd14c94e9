//! `load-friction`: the Coulomb level grows with contact force and weight.

use super::prelude::*;

parameters! { LoadFriction
    ratio: log(Dimension::NONE, Some(0.0), 0.1, (0.0, 10.0), "friction level per unit of load"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: LoadFriction::KIND,
    name: "load-friction",
    place: Place::Guide,
    order: 190,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: LoadFriction::PARAMETERS,
    summary: "the Coulomb level grows with contact force and weight",
    example: "\
[springs.guide.effects.load-friction]
ratio = 0.15
",
    sections: "\
## Model
The level of dry friction, sliding and at rest, is `ratio |F|` above what it is without load. `|F|` is the sum
of the sizes of all contact forces of the machine, and of its weights: the `gravity` of its bodies and the
effect `gravity`. A gear of efficiency `eta` has `ratio = 1 / eta - 1`: 0.11 for 90 %. Above a ratio of 1 it
is self-locking. A `constant-load` does not count. Neither does the acceleration that the gear carries,
although it loads a real one.

## Where it comes from
Screws, gears (as their efficiency) and plain guides that carry the process force or a weight, guides that are
tilted by it. Strain-wave gears of arm joints that hold their links.

## How it shows
Free motion without weights is as predicted. An arm that swings has most friction where its weight pulls most,
and least where the arm hangs. In contact, the command for a force differs by `2 ratio |F|` between rising and
falling force: a hysteresis in proportion to the force. At one contact force `coulomb-friction` does the same,
but it also acts where nothing loads the guide. This loop, between command and contact force, stays open in
slow motion. That of `contact-damping`, between contact force and compression, closes.

## How it is recognised
Push up and down in contact at several forces: the width of the hysteresis grows with the force. Swing an arm
over a wide angle: between the two directions, the missing torque differs most where the weight pulls most.
Over a narrow angle the same motion is that of `coulomb-friction`.

## Numerical treatment
Stick and slip are events, as for dry friction without load. Where the friction follows a weight or the force
of a clamped contact, an extrapolation method integrates the mode to machine precision. Linear theory leaves
it out. While the guide slides, the drive really meets the contact force times `1 + ratio` (pressing on) or
`1 - ratio` (backing off).

## Source
A. C. Bittencourt and S. Gunnarsson, Static friction in a robot joint: modeling and identification of load
and temperature effects, ASME Journal of Dynamic Systems, Measurement, and Control 134 (2012).
",
    law: LawDrawing {
        axes: ["load", "level of dry friction"],
        start: 0.0,
        with: &[Curve::Points(&[(0.0, 0.2), (1.0, 0.9)])],
        without: &[Curve::Points(&[(0.0, 0.2), (1.0, 0.2)])],
        labels: &[(0.25, 0.65, "slope: ratio")],
    },
    traits: &[Trait::Dissipative, Trait::DryFriction],
    change: Change::plant::<LoadFriction>(),
};

impl ChangesPlant for LoadFriction {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { ratio } = self;
        machine.link_mut(host, &DEFINITION)?.friction.load_ratio += ratio;
        Ok(())
    }
}
