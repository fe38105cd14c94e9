//! Faults of measured series. Each has a file, column, row and remedy, and is either fatal or a warning.

use std::borrow::Cow;
use std::fmt;

use feeler_plant::names::list;
use feeler_problem::Problem;

/// The kind of a fault of a series.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum FaultKind {
    /// The file has no such column.
    MissingColumn {
        /// A similar header that is not assigned to another column.
        near: Option<String>,
        /// All headers that are not assigned to another column.
        known: Vec<String>,
    },
    /// No column of the dataset commands a drive.
    NoCommand,
    /// The file has fewer rows than a prediction needs.
    TooShort {
        /// Rows of the file.
        rows: usize,
    },
    /// A cell is empty or not a number.
    NotANumber {
        /// Number of such cells in the column.
        cells: usize,
    },
    /// A few cells are empty; they are bridged, and count as unknown.
    EmptyCells {
        /// Number of empty cells in the column.
        cells: usize,
        /// Longest run of empty cells, rows.
        longest: usize,
    },
    /// Columns were recorded at several rates.
    OtherRate {
        /// The column, its rate, and how it was resampled.
        note: String,
    },
    /// The time stamp is not later than the previous one.
    TimeGoesBack,
    /// Rows are missing.
    Gap {
        /// Length, s.
        seconds: f64,
    },
    /// The recorder lost a few rows; they are bridged, and count as unknown.
    LostRows {
        /// Number of lost rows.
        rows: usize,
        /// Number of stretches.
        stretches: usize,
        /// Longest stretch, s.
        longest_s: f64,
    },
    /// The only experiment was cut into pieces, so that some could be scored.
    Cut {
        /// Number of pieces.
        pieces: usize,
        /// Number of scored pieces.
        checked: usize,
    },
    /// Rows are not evenly spaced.
    Uneven {
        /// Largest departure from the mean spacing, as a fraction of it.
        share: f64,
    },
    /// Rows are much farther apart than the hold time of commands.
    SlowRows {
        /// Spacing of the rows, s.
        spacing_s: f64,
        /// Hold time of a command, s.
        hold_s: f64,
    },
    /// Row spacing differs slightly from that of other experiments, as with a fast or slow clock.
    OtherSpacing {
        /// Spacing of the rows, s.
        spacing_s: f64,
        /// Spacing in most experiments, s.
        usual_s: f64,
    },
    /// Every row has the same value.
    Constant {
        /// Whether the channel measures the position of the machine.
        tells_place: bool,
    },
    /// The command never changes, so that it excites nothing.
    ConstantCommand,
    /// The largest or smallest value repeats in many consecutive rows, as in a saturated converter.
    Clipped {
        /// The value.
        value: f64,
        /// Share of rows at this value.
        share: f64,
        /// Whether the channel measures the position of the machine.
        tells_place: bool,
    },
    /// All values are multiples of a step coarser than believed.
    Quantised {
        /// The step, signal units.
        step: f64,
    },
    /// The variation of the series hardly exceeds its noise.
    WeakExcitation {
        /// Variation over noise.
        ratio: f64,
    },
    /// The series varies less than noise alone would: its stated noise or unit is wrong.
    BelowNoise {
        /// Variation over noise.
        ratio: f64,
    },
    /// Two channels of the same motion differ by a conversion factor of units.
    Units {
        /// The other column.
        other: String,
        /// Ratio of this column to the other.
        factor: f64,
        /// The factor in words.
        what: &'static str,
        /// Number of experiments that show it.
        experiments: usize,
    },
    /// Two channels that must move together are shifted in time.
    ClockOffset {
        /// The reference of the comparison.
        against: Yardstick,
        /// Delay of this channel, s.
        late_s: f64,
        /// Number of experiments that show it.
        experiments: usize,
    },
    /// Neither the column nor its sensor states a noise.
    NoiseNotStated {
        /// Standard deviation of the readings' scatter, signal units. It replaces the missing noise.
        scatter: f64,
    },
    /// All experiments were to be fitted; this one was set aside for scoring.
    SetAside,
}

