//! `gravity`: a load that varies with the angle of an arm.

use std::f64::consts::TAU;

use super::prelude::*;
use crate::assembly::{PositionForce, Pull, Weight};

parameters! { Gravity
    amplitude: log(Dimension::FORCE, Some(0.0), 5.0, (0.0, 1e6), "largest force (or torque) of gravity"),
    phase: linear(
        Dimension::NONE, None, 1.0, (-TAU, TAU),
        "angle of the arm from hanging straight down, at position zero, in rad"
    ),
    period: log(
        Dimension::LENGTH, None, 0.02, (ABOVE_ZERO, 1e6),
        "travel in which the arm turns once; state it on a translational axis"
    ) or TAU,
}

pub(super) static DEFINITION: Definition = Definition {
    kind: Gravity::KIND,
    name: "gravity",
    place: Place::Guide,
    order: 130,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: Gravity::PARAMETERS,
    summary: "a load that varies with the angle of an arm",
    example: "\
[springs.guide.effects.gravity]
amplitude = \"15 N\"
phase = 0.0
period = \"20 mm\"
",
    sections: "\
## Model
The force `-amplitude sin(2 pi x / period + phase)` acts on the second body of the spring, and its opposite on
the first. `x` is the position of the second against the first. A first body that moves, such as a base, takes
that opposite instead of feeling the weight. `period` is the travel in which the arm turns once. It is 2 pi by
default, which is one turn on a rotational axis. State it on a translational axis, and where a gear or a screw
lies between position and arm. For an arm of mass `m` whose centre lies `l` from its joint,
`amplitude = m g l 2 pi / period`: just `m g l` where `x` is the angle of the arm itself. This holds for a
horizontal joint axis; one inclined by `b` takes `cos(b)` times as much. `phase` is the angle of the arm from
hanging straight down, at position zero. The known gravity of a rotational body is stated by its keys
`gravity` and `gravity_phase`.

## Where it comes from
Arms, pendulums, unbalanced tables, a counterweight that is not quite right.

## How it shows
The command that holds the arm still varies with its angle as a sine. Over a short stroke it looks like a
`constant-load` and a spring. `force-ripple` repeats over many periods in a stroke.

## How it is recognised
Hold the axis at several positions over a quarter turn or more, and read the command: it is a sine of the
position. Over a short stroke, a load and a spring look the same.

## Numerical treatment
The force is a sine of the position, so an extrapolation method integrates the mode to machine precision. The
energy balance counts the potential energy. Linear theory takes the slope at the operating point. It is a
stiffness `amplitude 2 pi / period cos(2 pi x / period + phase)`, negative while the centre is above the
joint.

## Source
B. Siciliano, L. Sciavicco, L. Villani and G. Oriolo, Robotics: Modelling, Planning and Control, Springer
(2009): gravity in the equations of motion.
",
    law: LawDrawing {
        axes: ["position", "torque of gravity"],
        start: -1.0,
        with: &[Curve::Function(|x| -0.7 * (TAU * x / 2.0).sin()), Curve::Dimension([-1.0, 1.0], -0.9)],
        without: &[],
        labels: &[(-0.75, 0.82, "amplitude"), (-0.85, -0.8, "period")],
    },
    traits: &[Trait::PlainNumber],
    change: Change::plant::<Gravity>(),
};

impl ChangesPlant for Gravity {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { amplitude, phase, period } = self;
        let link = machine.link_mut(host, &DEFINITION)?;
        let (name, on, reacts_on) = (link.name.clone(), link.b, link.a);
        if amplitude > 0.0 {
            let course = PositionForce::Pull(Pull { amplitude, period, phase });
            machine.weights.push(Weight { name, on, reacts_on, is_of_earth: false, course });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::fixture::{self, GUIDE};

    #[test]
    fn truth_the_force_is_minus_the_slope_of_the_potential() {
        let mut machine = fixture::flexible();
        DEFINITION.apply(&mut machine, GUIDE, &[3.0, 0.4, 2.0]).unwrap();
        let weight = &machine.weights[0];
        assert_eq!((weight.on, weight.reacts_on), (1, 0));
        for x in [-1.3, 0.0, 0.7] {
            let h = 1e-5;
            let slope = (weight.course.potential(x + h) - weight.course.potential(x - h)) / (2.0 * h);
            // A central difference is off by a sixth of the square of its step times the third derivative,
            // 30 N/m^2.
            assert!((weight.course.force(x) + slope).abs() < 1e-8, "{x}");
        }
    }
}
