//! MJCF models of MuJoCo: the same tree of links and joints as in a URDF, and the author's parameters of each
//! joint and its actuator.

use std::collections::HashMap;

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};

use crate::chain::{Inertial, Joint, JointKind};
use crate::error::ArmError;
use crate::urdf::{Described, Link, Urdf};
use crate::xml::{child, line_of, vector, wrong};

/// Largest depth of nested bodies.
const MOST_DEEP: usize = 200;

/// A model: its tree, and the believed parameters of its joints.
#[derive(Clone, Debug)]
pub struct Mjcf {
    /// Links are its bodies.
    pub tree: Urdf,
    /// For each joint, in the order of the file.
    pub joints: Vec<JointBelief>,
}

/// The author's parameters of a joint and of the loop that drives it; SI.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointBelief {
    pub name: String,
    /// The link that it moves.
    pub link: String,
    /// Inertia (or mass) of rotor and gear, as seen at the joint.
    pub armature: f64,
    /// Viscous friction.
    pub damping: f64,
    pub friction: f64,
    /// Effort per position error of its position actuator.
    pub kp: Option<f64>,
    /// Effort per speed of that actuator.
    pub kd: f64,
    pub effort_limit: Option<f64>,
    /// Delay of a command, s.
    pub delay_s: f64,
}

/// Attributes of one kind of element by class, including those of the enclosing classes.
type Defaults<'a> = HashMap<(String, &'static str), HashMap<&'a str, &'a str>>;

/// Kinds of elements whose defaults are used here.
const KINDS: [&str; 4] = ["joint", "position", "general", "motor"];

struct Model<'a, 'i> {
    document: &'a Document<'i>,
    defaults: Defaults<'a>,
    is_degree: bool,
    tree: Urdf,
    joints: Vec<JointBelief>,
}

impl Mjcf {
    /// Reads the text of an MJCF file. Geometry is ignored: bodies that move need an `inertial`.
    ///
    /// # Errors
    /// [`ArmError::Xml`] and [`ArmError::Urdf`], with the line.
    pub fn parse(text: &str) -> Result<Self, ArmError> {
        let document = Document::parse(text).map_err(|error| ArmError::Xml { what: error.to_string() })?;
        let root = document.root_element();
        if !root.has_tag_name("mujoco") {
            let what = format!("this is a `<{}>`, not a `<mujoco>`", root.tag_name().name());
            return wrong(root, what, "name an MJCF file");
        }
        let mut defaults = Defaults::new();
        for node in root.children().filter(|node| node.has_tag_name("default")) {
            let class = node.attribute("class").unwrap_or("main");
            gather_defaults(node, class, None, &mut defaults);
        }
        let angle = root.children().filter_map(|node| node.attribute("angle")).next_back();
        let mut model = Model {
            document: &document,
            defaults,
            is_degree: angle != Some("radian"),
            tree: Urdf::empty(root.attribute("model").unwrap_or_default()),
            joints: Vec::new(),
        };
        model.tree.add_link("world", Link::massless());
        for world in root.children().filter(|node| node.has_tag_name("worldbody")) {
            for body in world.children().filter(|node| node.has_tag_name("body")) {
                model.body(body, "world", "main", Vector3::zeros(), 0)?;
            }
        }
        for section in root.children().filter(|node| node.has_tag_name("actuator")) {
            for actuator in section.children().filter(Node::is_element) {
                model.actuator(actuator)?;
            }
        }
        Ok(Self { tree: model.tree, joints: model.joints })
    }
}

/// Attributes of a class: those of the enclosing class, overridden by its own.
fn gather_defaults<'a>(node: Node<'a, '_>, class: &str, around: Option<&str>, defaults: &mut Defaults<'a>) {
    for kind in KINDS {
        let inherited = around.and_then(|around| defaults.get(&(around.to_owned(), kind)).cloned());
        let mut attributes = inherited.unwrap_or_default();
        if let Some(own) = child(node, kind) {
            attributes.extend(own.attributes().map(|attribute| (attribute.name(), attribute.value())));
        }
        defaults.entry((class.to_owned(), kind)).or_default().extend(attributes);
    }
    for inner in node.children().filter(|node| node.has_tag_name("default")) {
        let name = inner.attribute("class").unwrap_or(class);
        gather_defaults(inner, name, Some(class), defaults);
    }
}

