//! `directional-damping`: viscous friction that depends on the direction.

use super::prelude::*;

parameters! { DirectionalDamping
    damping: log(Dimension::DAMPING, Some(0.0), 20.0, (0.0, 1e7), "damping added to the guide's"),
    asymmetry: linear(
        Dimension::NONE, Some(0.0), 0.3, (-1.0, 1.0), "share of all damping added forward and taken off \
                                                       backward"
    ),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: DirectionalDamping::KIND,
    name: "directional-damping",
    place: Place::Guide,
    order: 170,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: DirectionalDamping::PARAMETERS,
    summary: "viscous friction that differs by direction",
    example: "\
[springs.guide.effects.directional-damping]
damping = \"100 N s/m\"
asymmetry = 0.8
",
    sections: "\
## Model
The guide's own damping grows by `damping` to `c`. Sliding at speed `v` the guide resists with
`c (1 + asymmetry) v` forward and `c (1 - asymmetry) v` backward. Forward means that the second body of the
spring moves in the positive direction relative to the first. The force is continuous at rest, and its slope
is not.

## Where it comes from
Seals and wipers with a lip, check valves, dampers with a bypass.

## How it shows
One direction takes more force than the other, and the difference grows with speed. `asymmetric-friction`
differs by the same force at every speed, and a `constant-load` differs at rest as well. With equal damping
both ways it is `viscous-friction`.

## How it is recognised
Plot the missing force against velocity: it is two straight lines with a corner at zero. Move at several
speeds in both directions.

## Numerical treatment
Forward and backward are modes, each linear and exact. The change between them is an event, once the speed
has passed zero by 1e-12 m/s. In between the mean `c` acts, and so it does in linear theory.

## Source
J. C. Dixon, The Shock Absorber Handbook, Wiley (2007): bump and rebound damping.
",
    law: LawDrawing {
        axes: ["sliding speed", "resistance of the guide"],
        start: -1.0,
        with: &[Curve::Points(&[(-1.0, -0.4), (0.0, 0.0), (1.0, 0.9)])],
        without: &[Curve::GUIDE],
        labels: &[(0.02, 0.85, "c (1 + asymmetry) v"), (-0.95, -0.6, "c (1 - asymmetry) v")],
    },
    traits: &[Trait::Dissipative],
    change: Change::plant::<DirectionalDamping>(),
};

impl ChangesPlant for DirectionalDamping {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { damping, asymmetry } = self;
        let link = machine.link_mut(host, &DEFINITION)?;
        link.damping += damping;
        link.asymmetry = asymmetry;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::fixture::{self, GUIDE};
    use crate::motion::{Mode, Motion};

    #[test]
    fn truth_damping_grows_and_each_direction_has_its_share() {
        let mut machine = fixture::flexible();
        DEFINITION.apply(&mut machine, GUIDE, &[20.0, 0.25]).unwrap();
        let motion = Motion::new(machine).unwrap();
        let mut xi = motion.initial_state();
        xi.resize(motion.layout().width(), 0.0);
        for (speed, damping) in [(0.1, 100.0), (-0.1, 60.0)] {
            xi[motion.layout().v(0)] = speed;
            let mut modes = Vec::new();
            let mode = motion.begin(&mut Modes(&mut modes), Mode::default(), &mut xi).unwrap().index;
            let row = &modes[mode].derivative[motion.layout().v(0)];
            // The motor weighs 7 kg, and the transmission damps it by 120 N s/m.
            let expected = -(damping + 120.0) / 7.0;
            assert!((row[motion.layout().v(0)] - expected).abs() < 1e-12, "{speed}");
        }
    }

    struct Modes<'a>(&'a mut Vec<crate::motion::Equations>);

    impl crate::motion::modes::ModeTable for Modes<'_> {
        type Error = std::convert::Infallible;

        fn index_of(&mut self, motion: &Motion, mode: Mode) -> Result<usize, Self::Error> {
            self.0.push(motion.equations(mode));
            Ok(self.0.len() - 1)
        }

        fn equations(&self, index: usize) -> &crate::motion::Equations {
            &self.0[index]
        }
    }
}
