//! The machine: what the user wrote ([`description`]), names resolved and effects applied ([`assembly`]), and
//! its equations of motion ([`motion`]).

pub mod assembly;
pub mod description;
pub mod effects;
pub mod motion;
pub mod names;
pub mod units {
    //! Physical dimensions.

    pub use feeler_catalogue::Dimension;
}

pub use feeler_problem as problem;
