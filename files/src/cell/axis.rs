//! The axis along the normal, as a machine. It has the contact, sensors, controller and run of a whole arm's
//! scenario, with the bodies and the drive between them.

use feeler_arm::Reduction;
use feeler_plant::effects::{Kind, find};

use crate::draft::Draft;
use crate::keys::EFFECTS;
use crate::problem::Problems;
use crate::read::join;
use crate::source::Origin;
use crate::tree::{Entry, Node, Table, Value};

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
const NOT_HERE: [(&str, &str, &str); 10] = [
    ("contacts", "between", "the contact is between `[tip]` and `[workpiece]`"),
    ("contacts", "engagement", "the contact pushes only"),
    ("contacts", "surface", "`[tip]` and `[workpiece]` have the shapes"),
    ("contacts", "profile", "`[tip]` and `[workpiece]` have the shapes"),
    ("sensors", "relative_to", "the base stands still"),
    ("controllers", "drives", "the controller drives the force along the normal"),
    ("run", "engine", "arms have one engine"),
    ("run", "integrator", "arms have one integrator"),
    ("run", "record", "everything is recorded"),
    ("run", "energy", "no energy ledger is kept of an arm"),
];

/// A scenario of the axis, as a draft; `None` if there are mistakes, or no axis is known.
pub(super) fn draft(draft: &Draft, reduction: Option<&Reduction>, problems: &mut Problems) -> Option<Draft> {
    let before = problems.count();
    let top = Origin { source: draft.main, span: 0..0 };
    let place = draft.root.get("arm").map_or(top.clone(), |entry| entry.key.clone());
    let mut root: Table = (draft.root.iter())
        .filter(|(name, _)| {
            ["name", "about", "contacts", "sensors", "controllers", "run"].contains(&name.as_str())
        })
        .map(|(name, entry)| (name.clone(), entry.clone()))
        .collect();
    refuse_keys(&root, problems);
    only_one(&root, "contacts", "contact", &top, problems);
    only_one(&root, "controllers", "controller", &top, problems);
    refuse_effects(&root, problems);
    refuse_sources(&root, problems);
    let axis = reduction.filter(|_| problems.count() == before)?;
    let make = Maker { place };
    each_table(&mut root, "contacts", |table| make.put(table, "between", make.texts(&[TIP, "ground"])));
    each_table(&mut root, "controllers", |table| make.put(table, "drives", make.text(DRIVE)));
    let body = |mass| make.table([("mass", make.number(mass))]);
    make.put(
        &mut root,
        "bodies",
        make.table([(MOTOR, body(axis.motor_mass_kg)), (TIP, body(axis.tip_mass_kg))]),
    );
    let spring = make.table([
        ("between", make.texts(&[MOTOR, TIP])),
        ("stiffness", make.number(axis.stiffness_n_per_m)),
        ("damping", make.number(axis.damping_n_s_per_m)),
    ]);
    make.put(&mut root, "springs", make.table([("transmission", spring)]));
    make.put(&mut root, "actuators", make.table([(DRIVE, make.table([("on", make.text(MOTOR))]))]));
    let sensors = root.entry("sensors".into()).or_insert_with(|| make.entry(make.table([])));
    if let Some(sensors) = sensors.node.as_table_mut().filter(|sensors| !sensors.contains_key(ENCODER)) {
        make.put(sensors, ENCODER, make.table([("reads", make.text("motor.position"))]));
    }
    Some(Draft { sources: draft.sources.clone(), root, main: draft.main, gaps: draft.gaps.clone() })
}

/// Creates nodes that are in no file.
struct Maker {
    place: Origin,
}

impl Maker {
    fn node(&self, value: Value) -> Node {
        Node { value, origin: self.place.clone() }
    }

    fn text(&self, text: &str) -> Node {
        self.node(Value::Text(text.into()))
    }

    fn texts(&self, texts: &[&str]) -> Node {
        self.node(Value::Array(texts.iter().map(|text| self.text(text)).collect()))
    }

    fn number(&self, number: f64) -> Node {
        self.node(Value::Float(number))
    }

    fn entry(&self, node: Node) -> Entry {
        Entry { key: self.place.clone(), node }
    }

