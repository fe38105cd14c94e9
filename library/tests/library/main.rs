//! The repository as a whole: its arrows, circles, messages and examples.

mod architecture;
mod circles;
mod examples;
mod messages;
