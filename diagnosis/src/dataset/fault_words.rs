//! Faults of a series and their remedies, in words.

use std::borrow::Cow;

use feeler_plant::names::list;

use super::fault::{FaultKind, Yardstick, as_in};
use super::units::{CURRENT, STATED};

/// Remedy if the position of the machine is unknown.
const NOT_PLACED: &str = "the position of the machine is unknown, so the experiment does not count; check \
                          the encoder, and record again";

/// A smaller scatter is rounding of numbers, SI: no sensor resolves a picometre or a piconewton.
const LEAST_SCATTER: f64 = 1e-12;

impl FaultKind {
    pub(super) fn message(&self) -> String {
        match self {
            Self::MissingColumn { known, .. } if known.is_empty() => "the column is missing".into(),
            Self::MissingColumn { known, .. } => {
                format!("the column is missing: the file has {}", list(known.iter().map(String::as_str)))
            }
            Self::NoCommand => "no column is the command of a drive".into(),
            Self::TooShort { rows: 0 } => "there are no rows below the header".into(),
            Self::TooShort { rows } => format!("only {rows} rows"),
            Self::NotANumber { cells: 1 } => "no number here".into(),
            Self::NotANumber { cells } => format!("no number here ({cells} such cells in the column)"),
            Self::EmptyCells { cells: 1, .. } => "one cell is empty or NaN".into(),
            Self::EmptyCells { cells, longest } => {
                format!("{cells} cells are empty or NaN, the first here, up to {longest} together")
            }
            Self::OtherRate { note } => note.clone(),
            Self::TimeGoesBack => "the time stamp does not advance".into(),
            Self::Gap { seconds } => format!("{seconds:.4} s are missing before this row"),
            Self::LostRows { rows: 1, .. } => "a row is missing before this one".into(),
            Self::LostRows { rows, stretches: 1, longest_s } => {
                format!("{rows} rows ({longest_s:.4} s) are missing before this one")
            }
            Self::LostRows { rows, stretches, longest_s } => format!(
                "{rows} rows are missing, in {stretches} places; the longest is {longest_s:.4} s before this \
                 row"
            ),
            Self::Cut { pieces, checked } => format!(
                "the only experiment: it was cut into {pieces} pieces, of which {checked} are scored and \
                 not fitted"
            ),
            Self::Uneven { share } => {
                format!("rows depart from even spacing by up to {:.0} %", 100.0 * share)
            }
            Self::SlowRows { spacing_s, hold_s } => {
                format!("rows are {spacing_s:.4} s apart, though a command is held for {hold_s} s")
            }
            Self::ShorterHold { every_s, hold_s } => {
                let [every, hold] = [every_s, hold_s].map(|time_s| short(1e3 * time_s));
                format!("changes every {every} ms on average, though it is held for {hold} ms")
            }
            Self::BeyondLimit { rows, largest, limit } => beyond(*rows, *largest, *limit),
            Self::OtherSpacing { spacing_s, usual_s } => {
                let [here, usual] = [spacing_s, usual_s].map(|spacing_s| short(1e3 * spacing_s));
                format!("rows are {here} ms apart, in most experiments {usual} ms")
            }
            Self::Constant { .. } => "the value never changes".into(),
            Self::ConstantCommand => "the command never changes".into(),
            Self::RestingCommand => "the command changes in no experiment".into(),
            Self::CopiedCheck { fitted } => format!("has the same rows as {fitted}, which is fitted"),
            Self::Clipped { value, share, .. } => format!("{:.1} % of rows sit at {value}", 100.0 * share),
            Self::Quantised { step } => {
                format!("values are multiples of {}, coarser than believed", short(*step))
            }
            Self::WeakExcitation { ratio } => format!("varies by only {ratio:.1} times its noise"),
            Self::BelowNoise { ratio } => {
                format!("varies by only {ratio:.2} times its noise, less than noise alone would")
            }
            Self::Units { other, factor, what, experiments } => {
                let (factor, also) = (short(*factor), as_in(*experiments));
                format!("reads {factor} times what `{other}` says of the same motion, about {what}{also}")
            }
            Self::Beside { other, offset, reach, experiments } => format!(
                "is offset by {} from `{other}` on average, though neither moves farther than {}{}",
                short(*offset),
                short(*reach),
                as_in(*experiments)
            ),
            Self::ClockOffset { against, late_s, experiments } => {
                off_clock(against, *late_s) + &as_in(*experiments)
            }
            Self::NoiseNotStated { scatter } if *scatter < LEAST_SCATTER => {
                "no noise is stated, and its readings have none".into()
            }
            Self::NoiseNotStated { scatter } => format!(
                "no noise is stated: taken from the scatter of its readings, {} (one sigma, SI)",
                short(*scatter)
            ),
            Self::SetAside => "all experiments were to be fitted, and none would be left to score: this one \
                               is set aside"
                .into(),
        }
    }

