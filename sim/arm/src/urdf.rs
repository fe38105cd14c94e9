//! URDF: links with inertia, joints between them.

use std::collections::HashMap;

use nalgebra::{Isometry3, Matrix3, Unit, Vector3};
use roxmltree::{Document, Node};

use crate::chain::{Chain, Inertial, Joint, JointKind};
use crate::collision::{self, Collision};
use crate::error::ArmError;
use crate::xml::{attribute, child, line_of, number, optional_number, origin, vector, wrong};

/// Standard acceleration of free fall, m/s².
const GRAVITY: f64 = 9.806_65;
/// The triangle inequality of principal moments holds within this share: tables of inertias are rounded.
const INERTIA_ROUNDING: f64 = 1e-3;

/// A robot description: links, and the joints between them.
#[derive(Clone, Debug, Default)]
pub struct Urdf {
    name: String,
    links: HashMap<String, Link>,
    /// In the order of the file.
    link_names: Vec<String>,
    joints: Vec<Described>,
    short_inertias: Vec<ShortInertia>,
    /// The standard one along -z, unless stated.
    pub(crate) gravity_m_per_s2: Option<Vector3<f64>>,
}

#[derive(Clone, Debug)]
pub(crate) struct Link {
    inertial: Inertial,
    collisions: Vec<Collision>,
    meshes: Vec<MeshFile>,
}

impl Link {
    /// A link without geometry.
    pub(crate) fn of(inertial: Inertial) -> Self {
        Self { inertial, collisions: Vec::new(), meshes: Vec::new() }
    }

    pub(crate) fn massless() -> Self {
        Self::of(Inertial::none())
    }
}

/// An inertia that lacks products. They count as zero here, but the format asks for all six numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShortInertia {
    /// Link that states it.
    pub link: String,
    /// The first absent product.
    pub lacks: &'static str,
    /// Line number, from 1.
    pub line: u32,
}

/// A mesh named by a link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshFile {
    /// Link that names it.
    pub link: String,
    /// The file as written, with its scheme if it has one.
    pub file: String,
    /// Line number, from 1.
    pub line: u32,
}

#[derive(Clone, Debug)]
pub(crate) struct Described {
    pub(crate) line: u32,
    pub(crate) parent: String,
    pub(crate) child: String,
    /// `None` for a fixed joint.
    pub(crate) kind: Option<JointKind>,
    pub(crate) joint: Joint,
}

/// Products of inertia.
const PRODUCTS: [&str; 3] = ["ixy", "ixz", "iyz"];

/// The inertia of a link, if it lacks products.
fn short_inertia(link: Node<'_, '_>, name: &str) -> Option<ShortInertia> {
    let inertia = child(child(link, "inertial")?, "inertia")?;
    let lacks = PRODUCTS.into_iter().find(|product| !inertia.has_attribute(*product))?;
    Some(ShortInertia { link: name.into(), lacks, line: line_of(inertia) })
}

fn inertial(link: Node<'_, '_>, name: &str) -> Result<Inertial, ArmError> {
    let Some(node) = child(link, "inertial") else { return Ok(Inertial::none()) };
    let Some(mass) = child(node, "mass") else {
        return wrong(
            node,
            format!("the `inertial` of link `{name}` has no `mass`"),
            "add `<mass value=\"...\"/>`",
        );
    };
    let mass_kg = number(mass, "value")?;
    if mass_kg <= 0.0 {
        return wrong(
            mass,
            format!("link `{name}` has a mass of {mass_kg} kg"),
            "write a mass above zero, or leave `inertial` out for a massless link",
        );
    }
    let Some(inertia) = child(node, "inertia") else {
        let what = format!("the `inertial` of link `{name}` has no `inertia`");
        return wrong(node, what, "add its six numbers: ixx, ixy, ixz, iyy, iyz and izz");
    };
    let entry = |name| number(inertia, name);
    let [xx, yy, zz] = [entry("ixx")?, entry("iyy")?, entry("izz")?];
    let [xy, xz, yz] = PRODUCTS.map(|name| optional_number(inertia, name));
    let (xy, xz, yz) = (xy?.unwrap_or(0.0), xz?.unwrap_or(0.0), yz?.unwrap_or(0.0));
    let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let mut principal = tensor.symmetric_eigenvalues();
    principal.as_mut_slice().sort_by(f64::total_cmp);
    // If all are zero, the link is a point mass. The joint must then turn other inertia too (see
    // `check_masses`).
    if principal[0] <= 0.0 && tensor.amax() > 0.0 {
        let what = format!(
            "link `{name}` has an inertia of {} kg m2 about one of its axes; it must be above zero",
            principal[0]
        );
        return wrong(inertia, what, "give the inertia of its shape");
    }
    if principal[2] > (principal[0] + principal[1]) * (1.0 + INERTIA_ROUNDING) {
        let [a, b, c] = [principal[0], principal[1], principal[2]];
        return wrong(
            inertia,
            format!(
                "the principal moments {a}, {b}, {c} kg m2 of link `{name}` are impossible: each must \
                 be at most the sum of the other two"
            ),
            "give the inertia of its shape",
        );
    }
    let place = origin(node)?;
    let mut found = Inertial::none();
    found.add(&Inertial { mass_kg, centre_m: Vector3::zeros(), inertia_kg_m2: tensor }, &place);
    Ok(found)
}

