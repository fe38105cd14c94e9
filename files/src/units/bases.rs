//! Symbols of units, and the bases that they stand for.

use std::f64::consts::PI;
use std::fmt::Write as _;

use feeler_catalogue::{Dimension, same_exponent};

/// Exponents of kg, m, s, A and rad. The radian is distinct from pure numbers, so that `rad/s` is not read as
/// `Hz`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bases {
    kg: f64,
    m: f64,
    s: f64,
    rad: f64,
    ampere: f64,
}

impl Bases {
    const fn new(kg: f64, m: f64, s: f64, rad: f64) -> Self {
        Self { kg, m, s, rad, ampere: 0.0 }
    }

    const fn electric(kg: f64, m: f64, s: f64, ampere: f64) -> Self {
        Self { kg, m, s, rad: 0.0, ampere }
    }

    pub(super) fn add(&mut self, other: Self, times: f64) {
        self.kg += times * other.kg;
        self.m += times * other.m;
        self.s += times * other.s;
        self.rad += times * other.rad;
        self.ampere += times * other.ampere;
    }

    pub(super) fn is_like(self, other: Self) -> bool {
        let exponents = |of: Self| [of.kg, of.m, of.s, of.rad, of.ampere];
        exponents(self).into_iter().zip(exponents(other)).all(|(own, other)| same_exponent(own, other))
    }

    /// Whether these bases represent `dim` on the given axis.
    pub(super) fn fit(self, dim: Dimension, rotational: bool) -> bool {
        if dim.unknown {
            return true;
        }
        let alike = [(self.kg, dim.mass), (self.s, dim.time), (self.ampere, dim.current)];
        if !alike.iter().all(|(own, other)| same_exponent(*own, *other)) {
            return false;
        }
        let number = same_exponent(dim.mass, 0.0)
            && same_exponent(dim.length, 0.0)
            && same_exponent(dim.time, 0.0)
            && same_exponent(dim.current, 0.0)
            && !dim.any_length;
        if number {
            return same_exponent(self.m, 0.0);
        }
        if !rotational {
            return same_exponent(self.rad, 0.0) && (dim.any_length || same_exponent(self.m, dim.length));
        }
        // On a rotational axis kg stands for kg m². The radian of N m/rad may be omitted, that of an angle
        // may not. An electric unit may have radians or not: V s/rad is N m/A.
        let angle = same_exponent(self.rad, dim.length - dim.mass) || !same_exponent(dim.current, 0.0);
        let dropped = !same_exponent(dim.mass, 0.0) && same_exponent(self.rad, 0.0);
        same_exponent(self.m, 2.0 * dim.mass) && (dim.any_length || angle || dropped)
    }

    /// The dimension on the given axis, if there is one.
    pub(super) fn dim(self, rotational: bool) -> Option<Dimension> {
        let length = if rotational { self.rad + self.kg } else { self.m };
        let mechanical = Dimension::new(self.kg, length, self.s);
        let dim = Dimension { current: self.ampere, ..mechanical };
        let moment = Dimension { length: 0.0, ..dim };
        [dim, moment].into_iter().find(|dim| self.fit(*dim, rotational))
    }
}

/// Symbol, factor to SI, bases, whether it accepts a prefix.
pub(super) const SYMBOLS: &[(&str, f64, Bases, bool)] = &[
    ("1", 1.0, Bases::new(0.0, 0.0, 0.0, 0.0), false),
    ("%", 0.01, Bases::new(0.0, 0.0, 0.0, 0.0), false),
    ("g", 1e-3, Bases::new(1.0, 0.0, 0.0, 0.0), true),
    ("m", 1.0, Bases::new(0.0, 1.0, 0.0, 0.0), true),
    ("s", 1.0, Bases::new(0.0, 0.0, 1.0, 0.0), true),
    ("min", 60.0, Bases::new(0.0, 0.0, 1.0, 0.0), false),
    ("Hz", 1.0, Bases::new(0.0, 0.0, -1.0, 0.0), true),
    ("N", 1.0, Bases::new(1.0, 1.0, -2.0, 0.0), true),
    ("J", 1.0, Bases::new(1.0, 2.0, -2.0, 0.0), true),
    ("W", 1.0, Bases::new(1.0, 2.0, -3.0, 0.0), true),
    ("A", 1.0, Bases::electric(0.0, 0.0, 0.0, 1.0), true),
    ("V", 1.0, Bases::electric(1.0, 2.0, -3.0, -1.0), true),
    ("ohm", 1.0, Bases::electric(1.0, 2.0, -3.0, -2.0), true),
    ("Ω", 1.0, Bases::electric(1.0, 2.0, -3.0, -2.0), true),
    ("H", 1.0, Bases::electric(1.0, 2.0, -2.0, -2.0), true),
    ("rad", 1.0, Bases::new(0.0, 0.0, 0.0, 1.0), true),
    ("deg", PI / 180.0, Bases::new(0.0, 0.0, 0.0, 1.0), false),
    ("°", PI / 180.0, Bases::new(0.0, 0.0, 0.0, 1.0), false),
    ("rpm", PI / 30.0, Bases::new(0.0, 0.0, -1.0, 1.0), false),
];

