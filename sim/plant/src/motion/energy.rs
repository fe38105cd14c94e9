//! Stored energy, and the flow of energy into and out of the machine.

use super::{ContactState, Equations, Motion, Row, dot};

/// The energy that a meter counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum MeterKind {
    /// Work done on the machine by a drive.
    DriveWork,
    /// Work done on the machine by the constant load of a link.
    LoadWork,
    /// Work done on the machine by the surface of a contact with a moving gap.
    FeedWork,
    /// Energy that the damping of a link dissipates.
    LinkDamping,
    /// Energy that the dry friction of a link dissipates.
    Friction,
    /// Energy that a contact dissipates: by damping, and the stored energy if it opens while still
    /// compressed.
    ContactDamping,
}

impl MeterKind {
    /// Whether the counted energy enters the machine; otherwise it leaves.
    pub fn enters(self) -> bool {
        matches!(self, Self::DriveWork | Self::LoadWork | Self::FeedWork)
    }
}

/// An integral of force times speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Meter {
    pub kind: MeterKind,
    /// Index of the drive, link or contact.
    pub element: usize,
    pub force: Row,
    /// Speed row; power is `force xi * speed xi`.
    pub speed: Row,
}

/// A kind of stored energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StorageKind {
    /// Kinetic energy of a coordinate.
    Kinetic,
    /// Elastic energy of a link and its bristles.
    Link,
    /// Potential energy of a weight, above its lowest position.
    Weight,
    /// Elastic energy of a contact.
    Contact,
}

/// Stored energy, J.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Storage {
    pub kind: StorageKind,
    /// Index of the coordinate, link, weight or contact.
    pub element: usize,
    pub joule: f64,
}

/// The meters of a mode, always the same ones in the same order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ledger {
    pub meters: Vec<Meter>,
}

fn minus(a: &Row, b: &Row) -> Row {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

impl Motion {
    /// The meters of a mode.
    pub fn ledger(&self, equations: &Equations) -> Ledger {
        let negative = |row: &Row| row.iter().map(|r| -r).collect::<Row>();
        let mut meters = Vec::new();
        for (element, (force, stroke)) in equations.drive_force.iter().zip(&equations.stroke).enumerate() {
            meters.push(Meter {
                kind: MeterKind::DriveWork,
                element,
                force: force.clone(),
                speed: stroke[1].clone(),
            });
        }
        for (element, link) in self.assembly.links.iter().enumerate() {
            let speed = equations.elongation[element][1].clone();
            let mut load = self.layout.zero();
            load[self.layout.one()] = if link.rigid { 0.0 } else { link.load };
            let friction = &equations.link_friction[element];
            let damping = minus(
                &minus(
                    &minus(&equations.link_force[element], friction),
                    &equations.link_spring_force[element],
                ),
                &load,
            );
            meters.push(Meter { kind: MeterKind::LoadWork, element, force: load, speed: speed.clone() });
            meters.push(Meter {
                kind: MeterKind::LinkDamping,
                element,
                force: negative(&damping),
                speed: speed.clone(),
            });
            meters.push(Meter { kind: MeterKind::Friction, element, force: negative(friction), speed });
            // Bristles store part of the work done on them.
            if let Some([force, speed]) = equations.bristles[element].clone() {
                meters.push(Meter { kind: MeterKind::Friction, element, force, speed });
            }
        }
        for (element, force) in equations.contact_force.iter().enumerate() {
            let mut surface_speed = self.layout.zero();
            if let Some(offset) = self.layout.moving_gap(element) {
                // The gap closes: the surface moves towards the tip.
                surface_speed[offset + 1] = -1.0;
            }
            meters.push(Meter {
                kind: MeterKind::FeedWork,
                element,
                force: force.clone(),
                speed: surface_speed,
            });
            let force = minus(force, &equations.contact_spring_force[element]);
            meters.push(Meter {
                kind: MeterKind::ContactDamping,
                element,
                force,
                speed: equations.compression[element][1].clone(),
            });
        }
        Ledger { meters }
    }

    /// Energy stored at `xi` in a mode.
    pub fn storage(&self, equations: &Equations, xi: &[f64]) -> Vec<Storage> {
        let mut storage = Vec::new();
        for g in 0..self.coordinates.count() {
            let v = xi[self.layout.v(g)];
            storage.push(Storage {
                kind: StorageKind::Kinetic,
                element: g,
                joule: 0.5 * self.coordinates.mass_kg(g) * v * v,
            });
        }
        for (element, link) in self.assembly.links.iter().enumerate().filter(|(_, link)| !link.rigid) {
            let e = dot(&equations.elongation[element][0], xi);
            let spring = |d: f64| 0.5 * link.stiffness * d * d + 0.25 * link.cubic * d.powi(4);
            let closed = |side| self.stop_state(equations.mode, element, side) == ContactState::Pushing;
            let mut sides = link.stops().peekable();
            let elastic = if sides.peek().is_none() {
                spring(e)
            } else {
                sides.filter(|(side, _)| closed(*side)).map(|(_, at)| spring(e - at)).sum()
            };
            let bristles = link.bristle.zip(self.layout.bristle(element));
            let bent = bristles.map_or(0.0, |(bristle, state)| 0.5 * bristle.stiffness * xi[state].powi(2));
            storage.push(Storage { kind: StorageKind::Link, element, joule: elastic + bent });
        }
        for (element, weight) in self.assembly.weights.iter().enumerate() {
            let [x, _] = self.relative(weight.on, weight.reacts_on);
            let joule = weight.course.potential(dot(&x, xi));
            storage.push(Storage { kind: StorageKind::Weight, element, joule });
        }
        for (element, contact) in self.assembly.contacts.iter().enumerate() {
            let closed = self.contact_state(equations.mode, element) == ContactState::Pushing;
            let d = dot(&equations.compression[element][0], xi).abs();
            let law = contact.law;
            let joule = law.stiffness * d.powf(law.exponent + 1.0) / (law.exponent + 1.0)
                + 0.25 * law.cubic * d.powi(4);
            storage.push(Storage {
                kind: StorageKind::Contact,
                element,
                joule: if closed { joule } else { 0.0 },
            });
        }
        storage
    }
}
