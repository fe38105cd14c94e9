//! The definition of a message.

use std::fmt;

/// Why a definition is invalid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct DefinitionError(pub(crate) String);

impl fmt::Display for DefinitionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Type of one value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Base {
    Bool,
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
    Text,
    /// Another structure, by its index.
    Struct(usize),
}

/// Number of values of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Many {
    One,
    Fixed(usize),
    Sequence,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Field {
    pub(crate) name: String,
    pub(crate) base: Base,
    pub(crate) many: Many,
}

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Struct {
    /// `package/Type`.
    pub(crate) name: String,
    pub(crate) fields: Vec<Field>,
}

/// A message with all its structures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Definition {
    pub(crate) structs: Vec<Struct>,
    pub(crate) root: usize,
}

/// Largest number of values of a message with fixed size: real messages have far fewer.
const MOST_FIXED: usize = 1 << 20;

impl Definition {
    /// Checks that no structure contains itself, and that fixed arrays have a possible size.
    pub(crate) fn checked(self) -> Result<Self, DefinitionError> {
        let mut sizes = vec![None; self.structs.len()];
        self.size(self.root, &mut Vec::new(), &mut sizes)?;
        Ok(self)
    }

    /// Number of values of a fixed structure.
    fn size(
        &self,
        of: usize,
        within: &mut Vec<usize>,
        sizes: &mut [Option<usize>],
    ) -> Result<usize, DefinitionError> {
        if let Some(size) = sizes[of] {
            return Ok(size);
        }
        let name = &self.structs[of].name;
        if within.contains(&of) {
            return Err(DefinitionError(format!("{name} holds itself")));
        }
        within.push(of);
        let mut total = 1_usize;
        for field in &self.structs[of].fields {
            let one = match field.base {
                Base::Struct(inner) => self.size(inner, within, sizes)?,
                _ => 1,
            };
            let count = if let Many::Fixed(count) = field.many { count } else { 1 };
            total = total.saturating_add(one.saturating_mul(count));
        }
        within.pop();
        if total > MOST_FIXED {
            return Err(DefinitionError(format!("{name} has more than {MOST_FIXED} values")));
        }
        sizes[of] = Some(total);
        Ok(total)
    }

    /// Whether the first field of the message is the usual header with a time stamp.
    pub(crate) fn has_header(&self) -> bool {
        let first = self.structs[self.root].fields.first();
        matches!(first, Some(Field { base: Base::Struct(i), many: Many::One, .. })
            if self.structs[*i].name == "std_msgs/Header")
    }
}

/// `package/Type` of `package/msg/Type` and `package::msg::Type`.
pub(crate) fn short_name(name: &str) -> String {
    let name = name.replace("::", "/");
    let mut parts: Vec<&str> = name.split('/').filter(|part| !part.is_empty()).collect();
    if parts.len() > 2 {
        parts.retain(|part| !matches!(*part, "msg" | "srv" | "action"));
    }
    parts.join("/")
}
