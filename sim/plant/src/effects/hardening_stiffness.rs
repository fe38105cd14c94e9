//! `hardening-stiffness`: the force grows faster than the deflection.

use super::prelude::*;

parameters! { HardeningStiffness
    cubic: log(Dimension::CUBIC_STIFFNESS, Some(0.0), 5e12, (0.0, 1e20), "force per cube of deflection"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: HardeningStiffness::KIND,
    name: "hardening-stiffness",
    place: Place::Transmission,
    order: 260,
    hosts: &[HostKind::Spring, HostKind::Contact],
    site: "",
    parameters: HardeningStiffness::PARAMETERS,
    summary: "the force grows faster than the deflection",
    example: "\
[contacts.tool.effects.hardening-stiffness]
cubic = \"1e13 N/m^3\"
",
    sections: "\
## Model
The elastic force of the spring or contact is `k d + cubic d^3`, `d` its elongation or compression (beyond
its free play, where it has some).

## Where it comes from
Harmonic drives, rolling elements, rubber, fixtures that seat themselves under load.

## How it shows
Modes rise with amplitude and with preload, and the peak of a resonance leans towards high frequency. At one
amplitude and preload a harder spring looks the same: `contact-stiffness` for a contact,
`transmission-flexibility` for a transmission. `hertz-contact` hardens too: most of all at small force,
where this effect is nearly linear.

## How it is recognised
Repeat a sweep at two amplitudes or preloads: the mode rises with both. One level alone looks like another
stiffness.

## Numerical treatment
The cubic force has no exponential, so an extrapolation method integrates the modes in which it acts to
machine precision. Linear theory takes the slope at the operating force.

## Source
A. H. Nayfeh and D. T. Mook, Nonlinear Oscillations, Wiley (1979): the Duffing oscillator. For harmonic
drives, T. D. Tuttle and W. P. Seering, A nonlinear model of a harmonic drive gear transmission, IEEE
Transactions on Robotics and Automation 12 (1996).
",
    law: LawDrawing {
        axes: ["elongation", "elastic force"],
        start: -1.0,
        with: &[Curve::Function(|d| 0.4 * d + 0.5 * d.powi(3))],
        without: &[Curve::Points(&[(-1.0, -0.4), (1.0, 0.4)])],
        labels: &[(0.3, 0.6, "cubic")],
    },
    traits: &[Trait::Compliance],
    change: Change::plant::<HardeningStiffness>(),
};

impl ChangesPlant for HardeningStiffness {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { cubic } = self;
        if let Host::Contact(_) = host {
            machine.contact_mut(host, &DEFINITION)?.law.cubic += cubic;
        } else {
            machine.link_mut(host, &DEFINITION)?.cubic += cubic;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::fixture::{self, TRANSMISSION};

    #[test]
    fn prop_a_rigid_spring_has_no_stiffness_to_grow() {
        let mut machine = fixture::rigid();
        assert!(matches!(
            DEFINITION.apply(&mut machine, TRANSMISSION, &[1e12]),
            Err(EffectError::WrongHost { .. })
        ));
    }

    #[test]
    fn truth_spring_and_contact_take_it() {
        let mut machine = fixture::flexible();
        DEFINITION.apply(&mut machine, TRANSMISSION, &[1e12]).unwrap();
        DEFINITION.apply(&mut machine, Host::Contact(0), &[2e12]).unwrap();
        let mut expected = fixture::flexible();
        expected.links[1].cubic = 1e12;
        expected.contacts[0].law.cubic = 2e12;
        assert_eq!(machine, expected);
    }
}
