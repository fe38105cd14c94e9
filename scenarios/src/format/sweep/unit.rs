//! The unit of a key, as axes of drawings name it.

use super::super::keys::{EFFECTS, ELEMENTS, RUN};
use super::super::shape::{Kind, Shape, Unit};

/// The SI unit of the number at a key path, on a translational axis; empty where it has none, or one that depends on more than the key.
pub fn unit_of_key(path: &str) -> String {
    let parts: Vec<&str> = path.split('.').collect();
    let of = |shape: &'static Shape, name: &str| {
        shape.all_keys().find(|key| key.name == name).and_then(|key| match key.kind {
            Kind::Quantity(Unit::Of(dimension), _) => Some(dimension.si_unit(false).to_owned()),
            Kind::Quantity(Unit::PowerStiffness, _) => Some("N/m".to_owned()),
            _ => None,
        })
    };
    let found = match parts.as_slice() {
        [_, _, EFFECTS, kind, parameter] => crate::sweep::unit_of_effect(kind, parameter).map(str::to_owned),
        ["run", name] => of(&RUN, name),
        ["contacts", _, "stiffness"] => Some("N/m".to_owned()),
        [table, _, name] => {
            let element = ELEMENTS.iter().find(|element| element.table == *table);
            element.and_then(|element| of(&element.shape, name))
        }
        _ => None,
    };
    found.unwrap_or_default()
}
