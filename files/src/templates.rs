//! Files to start from.

use std::fmt::Write as _;
use std::path::Path;

use feeler_arm::{Chain, JointDrive, JointKind};
use feeler_catalogue::Keyed;

use super::keys::arm::{JOINTS, NAME, TOOL, URDF};

/// A template of a single file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Template {
    pub name: &'static str,
    pub about: &'static str,
    pub text: &'static str,
}

/// Every template.
pub const TEMPLATES: &[Template] = &[
    Template {
        name: "rigid",
        about: "one mass against a stiff wall under force control",
        text: include_str!("templates/rigid.toml"),
    },
    Template {
        name: "flexible",
        about: "motor and tip with a flexible transmission between them",
        text: include_str!("templates/flexible.toml"),
    },
    Template {
        name: "base",
        about: "an axis on a base that moves",
        text: include_str!("templates/base.toml"),
    },
    Template {
        name: "workpiece",
        about: "an axis that pushes on a workpiece that yields",
        text: include_str!("templates/workpiece.toml"),
    },
    Template {
        name: "all-three",
        about: "transmission, base and workpiece all flexible, driven by a voltage amplifier",
        text: include_str!("templates/all-three.toml"),
    },
    Template {
        name: "chatter",
        about: "sustained bouncing on a stiff wall",
        text: include_str!("templates/chatter.toml"),
    },
    Template {
        name: "servo",
        about: "a position servo that moves a joint under a load",
        text: include_str!("templates/servo.toml"),
    },
    Template {
        name: "motor",
        about: "a geared motor of direct current that turns a joint, with its current limit",
        text: include_str!("templates/motor.toml"),
    },
    Template {
        name: "imposed",
        about: "a rig that moves one end of a spring as commanded, and the body that follows",
        text: include_str!("templates/imposed.toml"),
    },
];

/// A template of several files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Folder {
    pub name: &'static str,
    pub about: &'static str,
    /// Names and texts of the files.
    pub files: &'static [(&'static str, &'static str)],
}

/// Every template of several files.
pub const FOLDERS: &[Folder] = &[
    Folder {
        name: "sweep",
        about: "a sweep over the gain and the delay of a servo, with its machine",
        files: &[
            ("sweep.toml", include_str!("templates/sweep/sweep.toml")),
            ("servo.toml", include_str!("templates/servo.toml")),
        ],
    },
    Folder {
        name: "dataset",
        about: "records of targets and encoder of a servo, and the machine as it is believed",
        files: &[
            ("dataset.toml", include_str!("templates/dataset/dataset.toml")),
            ("machine.toml", include_str!("templates/dataset/machine.toml")),
            ("bench.toml", include_str!("templates/dataset/bench.toml")),
        ],
    },
];

/// The template that is made from a URDF: its name and description.
pub const ARM_TEMPLATE: (&str, &str) = ("arm", "an arm file with every joint of a URDF (--urdf FILE)");

/// The names of all templates.
pub fn template_names() -> impl Iterator<Item = &'static str> {
    TEMPLATES.iter().map(|t| t.name).chain(FOLDERS.iter().map(|f| f.name)).chain([ARM_TEMPLATE.0])
}

/// The template of this name.
pub fn template(name: &str) -> Option<&'static Template> {
    TEMPLATES.iter().find(|template| template.name == name)
}

/// An arm file for the joints of a URDF at the path `named`, with numbers of typical size; `tool` is its last
/// link.
pub fn arm_text(chain: &Chain, tool: &str, named: &Path) -> String {
    let mut text = format!(
        "# The drives of an arm, which its URDF does not state. Numbers are those of gears of that size;\n\
         # put those of your drives in their place.\n\
         {} = {:?}\n{} = {:?}\n{} = {tool:?}\n",
        NAME.name,
        chain.name,
        URDF.name,
        named.display().to_string(),
        TOOL.name
    );
    for joint in &chain.joints {
        let effort = joint.effort_limit.unwrap_or(50.0);
        let stiffness = 200.0 * effort;
        let drive = JointDrive {
            gear_ratio: 100.0,
            rotor_inertia_kg_m2: 1e-6 * effort,
            stiffness_n_m_per_rad: stiffness,
            damping_n_m_s_per_rad: 1e-3 * stiffness,
            viscous_friction_n_m_s_per_rad: joint.viscous_friction,
            dry_friction_n_m: joint.dry_friction,
            effort_limit_n_m: None,
            bandwidth_hz: None,
        };
        let _ = writeln!(text, "\n[{JOINTS}.{:?}]", joint.name);
        for field in JointDrive::FIELDS {
            let Some(value) = field.number(&drive) else { continue };
            let value = if field.key.name == JointDrive::ROTOR_INERTIA.key.name {
                format!("\"{value:e} {}\"", if joint.kind == JointKind::Prismatic { "kg" } else { "kg m2" })
            } else {
                value.to_string()
            };
            let _ = writeln!(text, "{:<16} = {value}", field.key.name);
        }
    }
    text
}
