//! The axis along the normal, as a machine. It has the contact, sensors, controller and run of a whole arm's
//! scenario, with the bodies and the drive between them.

use feeler_arm::Reduction;
use feeler_catalogue::Key;
use feeler_engine::{ControllerUse, RunSettings};
use feeler_plant::description::{
    Actuator, Body, Contact, GROUND, Machine, Quantity, Sensor, SignalName, Spring,
};
use feeler_plant::effects::{Kind, find};

use crate::draft::Draft;
use crate::keys::cell::ARM_FILE;
use crate::keys::surface::{PROFILE, SURFACE};
use crate::keys::{ABOUT, CONTACTS, CONTROLLERS, EFFECTS, Element, NAME, RUN_TABLE, SENSORS, SHARED};
use crate::parse::parse_toml;
use crate::problem::Problems;
use crate::read::join;
use crate::source::{Origin, Sources};
use crate::tree::{Entry, Node, Table, Value};
use crate::write::machine_to_toml;

const MOTOR: &str = "motor";
const TIP: &str = "tip";
const DRIVE: &str = "drive";
const ENCODER: &str = "encoder";

/// Effects of a contact that are valid for shapes in space.
pub(crate) const OF_CONTACTS: [Kind; 6] = [
    Kind::ContactStiffness,
    Kind::ContactDamping,
    Kind::HuntCrossleyContact,
    Kind::HertzContact,
    Kind::HardeningStiffness,
    Kind::SurfaceOffset,
];
/// Effects of sensors that are not valid, with the reason.
pub(crate) const NOT_OF_SENSORS: [(Kind, &str); 1] =
    [(Kind::ToolInertia, "the wrist sensor is taken as massless beyond it")];
/// Keys that are not valid for a whole arm: table, key, and the alternative.
const NOT_HERE: [(&str, Key, &str); 10] = [
    (CONTACTS.table, Contact::BETWEEN.key, "the contact is between `[tip]` and `[workpiece]`"),
    (CONTACTS.table, Contact::ENGAGEMENT.key, "the contact pushes only"),
    (CONTACTS.table, SURFACE, "`[tip]` and `[workpiece]` have the shapes"),
    (CONTACTS.table, PROFILE, "`[tip]` and `[workpiece]` have the shapes"),
    (SENSORS.table, Sensor::RELATIVE_TO.key, "the base stands still"),
    (CONTROLLERS.table, ControllerUse::DRIVES.key, "the controller drives the force along the normal"),
    (RUN_TABLE, RunSettings::ENGINE.key, "arms have one engine"),
    (RUN_TABLE, RunSettings::INTEGRATOR.key, "arms have one integrator"),
    (RUN_TABLE, RunSettings::RECORD.key, "everything is recorded"),
    (RUN_TABLE, RunSettings::ENERGY.key, "no energy ledger is kept of an arm"),
];

/// A scenario of the axis, as a draft; `None` if there are mistakes, or no axis is known.
pub(super) fn draft(draft: &Draft, reduction: Option<&Reduction>, problems: &mut Problems) -> Option<Draft> {
    let before = problems.count();
    let top = draft.top();
    let place = draft.root.get(ARM_FILE.name).map_or(top.clone(), |entry| entry.key.clone());
    let kept = |name: &str| [NAME.name, ABOUT.name].contains(&name) || SHARED.contains(&name);
    let mut root: Table = (draft.root.iter())
        .filter(|(name, _)| kept(name))
        .map(|(name, entry)| (name.clone(), entry.clone()))
        .collect();
    refuse_keys(&root, problems);
    only_one(&root, &CONTACTS, &top, problems);
    only_one(&root, &CONTROLLERS, &top, problems);
    refuse_effects(&root, problems);
    refuse_sources(&root, problems);
    let axis = reduction.filter(|_| problems.count() == before)?;
    let text = |text: &str| Node { value: Value::Text(text.into()), origin: place.clone() };
    let ends = Value::Array([TIP, GROUND].map(text).into());
    let ends = Node { value: ends, origin: place.clone() };
    for (table, key, node) in
        [(&CONTACTS, Contact::BETWEEN.key, ends), (&CONTROLLERS, ControllerUse::DRIVES.key, text(DRIVE))]
    {
        let elements = root.get_mut(table.table).and_then(|entry| entry.node.as_table_mut());
        for element in elements.into_iter().flat_map(Table::values_mut) {
            if let Some(keys) = element.node.as_table_mut() {
                keys.insert(key.name.into(), Entry { key: place.clone(), node: node.clone() });
            }
        }
    }
    let made = parse_toml(&machine_to_toml(&machine(axis)), "", &mut Sources::default()).ok()?;
    for (name, mut made) in made {
        made.node.replace(&|at: &mut Origin| *at = place.clone());
        let Value::Table(elements) = made.node.value else { continue };
        let empty = Entry { key: place.clone(), node: Node::table(place.clone()) };
        if let Some(own) = root.entry(name).or_insert(empty).node.as_table_mut() {
            // Keys of an element in the file take precedence.
            for (element, entry) in elements {
                own.entry(element).or_insert(entry);
            }
        }
    }
    Some(Draft { sources: draft.sources.clone(), root, main: draft.main, gaps: draft.gaps.clone() })
}

