//! Faults of measured series. Each has a file, column, row and remedy, and is either fatal or a warning.

use std::fmt;

use feeler_problem::Problem;

/// The kind of a fault of a series.
#[derive(Clone, Debug, PartialEq)]
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
    TooShort { rows: usize },
    /// A cell is empty or not a number.
    NotANumber {
        /// Number of such cells in the column.
        cells: usize,
    },
    /// A few cells are empty. They are interpolated and marked as unread.
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
    Gap { seconds: f64 },
    /// The recorder lost a few rows. They are interpolated and marked as unread.
    LostRows {
        /// Number of lost rows.
        rows: usize,
        stretches: usize,
        longest_s: f64,
    },
    /// The only experiment was cut into pieces so that some can be scored.
    Cut {
        pieces: usize,
        /// Number of scored pieces.
        checked: usize,
    },
    /// Rows are not evenly spaced.
    Uneven {
        /// Largest deviation from the mean spacing, as a fraction of the mean.
        share: f64,
    },
    /// Rows are much farther apart than the hold time of commands.
    SlowRows { spacing_s: f64, hold_s: f64 },
    /// A force command exceeds the limit of its drive.
    BeyondLimit {
        /// Number of such rows.
        rows: usize,
        /// Largest size of the command.
        largest: f64,
        limit: f64,
    },
    /// A command changes much more often than its hold time allows.
    ShorterHold { every_s: f64, hold_s: f64 },
    /// Row spacing differs slightly from that of other experiments, as with a fast or slow clock.
    OtherSpacing {
        spacing_s: f64,
        /// Spacing in most experiments, s.
        usual_s: f64,
    },
    /// Every row has the same value.
    Constant {
        /// Whether the channel measures the position of the machine.
        tells_place: bool,
    },
    /// No command changes, so that nothing excites the machine.
    ConstantCommand,
    /// A command is constant in every experiment, while others change.
    RestingCommand,
    /// A check has the rows of a fitted experiment, so that it would score the fit and not a prediction.
    CopiedCheck {
        /// The fitted file.
        fitted: String,
    },
    /// The largest or smallest value repeats in many consecutive rows, as in a saturated converter.
    Clipped {
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
    /// The ratio of two channels of the same motion is a conversion factor between units.
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
    /// The offset of a position from its target exceeds its whole motion.
    Beside {
        /// Column of the target.
        other: String,
        /// Mean offset.
        offset: f64,
        /// Largest excursion of either column.
        reach: f64,
        /// Number of experiments that show it.
        experiments: usize,
    },
    /// Two channels that must change together are shifted in time.
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
    /// No experiment was reserved for checking, so this one was set aside for scoring.
    SetAside,
}

/// The reference of a column's clock.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Yardstick {
    /// Another column of the same experiment.
    Column(String),
    /// The same column in another experiment. Each column is compared with the motion of its own experiment.
    Itself {
        /// The other experiment.
        file: String,
    },
    /// Another column of the same experiment. The two are synchronous in another experiment.
    ColumnAsIn {
        /// The other column.
        other: String,
        /// The other experiment.
        file: String,
    },
}

impl FaultKind {
    /// Whether the fault cannot be repaired by a stated assumption.
    pub(crate) fn is_fatal(&self) -> bool {
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
                | Self::CopiedCheck { .. }
        )
    }

    /// Whether the records contradict each other, so that a diagnosis may find the fault instead of a cause.
    pub fn is_contradiction(&self) -> bool {
        matches!(self, Self::Units { .. } | Self::ClockOffset { .. } | Self::BelowNoise { .. })
    }
}

/// A fault with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    pub file: String,
    /// The column, if one is affected.
    pub column: Option<String>,
    /// The row in the file, if one is affected. The header is row 1.
    pub row: Option<usize>,
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
        let remedy = self.kind.remedy(self.column.as_deref().unwrap_or_default());
        Problem::new(self.place(), self.kind.message(), remedy)
    }
}

/// Messages for faults. A fault that the same columns of several experiments have is reported once, for the
/// first.
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
        problem.message.push_str(&as_in(others + 1));
        problem
    };
    told.into_iter().map(of).collect()
}

/// Phrase that says how many experiments show a fault.
pub(super) fn as_in(experiments: usize) -> String {
    match experiments {
        0 | 1 => String::new(),
        2 => ", as in another experiment".into(),
        n => format!(", as in {} other experiments", n - 1),
    }
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
            | (FaultKind::ShorterHold { .. }, FaultKind::ShorterHold { .. })
            | (FaultKind::BeyondLimit { .. }, FaultKind::BeyondLimit { .. })
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
        assert!(units(-1.01, "-1 (a sign?)").ends_with("(reverse the sign of one of the two columns)"));
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
