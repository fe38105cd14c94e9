//! `presliding`: a guide with dry friction yields before it slides.

use super::prelude::*;
use crate::assembly;

parameters! { Presliding
    stiffness: log(Dimension::STIFFNESS, None, 1e6, (ABOVE_ZERO, 1e12), "stiffness of the guide at rest"),
    damping_ratio: log(
        Dimension::NONE, None, 0.5, (1e-3, 10.0), "damping ratio of the sliding mass on it"
    ) or 0.5,
}

pub(super) static DEFINITION: Definition = Definition {
    kind: Presliding::KIND,
    name: "presliding",
    place: Place::Guide,
    order: 215,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: Presliding::PARAMETERS,
    summary: "dry friction that yields before it slides",
    example: "\
[springs.guide.effects.coulomb-friction]
level = \"6 N\"

[springs.guide.effects.presliding]
stiffness = \"500 kN/m\"
",
    sections: "\
## Model
Two bristles in parallel carry the dry friction of the guide, whatever its law: one 74.9 % of `stiffness` and
47.2 % of the level, the other the rest. Each is a spring and a damper between the body and a surface that
sticks or slides under its share of the level. The surfaces together weigh 2 % of the body. From rest to full
sliding the force is `level (1 - exp(-x / s))`, Dahl's law, within 5 % of the level. There `s` is
`0.7 level / stiffness`, 8.4 um in the example. Sliding steadily the guide resists as without this effect.
`damping_ratio` is that of all that slides together, on `stiffness`. Without dry friction the effect does
nothing.

## Where it comes from
Every dry friction: asperities, seals and lubricated rollers bend by micrometres before they slide.

## How it shows
Around a reversal the force changes as that of a spring and not as a step. A machine that sticks oscillates at
`sqrt(stiffness / mass)`. `lugre-friction` looks alike; it also falls with speed, and creeps under vibration.
A diagnosis fits both numbers beside every dry friction and writes them into the
repaired machine, where records show them.

## How it is recognised
Move the axis by micrometres about one point, with an encoder that resolves a tenth of `level / stiffness`.
Force against position is then a loop with elastic flanks.

## Numerical treatment
The machine gets two small bodies with two springs, linear and exact, whose sliding and sticking are modes.
Linear theory of the sliding machine leaves it out; in that of the stuck one it is a spring and a damper.

## Source
P. R. Dahl, A solid friction model, The Aerospace Corporation, TOR-0158(3107-18)-1 (1968). Of parallel
bristles, W. D. Iwan, A distributed-element model for hysteresis and its steady-state dynamic response,
Journal of Applied Mechanics 33 (1966).
",
    law: LawDrawing {
        axes: ["position, slowly back and forth", "resistance of the guide"],
        start: -1.0,
        with: &[
            Curve::Function(|x| 0.7 - 1.4 * (-(x + 1.0) / 0.15).exp()),
            Curve::Function(|x| -0.7 + 1.4 * ((x - 1.0) / 0.15).exp()),
        ],
        without: &[],
        labels: &[(0.2, 0.85, "level: forward"), (-0.95, -0.9, "backward"), (-0.75, -0.15, "stiffness")],
    },
    traits: &[Trait::Dissipative],
    change: Change::plant::<Presliding>(),
};

impl ChangesPlant for Presliding {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { stiffness, damping_ratio } = self;
        machine.link_mut(host, &DEFINITION)?.presliding =
            Some(assembly::Presliding { stiffness, damping_ratio });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::{Link, Node};
    use crate::effects::Kind;
    use crate::effects::fixture::{self, GUIDE};

    /// While it yields, a guide follows Dahl's curve: the force is `1 - exp(-x)` of the level. Here `x` is
    /// the deflection over the length at which the initial stiffness alone would reach the level.
    #[test]
    fn truth_a_guide_yields_as_dahls_law_does() {
        let mut assembly = fixture::flexible();
        let (masses, links) = (assembly.nodes.clone(), assembly.links.len());
        Kind::CoulombFriction.definition().apply(&mut assembly, GUIDE, &[6.0]).unwrap();
        DEFINITION.apply(&mut assembly, GUIDE, &[5e5, 0.5]).unwrap();
        let surfaces = assembly.soften();
        let of = |surface: usize, what: fn(&Link) -> f64| {
            let own = assembly.links.iter().filter(|link| [link.a, link.b].contains(&surface));
            own.map(what).sum::<f64>()
        };
        let bristles: Vec<[f64; 2]> = (surfaces.iter())
            .map(|&surface| [of(surface, |link| link.stiffness), of(surface, |link| link.friction.forward)])
            .collect();
        let [stiffness, level] = [0, 1].map(|i| bristles.iter().map(|bristle| bristle[i]).sum::<f64>());
        assert!((stiffness / 5e5 - 1.0).abs() < 1e-12 && (level / 6.0 - 1.0).abs() < 1e-12);
        // Both bristles together begin with 0.7 of the stiffness that the law has at first.
        let length = 0.7 * level / stiffness;
        for i in 0..100 {
            let x = 0.05 * f64::from(i);
            let force: f64 = bristles.iter().map(|[k, most]| (k * length * x).min(*most)).sum();
            assert!((force / level - (1.0 - (-x).exp())).abs() < 0.051, "{x}: {force}");
        }
        // The mass stays, and a second call finds nothing to soften.
        let mass = |nodes: &[Node]| nodes[1..].iter().map(|node| node.mass_kg).sum::<f64>();
        assert!((mass(&assembly.nodes) / mass(&masses) - 1.0).abs() < 1e-12);
        assert!(assembly.soften().is_empty() && assembly.links.len() == links + 4);
    }
}
