//! `torque-speed-line`: the faster a drive moves, the less force is left.

use super::prelude::*;
use crate::assembly::SpeedLine;

parameters! { TorqueSpeedLine
    force: log(
        Dimension::FORCE, Some(f64::INFINITY), 100.0, (ABOVE_ZERO, f64::INFINITY), "largest force at rest"
    ),
    speed: log(Dimension::VELOCITY, None, 0.2, (ABOVE_ZERO, 1e6), "speed at which none is left"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: TorqueSpeedLine::KIND,
    name: "torque-speed-line",
    place: Place::Drive,
    order: 80,
    hosts: &[HostKind::Actuator],
    site: "a drive without a speed line of its own",
    parameters: TorqueSpeedLine::PARAMETERS,
    summary: "the largest force of a drive falls with its speed",
    example: "\
[actuators.drive.effects.torque-speed-line]
force = \"35 N\"
speed = \"30 mm/s\"
",
    sections: "\
## Model
The force of the drive is held between `-force (1 + v / speed)` and `force (1 - v / speed)`, `v` the speed of
its stroke, after any `force-limit`. This is the force that the supply voltage of a motor still allows at that
speed. Against the motion the voltage allows more than `force`, but most amplifiers limit the current there:
add a `force-limit`. Beyond `speed` the drive can only brake. `force` is the stall force on full voltage,
often far above the peak force of a data sheet. A motor on a voltage or a duty cycle has this line already, by
its resistance, and takes no second one. Nor does a velocity source, or a motor on a current with a supply
voltage.

## Where it comes from
The back-EMF of a motor on a bounded supply: servos of hobby size, batteries. The line is straight for a DC or
block-commutated motor that its resistance limits. An induction or synchronous servo that its inductance
limits is flat first, then falls in a steep curve. A battery's inner resistance lowers `force`, and a low
charge lowers both parameters.

## How it shows
Fast motions fall short, and the more the heavier the load, while slow ones are as before. `force-limit` caps
slow and fast motions alike. While the drive stays on its line, a `force-limit` of `force` with
`viscous-friction` of `force / speed` gives the same motion. Slow or small motions separate them, and so does
the current. Over a range of speeds `quadratic-drag` and `speed-table` may look alike. The limit of a target's
speed (`slew-limit` under a servo) does not depend on the load.

## How it is recognised
Plot the largest force against speed, with and against the motion: its edge is a straight line that falls.
Large steps of the target show it, small ones do not.

## Numerical treatment
Reaching and leaving the line are events, and on it the force is a row of the equations of motion. Linear
theory takes the line as not reached.

## Source
A. Hughes and B. Drury, Electric Motors and Drives, Newnes (2013): torque and speed of motors on a constant
voltage.
",
    law: LawDrawing {
        axes: ["speed", "bounds of the drive force"],
        start: -1.0,
        with: &[Curve::Points(&[(-1.0, 1.0), (1.0, 0.0)]), Curve::Points(&[(-1.0, 0.0), (1.0, -1.0)])],
        without: &[],
        labels: &[(0.05, 0.65, "force"), (0.7, -0.2, "speed")],
    },
    traits: &[Trait::Saturation],
    change: Change::plant::<TorqueSpeedLine>(),
};

impl ChangesPlant for TorqueSpeedLine {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { force, speed } = self;
        let drive = machine.force_drive_mut(host, &DEFINITION)?;
        if drive.line.is_some() || drive.velocity_source.is_some() {
            return Err(EffectError::WrongSite { kind: Self::KIND, needs: DEFINITION.site });
        }
        if force.is_finite() {
            drive.line = Some(SpeedLine { force, slope: force / speed });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::fixture;

    #[test]
    fn truth_nothing_is_left_at_the_speed_without_load() {
        let mut machine = fixture::rigid();
        DEFINITION.apply(&mut machine, Host::Actuator(0), &[12.0, 0.5]).unwrap();
        assert_eq!(machine.drives[0].line, Some(SpeedLine { force: 12.0, slope: 24.0 }));
        let again = DEFINITION.apply(&mut machine, Host::Actuator(0), &[12.0, 0.5]);
        assert!(matches!(again, Err(EffectError::WrongSite { .. })));
    }
}
