//! Arm files: a URDF, and the drives of its joints, which a URDF does not describe.

use feeler_catalogue::{Contents, Record};
use feeler_plant::names::did_you_mean;
use feeler_problem::{Problem, Remedy};
use std::path::{Path, PathBuf};

use feeler_arm::{Arm, Chain, Collision, Joint, JointDrive, JointKind, MeshFile, ShortInertia, Urdf};

use super::draft::{Sheet, load};
use super::keys::arm::{ABOUT, NAME, TOOL, URDF};
use super::keys::{ARM, JOINT};
use super::kind::FileKind;
use super::problem::{FormatError, Problems};
use super::read::{Reader, Scope, join};
use super::source::{Origin, Sources};
use super::tree::{Table, Value};

/// Bytes of the largest URDF.
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
    doubts: Vec<Problem>,
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
    let fields = Reader { problems, scope: Scope::new(true) }.fields(&ARM, &["joints"], root, at, "");
    let source = root.get("urdf").map_or(0, |entry| entry.node.origin.source);
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
            problems.add_error(&Origin::default(), "joints", &error);
            None
        }
    }
}

fn origin_of(root: &Table, key: &str) -> Origin {
    root.get(key).map(|entry| entry.node.origin.clone()).unwrap_or_default()
}

/// The meshes that a URDF names and that are absent. Those of collisions are mistakes where they are used.
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
    Some(Problem::new("urdf", message, "put the files beside the URDF if its shapes are to touch something"))
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
    Some(Problem::new("urdf", message, remedy))
}

/// The URDF and the tool link.
fn urdf(path: &Path, fields: &Contents, root: &Table, problems: &mut Problems) -> Option<(Urdf, String)> {
    let origin = origin_of(root, "urdf");
    let shown = path.display();
    let text = match super::file::read_text(path, LARGEST_URDF) {
        Ok(text) => text,
        Err(error) => {
            problems.add(
                &origin,
                "urdf",
                format!("{shown}: {error}"),
                "name a URDF file, relative to this one",
            );
            return None;
        }
    };
    let urdf = match Urdf::parse(&text) {
        Ok(urdf) => urdf,
        Err(error) => {
            problems.add(&origin, "urdf", format!("{shown}: {error}"), error.remedy());
            return None;
        }
    };
    let Some(tool) = fields.value(&TOOL).or_else(|| urdf.last_link().map(str::to_owned)) else {
        problems.add(&origin, "urdf", format!("{shown} has no links"), "name a URDF file of an arm");
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
        let key = if root.contains_key("tool") { "tool" } else { "urdf" };
        problems.add(&origin_of(root, key), key, format!("{}: {error}", path.display()), error.remedy());
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
    let remedy = "add [joints.NAME] with gear_ratio, rotor_inertia and stiffness for each joint that moves";
    let Some(entry) = root.get("joints") else {
        problems.add(
            &Origin::default(),
            "joints",
            "`joints` is missing: a URDF does not describe gears and rotors",
            remedy,
        );
        return Vec::new();
    };
    let Value::Table(table) = &entry.node.value else {
        problems.add(
            &entry.node.origin,
            "joints",
            format!("this must be a table, not {}", entry.node.value.kind()),
            remedy,
        );
        return Vec::new();
    };
    let names = || chain.joints.iter().map(|joint| joint.name.as_str());
    for (name, entry) in table {
        if !names().any(|known| known == name) {
            let remedy = did_you_mean(name, names());
            problems.add(
                &entry.key,
                join("joints", name),
                format!("no joint `{name}` moves on the way to the tool"),
                remedy,
            );
        }
    }
    let mut found = Vec::new();
    for joint in &chain.joints {
        let path = join("joints", &joint.name);
        match table.get(&joint.name).map(|entry| (&entry.node.value, &entry.node.origin)) {
            Some((Value::Table(keys), origin)) => {
                let scope = Scope::new(joint.kind != JointKind::Prismatic);
                let fields = Reader { problems, scope }.fields(&JOINT, besides, keys, origin, &path);
                found.push(drive(joint, &fields));
            }
            Some((value, origin)) => {
                problems.add(origin, &path, format!("this must be a table, not {}", value.kind()), remedy);
            }
            None => problems.add(
                &entry.node.origin,
                &path,
                format!("joint `{}` has no drive", joint.name),
                remedy,
            ),
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
