//! Arm files.

use feeler_arm::JointDrive;
use feeler_catalogue::{Key, KeyKind, Keyed, Keys, Tabled, keys, optional, required};

pub(crate) const NAME: Key = optional("name", KeyKind::Text, "short name; the URDF's if absent");
pub(crate) const ABOUT: Key = optional("about", KeyKind::Text, "what it is");
pub(crate) const URDF: Key = required("urdf", KeyKind::Text, "the URDF file, relative to this one");
pub(crate) const TOOL: Key = optional(
    "tool",
    KeyKind::Text,
    "link whose frame is the tool's; if absent, the last link without a child",
);

/// The table of the joints.
pub(crate) const JOINTS: &str = JointDrive::TABLE;

/// The top of an arm file; `[joints.*]` are tables of their own.
pub(crate) static ARM: Keys = Keys { keys: &[NAME, ABOUT, URDF, TOOL], choice: None };

/// `[joints.*]`
pub(crate) static JOINT: Keys = Keys { keys: keys!(JointDrive::FIELDS), choice: None };
