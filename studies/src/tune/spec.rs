//! The specification of a tuned controller, as a user writes it: clauses with commas between them.

use feeler_plant::description::Axis;
use serde::{Serialize, Serializer};

use crate::numbers::{percent, plain, with_unit};
use crate::refusal::Refusal;

/// Quantities that may be limited, beside gains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TuneMeasure {
    /// Smallest phase margin of the sampled loop, degrees.
    PhaseMargin,
    /// Factor by which the gain may rise or fall.
    GainMargin,
    /// Balanced disk margin: how far gain and phase may vary together.
    DiskMargin,
    /// Largest modulus of the sensitivity.
    Sensitivity,
    /// How far the linear step response passes its final value, as a share of it.
    StepOvershoot,
    /// How far the simulated force passes its reference, impact included, as a share of it.
    Overshoot,
    /// Largest simulated force of any contact, N; a moment of a rotational axis, N m.
    PeakForce,
    /// Simulated settling time, s.
    SettlingTime,
}

/// A unit, and its conversion to SI.
type Unit = (&'static str, fn(f64) -> f64);

const PERCENT: &[Unit] = &[("%", |x| x / 100.0), ("", |x| x)];
const FORCE: &[Unit] = &[("N", |x| x), ("kN", |x| 1e3 * x), ("N m", |x| x), ("", |x| x)];
const TIME: &[Unit] = &[("s", |x| x), ("ms", |x| 1e-3 * x), ("us", |x| 1e-6 * x), ("", |x| x)];
const ANGLE: &[Unit] = &[("deg", |x| x), ("rad", f64::to_degrees), ("", |x| x)];
const NUMBER: &[Unit] = &[("", |x| x)];
const RATIO: &[Unit] = &[("dB", |x| 10.0_f64.powf(x / 20.0)), ("", |x| x)];

impl TuneMeasure {
    /// Every measure: its name, its units, and whether it is to be at least the limit.
    const ALL: [(Self, &'static str, &'static [Unit], bool); 8] = [
        (Self::PhaseMargin, "phase margin", ANGLE, true),
        (Self::GainMargin, "gain margin", RATIO, true),
        (Self::DiskMargin, "disk margin", NUMBER, true),
        (Self::Sensitivity, "sensitivity", RATIO, false),
        (Self::StepOvershoot, "step overshoot", PERCENT, false),
        (Self::Overshoot, "overshoot", PERCENT, false),
        (Self::PeakForce, "peak force", FORCE, false),
        (Self::SettlingTime, "settling time", TIME, false),
    ];

    /// Its name in a specification.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(measure, ..)| *measure == self).map_or("", |(_, name, ..)| name)
    }

    /// Why no controlled loop has this value or a better one; `None` if one may.
    fn never_is(self, bound: f64) -> Option<&'static str> {
        let (never, why) = match self {
            Self::PhaseMargin => (bound >= 180.0, "a phase margin is below 180 deg"),
            Self::DiskMargin => (bound <= 0.0 || bound > 2.0, "a disk margin is above 0 and at most 2"),
            Self::Sensitivity => (bound <= 1.0, "a sensitivity peaks above 1, which is 0 dB"),
            Self::GainMargin | Self::PeakForce | Self::SettlingTime => (bound <= 0.0, "this is above zero"),
            Self::StepOvershoot | Self::Overshoot => (bound < 0.0, "an overshoot is never negative"),
        };
        never.then_some(why)
    }

    /// A value with its unit.
    pub(super) fn with_unit(self, value: f64, axis: Axis) -> String {
        match self {
            Self::PhaseMargin => format!("{} deg", plain(value)),
            Self::DiskMargin => plain(value),
            Self::GainMargin | Self::Sensitivity => format!("{:.1} dB", 20.0 * value.log10()),
            Self::StepOvershoot | Self::Overshoot => format!("{} %", percent(value)),
            Self::PeakForce if axis == Axis::Rotational => with_unit(value, "N m"),
            Self::PeakForce => with_unit(value, "N"),
            Self::SettlingTime => with_unit(value, "s"),
        }
    }

    /// Whether it follows from linear theory; the others follow from a run.
    pub(crate) fn is_of_theory(self) -> bool {
        !matches!(self, Self::Overshoot | Self::PeakForce | Self::SettlingTime)
    }
}

