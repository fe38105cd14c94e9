//! The facts of a run before it is judged.

use feeler_engine::RunEnd;

use crate::run::measure::winding::Command;

/// The facts of a run with a contact.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is a fact of its own")]
pub(in crate::run) struct Evidence<'a> {
    pub(in crate::run) end: Option<RunEnd>,
    /// Whether the run has its largest length, so that growth counts as lasting.
    pub(in crate::run) is_longest: bool,
    /// Whether this run is the last, although a longer one might be more conclusive.
    pub(in crate::run) is_last: bool,
    /// Whether a controller was in its approach at the end.
    pub(in crate::run) is_approaching: bool,
    /// Whether the tool, if apart, may still touch.
    pub(in crate::run) is_on_its_way: bool,
    /// Whether nothing can touch, so that `force_n` is the controlled signal, or else a drive's command.
    pub(in crate::run) is_rendered: bool,
    /// Without contact: the desired motion at the rows, if a controller has one.
    pub(in crate::run) wanted: Option<&'a [f64]>,
    /// Whether a surface under the tool, or a body that a series of commands drives, moves to the end.
    pub(in crate::run) surface_moves: bool,
    /// Times of the rows, s.
    pub(in crate::run) t_s: &'a [f64],
    /// The contact force at the rows, N.
    pub(in crate::run) force_n: &'a [f64],
    /// Whether some reference moves to the end.
    pub(in crate::run) driven: bool,
    /// Whether some reference was at rest and has moved only just before the end.
    pub(in crate::run) has_just_moved: bool,
    /// The reference force at the rows, if it moves.
    pub(in crate::run) moving_reference_n: Option<&'a [f64]>,
    /// Time of the last change of the reference or of the first touch, s; `None` without a touch.
    pub(in crate::run) starts_at_s: Option<f64>,
    /// Time of the last loss of contact; `None` if contact lasts to the end.
    pub(in crate::run) lost_at_s: Option<f64>,
    /// Each contact within the settling time: its start, s, and its largest force, N.
    pub(in crate::run) impacts: &'a [(f64, f64)],
    /// Instants of lift-off, s.
    pub(in crate::run) lifts_s: &'a [f64],
    /// Whether a limit was reached, row by row.
    pub(in crate::run) saturated: &'a [bool],
    /// Instants at which something began to stick or slip, s.
    pub(in crate::run) sticks_s: &'a [f64],
    /// Instants at which one side of a free play met or parted, s.
    pub(in crate::run) plays_s: &'a [f64],
    /// The commands of the drives that hold the force.
    pub(in crate::run) commands: &'a [Command<'a>],
    /// Whether something can stick while an integrator winds up a command.
    pub(in crate::run) can_wind_up: bool,
    /// Amplitude that counts as rest, N; `None` without a reference force: 2 % of the mean force then
    /// applies.
    pub(in crate::run) band_n: Option<f64>,
    /// Standard deviation of the readings due to the sensors' noise, N; zero without noise.
    pub(in crate::run) noise_n: f64,
}
