//! Default classes: attributes that elements have without stating them.

use std::collections::HashMap;

use roxmltree::Node;

use super::drive::Drive;
use super::read::Remarks;
use crate::error::ArmError;
use crate::xml::{child, wrong};

/// The class of elements without one.
pub(super) const MAIN: &str = "main";
/// Kinds of elements whose attributes have defaults here, beside the actuators.
const KINDS: [&str; 2] = ["joint", "geom"];

/// A class, with all that it inherits.
#[derive(Clone, Default)]
struct Class<'a> {
    /// Attributes by kind of element.
    of: HashMap<(&'static str, &'a str), &'a str>,
    drive: Drive,
}

/// All classes of a file.
#[derive(Default)]
pub(super) struct Classes<'a> {
    by_name: HashMap<String, Class<'a>>,
}

impl<'a> Classes<'a> {
    /// The classes of a file, each with what it inherits.
    pub(super) fn of(root: Node<'a, '_>, remarks: &mut Remarks) -> Result<Self, ArmError> {
        let mut all = Self::default();
        all.by_name.insert(MAIN.into(), Class::default());
        for node in root.children().filter(|node| node.has_tag_name("default")) {
            let top = all.by_name[MAIN].clone();
            // Only the outermost class may go without a name.
            all.gather(node, MAIN, top, remarks)?;
        }
        Ok(all)
    }

    fn gather(
        &mut self,
        node: Node<'a, '_>,
        name: &str,
        mut class: Class<'a>,
        remarks: &mut Remarks,
    ) -> Result<(), ArmError> {
        remarks.check(node, "default")?;
        for kind in KINDS {
            if let Some(own) = child(node, kind) {
                remarks.check(own, kind)?;
                class.of.extend(own.attributes().map(|a| ((kind, a.name()), a.value())));
            }
        }
        for own in node.children().filter(Node::is_element) {
            class.drive.apply(own, remarks)?;
        }
        self.by_name.insert(name.into(), class.clone());
        for inner in node.children().filter(|node| node.has_tag_name("default")) {
            let Some(name) = inner.attribute("class") else {
                return wrong(inner, "this class has no name", "add `class=\"NAME\"`");
            };
            self.gather(inner, name, class.clone(), remarks)?;
        }
        Ok(())
    }

    fn class(&self, node: Node<'_, '_>, class: &str) -> Result<&Class<'a>, ArmError> {
        let name = node.attribute("class").unwrap_or(class);
        self.by_name.get(name).map_or_else(
            || {
                let mut known: Vec<&str> = self.by_name.keys().map(String::as_str).collect();
                known.sort_unstable();
                let remedy = format!("name one of {}", known.join(", "));
                wrong(node, format!("there is no default class `{name}`"), remedy)
            },
            Ok,
        )
    }

    /// Attributes of an element: its own, or those of its class.
    pub(super) fn attributes(
        &self,
        node: Node<'a, '_>,
        kind: &'static str,
        class: &str,
    ) -> Result<impl Fn(&str) -> Option<&'a str> + use<'a, '_>, ArmError> {
        let class = self.class(node, class)?;
        let own: HashMap<&'a str, &'a str> = node.attributes().map(|a| (a.name(), a.value())).collect();
        Ok(move |name: &str| own.get(name).or_else(|| class.of.get(&(kind, name))).copied())
    }

    /// The drive of an actuator, before its own attributes.
    pub(super) fn drive(&self, node: Node<'_, '_>) -> Result<Drive, ArmError> {
        Ok(self.class(node, MAIN)?.drive.clone())
    }
}
