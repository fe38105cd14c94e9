//! `hard-stop`: an unexpected end of travel.

use super::prelude::*;
use crate::assembly::Link;
use crate::motion::StopSide;

parameters! { HardStop
    position: linear(
        Dimension::LENGTH, None, 1e-3, (-1e6, 1e6), "where the second body of the spring meets the stop"
    ),
    stiffness: log(Dimension::STIFFNESS, Some(0.0), 1e5, (0.0, 1e12), "stiffness of the stop"),
    damping: log(Dimension::DAMPING, Some(0.0), 100.0, (0.0, 1e9), "damping of the stop") or 0.0,
}

pub(super) static DEFINITION: Definition = Definition {
    kind: HardStop::KIND,
    name: "hard-stop",
    place: Place::Guide,
    order: 220,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: HardStop::PARAMETERS,
    summary: "an end of travel that the model lacks",
    example: "\
[springs.guide.effects.hard-stop]
position = \"4.05 mm\"
stiffness = \"200 kN/m\"
damping = \"200 N s/m\"
",
    sections: "\
## Model
Beyond `position`, of the second body of the spring against the first, a stop pushes back. Its force is
`stiffness` times the depth plus `damping` times its rate, and it never pulls. With `damping` its force begins
with a step. It is an upper stop if `position` is above the position at the start, else a lower one. The wall
of the example is at 4 mm. A stop well before it, as at the `typical` position, takes the drive's force, and
the tool touches late.

## Where it comes from
Rubber buffers, end caps, a cable that becomes taut, a chip in the guide, a bellows that is squeezed flat.

## How it shows
The axis stops short or bounces at one place, and the force that is missing begins there. On records that
barely reach the stop, `constant-load` and `gravity` may look alike. The forces of `hardening-stiffness` and
`force-table` have no corner. A wall that comes too early is a `surface-offset`, but the force sensor reads
it. `force-limit` stops an axis too, but at a force and at any place.

## How it is recognised
Plot the missing force against position: it is zero up to one place and rises beyond it, at every speed. The
force sensor reads none of it, while the drive's force rises.

## Numerical treatment
Touching and parting are events, and both modes are linear and exact. Linear theory takes the stop as never
reached.

## Source
G. Gilardi and I. Sharf, Literature survey of contact dynamics modelling, Mechanism and Machine Theory 37
(2002): the spring-dashpot model.
",
    law: LawDrawing {
        axes: ["travel", "force of the stop"],
        start: -1.0,
        with: &[Curve::Points(&[(-1.0, 0.0), (0.3, 0.0), (1.0, 0.9)])],
        without: &[],
        labels: &[(0.1, -0.11, "position"), (0.25, 0.65, "stiffness")],
    },
    traits: &[Trait::Dissipative],
    change: Change::plant::<HardStop>(),
};

impl ChangesPlant for HardStop {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { position, stiffness, damping } = self;
        let link = machine.link_mut(host, &DEFINITION)?;
        let (name, a, b) = (format!("{} stop", link.name), link.a, link.b);
        let start = machine.nodes[b].position_m - machine.nodes[a].position_m;
        let side = if start < position { StopSide::Upper } else { StopSide::Lower };
        if stiffness > 0.0 || damping > 0.0 {
            let stop = Some((side, position));
            machine.links.push(Link { stiffness, damping, stop, ..Link::between(name, a, b) });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::fixture::{self, GUIDE};

    #[test]
    fn truth_the_stop_stands_on_the_side_of_its_position() {
        for (position, side) in [(0.2, StopSide::Upper), (-0.2, StopSide::Lower)] {
            let mut machine = fixture::flexible();
            DEFINITION.apply(&mut machine, GUIDE, &[position, 1e4, 0.0]).unwrap();
            let stop = machine.links.last().unwrap();
            assert_eq!((stop.a, stop.b, stop.stop), (0, 1, Some((side, position))));
        }
    }
}
