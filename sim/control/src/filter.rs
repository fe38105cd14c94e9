//! Discrete filters. Configuration and state are separate: one configuration serves any number of states and
//! never changes in a run.
//!
//! All are second-order sections in transposed direct form II, from the continuous filter by the bilinear
//! transform `s = (2/T) (1 - z^-1) / (1 + z^-1)`. Source: Oppenheim and Schafer, "Discrete-Time Signal
//! Processing", section 7.2. Each constructor names the one frequency at which the transform is prewarped.
//! Elsewhere frequencies are compressed towards the Nyquist frequency. The gain at zero frequency is exactly
//! 1 for all of them.

use std::f64::consts::TAU;

use feeler_lanes::Lane;

use crate::listing::Listing;

/// Coefficients of `H(z) = (b0 + b1 z^-1 + b2 z^-2) / (1 + a1 z^-1 + a2 z^-2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section<L> {
    b0: L,
    b1: L,
    b2: L,
    a1: L,
    a2: L,
}

/// State of a [`Section`]: `s1[n+1] = b1 u - a1 y + s2[n]`, `s2[n+1] = b2 u - a2 y`, `y[n] = b0 u + s1[n]`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SectionState<L> {
    s1: L,
    s2: L,
}

impl Section<f64> {
    /// Passes its input unchanged.
    pub const IDENTITY: Self = Self { b0: 1.0, b1: 0.0, b2: 0.0, a1: 0.0, a2: 0.0 };

    /// First-order low-pass `1 / (1 + s / w_c)`; -3 dB exactly at `cutoff_hz`, which must lie below half the
    /// sample rate.
    pub fn low_pass_first(cutoff_hz: f64, period_s: f64) -> Self {
        let g = (0.5 * TAU * cutoff_hz * period_s).tan();
        let b = g / (1.0 + g);
        Self { b0: b, b1: b, b2: 0.0, a1: (g - 1.0) / (1.0 + g), a2: 0.0 }
    }

    /// Second-order low-pass `w^2 / (s^2 + 2 zeta w s + w^2)`; magnitude `1 / (2 zeta)` and phase -90 deg
    /// exactly at `natural_hz`, which must lie below half the sample rate.
    pub fn low_pass_second(natural_hz: f64, damping_ratio: f64, period_s: f64) -> Self {
        let g = (0.5 * TAU * natural_hz * period_s).tan();
        let a0 = 1.0 + 2.0 * damping_ratio * g + g * g;
        let b = g * g / a0;
        Self {
            b0: b,
            b1: 2.0 * b,
            b2: b,
            a1: 2.0 * (g * g - 1.0) / a0,
            a2: (1.0 - 2.0 * damping_ratio * g + g * g) / a0,
        }
    }

    /// Lead `(1 + s / w_z) / (1 + s / w_p)`, not prewarped, so that the gain at half the sample rate is
    /// exactly `pole_hz / zero_hz`.
    pub fn lead(zero_hz: f64, pole_hz: f64, period_s: f64) -> Self {
        // 2 / (T w): the bilinear image of s / w is this times (1 - z^-1) / (1 + z^-1).
        let z = 2.0 / (TAU * zero_hz * period_s);
        let p = 2.0 / (TAU * pole_hz * period_s);
        Self {
            b0: (1.0 + z) / (1.0 + p),
            b1: (1.0 - z) / (1.0 + p),
            b2: 0.0,
            a1: (1.0 - p) / (1.0 + p),
            a2: 0.0,
        }
    }

    /// Notch `(s^2 + 2 depth zeta w s + w^2) / (s^2 + 2 zeta w s + w^2)`; gain `depth` and no phase exactly
    /// at `frequency_hz`, which must lie below half the sample rate.
    pub fn notch(frequency_hz: f64, damping_ratio: f64, depth: f64, period_s: f64) -> Self {
        let g = (0.5 * TAU * frequency_hz * period_s).tan();
        let (width, a0) = (2.0 * damping_ratio * g, 1.0 + 2.0 * damping_ratio * g + g * g);
        let b1 = 2.0 * (g * g - 1.0) / a0;
        Self {
            b0: (1.0 + depth * width + g * g) / a0,
            b1,
            b2: (1.0 - depth * width + g * g) / a0,
            a1: b1,
            a2: (1.0 - width + g * g) / a0,
        }
    }

