//! Knowledge of the diagnosis about each kind of effect, one file per kind. It includes the starting points
//! of fits, the values that are not a finding, the laws that the kind contains and the uncertainty of its
//! values. It also says how to separate the kind from look-alikes.
//!
//! A file without special needs uses the defaults of [`Known`].

mod balance;
mod element;
mod start;

use feeler_catalogue::Key;
use feeler_plant::effects::{Kind, Parameters, Trait};

pub(crate) use balance::{At, Balance, Extent, Force, Form, spread};
pub(crate) use element::{Element, Glance, LATE_ROWS, SURELY_LATE_ROWS, Seen, host_of};
pub(crate) use force_ripple::ripples;

/// Largest change of a quantisation step that was read from the values, as a logarithm.
const STEP_SPREAD: f64 = 5e-4;
/// Relative standard deviation of a dry friction level: on 17 blind cases of `docs/diagnosis.md` the root
/// mean square error was 4.7 %.
const LEVEL: f64 = 0.045;
/// Standard deviation of a delay, in rows. A command in one row may have arrived at any instant since the
/// previous row, and sampling instants jitter.
const DELAY_ROWS: f64 = 0.05;

/// Knowledge about a kind, given by the struct of its parameters.
pub(crate) trait Known: Parameters + 'static {
    /// Largest change of values that are read from the records, as a logarithm; `None` if residuals determine
    /// them.
    const READ_OFF: Option<f64> = None;
    /// Standard deviation of the values beyond that from residuals, in rows.
    const OFF_ROWS: f64 = 0.0;
    /// Laws that the kind contains.
    const CONTAINS: &'static [Inner<Self>] = &[];
    /// Kinds that it resembles over a short motion, with starting values for their fits.
    const RESEMBLES: &'static [Resembled<Self>] = &[];
    /// Whether the kind has no effect on a machine without contacts and weights.
    const NEEDS_LOAD: bool = false;
    /// Whether only a rotational axis can have the kind.
    const ONLY_TURNING: bool = false;
    /// Whether an answer may name the kind as a cause.
    const IS_CAUSE: bool = true;
    /// Two kinds on one element that together have the same effect.
    const SUM_OF: Option<SumOf<Self>> = None;
    /// The kind that replaces this one if bodies hit each other.
    const WHERE_IT_RATTLES: Option<Kind> = None;
    /// Believed value of the element to which the first parameter adds.
    const ADDS_TO: Option<Key> = None;
    /// Kinds that may look alike, each with a way to separate them that needs more than a command.
    const APART: &'static [(Kind, &'static str)] = &[];

    /// Coordinate of the force, if the kind is a table.
    const TABLE_OVER: Option<Over> = None;
    /// The kind of mass that may be meant by a value below one, if records determine only ratios of forces.
    const MASS_INSTEAD: Option<Kind> = None;

    /// Contribution to the balance of forces of a rigid axis; `None` if a balance does not involve the kind.
    const BALANCE: Option<Balance<Self>> = None;

    /// Starting points of the fit. The cost is often far from quadratic, so there are several, spread over
    /// the range that the records can show.
    fn starts(_: &Element<'_>, _: &Glance) -> Vec<Self> {
        start::about_typical()
    }

    /// Whether these values only move a believed value within its tolerance, or make the effect nearly zero.
    fn is_trivial(self, _: &Element<'_>, _: Seen) -> bool {
        false
    }

    /// The smallest effect of note whose place a believed value may take within its tolerance, and a record
    /// that tells the two apart. It follows from the largest command of its drive. `None` if calibration
    /// cannot hide the kind.
    fn behind_calibration(_largest_command: f64) -> Option<(Self, &'static str)> {
        None
    }

    /// Relative standard deviation of each value beyond that from residuals; `None` if the law is exact.
    ///
    /// No law of the library describes real presliding friction, or exactly how friction falls with speed.
    fn fractions_off() -> Option<Self> {
        let of_all = || Self::of(&vec![LEVEL; Self::PARAMETERS.len()]);
        Self::KIND.definition().has(Trait::DryFriction).then(of_all)
    }

    /// Magnitude of the position-dependent force that the values describe, even if the effect itself is
    /// nearly zero. `None` if there is no such force.
    fn force_over_position(self) -> Option<f64> {
        None
    }
}

