//! Bodies that move as one share a coordinate.

use feeler_catalogue::Tabled;

use crate::assembly::{Assembly, GROUND_NODE, NodeId};
use crate::description::{Actuator, Body};
use crate::problem::Problem;

/// The coordinate of each node.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinates {
    /// For each node its coordinate; `None` if it is fixed.
    of_node: Vec<Option<usize>>,
    /// The first node of each coordinate, whose position is the coordinate.
    leads: Vec<NodeId>,
    /// Mass of each coordinate, kg.
    masses: Vec<f64>,
    /// The drive that imposes the motion of each coordinate, if one does.
    imposed: Vec<Option<usize>>,
}

impl Coordinates {
    pub(super) fn new(assembly: &Assembly) -> Result<Self, Vec<Problem>> {
        let n = assembly.nodes.len();
        // The root of a node is the lowest node rigidly joined to it: ground comes first, and leads keep the
        // order of the file.
        let mut root: Vec<NodeId> = (0..n).collect();
        let mut changed = true;
        while changed {
            changed = false;
            for link in assembly.links.iter().filter(|link| link.rigid) {
                let lowest = root[link.a].min(root[link.b]);
                changed |= root[link.a] != lowest || root[link.b] != lowest;
                root[link.a] = lowest;
                root[link.b] = lowest;
            }
        }
        let mut problems = Vec::new();
        let mut of_node = vec![None; n];
        let mut leads = Vec::new();
        let mut masses: Vec<f64> = Vec::new();
        for node in 1..n {
            let lead = &assembly.nodes[root[node]];
            let this = &assembly.nodes[node];
            if this.velocity_m_per_s.to_bits() != lead.velocity_m_per_s.to_bits() {
                problems.push(Problem::new(
                    Body::VELOCITY.of(&this.name),
                    format!(
                        "`{}` and `{}` are rigidly joined but start at {} and {} m/s",
                        this.name, lead.name, this.velocity_m_per_s, lead.velocity_m_per_s
                    ),
                    "give both the same velocity",
                ));
            }
            if root[node] == GROUND_NODE {
                continue;
            }
            if root[node] == node {
                leads.push(node);
                masses.push(0.0);
            }
            let g = leads.iter().position(|&lead| lead == root[node]);
            of_node[node] = g;
            if let Some(g) = g {
                masses[g] += this.mass_kg;
            }
        }
        if leads.is_empty() {
            problems.push(Problem::new(
                Body::TABLE,
                "nothing in this machine can move",
                "add a body that is not rigidly joined to ground",
            ));
        }
        for (g, &mass) in masses.iter().enumerate() {
            if !(mass > 0.0 && mass.is_finite()) {
                let name = &assembly.nodes[leads[g]].name;
                problems.push(Problem::new(
                    Body::MASS.of(name),
                    format!("`{name}` has a mass of {mass} kg"),
                    "give it a mass above zero",
                ));
            }
        }
        let mut imposed = vec![None; leads.len()];
        for (i, drive) in assembly.drives.iter().enumerate().filter(|(_, drive)| drive.imposed.is_some()) {
            let body = &assembly.nodes[drive.on].name;
            let message = match of_node[drive.on].map(|g: usize| imposed[g].replace(i)) {
                Some(None) => continue,
                Some(Some(_)) => format!("the motion of `{body}` is imposed twice"),
                None => format!("`{body}` is fixed, so that no motion can be imposed on it"),
            };
            let key = Actuator::ON.of(&drive.name);
            problems.push(Problem::new(key, message, "name a body that moves by itself"));
        }
        if problems.is_empty() { Ok(Self { of_node, leads, masses, imposed }) } else { Err(problems) }
    }

    /// Number of coordinates.
    pub fn count(&self) -> usize {
        self.leads.len()
    }

    /// The coordinate of a node; `None` if it is fixed.
    pub fn of(&self, node: NodeId) -> Option<usize> {
        self.of_node[node]
    }

    /// The node whose position is the coordinate.
    pub fn lead(&self, coordinate: usize) -> NodeId {
        self.leads[coordinate]
    }

    /// The drive that imposes the motion of a coordinate.
    pub(crate) fn imposing(&self, coordinate: usize) -> Option<usize> {
        self.imposed[coordinate]
    }

    /// Whether the motion of a coordinate is imposed.
    pub fn is_imposed(&self, coordinate: usize) -> bool {
        self.imposed[coordinate].is_some()
    }

    /// Mass that moves with a coordinate.
    pub fn mass_kg(&self, coordinate: usize) -> f64 {
        self.masses[coordinate]
    }
}
