//! The unit of a key, as axes of drawings name it.

use feeler_plant::description::Axis;
use feeler_plant::units::Dimension;

use super::super::keys::{EFFECTS, ELEMENTS, RUN};
use super::super::shape::{Kind, Shape, Unit};

/// The SI unit of the number at a key path, of a machine whose axis is of this kind; empty where it has none, or one that depends on more than the key.
pub fn unit_of_key(path: &str, axis: Axis) -> String {
    let turns = axis == Axis::Rotational;
    let parts: Vec<&str> = path.split('.').collect();
    let of = |shape: &'static Shape, name: &str| {
        shape.all_keys().find(|key| key.name == name).and_then(|key| match key.kind {
            Kind::Quantity(Unit::Of(dimension), _) => Some(dimension.si_unit(turns).to_owned()),
            Kind::Quantity(Unit::PowerStiffness, _) => Some(Dimension::STIFFNESS.si_unit(turns).to_owned()),
            _ => None,
        })
    };
    let found = match parts.as_slice() {
        [_, _, EFFECTS, kind, parameter] => crate::sweep::unit_of_effect(kind, parameter, turns).map(str::to_owned),
        ["run", name] => of(&RUN, name),
        ["contacts", _, "stiffness"] => Some(Dimension::STIFFNESS.si_unit(turns).to_owned()),
        [table, _, name] => {
            let element = ELEMENTS.iter().find(|element| element.table == *table);
            element.and_then(|element| of(&element.shape, name))
        }
        _ => None,
    };
    found.unwrap_or_default()
}