impl Serialize for TuneMeasure {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// A bound on a measure or a gain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TuneLimit<T> {
    /// Name of the bounded measure or gain.
    pub of: T,
    /// Whether the bound is the smallest value allowed; otherwise it is the largest.
    pub at_least: bool,
    /// The bound, SI; a gain margin as a factor.
    pub bound: f64,
}

impl<T> TuneLimit<T> {
    /// Share of the bound by which a value misses it; zero if the value meets it.
    pub(super) fn missed_by(&self, value: f64) -> f64 {
        let missed = if self.at_least { self.bound - value } else { value - self.bound };
        let share = if missed <= 0.0 { 0.0 } else { missed / self.bound.abs().max(f64::MIN_POSITIVE) };
        if share.is_nan() { f64::INFINITY } else { share }
    }
}

/// Parts that are tuned beside the gains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TunedPart {
    /// A low-pass on the reading.
    Filter,
    /// A lead in series with the law.
    Lead,
    /// A notch on the reading.
    Notch,
}

impl TunedPart {
    const ALL: [Self; 3] = [Self::Filter, Self::Lead, Self::Notch];

    /// Its name in a specification.
    pub fn name(self) -> &'static str {
        match self {
            Self::Filter => "filter",
            Self::Lead => "lead",
            Self::Notch => "notch",
        }
    }
}

/// Requirements on a tuned controller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spec {
    /// Limits on margins, overshoot and the like.
    pub limits: Vec<TuneLimit<TuneMeasure>>,
    /// Limits on gains, by their names.
    pub gain_limits: Vec<TuneLimit<String>>,
    /// Limits on gains that have a unit, as `(index in gain_limits, text)`. Only the file knows their units.
    #[serde(skip)]
    pub(super) with_units: Vec<(usize, String)>,
    /// The filters that are tuned beside the gains.
    pub parts: Vec<TunedPart>,
    /// The gains that are tuned individually. `None` scales those on errors together, and damping if there is
    /// any.
    pub gains: Option<Vec<String>>,
    /// The controller; `None` for that of the force.
    pub controller: Option<String>,
}

/// Margins that hold unless a specification states others. They are those that textbooks ask for (Astrom and
/// Murray, Feedback Systems, section 10.3: 6 dB, 30 to 60 degrees).
const DEFAULT_LIMITS: [TuneLimit<TuneMeasure>; 2] = [
    TuneLimit { of: TuneMeasure::PhaseMargin, at_least: true, bound: 45.0 },
    TuneLimit { of: TuneMeasure::GainMargin, at_least: true, bound: 2.0 },
];

impl Default for Spec {
    fn default() -> Self {
        Self {
            limits: DEFAULT_LIMITS.to_vec(),
            gain_limits: Vec::new(),
            with_units: Vec::new(),
            parts: Vec::new(),
            gains: None,
            controller: None,
        }
    }
}

impl Spec {
    /// Reads a specification, as in `phase margin >= 50 deg, structure = gains+notch`.
    ///
    /// # Errors
    /// The first clause that cannot be read, with the remedy.
    pub fn parse(text: &str) -> Result<Self, Refusal> {
        let mut spec = Self::default();
        let mut stated = Vec::new();
        for clause in text.split([',', ';', '\n']).map(str::trim).filter(|clause| !clause.is_empty()) {
            spec.take(clause, &mut stated)?;
        }
        Ok(spec)
    }

