//! Where shapes touch, along an axis and in space.

mod pair;
mod touching;
