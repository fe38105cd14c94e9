//! `actuator-lag`: a lag of the drive.

use feeler_plant::effects::{ActuatorLag, Kind};

use super::start::times;
use super::{Balance, Element, Form, Glance, Known, Seen, spread};

impl Known for ActuatorLag {
    const BALANCE: Option<Balance<Self>> = Some(Balance::shaped(
        Form::Lag,
        |extent| spread(0.03 * extent.resolved_s, 3.0 * extent.resolved_s, 30),
        |_, time_constant| Self { time_constant },
        |own| (Vec::new(), own.time_constant),
    ));
    const APART: &'static [(Kind, &'static str)] = &[(
        Kind::CommandDelay,
        "excite the drive at higher frequencies: a lag reduces the amplitude there, a delay does not",
    )];

    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        times(glance).map(|time_constant| Self { time_constant }).to_vec()
    }

    fn is_trivial(self, _: &Element<'_>, seen: Seen) -> bool {
        seen.is_in_time(self.time_constant)
    }
}
