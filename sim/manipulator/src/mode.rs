//! Which contacts push and which joints stick: between changes of these the motion is smooth.

/// What a motor's dry friction does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Slide {
    /// It holds the motor.
    Stick,
    /// It resists a motor that moves forward (1) or backward (-1).
    Along(f64),
    /// There is none.
    None,
}

/// What is in touch, and what slides.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mode {
    /// Whether the tip pushes on the workpiece.
    pub(crate) touching: bool,
    /// The flank of each gear's play that pushes: 1, -1, or 0 for none.
    pub(crate) flanks: Vec<i8>,
    pub(crate) slides: Vec<Slide>,
}

/// A change of mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Change {
    /// The contact begins or ceases to push.
    Contact,
    /// A flank of a gear meets or parts.
    Flank(usize),
    /// A motor sticks, breaks loose or turns.
    Slide(usize),
}
