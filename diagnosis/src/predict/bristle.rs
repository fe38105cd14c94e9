//! Bristles of sticking guides while corrections move their bodies.

use feeler_plant::motion::{Motion, dot};

use super::machine::Moving;
use super::state::State;

/// A bristle that carries dry friction of a constant level.
#[derive(Clone, Debug)]
pub(super) struct Bristle {
    link: usize,
    /// Position of the sliding surface in the state.
    surface: usize,
    /// Largest force before the surface slides, N.
    level: f64,
}

impl Bristle {
    /// The bristles of a machine, from the nodes of its sliding surfaces. Levels that depend on a load or a
    /// place have none.
    pub(super) fn all(motion: &Motion, surfaces: &[usize]) -> Vec<Self> {
        let links = &motion.assembly().links;
        let of = |&surface: &usize| {
            let is_on = |a: usize, b: usize| a == surface || b == surface;
            let link = links.iter().position(|link| link.bears.is_some() && is_on(link.a, link.b))?;
            let friction = links.iter().find(|l| l.bears.is_none() && is_on(l.a, l.b))?.friction;
            let level = friction.forward.max(friction.backward) + friction.stribeck_excess;
            let is_constant = friction.load_ratio <= 0.0 && friction.over.is_none();
            let surface = motion.layout().q(motion.coordinates().of(surface)?);
            is_constant.then_some(Self { link, surface, level })
        };
        surfaces.iter().filter_map(of).collect()
    }

    /// Moves the surface along with its body as far as the bristle would carry more than the level. Otherwise
    /// a correction of a body on a stiff bristle would be a blow.
    pub(super) fn slide(&self, machine: &Moving, state: &mut State) {
        let row = &machine.flows[state.flow].equations.link_spring_force[self.link];
        let force = dot(row, &state.xi);
        let beyond = force - force.clamp(-self.level, self.level);
        if beyond.abs() > 0.0 {
            state.xi[self.surface] -= beyond / row[self.surface];
        }
    }
}