/// The reference of a column's clock.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Yardstick {
    /// Another column of the same experiment.
    Column(String),
    /// The same column in another experiment. Each is compared with its own motion.
    Itself {
        /// The other experiment.
        file: String,
    },
    /// Another column of the same experiment, which is synchronous in another experiment.
    ColumnAsIn {
        /// The other column.
        other: String,
        /// The other experiment.
        file: String,
    },
}

/// Remedy if the position of the machine is unknown.
const NOT_PLACED: &str = "the position of the machine is unknown, so the experiment does not count; check \
                          the encoder, and record again";

impl FaultKind {
    /// Whether the fault cannot be repaired by a stated assumption.
    pub fn is_fatal(&self) -> bool {
        matches!(
            self,
            Self::MissingColumn { .. }
                | Self::NoCommand
                | Self::TooShort { .. }
                | Self::NotANumber { .. }
                | Self::TimeGoesBack
                | Self::Gap { .. }
                | Self::ConstantCommand
                | Self::SlowRows { .. }
        )
    }

    /// Whether the records contradict each other, so that a diagnosis may find the fault instead of a cause.
    pub fn is_contradiction(&self) -> bool {
        matches!(self, Self::Units { .. } | Self::ClockOffset { .. } | Self::BelowNoise { .. })
    }

