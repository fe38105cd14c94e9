//! Attributes of elements: numbers, poses, and the ones that are known.

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};
use roxmltree::Node;

use super::known;
use crate::error::ArmError;
use crate::xml::{line_of, wrong};

/// Attributes that turn a frame; an element has at most one.
const TURNS: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];

/// How the file counts angles.
#[derive(Clone, Debug)]
pub(super) struct Angles {
    pub(super) is_degree: bool,
    /// Axes of Euler angles: lower case about the turned axes, upper case about the fixed ones.
    pub(super) sequence: Vec<char>,
}

impl Angles {
    pub(super) fn in_radians(&self, angle: f64) -> f64 {
        if self.is_degree { angle.to_radians() } else { angle }
    }
}

/// Numbers of a text.
pub(super) fn numbers_of(node: Node<'_, '_>, name: &str, text: &str) -> Result<Vec<f64>, ArmError> {
    let found: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    if found.len() != text.split_whitespace().count() || found.iter().any(|x| !x.is_finite()) {
        let what = format!("`{name}=\"{text}\"` is not a list of numbers");
        return wrong(node, what, "write numbers, separated by spaces");
    }
    Ok(found)
}

/// Exactly `N` numbers of a text.
pub(super) fn exactly<const N: usize>(
    node: Node<'_, '_>,
    name: &str,
    text: &str,
) -> Result<[f64; N], ArmError> {
    let found = numbers_of(node, name, text)?;
    let count = found.len();
    <[f64; N]>::try_from(found)
        .or_else(|_| wrong(node, format!("`{name}=\"{text}\"` has {count} numbers"), format!("write {N}")))
}

/// Pose of an element in the frame of its body. `find` gives an attribute of the element or its class.
pub(super) fn place<'a>(
    node: Node<'_, '_>,
    angles: &Angles,
    find: &impl Fn(&str) -> Option<&'a str>,
) -> Result<Isometry3<f64>, ArmError> {
    let at = find("pos").map_or(Ok([0.0; 3]), |text| exactly(node, "pos", text))?;
    let own = TURNS.into_iter().find(|name| node.has_attribute(*name));
    let Some(name) = own.or_else(|| TURNS.into_iter().find(|name| find(name).is_some())) else {
        return Ok(Isometry3::from(Translation3::from(Vector3::from(at))));
    };
    let text = find(name).unwrap_or_default();
    let turn = match name {
        "quat" => {
            let [w, x, y, z] = exactly(node, name, text)?;
            UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
        }
        "axisangle" => {
            let [x, y, z, angle] = exactly(node, name, text)?;
            let axis = Unit::new_normalize(Vector3::new(x, y, z));
            UnitQuaternion::from_axis_angle(&axis, angles.in_radians(angle))
        }
        "euler" => {
            let each: [f64; 3] = exactly(node, name, text)?;
            euler(angles, each)
        }
        "xyaxes" => {
            let [x1, x2, x3, y1, y2, y3] = exactly(node, name, text)?;
            let x = Vector3::new(x1, x2, x3).normalize();
            let y = Vector3::new(y1, y2, y3);
            let y = (y - x * x.dot(&y)).normalize();
            let turn = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]));
            UnitQuaternion::from_rotation_matrix(&turn)
        }
        _ => {
            let z: [f64; 3] = exactly(node, name, text)?;
            onto(&Vector3::from(z))
        }
    };
    if !turn.coords.iter().all(|x| x.is_finite()) {
        return wrong(
            node,
            format!("`{name}=\"{text}\"` has no direction"),
            "write it as `quat=\"w x y z\"`",
        );
    }
    Ok(Isometry3::from_parts(Translation3::from(Vector3::from(at)), turn))
}

fn euler(angles: &Angles, each: [f64; 3]) -> UnitQuaternion<f64> {
    angles.sequence.iter().zip(each).fold(UnitQuaternion::identity(), |turn, (axis, angle)| {
        let about = match axis.to_ascii_lowercase() {
            'x' => Vector3::x_axis(),
            'y' => Vector3::y_axis(),
            _ => Vector3::z_axis(),
        };
        let next = UnitQuaternion::from_axis_angle(&about, angles.in_radians(angle));
        if axis.is_lowercase() { turn * next } else { next * turn }
    })
}

/// The shortest turn that brings z to a direction. Of the turns onto -z it is the one about x, as in MuJoCo.
pub(super) fn onto(z: &Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(&Vector3::z(), z)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI))
}

/// Attributes and elements that change motions but are not read, each once.
#[derive(Debug, Default)]
pub(super) struct Remarks {
    /// Its name, its first line, and the remark.
    found: Vec<(String, u32, String)>,
}

impl Remarks {
    pub(super) fn add(&mut self, node: Node<'_, '_>, what: impl Into<String>, follows: &str) {
        let what = what.into();
        if !self.found.iter().any(|(other, ..)| *other == what) {
            let line = line_of(node);
            self.found.push((what.clone(), line, format!("line {line}: {what} is not read: {follows}")));
        }
    }

    /// In the order of the file.
    pub(super) fn texts(mut self) -> Vec<String> {
        self.found.sort_by_key(|(_, line, _)| *line);
        self.found.into_iter().map(|(.., text)| text).collect()
    }

    /// Checks every attribute of an element of a kind against those that are known.
    pub(super) fn check(&mut self, node: Node<'_, '_>, kind: &str) -> Result<(), ArmError> {
        for attribute in node.attributes() {
            let (name, value) = (attribute.name(), attribute.value().trim());
            match known::attribute(kind, name) {
                known::Use::Read | known::Use::Idle => {}
                known::Use::Remark { unless, follows } => {
                    if !is_same(value, unless) {
                        self.add(node, format!("`{name}` of `<{kind}>`"), follows);
                    }
                }
                known::Use::Refused { unless } => {
                    if unless.is_none_or(|unless| !is_same(value, unless)) {
                        let what = format!("`{name}=\"{value}\"` of `<{kind}>` is not read");
                        return wrong(node, what, known::SAVE);
                    }
                }
            }
        }
        Ok(())
    }
}

/// Whether a value is the neutral one: the same word, or as many times its number.
fn is_same(value: &str, neutral: &str) -> bool {
    value == neutral
        || neutral.parse::<f64>().is_ok_and(|neutral| {
            // Equal as numbers: `0.0` and `0` are the same text to MuJoCo.
            value.split_whitespace().all(|word| word.parse::<f64>().is_ok_and(|x| (x - neutral).abs() == 0.0))
        })
}
