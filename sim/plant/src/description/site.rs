//! Elements of a machine, whatever their kind.

use feeler_catalogue::{Dimension, Field, Key, KeyKind, KeyRole, Keyed, Tabled, Unit};

use super::{Actuator, Body, Contact, Elements, Machine, Sensor, Spring};
use crate::effects::EffectUse;

/// A kind of elements: a table in files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ElementKind {
    /// `[bodies.*]`.
    Bodies,
    /// `[springs.*]`.
    Springs,
    /// `[contacts.*]`.
    Contacts,
    /// `[actuators.*]`.
    Actuators,
    /// `[sensors.*]`.
    Sensors,
}

impl ElementKind {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bodies => Body::TABLE,
            Self::Springs => Spring::TABLE,
            Self::Contacts => Contact::TABLE,
            Self::Actuators => Actuator::TABLE,
            Self::Sensors => Sensor::TABLE,
        }
    }
}

impl Tabled for Body {
    const TABLE: &'static str = "bodies";
}

impl Tabled for Spring {
    const TABLE: &'static str = "springs";
}

impl Tabled for Contact {
    const TABLE: &'static str = "contacts";
}

impl Tabled for Actuator {
    const TABLE: &'static str = "actuators";
}

impl Tabled for Sensor {
    const TABLE: &'static str = "sensors";
}

/// Position of an element in its machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Site {
    /// Kind of the element, which is also its table in files.
    pub table: ElementKind,
    /// Position of the element in that table.
    pub index: usize,
}

impl Site {
    /// Key of the element as in a file, `springs.guide`.
    pub fn key(self, machine: &Machine) -> String {
        format!("{}.{}", self.table.name(), machine.element(self).map_or("", |(name, _)| name))
    }
}

/// A believed parameter of an element.
#[derive(Clone, Copy, Debug)]
pub struct Believed {
    /// Its index among the element's keys.
    pub index: usize,
    /// Its declaration.
    pub key: &'static Key,
    /// The believed value, SI.
    pub value: f64,
}

impl Believed {
    /// Its dimension; N/m for the stiffness of a power law.
    pub fn dimension(&self) -> Dimension {
        match self.key.kind {
            KeyKind::Quantity(Unit::Of(dimension), _) => dimension,
            KeyKind::Quantity(Unit::PowerStiffness, _) => Dimension::STIFFNESS,
            _ => Dimension::NONE,
        }
    }
}

/// Properties of every element.
pub trait Element {
    /// Departures from the ideal.
    fn effects(&self) -> &[EffectUse];
    /// Departures from the ideal.
    fn effects_mut(&mut self) -> &mut Vec<EffectUse>;
    /// Its believed parameters, in the order of its keys.
    fn believed(&self) -> Vec<Believed>;
    /// Sets a believed parameter, by its index among the keys.
    fn believe(&mut self, index: usize, value: f64);
}

macro_rules! elements {
    ($($element:ty),*) => { $(
        impl Element for $element {
            fn effects(&self) -> &[EffectUse] {
                &self.effects
            }

            fn effects_mut(&mut self) -> &mut Vec<EffectUse> {
                &mut self.effects
            }

            fn believed(&self) -> Vec<Believed> {
                let believed = |(index, field): (usize, &'static Field<Self>)| {
                    let value = field.number(self).filter(|_| field.role == KeyRole::Believed)?;
                    Some(Believed { index, key: &field.key, value })
                };
                self.fields().enumerate().filter_map(believed).collect()
            }

            fn believe(&mut self, index: usize, value: f64) {
                let found = self.fields().nth(index);
                if let Some(field) = found {
                    field.set_number(self, value);
                }
            }
        }
    )* };
}

elements!(Body, Spring, Contact, Actuator, Sensor);

impl Machine {
    /// Every element, table by table.
    pub fn sites(&self) -> impl Iterator<Item = Site> + use<> {
        let tables = [
            (ElementKind::Bodies, self.bodies.len()),
            (ElementKind::Springs, self.springs.len()),
            (ElementKind::Contacts, self.contacts.len()),
            (ElementKind::Actuators, self.actuators.len()),
            (ElementKind::Sensors, self.sensors.len()),
        ];
        tables.into_iter().flat_map(|(table, n)| (0..n).map(move |index| Site { table, index }))
    }

    /// An element and its name.
    pub fn element(&self, site: Site) -> Option<(&str, &dyn Element)> {
        fn at<T: Element>(elements: &Elements<T>, index: usize) -> Option<(&str, &dyn Element)> {
            elements.get_index(index).map(|(name, element)| (name.as_str(), element as &dyn Element))
        }
        match site.table {
            ElementKind::Bodies => at(&self.bodies, site.index),
            ElementKind::Springs => at(&self.springs, site.index),
            ElementKind::Contacts => at(&self.contacts, site.index),
            ElementKind::Actuators => at(&self.actuators, site.index),
            ElementKind::Sensors => at(&self.sensors, site.index),
        }
    }

    /// An element, to be changed.
    pub fn element_mut(&mut self, site: Site) -> Option<&mut dyn Element> {
        fn at<T: Element>(elements: &mut Elements<T>, index: usize) -> Option<&mut dyn Element> {
            elements.get_index_mut(index).map(|(_, element)| element as &mut dyn Element)
        }
        match site.table {
            ElementKind::Bodies => at(&mut self.bodies, site.index),
            ElementKind::Springs => at(&mut self.springs, site.index),
            ElementKind::Contacts => at(&mut self.contacts, site.index),
            ElementKind::Actuators => at(&mut self.actuators, site.index),
            ElementKind::Sensors => at(&mut self.sensors, site.index),
        }
    }
}