    /// `stated` holds the measures of the clauses so far: a clause replaces a default, but no other clause.
    fn take(&mut self, clause: &str, stated: &mut Vec<TuneMeasure>) -> Result<(), Refusal> {
        for (sign, at_least) in [(">=", true), ("<=", false)] {
            if let Some((name, value)) = clause.split_once(sign) {
                let of = self.limit(clause, &squeezed(name), value.trim(), at_least)?;
                if let Some(of) = of.filter(|of| stated.contains(of)) {
                    let message = format!("the {} is limited twice", of.name());
                    return Err(refused(clause, &message, "keep one of the two clauses"));
                }
                stated.extend(of);
                return Ok(());
            }
        }
        let Some((name, value)) = clause.split_once('=') else {
            return Err(refused(
                clause,
                "this is not a clause",
                "write `NAME >= VALUE`, `NAME <= VALUE` or `NAME = WORDS`",
            ));
        };
        let words = || value.split('+').map(str::trim).filter(|word| !word.is_empty());
        match squeezed(name).as_str() {
            "structure" => {
                self.parts.clear();
                for word in words().filter(|word| *word != "gains") {
                    let known = TunedPart::ALL.into_iter().find(|part| part.name() == word);
                    let Some(part) = known.filter(|part| !self.parts.contains(part)) else {
                        let remedy =
                            "write gains, gains+filter, gains+lead or gains+notch, or several with +";
                        return Err(refused(clause, &format!("`{word}` is not a further part"), remedy));
                    };
                    self.parts.push(part);
                }
            }
            "gains" => self.gains = Some(words().map(str::to_owned).collect()),
            "controller" => self.controller = Some(value.trim().to_owned()),
            other => {
                let message = format!("`{other}` cannot be set");
                return Err(refused(clause, &message, "write structure, gains or controller before the ="));
            }
        }
        Ok(())
    }

    /// The measure that the clause limits; `None` for a gain.
    fn limit(
        &mut self,
        clause: &str,
        name: &str,
        value: &str,
        at_least: bool,
    ) -> Result<Option<TuneMeasure>, Refusal> {
        let is_of_unit =
            |c: char| c.is_whitespace() || c.is_alphabetic() && !matches!(c, 'e' | 'E') || c == '%';
        let (number, unit) = value.split_at(value.find(is_of_unit).unwrap_or(value.len()));
        let unit = unit.trim();
        let Some(number) = number.parse().ok().filter(|number: &f64| number.is_finite()) else {
            return Err(refused(
                clause,
                &format!("`{value}` is not a number"),
                "write a number, then its unit",
            ));
        };
        let Some((of, _, units, rises)) = TuneMeasure::ALL.iter().find(|(_, known, ..)| *known == name)
        else {
            if name.is_empty() || name.contains(' ') || unit.contains('%') {
                let known: Vec<&str> = TuneMeasure::ALL.iter().map(|(_, name, ..)| *name).collect();
                let remedy = format!("limit {}, or a gain by its name", known.join(", "));
                return Err(refused(clause, &format!("`{name}` cannot be limited to `{value}`"), &remedy));
            }
            if !unit.is_empty() {
                self.with_units.push((self.gain_limits.len(), value.to_owned()));
            }
            self.gain_limits.push(TuneLimit { of: name.into(), at_least, bound: number });
            return Ok(None);
        };
        if at_least != *rises {
            let sign = if *rises { ">=" } else { "<=" };
            return Err(refused(
                clause,
                "this bounds the wrong side",
                &format!("write {name} {sign} {value}"),
            ));
        }
        let Some((_, si)) = units.iter().find(|(known, _)| *known == unit) else {
            let known: Vec<&str> = units.iter().map(|(unit, _)| *unit).filter(|u| !u.is_empty()).collect();
            let units =
                if known.is_empty() { String::new() } else { format!("in {}, or ", known.join(" or ")) };
            let remedy = format!("write the value {units}as a plain number");
            return Err(refused(clause, &format!("`{unit}` is not a unit of the {name}"), &remedy));
        };
        let bound = si(number);
        if !bound.is_finite() {
            return Err(refused(clause, &format!("`{value}` is beyond all numbers"), "write a smaller one"));
        }
        if let Some(why) = of.never_is(bound) {
            return Err(refused(clause, why, &format!("write a value of the {name} that a loop can have")));
        }
        self.limits.retain(|limit| limit.of != *of);
        self.limits.push(TuneLimit { of: *of, at_least, bound });
        Ok(Some(*of))
    }

