//! Presliding of dry friction: before a guide slides, it yields like a spring by micrometres.

use super::{Assembly, Friction, Link, Node, NodeId};

/// How a guide with dry friction yields before it slides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Presliding {
    /// Stiffness of the guide at rest, N/m.
    pub stiffness: f64,
    /// Damping ratio of the sliding mass on that stiffness.
    pub damping_ratio: f64,
}

/// Parallel bristles (Maxwell slip): the share of the stiffness and of the level that each has. A single
/// bristle yields linearly up to the whole level. Real friction yields ever more easily: its force approaches
/// the level exponentially (Dahl 1968). Two bristles stay within 5 % of that curve.
const BRISTLES: [[f64; 2]; 2] = [[0.749, 0.472], [0.251, 0.528]];

/// Share of a body's mass that is assigned to its sliding surfaces: small against the body, but large enough
/// that the surfaces need no finer steps.
const SURFACE_SHARE: f64 = 0.02;

impl Presliding {
    /// Damping of the yielding guide under a mass, N s/m.
    pub fn damping(self, mass_kg: f64) -> f64 {
        2.0 * self.damping_ratio * (self.stiffness * mass_kg).sqrt()
    }
}

impl Assembly {
    /// The lighter of the two masses that a link connects, with all that moves as one with it.
    pub fn sliding_mass_kg(&self, link: &Link) -> f64 {
        self.rigid_mass_kg(link.a).min(self.rigid_mass_kg(link.b))
    }

    /// Guides with dry friction, each with its number.
    pub fn dry_guides(&self) -> impl Iterator<Item = (usize, &Link)> {
        self.links.iter().enumerate().filter(|(_, link)| !link.rigid && link.friction.acts())
    }

    /// Gives every guide with dry friction and a stated presliding its sliding surfaces, and returns these.
    ///
    /// A surface connects to its body by a bristle, a damped spring, and carries a share of the friction.
    /// While the guide sticks, the body moves on the bristles; while it slides, the level acts as before.
    pub fn soften(&mut self) -> Vec<NodeId> {
        let stated = |(i, link): (usize, &Link)| Some((i, link.presliding?));
        let stated: Vec<_> = self.dry_guides().filter_map(stated).collect();
        let mut surfaces = Vec::new();
        for (i, presliding) in stated {
            let Link { a, b, .. } = self.links[i];
            let on_b = self.rigid_mass_kg(b) <= self.rigid_mass_kg(a);
            let (body, other) = if on_b { (b, a) } else { (a, b) };
            let mass_kg = SURFACE_SHARE * self.nodes[body].mass_kg;
            if !(mass_kg.is_finite() && mass_kg > 0.0) {
                continue;
            }
            let damping = presliding.damping(self.rigid_mass_kg(body));
            let under = self.nodes[body].clone();
            self.nodes[body].mass_kg -= mass_kg;
            let friction = std::mem::replace(&mut self.links[i].friction, Friction::NONE);
            for [stiff, level] in BRISTLES {
                let surface = self.nodes.len();
                let name = format!("{} surface", under.name);
                self.nodes.push(Node { name, mass_kg: stiff * mass_kg, ..under.clone() });
                let between = |from: NodeId, to: NodeId| {
                    let (a, b) = if on_b { (from, to) } else { (to, from) };
                    Link::between(self.links[i].name.clone(), a, b)
                };
                let added = [
                    Link { friction: friction.scaled(level), ..between(other, surface) },
                    Link {
                        stiffness: stiff * presliding.stiffness,
                        damping: stiff * damping,
                        bears: Some(i),
                        ..between(surface, body)
                    },
                ];
                self.links.extend(added);
                surfaces.push(surface);
            }
        }
        surfaces
    }
}
