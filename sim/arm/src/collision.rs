//! Collision geometry of links in a URDF.

use nalgebra::{Isometry3, Vector3};
use roxmltree::Node;

use crate::error::ArmError;
use crate::xml::{attribute, child, line_of, number, origin, vector, wrong};

/// A shape of a link, for detecting collisions.
#[derive(Clone, Debug, PartialEq)]
pub struct Collision {
    pub shape: CollisionShape,
    /// Its pose in the frame of the body that carries it.
    pub place: Isometry3<f64>,
    /// The line of the URDF, from 1.
    pub line: u32,
}

/// Shapes of a URDF, centred on their origin.
#[derive(Clone, Debug, PartialEq)]
pub enum CollisionShape {
    Box {
        half_extents_m: [f64; 3],
    },
    /// A cylinder along z.
    Cylinder {
        radius_m: f64,
        half_length_m: f64,
    },
    Sphere {
        radius_m: f64,
    },
    /// The triangles of a file.
    Mesh {
        /// The file as written, with its scheme if it has one.
        file: String,
        /// Length of the file's unit in x, y and z, m.
        scale_m: [f64; 3],
    },
}

/// The collision shapes of a link, in its frame.
pub(crate) fn of_link(link: Node<'_, '_>) -> Result<Vec<Collision>, ArmError> {
    let nodes = link.children().filter(|node| node.has_tag_name("collision"));
    let shape = |node: Node<'_, '_>| -> Result<Option<Collision>, ArmError> {
        let Some(geometry) = child(node, "geometry") else {
            return wrong(node, "this `<collision>` has no `<geometry>`", "add one with a shape");
        };
        let Some(shape) = geometry.children().find(Node::is_element) else {
            return wrong(geometry, "this `<geometry>` is empty", "add a shape to it");
        };
        let Some(found) = of_geometry(shape)? else { return Ok(None) };
        Ok(Some(Collision { shape: found, place: origin(node)?, line: line_of(shape) }))
    };
    nodes.filter_map(|node| shape(node).transpose()).collect()
}

fn of_geometry(node: Node<'_, '_>) -> Result<Option<CollisionShape>, ArmError> {
    let positive = |name: &str| match number(node, name)? {
        value if value > 0.0 => Ok(value),
        value => wrong(node, format!("`{name}` of this shape is {value}"), "write a number above zero"),
    };
    Ok(Some(match node.tag_name().name() {
        "box" => {
            let size = vector(node, "size", Vector3::zeros())?;
            if size.min() <= 0.0 {
                return wrong(
                    node,
                    "the `size` of this box is not above zero",
                    "write three numbers above zero",
                );
            }
            CollisionShape::Box { half_extents_m: (0.5 * size).into() }
        }
        "cylinder" => CollisionShape::Cylinder {
            radius_m: positive("radius")?,
            half_length_m: 0.5 * positive("length")?,
        },
        "sphere" => CollisionShape::Sphere { radius_m: positive("radius")? },
        "mesh" => CollisionShape::Mesh {
            file: attribute(node, "filename")?.into(),
            scale_m: vector(node, "scale", Vector3::repeat(1.0))?.into(),
        },
        // Shapes of other dialects are ignored here.
        _ => return Ok(None),
    }))
}
