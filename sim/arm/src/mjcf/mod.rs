//! MJCF models of MuJoCo: the same tree of links and joints as in a URDF, and the author's parameters of each
//! joint and its actuator.

mod belief;
mod classes;
mod drive;
mod known;
mod mass;
mod parts;
mod read;

use std::collections::HashSet;

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};

use crate::chain::{Inertial, Joint, JointKind};
use crate::error::ArmError;
use crate::urdf::{Described, Link, Urdf};
use crate::xml::{child, line_of, wrong};
pub use belief::JointBelief;
use classes::{Classes, MAIN};
use known::Use;
use mass::FromShapes;
use parts::{Part, parts};
use read::{Angles, Remarks, exactly, numbers_of, place};

/// Largest depth of nested bodies.
const MOST_DEEP: usize = 200;

/// A model: its tree, and the believed parameters of its joints.
#[derive(Clone, Debug)]
pub struct Mjcf {
    /// Links are its bodies.
    pub tree: Urdf,
    /// For each joint, in the order of the file.
    pub joints: Vec<JointBelief>,
    /// Attributes and elements that change motions but are not read, a sentence each with its line.
    pub remarks: Vec<String>,
}

struct Model<'a, 'i> {
    document: &'a Document<'i>,
    classes: Classes<'a>,
    angles: Angles,
    shapes: FromShapes,
    /// Groups of the shapes that count.
    groups: [f64; 2],
    tree: Urdf,
    names: HashSet<String>,
    joints: Vec<JointBelief>,
    remarks: Remarks,
}

/// The surroundings of a body or frame, in the frame of the parent's joint.
#[derive(Clone, Copy)]
struct Around<'b> {
    parent: &'b str,
    class: &'b str,
    /// Frame of the enclosing element.
    at: Isometry3<f64>,
    /// Whether a joint moves it.
    is_moved: bool,
    depth: usize,
}

impl Mjcf {
    /// Reads the text of an MJCF file. A body without an `inertial` has that of its shapes, as in MuJoCo.
    ///
    /// # Errors
    /// [`ArmError::Xml`] and [`ArmError::Urdf`], with the line. What may change a motion and is not known is
    /// an error too.
    pub fn parse(text: &str) -> Result<Self, ArmError> {
        let document = Document::parse(text).map_err(|error| ArmError::Xml { what: error.to_string() })?;
        let root = document.root_element();
        if !root.has_tag_name("mujoco") {
            let what = format!("this is a `<{}>`, not a `<mujoco>`", root.tag_name().name());
            return wrong(root, what, "name an MJCF file");
        }
        if let Some(node) = root.descendants().find(|node| node.has_tag_name("include")) {
            let what = format!("it includes `{}`", node.attribute("file").unwrap_or_default());
            return wrong(node, what, "load it in MuJoCo, save it by `mj_saveLastXML`, and name that file");
        }
        let mut remarks = Remarks::default();
        let classes = Classes::of(root, &mut remarks)?;
        let mut model = Model {
            document: &document,
            classes,
            angles: Angles { is_degree: true, sequence: vec!['x', 'y', 'z'] },
            shapes: FromShapes::Where,
            groups: [0.0, 5.0],
            tree: Urdf::empty(root.attribute("model").unwrap_or_default()),
            names: HashSet::new(),
            joints: Vec::new(),
            remarks,
        };
        model.tree.add_link("world", Link::massless());
        for node in root.children().filter(Node::is_element) {
            model.section(node)?;
        }
        let is = |tag: &'static str| root.children().filter(move |node| node.has_tag_name(tag));
        for world in is("worldbody") {
            let around =
                Around { parent: "world", class: MAIN, at: Isometry3::identity(), is_moved: false, depth: 0 };
            model.children(world, "worldbody", around)?;
        }
        for section in is("actuator") {
            for actuator in section.children().filter(Node::is_element) {
                model.actuator(actuator)?;
            }
        }
        Ok(Self { tree: model.tree, joints: model.joints, remarks: model.remarks.texts() })
    }
}

