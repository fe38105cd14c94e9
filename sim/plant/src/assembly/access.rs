//! Access of effects to their elements, and how they split bodies and add new ones.

use super::{
    Assembly, ContactPart, Drive, Friction, GROUND_NODE, Link, Node, NodeId, PositionForce, SensorPart,
    ServoFeed, Source, StopSide,
};
use crate::description::Quantity;
use crate::effects::{Definition, EffectError, Host, HostKind};

/// The element with an effect, by the kind of its host. On any other host it is [`EffectError::WrongHost`].
macro_rules! hosts {
    ($($name:ident: $host:ident in $parts:ident, $part:ty;)*) => {$(
        pub(crate) fn $name(&mut self, host: Host, effect: &Definition) -> Result<&mut $part, EffectError> {
            match host {
                Host::$host(i) => Ok(&mut self.$parts[i]),
                _ => Err(self.wrong_host(host, effect)),
            }
        }
    )*};
}

impl Assembly {
    /// Kind of the element with an effect, in the present machine: a rigid spring that another effect made
    /// flexible is no longer rigid.
    pub fn host_kind(&self, host: Host) -> HostKind {
        match host {
            Host::Body(_) => HostKind::Body,
            Host::Spring(i) if self.links[i].rigid => HostKind::RigidSpring,
            Host::Spring(_) => HostKind::Spring,
            Host::Contact(_) => HostKind::Contact,
            Host::Actuator(_) => HostKind::Actuator,
            Host::Sensor(i) => self.sensors[i].source.host_kind(),
        }
    }

    hosts! {
        node_mut: Body in nodes, Node;
        link_mut: Spring in links, Link;
        contact_mut: Contact in contacts, ContactPart;
        drive_mut: Actuator in drives, Drive;
        sensor_mut: Sensor in sensors, SensorPart;
    }

    /// The drive with an effect on its force.
    ///
    /// [`EffectError::WrongHost`] if the host is not an actuator; [`EffectError::WrongSite`] if its motion is
    /// imposed, or if its command is an input of a servo.
    pub(crate) fn force_drive_mut(
        &mut self,
        host: Host,
        effect: &Definition,
    ) -> Result<&mut Drive, EffectError> {
        let drive = self.drive_mut(host, effect)?;
        if drive.imposed.is_some() || drive.feeds.is_some() {
            return Err(EffectError::WrongSite { kind: effect.kind, needs: effect.site });
        }
        Ok(drive)
    }

    /// The error of a wrong host; it names the elements that accept the effect.
    pub(crate) fn wrong_host(&self, host: Host, effect: &Definition) -> EffectError {
        EffectError::WrongHost { kind: effect.kind, found: self.host_kind(host), expected: effect.hosts }
    }

    /// Adds a body with the position and velocity of `at`, and returns its node.
    pub(crate) fn add_node(&mut self, name: String, mass_kg: f64, at: NodeId) -> NodeId {
        let position_m = self.nodes[at].position_m;
        let velocity_m_per_s = self.nodes[at].velocity_m_per_s;
        self.nodes.push(Node { name, mass_kg, position_m, velocity_m_per_s });
        self.nodes.len() - 1
    }

    /// Adds a spring and damper between two nodes and returns its index.
    pub fn add_link(
        &mut self,
        name: String,
        a: NodeId,
        b: NodeId,
        stiffness_n_per_m: f64,
        damping_n_s_per_m: f64,
    ) -> usize {
        self.links.push(Link {
            stiffness: stiffness_n_per_m,
            damping: damping_n_s_per_m,
            ..Link::between(name, a, b)
        });
        self.links.len() - 1
    }

    /// Moves every contact from one node to another.
    pub(crate) fn move_contacts(&mut self, from: NodeId, to: NodeId) {
        for contact in &mut self.contacts {
            for end in [&mut contact.a, &mut contact.b] {
                if *end == from {
                    *end = to;
                }
            }
        }
    }

