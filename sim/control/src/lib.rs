//! feeler-control
