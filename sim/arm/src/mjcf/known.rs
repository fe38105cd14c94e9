//! Elements and attributes of MJCF that are known. All others are refused, since they may change a motion.

/// Treatment of an attribute or element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// It is read.
    Read,
    /// It does not change the motion of a joint, its load or its drive.
    Idle,
    /// It does, unless it has this value. It is not read, and the user learns so.
    Remark { unless: &'static str, follows: &'static str },
    /// It changes what is read, unless it has this value.
    Refused { unless: Option<&'static str> },
}

/// The remedy for what only MuJoCo can expand.
pub(super) const SAVE: &str = "load the model in MuJoCo, save it by `mj_saveLastXML` with `<compiler \
                               saveinertial=\"true\"/>`, and name the saved file; or remove it";

const POSE: [&str; 6] = ["pos", "quat", "axisangle", "euler", "xyaxes", "zaxis"];

/// Attributes that are read, by element.
const READ: [(&str, &[&str]); 11] = [
    ("compiler", &["angle", "eulerseq", "inertiafromgeom", "inertiagrouprange"]),
    ("option", &["gravity"]),
    ("default", &["class"]),
    ("body", &["name", "childclass"]),
    ("frame", &["childclass"]),
    (
        "joint",
        &[
            "name",
            "class",
            "type",
            "pos",
            "axis",
            "ref",
            "range",
            "limited",
            "damping",
            "frictionloss",
            "armature",
            "actuatorfrcrange",
            "actuatorfrclimited",
        ],
    ),
    ("inertial", &["mass", "diaginertia", "fullinertia"]),
    ("geom", &["class", "type", "size", "fromto", "mass", "density", "group"]),
    ("position", &["kp", "kv", "dampratio"]),
    ("general", &["gainprm", "biasprm", "gaintype", "biastype", "dyntype"]),
    ("motor", &[]),
];
/// Attributes that every actuator has.
const OF_ACTUATORS: [&str; 11] = [
    "class",
    "joint",
    "jointinparent",
    "gear",
    "forcerange",
    "forcelimited",
    "ctrlrange",
    "ctrllimited",
    "armature",
    "damping",
    "delay",
];
/// Kinds of actuators of which a servo or a limit is read.
pub(super) const ACTUATORS: [&str; 3] = ["position", "general", "motor"];

/// Attributes that change no motion of a joint, by element.
const IDLE: [(&str, &[&str]); 8] = [
    (
        "compiler",
        &[
            "alignfree",
            "assetdir",
            "autolimits",
            "conflict",
            "convexhull",
            "discardvisual",
            "exactmeshinertia",
            "fitaabb",
            "fusestatic",
            "meshdir",
            "passthrough",
            "savecanonical",
            "savecompiled",
            "saveinertial",
            "strippath",
            "texturedir",
            "usethread",
        ],
    ),
    // Steps and solvers; wind acts through the density and viscosity of the medium alone.
    (
        "option",
        &[
            "apirate",
            "ccd_iterations",
            "ccd_tolerance",
            "collision",
            "cone",
            "impratio",
            "integrator",
            "iterations",
            "jacobian",
            "ls_iterations",
            "ls_tolerance",
            "magnetic",
            "mpr_iterations",
            "mpr_tolerance",
            "noslip_iterations",
            "noslip_tolerance",
            "o_friction",
            "o_margin",
            "o_solimp",
            "o_solref",
            "sdf_initpoints",
            "sdf_iterations",
            "sleep_tolerance",
            "solver",
            "timestep",
            "tolerance",
            "wind",
        ],
    ),
    ("body", &["user", "mocap", "sleep"]),
    ("frame", &["name"]),
    // Stops are no part of a first machine. `springref` and `springyield` need a `stiffness`.
    (
        "joint",
        &[
            "group",
            "margin",
            "user",
            "solreflimit",
            "solimplimit",
            "springref",
            "springyield",
            "actuatorgravcomp",
        ],
    ),
    (
        "geom",
        &[
            "name",
            "adhesion",
            "castshadow",
            "conaffinity",
            "condim",
            "contype",
            "fluidcoef",
            "fluidshape",
            "friction",
            "gap",
            "hfield",
            "margin",
            "material",
            "priority",
            "rgba",
            "solimp",
            "solmix",
            "solref",
            "surfacevel",
            "user",
            // A body with a mesh is refused by its type, where its mass counts.
            "mesh",
            "fitscale",
        ],
    ),
    (
        "flag",
        &[
            "autoreset",
            "contact",
            "diagexact",
            "energy",
            "equality",
            "eulerdamp",
            "filterparent",
            "fwdinv",
            "invdiscrete",
            "ipc",
            "island",
            "limit",
            "midphase",
            "multiccd",
            "nativeccd",
            "override",
            "refsafe",
            "sensor",
            "sleep",
            "speculative",
            "warmstart",
        ],
    ),
    ("general", &["dynprm", "actdim", "actlimited", "actrange", "actearly", "ffrange", "velrange", "input"]),
];
/// Attributes of actuators that change nothing. Those of other transmissions need one.
const IDLE_OF_ACTUATORS: [&str; 8] =
    ["name", "group", "user", "nsample", "lengthrange", "cranklength", "inheritrange", "refsite"];

