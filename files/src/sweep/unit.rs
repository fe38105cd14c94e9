//! The unit of a key, for axes of drawings.

use feeler_catalogue::{Dimension, KeyKind, Keys, Unit};
use feeler_engine::Scenario;
use feeler_plant::description::Axis;
use feeler_plant::effects;

use super::super::keys::{CONTROLLERS, EFFECTS, ELEMENTS, RUN, RUN_TABLE};

const TIME: Unit = Unit::Of(Dimension::TIME);

/// The SI unit of the number at a key path of a scenario; empty if it has none.
pub(crate) fn unit_of_key(path: &str, scenario: &Scenario) -> String {
    let turns = scenario.machine.axis == Axis::Rotational;
    let parts: Vec<&str> = path.split('.').collect();
    let found = match parts.as_slice() {
        [_, _, EFFECTS, kind, parameter] => {
            return unit_of_effect(kind, parameter, turns).unwrap_or_default();
        }
        [RUN_TABLE, rest @ ..] => unit(&RUN, None, rest).map(|unit| (unit, "")),
        [table, name, rest @ ..] => {
            let law = scenario
                .controllers
                .get(*name)
                .filter(|_| *table == CONTROLLERS.table)
                .map(|used| used.spec.law.name());
            let element = ELEMENTS.iter().find(|element| element.table == *table);
            element.and_then(|element| unit(&element.shape, law, rest)).map(|unit| (unit, *name))
        }
        _ => None,
    };
    let Some((unit, dimension)) =
        found.and_then(|(unit, name)| Some((unit, dimension(unit, name, scenario)?)))
    else {
        return String::new();
    };
    match unit {
        _ if dimension.is(Dimension::NONE) => String::new(),
        // A gain divided by a time is not a frequency.
        Unit::OutputPer(_) if dimension.is(Dimension::FREQUENCY) => "1/s".into(),
        _ => dimension.si_unit(turns).into_owned(),
    }
}

/// The unit of an effect's parameter by its key path.
fn unit_of_effect(kind: &str, parameter: &str, turns: bool) -> Option<String> {
    let parameter = effects::find(kind)?.parameters.iter().find(|known| known.name == parameter)?;
    Some(parameter.dimension.si_unit(turns).into_owned())
}

/// The unit of a key in a shape, or in a table within it. If several variants have the key, `variant` selects
/// one.
fn unit(shape: &'static Keys, variant: Option<&str>, path: &[&str]) -> Option<Unit> {
    let (name, rest) = path.split_first()?;
    let chosen =
        shape.choice.iter().flat_map(|choice| choice.variants).find(|known| Some(known.name) == variant);
    let of_variant = chosen.and_then(|variant| variant.keys.iter().find(|key| key.name == *name));
    let key = of_variant.or_else(|| shape.all_keys().find(|key| key.name == *name))?;
    match (key.kind, rest) {
        // Entries of lists count from zero. The first number of a point is the time.
        (KeyKind::Points(_) | KeyKind::Reference(_), [point, "0"]) if is_place(point) => Some(TIME),
        (KeyKind::Reference(_), [point, _]) if is_place(point) => Some(Unit::Reference),
        (KeyKind::Quantity(unit, _) | KeyKind::QuantityOrTable(_, unit, _), [])
        | (KeyKind::Numbers(unit, _) | KeyKind::Range(unit), [_])
        | (KeyKind::Points(unit), [_, _]) => Some(unit),
        (KeyKind::Reference(_), []) => Some(Unit::Reference),
        (
            KeyKind::Table(shape)
            | KeyKind::QuantityOrTable(_, _, shape)
            | KeyKind::WordOrTable(_, shape)
            | KeyKind::Reference(shape),
            rest,
        ) => unit(shape, None, rest),
        _ => None,
    }
}

/// Whether a part of a key is the index of a list entry.
fn is_place(part: &str) -> bool {
    part.parse::<usize>().is_ok()
}

fn dimension(unit: Unit, name: &str, scenario: &Scenario) -> Option<Dimension> {
    let machine = &scenario.machine;
    let output = || {
        let actuator = machine.actuators.get(&scenario.controllers.get(name)?.drives)?;
        Some(actuator.kind.command())
    };
    match unit {
        Unit::Of(dimension) => Some(dimension),
        Unit::Pressure => Some(Dimension::power_stiffness(2.0)),
        Unit::PowerStiffness => Some(Dimension::STIFFNESS),
        Unit::Output => output(),
        Unit::OutputPer(dimension) => Some(output()? / dimension),
        Unit::Reference => dimension(scenario.controllers.get(name)?.spec.law.follows(), name, scenario),
        Unit::Signal => machine.sensors.get(name)?.reads.quantity.dimension(),
        Unit::Swept => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Document;

    fn scenario(file: &str) -> Scenario {
        Document::load(&std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")).join(file))
            .unwrap()
            .scenario
    }

    /// A gain is a command per newton: a force for a force drive, a velocity for a velocity drive.
    #[test]
    fn regress_a_gain_has_the_unit_that_its_law_and_drive_give_it() {
        let (force, velocity) = (scenario("chatter/sustained.toml"), scenario("paper/rigid-source.toml"));
        for (path, of_force, of_velocity) in [
            ("controllers.force.kp", "", "m/(N s)"),
            ("controllers.force.ki", "1/s", "m/(N s^2)"),
            ("controllers.force.reference", "N", "N"),
            ("controllers.force.reference.1.0", "s", "s"),
            ("controllers.force.reference.1.1", "N", "N"),
            ("controllers.force.reference.points.1.0", "s", "s"),
            ("controllers.force.reference.points.1.1", "N", "N"),
            ("controllers.force.reference.band.0", "Hz", "Hz"),
            ("contacts.tool.profile.offset.1.1", "m", "m"),
            ("controllers.force.delay", "s", "s"),
            ("controllers.force.approach.speed", "m/s", "m/s"),
            ("sensors.force.noise", "N", "N"),
            ("contacts.tool.stiffness", "N/m", "N/m"),
            ("run.duration", "s", "s"),
            ("run.seed", "", ""),
        ] {
            assert_eq!(unit_of_key(path, &force), of_force, "{path}");
            assert_eq!(unit_of_key(path, &velocity), of_velocity, "{path}");
        }
    }
}
