//! Units of columns, by what files state and what numbers show.

use std::borrow::Cow;

use feeler_files::{ColumnUnit, UnitKind, column_unit};
use feeler_logs::Column;
use feeler_problem::short;

use super::role::ColumnRole;

/// A unit other than SI.
#[derive(Clone, Debug, PartialEq)]
pub enum UnitGuess {
    /// A symbol that files take.
    Symbol(Cow<'static, str>),
    /// Counts, with the radians per count.
    Counts(f64),
}

/// Kinds of units of motion.
const MOTION: [UnitKind; 4] = [UnitKind::Length, UnitKind::Angle, UnitKind::Speed, UnitKind::TurningSpeed];
/// Kinds of units of a drive's command.
const DRIVE: [UnitKind; 5] =
    [UnitKind::Force, UnitKind::Torque, UnitKind::Current, UnitKind::Voltage, UnitKind::Share];

impl UnitGuess {
    pub(super) fn symbol(symbol: &'static str) -> Self {
        Self::Symbol(symbol.into())
    }

    fn known(&self) -> Option<ColumnUnit> {
        let Self::Symbol(symbol) = self else { return None };
        column_unit(symbol, &MOTION).or_else(|_| column_unit(symbol, &DRIVE)).ok()
    }

    /// The unit of the speed of numbers in this unit.
    pub(super) fn per_second(&self) -> Self {
        match self {
            Self::Symbol(symbol) => Self::Symbol(format!("{symbol}/s").into()),
            Self::Counts(each) => Self::Counts(*each),
        }
    }

    /// Whether it is one of a slide, or of a joint that turns; `None` if it may be of either.
    pub(super) fn is_straight(&self) -> Option<bool> {
        match self.known()?.kind {
            UnitKind::Length | UnitKind::Speed => Some(true),
            UnitKind::Angle | UnitKind::TurningSpeed => Some(false),
            _ => None,
        }
    }

    /// One of it in SI.
    pub(super) fn in_si(&self) -> f64 {
        match self {
            Self::Symbol(_) => self.known().map_or(1.0, |unit| unit.in_si),
            Self::Counts(each) => *each,
        }
    }

