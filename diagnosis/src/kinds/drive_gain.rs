//! `drive-gain`: a drive with more or less force than commanded.

use feeler_plant::effects::{DriveGain, Kind};

use super::start::{GAINS, off};
use super::{Balance, Element, Form, Glance, Known, Seen, spread};
use crate::tolerance::FRACTION;

impl Known for DriveGain {
    const MASS_INSTEAD: Option<Kind> = Some(Kind::AddedMass);
    const BALANCE: Option<Balance<Self>> = Some(Balance::shaped(
        Form::Gain,
        |_| spread(0.4, 2.5, 41),
        |_, gain| Self { gain },
        |own| (Vec::new(), own.gain),
    ));

    fn starts(_: &Element<'_>, _: &Glance) -> Vec<Self> {
        GAINS.map(|gain| Self { gain }).to_vec()
    }

    fn is_trivial(self, _: &Element<'_>, _: Seen) -> bool {
        off(self.gain, 1.0) <= FRACTION
    }
}