/// Attributes that are remarked unless they have their neutral value.
const REMARKED: [(&str, &str, &str, &str); 12] = [
    ("option", "density", "0", "the machine has no drag of the medium"),
    ("option", "viscosity", "0", "the machine has no drag of the medium"),
    ("option", "actuatorgroupdisable", "", "every actuator counts as enabled"),
    ("body", "gravcomp", "0", "the column `load` holds the full weight of each body"),
    ("joint", "stiffness", "0", "state it as `stiffness` of the bearing"),
    ("joint", "solreffriction", "0.02 1", "dry friction holds without creep"),
    ("joint", "solimpfriction", "0.9 0.95 0.001 0.5 2", "dry friction holds without creep"),
    ("position", "timeconst", "0", "state the lag as an effect of the servo"),
    ("position", "interp", "zoh", "the late target is that of a row"),
    ("general", "interp", "zoh", "the late target is that of a row"),
    ("motor", "interp", "zoh", "the late command is that of a row"),
    ("flag", "constraint", "enable", "dry friction counts as enabled"),
];
/// Flags that switch a part of the dynamics off.
const FLAGS: [&str; 6] = ["actuation", "clampctrl", "damper", "frictionloss", "gravity", "spring"];

/// Attributes that are refused unless they have their neutral value.
const REFUSED: [(&str, &str, &str); 7] = [
    ("compiler", "coordinate", "local"),
    ("compiler", "boundmass", "0"),
    ("compiler", "boundinertia", "0"),
    ("compiler", "settotalmass", "-1"),
    ("compiler", "balanceinertia", "false"),
    ("joint", "springdamper", "0"),
    ("geom", "shellinertia", "false"),
];

/// Treatment of an attribute of a kind of element.
pub(super) fn attribute(kind: &str, name: &str) -> Use {
    let in_list = |list: &[(&str, &[&str])]| {
        list.iter().any(|(element, names)| *element == kind && names.contains(&name))
    };
    let has_pose = ["body", "frame", "inertial", "geom"].contains(&kind);
    let is_actuator = ACTUATORS.contains(&kind);
    if in_list(&READ) || has_pose && POSE.contains(&name) || is_actuator && OF_ACTUATORS.contains(&name) {
        return Use::Read;
    }
    if in_list(&IDLE) || is_actuator && IDLE_OF_ACTUATORS.contains(&name) {
        return Use::Idle;
    }
    if kind == "flag" && FLAGS.contains(&name) {
        return Use::Remark { unless: "enable", follows: "this part of the dynamics counts as enabled" };
    }
    let remarked = REMARKED.iter().find(|(element, own, ..)| *element == kind && *own == name);
    if let Some((_, _, unless, follows)) = remarked {
        return Use::Remark { unless, follows };
    }
    let refused = REFUSED.iter().find(|(element, own, _)| *element == kind && *own == name);
    Use::Refused { unless: refused.map(|(.., unless)| *unless) }
}

/// Children by element: those that are read, and those that change no motion of a joint.
const CHILDREN: [(&str, &[&str], &[&str]); 3] = [
    (
        "mujoco",
        &["compiler", "option", "default", "worldbody", "actuator"],
        // Contacts are those of geoms: no part of a first machine.
        &["size", "visual", "statistic", "asset", "sensor", "keyframe", "custom", "contact"],
    ),
    ("body", &["body", "frame", "joint", "inertial", "geom"], &["site", "camera", "light"]),
    ("worldbody", &["body", "frame"], &["geom", "site", "camera", "light"]),
];
/// Sections that couple or drive joints in other ways.
const COUPLING: [(&str, &str); 4] = [
    ("equality", "joints count as independent"),
    ("tendon", "joints count as independent"),
    ("deformable", "the bodies of the joints count alone"),
    ("extension", "no plugin acts"),
];

/// Treatment of a child of an element. A frame has the children of its body.
pub(super) fn child(parent: &str, name: &str) -> Use {
    if let Some((_, follows)) = COUPLING.iter().find(|(section, _)| parent == "mujoco" && *section == name) {
        return Use::Remark { unless: "", follows };
    }
    let found = CHILDREN.iter().find(|(element, ..)| *element == parent);
    match found {
        Some((_, read, _)) if read.contains(&name) => Use::Read,
        Some((.., idle)) if idle.contains(&name) => Use::Idle,
        _ => Use::Refused { unless: None },
    }
}
