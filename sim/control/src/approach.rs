//! The phase before contact.

use std::f64::consts::TAU;

use feeler_lanes::{Lane, LaneMask};

use crate::listing::Listing;
use crate::spec::Approach;

/// Damping ratio of the approach's position loop.
const DAMPING_RATIO: f64 = 0.7;

#[derive(Clone, Copy)]
pub(crate) struct ApproachConfig<L: Lane> {
    /// Lanes that have an approach.
    present: L::Mask,
    speed: L,
    until: L,
    release: L,
    /// `M w^2`; zero for a velocity source.
    stiffness: L,
    /// `2 zeta M w`; zero for a velocity source.
    damping: L,
    /// The speed itself for a velocity source, else zero.
    command: L,
}

#[derive(Clone, Copy)]
pub(crate) struct ApproachState<L: Lane> {
    /// Lanes in the contact phase at the last sample.
    contact: L::Mask,
    /// Lanes whose approach has begun and has an origin.
    moving: L::Mask,
    origin: L,
    since: L,
}

/// Result of the approach for one sample.
pub(crate) struct Phase<L: Lane> {
    /// Lanes that run their law now.
    pub(crate) contact: L::Mask,
    /// Lanes that run their law for the first time now.
    pub(crate) fresh: L::Mask,
    /// The output of lanes without a running law.
    pub(crate) output: L,
}

impl<L: Lane> ApproachConfig<L> {
    pub(crate) fn new(approach: impl Fn(usize) -> Option<Approach>) -> Self {
        let value =
            |of: fn(&Approach) -> f64, absent: f64| L::from_fn(|i| approach(i).as_ref().map_or(absent, of));
        Self {
            present: L::Mask::from_fn(|i| approach(i).is_some()),
            speed: value(|a| a.speed, 0.0),
            until: value(|a| a.until, f64::NEG_INFINITY),
            release: value(|a| a.release.unwrap_or(f64::NEG_INFINITY), f64::NEG_INFINITY),
            stiffness: value(
                |a| if a.velocity_drive { 0.0 } else { a.effective_mass * (TAU * a.bandwidth_hz).powi(2) },
                0.0,
            ),
            damping: value(
                |a| {
                    if a.velocity_drive {
                        0.0
                    } else {
                        2.0 * DAMPING_RATIO * a.effective_mass * TAU * a.bandwidth_hz
                    }
                },
                0.0,
            ),
            command: value(|a| if a.velocity_drive { a.speed } else { 0.0 }, 0.0),
        }
    }

    #[inline(always)]
    pub(crate) fn update(&self, state: &mut ApproachState<L>, t: L, f: L, x: L, v: L) -> Phase<L> {
        if !self.present.any() {
            // The general case below gives the same result; this is cheaper for machines without an approach.
            let fresh = !state.contact;
            state.contact = L::Mask::splat(true);
            return Phase { contact: state.contact, fresh, output: L::zero() };
        }
        // Contact ends below `release` and begins at `until`.
        let kept = state.contact & !f.lt(self.release);
        let contact = !self.present | kept | f.ge(self.until);
        let fresh = contact & !state.contact;
        state.origin = L::select(state.moving, state.origin, x);
        state.since = L::select(state.moving, state.since, t);
        state.contact = contact;
        state.moving = !contact;
        let ramp = state.origin + self.speed * (t - state.since);
        let output = self.stiffness * (ramp - x) + self.damping * (self.speed - v) + self.command;
        Phase { contact, fresh, output }
    }
}

impl<L: Lane> ApproachState<L> {
    pub(crate) fn new() -> Self {
        let none = L::Mask::splat(false);
        Self { contact: none, moving: none, origin: L::zero(), since: L::zero() }
    }

    /// A state that has been in the contact phase since the last sample at least.
    pub(crate) fn in_contact() -> Self {
        Self { contact: L::Mask::splat(true), ..Self::new() }
    }

    pub(crate) fn contact(&self) -> L::Mask {
        self.contact
    }
}

impl ApproachConfig<f64> {
    pub(crate) fn is_present(&self) -> bool {
        self.present
    }

    /// The phases of [`Self::update`] as lines of a program. Gives the condition under which the law starts,
    /// and the one under which it runs; `None` if it always runs.
    pub(crate) fn list_phase(&self, l: &mut Listing, y: &str, x: &str) -> (String, Option<String>) {
        l.truth_state("contact");
        if !self.present {
            l.truth("fresh", "!s.contact");
            l.set("contact", "true");
            return ("fresh".into(), None);
        }
        l.constant("UNTIL", self.until);
        let kept = if self.release.is_finite() {
            l.constant("RELEASE", self.release);
            format!("(s.contact && !({y} < RELEASE))")
        } else {
            "s.contact".into()
        };
        l.truth("contact", &format!("{kept} || {y} >= UNTIL"));
        l.truth("fresh", "contact && !s.contact");
        l.truth_state("moving");
        l.number_state("origin");
        l.number_state("since");
        l.choice("origin", "s.moving", "s.origin", x);
        l.choice("since", "s.moving", "s.since", "t");
        for (state, value) in
            [("origin", "origin"), ("since", "since"), ("contact", "contact"), ("moving", "!contact")]
        {
            l.set(state, value);
        }
        ("fresh".into(), Some("contact".into()))
    }

    /// The output of law or approach as lines of a program, where `contact` decides which runs.
    pub(crate) fn list_output(
        &self,
        l: &mut Listing,
        law: &str,
        contact: Option<&str>,
        x: &str,
        v: &str,
    ) -> String {
        let Some(contact) = contact else { return law.into() };
        for (name, value) in [
            ("APPROACH_SPEED", self.speed),
            ("APPROACH_STIFFNESS", self.stiffness),
            ("APPROACH_DAMPING", self.damping),
            ("APPROACH_COMMAND", self.command),
        ] {
            l.constant(name, value);
        }
        l.number("ramp", "origin + APPROACH_SPEED * (t - since)");
        let spring = format!("APPROACH_STIFFNESS * (ramp - {x})");
        let damper = format!("APPROACH_DAMPING * (APPROACH_SPEED - {v})");
        l.number("approach", &format!("{spring} + {damper} + APPROACH_COMMAND"));
        l.choice("output", contact, law, "approach");
        "output".into()
    }
}