impl<'a> Model<'a, '_> {
    /// An attribute of an element: its own, or that of its class.
    fn attribute(&self, node: Node<'a, '_>, kind: &'static str, class: &str, name: &str) -> Option<&'a str> {
        let class = node.attribute("class").unwrap_or(class);
        let by_class = |class: &str| self.defaults.get(&(class.to_owned(), kind))?.get(name).copied();
        node.attribute(name).or_else(|| by_class(class)).or_else(|| by_class("main"))
    }

    fn numbers(
        &self,
        node: Node<'a, '_>,
        kind: &'static str,
        class: &str,
        name: &str,
    ) -> Result<Vec<f64>, ArmError> {
        let Some(text) = self.attribute(node, kind, class, name) else { return Ok(Vec::new()) };
        let found: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        if found.len() != text.split_whitespace().count() || found.iter().any(|x| !x.is_finite()) {
            return wrong(
                node,
                format!("`{name}=\"{text}\"` is not a list of numbers"),
                "write numbers, separated by spaces",
            );
        }
        Ok(found)
    }

    fn one(&self, node: Node<'a, '_>, kind: &'static str, class: &str, name: &str) -> Result<f64, ArmError> {
        Ok(self.numbers(node, kind, class, name)?.first().copied().unwrap_or(0.0))
    }

    /// Pose of an element in the frame of its body.
    fn place(&self, node: Node<'_, '_>) -> Result<Isometry3<f64>, ArmError> {
        let at = vector(node, "pos", Vector3::zeros())?;
        let all = |name: &str| -> Option<Vec<f64>> {
            node.attribute(name)?.split_whitespace().map(|word| word.parse().ok()).collect()
        };
        let angle = |value: f64| if self.is_degree { value.to_radians() } else { value };
        let turn = if let Some([w, x, y, z]) = all("quat").as_deref() {
            UnitQuaternion::from_quaternion(Quaternion::new(*w, *x, *y, *z))
        } else if let Some([x, y, z, a]) = all("axisangle").as_deref() {
            let axis = Unit::new_normalize(Vector3::new(*x, *y, *z));
            UnitQuaternion::from_axis_angle(&axis, angle(*a))
        } else if let Some([a, b, c]) = all("euler").as_deref() {
            // Intrinsic about x, y, z, unless the compiler element specifies another order.
            let about = |axis: &Unit<Vector3<f64>>, a: f64| UnitQuaternion::from_axis_angle(axis, angle(a));
            about(&Vector3::x_axis(), *a) * about(&Vector3::y_axis(), *b) * about(&Vector3::z_axis(), *c)
        } else if let Some([x1, x2, x3, y1, y2, y3]) = all("xyaxes").as_deref() {
            let x = Vector3::new(*x1, *x2, *x3).normalize();
            let y = Vector3::new(*y1, *y2, *y3);
            let y = (y - x * x.dot(&y)).normalize();
            let turn = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]));
            UnitQuaternion::from_rotation_matrix(&turn)
        } else {
            UnitQuaternion::identity()
        };
        if !turn.coords.iter().all(|x| x.is_finite()) || node.has_attribute("zaxis") {
            return wrong(node, "its orientation is not understood", "write it as `quat=\"w x y z\"`");
        }
        Ok(Isometry3::from_parts(Translation3::from(at), turn))
    }

    /// A body, with everything attached to it. `shift` is the offset of the parent's frame to its joint.
    fn body(
        &mut self,
        node: Node<'a, '_>,
        parent: &str,
        class: &str,
        shift: Vector3<f64>,
        depth: usize,
    ) -> Result<(), ArmError> {
        if depth > MOST_DEEP {
            return wrong(node, "bodies are nested too deeply", "flatten the tree");
        }
        let class = node.attribute("childclass").unwrap_or(class);
        let name =
            node.attribute("name").map_or_else(|| format!("body on line {}", line_of(node)), str::to_owned);
        let place = Translation3::from(-shift) * self.place(node)?;
        let joints: Vec<Node<'a, '_>> = node.children().filter(|node| node.has_tag_name("joint")).collect();
        if joints.len() > 1 {
            let what = format!("body `{name}` has {} joints", joints.len());
            return wrong(joints[1], what, "put a massless body between them, one joint in each");
        }
        let mut own = Vector3::zeros();
        let described = match joints.first() {
            None => fixed(node, parent, &name, place),
            Some(joint) => {
                own = vector(*joint, "pos", Vector3::zeros())?;
                self.joint(*joint, parent, &name, class, place * Translation3::from(own))?
            }
        };
        self.tree.add_joint(described);
        let inertial = match child(node, "inertial") {
            Some(inertial) => self.inertial(inertial, own)?,
            None => Inertial::none(),
        };
        self.tree.add_link(&name, Link::of(inertial));
        for inner in node.children().filter(|node| node.has_tag_name("body")) {
            self.body(inner, &name, class, own, depth + 1)?;
        }
        Ok(())
    }

    fn joint(
        &mut self,
        node: Node<'a, '_>,
        parent: &str,
        link: &str,
        class: &str,
        place: Isometry3<f64>,
    ) -> Result<Described, ArmError> {
        let name = node.attribute("name").map_or_else(|| link.to_owned(), str::to_owned);
        let mut kind = match self.attribute(node, "joint", class, "type") {
            None | Some("hinge") => JointKind::Continuous,
            Some("slide") => JointKind::Prismatic,
            Some(other) => {
                let what = format!("joint `{name}` is of type `{other}`, which is not simulated");
                return wrong(node, what, "make it a hinge or a slide");
            }
        };
        let axis = self.numbers(node, "joint", class, "axis")?;
        let axis = if let [x, y, z] = axis.as_slice() { Vector3::new(*x, *y, *z) } else { Vector3::z() };
        let Some(axis) = Unit::try_new(axis, 1e-9) else {
            return wrong(
                node,
                format!("the axis of joint `{name}` has no direction"),
                "write three numbers",
            );
        };
        let mut limits = [f64::NEG_INFINITY, f64::INFINITY];
        if let [low, high] = self.numbers(node, "joint", class, "range")?.as_slice() {
            let in_si = |x: f64| {
                if self.is_degree && kind != JointKind::Prismatic { x.to_radians() } else { x }
            };
            limits = [in_si(*low), in_si(*high)];
            if kind == JointKind::Continuous {
                kind = JointKind::Revolute;
            }
        }
        let belief = JointBelief {
            name: name.clone(),
            link: link.into(),
            armature: self.one(node, "joint", class, "armature")?,
            damping: self.one(node, "joint", class, "damping")?,
            friction: self.one(node, "joint", class, "frictionloss")?,
            ..JointBelief::default()
        };
        let joint = Joint {
            name,
            link: link.into(),
            kind,
            place,
            axis,
            limits,
            effort_limit: None,
            viscous_friction: belief.damping,
            dry_friction: belief.friction,
            inertial: Inertial::none(),
        };
        self.joints.push(belief);
        Ok(Described {
            line: line_of(node),
            parent: parent.into(),
            child: link.into(),
            kind: Some(kind),
            joint,
        })
    }

    fn inertial(&self, node: Node<'_, '_>, shift: Vector3<f64>) -> Result<Inertial, ArmError> {
        let mass_kg = crate::xml::number(node, "mass")?;
        let all = |name: &str| -> Option<Vec<f64>> {
            node.attribute(name)?.split_whitespace().map(|word| word.parse().ok()).collect()
        };
        let tensor = if let Some([xx, yy, zz, xy, xz, yz]) = all("fullinertia").as_deref() {
            Matrix3::new(*xx, *xy, *xz, *xy, *yy, *yz, *xz, *yz, *zz)
        } else if let Some([xx, yy, zz]) = all("diaginertia").as_deref() {
            Matrix3::from_diagonal(&Vector3::new(*xx, *yy, *zz))
        } else {
            return wrong(node, "this `inertial` states no inertia", "add `diaginertia` or `fullinertia`");
        };
        let place = Translation3::from(-shift) * self.place(node)?;
        let mut found = Inertial::none();
        found.add(&Inertial { mass_kg, centre_m: Vector3::zeros(), inertia_kg_m2: tensor }, &place);
        Ok(found)
    }

    /// Parameters of an actuator's loop at its joint.
    fn actuator(&mut self, node: Node<'_, '_>) -> Result<(), ArmError> {
        // The document's borrow outlives that of the iterator.
        let Some(node) = self.document.get_node(node.id()) else { return Ok(()) };
        let Some(joint) = node.attribute("joint") else { return Ok(()) };
        let Some(at) = self.joints.iter().position(|belief| belief.name == joint) else {
            let known: Vec<&str> = self.joints.iter().map(|belief| belief.name.as_str()).collect();
            let remedy = format!("name one of {}", known.join(", "));
            return wrong(node, format!("there is no joint `{joint}`"), remedy);
        };
        let (kind, is_position) = match node.tag_name().name() {
            "position" => ("position", true),
            "general" => ("general", false),
            "motor" => ("motor", false),
            _ => return Ok(()),
        };
        let one = |name: &str| self.one(node, kind, "main", name);
        if kind != "motor" {
            let remedy = "state `kp` and `kv` of the joint itself, and leave it out";
            let gear = self.numbers(node, kind, "main", "gear")?;
            if gear.first().is_some_and(|gear| (gear - 1.0).abs() > f64::EPSILON) {
                return wrong(node, "the `gear` of an actuator is not read", remedy);
            }
            if is_position && one("dampratio")? > 0.0 && one("kv")? <= 0.0 {
                return wrong(node, "a damping by `dampratio` is not read", remedy);
            }
        }
        let mut belief = self.joints[at].clone();
        if is_position {
            // MuJoCo's own default.
            let kp = self.numbers(node, kind, "main", "kp")?;
            belief.kp = Some(kp.first().copied().unwrap_or(1.0)).filter(|kp| *kp > 0.0);
            belief.kd = one("kv")?;
        } else if kind == "general" && self.attribute(node, kind, "main", "biastype") == Some("affine") {
            belief.kp = Some(one("gainprm")?).filter(|kp| *kp > 0.0);
            let bias = self.numbers(node, kind, "main", "biasprm")?;
            belief.kd = -bias.get(2).copied().unwrap_or(0.0);
        }
        belief.delay_s = one("delay")?;
        if let [low, high] = self.numbers(node, kind, "main", "forcerange")?.as_slice() {
            belief.effort_limit = Some(low.abs().max(high.abs())).filter(|limit| *limit > 0.0);
        }
        self.joints[at] = belief;
        Ok(())
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
mod tests {
    use super::*;

    const MODEL: &str = r#"<mujoco model="two"><compiler angle="degree"/>
      <default><joint damping="1" armature="0.5"/>
        <default class="servo"><joint frictionloss="0.2" armature="0.1"/>
          <position kp="20" kv="2" forcerange="-3 3"/></default></default>
      <worldbody><body name="base"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
        <body name="upper" pos="0 0 1" childclass="servo">
          <joint name="lift" axis="0 1 0" range="-90 90"/>
          <inertial pos="0.5 0 0" mass="2" diaginertia="0.01 0.02 0.03"/>
          <body name="fore" pos="1 0 0">
            <joint name="elbow" axis="0 1 0" pos="0.1 0 0"/>
            <inertial pos="0.3 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
          </body></body></body></worldbody>
      <actuator><position class="servo" joint="lift"/><motor joint="elbow"/></actuator></mujoco>"#;

    #[test]
    fn truth_classes_and_joints_off_the_body_are_understood() {
        let model = Mjcf::parse(MODEL).expect("a model");
        let lift = &model.joints[0];
        assert_eq!((lift.armature, lift.damping, lift.friction), (0.1, 1.0, 0.2));
        assert_eq!((lift.kp, lift.kd, lift.effort_limit), (Some(20.0), 2.0, Some(3.0)));
        assert_eq!(model.joints[1].kp, None);
        let chain = model.tree.chain("fore").expect("a chain");
        assert!((chain.joints[0].limits[1] - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        let mass = chain.mass_matrix(&[0.0, 0.0]);
        // About the lift: 0.02 + 2 (0.5)^2 + 0.01 + 1 (1.3)^2; about the elbow, at 1.1: 0.01 + 1 (0.2)^2.
        assert!((mass[(0, 0)] - 2.22).abs() < 1e-12 && (mass[(1, 1)] - 0.05).abs() < 1e-12, "{mass}");
    }

    #[test]
    fn truth_what_is_not_simulated_is_refused_with_its_line() {
        let ball = MODEL.replace("name=\"elbow\"", "name=\"elbow\" type=\"ball\"");
        let error = Mjcf::parse(&ball).expect_err("refused").to_string();
        assert!(error.contains("line 10") && error.contains("`ball`"), "{error}");
        assert!(Mjcf::parse("<robot/>").is_err());
    }
}