    /// The specification with every limit of a gain in SI. `read` converts a text to the value of a gain.
    ///
    /// # Errors
    /// A unit that the gain cannot have.
    pub(super) fn in_si<E>(mut self, read: impl Fn(&str, &str) -> Result<f64, E>) -> Result<Self, E> {
        for (index, text) in std::mem::take(&mut self.with_units) {
            let limit = &mut self.gain_limits[index];
            limit.bound = read(&limit.of, &text)?;
        }
        Ok(self)
    }

    /// The limits that linear theory decides, or those that a run does.
    pub(super) fn limits_of(&self, theory: bool) -> impl Iterator<Item = &TuneLimit<TuneMeasure>> {
        self.limits.iter().filter(move |limit| limit.of.is_of_theory() == theory)
    }
}

fn refused(clause: &str, message: &str, remedy: &str) -> Refusal {
    Refusal::new(format!("--spec: `{clause}`: {message}"), remedy)
}

/// A name with single spaces.
fn squeezed(name: &str) -> String {
    name.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_specification_is_read() {
        use TuneMeasure::{DiskMargin, Overshoot, PhaseMargin, SettlingTime};

        let text = "phase margin >= 50 deg, gain  margin>=6.0206 dB, overshoot <= 10 %, ki >= 5, \
                    disk margin >= 0.7, \
                    structure = gains + notch, gains = kp+ki, settling time <= 80 ms";
        let spec = Spec::parse(text).unwrap();
        let bound = |of| spec.limits.iter().find(|limit| limit.of == of).unwrap().bound;
        let found = [PhaseMargin, DiskMargin, Overshoot, SettlingTime].map(bound);
        assert_eq!(found.map(f64::to_bits), [50.0, 0.7, 0.1, 0.08].map(f64::to_bits));
        // 6.0206 dB are a factor of two within its last digit.
        assert!((bound(TuneMeasure::GainMargin) - 2.0).abs() < 1e-5);
        assert_eq!(spec.gain_limits, [TuneLimit { of: "ki".to_owned(), at_least: true, bound: 5.0 }]);
        assert_eq!(
            (spec.parts, spec.gains.unwrap()),
            (vec![TunedPart::Notch], vec!["kp".into(), "ki".into()])
        );
        assert_eq!(Spec::parse("").unwrap(), Spec::default());

        let read = Spec::parse("kp <= 2, ki <= 5 1/s").unwrap().in_si(|name, text| {
            assert_eq!((name, text), ("ki", "5 1/s"));
            Ok::<f64, ()>(7.0)
        });
        let bounds: Vec<u64> = read.unwrap().gain_limits.iter().map(|limit| limit.bound.to_bits()).collect();
        assert_eq!(bounds, [2.0, 7.0].map(f64::to_bits));
    }

    #[test]
    fn truth_each_mistake_names_its_clause_and_a_way_out() {
        for (text, remedy) in [
            ("phase margin", "write `NAME >= VALUE`"),
            ("phase margin <= 45 deg", "write phase margin >= 45 deg"),
            ("phase margin >= 45 dB", "deg or rad"),
            ("phase margin >= 450 deg", "that a loop can have"),
            ("overshoot <= -3 %", "a value of the overshoot"),
            ("sensitivity <= 0 dB", "that a loop can have"),
            ("peak force <= 0 N", "that a loop can have"),
            ("disk margin >= 3", "that a loop can have"),
            ("disk margin >= 0.7 dB", "write the value as a plain number"),
            ("phase margin >= much", "a number"),
            ("colour <= 3 %", "limit phase margin"),
            ("structure = gains+magic", "gains+filter"),
            ("tune = all", "structure, gains or controller"),
        ] {
            let refusal = Spec::parse(text).unwrap_err();
            assert!(refusal.message.contains(text), "{}", refusal.message);
            assert!(refusal.remedy.contains(remedy), "{text}: {}", refusal.remedy);
        }
        for second in [40, 45, 50] {
            let twice =
                Spec::parse(&format!("phase margin >= 45 deg, phase margin >= {second} deg")).unwrap_err();
            assert!(twice.message.contains("limited twice"), "{}", twice.message);
        }
        assert!(Spec::parse("settling time <= 900 us").is_ok());
    }
}