const PREFIXES: &[(&str, f64)] = &[
    ("n", 1e-9),
    ("u", 1e-6),
    ("µ", 1e-6),
    ("μ", 1e-6),
    ("m", 1e-3),
    ("c", 1e-2),
    ("k", 1e3),
    ("M", 1e6),
    ("G", 1e9),
];

/// Factor to SI and bases of a symbol, which may have a prefix.
pub(super) fn symbol_bases(text: &str) -> Option<(f64, Bases)> {
    let exact =
        SYMBOLS.iter().find(|(symbol, ..)| *symbol == text).map(|(_, factor, bases, _)| (*factor, *bases));
    exact.or_else(|| {
        PREFIXES.iter().find_map(|(prefix, scale)| {
            let rest = text.strip_prefix(prefix)?;
            let (_, factor, bases, _) =
                SYMBOLS.iter().find(|(symbol, _, _, prefixed)| *prefixed && *symbol == rest)?;
            // For "kg" the product 1e3 * 1e-3 is exactly 1; products for all other units in files are exact
            // too.
            Some((scale * factor, *bases))
        })
    })
}

/// Units under other names.
pub(super) const ELSEWHERE: [(&str, &str); 28] = [
    ("sec", "s"),
    ("secs", "s"),
    ("seconds", "s"),
    ("msec", "ms"),
    ("usec", "us"),
    ("hertz", "Hz"),
    ("newton", "N"),
    ("newtons", "N"),
    ("meter", "m"),
    ("meters", "m"),
    ("metre", "m"),
    ("metres", "m"),
    ("micron", "um"),
    ("microns", "um"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("radian", "rad"),
    ("radians", "rad"),
    ("Nm", "N m"),
    ("N.m", "N m"),
    ("N-m", "N m"),
    ("mNm", "mN m"),
    ("kNm", "kN m"),
    ("mps", "m/s"),
    ("radps", "rad/s"),
    ("degps", "deg/s"),
    ("dps", "deg/s"),
    ("percent", "%"),
];

/// The unit most similar to a symbol.
pub(super) fn nearest(symbol: &str) -> Option<String> {
    if let Some((_, unit)) = ELSEWHERE.iter().find(|(name, _)| *name == symbol) {
        return Some((*unit).to_owned());
    }
    let common = ["kg", "g", "mm", "um", "ms", "us", "kHz", "kN", "mN", "MN", "mrad", "cm"];
    let known = SYMBOLS.iter().map(|(symbol, ..)| *symbol).chain(common);
    let distance =
        |candidate: &str| strsim::damerau_levenshtein(&symbol.to_lowercase(), &candidate.to_lowercase());
    let (edits, best) =
        known.map(|candidate| (distance(candidate), candidate)).min_by_key(|(edits, _)| *edits)?;
    // A single letter is one edit away from any other, so it suggests no unit.
    (edits <= 1 && edits < symbol.chars().count()).then(|| best.to_owned())
}

/// Bases in words, for units without a quantity on the axis.
pub(super) fn describe(bases: Bases) -> String {
    let mut text = String::from("in");
    let exponents =
        [("kg", bases.kg), ("m", bases.m), ("s", bases.s), ("A", bases.ampere), ("rad", bases.rad)];
    for (unit, exponent) in exponents {
        if same_exponent(exponent, 1.0) {
            let _ = write!(text, " {unit}");
        } else if !same_exponent(exponent, 0.0) {
            let _ = write!(text, " {unit}^{exponent}");
        }
    }
    text
}
