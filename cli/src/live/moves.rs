//! Slider moves have priority: background work pauses while a move is computed.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// The current moves, and the threads that wait for their end.
#[derive(Default)]
pub(super) struct Moves {
    /// Changed only under the lock, but read without it at each row of a run.
    under_way: AtomicUsize,
    resting: Mutex<usize>,
    changed: Condvar,
}

/// A move that is being computed, until this guard is dropped.
pub(super) struct Move<'a>(&'a Moves);

impl Moves {
    pub(super) fn begin(&self) -> Move<'_> {
        let _lock = self.lock();
        self.under_way.fetch_add(1, Ordering::Relaxed);
        Move(self)
    }

    /// Returns at once if no move is computed, otherwise at the end of the last one.
    pub(super) fn rest(&self) {
        if !self.is_any() {
            return;
        }
        let mut resting = self.lock();
        *resting += 1;
        self.changed.notify_all();
        while self.is_any() {
            resting = self.changed.wait(resting).unwrap_or_else(PoisonError::into_inner);
        }
        *resting -= 1;
    }

    fn is_any(&self) -> bool {
        self.under_way.load(Ordering::Relaxed) > 0
    }

    fn lock(&self) -> MutexGuard<'_, usize> {
        self.resting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Move<'_> {
    fn drop(&mut self) {
        let _lock = self.0.lock();
        self.0.under_way.fetch_sub(1, Ordering::Relaxed);
        self.0.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;

    impl Moves {
        /// Whether this number of threads rests before the work is over.
        pub(in crate::live) fn wait_for(&self, resting: usize, over: &AtomicBool) -> bool {
            let mut now = self.lock();
            while *now < resting && !over.load(Ordering::Relaxed) {
                now = self.changed.wait(now).unwrap_or_else(PoisonError::into_inner);
            }
            *now >= resting
        }

        /// Wakes the threads that wait for resting ones.
        pub(in crate::live) fn is_over(&self, over: &AtomicBool) {
            let _lock = self.lock();
            over.store(true, Ordering::Relaxed);
            self.changed.notify_all();
        }
    }

    /// Two moves overlap, and the map continues after both have ended.
    #[test]
    fn truth_work_rests_until_the_last_move_has_ended() {
        let moves = Moves::default();
        moves.rest();
        let (first, second) = (moves.begin(), moves.begin());
        let (over, last) = (AtomicBool::new(false), AtomicBool::new(false));
        std::thread::scope(|scope| {
            scope.spawn(|| {
                moves.rest();
                assert!(last.load(Ordering::Relaxed));
                moves.is_over(&over);
            });
            assert!(moves.wait_for(1, &over));
            drop(first);
            assert!(moves.wait_for(1, &over));
            last.store(true, Ordering::Relaxed);
            drop(second);
        });
        moves.rest();
    }
}
