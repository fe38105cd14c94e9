//! `loop-gain`: a drive makes more or less force of the same motion and command.

use super::prelude::*;

parameters! { LoopGain
    gain: log(Dimension::NONE, Some(1.0), 0.8, (ABOVE_ZERO, 1e6), "force of the drive over the believed one"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: LoopGain::KIND,
    name: "loop-gain",
    place: Place::Drive,
    order: 50,
    hosts: &[HostKind::Actuator],
    site: "a drive that gives a force",
    parameters: LoopGain::PARAMETERS,
    summary: "all force of a drive is scaled, and so are the gains of a servo",
    example: "\
[actuators.drive.effects.loop-gain]
gain = 0.7
",
    sections: "\
## Model
The drive gives `gain` times the force that it would give for the same command at the same motion, before its
limits. For a position servo, `gain` scales `kp`, `ki` and `kd`. For a velocity source or a motor it scales
the parts of the force that follow from command and speed. For a drive whose command is its force, as in the
example, it is the same as `drive-gain`. Under a servo `drive-gain` scales the target instead. To see the
difference, write a servo by `feeler new servo --out servo.toml`, then run
`feeler run servo.toml --set actuators.servo.effects.loop-gain.gain=0.7`.

## Where it comes from
Gains that were converted wrongly from units of the firmware, or changed in the servo's memory. On a motor at
full duty, a supply with an inner resistance. (A lower supply voltage is a `drive-gain` on a duty cycle.) On a
drive that is commanded by current, a torque constant that differs from the data sheet. Where that current is
limited, lower the limit of force too (`force-limit`). On a voltage or duty cycle, a torque constant of `g`
times the believed one is this effect with `gain = g^2`, and a `drive-gain` of `1 / g`. The current signal is
then `g` times the true one, and supply and current limit clip at another command.

## How it shows
Under a load, a servo without an integral part sags `1 / gain` times as far. Its undamped frequency is
`sqrt(gain)` times as high. Its damping ratio is `sqrt(gain)` times as large if `kd` gives nearly all damping.
At constant speed, without `ki`, it lags by `kd / kp` times the speed, which stays: `kd` acts on the measured
speed. It lags by the friction over `gain kp` too. Friction, loads and inertia keep their sizes. Without a
load, inertia (`added-mass`) and friction that are both `1 / gain` times the believed ones look the same.
`viscous-friction` alone changes the lag, and not how a load is held.

## How it is recognised
Hold a known load: without `ki` the error is the load over `gain kp`. Dry friction shifts it: approach slowly
from above and from below, and take the mean. With `ki` the error vanishes, and its integral over time is the
load over `gain ki`. Without a known load, only the ratios of the gain to inertia and friction show.

## Numerical treatment
The entries of the servo in the equations of motion are multiplied, which is exact. Linear theory scales the
gains of the servo.

## Source
K. J. Åström and T. Hägglund, Advanced PID Control, ISA (2006): load disturbances and the integrated error.
",
    law: LawDrawing {
        axes: ["error of the servo", "drive force"],
        start: -1.0,
        with: &[Curve::Points(&[(-0.9, -0.54), (0.9, 0.54)])],
        without: &[Curve::UNCHANGED],
        labels: &[(0.5, 0.12, "gain")],
    },
    traits: &[Trait::PlainNumber, Trait::Gain],
    change: Change::plant::<LoopGain>(),
};

impl ChangesPlant for LoopGain {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { gain } = self;
        let drive = machine.force_drive_mut(host, &DEFINITION)?;
        if let Some(servo) = &mut drive.servo {
            servo.kp *= gain;
            servo.ki *= gain;
            servo.kd *= gain;
        } else if let Some(source) = &mut drive.velocity_source {
            source.gain *= gain;
            source.damping *= gain;
        } else {
            drive.gain *= gain;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::Servo;
    use crate::effects::fixture;

    #[test]
    fn truth_every_gain_of_a_servo_is_scaled_and_nothing_else() {
        let mut machine = fixture::rigid();
        let servo = |gain| Servo { kp: 20.0 * gain, ki: 4.0 * gain, kd: 2.0 * gain, sampling: None };
        machine.drives[0].servo = Some(servo(1.0));
        let mut expected = machine.clone();
        DEFINITION.apply(&mut machine, Host::Actuator(0), &[0.25]).unwrap();
        expected.drives[0].servo = Some(servo(0.25));
        assert_eq!(machine, expected);
    }
}
