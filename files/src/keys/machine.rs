//! Bodies, springs, contacts, actuators, sensors: their texts, and keys that fill no struct.

use feeler_catalogue::{Choice, Keyed, Keys, LAW, Tabled, Variant, joined, keys, variants};
use feeler_plant::description::{Actuator, Body, Contact, Sensor, Spring};
use feeler_plant::effects::HostKind;

use super::Element;
use super::surface::{PROFILE, SURFACE};

/// The kind of an actuator.
pub(crate) const KIND: &str = "kind";

/// `[bodies.*]`
pub(crate) static BODIES: Element = Element {
    table: Body::TABLE,
    singular: "body",
    text: "Lumped masses. `ground` is the fixed body and needs no entry. All springs are relaxed where \
           every position is zero.",
    shape: Keys { keys: keys!(Body::FIELDS), choice: None },
    hosts: &[HostKind::Body],
};

/// `[springs.*]`
pub(crate) static SPRINGS: Element = Element {
    table: Spring::TABLE,
    singular: "spring",
    text: "Springs and dampers between two bodies. Without stiffness: a viscous guide. With `rigid`: \
           a joint.",
    shape: Keys { keys: keys!(Spring::FIELDS), choice: None },
    hosts: &[HostKind::Spring, HostKind::RigidSpring],
};

const CONTACT_LAWS: [Variant; Contact::FORMS.len()] = variants(Contact::FORMS);

/// `[contacts.*]`
pub(crate) static CONTACTS: Element = Element {
    table: Contact::TABLE,
    singular: "contact",
    text: "Contact of tool and workpiece. The force sensor is this spring, compressed by d = x_tip - \
           x_work - gap.",
    shape: Keys {
        keys: joined!(keys!(Contact::FIELDS), &[SURFACE, PROFILE]),
        choice: Some(Choice {
            key: LAW,
            default: Some(Contact::FORMS[0].name),
            text: "force against compression d and its rate d', for d > 0",
            variants: &CONTACT_LAWS,
        }),
    },
    hosts: &[HostKind::Contact],
};

const AMPLIFIERS: [Variant; Actuator::FORMS.len()] = variants(Actuator::FORMS);

/// `[actuators.*]`
pub(crate) static ACTUATORS: Element = Element {
    table: Actuator::TABLE,
    singular: "actuator",
    text: "Drives: a force on one body and its reaction on another.",
    shape: Keys {
        keys: keys!(Actuator::FIELDS),
        choice: Some(Choice {
            key: KIND,
            default: Some(Actuator::FORMS[0].name),
            text: "how a command becomes a force",
            variants: &AMPLIFIERS,
        }),
    },
    hosts: &[HostKind::Actuator],
};

/// `[sensors.*]`
pub(crate) static SENSORS: Element = Element {
    table: Sensor::TABLE,
    singular: "sensor",
    text: "A reading is `gain` times the filtered, delayed signal, plus `bias` and noise, rounded to \
           `resolution`.",
    shape: Keys { keys: keys!(Sensor::FIELDS), choice: None },
    hosts: &[HostKind::ForceSensor, HostKind::MotionSensor],
};
