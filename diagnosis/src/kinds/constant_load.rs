//! `constant-load`: weight, cables, counterweights.

use feeler_plant::effects::ConstantLoad;

use super::{Balance, Element, Force, Glance, Known};

impl Known for ConstantLoad {
    /// It pushes along the axis, so a negative value resists.
    const BALANCE: Option<Balance<Self>> = Some(Balance::forces(
        &[Force::signed(|_| -1.0)],
        |of, _| Self { force: of[0] },
        |own| (vec![own.force], 0.0),
    ));

    /// Of a force that is far from every share of the command, the mean of what is missing tells.
    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        let sum: f64 = glance.missing.iter().map(|(_, force)| force).sum();
        let mean = sum / glance.missing.len().max(1) as f64;
        let shares = [-0.01, -0.1, -0.5, 0.01, 0.1, 0.5].map(|share| share * glance.command);
        let seen = Some(mean).filter(|mean| *mean != 0.0);
        seen.into_iter().chain(shares).map(|force| Self { force }).collect()
    }
}
