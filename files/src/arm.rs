//! Arm files: a URDF, and the drives of its joints, which a URDF does not describe.

use feeler_catalogue::{Absent, Contents, Keyed};
use feeler_plant::names::{did_you_mean, list};
use feeler_problem::{Problem, Remedy};
use std::path::{Path, PathBuf};

use feeler_arm::{Arm, Chain, Collision, Joint, JointDrive, JointKind, MeshFile, ShortInertia, Urdf};

use super::draft::{Sheet, load};
use super::keys::arm::{ABOUT, JOINTS, NAME, TOOL, URDF};
use super::keys::{ARM, JOINT};
use super::kind::FileKind;
use super::problem::{FormatError, Problems};
use super::read::{Reader, Scope, join};
use super::source::{Origin, Sources};
use super::tree::{Entry, Table, place};

/// Largest size of a URDF, bytes.
const LARGEST_URDF: u64 = 16 << 20;

/// A checked arm file.
#[derive(Clone, Debug)]
pub struct ArmFile {
    pub name: String,
    pub about: String,
    /// Links, joints and drives.
    pub arm: Arm,
    /// Elements that are missing and not needed so far.
    pub doubts: Vec<Problem>,
}

impl ArmFile {
    /// Reads an arm file and the URDF that it names.
    ///
    /// # Errors
    /// Every mistake of the arm file at once; only the first of the URDF.
    pub fn load(path: &Path) -> Result<Self, FormatError> {
        load(path, Self::parse)
    }

    /// Checks `text` as the content of `file_name`, against which the URDF's name is resolved.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn parse(text: &str, file_name: &str) -> Result<Self, FormatError> {
        let mut sheet = Sheet::parse(text, file_name, FileKind::Arm)?;
        let read = read(&sheet.root, &sheet.sources, &Origin::default(), &[], &mut sheet.problems);
        sheet.finish(read).map(|read| {
            let ReadArm { name, about, arm, doubts, .. } = read;
            Self { name, about, arm, doubts }
        })
    }
}

/// Contents of an arm file and its URDF.
pub(super) struct ReadArm {
    pub(super) name: String,
    pub(super) about: String,
    pub(super) arm: Arm,
    /// The URDF's shapes of base and links; empty if it has none.
    pub(super) collisions: Vec<Vec<Collision>>,
    /// The folder of the URDF.
    pub(super) folder: PathBuf,
    pub(super) doubts: Vec<Problem>,
}

/// Reads the tree of an arm file, which begins at `at`. Ignores the keys of joints in `besides`. `None` if
/// there are mistakes.
pub(super) fn read(
    root: &Table,
    sources: &Sources,
    at: &Origin,
    besides: &[&str],
    problems: &mut Problems,
) -> Option<ReadArm> {
    let before = problems.count();
    let fields = Reader { problems, scope: Scope::new(true) }.fields(&ARM, &[JOINTS], root, at, "");
    let source = root.get(URDF.name).map_or(0, |entry| entry.node.origin.source);
    let path = sources.0[source].directory.join(fields.value::<String>(&URDF)?);
    let (urdf, tool) = urdf(&path, &fields, root, problems)?;
    let (chain, collisions) = chain(&urdf, &tool, &path, root, problems)?;
    let drives = drives(&chain, root, besides, problems);
    if problems.count() > before {
        return None;
    }
    match Arm::new(chain, drives) {
        Ok(arm) => Some(ReadArm {
            name: fields.value(&NAME).unwrap_or_else(|| arm.chain().name.clone()),
            about: fields.value(&ABOUT).unwrap_or_default(),
            arm,
            collisions,
            doubts: absent_meshes(&urdf, &path).into_iter().chain(short_inertias(&urdf, &path)).collect(),
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
        }),
        Err(error) => {
            problems.add_error(&Origin::default(), JOINTS, &error);
            None
        }
    }
}

/// Warns of meshes that a URDF names but that are absent. An absent collision mesh is a mistake when it is
/// used.
fn absent_meshes(urdf: &Urdf, path: &Path) -> Option<Problem> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let is_absent = |mesh: &&MeshFile| !mesh_path(folder, &mesh.file).is_some_and(|path| path.is_file());
    let absent: Vec<&MeshFile> = urdf.meshes().filter(is_absent).collect();
    let MeshFile { link, file, line } = absent.first()?;
    let message = format!(
        "{}, line {line}: link `{link}` names the mesh `{file}`, which does not exist{}",
        path.display(),
        if absent.len() > 1 { format!(" ({} meshes are absent)", absent.len()) } else { String::new() }
    );
    Some(Problem::new(
        URDF.name,
        message,
        "put the files beside the URDF if its shapes are to touch something",
    ))
}