/// Coordinate of the force of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Over {
    Position,
    Speed,
    /// A level of friction.
    PositionAndDirection,
}

impl Over {
    /// Its name in an answer.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Speed => "speed",
            Self::PositionAndDirection => "position and direction",
        }
    }
}

/// A kind that another one resembles, and its values from those of the other.
type Resembled<Other> = (Kind, fn(Other) -> Vec<Vec<f64>>);

/// A law that another one contains.
pub(crate) struct Inner<Outer> {
    kind: Kind,
    /// Parameters of the outer law from equivalent parameters of the inner law.
    embed: fn(&[f64]) -> Outer,
    /// Parameters of the inner law closest to the outer one; there may be several candidates.
    nearest: fn(Outer) -> Vec<Vec<f64>>,
}

/// Two laws on one element whose sum is another law.
pub(crate) struct SumOf<Sum> {
    parts: [Kind; 2],
    /// Parameters of the two laws from those of their sum.
    split: fn(Sum) -> [Vec<f64>; 2],
    /// Parameters of the sum from those of the two laws.
    merge: fn([&[f64]; 2]) -> Sum,
}

/// The smallest effect of note whose place a believed value may take, and a record that tells the two apart.
pub(crate) struct Behind {
    pub(crate) values: Vec<f64>,
    pub(crate) record: &'static str,
}

/// Knowledge about a kind, with values in the order of its definition; see [`Known`].
pub(crate) struct Dossier {
    pub(crate) read_off: Option<f64>,
    pub(crate) off_rows: f64,
    pub(crate) needs_load: bool,
    pub(crate) only_turning: bool,
    pub(crate) is_cause: bool,
    /// The two kinds whose sum the kind is.
    pub(crate) parts: Option<[Kind; 2]>,
    /// Parameters of these two from those of the sum, and the reverse.
    pub(crate) split: fn(&[f64]) -> Option<[Vec<f64>; 2]>,
    pub(crate) merge: fn([&[f64]; 2]) -> Option<Vec<f64>>,
    pub(crate) where_it_rattles: Option<Kind>,
    pub(crate) adds_to: Option<Key>,
    pub(crate) starts: fn(&Element<'_>, &Glance) -> Vec<Vec<f64>>,
    pub(crate) is_trivial: fn(&[f64], &Element<'_>, Seen) -> bool,
    pub(crate) behind_calibration: fn(f64) -> Option<Behind>,
    pub(crate) fractions_off: fn() -> Option<Vec<f64>>,
    pub(crate) force_over_position: fn(&[f64]) -> Option<f64>,
    pub(crate) table_over: Option<Over>,
    pub(crate) mass_instead: Option<Kind>,
    pub(crate) balance: Option<Shown>,
    embed: fn(Kind, &[f64]) -> Option<Vec<f64>>,
    nearest: fn(Kind, &[f64]) -> Vec<Vec<f64>>,
    contains: fn(Kind) -> bool,
    apart: &'static [(Kind, &'static str)],
}

impl Dossier {
    /// Whether the kind delays commands.
    pub(crate) fn is_late(&self) -> bool {
        matches!(self.balance, Some(Shown { form: Form::Lag | Form::Delay, .. }))
    }
}

/// [`Balance`] for values in the order of the definition.
#[derive(Clone, Copy)]
pub(crate) struct Shown {
    pub(crate) form: Form,
    pub(crate) shapes: fn(&Extent) -> Vec<f64>,
    pub(crate) values: fn(&[f64], f64) -> Vec<f64>,
    pub(crate) coefficients: fn(&[f64]) -> (Vec<f64>, f64),
}

fn shown<K: Known>() -> Option<Shown> {
    let of = |balance: &Balance<K>| (balance.form, balance.shapes);
    let (form, shapes) = K::BALANCE.as_ref().map(of)?;
    Some(Shown {
        form,
        shapes,
        values: |coefficients, shape| {
            K::BALANCE.map_or_else(Vec::new, |balance| (balance.values)(coefficients, shape).values())
        },
        coefficients: |values| {
            K::BALANCE.map_or_else(|| (Vec::new(), 0.0), |balance| (balance.coefficients)(K::of(values)))
        },
    })
}

