//! `actuator-lag`: first-order lag between command and drive force.

use super::prelude::*;

parameters! { ActuatorLag
    time_constant: log(Dimension::TIME, Some(0.0), 2e-3, (0.0, 10.0), "time to cover 63 % of a step"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ActuatorLag::KIND,
    name: "actuator-lag",
    place: Place::Drive,
    order: 10,
    hosts: &[HostKind::Actuator],
    site: "a drive that gives a force",
    parameters: ActuatorLag::PARAMETERS,
    summary: "first-order lag between command and drive force",
    example: "\
[actuators.drive.effects.actuator-lag]
time_constant = \"2 ms\"
",
    sections: "\
## Model
The drive force `f` follows the command `u`, after its gain and limits, by `time_constant df/dt + f = u`. A
lag that the drive already has acts in series with this one. Under a position servo the force of its loop
lags. On a velocity source, and on a motor with a voltage or a duty cycle, the command lags, and the law of
the drive acts on the lagged command.

## Where it comes from
Current loops of finite bandwidth, valves, a filter on the torque set point. A winding's inductance lags the
current, back-EMF included: on a motor with a voltage or a duty cycle, give its key `inductance` instead.

## How it shows
Above `1 / (2 pi time_constant)` Hz the drive force shrinks, and its phase falls by up to 90 degrees. In a
force loop that lag is what first bounds the gain of a rigid machine. Well below the corner it is a delay of
`time_constant`, so `command-delay` looks the same until the magnitude drops. `force-lag` costs a force loop
as much phase but leaves free motion as it was.

## How it is recognised
Excite the drive up to its corner: the measured response falls off and lags there, in free motion and in
contact alike. Below the corner only a delay shows.

## Numerical treatment
The lag is one more state of the linear equations, so it enters the matrix exponential exactly. Linear
theory has it as a pole.

## Source
S. D. Eppinger and W. P. Seering, Three dynamic problems in robot force control, IEEE Transactions on
Robotics and Automation 8 (1992): the rigid model with a first-order actuator.
",
    law: LawDrawing {
        axes: ["time", "drive force"],
        start: 0.0,
        with: &[Curve::LAGGED_STEP],
        without: &[Curve::STEP],
        labels: &[(0.34, 0.3, "time_constant")],
    },
    traits: &[Trait::DriveFlaw],
    change: Change::plant::<ActuatorLag>(),
};

impl ChangesPlant for ActuatorLag {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { time_constant } = self;
        let drive = machine.force_drive_mut(host, &DEFINITION)?;
        if time_constant > 0.0 {
            drive.lags.push(time_constant);
        }
        Ok(())
    }
}