    fn message_and_remedy(&self, column: &str) -> (String, Cow<'static, str>) {
        let (message, remedy) = match self {
            Self::MissingColumn { near, known } => {
                let there = if known.is_empty() {
                    String::new()
                } else {
                    format!(": the file has {}", list(known.iter().map(String::as_str)))
                };
                let rename = |near: &String| {
                    format!("rename `{near}` to `{column}` in the file, or [columns.{column}] to `{near}`")
                };
                let others = if known.is_empty() { "" } else { "rename the column that it is, or " };
                let remedy = near
                    .as_ref()
                    .map_or_else(|| format!("{others}record it, or take it out of [columns]"), rename);
                return (format!("the column is missing{there}"), remedy.into());
            }
            Self::NoCommand => (
                "no column is the command of a drive".into(),
                "add one with `signal = \"<actuator>.command\"`: without it nothing drives the prediction",
            ),
            Self::TooShort { rows: 0 } => {
                ("there are no rows below the header".into(), "record at least 50 rows")
            }
            Self::TooShort { rows } => (format!("only {rows} rows"), "record at least 50 rows"),
            Self::NotANumber { cells } => (
                format!("no number here ({cells} such cells in the column)"),
                "cut the file there, or record again",
            ),
            Self::EmptyCells { cells: 1, .. } => (
                "one cell is empty".into(),
                "its value was bridged and counts as unknown; look at the recorder if there are more",
            ),
            Self::EmptyCells { cells, longest } => (
                format!("{cells} cells are empty, the first here, up to {longest} together"),
                "their values were bridged and count as unknown; look at the recorder if they become more",
            ),
            Self::OtherRate { note } => {
                (note.clone(), "record it at the rate of the others where its band matters")
            }
            Self::TimeGoesBack => (
                "the time stamp does not advance".into(),
                "sort the rows, or repair the clock of the recorder",
            ),
            Self::Gap { seconds } => (
                format!("{seconds:.4} s are missing before this row"),
                "split the file here into two experiments",
            ),
            Self::LostRows { rows, stretches, longest_s } => (
                match (rows, stretches) {
                    (1, _) => "a row is missing before this one".into(),
                    (_, 1) => format!("{rows} rows ({longest_s:.4} s) are missing before this one"),
                    _ => format!(
                        "{rows} rows are missing, in {stretches} places; the longest is {longest_s:.4} s \
                         before this row"
                    ),
                },
                "the rows between were bridged and count as unknown; look at the recorder's buffer if they \
                 become more",
            ),
            Self::Cut { pieces, checked } => (
                format!(
                    "the only experiment: it was cut into {pieces} pieces, of which {checked} are scored \
                     and not fitted"
                ),
                "record one more with `role = \"check\"` to choose what is scored",
            ),
            Self::Uneven { share } => (
                format!("rows depart from even spacing by up to {:.0} %", 100.0 * share),
                "series were brought to an even grid by interpolation",
            ),
            Self::SlowRows { spacing_s, hold_s } => (
                format!("rows are {spacing_s:.4} s apart, though a command is held for {hold_s} s"),
                "bring the time to seconds, or record every command",
            ),
            Self::OtherSpacing { spacing_s, usual_s } => (
                format!(
                    "rows are {} ms apart, in most experiments {} ms",
                    short(1e3 * spacing_s),
                    short(1e3 * usual_s)
                ),
                "taken as it is; if the recorder's rate was the same, mend its time stamps",
            ),
            Self::Constant { tells_place: false } => (
                "the value never changes".into(),
                "the column does not count in this experiment; check the wiring",
            ),
            Self::Constant { tells_place: true } => ("the value never changes".into(), NOT_PLACED),
            Self::ConstantCommand => {
                ("the command never changes".into(), "excite the drive, or remove the experiment")
            }
            Self::Clipped { value, share, tells_place } => {
                let remedy = if *tells_place {
                    NOT_PLACED
                } else {
                    "the column does not count in this experiment; widen its range"
                };
                (format!("{:.1} % of rows sit at {value}", 100.0 * share), remedy)
            }
            Self::Quantised { step } => (
                format!("values are multiples of {}, coarser than believed", short(*step)),
                "taken as a finding, not as noise",
            ),
            Self::WeakExcitation { ratio } => (
                format!("the series varies only {ratio:.1} times its noise"),
                "it carries little information; excite more strongly",
            ),
            Self::BelowNoise { ratio } => (
                format!("the series varies only {ratio:.2} times its noise, less than noise alone would"),
                "check the unit of the column, and the `noise` that is stated",
            ),
            Self::Units { other, factor, what, experiments } => (
                format!(
                    "reads {} times what `{other}` says of the same motion, about {what}{}",
                    short(*factor),
                    as_in(*experiments)
                ),
                if *factor < 0.0 {
                    "turn the sign of one of the two columns"
                } else {
                    "bring both columns to SI"
                },
            ),
            Self::ClockOffset { against, late_s, experiments } => {
                let late_ms = format!("{:.3} ms", 1e3 * late_s.abs());
                let (later, side) = if *late_s > 0.0 { ("later", "behind") } else { ("earlier", "ahead of") };
                let message = match against {
                    Yardstick::Itself { file } => {
                        format!("runs {late_ms} {later} here than in {file}, each against what moves with it")
                    }
                    Yardstick::Column(other) => format!("runs {late_ms} {side} `{other}`"),
                    Yardstick::ColumnAsIn { other, file } => {
                        format!("runs {late_ms} {side} `{other}`, compared with {file}")
                    }
                } + &as_in(*experiments);
                (
                    message,
                    "shift the column; if the sensor itself is late, set its `delay` in the machine file",
                )
            }
            Self::NoiseNotStated { scatter } => (
                format!(
                    "no noise is stated: taken from the scatter of its readings, {scatter:.1e} (one sigma, \
                     SI)"
                ),
                "state `noise` under its column or sensor, from a record at rest, for a known floor",
            ),
            Self::SetAside => (
                "all experiments were to be fitted, and none would be left to score: this one is set aside"
                    .into(),
                "give one `role = \"check\"` to choose which",
            ),
        };
        (message, remedy.into())
    }
}

/// A number with four digits, of any magnitude.
fn short(factor: f64) -> String {
    if (0.1..1e4).contains(&factor.abs()) { format!("{factor:.3}") } else { format!("{factor:.3e}") }
}

fn as_in(experiments: usize) -> String {
    match experiments {
        0 | 1 => String::new(),
        2 => ", as in another experiment".into(),
        n => format!(", as in {} other experiments", n - 1),
    }
}