/// The bodies and the drive between them, with the motor's encoder.
fn machine(axis: &Reduction) -> Machine {
    Machine::default()
        .with_body(MOTOR, Body::new(axis.motor_mass_kg))
        .with_body(TIP, Body::new(axis.tip_mass_kg))
        .with_spring("transmission", Spring::new(MOTOR, TIP, axis.stiffness_n_per_m, axis.damping_n_s_per_m))
        .with_actuator(DRIVE, Actuator::ideal(MOTOR, GROUND))
        .with_sensor(ENCODER, Sensor::ideal(SignalName::new(MOTOR, Quantity::Position)))
}

fn elements<'t>(root: &'t Table, name: &str) -> impl Iterator<Item = (&'t String, &'t Table)> {
    let tables = root.get(name).and_then(|entry| entry.node.as_table());
    tables.into_iter().flatten().filter_map(|(name, entry)| Some((name, entry.node.as_table()?)))
}

fn refuse_keys(root: &Table, problems: &mut Problems) {
    for (table, key, instead) in NOT_HERE {
        let run = root.get(table).filter(|_| table == RUN_TABLE).and_then(|entry| entry.node.as_table());
        let of_elements = elements(root, table).map(|(name, keys)| (join(table, name), keys));
        for (path, keys) in run.map(|keys| (table.to_owned(), keys)).into_iter().chain(of_elements) {
            if let Some(entry) = keys.get(key.name) {
                let path = join(&path, key.name);
                let message = format!("`{}` has no meaning for a whole arm: {instead}", key.name);
                problems.add(&entry.key, path, message, "remove it");
            }
        }
    }
}

fn only_one(root: &Table, element: &Element, top: &Origin, problems: &mut Problems) {
    let Element { table, singular, .. } = *element;
    let count = elements(root, table).count();
    if count != 1 {
        let at = root.get(table).map_or(top, |entry| &entry.key);
        let remedy = if count == 0 { format!("add [{table}.NAME]") } else { format!("keep one {singular}") };
        problems.add(at, table, format!("a whole arm has one {singular}, and here are {count}"), remedy);
    }
}

fn refuse_effects(root: &Table, problems: &mut Problems) {
    for name in [CONTACTS.table, SENSORS.table] {
        for (element, table) in elements(root, name) {
            let effects = table.get(EFFECTS).and_then(|entry| entry.node.as_table());
            for (kind, entry) in effects.into_iter().flatten() {
                // An unknown name is rejected with the nearest known one.
                let Some(definition) = find(kind) else { continue };
                let why = match name {
                    _ if name == CONTACTS.table && !OF_CONTACTS.contains(&definition.kind) => {
                        format!("contacts of a whole arm take {}", OF_CONTACTS.map(Kind::name).join(", "))
                    }
                    _ if name == SENSORS.table => {
                        match NOT_OF_SENSORS.iter().find(|(other, _)| *other == definition.kind) {
                            Some((_, why)) => (*why).to_owned(),
                            None => continue,
                        }
                    }
                    _ => continue,
                };
                let path = join(&join(&join(name, element), EFFECTS), kind);
                let remedy = format!("{why}; the axis that `feeler reduce` makes takes every effect");
                problems.add(&entry.key, path, format!("`{kind}` is not simulated with a whole arm"), remedy);
            }
        }
    }
}

/// Sensors read the contact's force, or the tool's displacement along the normal from the motors.
fn refuse_sources(root: &Table, problems: &mut Problems) {
    let contact = elements(root, CONTACTS.table).next().map_or("", |(name, _)| name.as_str());
    let named = |element: &str, quantity| SignalName::new(element, quantity).to_string();
    let force = [Quantity::Force, Quantity::SpringForce].map(|quantity| named(contact, quantity));
    let motion = [Quantity::Position, Quantity::Velocity].map(|quantity| named(MOTOR, quantity));
    for (name, table) in elements(root, SENSORS.table) {
        let Some(reads) = table.get(Sensor::READS.key.name) else { continue };
        let signal = reads.node.as_text().unwrap_or_default().to_owned();
        let path = |key: Key| join(&join(SENSORS.table, name), key.name);
        if !motion.contains(&signal) && !force.contains(&signal) {
            let remedy = format!("read {}, {}", force.join(" or "), motion.join(" or "));
            let message = format!("no sensor of a whole arm reads `{signal}`");
            problems.add(&reads.node.origin, path(Sensor::READS.key), message, remedy);
        }
        let filter = Sensor::LOW_PASS.key;
        if let Some(written) = table.get(filter.name).filter(|_| motion.contains(&signal)) {
            let remedy = "remove it; `velocity_filter` of the controller smooths speeds";
            problems.add(&written.key, path(filter), "joint encoders have no analogue filter", remedy);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::keys::{ELEMENTS, RUN};

    #[test]
    fn truth_keys_that_an_arm_refuses_are_keys_of_an_axis() {
        for (table, key, _) in NOT_HERE {
            let element = ELEMENTS.iter().find(|element| element.table == table);
            let shape = element.map_or(&RUN, |element| &element.shape);
            assert!(shape.all_keys().any(|known| known.name == key.name), "{table}.{}", key.name);
        }
    }
}
