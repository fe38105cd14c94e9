//! The notation of the cells of a table.

/// Separator of two cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Separator {
    Mark(u8),
    /// Any number of blanks.
    Blanks,
}

/// How a table is written.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Dialect {
    pub(super) separator: Separator,
    /// Byte that begins a comment line.
    pub(super) comment: u8,
    pub(super) decimal_comma: bool,
}