/// A fault with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// The file.
    pub file: String,
    /// The column, if one is affected.
    pub column: Option<String>,
    /// The row in the file, if one is affected. The header is row 1.
    pub row: Option<usize>,
    /// The kind of the fault.
    pub kind: FaultKind,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.problem().fmt(f)
    }
}

impl Fault {
    /// File, row and column, as far as they are known.
    pub fn place(&self) -> String {
        let row = self.row.map_or_else(String::new, |row| format!(":{row}"));
        let column = self.column.as_ref().map_or_else(String::new, |column| format!(": `{column}`"));
        format!("{}{row}{column}", self.file)
    }

    /// The remedy.
    pub fn remedy(&self) -> String {
        self.problem().remedy
    }

    /// Place, message and remedy.
    pub fn problem(&self) -> Problem {
        let (message, remedy) = self.kind.message_and_remedy(self.column.as_deref().unwrap_or_default());
        Problem::new(self.place(), message, remedy)
    }
}

/// The problems of faults. A fault that columns of several experiments share is reported once, at the first.
pub fn problems(faults: &[Fault]) -> Vec<Problem> {
    let mut told: Vec<(&Fault, usize)> = Vec::new();
    for fault in faults {
        match told.iter_mut().find(|(known, _)| known.is_shared_by(fault)) {
            Some((_, others)) => *others += 1,
            None => told.push((fault, 0)),
        }
    }
    let of = |(fault, others): (&Fault, usize)| {
        let mut problem = fault.problem();
        let also = match others {
            0 => String::new(),
            1 => ", as in another experiment".to_owned(),
            n => format!(", as in {n} other experiments"),
        };
        problem.message.push_str(&also);
        problem
    };
    told.into_iter().map(of).collect()
}

/// Describes each fault in one sentence.
pub fn in_words(faults: &[Fault]) -> Vec<String> {
    problems(faults).iter().map(Problem::to_string).collect()
}

impl Fault {
    /// Whether another experiment has the same fault in the same column, by about the same amount.
    fn is_shared_by(&self, other: &Self) -> bool {
        let is_alike = match (&self.kind, &other.kind) {
            (FaultKind::MissingColumn { near: a, .. }, FaultKind::MissingColumn { near: b, .. }) => a == b,
            (FaultKind::Constant { .. }, FaultKind::Constant { .. })
            | (FaultKind::ConstantCommand, FaultKind::ConstantCommand)
            | (FaultKind::SlowRows { .. }, FaultKind::SlowRows { .. })
            | (FaultKind::WeakExcitation { .. }, FaultKind::WeakExcitation { .. })
            | (FaultKind::BelowNoise { .. }, FaultKind::BelowNoise { .. }) => true,
            (FaultKind::Quantised { step: a }, FaultKind::Quantised { step: b }) => {
                (a / b - 1.0).abs() < 0.01
            }
            _ => false,
        };
        is_alike && self.column == other.column && self.file != other.file
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(kind: FaultKind) -> String {
        Fault { file: "c.csv".into(), column: Some("command_n".into()), row: None, kind }.to_string()
    }

    #[test]
    fn truth_a_sign_is_turned_and_a_unit_brought_to_si() {
        let units = |factor, what| {
            fault(FaultKind::Units { other: "encoder_m".into(), factor, what, experiments: 1 })
        };
        assert!(units(-1.01, "-1 (a sign?)").ends_with("(turn the sign of one of the two columns)"));
        assert!(units(1000.0, "1000 (mm for m?)").ends_with("(bring both columns to SI)"));
    }

    #[test]
    fn truth_a_column_that_is_late_against_another_file_reads_so() {
        let late = |late_s| {
            fault(FaultKind::ClockOffset {
                against: Yardstick::Itself { file: "b.csv".into() },
                late_s,
                experiments: 1,
            })
        };
        assert!(late(0.0501).starts_with(
            "c.csv: `command_n`: runs 50.100 ms later here than in b.csv, each against what moves with it ("
        ));
        assert!(late(-0.0501).starts_with("c.csv: `command_n`: runs 50.100 ms earlier here than in b.csv"));
    }
}