    /// `[real, imaginary]` part of the response at `frequency_hz` when run every `period_s`.
    pub fn response(&self, frequency_hz: f64, period_s: f64) -> [f64; 2] {
        let w = TAU * frequency_hz * period_s;
        let (c1, s1, c2, s2) = (w.cos(), -w.sin(), (2.0 * w).cos(), -(2.0 * w).sin());
        let num = [self.b0 + self.b1 * c1 + self.b2 * c2, self.b1 * s1 + self.b2 * s2];
        let den = [1.0 + self.a1 * c1 + self.a2 * c2, self.a1 * s1 + self.a2 * s2];
        let norm = den[0] * den[0] + den[1] * den[1];
        [(num[0] * den[0] + num[1] * den[1]) / norm, (num[1] * den[0] - num[0] * den[1]) / norm]
    }
}

impl<L: Lane> Section<L> {
    /// The section `of(i)` in lane `i`; `None` if every lane passes its input unchanged.
    pub(crate) fn of_lanes(of: impl Fn(usize) -> Option<Section<f64>>) -> Option<Self> {
        (0..L::WIDTH)
            .any(|i| of(i).is_some())
            .then(|| Self::from_lanes(|i| of(i).unwrap_or(Section::IDENTITY)))
    }

    /// The section `of(i)` in lane `i`.
    pub(crate) fn from_lanes(of: impl Fn(usize) -> Section<f64>) -> Self {
        Self {
            b0: L::from_fn(|i| of(i).b0),
            b1: L::from_fn(|i| of(i).b1),
            b2: L::from_fn(|i| of(i).b2),
            a1: L::from_fn(|i| of(i).a1),
            a2: L::from_fn(|i| of(i).a2),
        }
    }

    /// The steady state for a constant input `u`, for a section of gain 1 at zero frequency.
    #[inline(always)]
    pub fn settled(&self, u: L) -> SectionState<L> {
        SectionState { s1: u - self.b0 * u, s2: (self.b2 - self.a2) * u }
    }

    /// Takes the input of one sample and returns the output of the same sample.
    #[inline(always)]
    pub fn update(&self, state: &mut SectionState<L>, u: L) -> L {
        let y = self.b0 * u + state.s1;
        state.s1 = self.b1 * u - self.a1 * y + state.s2;
        state.s2 = self.b2 * u - self.a2 * y;
        y
    }
}

impl Section<f64> {
    /// [`Self::update`] of the input `u` as lines of a program, begun by [`Self::settled`] where `restarts`
    /// holds; gives the name of the output.
    pub(crate) fn list(&self, listing: &mut Listing, name: &str, u: &str, restarts: &str) -> String {
        let up = name.to_uppercase();
        for (of, value) in
            [("B0", self.b0), ("B1", self.b1), ("B2", self.b2), ("A1", self.a1), ("A2", self.a2)]
        {
            listing.constant(&format!("{up}_{of}"), value);
        }
        let (s1, s2) = (format!("{name}_1"), format!("{name}_2"));
        listing.number_state(&s1);
        listing.number_state(&s2);
        listing.choice(&s1, restarts, &format!("{u} - {up}_B0 * {u}"), &format!("s.{s1}"));
        listing.choice(&s2, restarts, &format!("({up}_B2 - {up}_A2) * {u}"), &format!("s.{s2}"));
        let y = format!("{name}_out");
        listing.number(&y, &format!("{up}_B0 * {u} + {s1}"));
        listing.set(&s1, &format!("{up}_B1 * {u} - {up}_A1 * {y} + {s2}"));
        listing.set(&s2, &format!("{up}_B2 * {u} - {up}_A2 * {y}"));
        y
    }
}

impl<L: Lane> SectionState<L> {
    pub(crate) fn from_array([s1, s2]: [L; 2]) -> Self {
        Self { s1, s2 }
    }

    pub(crate) fn to_array(self) -> [L; 2] {
        [self.s1, self.s2]
    }

    /// `a` where the mask holds, else `b`.
    #[inline(always)]
    #[must_use]
    pub fn select(mask: L::Mask, a: Self, b: Self) -> Self {
        Self { s1: L::select(mask, a.s1, b.s1), s2: L::select(mask, a.s2, b.s2) }
    }
}
