//! What can be wrong with shapes and their motion.

use feeler_plant::problem::short;
use thiserror::Error;

/// Why a contact's geometry cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum GeometryError {
    /// A length, radius or other number of a shape is out of range.
    #[error("{what} is {value}; it must be above zero and finite")]
    Size {
        /// What it is.
        what: &'static str,
        /// What was given.
        value: f64,
    },
    /// Points that span no body.
    #[error(
        "{points} points have no convex hull with a volume; give at least four that do not lie in one plane"
    )]
    Hull {
        /// How many were given.
        points: usize,
    },
    /// A mesh without triangles, or with corners that do not exist.
    #[error("{what}; export the mesh again as triangles")]
    Mesh {
        /// What is wrong.
        what: String,
    },
    /// A line of a file that cannot be read.
    #[error("line {line}: {what}")]
    Line {
        /// The line, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// The times of a feed's path.
    #[error(
        "point {index} of the path is at {t_s} s, which is not after the one before; sort the path by time"
    )]
    Path {
        /// Which point, from 0.
        index: usize,
        /// Its time, s.
        t_s: f64,
    },
    /// A path without points.
    #[error("the path has no points; give at least one")]
    EmptyPath,
    /// Two shapes that Parry cannot measure against each other.
    #[error("distances between a {tip} and a {workpiece} cannot be measured; use another shape for the tip")]
    Unsupported {
        /// The tip's shape.
        tip: &'static str,
        /// The workpiece's shape.
        workpiece: &'static str,
    },
    /// The tip never meets the workpiece on its way along the axis.
    #[error("with the tip at y = {y_m} m, z = {z_m} m{} the way along the axis does not meet the workpiece; move the workpiece or the feed", at(*.t_s))]
    Unreachable {
        /// Where, m.
        y_m: f64,
        /// Where, m.
        z_m: f64,
        /// When on the feed, s, if known.
        t_s: Option<f64>,
    },
    /// The tip's way along the axis grazes a wall that is parallel to it, so that the gap jumps.
    #[error(
        "at {} s the gap jumps by {} m: the tip travels against a wall, or begins just where it could touch; give the tip a radius larger than the step, or begin \
         or end the feed elsewhere", short(*.t_s), short(*.jump_m)
    )]
    Jump {
        /// When, s.
        t_s: f64,
        /// Size of the jump, m.
        jump_m: f64,
    },
    /// An edge of the gap at which the error asked for is missed even within 0.1 us.
    #[error(
        "an `error` of {error_m:e} m cannot be kept: at {} s, where the gap bends sharply, it is known to {} m; raise `error` to {:.0e} m or more",
        short(*.t_s), short(*.apart_m), 2.0 * .apart_m
    )]
    Unresolved {
        /// When, s.
        t_s: f64,
        /// How far off the gap may be there, m.
        apart_m: f64,
        /// The error asked for, m.
        error_m: f64,
    },
    /// The tip starts inside the workpiece.
    #[error("the tip starts {} m inside the workpiece; move the workpiece away along x, or the tip back", short(*.depth_m))]
    Overlap {
        /// How far it must go back, m.
        depth_m: f64,
    },
    /// More knots than a run should carry.
    #[error(
        "more than {most} knots are needed for an error of {error_m} m; ask for less accuracy, or smooth the surface"
    )]
    Knots {
        /// The limit.
        most: usize,
        /// The error asked for, m.
        error_m: f64,
    },
}

fn at(t_s: Option<f64>) -> String {
    t_s.map_or_else(String::new, |t| format!(" (at {t} s)"))
}
