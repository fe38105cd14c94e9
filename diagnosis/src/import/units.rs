//! Units of columns, by what files state and what numbers show.

use feeler_logs::Column;

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
/// No joint in radians exceeds this: larger values are degrees.
const MOST_RADIANS: f64 = 7.0;

/// The unit of a column of positions or their targets' speeds, if the file states it or the numbers of
/// positions show that it is not SI.
pub(super) fn unit(role: Role, column: &Column) -> Option<(UnitGuess, String)> {
    let known = match role {
        Role::Target | Role::Position => ["deg", "mm", "rad", "m"],
        Role::TargetVelocity => ["deg/s", "mm/s", "rad/s", "m/s"],
        _ => return None,
    };
    if let Some(stated) = &column.unit {
        let known = known.into_iter().find(|symbol| symbol == stated)?;
        return Some((UnitGuess::Symbol(known), "the file states it".into()));
    }
    if role == Role::TargetVelocity {
        return None;
    }
    let ending = column.name.trim_end_matches(']').rsplit_once('_').map(|(_, ending)| ending);
    if let Some(named) = known.into_iter().find(|symbol| ending == Some(*symbol)) {
        return Some((UnitGuess::Symbol(named), "its name ends in it".into()));
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

#[cfg(test)]
mod tests {
    use super::*;

    /// 20 would be degrees by the numbers alone.
    #[test]
    fn truth_the_end_of_a_name_tells_its_unit() {
        let found = |name: &str, role| {
            let column = Column { name: name.into(), values: vec![0.0, 20.0], ..Column::default() };
            unit(role, &column).map(|(unit, _)| unit)
        };
        assert_eq!(found("encoder_m", Role::Position), Some(UnitGuess::Symbol("m")));
        assert_eq!(found("target[elbow_rad]", Role::Target), Some(UnitGuess::Symbol("rad")));
        assert_eq!(found("elbow_deg", Role::Position), Some(UnitGuess::Symbol("deg")));
        assert_eq!(found("elbow", Role::Position), Some(UnitGuess::Symbol("deg")));
        assert_eq!(found("command_n", Role::Command), None);
    }
}
