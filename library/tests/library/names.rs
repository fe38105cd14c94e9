//! A public type's name has one meaning in the workspace: no two public types share it.

use std::collections::BTreeMap;

use super::architecture::{LIBRARIES, product};

/// The name of the public type that a line declares.
fn public_type(line: &str) -> Option<&str> {
    let mut words = line.split_whitespace();
    let is_type = words.next() == Some("pub")
        && matches!(words.next(), Some("struct" | "enum" | "trait" | "type" | "union"));
    let name = words.next().filter(|_| is_type)?;
    let end = name.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(name.len());
    // A macro's type has the name that its caller gives.
    (end > 0).then(|| &name[..end])
}

#[test]
fn truth_a_public_type_has_a_name_of_its_own() {
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (path, text) in LIBRARIES.iter().flat_map(|folder| product(folder)) {
        for (number, line) in text.lines().enumerate() {
            if let Some(name) = public_type(line) {
                let place = format!("{}:{}", path.display(), number + 1);
                places.entry(name.to_owned()).or_default().push(place);
            }
        }
    }
    assert!(places.len() > 400, "only {} public types were found", places.len());
    places.retain(|_, places| places.len() > 1);
    assert!(places.is_empty(), "rename all but one of each: {places:#?}");
}

#[test]
fn truth_a_public_type_is_seen_whatever_follows_its_name() {
    assert_eq!(public_type("pub struct Field<T> {"), Some("Field"));
    assert_eq!(public_type("        pub enum Kind {"), Some("Kind"));
    assert_eq!(public_type("pub struct Name;"), Some("Name"));
    assert_eq!(public_type("pub trait Lane: Copy {"), Some("Lane"));
    assert_eq!(public_type("        pub struct $kind {"), None);
    assert_eq!(public_type("pub(crate) struct Table {"), None);
    assert_eq!(public_type("pub fn enum_of()"), None);
}
