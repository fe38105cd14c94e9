//! Points of contact between shapes, along an axis and in space.

mod pair;
mod touching;