    /// The remedy for a fault of column `column`.
    pub(super) fn remedy(&self, column: &str) -> Cow<'static, str> {
        let remedy = match self {
            Self::MissingColumn { near: Some(near), .. } => {
                let rename =
                    format!("rename `{near}` to `{column}` in the file, or [columns.{column}] to `{near}`");
                return rename.into();
            }
            Self::MissingColumn { near: None, known } if known.is_empty() => {
                "record it, or remove it from [columns]"
            }
            Self::MissingColumn { .. } => {
                "rename the column that it is, or record it, or remove it from [columns]"
            }
            Self::NoCommand => {
                "add one with `signal = \"<actuator>.command\"`: without it nothing drives the prediction"
            }
            Self::TooShort { .. } => "record at least 50 rows",
            Self::NotANumber { .. } => "cut the file there, or record again",
            Self::EmptyCells { cells: 1, .. } => {
                "its value was bridged and counts as unknown; check the recorder if there are more"
            }
            Self::EmptyCells { .. } => {
                "their values were bridged and count as unknown; check the recorder if there are more"
            }
            Self::OtherRate { .. } => "record it at the rate of the others where its band matters",
            Self::TimeGoesBack => "sort the rows, or repair the clock of the recorder",
            Self::Gap { .. } => "split the file here into two experiments",
            Self::LostRows { .. } => {
                "the rows between were bridged and count as unknown; check the recorder's buffer if there \
                 are more"
            }
            Self::Cut { .. } => "record one more with `role = \"check\"` to choose what is scored",
            Self::Uneven { .. } => "series were brought to an even grid by interpolation",
            Self::ShorterHold { .. } => {
                "state the controller's period as `hold`, or remove `hold`; check the unit of time"
            }
            Self::SlowRows { .. } => "bring the time to seconds, or record every command",
            Self::BeyondLimit { .. } => {
                "the drive is taken to give no more than its limit; if it gave more, correct `limit` in the \
                 machine file, or the unit of the column"
            }
            Self::OtherSpacing { .. } => {
                "taken as it is; if the recorder's rate was the same, correct its time stamps"
            }
            Self::Constant { tells_place: true } | Self::Clipped { tells_place: true, .. } => NOT_PLACED,
            Self::Constant { .. } => "the column does not count in this experiment; check the wiring",
            Self::ConstantCommand => "excite the drive, or remove the experiment",
            Self::RestingCommand => {
                "if this drive moves, check its column; otherwise remove it from [columns]"
            }
            Self::CopiedCheck { .. } => {
                "a check must be another measurement: record one, or remove this file"
            }
            Self::Clipped { .. } => "the column does not count in this experiment; widen its range",
            Self::Quantised { .. } => "taken as a finding, not as noise",
            Self::WeakExcitation { .. } => "little information; excite more strongly",
            Self::BelowNoise { .. } => "check the unit of the column, and the `noise` that is stated",
            Self::Units { what, .. } if *what == STATED => {
                "remove its `unit` or `scale`, or state the true one"
            }
            Self::Units { what, .. } if *what == CURRENT => {
                "bring both columns to SI, or correct the mass in the machine file"
            }
            Self::Units { factor, .. } if *factor < 0.0 => "reverse the sign of one of the two columns",
            Self::Units { .. } => "bring both columns to SI",
            Self::Beside { .. } => {
                "state the `offset` of the column with the other zero, unless a load holds it there"
            }
            Self::ClockOffset { .. } => {
                "shift the column; if the sensor itself is late, set its `delay` in the machine file"
            }
            Self::NoiseNotStated { .. } => {
                "state `noise` under its column or sensor, from a record at rest, for a known floor"
            }
            Self::SetAside => "give one `role = \"check\"` to choose which",
        };
        remedy.into()
    }
}

/// The delay of a column and its reference, in words.
fn off_clock(against: &Yardstick, late_s: f64) -> String {
    let late_ms = format!("{:.3} ms", 1e3 * late_s.abs());
    let (later, side) = if late_s > 0.0 { ("later", "behind") } else { ("earlier", "ahead of") };
    match against {
        Yardstick::Itself { file } => {
            format!("runs {late_ms} {later} here than in {file}, each against what moves with it")
        }
        Yardstick::Column(other) => format!("runs {late_ms} {side} `{other}`"),
        Yardstick::ColumnAsIn { other, file } => {
            format!("runs {late_ms} {side} `{other}`, compared with {file}")
        }
    }
}

/// A number with about four significant digits.
fn short(factor: f64) -> String {
    if (0.1..1e4).contains(&factor.abs()) { format!("{factor:.3}") } else { format!("{factor:.3e}") }
}

fn beyond(rows: usize, largest: f64, limit: f64) -> String {
    let [largest, limit] = [largest, limit].map(short);
    format!("{rows} rows exceed the limit of the drive, {limit}; the largest is {largest}")
}