    fn table<const N: usize>(&self, entries: [(&str, Node); N]) -> Node {
        self.node(Value::Table(
            entries.into_iter().map(|(name, node)| (name.to_owned(), self.entry(node))).collect(),
        ))
    }

    fn put(&self, table: &mut Table, name: &str, node: Node) {
        table.insert(name.into(), self.entry(node));
    }
}

fn each_table(root: &mut Table, name: &str, mut change: impl FnMut(&mut Table)) {
    let tables = root.get_mut(name).and_then(|entry| entry.node.as_table_mut());
    tables
        .into_iter()
        .flat_map(Table::values_mut)
        .filter_map(|entry| entry.node.as_table_mut())
        .for_each(&mut change);
}

fn elements<'t>(root: &'t Table, name: &str) -> impl Iterator<Item = (&'t String, &'t Table)> {
    let tables = root.get(name).and_then(|entry| entry.node.as_table());
    tables.into_iter().flatten().filter_map(|(name, entry)| Some((name, entry.node.as_table()?)))
}

fn refuse_keys(root: &Table, problems: &mut Problems) {
    for (name, key, instead) in NOT_HERE {
        let mut refuse = |path: &str, table: &Table| {
            if let Some(entry) = table.get(key) {
                problems.add(
                    &entry.key,
                    join(path, key),
                    format!("`{key}` has no meaning for a whole arm: {instead}"),
                    "remove it",
                );
            }
        };
        if name == "run" {
            if let Some(run) = root.get("run").and_then(|entry| entry.node.as_table()) {
                refuse("run", run);
            }
            continue;
        }
        for (element, table) in elements(root, name) {
            refuse(&join(name, element), table);
        }
    }
}

fn only_one(root: &Table, name: &str, singular: &str, top: &Origin, problems: &mut Problems) {
    let count = elements(root, name).count();
    if count != 1 {
        let at = root.get(name).map_or(top, |entry| &entry.key);
        let remedy = if count == 0 { format!("add [{name}.NAME]") } else { format!("keep one {singular}") };
        problems.add(at, name, format!("a whole arm has one {singular}, and here are {count}"), remedy);
    }
}

fn refuse_effects(root: &Table, problems: &mut Problems) {
    for name in ["contacts", "sensors"] {
        for (element, table) in elements(root, name) {
            let effects = table.get(EFFECTS).and_then(|entry| entry.node.as_table());
            for (kind, entry) in effects.into_iter().flatten() {
                // An unknown name is rejected with the nearest known one.
                let Some(definition) = find(kind) else { continue };
                let why = match name {
                    "contacts" if !OF_CONTACTS.contains(&definition.kind) => {
                        format!("contacts of a whole arm take {}", OF_CONTACTS.map(Kind::name).join(", "))
                    }
                    "sensors" => match NOT_OF_SENSORS.iter().find(|(other, _)| *other == definition.kind) {
                        Some((_, why)) => (*why).to_owned(),
                        None => continue,
                    },
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
    let contact = elements(root, "contacts").next().map_or("", |(name, _)| name.as_str());
    for (name, table) in elements(root, "sensors") {
        let Some(reads) = table.get("reads") else { continue };
        let signal = reads.node.as_text().unwrap_or_default();
        let force = [format!("{contact}.force"), format!("{contact}.spring_force")];
        let motion = signal == "motor.position" || signal == "motor.velocity";
        let path = join("sensors", name);
        if !motion && !force.iter().any(|known| known == signal) {
            let remedy = format!("read {} or {}, motor.position or motor.velocity", force[0], force[1]);
            problems.add(
                &reads.node.origin,
                join(&path, "reads"),
                format!("no sensor of a whole arm reads `{signal}`"),
                remedy,
            );
        }
        if let Some(filter) = table.get("low_pass").filter(|_| motion) {
            let remedy = "remove it; `velocity_filter` of the controller smooths speeds";
            problems.add(
                &filter.key,
                join(&path, "low_pass"),
                "joint encoders have no analogue filter",
                remedy,
            );
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
            assert!(shape.all_keys().any(|known| known.name == key), "{table}.{key}");
        }
    }
}
