//! The repository as a whole: its arrows, circles, comments, messages and examples.

mod architecture;
mod circles;
mod comments;
mod examples;
mod messages;
