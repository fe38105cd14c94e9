//! Errors of shapes and their motion.

use std::borrow::Cow;

use feeler_problem::{Remedy, short};
use thiserror::Error;

/// Why a contact's geometry cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum GeometryError {
    #[error("{what} is {value}")]
    Size { what: &'static str, value: f64 },
    #[error("{points} points have no convex hull with a volume")]
    Hull { points: usize },
    /// A mesh without triangles, or with corners that do not exist; a height field without a surface.
    #[error("{what}")]
    Mesh { what: String, remedy: &'static str },
    #[error("line {line}: {what}")]
    Line {
        /// The line, from 1.
        line: usize,
        what: String,
        remedy: &'static str,
    },
    #[error("point {index} of the path is at {t_s} s, which is not after the one before")]
    Path {
        /// Index of the point, from 0.
        index: usize,
        t_s: f64,
    },
    #[error("the path has no points")]
    EmptyPath,
    #[error("distances between a {tip} and a {workpiece} cannot be measured")]
    Unsupported { tip: &'static str, workpiece: &'static str },
    #[error("with the tip at y = {y_m} m, z = {z_m} m{} the way along the axis does not meet the \
             workpiece", at(*.t_s))]
    Unreachable {
        y_m: f64,
        z_m: f64,
        /// Time on the feed, s, if known.
        t_s: Option<f64>,
    },
    #[error(
        "at {} s the gap jumps by {} m: the tip travels against a wall, or begins just where it could \
         touch", short(*.t_s), short(*.jump_m)
    )]
    Jump { t_s: f64, jump_m: f64 },
    /// An edge of the gap at which the requested error is exceeded even within 0.1 us.
    #[error(
        "an `error` of {error_m:e} m cannot be kept: at {} s, where the gap bends sharply, it is known to \
         {} m",
        short(*.t_s), short(*.apart_m)
    )]
    Unresolved { t_s: f64, apart_m: f64, error_m: f64 },
    #[error("the tip starts {} m inside the workpiece", short(*.depth_m))]
    Overlap { depth_m: f64 },
    #[error("more than {most} knots are needed for an error of {error_m} m")]
    Knots { most: usize, error_m: f64 },
}

impl Remedy for GeometryError {
    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::Size { .. } => "write a finite number above zero".into(),
            Self::Hull { .. } => "give at least four points that do not lie in one plane".into(),
            Self::Mesh { remedy, .. } | Self::Line { remedy, .. } => (*remedy).into(),
            Self::Path { .. } => "sort the path by time".into(),
            Self::EmptyPath => "give at least one point".into(),
            Self::Unsupported { .. } => "use another shape for the tip".into(),
            Self::Unreachable { .. } => "move the workpiece or the feed".into(),
            Self::Jump { .. } => {
                "give the tip a radius larger than the step, or begin or end the feed elsewhere".into()
            }
            Self::Unresolved { apart_m, .. } => {
                format!("raise `error` to {:.0e} m or more", 2.0 * apart_m).into()
            }
            Self::Overlap { .. } => "move the workpiece away along x, or the tip back".into(),
            Self::Knots { .. } => "ask for less accuracy, or smooth the surface".into(),
        }
    }
}

fn at(t_s: Option<f64>) -> String {
    t_s.map_or_else(String::new, |t| format!(" (at {t} s)"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let all = [
            GeometryError::Size { what: "the radius of a ball", value: 0.0 },
            GeometryError::Hull { points: 3 },
            GeometryError::Mesh { what: "the mesh has no triangles".into(), remedy: "export it again" },
            GeometryError::Line { line: 1, what: "`x` is not a number".into(), remedy: "write a number" },
            GeometryError::Path { index: 1, t_s: 0.0 },
            GeometryError::EmptyPath,
            GeometryError::Unsupported { tip: "mesh", workpiece: "mesh" },
            GeometryError::Unreachable { y_m: 0.0, z_m: 0.0, t_s: Some(1.0) },
            GeometryError::Jump { t_s: 1.0, jump_m: 1e-3 },
            GeometryError::Unresolved { t_s: 1.0, apart_m: 1e-9, error_m: 1e-10 },
            GeometryError::Overlap { depth_m: 1e-3 },
            GeometryError::Knots { most: 1000, error_m: 1e-9 },
        ];
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("error.rs")),
            Vec::<String>::new()
        );
    }
}
