//! The parts of a body.

use nalgebra::Isometry3;
use roxmltree::Node;

use super::read::{Angles, place};
use crate::error::ArmError;

/// A joint, shape or `inertial` of a body, perhaps inside frames.
pub(super) struct Part<'a, 'i> {
    pub(super) node: Node<'a, 'i>,
    pub(super) class: String,
    /// Frame around it, in that of the body.
    pub(super) frame: Isometry3<f64>,
}

impl Part<'_, '_> {
    pub(super) fn is(&self, tag: &str) -> bool {
        self.node.has_tag_name(tag)
    }
}

/// The parts of a body, those in its frames included.
pub(super) fn parts<'a, 'i>(
    body: Node<'a, 'i>,
    class: &str,
    angles: &Angles,
) -> Result<Vec<Part<'a, 'i>>, ArmError> {
    let mut found = Vec::new();
    let mut open = vec![(body, class.to_owned(), Isometry3::identity())];
    while let Some((node, class, frame)) = open.pop() {
        for inner in node.children().filter(Node::is_element) {
            if inner.has_tag_name("frame") {
                let at = frame * place(inner, angles, &|name: &str| inner.attribute(name))?;
                let class = inner.attribute("childclass").unwrap_or(&class).to_owned();
                open.push((inner, class, at));
            } else if ["joint", "geom", "inertial"].iter().any(|tag| inner.has_tag_name(*tag)) {
                found.push(Part { node: inner, class: class.clone(), frame });
            }
        }
    }
    Ok(found)
}