fn meshes(link: Node<'_, '_>, name: &str) -> Result<Vec<MeshFile>, ArmError> {
    let named = link.descendants().filter(|node| node.has_tag_name("mesh"));
    named
        .map(|node| {
            Ok(MeshFile { link: name.into(), file: attribute(node, "filename")?.into(), line: line_of(node) })
        })
        .collect()
}

fn joint(node: Node<'_, '_>) -> Result<Described, ArmError> {
    let name = attribute(node, "name")?;
    let kind = match attribute(node, "type")? {
        "revolute" => Some(JointKind::Revolute),
        "continuous" => Some(JointKind::Continuous),
        "prismatic" => Some(JointKind::Prismatic),
        "fixed" => None,
        other => {
            return wrong(
                node,
                format!("joint `{name}` is of type `{other}`, which is not simulated"),
                "make it revolute, continuous, prismatic or fixed",
            );
        }
    };
    let end = |tag: &str| match child(node, tag) {
        Some(end) => attribute(end, "link").map(str::to_owned),
        None => wrong(node, format!("joint `{name}` has no `{tag}`"), format!("add `<{tag} link=\"...\"/>`")),
    };
    // A fixed joint needs no axis, and exporters write zeros there.
    let axis = child(node, "axis").filter(|_| kind.is_some());
    let axis = axis.map_or(Ok(Vector3::x()), |axis| vector(axis, "xyz", Vector3::x()))?;
    let Some(axis) = Unit::try_new(axis, 1e-9) else {
        return wrong(
            node,
            format!("the axis of joint `{name}` has no direction"),
            "write three numbers that are not all zero",
        );
    };
    let mut limits = [f64::NEG_INFINITY, f64::INFINITY];
    let mut effort_limit = None;
    match child(node, "limit") {
        Some(limit) => {
            if kind != Some(JointKind::Continuous) {
                limits = [
                    optional_number(limit, "lower")?.unwrap_or(0.0),
                    optional_number(limit, "upper")?.unwrap_or(0.0),
                ];
            }
            effort_limit = optional_number(limit, "effort")?.filter(|effort| *effort > 0.0);
            if limits[0] > limits[1] {
                return wrong(
                    limit,
                    format!("the limits of joint `{name}` are {} to {}", limits[0], limits[1]),
                    "write the lower one first",
                );
            }
        }
        None if matches!(kind, Some(JointKind::Revolute | JointKind::Prismatic)) => {
            let what = format!("joint `{name}` has no `limit`");
            return wrong(node, what, "add one, or make the joint continuous");
        }
        None => {}
    }
    let friction =
        |name: &str| child(node, "dynamics").map_or(Ok(None), |dynamics| optional_number(dynamics, name));
    Ok(Described {
        line: line_of(node),
        parent: end("parent")?,
        child: end("child")?,
        kind,
        joint: Joint {
            name: name.into(),
            link: end("child")?,
            kind: kind.unwrap_or(JointKind::Continuous),
            place: origin(node)?,
            axis,
            limits,
            effort_limit,
            viscous_friction: friction("damping")?.unwrap_or(0.0),
            dry_friction: friction("friction")?.unwrap_or(0.0),
            inertial: Inertial::none(),
        },
    })
}

