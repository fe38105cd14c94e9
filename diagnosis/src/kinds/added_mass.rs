//! `added-mass`: payload or inertia beyond the believed one.

use feeler_plant::description::Body;
use feeler_plant::effects::{AddedMass, Host, Kind};

use super::{Balance, Element, Form, Glance, Known, Seen};
use crate::tolerance::FRACTION;

impl Known for AddedMass {
    const BALANCE: Option<Balance<Self>> = Some(Balance::shaped(
        Form::Mass,
        |_| vec![0.0],
        |of, _| Self { mass: of[0] },
        |own| (vec![own.mass], 0.0),
    ));
    const APART: &'static [(Kind, &'static str)] = &[(
        Kind::DriveGain,
        "weigh what moves, or read the drive's force with a spring scale against a stop",
    )];

    fn starts(element: &Element<'_>, _: &Glance) -> Vec<Self> {
        let Some(body) = element.body() else { return Vec::new() };
        [0.15, 0.5, 1.5].map(|share| Self { mass: share * body.mass_kg }).to_vec()
    }

    fn is_trivial(self, element: &Element<'_>, _: Seen) -> bool {
        let Host::Body(node) = element.host else { return false };
        let chain_kg = element.assembly().map_or(0.0, |assembly| assembly.rigid_mass_kg(node));
        self.mass <= element.tolerance(&Body::MASS.key, FRACTION) * chain_kg
    }
}
