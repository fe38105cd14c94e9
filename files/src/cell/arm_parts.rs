//! The arm of a scenario: from an arm file or a URDF, with the joints of the scenario on top.

use std::path::Path;

use feeler_arm::{Arm, Collision, CollisionShape, JointKind};
use feeler_catalogue::{Contents, Dimension};
use feeler_geometry::Shape;
use feeler_manipulator::{BodyShapes, JointPart, joint_effect_host, joint_effects, link_capsules};
use feeler_plant::description::Axis;
use feeler_plant::effects::{EffectUse, Kind, find};
use feeler_plant::names::did_you_mean;
use feeler_problem::{Problem, Remedy};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::arm::{self, ReadArm, mesh_path};
use crate::build::Builder;
use crate::build::shapes::{self, FileError};
use crate::draft::{Draft, lay_over, read_text};
use crate::keys::EFFECTS;
use crate::keys::arm::{self as arm_keys, JOINTS, URDF};
use crate::keys::cell::{ARM_FILE, TOOL};
use crate::parse::parse_toml;
use crate::problem::Problems;
use crate::read::join;
use crate::source::Origin;
use crate::tree::{Entry, Table, locate, node_at};

/// An arm with its joints' drives, effects applied, and its shapes.
pub(super) struct ArmParts {
    pub(super) arm: Arm,
    pub(super) joints: Vec<JointPart>,
    pub(super) bodies: Vec<BodyShapes>,
    /// See [`crate::ArmFile::doubts`].
    pub(super) doubts: Vec<Problem>,
}

/// Reads the arm that a scenario names; `None` if there are mistakes.
pub(super) fn read(draft: &mut Draft, fields: &Contents, problems: &mut Problems) -> Option<ArmParts> {
    let name: String = fields.value(&ARM_FILE)?;
    let entry = draft.root.get(ARM_FILE.name)?.clone();
    let path = draft.sources.0[entry.node.origin.source].directory.join(name);
    let tool = draft.root.get(TOOL.name).cloned();
    let is_urdf = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("urdf"));
    let (mut root, at) = if is_urdf {
        let mut root = Table::new();
        root.insert(URDF.name.into(), entry.clone());
        root.extend(tool.map(|tool| (arm_keys::TOOL.name.to_owned(), tool)));
        (root, entry.node.origin.clone())
    } else {
        if let Some(tool) = tool {
            problems.add(
                &tool.key,
                TOOL.name,
                "an arm file names its tool itself",
                "remove `tool`, or set it in the arm file",
            );
        }
        (arm_file(&path, draft, &entry, problems)?, Origin { source: draft.sources.0.len() - 1, span: 0..0 })
    };
    let mut over = Table::new();
    over.extend(draft.root.get(JOINTS).map(|joints| (JOINTS.to_owned(), joints.clone())));
    lay_over(&mut root, over, 0);
    let read = arm::read(&root, &draft.sources, &at, &[EFFECTS], problems)?;
    let joints = joints(&read.arm, &root, draft, problems)?;
    let bodies = bodies(&read, &entry.node.origin, problems)?;
    Some(ArmParts { arm: read.arm, joints, bodies, doubts: read.doubts })
}

/// The tree of an arm file, which is added to the sources.
fn arm_file(path: &Path, draft: &mut Draft, entry: &Entry, problems: &mut Problems) -> Option<Table> {
    let mut refuse = |message: String| {
        problems.add(
            &entry.node.origin,
            ARM_FILE.name,
            message,
            "name an arm file or a URDF, relative to this file",
        );
    };
    let said = |error: crate::problem::FormatError| {
        error.problems.first().map_or_else(String::new, |problem| problem.message.clone())
    };
    let text =
        read_text(path).map_err(|error| refuse(format!("{}: {}", path.display(), said(error)))).ok()?;
    parse_toml(&text, &path.display().to_string(), &mut draft.sources)
        .map_err(|error| refuse(format!("{}: {}", path.display(), said(error))))
        .ok()
}

/// The joints' parts with their effects.
fn joints(arm: &Arm, root: &Table, draft: &Draft, problems: &mut Problems) -> Option<Vec<JointPart>> {
    let mut found = Vec::new();
    for (joint, drive) in arm.chain().joints.iter().zip(arm.drives()) {
        let path = join(JOINTS, &joint.name);
        let slides = joint.kind == JointKind::Prismatic;
        let effects = effects(root, &joint.name, &path, slides, draft, problems)?;
        match JointPart::new(&joint.name, drive, slides, &effects) {
            Ok(part) => found.push(part),
            Err(mistakes) => {
                for mistake in mistakes {
                    let key = join(&path, &mistake.key);
                    let at = locate(root, &key).0.unwrap_or_default();
                    problems.add(&at, key, mistake.message, mistake.remedy);
                }
            }
        }
    }
    (found.len() == arm.chain().joints()).then_some(found)
}