impl Urdf {
    pub(crate) fn empty(name: &str) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    pub(crate) fn add_link(&mut self, name: &str, link: Link) {
        if self.links.insert(name.into(), link).is_none() {
            self.link_names.push(name.into());
        }
    }

    pub(crate) fn add_joint(&mut self, described: Described) {
        self.joints.push(described);
    }

    /// The joints that move, in the order of the file.
    pub fn moving_joints(&self) -> impl Iterator<Item = &Joint> {
        self.joints.iter().filter(|described| described.kind.is_some()).map(|described| &described.joint)
    }

    /// Reads the text of a URDF file.
    ///
    /// # Errors
    /// [`ArmError::Xml`] and [`ArmError::Urdf`], with the line.
    pub fn parse(text: &str) -> Result<Self, ArmError> {
        let document = Document::parse(text).map_err(|error| ArmError::Xml { what: error.to_string() })?;
        let root = document.root_element();
        if !root.has_tag_name("robot") {
            return wrong(
                root,
                format!("this is a `<{}>`, not a `<robot>`", root.tag_name().name()),
                "name a URDF file",
            );
        }
        let mut urdf = Self::empty(root.attribute("name").unwrap_or_default());
        for node in root.children().filter(|node| node.has_tag_name("link")) {
            let name = attribute(node, "name")?;
            let link = Link {
                inertial: inertial(node, name)?,
                collisions: collision::of_link(node)?,
                meshes: meshes(node, name)?,
            };
            if urdf.links.insert(name.into(), link).is_some() {
                return wrong(node, format!("there are two links `{name}`"), "rename one of them");
            }
            urdf.link_names.push(name.into());
            urdf.short_inertias.extend(short_inertia(node, name));
        }
        for node in root.children().filter(|node| node.has_tag_name("joint")) {
            let described = joint(node)?;
            for end in [&described.parent, &described.child] {
                if !urdf.links.contains_key(end) {
                    return wrong(
                        node,
                        format!("joint `{}` names a link `{end}` that is not there", described.joint.name),
                        format!("add the link, or name one of {}", urdf.link_names.join(", ")),
                    );
                }
            }
            if let Some(other) = urdf.joints.iter().find(|other| other.child == described.child) {
                let what = format!(
                    "link `{}` hangs on two joints, `{}` and `{}`, and loops are not simulated",
                    other.child, other.joint.name, described.joint.name
                );
                return wrong(node, what, "open the loop: remove one of the two joints");
            }
            urdf.joints.push(described);
        }
        Ok(urdf)
    }

    /// Every mesh that the links name.
    pub fn meshes(&self) -> impl Iterator<Item = &MeshFile> {
        self.link_names.iter().flat_map(|name| &self.links[name].meshes)
    }

    /// Every inertia that lacks products.
    pub fn short_inertias(&self) -> &[ShortInertia] {
        &self.short_inertias
    }

    /// The default tool: the last link of the file without a child.
    pub fn last_link(&self) -> Option<&str> {
        let is_leaf = |name: &&String| !self.joints.iter().any(|joint| joint.parent == **name);
        self.link_names.iter().rfind(is_leaf).map(String::as_str)
    }

    /// The chain from the base to a link, whose frame is the tool's. Bodies on fixed joints move with their
    /// link. Joints off the path stay at zero, and bodies on them move with their link too.
    ///
    /// # Errors
    /// [`ArmError::Unknown`], [`ArmError::NoJoints`], [`ArmError::Massless`], and [`ArmError::Urdf`] for
    /// links in a circle.
    pub fn chain(&self, tool: &str) -> Result<Chain, ArmError> {
        let way = self.way(tool)?;
        let mut joints: Vec<Joint> = Vec::new();
        // Frame of the current link, relative to that of the last moving joint.
        let mut frame = Isometry3::identity();
        for described in &way {
            frame *= described.joint.place;
            if described.kind.is_some() {
                let axis = described.joint.axis;
                joints.push(Joint { place: frame, axis, ..described.joint.clone() });
                frame = Isometry3::identity();
            }
            if let Some(last) = joints.last_mut() {
                self.gather(&described.child, &frame, &way, &mut last.inertial);
            }
        }
        if joints.is_empty() {
            return Err(ArmError::NoJoints { tip: tool.into() });
        }
        let chain = Chain {
            name: self.name.clone(),
            joints,
            tool: frame,
            gravity_m_per_s2: self.gravity_m_per_s2.unwrap_or(Vector3::z() * -GRAVITY),
        };
        check_masses(&chain, &way)?;
        Ok(chain)
    }

