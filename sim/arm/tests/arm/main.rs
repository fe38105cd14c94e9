//! Arms: their files, their motion, and the axis that they are along a normal.

mod reduction;
mod two_link;
mod urdf;
