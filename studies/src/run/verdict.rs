//! The outcome of a run: settled, chattering, unstable, or another class, by criteria on its tail.
//!
//! The *tail* is the second half of the time after the last change of the reference or the first touch,
//! whichever is later. If the reference moves to the end, it is the second half of the time after the first
//! touch. The tail is divided into three equal parts with the amplitudes `A1, A2, A3`. They are half of peak
//! to peak of the force, less its reference if that moves. The three separate growth from decay. The criteria
//! apply in this order:
//!
//! - *unstable*: the motion left all bounds. Or it grows ([`growth`]) and never left the workpiece, or it
//!   still grows at the end of the longest extension.
//! - *no-contact*: the tool never touched, or left before the tail without return, and is not on its way.
//!   That is, no controller approaches, and no gap would close at its present rate and acceleration within
//!   the longest extension.
//! - *chatter*: at least 3 lift-offs in the tail, 2 of them in its last part. `A3 >= 0.7 A1`, with no fall by
//!   3 % that continues to the end. And the last impacts do not each fall by 1 % from the one before.
//! - *driven*: a reference moves to the end, possibly in even steps, so there is nothing to settle at.
//! - *settled*, *bounces-then-settles*: `A3` is within the settling band, and no growth from part to part
//!   continues. There is no lift-off in the last part, and no controller is in its approach. No command moves
//!   on while the force rests. The band is 2 % of the reference force, or four sigma of the sensor's noise if
//!   that is more. Steps of the sensor do not widen it. The two differ in whether the tool had left the
//!   workpiece.
//! - *limit-cycle*: the force oscillates and does not decay, and a drive or controller is at its limit for
//!   over 1 % of the tail.
//! - *hunting*: the same, but no limit is reached, and a guide sticks or breaks loose at least twice. A guide
//!   on bristles sticks if it rests for long and then travels farther than they bend.
//! - *oscillates*: the same with neither, over 12 cycles at least or to the end of the longest extension.
//! - *undecided*: none of these. Oscillation or bouncing decays but has not ended, or creeps up or down.
//!   (Creep is a significant line through the logarithms of the amplitudes of 4 to 24 windows, see
//!   [`super::trend`]. With fewer than 12 cycles it is a factor of more than 1.05 from part to part.) Or a
//!   tool is on its way, or a command winds up. Or a reference was at rest over a fifth of the run and has
//!   moved in the last fifth. Or a run that left the workpiece grows and may still be bounded by that. Or the
//!   tail is too short to judge, with less than two cycles of a motion that lasts or grows.
//!
//! If nothing can touch, a wall is one that a controller renders. The first drive's command then replaces the
//! force. The outcome is unstable if the command grows (and at the end of the longest extension if it creeps
//! up). It is a limit cycle if the command oscillates between limits, and `no-contact` otherwise.
//!
//! A longer run decides most of the undecided cases: [`super::measure()`] extends the run until it is
//! decided.

mod evidence;
mod growth;
mod judge;
mod outcome;
mod rendered;
mod tail;

pub(super) use evidence::Evidence;
pub use outcome::{MOST_EXTENSION, Outcome, RunVerdict, Undecided};