    /// Shapes for collision detection, in the frames of the bodies that carry them. The first list belongs to
    /// the base, the others to the bodies that each joint on the path to the tool moves.
    ///
    /// # Errors
    /// [`ArmError::Unknown`], and [`ArmError::Urdf`] for links in a circle.
    pub fn collisions(&self, tool: &str) -> Result<Vec<Vec<Collision>>, ArmError> {
        let way = self.way(tool)?;
        let base = way.first().map_or(tool, |described| described.parent.as_str());
        let mut found = vec![Vec::new()];
        let mut frame = Isometry3::identity();
        self.gather_collisions(base, &frame, &way, &mut found[0]);
        for described in &way {
            frame *= described.joint.place;
            if described.kind.is_some() {
                frame = Isometry3::identity();
                found.push(Vec::new());
            }
            if let Some(last) = found.last_mut() {
                self.gather_collisions(&described.child, &frame, &way, last);
            }
        }
        Ok(found)
    }

    fn gather_collisions(
        &self,
        link: &str,
        frame: &Isometry3<f64>,
        way: &[&Described],
        into: &mut Vec<Collision>,
    ) {
        into.extend(
            self.links[link]
                .collisions
                .iter()
                .map(|part| Collision { place: frame * part.place, ..part.clone() }),
        );
        for joint in self
            .joints
            .iter()
            .filter(|joint| joint.parent == link && !way.iter().any(|on| on.child == joint.child))
        {
            self.gather_collisions(&joint.child, &(frame * joint.joint.place), way, into);
        }
    }

    /// The joints on the path from the base to a link.
    fn way(&self, tool: &str) -> Result<Vec<&Described>, ArmError> {
        if !self.links.contains_key(tool) {
            return Err(ArmError::Unknown {
                kind: "link",
                name: tool.into(),
                known: self.link_names.join(", "),
            });
        }
        let mut way: Vec<&Described> = Vec::new();
        let mut link = tool;
        while let Some(joint) = self.joints.iter().find(|joint| joint.child == link) {
            if way.len() > self.joints.len() {
                return Err(ArmError::Urdf {
                    line: joint.line,
                    what: format!("link `{link}` is attached to itself"),
                    remedy: "open the circle: remove one of its joints".into(),
                });
            }
            way.push(joint);
            link = &joint.parent;
        }
        way.reverse();
        Ok(way)
    }

    /// Adds a link and everything attached to it that is not on the path to the tool.
    fn gather(&self, link: &str, frame: &Isometry3<f64>, way: &[&Described], into: &mut Inertial) {
        into.add(&self.links[link].inertial, frame);
        for joint in self
            .joints
            .iter()
            .filter(|joint| joint.parent == link && !way.iter().any(|on| on.child == joint.child))
        {
            self.gather(&joint.child, &(frame * joint.joint.place), way, into);
        }
    }
}

/// Every joint must move a mass or inertia.
fn check_masses(chain: &Chain, way: &[&Described]) -> Result<(), ArmError> {
    let mass = chain.mass_matrix(&vec![0.0; chain.joints()]);
    let largest = mass.diagonal().amax();
    match (0..chain.joints()).find(|&i| mass[(i, i)].is_nan() || mass[(i, i)] <= f64::EPSILON * largest) {
        None => Ok(()),
        Some(i) => {
            let joint = &chain.joints[i].name;
            let described = way.iter().find(|described| described.joint.name == *joint);
            let link = described.map_or(String::new(), |described| described.child.clone());
            Err(ArmError::Massless { joint: joint.clone(), link })
        }
    }
}
