//! feeler-lti
