//! `friction-table`: dry friction over position that no law describes, by its levels at some points.

use super::force_table::table;
use super::prelude::*;
use crate::assembly::TabulatedForce;

parameters! { FrictionTable
    from: linear(Dimension::LENGTH, None, -0.01, (-1e6, 1e6), "position of the first point"),
    to: linear(Dimension::LENGTH, None, 0.01, (-1e6, 1e6), "position of the last point, above `from`"),
    level_1: linear(Dimension::FORCE, Some(0.0), 1.0, (0.0, 1e6), "friction at the first point"),
    level_2: linear(Dimension::FORCE, Some(0.0), 1.0, (0.0, 1e6), "friction at the second point"),
    level_3: linear(Dimension::FORCE, Some(0.0), 1.0, (0.0, 1e6), "friction at the third point"),
    level_4: linear(Dimension::FORCE, Some(0.0), 3.0, (0.0, 1e6), "friction at the fourth point"),
    level_5: linear(Dimension::FORCE, Some(0.0), 4.0, (0.0, 1e6), "friction midway"),
    level_6: linear(Dimension::FORCE, Some(0.0), 3.0, (0.0, 1e6), "friction at the sixth point"),
    level_7: linear(Dimension::FORCE, Some(0.0), 1.0, (0.0, 1e6), "friction at the seventh point"),
    level_8: linear(Dimension::FORCE, Some(0.0), 1.0, (0.0, 1e6), "friction at the eighth point"),
    level_9: linear(Dimension::FORCE, Some(0.0), 1.0, (0.0, 1e6), "friction at the last point"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: FrictionTable::KIND,
    name: "friction-table",
    place: Place::Guide,
    order: 227,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: FrictionTable::PARAMETERS,
    summary: "dry friction over position that no law describes, by nine levels",
    example: "\
[springs.guide.effects.friction-table]
from = \"0 mm\"
to = \"8 mm\"
level_1 = 0.0
level_2 = 0.0
level_3 = \"4 N\"
level_4 = \"10 N\"
level_5 = \"7 N\"
level_6 = \"2 N\"
level_7 = 0.0
level_8 = 0.0
level_9 = 0.0
",
    sections: "\
## Model
Dry friction acts at the spring, with a level that depends on the position `x` of the second body against the
first. Nine points lie evenly spaced from `from` to `to`; choose the range that was recorded. The levels there
are `level_1` to `level_9`. Between the points the level follows straight lines with rounded corners, as the
force of `force-table` does. Beyond its ends it stays at the outermost level. It adds to other dry friction of
the spring. The static level equals the sliding one: at rest the spring holds up to the level at the place.

## Where it comes from
It is not a cause, but what is left when none is known: a tight spot, a rail out of line, worn or dry
stretches, a gear that binds over part of its turn.

## How it shows
The missing force opposes the speed. Its size varies along the travel. With the same level everywhere it is
`coulomb-friction`. A force that keeps its sign in both directions is a `force-table`. If the axis passes in
one direction only, a `force-table` gives the same motion: drive over the stretch both ways. In contact or
under a weight, `load-friction` also changes the level.

## How it is recognised
Plot the missing force against position, forward and backward: the two curves are equal and opposite. A
diagnosis never names the table as a cause. It proposes one as it does a `force-table`.

## Numerical treatment
Forward, backward and stick are modes, as for `coulomb-friction`. The instants between them are events,
located to machine precision. The level is an analytic function of the position, so an extrapolation method
integrates each mode to machine precision. Linear theory takes the guide as sliding. It leaves out the slope
of the level, which would be a stiffness of either sign.

## Source
M. R. Popovic and A. A. Goldenberg, Modeling of friction using spectral analysis, IEEE Transactions on
Robotics and Automation 14 (1998).
",
    law: LawDrawing {
        axes: ["position", "resistance of the guide"],
        start: -1.0,
        with: &[Curve::Function(level), Curve::Function(|x| -level(x))],
        without: &[],
        labels: &[
            (-0.95, 0.3, "from"),
            (0.75, 0.3, "to"),
            (0.15, 0.75, "forward: level_4"),
            (0.15, -0.85, "backward: -level_4"),
        ],
    },
    traits: &[Trait::Dissipative, Trait::DryFriction],
    change: Change::plant::<FrictionTable>(),
};

fn level(x: f64) -> f64 {
    TabulatedForce::between(-0.8, 0.8, [0.1, 0.1, 0.25, 0.7, 0.5, 0.2, 0.1, 0.1, 0.1]).force(x)
}

impl ChangesPlant for FrictionTable {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        machine.link_mut(host, &DEFINITION)?.friction.over = table(&self)?;
        Ok(())
    }
}
