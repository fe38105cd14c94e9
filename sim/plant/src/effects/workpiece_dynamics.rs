//! `workpiece-dynamics`: the workpiece yields.

use super::prelude::*;
use crate::assembly::NodeId;

parameters! { WorkpieceDynamics
    mass: log(Dimension::MASS, None, 3.0, (ABOVE_ZERO, 1e6), "mass of the workpiece"),
    stiffness: log(Dimension::STIFFNESS, None, 1.5e6, (ABOVE_ZERO, 1e12), "stiffness of its fixture"),
    damping: log(Dimension::DAMPING, None, 150.0, (0.0, 1e9), "damping of its fixture"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: WorkpieceDynamics::KIND,
    name: "workpiece-dynamics",
    place: Place::Workpiece,
    order: 280,
    hosts: &[HostKind::RigidSpring, HostKind::Contact],
    site: "a rigid spring must be a fixture: its workpiece is the end that a contact names second, or else \
           its second end; ground is not a workpiece",
    parameters: WorkpieceDynamics::PARAMETERS,
    summary: "the workpiece yields",
    example: "\
[contacts.tool.effects.workpiece-dynamics]
mass = \"3 kg\"
stiffness = \"500 kN/m\"
damping = \"150 N s/m\"
",
    sections: "\
## Model
`mass x_w'' = F - stiffness e - damping de/dt`. `F` is the contact force on the workpiece. `e` is how far the
fixture has yielded in its direction. Under a rigid fixture (a spring), the workpiece is the end that a
contact names second. If none does, it is the second end, or the first where the second is ground. The mass of
that body becomes `mass`, and the fixture yields. Under a contact, a workpiece is put between the contact and
what it touched.

## Where it comes from
Thin sheets, long parts, clamps, jigs, a hand that holds the part.

## How it shows
In contact a zero pair at `sqrt(stiffness / mass)` rad/s accompanies a pole pair. Between the two the phase
swings by up to 180 degrees and then returns. It swings up if the zeros lie above the contact mode, which adds
phase. It swings down if they lie below. Then the peak of the poles comes first, and the phase falls there.
With an integral part, a lag or a delay it may pass -180 degrees, and the loop become unstable. Damping, or a
low gain, that keeps this peak below one prevents it. Free motion is as predicted, which separates it from
`base-flexibility`. Far below the mode only the series stiffness counts, so `contact-stiffness` looks the same
there.

## How it is recognised
A phase swing, up or down and back, appears in contact and vanishes in free motion. The response must reach
the frequency of the workpiece; below it, only a softer contact shows.

## Numerical treatment
The workpiece is one more body; everything stays linear and exact. Linear theory has a pair of poles beside
a pair of zeros.

## Source
S. D. Eppinger and W. P. Seering, Three dynamic problems in robot force control, IEEE Transactions on
Robotics and Automation 8 (1992): workpiece dynamics.
",
    law: LawDrawing {
        axes: ["time after a step of the contact force", "workpiece position"],
        start: 0.0,
        with: &[Curve::Function(|t| 0.5 * (1.0 - (-4.0 * t).exp() * (35.0 * t).cos()))],
        without: &[Curve::Points(&[(0.0, 0.0), (1.0, 0.0)])],
        labels: &[(0.3, 0.1, "mass, stiffness, damping")],
    },
    traits: &[Trait::Compliance],
    change: Change::plant::<WorkpieceDynamics>(),
};

impl ChangesPlant for WorkpieceDynamics {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { mass, stiffness, damping } = self;
        match host {
            Host::Spring(spring) => {
                let workpiece =
                    workpiece_end(machine, spring).ok_or_else(|| machine.wrong_host(host, &DEFINITION))?;
                machine.nodes[workpiece].mass_kg = mass;
                machine.links[spring].set_flexible(stiffness, damping);
                Ok(())
            }
            Host::Contact(contact) => {
                let touched = machine.contacts[contact].b;
                let name = format!("{}-workpiece", machine.contacts[contact].name);
                let workpiece = machine.add_node(name.clone(), mass, touched);
                machine.contacts[contact].b = workpiece;
                machine.add_link(name, touched, workpiece, stiffness, damping);
                Ok(())
            }
            _ => Err(machine.wrong_host(host, &DEFINITION)),
        }
    }
}

/// The end of a fixture that is the workpiece: the one that a contact touches, else the second, but never
/// ground.
fn workpiece_end(machine: &Assembly, spring: usize) -> Option<NodeId> {
    let link = &machine.links[spring];
    let bodies = || [link.b, link.a].into_iter().filter(|&end| !Assembly::is_ground(end));
    let touched = |end: &NodeId| machine.contacts.iter().any(|contact| contact.b == *end);
    bodies().find(touched).or_else(|| bodies().next())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::{GROUND_NODE, Link};
    use crate::effects::fixture::{self, TOOL};

    const PARAMETERS: [f64; 3] = [3.0, 1.5e6, 150.0];

    #[test]
    fn truth_a_workpiece_comes_between_contact_and_ground() {
        let mut machine = fixture::flexible();
        DEFINITION.apply(&mut machine, TOOL, &PARAMETERS).unwrap();
        let mut expected = fixture::flexible();
        let workpiece = expected.add_node("tool-workpiece".into(), 3.0, GROUND_NODE);
        expected.contacts[0].b = workpiece;
        expected.add_link("tool-workpiece".into(), GROUND_NODE, workpiece, 1.5e6, 150.0);
        assert_eq!(machine, expected);
    }

    #[test]
    fn truth_the_touched_end_of_a_fixture_is_the_workpiece() {
        // Whatever the order of the fixture's ends, and whether or not the other end is ground.
        for (other, turned) in [(GROUND_NODE, false), (GROUND_NODE, true), (1, false), (1, true)] {
            let mut ideal = fixture::flexible();
            let workpiece = ideal.add_node("workpiece".into(), 1.0, GROUND_NODE);
            ideal.contacts[0].b = workpiece;
            let (a, b) = if turned { (workpiece, other) } else { (other, workpiece) };
            ideal.links.push(Link { rigid: true, ..Link::between("fixture".into(), a, b) });
            let mut machine = ideal.clone();
            DEFINITION.apply(&mut machine, Host::Spring(2), &PARAMETERS).unwrap();
            ideal.nodes[workpiece].mass_kg = 3.0;
            ideal.links[2].set_flexible(1.5e6, 150.0);
            assert_eq!(machine, ideal);
        }
    }

    #[test]
    fn truth_of_a_fixture_that_nothing_touches_the_second_end_is_the_workpiece() {
        for (a, b, expected) in [(GROUND_NODE, 3, 3), (3, GROUND_NODE, 3), (1, 3, 3), (3, 1, 1)] {
            let mut machine = fixture::flexible();
            machine.add_node("workpiece".into(), 1.0, GROUND_NODE);
            machine.links.push(Link { rigid: true, ..Link::between("fixture".into(), a, b) });
            DEFINITION.apply(&mut machine, Host::Spring(2), &PARAMETERS).unwrap();
            assert!((machine.nodes[expected].mass_kg - 3.0).abs() < f64::EPSILON, "{a} {b}");
        }
    }
}
