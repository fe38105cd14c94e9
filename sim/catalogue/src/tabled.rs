//! The path of a key in a file: table, element, key.

use crate::field::Field;
use crate::shape::Key;

/// A record that a file names within a table, as each body within `[bodies.*]`.
pub trait Tabled {
    /// The table.
    const TABLE: &'static str;

    /// The place of an element, as `bodies.tip`.
    fn place(element: &str) -> String {
        format!("{}.{element}", Self::TABLE)
    }

    /// The rest of a path after the table, `tip.mass` of `bodies.tip.mass`; `None` in another table.
    fn within(path: &str) -> Option<&str> {
        path.strip_prefix(Self::TABLE)?.strip_prefix('.')
    }
}

impl Key {
    /// The key of an element in a file, as `controllers.force.reference`.
    pub fn of<T: Tabled>(&self, element: &str) -> String {
        format!("{}.{}", T::place(element), self.name)
    }
}

impl<T: Tabled> Field<T> {
    /// The key of an element in a file, as `bodies.tip.mass`.
    pub fn of(&self, element: &str) -> String {
        self.key.of::<T>(element)
    }
}
