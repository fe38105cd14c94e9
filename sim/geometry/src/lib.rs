//! Shapes of tip and workpiece, with Parry.
//!
//! The machine moves along x. The workpiece may have any [`Shape`] at any [`Placement`], and the tip travels
//! sideways, in y and z, along a [`Feed`]. For the axis all of this reduces to one function of time: how far
//! the tip can travel along x before it touches. [`Touching::at`] computes it for one place, with contact
//! point, normal, and the slope that gives the rate. [`Touching::profile`] converts it along a feed into a
//! [`feeler_plant::description::Profile`] with a bound on its error, which the engine then uses exactly. A
//! [`Pair`] measures a tip that moves anywhere in space, as that of an arm does.
//!
//! ```
//! use feeler_geometry::{Feed, Placement, Shape, Touching};
//!
//! let tip = Shape::Ball { radius_m: 2e-3 };
//! let work = Shape::Cuboid { half_extents_m: [10e-3, 50e-3, 50e-3] };
//! let touching = Touching::new(&tip, &Placement::at([0.0; 3]), &work, &Placement::at([30e-3, 0.0, 0.0]))?;
//! // The ball's front is 2 mm ahead of its centre, and the face 20 mm away.
//! assert!((touching.at([0.0, 0.0])?.travel_m - 18e-3).abs() < 1e-12);
//! let found = touching.profile(&Feed::line([0.0, 0.0], [20e-3, 0.0]), 1.0, 1e-9)?;
//! assert!(found.error_m < 1e-9);
//! # Ok::<(), feeler_geometry::GeometryError>(())
//! ```

mod capsule;
mod error;
mod feed;
mod field;
mod hertz;
mod keys;
mod mesh;
mod outline;
mod pair;
mod profile;
mod shape;
mod swept_ball;
mod touching;

pub use error::GeometryError;
pub use feed::Feed;
pub use field::read_height_field;
pub use hertz::{Material, hertz_stiffness};
pub use mesh::{Mesh, read_obj, read_stl};
pub use pair::{Nearest, Pair, overlap_m};
pub use profile::Compiled;
pub use shape::{Placement, Shape};
pub use touching::{Touch, Touching};
