//! Units of columns, by what files state and what numbers show.

use feeler_logs::Column;
use feeler_problem::short;

use super::role::Role;

/// A unit other than SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UnitGuess {
    /// A symbol that files take.
    Symbol(&'static str),
    /// Counts, with the radians per count.
    Counts(f64),
}

impl UnitGuess {
    /// The unit of the speed of numbers in this unit.
    pub(super) fn per_second(self) -> Self {
        match self {
            Self::Symbol("deg") => Self::Symbol("deg/s"),
            Self::Symbol("mm") => Self::Symbol("mm/s"),
            Self::Symbol("rad") => Self::Symbol("rad/s"),
            Self::Symbol("m") => Self::Symbol("m/s"),
            other => other,
        }
    }

    /// Whether it is one of a slide, or of a joint that turns; `None` if it may be of either.
    pub(super) fn is_straight(self) -> Option<bool> {
        match self {
            Self::Symbol(symbol) => Some(symbol.starts_with('m')),
            Self::Counts(_) => None,
        }
    }

    /// One of it in SI.
    pub(super) fn in_si(self) -> f64 {
        match self {
            Self::Symbol("deg" | "deg/s") => 1.0_f64.to_radians(),
            Self::Symbol("mm" | "mm/s") => 1e-3,
            Self::Symbol(_) => 1.0,
            Self::Counts(each) => each,
        }
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

/// The unit of a column of positions or their targets' speeds, if its file or its name states it.
pub(super) fn stated(role: Role, column: &Column) -> Reasoned {
    let known = match role {
        Role::Target | Role::Position => ["deg", "mm", "rad", "m"],
        Role::TargetVelocity => ["deg/s", "mm/s", "rad/s", "m/s"],
        _ => return None,
    };
    if let Some(stated) = &column.unit {
        let known = known.into_iter().find(|symbol| symbol == stated)?;
        return Some((UnitGuess::Symbol(known), "the file states it".into()));
    }
    let name = &column.name;
    let in_brackets = (bare(name).len() < name.len())
        .then(|| name[bare(name).len()..].trim_matches([' ', '(', ')', '[', ']']));
    let ending =
        in_brackets.or_else(|| name.trim_end_matches(']').rsplit_once('_').map(|(_, ending)| ending));
    let named = known.into_iter().find(|symbol| ending == Some(*symbol))?;
    Some((UnitGuess::Symbol(named), "its name ends in it".into()))
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
pub(super) fn by_size(role: Role, column: &Column) -> Reasoned {
    if !matches!(role, Role::Target | Role::Position) || column.unit.is_some() {
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
    (most <= 1440.0).then(|| (UnitGuess::Symbol("deg"), format!("numbers up to {most:.1} are not radians")))
}

/// The unit of a column whose motion is `times` that of another in SI, though it is the same motion. `None`
/// if no common unit makes it so.
pub(super) fn beside(times: f64, other: &str, is_straight: bool) -> Reasoned {
    let counts = TURNS.map(|turn| UnitGuess::Counts(std::f64::consts::TAU / turn));
    let turning = counts.into_iter().chain([UnitGuess::Symbol("deg"), UnitGuess::Counts(1e-3)]);
    let straight = [UnitGuess::Symbol("mm")];
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
            stated(role, &column).or_else(|| by_size(role, &column)).map(|(unit, _)| unit)
        };
        assert_eq!(found("encoder_m", Role::Position), Some(UnitGuess::Symbol("m")));
        assert_eq!(found("target[elbow_rad]", Role::Target), Some(UnitGuess::Symbol("rad")));
        assert_eq!(found("elbow_deg", Role::Position), Some(UnitGuess::Symbol("deg")));
        assert_eq!(found("elbow", Role::Position), Some(UnitGuess::Symbol("deg")));
        assert_eq!(found("command_n", Role::Command), None);
        for name in ["Ist [deg]", "ist (deg)", "ist(deg)"] {
            assert_eq!(found(name, Role::Position), Some(UnitGuess::Symbol("deg")), "{name}");
        }
    }
    /// A motion in degrees is 57.3 times that in radians.
    #[test]
    fn truth_the_size_of_one_motion_tells_its_unit() {
        let found = |times: f64| beside(times, "target", false).map(|(unit, _)| unit);
        assert_eq!(found(55.0), Some(UnitGuess::Symbol("deg")));
        assert_eq!(found(990.0), Some(UnitGuess::Counts(1e-3)));
        assert_eq!(found(640.0), Some(UnitGuess::Counts(std::f64::consts::TAU / 4096.0)));
        assert_eq!([found(0.02), found(4.0), found(1e7)], [None; 3]);
        assert_eq!(beside(990.0, "x", true).map(|(unit, _)| unit), Some(UnitGuess::Symbol("mm")));
        assert_eq!(beside(57.0, "x", true), None);
    }
}