    /// Whether a column of the machine takes it as its `unit`. Amperes and volts of a force drive are a
    /// `scale`.
    pub(super) fn is_of_the_signal(&self) -> bool {
        let is_electric = |kind| matches!(kind, UnitKind::Current | UnitKind::Voltage | UnitKind::Share);
        self.known().is_some_and(|unit| !is_electric(unit.kind))
    }
}

/// Counts of one turn of common encoders.
const TURNS: [f64; 4] = [1024.0, 4096.0, 16_384.0, 65_536.0];
/// Largest factor by which one motion may differ from another that follows it, in the same unit.
const SAME: f64 = 1.5;
/// No joint in radians exceeds this: larger values are degrees.
const MOST_RADIANS: f64 = 7.0;

/// A unit, and why it is guessed.
pub(super) type Reasoned = Option<(UnitGuess, String)>;

/// The unit of a column, if its file or its name states it.
///
/// # Errors
/// A unit in brackets or below the header that does not exist, or of another quantity.
pub(super) fn stated(role: ColumnRole, column: &Column) -> Result<Reasoned, String> {
    let kinds: &[UnitKind] = match role {
        ColumnRole::Target | ColumnRole::Position => &MOTION[..2],
        ColumnRole::TargetVelocity => &MOTION[2..],
        ColumnRole::Command | ColumnRole::FeedForward => &DRIVE,
        ColumnRole::Velocity | ColumnRole::Effort => return Ok(None),
    };
    let name = &column.name;
    let in_brackets = (bare(name).len() < name.len()).then(|| &name[bare(name).len()..]);
    let written = column.unit.as_deref().map(|text| (text, STATED_BY_FILE));
    let brackets = [' ', '(', ')', '[', ']'];
    if let Some((text, why)) = written.or_else(|| Some((in_brackets?, STATED_BY_NAME))) {
        let text = text.trim_matches(brackets);
        // Readings of an encoder as they come: their size tells the rest.
        if text.is_empty() || COUNTED.iter().any(|word| text.eq_ignore_ascii_case(word)) {
            return Ok(None);
        }
        let unit = column_unit(text, kinds).map_err(|what| format!("the unit of `{name}`: {what}"))?;
        return Ok(guess(unit, role, why));
    }
    // `_deg`, `_mm`, `_rad_s`, `_deg_per_s`: the longest end that is a unit of this quantity.
    let parts: Vec<&str> = name.trim_end_matches(']').split('_').collect();
    let ends = (1..parts.len().min(4)).rev().map(|count| &parts[parts.len() - count..]);
    let mut spoken = ends.map(|end| match end {
        [before, "per", after] => format!("{before}/{after}"),
        _ => end.join("/"),
    });
    let found = spoken.find_map(|text| column_unit(&text, kinds).ok());
    Ok(found.and_then(|unit| guess(unit, role, STATED_BY_NAME)))
}

/// Why a unit is not a guess.
const STATED_BY_FILE: &str = "the file states it";
const STATED_BY_NAME: &str = "its name ends in it";

/// Whether a unit with this reason is stated.
pub(super) fn is_stated(why: &str) -> bool {
    [STATED_BY_FILE, STATED_BY_NAME].contains(&why)
}

/// Words of a name without the unit at its end.
pub(super) fn without_unit(words: &[String]) -> &[String] {
    let is_unit = |word: &String| {
        word == "per"
            || word.len() > 1 && [&MOTION[..], &DRIVE].iter().any(|of| column_unit(word, of).is_ok())
    };
    // The time of a speed.
    let left = words.iter().rposition(|word| !is_unit(word) && word != "s").map_or(1, |at| at + 1);
    if words[left.min(words.len())..].iter().any(is_unit) { &words[..left] } else { words }
}

/// Words that state numbers without a unit.
const COUNTED: [&str; 8] = ["count", "counts", "tick", "ticks", "raw", "lsb", "steps", "-"];

/// SI needs no word beside the command of a drive.
fn guess(unit: ColumnUnit, role: ColumnRole, why: &str) -> Reasoned {
    let is_plain =
        matches!(role, ColumnRole::Command | ColumnRole::FeedForward) && (unit.in_si - 1.0).abs() < 1e-12;
    (!is_plain).then(|| (UnitGuess::Symbol(unit.symbol.into()), why.into()))
}

/// A name without the unit in brackets behind it: `Ist [deg]`, `q(rad)`. The item of a list stays: `q[a]`.
pub(super) fn bare(name: &str) -> &str {
    let Some(end) = name.chars().last() else { return name };
    let begin = match end {
        ')' => name.rfind('('),
        ']' => name.rfind('[').filter(|at| name[..*at].ends_with(' ')),
        _ => None,
    };
    begin.map_or(name, |at| name[..at].trim_end())
}

/// The unit of a column of positions that states none, if its numbers show that it is not SI.
pub(super) fn by_size(role: ColumnRole, column: &Column) -> Reasoned {
    if !matches!(role, ColumnRole::Target | ColumnRole::Position) || column.unit.is_some() {
        return None;
    }
    let values = || column.values.iter().copied().filter(|x| x.is_finite());
    let most = values().map(f64::abs).fold(0.0, f64::max);
    if most <= MOST_RADIANS {
        return None;
    }
    let is_whole = values().all(|x| x.fract() == 0.0);
    let has_sign = values().any(|x| x < 0.0);
    if is_whole && !has_sign && most > 360.0 {
        let turn = TURNS.into_iter().find(|turn| most < *turn)?;
        let why = format!("whole numbers up to {most}: counts, {turn} a turn");
        return Some((UnitGuess::Counts(std::f64::consts::TAU / turn), why));
    }
    (most <= 1440.0).then(|| (UnitGuess::symbol("deg"), format!("numbers up to {most:.1} are not radians")))
}

/// The unit of a column whose motion is `times` that of another in SI, though it is the same motion. `None`
/// if no common unit makes it so.
pub(super) fn beside(times: f64, other: &str, is_straight: bool) -> Reasoned {
    let counts = TURNS.map(|turn| UnitGuess::Counts(std::f64::consts::TAU / turn));
    let turning = counts.into_iter().chain([UnitGuess::symbol("deg"), UnitGuess::Counts(1e-3)]);
    let straight = [UnitGuess::symbol("mm")];
    let known: Vec<UnitGuess> = if is_straight { straight.into() } else { turning.collect() };
    let off = |unit: &UnitGuess| (times * unit.in_si()).ln().abs();
    let nearest =
        known.into_iter().min_by(|a, b| off(a).total_cmp(&off(b))).filter(|unit| off(unit) < SAME.ln())?;
    Some((nearest, format!("its numbers move {} times as far as `{other}`", short(times))))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 20 would be degrees by the numbers alone.
    #[test]
    fn truth_the_end_of_a_name_tells_its_unit() {
        let found = |name: &str, role| {
            let column = Column { name: name.into(), values: vec![0.0, 20.0], ..Column::default() };
            stated(role, &column).expect("a unit").or_else(|| by_size(role, &column)).map(|(unit, _)| unit)
        };
        assert_eq!(found("encoder_m", ColumnRole::Position), Some(UnitGuess::symbol("m")));
        assert_eq!(found("target[elbow_rad]", ColumnRole::Target), Some(UnitGuess::symbol("rad")));
        assert_eq!(found("elbow_deg", ColumnRole::Position), Some(UnitGuess::symbol("deg")));
        assert_eq!(found("elbow", ColumnRole::Position), Some(UnitGuess::symbol("deg")));
        assert_eq!(found("command_n", ColumnRole::Command), None);
        for name in ["Ist [deg]", "ist (deg)", "ist(deg)"] {
            assert_eq!(found(name, ColumnRole::Position), Some(UnitGuess::symbol("deg")), "{name}");
        }
        for (name, role, symbol) in [
            ("ist [mrad]", ColumnRole::Position, "mrad"),
            ("slide (cm)", ColumnRole::Target, "cm"),
            ("q_des_um", ColumnRole::Target, "um"),
            ("speed_deg_per_s", ColumnRole::TargetVelocity, "deg/s"),
            ("qd_des_mm_s", ColumnRole::TargetVelocity, "mm/s"),
            ("Soll [°]", ColumnRole::Target, "°"),
            ("force_cmd [kN]", ColumnRole::Command, "kN"),
            ("current_cmd_mA", ColumnRole::Command, "mA"),
        ] {
            assert_eq!(found(name, role), Some(UnitGuess::Symbol(symbol.into())), "{name}");
        }
        // The end of a name that is not a unit of the quantity is a name.
        for name in ["q_a", "q_A", "position_n", "joint_s", "target_3"] {
            let column = Column { name: name.into(), values: vec![0.0, 2.0], ..Column::default() };
            assert_eq!(stated(ColumnRole::Position, &column), Ok(None), "{name}");
        }
    }

    #[test]
    fn truth_a_unit_in_brackets_that_does_not_exist_is_refused() {
        for (name, unit, what) in [
            ("ist [degg]", None, "the unit of `ist [degg]`: `degg` is not a unit (perhaps `deg`)"),
            ("ist (N)", None, "`N` is a unit of another quantity"),
            ("ist", Some("furlong"), "`furlong` is not a unit"),
        ] {
            let column = Column { name: name.into(), unit: unit.map(str::to_owned), ..Column::default() };
            let error = stated(ColumnRole::Position, &column).expect_err("refused");
            assert!(error.contains(what), "{error}");
        }
        for (name, unit) in [("ist [raw]", None), ("ist", Some("[-]")), ("ist", Some("counts"))] {
            let column = Column { name: name.into(), unit: unit.map(str::to_owned), ..Column::default() };
            assert_eq!(stated(ColumnRole::Position, &column), Ok(None), "{name}");
        }
    }

    /// A motion in degrees is 57.3 times that in radians.
    #[test]
    fn truth_the_size_of_one_motion_tells_its_unit() {
        let found = |times: f64| beside(times, "target", false).map(|(unit, _)| unit);
        assert_eq!(found(55.0), Some(UnitGuess::symbol("deg")));
        assert_eq!(found(990.0), Some(UnitGuess::Counts(1e-3)));
        assert_eq!(found(640.0), Some(UnitGuess::Counts(std::f64::consts::TAU / 4096.0)));
        assert_eq!([found(0.02), found(4.0), found(1e7)], [None, None, None]);
        assert_eq!(beside(990.0, "x", true).map(|(unit, _)| unit), Some(UnitGuess::symbol("mm")));
        assert_eq!(beside(57.0, "x", true), None);
    }
}
