//! feeler-plant
