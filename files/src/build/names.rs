//! Names of elements: valid characters, and no two elements with one name if signals would be ambiguous.

use std::collections::HashMap;

use feeler_catalogue::Tabled;
use feeler_plant::description::{Actuator, Contact, GROUND, Spring};

use crate::keys::ELEMENTS;
use crate::problem::Problems;
use crate::tree::Table;

/// Tables whose elements all have a `force`.
const FORCEFUL: [&str; 3] = [Spring::TABLE, Contact::TABLE, Actuator::TABLE];

/// Largest number of characters of a name.
const LONGEST_NAME: usize = 64;

pub(crate) fn check(root: &Table, problems: &mut Problems) {
    let mut seen: HashMap<&str, &str> = HashMap::new();
    for element in ELEMENTS {
        let Some(items) = root.get(element.table).and_then(|entry| entry.node.as_table()) else { continue };
        for (name, entry) in items {
            let path = format!("{}.{name}", element.table);
            let plain = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
            if name.is_empty() || name.len() > LONGEST_NAME || !name.chars().all(plain) {
                let remedy = format!("use letters, digits, `_` and `-`, at most {LONGEST_NAME}");
                problems.add(&entry.key, &path, format!("`{name}` cannot be a name"), remedy);
            }
            if name == GROUND {
                problems.add(&entry.key, &path, "`ground` is the fixed body", "choose another name");
            }
            // Other elements may share a name: the quantity selects one.
            if !FORCEFUL.contains(&element.table) {
                continue;
            }
            if let Some(first) = seen.insert(name, element.singular) {
                let message =
                    format!("there is already a {first} `{name}`, and `{name}.force` would mean both");
                problems.add(&entry.key, &path, message, "choose another name");
            }
        }
    }
}
