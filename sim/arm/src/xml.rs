//! Numbers and places in the elements of a URDF.

use std::borrow::Cow;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use roxmltree::Node;

use crate::error::ArmError;

pub(crate) fn line_of(node: Node<'_, '_>) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

pub(crate) fn wrong<T>(
    node: Node<'_, '_>,
    what: impl Into<String>,
    remedy: impl Into<Cow<'static, str>>,
) -> Result<T, ArmError> {
    Err(ArmError::Urdf { line: line_of(node), what: what.into(), remedy: remedy.into() })
}

pub(crate) fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|child| child.has_tag_name(tag))
}

/// A required attribute.
pub(crate) fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Result<&'a str, ArmError> {
    node.attribute(name).map_or_else(
        || wrong(node, format!("`<{}>` has no `{name}`", node.tag_name().name()), format!("add `{name}`")),
        Ok,
    )
}

pub(crate) fn number(node: Node<'_, '_>, name: &str) -> Result<f64, ArmError> {
    let text = attribute(node, name)?;
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => {
            wrong(node, format!("`{name}=\"{text}\"` is not a finite number"), "write a number such as 0.25")
        }
    }
}

pub(crate) fn optional_number(node: Node<'_, '_>, name: &str) -> Result<Option<f64>, ArmError> {
    if node.has_attribute(name) { number(node, name).map(Some) } else { Ok(None) }
}

pub(crate) fn vector(node: Node<'_, '_>, name: &str, absent: Vector3<f64>) -> Result<Vector3<f64>, ArmError> {
    let Some(text) = node.attribute(name) else { return Ok(absent) };
    let numbers: Vec<f64> = text
        .split_whitespace()
        .filter_map(|word| word.parse().ok())
        .filter(|x: &f64| x.is_finite())
        .collect();
    match numbers.as_slice() {
        [x, y, z] if text.split_whitespace().count() == 3 => Ok(Vector3::new(*x, *y, *z)),
        _ => wrong(
            node,
            format!("`{name}=\"{text}\"` is not three finite numbers"),
            "write three numbers, separated by spaces",
        ),
    }
}

/// The `origin` of a node; the identity if it has none.
pub(crate) fn origin(node: Node<'_, '_>) -> Result<Isometry3<f64>, ArmError> {
    let Some(origin) = child(node, "origin") else { return Ok(Isometry3::identity()) };
    let xyz = vector(origin, "xyz", Vector3::zeros())?;
    let rpy = vector(origin, "rpy", Vector3::zeros())?;
    Ok(Isometry3::from_parts(Translation3::from(xyz), UnitQuaternion::from_euler_angles(rpy.x, rpy.y, rpy.z)))
}
