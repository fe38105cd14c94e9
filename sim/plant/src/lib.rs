//! The machine: the user's description ([`description`]), the same with names resolved and effects applied
//! ([`assembly`]), and its equations of motion ([`motion`]).

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
