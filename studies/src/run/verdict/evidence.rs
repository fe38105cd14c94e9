//! What is known of a run before it is judged.

use feeler_engine::RunEnd;

use crate::run::measure::winding::Command;

/// What is known of a run with a contact.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is a fact of its own")]
pub(in crate::run) struct Evidence<'a> {
    pub(in crate::run) end: Option<RunEnd>,
    /// Whether the run is as long as it gets, so that growth counts as lasting.
    pub(in crate::run) is_longest: bool,
    /// Whether no longer run follows, though one might tell more.
    pub(in crate::run) is_last: bool,
    /// Whether a controller was in its approach at the end.
    pub(in crate::run) is_approaching: bool,
    /// Whether the tool, where it is away, may yet touch.
    pub(in crate::run) is_on_its_way: bool,
    /// Whether nothing can touch, so that `force_n` is what is controlled, or else what a drive is commanded.
    pub(in crate::run) is_rendered: bool,
    /// Where nothing can touch: the motion wanted at the rows, where a controller wants one.
    pub(in crate::run) wanted: Option<&'a [f64]>,
    /// Whether a surface moves under the tool, or a body that a series of commands drives, to the end.
    pub(in crate::run) surface_moves: bool,
    /// Times of the rows, s.
    pub(in crate::run) t_s: &'a [f64],
    /// The contact force at the rows, N.
    pub(in crate::run) force_n: &'a [f64],
    /// Whether some reference moves to the end.
    pub(in crate::run) driven: bool,
    /// Whether some reference was at rest and has moved only just before the end.
    pub(in crate::run) has_just_moved: bool,
    /// The force wanted at the rows, where that is what moves.
    pub(in crate::run) moving_reference_n: Option<&'a [f64]>,
    /// When the last change of the reference or the first touch was, s; none where there was no touch.
    pub(in crate::run) starts_at_s: Option<f64>,
    /// When contact last ended; none where it lasts to the end.
    pub(in crate::run) lost_at_s: Option<f64>,
    /// Each contact since settling counts: when it began, s, and its largest force, N.
    pub(in crate::run) impacts: &'a [(f64, f64)],
    /// Instants of lift-off, s.
    pub(in crate::run) lifts_s: &'a [f64],
    /// Whether a limit was reached, row by row.
    pub(in crate::run) saturated: &'a [bool],
    /// Instants at which something began to stick or slip, s.
    pub(in crate::run) sticks_s: &'a [f64],
    /// Instants at which one side of a free play met or parted, s.
    pub(in crate::run) plays_s: &'a [f64],
    /// What the drives are commanded that hold the force.
    pub(in crate::run) commands: &'a [Command<'a>],
    /// Amplitude of the motion that counts as rest, N; none where no force is wanted: then 2 % of the mean
    /// force is taken.
    pub(in crate::run) band_n: Option<f64>,
    /// One sigma of what the sensors' noise makes of the readings, N; zero where there is none.
    pub(in crate::run) noise_n: f64,
}
