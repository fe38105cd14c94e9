//! Controllers: the keys of their wiring, those of every controller, and those of each law.

use feeler_catalogue::{Choice, Keyed, Keys, LAW, Tabled, Variant, joined, keys, variants};
use feeler_control::reference::FOLLOWED;
use feeler_control::{ControllerSpec, Law};
use feeler_engine::ControllerUse;
use feeler_plant::effects::HostKind;

use super::Element;

const LAWS: [Variant; Law::FORMS.len()] = variants(Law::FORMS);

/// `[controllers.*]`
pub(crate) static CONTROLLERS: Element = Element {
    table: ControllerSpec::TABLE,
    singular: "controller",
    text: "Sampled-data controllers. Every `period` one reads its sensors, computes, and after `delay` its \
           output is applied and held. Outputs on the same actuator add up.",
    shape: Keys {
        keys: joined!(joined!(keys!(ControllerUse::FIELDS), keys!(ControllerSpec::FIELDS)), &[FOLLOWED]),
        choice: Some(Choice { key: LAW, default: None, text: "the control law", variants: &LAWS }),
    },
    hosts: &[HostKind::Controller],
};

/// A key of a file, as messages show one.
pub const EXAMPLE_KEY: &str = "controllers.force.kp";
