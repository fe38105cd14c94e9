//! feeler-engine
