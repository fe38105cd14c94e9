//! Independent tasks, executed by the caller.

use std::fmt;
use std::sync::OnceLock;

/// A task for each index.
type Task<'a> = &'a (dyn Fn(usize) + Sync);

/// Executes independent tasks. This crate starts no threads; a caller that has some lends them. Results do
/// not depend on the number or order of threads.
#[derive(Clone, Copy)]
pub struct Workers(fn(usize, Task<'_>));

impl Workers {
    /// Workers that do a task once for each index below a count, in any order, and return when all are
    /// finished.
    pub const fn new(do_all: fn(usize, Task<'_>)) -> Self {
        Self(do_all)
    }

    /// Results of a task for each index below `count`, in order.
    pub(crate) fn collect<T: Send + Sync>(self, count: usize, task: impl Fn(usize) -> T + Sync) -> Vec<T> {
        let slots: Vec<OnceLock<T>> = (0..count).map(|_| OnceLock::new()).collect();
        (self.0)(count, &|index| {
            slots[index].get_or_init(|| task(index));
        });
        slots.into_iter().filter_map(OnceLock::into_inner).collect()
    }

    /// Results of two tasks.
    pub(crate) fn both<A: Send + Sync, B: Send + Sync>(
        self,
        first: impl Fn() -> A + Sync,
        second: impl Fn() -> B + Sync,
    ) -> (A, B) {
        let (a, b) = (OnceLock::new(), OnceLock::new());
        (self.0)(2, &|index| {
            if index == 0 {
                a.get_or_init(&first);
            } else {
                b.get_or_init(&second);
            }
        });
        (a.into_inner().unwrap_or_else(first), b.into_inner().unwrap_or_else(second))
    }
}

impl Default for Workers {
    /// The calling thread.
    fn default() -> Self {
        Self(|count, task| (0..count).for_each(task))
    }
}

impl fmt::Debug for Workers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Workers")
    }
}

impl PartialEq for Workers {
    /// All workers are equal, since they give equal results.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
