//! How effects reach the element they sit under, and how they split bodies.

use super::{Assembly, ContactPart, Drive, Friction, GROUND_NODE, Link, Node, NodeId, SensorPart};
use crate::effects::{EffectError, Host};

impl Assembly {
    /// The node an effect sits under.
    ///
    /// # Errors
    /// [`EffectError::WrongHost`] where the host is no body.
    pub fn node_mut(&mut self, host: Host, kind: &'static str) -> Result<&mut Node, EffectError> {
        match host {
            Host::Body(i) => Ok(&mut self.nodes[i]),
            _ => Err(EffectError::WrongHost { kind, expected: "a body" }),
        }
    }

    /// The link an effect sits under.
    ///
    /// # Errors
    /// [`EffectError::WrongHost`] where the host is no spring.
    pub fn link_mut(&mut self, host: Host, kind: &'static str) -> Result<&mut Link, EffectError> {
        match host {
            Host::Spring(i) => Ok(&mut self.links[i]),
            _ => Err(EffectError::WrongHost { kind, expected: "a spring" }),
        }
    }

    /// The contact an effect sits under.
    ///
    /// # Errors
    /// [`EffectError::WrongHost`] where the host is no contact.
    pub fn contact_mut(&mut self, host: Host, kind: &'static str) -> Result<&mut ContactPart, EffectError> {
        match host {
            Host::Contact(i) => Ok(&mut self.contacts[i]),
            _ => Err(EffectError::WrongHost { kind, expected: "a contact" }),
        }
    }

    /// The drive an effect sits under.
    ///
    /// # Errors
    /// [`EffectError::WrongHost`] where the host is no actuator.
    pub fn drive_mut(&mut self, host: Host, kind: &'static str) -> Result<&mut Drive, EffectError> {
        match host {
            Host::Actuator(i) => Ok(&mut self.drives[i]),
            _ => Err(EffectError::WrongHost { kind, expected: "an actuator" }),
        }
    }

    /// The sensor an effect sits under.
    ///
    /// # Errors
    /// [`EffectError::WrongHost`] where the host is no sensor.
    pub fn sensor_mut(&mut self, host: Host, kind: &'static str) -> Result<&mut SensorPart, EffectError> {
        match host {
            Host::Sensor(i) => Ok(&mut self.sensors[i]),
            _ => Err(EffectError::WrongHost { kind, expected: "a sensor" }),
        }
    }

    /// Adds a body that stands where `at` stands, and gives its node.
    pub fn add_node(&mut self, name: String, mass_kg: f64, at: NodeId) -> NodeId {
        let position_m = self.nodes[at].position_m;
        let velocity_m_per_s = self.nodes[at].velocity_m_per_s;
        self.nodes.push(Node { name, mass_kg, position_m, velocity_m_per_s });
        self.nodes.len() - 1
    }

    /// Adds a spring and damper between two nodes and gives its index.
    pub fn add_link(&mut self, name: String, a: NodeId, b: NodeId, stiffness: f64, damping: f64) -> usize {
        self.links.push(Link { stiffness, damping, ..Link::between(name, a, b) });
        self.links.len() - 1
    }

    /// Sum of the masses that move as one with `node` through rigid links, itself included; infinite where it is fixed.
    pub fn rigid_mass_kg(&self, node: NodeId) -> f64 {
        let mut members = vec![node];
        let mut next = 0;
        while let Some(&at) = members.get(next) {
            next += 1;
            for link in self.links.iter().filter(|link| link.rigid) {
                for (from, to) in [(link.a, link.b), (link.b, link.a)] {
                    if from == at && !members.contains(&to) {
                        members.push(to);
                    }
                }
            }
        }
        members.iter().map(|&i| self.nodes[i].mass_kg).sum()
    }

    /// Whether a node is the fixed body.
    pub fn is_ground(node: NodeId) -> bool {
        node == GROUND_NODE
    }
}

impl Link {
    /// A link that does nothing yet.
    pub fn between(name: String, a: NodeId, b: NodeId) -> Self {
        Self { name, a, b, rigid: false, stiffness: 0.0, damping: 0.0, cubic: 0.0, play: 0.0, load: 0.0, friction: Friction::NONE }
    }
}