impl Dossier {
    fn of<K: Known>() -> Self {
        Self {
            read_off: K::READ_OFF,
            off_rows: K::OFF_ROWS,
            needs_load: K::NEEDS_LOAD,
            only_turning: K::ONLY_TURNING,
            is_cause: K::IS_CAUSE,
            parts: K::SUM_OF.map(|sum| sum.parts),
            split: |values| K::SUM_OF.map(|sum| (sum.split)(K::of(values))),
            merge: |parts| K::SUM_OF.map(|sum| (sum.merge)(parts).values()),
            where_it_rattles: K::WHERE_IT_RATTLES,
            adds_to: K::ADDS_TO,
            starts: |element, glance| K::starts(element, glance).into_iter().map(K::values).collect(),
            is_trivial: |values, element, seen| K::of(values).is_trivial(element, seen),
            behind_calibration: |command| {
                K::behind_calibration(command)
                    .map(|(least, record)| Behind { values: least.values(), record })
            },
            fractions_off: || K::fractions_off().map(K::values),
            force_over_position: |values| K::of(values).force_over_position(),
            table_over: K::TABLE_OVER,
            mass_instead: K::MASS_INSTEAD,
            balance: shown::<K>(),
            embed: |inner, values| Some((contained::<K>(inner)?.embed)(values).values()),
            nearest: |inner, values| {
                let resembled = K::RESEMBLES.iter().find(|(kind, _)| *kind == inner).map(|(_, of)| *of);
                let nearest = contained::<K>(inner).map(|inner| inner.nearest).or(resembled);
                nearest.map_or_else(Vec::new, |nearest| nearest(K::of(values)))
            },
            contains: |inner| contained::<K>(inner).is_some(),
            apart: K::APART,
        }
    }
}

fn contained<K: Known>(inner: Kind) -> Option<&'static Inner<K>> {
    K::CONTAINS.iter().find(|contained| contained.kind == inner)
}

macro_rules! dossiers {
    ($($file:ident $kind:ident,)*) => {
        $(mod $file;)*

        pub(crate) fn dossier(kind: Kind) -> Dossier {
            match kind {
                $(Kind::$kind => Dossier::of::<feeler_plant::effects::$kind>(),)*
            }
        }
    };
}

feeler_plant::effects!(dossiers);

/// Parameters with which the law `outer` equals the law `inner` with parameters `values`; `None` if `outer`
/// does not contain `inner`.
pub(crate) fn embed(outer: Kind, inner: Kind, values: &[f64]) -> Option<Vec<f64>> {
    (dossier(outer).embed)(inner, values)
}

/// Parameters of the law `inner` closest to the law `outer` with parameters `values`. There may be several
/// candidates; empty if `outer` neither contains nor resembles `inner`.
pub(crate) fn nearest(outer: Kind, inner: Kind, values: &[f64]) -> Vec<Vec<f64>> {
    (dossier(outer).nearest)(inner, values)
}

/// Whether the law `outer` contains the law `inner`.
pub(crate) fn contains(outer: Kind, inner: Kind) -> bool {
    (dossier(outer).contains)(inner)
}

/// Whether two laws on one element are equivalent, or one contains the other, or both are laws of dry
/// friction, whose levels only their sum shows. A load beside one of these acts like a second level.
pub(crate) fn overlaps(a: Kind, b: Kind) -> bool {
    a == b || contains(a, b) || contains(b, a) || [a, b].into_iter().all(is_dry_friction)
}

/// Whether a kind is a law of dry friction whose level does not follow a load.
fn is_dry_friction(kind: Kind) -> bool {
    let known = dossier(kind);
    kind.definition().has(Trait::DryFriction) && known.is_cause && !known.needs_load
}

/// How to separate two look-alike kinds, in words, if no command does; `None` if nothing is known.
pub fn apart(a: Kind, b: Kind) -> Option<&'static str> {
    let of = |one: Kind, other: Kind| dossier(one).apart.iter().find(|(kind, _)| *kind == other);
    of(a, b).or_else(|| of(b, a)).map(|(_, what)| *what)
}

#[cfg(test)]
mod tests {
    use feeler_plant::description::{Contact, ElementKind, GROUND, Machine, Site};
    use feeler_plant::effects::{ContactStiffness, CoulombFriction, LIBRARY, LoadFriction};
    use indexmap::IndexMap;

    use super::*;

