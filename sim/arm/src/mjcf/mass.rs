//! Mass and inertia of bodies: as stated, or from their shapes.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix3, Translation3, Vector3};
use roxmltree::Node;

use super::read::{Angles, exactly, numbers_of, onto, place};
use crate::chain::Inertial;
use crate::error::ArmError;
use crate::xml::wrong;

/// That of a shape that states neither mass nor density, kg/m3: water.
const DENSITY: f64 = 1000.0;
/// The triangle inequality of principal moments holds within this share, because inertias are rounded.
const INERTIA_ROUNDING: f64 = 1e-3;

/// When the shapes of a body give its inertia.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FromShapes {
    Never,
    /// In bodies without an `inertial`.
    Where,
    Always,
}

/// That of an `inertial`, in the frame around it.
pub(super) fn stated(node: Node<'_, '_>, angles: &Angles) -> Result<Inertial, ArmError> {
    let mass_kg = crate::xml::number(node, "mass")?;
    if mass_kg < 0.0 {
        return wrong(node, format!("its mass is {mass_kg} kg"), "write a mass of zero or more");
    }
    let tensor = if let Some(text) = node.attribute("fullinertia") {
        let [xx, yy, zz, xy, xz, yz] = exactly(node, "fullinertia", text)?;
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    } else if let Some(text) = node.attribute("diaginertia") {
        Matrix3::from_diagonal(&Vector3::from(exactly(node, "diaginertia", text)?))
    } else {
        return wrong(node, "this `inertial` states no inertia", "add `diaginertia` or `fullinertia`");
    };
    let mut principal = tensor.symmetric_eigenvalues();
    principal.as_mut_slice().sort_by(f64::total_cmp);
    let [a, b, c] = [principal[0], principal[1], principal[2]];
    if a < 0.0 || c > (a + b) * (1.0 + INERTIA_ROUNDING) {
        let what = format!("the principal moments {a}, {b}, {c} kg m2 are impossible");
        return wrong(node, what, "give the inertia of its shape");
    }
    let mut found = Inertial::none();
    let place = place(node, angles, &|name: &str| node.attribute(name))?;
    found.add(&Inertial { mass_kg, centre_m: Vector3::zeros(), inertia_kg_m2: tensor }, &place);
    Ok(found)
}

/// The inertia of one shape in the frame of its body. `None` if it has no mass.
pub(super) fn of_shape<'a>(
    node: Node<'_, '_>,
    angles: &Angles,
    find: &impl Fn(&str) -> Option<&'a str>,
) -> Result<Option<Inertial>, ArmError> {
    let one = |name: &str| -> Result<Option<f64>, ArmError> {
        find(name).map(|text| exactly::<1>(node, name, text).map(|[x]| x)).transpose()
    };
    let (mass, density) = (one("mass")?, one("density")?.unwrap_or(DENSITY));
    if mass.unwrap_or(density) == 0.0 {
        return Ok(None);
    }
    if mass.unwrap_or(density) < 0.0 {
        return wrong(node, "its mass or density is below zero", "write zero or more");
    }
    let kind = find("type").unwrap_or("sphere");
    if find("mesh").is_some() || ["mesh", "sdf", "hfield"].contains(&kind) {
        let what = "the body has no `inertial`, and one from a mesh is not computed";
        let remedy = "add `<inertial>`; MuJoCo saves one if `<compiler>` has `saveinertial=\"true\"`";
        return wrong(node, what, remedy);
    }
    let mut size = find("size").map_or(Ok(Vec::new()), |text| numbers_of(node, "size", text))?;
    let mut at = place(node, angles, find)?;
    if let Some(text) = find("fromto") {
        let [ax, ay, az, bx, by, bz] = exactly(node, "fromto", text)?;
        let (a, b) = (Vector3::new(ax, ay, az), Vector3::new(bx, by, bz));
        // The width counts for both directions across.
        let width = size.first().copied().unwrap_or(0.0);
        let half = 0.5 * (b - a).norm();
        size = match kind {
            "capsule" | "cylinder" => vec![width, half],
            "box" | "ellipsoid" => vec![width, width, half],
            _ => return wrong(node, format!("a {kind} has no `fromto`"), "state its `pos` and `size`"),
        };
        at = Isometry3::from_parts(Translation3::from(0.5 * (a + b)), onto(&(a - b)));
    }
    let need = |count: usize| -> Result<(), ArmError> {
        if size.len() >= count && size[..count].iter().all(|x| *x > 0.0) {
            return Ok(());
        }
        wrong(node, format!("the `size` of a {kind} needs {count} numbers above zero"), "add them")
    };
    let (volume, per_mass) = match kind {
        "sphere" => {
            need(1)?;
            ellipsoid([size[0]; 3])
        }
        "ellipsoid" => {
            need(3)?;
            ellipsoid([size[0], size[1], size[2]])
        }
        "box" => {
            need(3)?;
            let [a, b, c] = [size[0], size[1], size[2]].map(|x| x * x / 3.0);
            (8.0 * size[0] * size[1] * size[2], Vector3::new(b + c, a + c, a + b))
        }
        "cylinder" => {
            need(2)?;
            cylinder(size[0], size[1])
        }
        "capsule" => {
            need(2)?;
            capsule(size[0], size[1])
        }
        _ => return wrong(node, format!("a {kind} gives no inertia"), "add `<inertial>` to its body"),
    };
    let mass_kg = mass.unwrap_or(density * volume);
    let inertia_kg_m2 = Matrix3::from_diagonal(&(mass_kg * per_mass));
    let mut found = Inertial::none();
    found.add(&Inertial { mass_kg, centre_m: Vector3::zeros(), inertia_kg_m2 }, &at);
    Ok(Some(found))
}

/// Volume of a shape, and its principal moments over its mass.
type Shape = (f64, Vector3<f64>);

fn ellipsoid(half: [f64; 3]) -> Shape {
    let [a, b, c] = half.map(|x| x * x / 5.0);
    (4.0 / 3.0 * PI * half.iter().product::<f64>(), Vector3::new(b + c, a + c, a + b))
}

fn cylinder(radius: f64, half: f64) -> Shape {
    let (r2, h2) = (radius * radius, half * half);
    let across = r2 / 4.0 + h2 / 3.0;
    (2.0 * PI * r2 * half, Vector3::new(across, across, r2 / 2.0))
}

/// A cylinder with half a sphere on each end.
fn capsule(radius: f64, half: f64) -> Shape {
    let (middle, of_middle) = cylinder(radius, half);
    let (ends, of_ends) = ellipsoid([radius; 3]);
    // The centre of half a sphere is 3/8 of its radius from its face.
    let off = half * half + 0.75 * half * radius;
    let of_ends = of_ends + Vector3::new(off, off, 0.0);
    (middle + ends, (middle * of_middle + ends * of_ends) / (middle + ends))
}