/// Inertias without all six numbers, for which other programs refuse a URDF.
fn short_inertias(urdf: &Urdf, path: &Path) -> Option<Problem> {
    let ShortInertia { link, lacks, line } = urdf.short_inertias().first()?;
    let count = urdf.short_inertias().len();
    let message = format!(
        "{}, line {line}: the inertia of link `{link}` lacks `{lacks}`, which counts as zero here{}",
        path.display(),
        if count > 1 { format!(" ({count} links lack some)") } else { String::new() }
    );
    let remedy = "write ixx, ixy, ixz, iyy, iyz and izz: other programs refuse the file without";
    Some(Problem::new(URDF.name, message, remedy))
}

/// The URDF and the tool link.
fn urdf(path: &Path, fields: &Contents, root: &Table, problems: &mut Problems) -> Option<(Urdf, String)> {
    let shown = path.display();
    let mut refuse = |message: String, remedy: &str| {
        problems.add(&place(root, URDF.name), URDF.name, format!("{shown}{message}"), remedy);
    };
    let text = super::file::read_text(path, LARGEST_URDF)
        .map_err(|error| refuse(format!(": {error}"), "name a URDF file, relative to this one"))
        .ok()?;
    let urdf = Urdf::parse(&text).map_err(|error| refuse(format!(": {error}"), &error.remedy())).ok()?;
    let Some(tool) = fields.value(&TOOL).or_else(|| urdf.last_link().map(str::to_owned)) else {
        refuse(" has no links".into(), "name a URDF file of an arm");
        return None;
    };
    Some((urdf, tool))
}

/// The chain of the joints to the tool, and the shapes of the moving bodies.
fn chain(
    urdf: &Urdf,
    tool: &str,
    path: &Path,
    root: &Table,
    problems: &mut Problems,
) -> Option<(Chain, Vec<Vec<Collision>>)> {
    let found = urdf.chain(tool).and_then(|chain| Ok((chain, urdf.collisions(tool)?)));
    if let Err(error) = &found {
        let key = if root.contains_key(TOOL.name) { TOOL.name } else { URDF.name };
        problems.add(&place(root, key), key, format!("{}: {error}", path.display()), error.remedy());
    }
    found.ok()
}

/// Path of a mesh: beside the URDF or, for a package, in one of the folders above it.
pub(super) fn mesh_path(folder: &Path, file: &str) -> Option<PathBuf> {
    let Some(inner) = file.strip_prefix("package://") else {
        return Some(folder.join(file.strip_prefix("file://").unwrap_or(file)));
    };
    let inside = inner.split_once('/').map_or(inner, |(_, inside)| inside);
    let found = folder
        .ancestors()
        .flat_map(|above| [above.join(inner), above.join(inside)])
        .find(|path| path.is_file());
    found.or_else(|| Some(folder.join(inner)))
}

fn drives(chain: &Chain, root: &Table, besides: &[&str], problems: &mut Problems) -> Vec<JointDrive> {
    let required = JOINT.keys.iter().filter(|key| key.absent == Absent::Required).map(|key| key.name);
    let remedy = format!("add [{JOINTS}.NAME] with {} for each joint that moves", list(required));
    let Some(entry) = root.get(JOINTS) else {
        let message = format!("`{JOINTS}` is missing: a URDF does not describe gears and rotors");
        problems.add(&Origin::default(), JOINTS, message, remedy);
        return Vec::new();
    };
    let Some(table) = problems.table(&entry.node, JOINTS, remedy.as_str()) else { return Vec::new() };
    let names = || chain.joints.iter().map(|joint| joint.name.as_str());
    for (name, entry) in table {
        if !names().any(|known| known == name) {
            let remedy = did_you_mean(name, names());
            problems.add(
                &entry.key,
                join(JOINTS, name),
                format!("no joint `{name}` moves on the way to the tool"),
                remedy,
            );
        }
    }
    let mut found = Vec::new();
    for joint in &chain.joints {
        let path = join(JOINTS, &joint.name);
        let Some(Entry { node, .. }) = table.get(&joint.name) else {
            let message = format!("joint `{}` has no drive", joint.name);
            problems.add(&entry.node.origin, &path, message, remedy.as_str());
            continue;
        };
        if let Some(keys) = problems.table(node, &path, remedy.as_str()) {
            let scope = Scope::new(joint.kind != JointKind::Prismatic);
            let fields = Reader { problems, scope }.fields(&JOINT, besides, keys, &node.origin, &path);
            found.push(drive(joint, &fields));
        }
    }
    found
}

/// A drive; friction and effort default to those of the URDF.
fn drive(joint: &Joint, fields: &Contents) -> JointDrive {
    let mut drive = JointDrive {
        gear_ratio: 1.0,
        rotor_inertia_kg_m2: 1.0,
        stiffness_n_m_per_rad: 1.0,
        damping_n_m_s_per_rad: 0.0,
        viscous_friction_n_m_s_per_rad: joint.viscous_friction,
        dry_friction_n_m: joint.dry_friction,
        effort_limit_n_m: joint.effort_limit,
        bandwidth_hz: None,
    };
    drive.take(fields);
    drive
}
