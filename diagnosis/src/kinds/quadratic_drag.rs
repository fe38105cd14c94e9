//! `quadratic-drag`: a resistance that grows with the square of the speed.

use feeler_plant::effects::{Kind, QuadraticDrag};

use super::{Balance, Element, Force, Glance, Known};

impl Known for QuadraticDrag {
    const BALANCE: Option<Balance<Self>> = Some(Balance::forces(
        &[Force::positive(|at| at.speed * at.speed.abs())],
        |of, _| Self { drag: of[0] },
        |own| (vec![own.drag], 0.0),
    ));
    const APART: &'static [(Kind, &'static str)] = &[(
        Kind::ViscousFriction,
        "move at steady speeds, the fastest three times the slowest: drag grows nine times, viscous friction \
         three times",
    )];

    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        let whole = glance.command / glance.speed.max(1e-9).powi(2);
        [0.03, 0.1, 0.3, 0.8].map(|share| Self { drag: share * whole }).to_vec()
    }
}
