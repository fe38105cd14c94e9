//! feeler-analysis
