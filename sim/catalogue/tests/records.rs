//! Contents of a table in the struct that it fills.

use feeler_catalogue::{
    Bound, Content, Contents, Dimension, Field, Form, Key, KeyKind, Keyed, Unit, field, form, number,
    required, words,
};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Pace {
    Slow,
    Fast,
}

words!(Pace {
    Slow = "slow", "at a walk";
    Fast = "fast", "at a run";
});

#[derive(Clone, Debug, PartialEq)]
enum Course {
    Straight { length_m: f64, pace: Option<Pace> },
    Round { centre_m: [f64; 2] },
}

const LENGTH: Unit = Unit::Of(Dimension::LENGTH);
const PACE: Key = feeler_catalogue::optional("pace", KeyKind::Word(Pace::WORDS), "how fast");
const STRAIGHT: &[Field<Course>] = &[
    field!(
        Course: Course::Straight { length_m, .. } => *length_m,
        required("length", KeyKind::Quantity(LENGTH, Bound::Positive), "its length")
    ),
    field!(Course: Course::Straight { pace, .. } => *pace, PACE),
];
const ROUND: &[Field<Course>] = &[
    field!(Course: Course::Round { centre_m } => centre_m[0], number("x", LENGTH, Bound::Any, 0.0, "centre")),
    field!(Course: Course::Round { centre_m } => centre_m[1], number("y", LENGTH, Bound::Any, 0.0, "centre")),
];

impl Keyed for Course {
    const FIELDS: &'static [Field<Self>] = &[];
    const FORMS: &'static [Form<Self>] = &[
        form!(
            "straight",
            "along a line",
            Course: Course::Straight { .. },
            Course::Straight { length_m: 1.0, pace: None },
            STRAIGHT
        ),
        form!(
            "round",
            "about a centre",
            Course: Course::Round { .. },
            Course::Round { centre_m: [0.0; 2] },
            ROUND
        ),
    ];
}

fn table(form: &'static str, entries: &[(&'static str, Content)]) -> Contents {
    let mut contents = Contents::new(Some(form));
    for (key, content) in entries {
        contents.insert(key, content.clone());
    }
    contents
}

#[test]
fn truth_a_record_is_read_as_its_contents_say() {
    let straight = Course::Straight { length_m: 3.0, pace: Some(Pace::Fast) };
    let contents =
        table("straight", &[("length", Content::Number(3.0)), ("pace", Content::Word(Pace::Fast.name()))]);
    assert_eq!(straight.contents(), contents);
    assert_eq!(Course::read(&contents), Some(straight));
    // Values equal to their default are omitted, and an element of an array is set separately.
    let round = Course::Round { centre_m: [0.0, 2.0] };
    assert_eq!(round.contents(), table("round", &[("y", Content::Number(2.0))]));
    assert_eq!(Course::read(&round.contents()), Some(round));
}

#[test]
fn truth_nothing_stands_in_for_a_form_that_is_not_known() {
    assert_eq!(Course::read(&table("zigzag", &[("length", Content::Number(3.0))])), None);
    assert_eq!(Course::read(&Contents::new(None)), None);
}

#[test]
fn truth_content_of_another_kind_is_no_value() {
    let contents = table("straight", &[("pace", Content::Number(3.0)), ("length", Content::Word("slow"))]);
    assert_eq!(contents.value::<Pace>(&PACE), None);
    assert_eq!(Course::read(&contents), Some(Course::Straight { length_m: 1.0, pace: None }));
    assert_eq!(Pace::named("slow"), Some(Pace::Slow));
    assert_eq!(Pace::named("Slow"), None);
}
