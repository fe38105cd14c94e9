//! Logs as robots write them, sound and broken.

mod bounds;
mod broken;
mod messages;
mod real_writers;
mod tables;