fn effects(
    root: &Table,
    name: &str,
    path: &str,
    slides: bool,
    draft: &Draft,
    problems: &mut Problems,
) -> Option<Vec<EffectUse>> {
    let path = join(path, EFFECTS);
    let Some(node) = node_at(root, &[JOINTS, name, EFFECTS]) else { return Some(Vec::new()) };
    let table = problems.table(node, &path, format!("write [{path}.KIND]"))?;
    let axis = if slides { Axis::Translational } else { Axis::Rotational };
    let mut found = Some(Vec::new());
    for (kind, entry) in table {
        let path = join(&path, kind);
        let known = find(kind);
        let Some(host) = known.and_then(|definition| joint_effect_host(definition.kind)) else {
            let taken = joint_effects().map(Kind::name);
            let (message, remedy) = if known.is_some() {
                let taken = taken.collect::<Vec<_>>().join(", ");
                (format!("`{kind}` is not simulated in a joint"), format!("joints take {taken}"))
            } else {
                (format!("there is no effect `{kind}`"), did_you_mean(kind, taken))
            };
            problems.add(&entry.key, &path, message, remedy);
            found = None;
            continue;
        };
        let read = Builder::new(draft, problems, axis).effect(kind, entry, (host, Dimension::FORCE), &path);
        match (read, &mut found) {
            (Some(effect), Some(effects)) => effects.push(effect),
            _ => found = None,
        }
    }
    found
}

/// The URDF's collision shapes; without any, capsules along the links.
fn bodies(read: &ReadArm, at: &Origin, problems: &mut Problems) -> Option<Vec<BodyShapes>> {
    let chain = read.arm.chain();
    if read.collisions.iter().all(Vec::is_empty) {
        return Some(link_capsules(chain));
    }
    let names = std::iter::once("base").chain(chain.joints.iter().map(|joint| joint.link.as_str()));
    let mut all = Vec::new();
    for (name, collisions) in names.zip(&read.collisions) {
        let mut shapes = Vec::new();
        for collision in collisions {
            shapes.push(
                shape(collision, &read.folder)
                    .map_err(|problem| problems.add(at, problem.key, problem.message, problem.remedy))
                    .ok()?,
            );
        }
        all.push(BodyShapes { name: name.into(), shapes, radius_m: 0.0 });
    }
    Some(all)
}

/// A collision shape; a mesh as the convex hull of its corners, as is usual.
fn shape(collision: &Collision, folder: &Path) -> Result<(Shape, Isometry3<f64>), Problem> {
    let place = collision.place;
    Ok(match &collision.shape {
        CollisionShape::Box { half_extents_m } => (Shape::Cuboid { half_extents_m: *half_extents_m }, place),
        CollisionShape::Sphere { radius_m } => (Shape::Ball { radius_m: *radius_m }, place),
        CollisionShape::Cylinder { radius_m, half_length_m } => {
            // A URDF's cylinders are along z, those here along y.
            let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
            (Shape::Cylinder { half_length_m: *half_length_m, radius_m: *radius_m }, place * turn)
        }
        CollisionShape::Mesh { file, scale_m } => {
            let path = mesh_path(folder, file).unwrap_or_else(|| folder.join(file));
            let mesh = shapes::mesh(&path, 1.0).map_err(|error| {
                let message = format!("line {} of the URDF: {}: {error}", collision.line, path.display());
                let remedy = match error {
                    FileError::Read { .. } => "put the file beside the URDF as STL or OBJ".into(),
                    FileError::Geometry(_) | FileError::Extension(_) => error.remedy(),
                };
                Problem::new(ARM_FILE.name, message, remedy)
            })?;
            let points_m = mesh
                .vertices_m
                .iter()
                .map(|corner| std::array::from_fn(|axis| corner[axis] * scale_m[axis]))
                .collect();
            (Shape::Hull { points_m }, place)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_a_damaged_mesh_of_a_urdf_has_its_own_remedy() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("link.stl"), "cut").unwrap();
        let refused = |file: &str| {
            let shape = CollisionShape::Mesh { file: file.into(), scale_m: [1.0; 3] };
            super::shape(&Collision { shape, place: Isometry3::identity(), line: 7 }, folder.path())
                .unwrap_err()
        };
        let [damaged, absent] = ["link.stl", "absent.stl"].map(refused);
        assert!(damaged.message.contains("line 7 of the URDF") && damaged.message.contains("cut short"));
        assert!(absent.remedy.contains("beside the URDF"), "{}", absent.remedy);
        assert!(!damaged.remedy.contains("beside the URDF"), "{}", damaged.remedy);
    }
}
