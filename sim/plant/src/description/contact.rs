//! Contacts between tool and workpiece.

use feeler_catalogue::{
    Absent, Bound, Dimension, Field, Form, Key, KeyKind, KeyRole, Keyed, Unit, field, form, number, optional,
    required, words,
};

use crate::effects::EffectUse;

/// The force sensor as in the paper (Fig. 1): a spring `k_s`, `b_s` between tip and workpiece, compressed by
/// `d = x_tip - x_work - gap`.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Tip and workpiece (or ground).
    pub between: [String; 2],
    /// Whether the two are attached, only push, or never touch.
    pub engagement: Engagement,
    /// Force against compression and its rate.
    pub law: ContactLaw,
    /// `k`: N/m, or N/m^exponent for a power law.
    pub stiffness: f64,
    /// Linear damping `c`, N s/m.
    pub damping_n_s_per_m: f64,
    /// Gap between tip and workpiece at zero positions.
    pub gap_m: f64,
    /// Departures from the ideal contact.
    pub effects: Vec<EffectUse>,
}

impl Contact {
    /// A linear contact that only pushes; tip and workpiece touch at zero positions.
    pub fn kelvin_voigt(
        tip: impl Into<String>,
        workpiece: impl Into<String>,
        stiffness_n_per_m: f64,
        damping_n_s_per_m: f64,
    ) -> Self {
        Self {
            between: [tip.into(), workpiece.into()],
            engagement: Engagement::Unilateral,
            law: ContactLaw::KelvinVoigt,
            stiffness: stiffness_n_per_m,
            damping_n_s_per_m,
            gap_m: 0.0,
            effects: Vec::new(),
        }
    }
}

/// How tip and workpiece are engaged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Engagement {
    /// Bilateral: attached at the initial positions; the gap counts as zero.
    Clamped,
    /// Pushes only.
    #[default]
    Unilateral,
    Free,
}

/// Contact force against compression `d` and its rate, for `d > 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactLaw {
    /// `k d + c d'`.
    KelvinVoigt,
    /// `k d^n (1 + alpha d')`.
    HuntCrossley {
        /// `alpha`, s/m, >= 0.
        alpha_s_per_m: f64,
        /// `n`, >= 1.
        exponent: f64,
    },
    /// `k d^1.5 + c d'` (c usually zero).
    Hertz,
}

impl ContactLaw {
    /// `n` in `k d^n`.
    pub fn exponent(self) -> f64 {
        match self {
            Self::KelvinVoigt => 1.0,
            Self::HuntCrossley { exponent, .. } => exponent,
            Self::Hertz => 1.5,
        }
    }
}

words!(Engagement {
    Clamped = "clamped", "attached where the bodies are at the start; the gap counts as zero";
    Unilateral = "unilateral", "pushes only";
    Free = "free", "absent";
});

const HUNT_CROSSLEY: &[Field<Contact>] = &[
    field!(Contact: Contact { law: ContactLaw::HuntCrossley { alpha_s_per_m, .. }, .. } => *alpha_s_per_m,
        required("alpha", KeyKind::Quantity(Unit::Of(Dimension::INVERSE_VELOCITY), Bound::NotNegative),
            "alpha")),
    Contact::EXPONENT,
];

/// A contact before its keys are read.
fn unread(law: ContactLaw) -> Contact {
    Contact { law, gap_m: 1.0, ..Contact::kelvin_voigt("", "", 1.0, 1.0) }
}

impl Contact {
    /// Tip and workpiece.
    pub const BETWEEN: Field<Self> = field!(Contact: between,
        required("between", KeyKind::Pair,
            "tip and workpiece, in this order; the workpiece may be `ground`"));
    /// The engagement of tip and workpiece.
    pub const ENGAGEMENT: Field<Self> = field!(Contact: engagement,
        Key { name: "engagement", kind: KeyKind::Word(Engagement::WORDS),
            absent: Absent::Word(Engagement::Unilateral.name()),
            text: "how tip and workpiece hold on to each other" });
    /// Its stiffness.
    pub const STIFFNESS: Field<Self> = field!(Contact: stiffness,
        optional("stiffness", KeyKind::Quantity(Unit::PowerStiffness, Bound::Positive),
            "k; may be left out of a `hertz` law between materials"), KeyRole::Believed);
    /// Its linear damping.
    pub const DAMPING: Field<Self> = field!(Contact: damping_n_s_per_m,
        number("damping", Unit::Of(Dimension::DAMPING), Bound::NotNegative, 0.0, "linear damping c"),
        KeyRole::Believed);
    /// The exponent of its law, if a file states one.
    pub const EXPONENT: Field<Self> = field!(
        Contact: Contact { law: ContactLaw::HuntCrossley { exponent, .. }, .. } => *exponent,
        number("exponent", Unit::Of(Dimension::NONE), Bound::Within(1.0, 5.0), 1.0, "n"));
    /// Its gap at zero positions.
    pub const GAP: Field<Self> = field!(Contact: gap_m,
        number("gap", Unit::Of(Dimension::LENGTH), Bound::Any, 0.0,
            "distance to close before they touch, where all positions are zero"), KeyRole::Believed);
}

impl Keyed for Contact {
    const FIELDS: &'static [Field<Self>] =
        &[Contact::BETWEEN, Contact::ENGAGEMENT, Contact::STIFFNESS, Contact::DAMPING, Contact::GAP];
    const FORMS: &'static [Form<Self>] = &[
        form!("kelvin-voigt", "k d + c d'", Contact: Contact { law: ContactLaw::KelvinVoigt, .. },
            unread(ContactLaw::KelvinVoigt), &[] as &[Field<Contact>]),
        form!("hunt-crossley", "k d^n (1 + alpha d')",
            Contact: Contact { law: ContactLaw::HuntCrossley { .. }, .. },
            unread(ContactLaw::HuntCrossley { alpha_s_per_m: 1.0, exponent: 1.0 }), HUNT_CROSSLEY),
        form!("hertz", "k d^1.5 + c d'", Contact: Contact { law: ContactLaw::Hertz, .. },
            unread(ContactLaw::Hertz), &[] as &[Field<Contact>]),
    ];

    fn blank() -> Option<Self> {
        Some(unread(ContactLaw::KelvinVoigt))
    }
}
