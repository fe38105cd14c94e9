//! `speed-table`: a force over speed that no law describes, by its values at some points.

use super::force_table::table;
use super::prelude::*;
use crate::assembly::TabulatedForce;

parameters! { SpeedTable
    from: linear(Dimension::VELOCITY, None, -0.1, (-1e6, 1e6), "speed of the first point"),
    to: linear(Dimension::VELOCITY, None, 0.1, (-1e6, 1e6), "speed of the last point, above `from`"),
    force_1: linear(Dimension::FORCE, Some(0.0), 4.0, (-1e6, 1e6), "force at the first point"),
    force_2: linear(Dimension::FORCE, Some(0.0), 3.0, (-1e6, 1e6), "force at the second point"),
    force_3: linear(Dimension::FORCE, Some(0.0), 2.0, (-1e6, 1e6), "force at the third point"),
    force_4: linear(Dimension::FORCE, Some(0.0), 1.0, (-1e6, 1e6), "force at the fourth point"),
    force_5: linear(Dimension::FORCE, Some(0.0), 1.0, (-1e6, 1e6), "force midway"),
    force_6: linear(Dimension::FORCE, Some(0.0), -1.0, (-1e6, 1e6), "force at the sixth point"),
    force_7: linear(Dimension::FORCE, Some(0.0), -2.0, (-1e6, 1e6), "force at the seventh point"),
    force_8: linear(Dimension::FORCE, Some(0.0), -3.0, (-1e6, 1e6), "force at the eighth point"),
    force_9: linear(Dimension::FORCE, Some(0.0), -4.0, (-1e6, 1e6), "force at the last point"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: SpeedTable::KIND,
    name: "speed-table",
    place: Place::Guide,
    order: 226,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: SpeedTable::PARAMETERS,
    summary: "a force over speed that no law describes, by nine values",
    example: "\
[springs.guide.effects.speed-table]
from = \"-32 mm/s\"
to = \"32 mm/s\"
force_1 = \"9 N\"
force_2 = \"11 N\"
force_3 = \"8 N\"
force_4 = \"3 N\"
force_5 = 0.0
force_6 = \"-2 N\"
force_7 = \"-5 N\"
force_8 = \"-6 N\"
force_9 = \"-4 N\"
",
    sections: "\
## Model
A force acts on the second body of the spring, and its opposite on the first. It depends on the speed `v` of
the second against the first. Nine points lie evenly spaced from `from` to `to`; choose the range that was
recorded. The forces there are `force_1` to `force_9`. Between the points the force follows straight lines
with rounded corners, as that of `force-table` does. Beyond its ends the force levels out at the outermost
value, so the range should include zero: otherwise the end value is a load at rest. If the range is symmetric,
`force_5` is that load: leave it at zero, unless a `constant-load` acts. The `typical` value of `force_5` is
only a scale for fits. Even with `force_5 = 0` a rounded corner leaves about `(force_4 + force_6) / 8` at
rest. A resistance is negative at positive speed and positive at negative speed, opposite to the drawing of
`viscous-friction`. Forward and backward have their own points, so a table may differ by direction.

## Where it comes from
It is not a cause, but what is left when none is known: a drive that sags, a seal, grease, a bearing.

## How it shows
The missing force is a function of speed alone, the same at every position. A straight line through zero speed
is `viscous-friction`, a line for each direction `directional-damping`, a parabola `quadratic-drag`. Their
laws hold beyond the recorded speeds too. A force at zero speed is a `constant-load`, and a drive whose force
falls with speed has a `torque-speed-line`. Dry friction jumps at rest. A table over speed is smooth there, so
it cannot describe it, nor hold an axis at rest: the axis creeps. Add `coulomb-friction` for that. A Stribeck
fall within one spacing is not resolved.

## How it is recognised
Plot the missing force against speed: it is one curve. A diagnosis never names the table as a cause. It
proposes one as it does a `force-table`.

## Numerical treatment
The force is an analytic function of the speed, so an extrapolation method integrates the mode to machine
precision. The energy balance counts its work as damping, which is negative where the force drives the motion.
Linear theory takes the slope at rest: damping of either sign.

## Source
L. Ljung, System Identification: Theory for the User, Prentice Hall (1999), chapter 5: nonlinear black-box
models.
",
    law: LawDrawing {
        axes: ["sliding speed", "force on the second body"],
        start: -1.0,
        with: &[Curve::Function(|v| {
            TabulatedForce::between(-0.8, 0.8, [0.45, 0.55, 0.4, 0.15, 0.0, -0.2, -0.5, -0.6, -0.4]).force(v)
        })],
        without: &[],
        labels: &[(-0.95, 0.2, "from"), (0.8, -0.15, "to"), (-0.65, 0.7, "force_2")],
    },
    traits: &[],
    change: Change::plant::<SpeedTable>(),
};

impl ChangesPlant for SpeedTable {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        machine.link_mut(host, &DEFINITION)?.over_speed = table(&self)?;
        Ok(())
    }
}
