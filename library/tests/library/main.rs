//! The repository as a whole: its arrows, circles, comments, messages, names and examples.

mod architecture;
mod circles;
mod comments;
mod examples;
mod messages;
mod names;
