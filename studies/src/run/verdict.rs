//! What became of a run: settled, chattering, unstable, or something else, by criteria on its tail.
//!
//! The *tail* is the second half of what follows the last change of the reference or the first touch,
//! whichever is later (the second half of what follows the first touch where the reference moves to the end).
//! It is cut into three equal parts whose amplitudes `A1, A2, A3` (half of peak to peak of the force, less
//! its reference where that moves) tell growth from decay. In this order:
//!
//! | outcome | when |
//! |---|---|
//! | unstable | the motion left all bounds; or it grows ([`growth`]) and never left the workpiece, or still grows at the end of the longest extension |
//! | no-contact | the tool never touched, or left before the tail without return, and is not on its way: no controller approaches, and no gap would close at its present rate and acceleration within the longest extension |
//! | chatter | at least 3 lift-offs in the tail, 2 of them in its last part, and `A3 >= 0.7 A1` with no fall by 3 % that goes on to the end, and impacts of which the last ones do not each fall short of the one before by 1 % |
//! | driven | a reference moves to the end, in even steps too, so that there is nothing to settle at |
//! | settled, bounces-then-settles | `A3` within the settling band (2 % of the force wanted, or four sigma of the sensor's noise where that is more; steps of the sensor do not widen it), no lift-off in the last part, no controller in its approach, no command that moves on while the force rests, and no growth from part to part that goes on; by whether the tool had left the workpiece |
//! | limit-cycle | the force oscillates and does not decay, and a drive or controller is at its limit for over 1 % of the tail |
//! | hunting | the same, no limit is reached, and a guide sticks or breaks loose at least twice |
//! | oscillates | the same with neither, over 12 cycles at least or to the end of the longest extension |
//! | undecided | none of these: oscillation or bouncing that decays but has not ended, that creeps up or down (by a line through the logarithms of the amplitudes of 4 to 24 windows, see [`super::trend`]; by more than 1.05 from part to part where there are fewer than 12 cycles), a tool on its way, a reference that was at rest over a fifth of the run and has moved in the last one, a command that winds, growth in a run that left the workpiece and may yet be bounded by that, or a tail too short to judge, with less than two cycles of what lasts or grows |
//!
//! Where nothing can touch, so that a wall is one that a controller renders, the first drive's command takes
//! the force's place: it is unstable where that grows (and at the end of the longest extension where it
//! creeps up), a limit cycle where it swings between limits, and `no-contact` otherwise.
//!
//! A longer run decides most of what a short one leaves undecided: [`super::measure()`] extends the run until
//! it is.

mod evidence;
mod growth;
mod judge;
mod outcome;
mod rendered;
mod tail;

pub(super) use evidence::Evidence;
pub use outcome::{MOST_EXTENSION, Outcome, Undecided, Verdict};
