//! From fields to a scenario.

mod controllers;
mod effects;
mod elements;
mod integrator;
pub(crate) mod names;
mod references;
mod run;
pub(crate) mod shapes;
mod surface;

pub(crate) use effects::bound_of;
pub use integrator::{EXACT_PAYS_UP_TO_BODIES, longest_step_s};

use crate::keys::Element;
use feeler_catalogue::Contents;
use feeler_plant::description::{Axis, Elements};

use super::draft::Draft;
use super::problem::Problems;
use super::read::{Reader, Scope, join};
use super::source::Origin;
use super::tree::Table;

/// Reads the tables of a draft.
pub(crate) struct Builder<'a> {
    draft: &'a Draft,
    problems: &'a mut Problems,
    axis: Axis,
}

/// One element of a table, as in the file.
#[derive(Clone, Copy)]
struct Item<'t> {
    element: &'static Element,
    name: &'t str,
    table: &'t Table,
    at: &'t Origin,
}

impl Item<'_> {
    fn path(&self) -> String {
        format!("{}.{}", self.element.table, self.name)
    }

    /// Dotted path of a key of the element.
    fn key(&self, key: &str) -> String {
        format!("{}.{}.{key}", self.element.table, self.name)
    }

    /// Place of a key of the element; the element's own place if the key is absent.
    fn place(&self, key: &str) -> &Origin {
        self.table.get(key).map_or(self.at, |entry| &entry.node.origin)
    }
}

impl<'a> Builder<'a> {
    pub(crate) fn new(draft: &'a Draft, problems: &'a mut Problems, axis: Axis) -> Self {
        Self { draft, problems, axis }
    }

    fn rotational(&self) -> bool {
        self.axis == Axis::Rotational
    }

    fn scope(&self) -> Scope {
        Scope::new(self.rotational())
    }

    /// Reads every element of a table with `read`. Elements that are not tables are recorded as mistakes and
    /// skipped.
    fn each<T>(
        &mut self,
        element: &'static Element,
        mut read: impl FnMut(&mut Self, Item<'_>) -> Option<T>,
    ) -> Elements<T> {
        let mut found = Elements::new();
        let draft = self.draft;
        let Some(entry) = draft.root.get(element.table) else { return found };
        let remedy = format!("write [{}.NAME]", element.table);
        let items = self.problems.table(&entry.node, element.table, remedy);
        for (name, entry) in items.into_iter().flatten() {
            let path = join(element.table, name);
            let Some(table) = self.problems.table(&entry.node, &path, format!("write [{path}]")) else {
                continue;
            };
            if let Some(one) = read(self, Item { element, name, table, at: &entry.node.origin }) {
                found.insert(name.clone(), one);
            }
        }
        found
    }

    fn fields(&mut self, item: Item<'_>, scope: Scope) -> Contents {
        let mut reader = Reader { problems: self.problems, scope };
        reader.fields(&item.element.shape, &[super::keys::EFFECTS], item.table, item.at, &item.path())
    }
}
