//! Messages of ROS 2: their definitions in a log, and the numbers of messages in CDR.

mod cdr;
mod definition;
mod idl;
mod msg;
mod names;
mod well_known;

pub(crate) use cdr::CdrError;
pub(crate) use definition::{Definition, DefinitionError};
pub(crate) use well_known::well_known;

use cdr::{Numbers, decode};

/// Reads the definition of a type from the text of a schema.
pub(crate) fn definition(encoding: &str, name: &str, text: &str) -> Result<Definition, DefinitionError> {
    match encoding {
        "ros2idl" => idl::parse(name, text),
        _ => msg::parse(name, text),
    }
}

/// Decodes the messages of one topic into numbers with a path each.
pub(crate) struct Decoder {
    definition: Definition,
    now: Numbers,
    before: Numbers,
    paths: Vec<String>,
    left_out: Vec<String>,
}

impl Decoder {
    pub(crate) fn new(definition: Definition) -> Self {
        let (now, before) = (Numbers::default(), Numbers::default());
        Self { definition, now, before, paths: Vec::new(), left_out: Vec::new() }
    }

    /// Decodes a message. Returns whether the paths of its numbers differ from those of the previous message.
    pub(crate) fn decode(&mut self, message: &[u8]) -> Result<bool, CdrError> {
        std::mem::swap(&mut self.now, &mut self.before);
        decode(&self.definition, message, &mut self.now)?;
        let is_same = !self.paths.is_empty()
            && self.now.lengths == self.before.lengths
            && self.now.names == self.before.names;
        if !is_same {
            (self.paths, self.left_out) = names::paths(&self.definition, &self.now);
        }
        Ok(!is_same)
    }

    /// Numbers of the last message.
    pub(crate) fn values(&self) -> &[f64] {
        &self.now.values
    }

    /// Time in the header of the last message, ns.
    pub(crate) fn stamp_ns(&self) -> Option<i64> {
        self.now.stamp_ns
    }

    /// A path for each number.
    pub(crate) fn paths(&self) -> &[String] {
        &self.paths
    }

    /// Fields with too many numbers to be columns.
    pub(crate) fn left_out(&self) -> &[String] {
        &self.left_out
    }
}