    /// Drives that are inputs of a servo beside its target.
    pub fn feeds_of(&self, servo: usize) -> impl Iterator<Item = (usize, ServoFeed)> + '_ {
        let drives = self.drives.iter().enumerate();
        drives.filter_map(move |(i, drive)| Some((i, drive.feeds.filter(|feed| feed.servo == servo)?)))
    }

    /// Moves the weights of a spring's first body, and of all bodies that move as one with it, to its second
    /// body: an arm hangs behind its joint. A weight that the earth pulls stays with the body that states it,
    /// and the force of a guide stays at the guide.
    pub(crate) fn hang_behind(&mut self, spring: usize) {
        let (a, b) = (self.links[spring].a, self.links[spring].b);
        if Self::is_ground(a) || Self::is_ground(b) {
            return;
        }
        let side = self.reached(vec![a], &[GROUND_NODE, b], |link| link.rigid);
        for weight in self.weights.iter_mut().filter(|weight| !weight.is_of_earth) {
            if matches!(weight.course, PositionForce::Pull(_)) && side.contains(&weight.on) {
                weight.on = b;
            }
        }
    }

    /// Moves links, contacts, drives and weights from one node to another. Sensors stay, and so do weights
    /// that the earth pulls.
    pub(crate) fn move_everything(&mut self, from: NodeId, to: NodeId) {
        self.move_contacts(from, to);
        let links = self.links.iter_mut().flat_map(|link| [&mut link.a, &mut link.b]);
        let drives = self.drives.iter_mut().flat_map(|drive| [&mut drive.on, &mut drive.reacts_on]);
        let weights = self.weights.iter_mut().filter(|weight| !weight.is_of_earth);
        let weights = weights.flat_map(|weight| [&mut weight.on, &mut weight.reacts_on]);
        for end in links.chain(drives).chain(weights) {
            if *end == from {
                *end = to;
            }
        }
    }

    /// Nodes that links of some kind connect to `members`, these included and first; `stops` are not entered.
    pub fn reached(
        &self,
        mut members: Vec<NodeId>,
        stops: &[NodeId],
        leads: impl Fn(&Link) -> bool,
    ) -> Vec<NodeId> {
        let mut next = 0;
        while let Some(&at) = members.get(next) {
            next += 1;
            for link in self.links.iter().filter(|link| leads(link)) {
                for (from, to) in [(link.a, link.b), (link.b, link.a)] {
                    if from == at && !stops.contains(&to) && !members.contains(&to) {
                        members.push(to);
                    }
                }
            }
        }
        members
    }

    /// Whether some force depends on where the machine is, apart from its linear springs and its contacts.
    pub fn depends_on_position(&self) -> bool {
        let hardens = |link: &Link| !link.rigid && link.cubic != 0.0;
        !self.weights.is_empty()
            || self.drives.iter().any(|drive| !drive.ripples.is_empty())
            || self.links.iter().any(hardens)
    }

    /// Sum of the masses that move as one with `node` through rigid links, itself included; infinite if it is
    /// fixed.
    pub fn rigid_mass_kg(&self, node: NodeId) -> f64 {
        let members = self.reached(vec![node], &[], |link| link.rigid);
        members.iter().map(|&i| self.nodes[i].mass_kg).sum()
    }

    /// The node of a node's or sensor's signal, the node that it is relative to, and the quantity; `None` for
    /// other signals.
    pub fn node_read(&self, source: Source) -> Option<(NodeId, NodeId, Quantity)> {
        let of = |source: Source, relative_to: NodeId| match source {
            Source::Node(node, quantity) => Some((node, relative_to, quantity)),
            _ => None,
        };
        match source {
            Source::Sensor(i) => of(self.sensors[i].source, self.sensors[i].relative_to),
            other => of(other, GROUND_NODE),
        }
    }

    /// Whether a node is the fixed body.
    pub(crate) fn is_ground(node: NodeId) -> bool {
        node == GROUND_NODE
    }
}

impl Source {
    /// Kind of a sensor of this signal, as an element.
    pub fn host_kind(self) -> HostKind {
        match self {
            Self::Contact(_, Quantity::Force | Quantity::SpringForce)
            | Self::Link(..)
            | Self::Drive(_, Quantity::Force) => HostKind::ForceSensor,
            Self::Node(..)
            | Self::Drive(_, Quantity::Position | Quantity::Velocity)
            | Self::Contact(_, Quantity::Compression | Quantity::Gap | Quantity::GapRate) => {
                HostKind::MotionSensor
            }
            Self::Contact(..) | Self::Drive(..) | Self::Sensor(_) => HostKind::OtherSensor,
        }
    }
}

impl Link {
    /// A link without any force.
    pub fn between(name: String, a: NodeId, b: NodeId) -> Self {
        Self {
            name,
            a,
            b,
            rigid: false,
            stiffness: 0.0,
            damping: 0.0,
            asymmetry: 0.0,
            drag: 0.0,
            over_speed: None,
            cubic: 0.0,
            play: 0.0,
            stop: None,
            load: 0.0,
            friction: Friction::NONE,
            presliding: None,
            bears: None,
            bristle: None,
        }
    }

    /// The sides with a stop, each with the elongation at which it begins; empty if the link acts everywhere.
    pub fn stops(&self) -> impl Iterator<Item = (StopSide, f64)> + use<> {
        let half = 0.5 * self.play;
        let play = (self.play > 0.0).then_some([(StopSide::Upper, half), (StopSide::Lower, -half)]);
        play.into_iter().flatten().chain(self.stop)
    }

    /// Whether any property of the link depends on its direction of motion.
    pub(crate) fn feels_direction(&self) -> bool {
        self.asymmetry != 0.0 || self.drag != 0.0 || self.bristle.is_some()
    }

    /// Replaces the rigid joint by this spring and damper.
    pub(crate) fn set_flexible(&mut self, stiffness_n_per_m: f64, damping_n_s_per_m: f64) {
        self.rigid = false;
        self.stiffness = stiffness_n_per_m;
        self.damping = damping_n_s_per_m;
    }
}