impl<'a> Model<'a, '_> {
    /// Settings of the whole file, and sections that are not read.
    fn section(&mut self, node: Node<'a, '_>) -> Result<(), ArmError> {
        let tag = node.tag_name().name();
        match known::child("mujoco", tag) {
            Use::Remark { follows, .. } if node.children().any(|child| child.is_element()) => {
                self.remarks.add(node, format!("`<{tag}>`"), follows);
            }
            Use::Refused { .. } => {
                return wrong(node, format!("`<{tag}>` is not read"), known::SAVE);
            }
            _ => {}
        }
        match tag {
            "compiler" => self.compiler(node),
            "option" => {
                self.remarks.check(node, tag)?;
                if let Some(text) = node.attribute("gravity") {
                    self.tree.gravity_m_per_s2 = Some(Vector3::from(exactly(node, "gravity", text)?));
                }
                child(node, "flag").map_or(Ok(()), |flag| self.remarks.check(flag, "flag"))
            }
            _ => Ok(()),
        }
    }

    fn compiler(&mut self, node: Node<'a, '_>) -> Result<(), ArmError> {
        self.remarks.check(node, "compiler")?;
        if let Some(angle) = node.attribute("angle") {
            self.angles.is_degree = angle != "radian";
        }
        if let Some(text) = node.attribute("eulerseq") {
            self.angles.sequence = text.chars().collect();
            if self.angles.sequence.len() != 3 || !text.chars().all(|c| "xyzXYZ".contains(c)) {
                return wrong(
                    node,
                    format!("`eulerseq=\"{text}\"` is not an order of axes"),
                    "write as `xyz`",
                );
            }
        }
        if let Some(range) = node.attribute("inertiagrouprange") {
            self.groups = exactly(node, "inertiagrouprange", range)?;
        }
        match node.attribute("inertiafromgeom") {
            Some("true") => self.shapes = FromShapes::Always,
            Some("false") => self.shapes = FromShapes::Never,
            _ => {}
        }
        Ok(())
    }

    /// The bodies and frames inside an element; everything else there must be known.
    fn children(&mut self, node: Node<'a, '_>, parent: &str, around: Around<'_>) -> Result<(), ArmError> {
        if around.depth > MOST_DEEP {
            return wrong(node, "bodies are nested too deeply", "flatten the tree");
        }
        for inner in node.children().filter(Node::is_element) {
            let tag = inner.tag_name().name();
            if tag == "freejoint" {
                return wrong(
                    inner,
                    "a body that floats is not simulated",
                    "remove it: its body is then fixed, as the base of a robot on a table",
                );
            }
            if let Use::Refused { .. } = known::child(parent, tag) {
                return wrong(inner, format!("`<{tag}>` is not read"), known::SAVE);
            }
            let depth = around.depth + 1;
            match tag {
                "body" => self.body(inner, Around { depth, ..around })?,
                "frame" => {
                    self.remarks.check(inner, tag)?;
                    let at = around.at * place(inner, &self.angles, &|name: &str| inner.attribute(name))?;
                    let class = inner.attribute("childclass").unwrap_or(around.class);
                    self.children(inner, parent, Around { class, at, depth, ..around })?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// A body, with everything attached to it.
    fn body(&mut self, node: Node<'a, '_>, around: Around<'_>) -> Result<(), ArmError> {
        self.remarks.check(node, "body")?;
        let class = node.attribute("childclass").unwrap_or(around.class);
        let name =
            node.attribute("name").map_or_else(|| format!("body on line {}", line_of(node)), str::to_owned);
        if name == "world" || !self.names.insert(name.clone()) {
            return wrong(node, format!("there are two bodies `{name}`"), "rename one of them");
        }
        let at = around.at * place(node, &self.angles, &|name: &str| node.attribute(name))?;
        let parts = parts(node, class, &self.angles)?;
        let joints: Vec<&Part<'a, '_>> = parts.iter().filter(|part| part.is("joint")).collect();
        if joints.len() > 1 {
            let what = format!("body `{name}` has {} joints", joints.len());
            return wrong(joints[1].node, what, "put a massless body between them, one joint in each");
        }
        let is_moved = around.is_moved || !joints.is_empty();
        let mut own = Isometry3::identity();
        let described = match joints.first() {
            None => fixed(node, around.parent, &name, at),
            Some(joint) => {
                let (described, frame) = self.joint(joint, around.parent, &name, at)?;
                own = frame;
                described
            }
        };
        self.tree.add_joint(described);
        // The frame of the body in that of its joint.
        let shift = own.inverse();
        let inertial = self.inertia(&parts, is_moved, &shift)?;
        self.tree.add_link(&name, Link::of(inertial));
        let around = Around { parent: &name, class, at: shift, is_moved, depth: around.depth };
        self.children(node, "body", around)
    }

    /// Mass and inertia of a body, from its `inertial` or its shapes.
    fn inertia(
        &mut self,
        parts: &[Part<'a, '_>],
        is_moved: bool,
        shift: &Isometry3<f64>,
    ) -> Result<Inertial, ArmError> {
        let mut found = Inertial::none();
        let stated = parts.iter().find(|part| part.is("inertial"));
        let shapes: Vec<&Part<'a, '_>> = parts.iter().filter(|part| part.is("geom")).collect();
        let by_shapes = match self.shapes {
            FromShapes::Never => false,
            FromShapes::Where => stated.is_none(),
            FromShapes::Always => stated.is_none() || !shapes.is_empty(),
        };
        for shape in &shapes {
            self.remarks.check(shape.node, "geom")?;
            // The mass of what stands still changes no motion.
            if !by_shapes || !is_moved {
                continue;
            }
            let find = self.classes.attributes(shape.node, "geom", &shape.class)?;
            let group = find("group").map_or(Ok([0.0]), |text| exactly::<1>(shape.node, "group", text))?[0];
            if (self.groups[0]..=self.groups[1]).contains(&group)
                && let Some(inertia) = mass::of_shape(shape.node, &self.angles, &find)?
            {
                found.add(&inertia, &(shift * shape.frame));
            }
        }
        if let Some(stated) = stated {
            self.remarks.check(stated.node, "inertial")?;
            if !by_shapes {
                found.add(&mass::stated(stated.node, &self.angles)?, &(shift * stated.frame));
            }
        }
        Ok(found)
    }

    /// A joint, and its frame in that of its body.
    fn joint(
        &mut self,
        part: &Part<'a, '_>,
        parent: &str,
        link: &str,
        at: Isometry3<f64>,
    ) -> Result<(Described, Isometry3<f64>), ArmError> {
        let node = part.node;
        self.remarks.check(node, "joint")?;
        let find = self.classes.attributes(node, "joint", &part.class)?;
        let one = |name: &str| -> Result<f64, ArmError> {
            let all = find(name).map_or(Ok(Vec::new()), |text| numbers_of(node, name, text))?;
            Ok(all.first().copied().unwrap_or(0.0))
        };
        let pair = |name: &str| find(name).map(|text| exactly::<2>(node, name, text)).transpose();
        let name = node.attribute("name").map_or_else(|| link.to_owned(), str::to_owned);
        let mut kind = match find("type") {
            None | Some("hinge") => JointKind::Continuous,
            Some("slide") => JointKind::Prismatic,
            Some(other) => {
                let what = format!("joint `{name}` is of type `{other}`, which is not simulated");
                return wrong(node, what, "make it a hinge or a slide");
            }
        };
        let is_slide = kind == JointKind::Prismatic;
        let axis = find("axis").map_or(Ok([0.0, 0.0, 1.0]), |text| exactly(node, "axis", text))?;
        let Some(axis) = Unit::try_new(Vector3::from(axis), 1e-9) else {
            let what = format!("the axis of joint `{name}` has no direction");
            return wrong(node, what, "write three numbers");
        };
        let in_si = |x: f64| if is_slide { x } else { self.angles.in_radians(x) };
        let mut limits = [f64::NEG_INFINITY, f64::INFINITY];
        if let Some(range) = pair("range")?.filter(|_| find("limited") != Some("false")) {
            limits = range.map(in_si);
            if kind == JointKind::Continuous {
                kind = JointKind::Revolute;
            }
        }
        let anchor = find("pos").map_or(Ok([0.0; 3]), |text| exactly(node, "pos", text))?;
        let frame = part.frame * Translation3::from(Vector3::from(anchor));
        // The model shows the joint at `ref`, not at zero.
        let back = -in_si(one("ref")?);
        let zero = if is_slide {
            Isometry3::from(Translation3::from(axis.into_inner() * back))
        } else {
            Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_axis_angle(&axis, back))
        };
        let mut belief = JointBelief {
            name: name.clone(),
            link: link.into(),
            armature: one("armature")?,
            damping: one("damping")?,
            friction: one("frictionloss")?,
            ..JointBelief::default()
        };
        for name in ["damping", "stiffness"] {
            let more = find(name).map_or(Ok(Vec::new()), |text| numbers_of(node, name, text))?;
            if more.iter().skip(1).any(|x| x.abs() > 0.0) {
                let what = format!("a `{name}` with several numbers");
                self.remarks.add(node, what, "only the first, the linear one, counts");
            }
        }
        if let Some(range) = pair("actuatorfrcrange")?.filter(|_| find("actuatorfrclimited") != Some("false"))
        {
            drive::limit(node, &mut belief, range, &mut self.remarks);
        }
        let joint = Joint {
            name,
            link: link.into(),
            kind,
            place: at * frame * zero,
            axis,
            limits,
            effort_limit: None,
            viscous_friction: belief.damping,
            dry_friction: belief.friction,
            inertial: Inertial::none(),
        };
        self.joints.push(belief);
        let (parent, child) = (parent.into(), link.into());
        Ok((Described { line: line_of(node), parent, child, kind: Some(kind), joint }, frame))
    }

    /// Parameters of an actuator's loop at its joint.
    fn actuator(&mut self, node: Node<'_, '_>) -> Result<(), ArmError> {
        // The document's borrow outlives that of the iterator.
        let Some(node) = self.document.get_node(node.id()) else { return Ok(()) };
        let kind = node.tag_name().name();
        let Some(joint) = node.attribute("joint").or_else(|| node.attribute("jointinparent")) else {
            let what = format!("the `<{kind}>` that drives no single joint");
            self.remarks.add(node, what, "no drive of a joint follows from it");
            return Ok(());
        };
        let Some(at) = self.joints.iter().position(|belief| belief.name == joint) else {
            let known: Vec<&str> = self.joints.iter().map(|belief| belief.name.as_str()).collect();
            let remedy = format!("name one of {}", known.join(", "));
            return wrong(node, format!("there is no joint `{joint}`"), remedy);
        };
        if !known::ACTUATORS.contains(&kind) {
            let what = format!("the `<{kind}>` of joint `{joint}`");
            self.remarks.add(node, what, "state its effect in the machine");
            return Ok(());
        }
        let mut drive = self.classes.drive(node)?;
        drive.apply(node, &mut self.remarks)?;
        drive.drives(node, &mut self.joints[at], &mut self.remarks)
    }
}

/// A body that is welded to its parent.
fn fixed(node: Node<'_, '_>, parent: &str, link: &str, place: Isometry3<f64>) -> Described {
    let joint = Joint {
        name: format!("{link}, fixed"),
        link: link.into(),
        kind: JointKind::Continuous,
        place,
        axis: Vector3::z_axis(),
        limits: [f64::NEG_INFINITY, f64::INFINITY],
        effort_limit: None,
        viscous_friction: 0.0,
        dry_friction: 0.0,
        inertial: Inertial::none(),
    };
    Described { line: line_of(node), parent: parent.into(), child: link.into(), kind: None, joint }
}

#[cfg(test)]
mod tests;
