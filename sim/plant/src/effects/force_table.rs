//! `force-table`: a force over position that no law describes, by its values at some points.

use super::prelude::*;
use crate::assembly::{PositionForce, TabulatedForce, Weight};

parameters! { ForceTable
    from: linear(Dimension::LENGTH, None, -0.01, (-1e6, 1e6), "position of the first point"),
    to: linear(Dimension::LENGTH, None, 0.01, (-1e6, 1e6), "position of the last point, above `from`"),
    force_1: linear(Dimension::FORCE, Some(0.0), 1.0, (-1e6, 1e6), "force at the first point"),
    force_2: linear(Dimension::FORCE, Some(0.0), 1.0, (-1e6, 1e6), "force at the second point"),
    force_3: linear(Dimension::FORCE, Some(0.0), 2.0, (-1e6, 1e6), "force at the third point"),
    force_4: linear(Dimension::FORCE, Some(0.0), 4.0, (-1e6, 1e6), "force at the fourth point"),
    force_5: linear(Dimension::FORCE, Some(0.0), 6.0, (-1e6, 1e6), "force midway"),
    force_6: linear(Dimension::FORCE, Some(0.0), 8.0, (-1e6, 1e6), "force at the sixth point"),
    force_7: linear(Dimension::FORCE, Some(0.0), 4.0, (-1e6, 1e6), "force at the seventh point"),
    force_8: linear(Dimension::FORCE, Some(0.0), 2.0, (-1e6, 1e6), "force at the eighth point"),
    force_9: linear(Dimension::FORCE, Some(0.0), 1.0, (-1e6, 1e6), "force at the last point"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ForceTable::KIND,
    name: "force-table",
    place: Place::Guide,
    order: 225,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: ForceTable::PARAMETERS,
    summary: "a force over position that no law describes, by nine values",
    example: "\
[springs.guide.effects.force-table]
from = \"-1 mm\"
to = \"7 mm\"
force_1 = 0.0
force_2 = 0.0
force_3 = \"-4 N\"
force_4 = \"-12 N\"
force_5 = \"-9 N\"
force_6 = \"-3 N\"
force_7 = 0.0
force_8 = 0.0
force_9 = 0.0
",
    sections: "\
## Model
A force acts on the second body of the spring, and its opposite on the first. It depends on the position `x`
of the second against the first. Nine points lie evenly spaced from `from` to `to`; choose the range that was
recorded. The forces there are `force_1` to `force_9`. Between the points the force follows straight lines
whose corners are rounded over a quarter of the spacing. Let `D = f(k+1) - 2 f(k) + f(k-1)` be the change of
rise at a point, `f(k)` its force. It lifts the force by `D / 8` there and by about `D / 64` at each
neighbour. Beyond its ends the table has no information: the force levels out at the outermost value.
Positions are those of the bodies. They are zero at the start unless the file says otherwise. A base that
moves as the first body takes the opposite force.

## Where it comes from
It is not a cause, but what is left when none is known: bumps of a rail, a cable chain, a seal, a cam, a
magnet.

## How it shows
The missing force is a function of position alone, the same at every speed and in both directions. If it
repeats, it is `force-ripple` or `gravity`, whose laws hold beyond the records too. Over a short stroke it
contains `constant-load`. A table shows no detail finer than its spacing. For speed use `speed-table`, for
direction `friction-table`.

## How it is recognised
Plot the missing force against position: it is one curve. A diagnosis never names the table as a cause. If it
calls the cause unknown, it reads a table of each kind off the fitted experiments. It keeps the kind that best
predicts the check experiments, and fits that. It proposes the table if that closes more than a tenth of the
gap there and worsens no horizon. Choice and acceptance use the same experiments, which is slightly
optimistic.

## Numerical treatment
The force is an analytic function of the position, so an extrapolation method integrates the mode to machine
precision. Its steps resolve the corners. The energy balance counts the potential energy. Linear theory takes
the slope at the operating point: a stiffness of either sign.

## Source
L. Ljung, System Identification: Theory for the User, Prentice Hall (1999), chapter 5: nonlinear black-box
models.
",
    law: LawDrawing {
        axes: ["position", "force on the second body"],
        start: -1.0,
        with: &[Curve::Function(|x| {
            TabulatedForce::between(-0.8, 0.8, [0.0, 0.0, 0.15, 0.6, 0.75, 0.3, 0.0, -0.2, -0.2]).force(x)
        })],
        without: &[],
        labels: &[(-0.95, -0.25, "from"), (0.75, 0.12, "to"), (0.1, 0.8, "force_5")],
    },
    traits: &[],
    change: Change::plant::<ForceTable>(),
};

impl ChangesPlant for ForceTable {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let link = machine.link_mut(host, &DEFINITION)?;
        let (name, on, reacts_on) = (link.name.clone(), link.b, link.a);
        if let Some(table) = table(&self)? {
            let course = PositionForce::Table(table);
            machine.weights.push(Weight { name, on, reacts_on, is_of_earth: false, course });
        }
        Ok(())
    }
}

/// The table of an effect with the parameters `from`, `to` and a force at each point; `None` if all are zero.
///
/// # Errors
/// [`EffectError::Value`] if the last point does not lie above the first.
pub(super) fn table(effect: &impl Parameters) -> Result<Option<TabulatedForce>, EffectError> {
    let values = effect.values();
    if values[1] <= values[0] {
        return Err(EffectError::Value {
            parameter: "to",
            value: values[1],
            reason: "the last point does not lie above `from`",
            remedy: "raise it above `from`, or exchange both and reverse the order of the forces",
        });
    }
    let table = TabulatedForce::of(&values);
    Ok((!table.is_null()).then_some(table))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::fixture::{self, GUIDE};

    #[test]
    fn truth_the_second_body_is_pushed_by_the_table() {
        let mut machine = fixture::flexible();
        let values = [-1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0];
        DEFINITION.apply(&mut machine, GUIDE, &values).unwrap();
        let weight = &machine.weights[0];
        assert_eq!((weight.on, weight.reacts_on), (1, 0));
        assert!([-3.0, 0.1, 3.0].iter().all(|x| weight.course.force(*x).to_bits() == 2.0_f64.to_bits()));
    }

    #[test]
    fn prop_a_table_without_a_stretch_is_refused() {
        let mut machine = fixture::flexible();
        let values = [0.5, 0.5, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0];
        let error = DEFINITION.apply(&mut machine, GUIDE, &values).unwrap_err();
        assert!(matches!(error, EffectError::Value { parameter: "to", .. }));
        assert_eq!(machine, fixture::flexible());
    }
}
