//! Units as headers of logs state them: `deg/s`, `Nm`, `DEGREES`.

use super::bases::{Bases, ELSEWHERE, SYMBOLS};
use super::{UnitError, unit_bases};

/// The quantity of a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitKind {
    Length,
    Angle,
    Speed,
    TurningSpeed,
    Force,
    Torque,
    Current,
    Voltage,
    /// A share: 1 or %.
    Share,
    Other,
}

/// A unit of the numbers in a column.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnUnit {
    /// As files take it.
    pub symbol: String,
    /// One of it in SI.
    pub in_si: f64,
    pub kind: UnitKind,
}

/// Units that represent each kind.
const KINDS: [(&str, UnitKind); 9] = [
    ("m", UnitKind::Length),
    ("rad", UnitKind::Angle),
    ("m/s", UnitKind::Speed),
    ("rad/s", UnitKind::TurningSpeed),
    ("N", UnitKind::Force),
    ("N m", UnitKind::Torque),
    ("A", UnitKind::Current),
    ("V", UnitKind::Voltage),
    ("1", UnitKind::Share),
];

fn kind(bases: Bases) -> UnitKind {
    let is = |symbol: &str| unit_bases(symbol).is_ok_and(|(_, other)| bases.is_like(other));
    KINDS.iter().find(|(symbol, _)| is(symbol)).map_or(UnitKind::Other, |(_, kind)| *kind)
}

/// The unit that a text states, if it is one of the `kinds`. Headers are often careless about case (`nm` of a
/// torque) and write units out, so other readings count too, if the text itself is not such a unit.
///
/// # Errors
/// A text that is not a unit, with the nearest one, or a unit of another quantity.
pub fn column_unit(text: &str, kinds: &[UnitKind]) -> Result<ColumnUnit, String> {
    let text = text.trim();
    let alike = |name: &str| name.eq_ignore_ascii_case(text);
    let elsewhere = ELSEWHERE.iter().filter(|(name, _)| alike(name)).map(|(_, unit)| (*unit).to_owned());
    let symbols =
        SYMBOLS.iter().filter(|(symbol, ..)| alike(symbol)).map(|(symbol, ..)| (*symbol).to_owned());
    let readings =
        std::iter::once(text.to_owned()).chain(elsewhere).chain(symbols).chain([text.to_lowercase()]);
    let mut first = None;
    for symbol in readings {
        match unit_bases(&symbol) {
            Ok((in_si, bases)) if kinds.contains(&kind(bases)) => {
                return Ok(ColumnUnit { symbol, in_si, kind: kind(bases) });
            }
            Ok(_) => {
                first.get_or_insert_with(|| format!("`{text}` is a unit of another quantity"));
            }
            Err(error) => {
                first.get_or_insert_with(|| match error {
                    UnitError::UnknownUnit { nearest: Some(nearest), .. } => {
                        format!("`{text}` is not a unit (perhaps `{nearest}`)")
                    }
                    _ => format!("`{text}` is not a unit"),
                });
            }
        }
    }
    Err(first.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_headers_state_units_in_many_ways() {
        use UnitKind::{Angle, Current, Force, Length, Speed, Torque, TurningSpeed};
        let motion = [Length, Angle, Speed, TurningSpeed];
        let drive = [Force, Torque, Current];
        for (text, kinds, symbol, in_si) in [
            ("deg", &motion[..], "deg", 1_f64.to_radians()),
            ("Degrees", &motion, "deg", 1_f64.to_radians()),
            ("°/s", &motion, "°/s", 1_f64.to_radians()),
            ("mrad", &motion, "mrad", 1e-3),
            ("cm", &motion, "cm", 1e-2),
            ("MM", &motion, "mm", 1e-3),
            ("rpm", &motion, "rpm", std::f64::consts::PI / 30.0),
            // Nanometres of a torque are newton metres of a careless header.
            ("nm", &drive, "N m", 1.0),
            ("nm", &motion, "nm", 1e-9),
            ("Nm", &drive, "N m", 1.0),
            ("mNm", &drive, "mN m", 1e-3),
            ("kN", &drive, "kN", 1e3),
            ("mA", &drive, "mA", 1e-3),
        ] {
            let found = column_unit(text, kinds).unwrap_or_else(|error| panic!("{text}: {error}"));
            assert_eq!(found.symbol, symbol, "{text}");
            assert!((found.in_si - in_si).abs() < 1e-15 * in_si, "{text}: {}", found.in_si);
        }
        assert_eq!(column_unit("N", &motion), Err("`N` is a unit of another quantity".into()));
        assert_eq!(column_unit("degg", &motion), Err("`degg` is not a unit (perhaps `deg`)".into()));
        assert_eq!(column_unit("furlong", &motion), Err("`furlong` is not a unit".into()));
    }
}