    #[test]
    fn truth_what_tells_a_pair_apart_is_found_either_way_round_and_said_once() {
        let pairs =
            || LIBRARY.iter().flat_map(|one| dossier(one.kind).apart.iter().map(|two| (one.kind, two)));
        assert!(pairs().count() > 0);
        for (a, (b, what)) in pairs() {
            assert_eq!([apart(a, *b), apart(*b, a)], [Some(*what); 2]);
            assert!(a != *b && dossier(*b).apart.iter().all(|(kind, _)| *kind != a), "{a} {b}");
        }
        assert_eq!(apart(Kind::Backlash, Kind::AddedMass), None);
    }

    /// A shape is refined between its neighbours in the grid.
    #[test]
    fn truth_trial_shapes_ascend() {
        let extent = balance::Extent {
            speed: 0.3,
            ends: [-0.2, 0.5],
            command: 20.0,
            usual_command: 8.0,
            resolved_s: 0.05,
        };
        let shown = LIBRARY.iter().filter_map(|one| dossier(one.kind).balance);
        let grids: Vec<Vec<f64>> = shown.map(|shown| (shown.shapes)(&extent)).collect();
        assert!(grids.iter().any(|grid| grid.len() > 1));
        assert!(grids.iter().all(|grid| grid.is_sorted()), "{grids:?}");
    }

    #[test]
    fn truth_a_sum_of_two_laws_is_split_and_merged_without_loss() {
        let sums: Vec<_> =
            LIBRARY.iter().map(|one| dossier(one.kind)).filter(|one| one.parts.is_some()).collect();
        assert!(!sums.is_empty());
        for sum in sums {
            for values in [[3.0, 0.4], [0.5, -0.9]] {
                let [first, second] = (sum.split)(&values).unwrap();
                let merged = (sum.merge)([&first, &second]).unwrap();
                assert!(
                    merged.iter().zip(&values).all(|(a, b)| (a - b).abs() < 4.0 * f64::EPSILON),
                    "{merged:?}"
                );
            }
        }
    }

    #[test]
    fn truth_what_is_later_than_a_held_command_departs_however_it_is_split() {
        let seen = Seen { ends_m: [0.0, 1.0], command_n: 1.0, instant_s: 0.01, ..Seen::default() };
        for late_rows in [-0.5, -0.1, 0.0, 0.3, 0.5] {
            let is_held = |rows: f64| seen.beside(Some(late_rows)).is_in_time(0.01 * (rows - late_rows));
            assert!(is_held(0.99 * LATE_ROWS) && !is_held(1.01 * LATE_ROWS), "{late_rows}");
        }
        assert!(!seen.beside(None).is_in_time(1e-5));
    }

    #[test]
    fn truth_a_value_within_tolerance_departs_from_one_that_is_known_exactly() {
        let mut machine = Machine::default();
        machine.contacts.insert("tool".into(), Contact::kelvin_voigt("tip", GROUND, 1e5, 0.0));
        let tolerance = IndexMap::from([("contacts.tool.stiffness".to_owned(), 0.1)]);
        let contact = Element::at(Site { table: ElementKind::Contacts, index: 0 }, &machine, &tolerance);
        let seen = Seen { ends_m: [0.0, 1.0], command_n: 1.0, instant_s: 0.0, ..Seen::default() };
        let trivial =
            |element: &Element<'_>, stiffness| ContactStiffness { stiffness }.is_trivial(element, seen);
        assert!(trivial(&contact, 1.05e5) && !trivial(&contact, 1.2e5));
        assert!(!trivial(&contact.known_exactly(), 1.05e5));
        assert!(LoadFriction { ratio: 100.0 }.is_trivial(&contact.known_exactly(), seen));
    }

    #[test]
    fn prop_a_law_that_contains_another_takes_values_within_its_bounds() {
        let inner = CoulombFriction { level: 7.0 }.values();
        let outer: Vec<_> = LIBRARY
            .iter()
            .filter_map(|outer| Some((outer, embed(outer.kind, Kind::CoulombFriction, &inner)?)))
            .collect();
        assert!(!outer.is_empty());
        for (definition, values) in outer {
            for (parameter, value) in definition.parameters.iter().zip(values) {
                let (low, high) = parameter.bounds;
                assert!((low..=high).contains(&value), "{}.{}", definition.kind, parameter.name);
            }
        }
    }
}
