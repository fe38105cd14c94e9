//! Arms: their files, their motion, and the axis that represents them along a normal.

mod mjcf;
mod reduction;
mod two_link;
mod urdf;
