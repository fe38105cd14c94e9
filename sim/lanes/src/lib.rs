//! Lanes: the physics is written once over [`Lane`], and runs on one machine (`f64`) or on several variants
//! side by side ([`Pack`]).
//!
//! Every operation on a [`Pack`] is the same IEEE operation on each of its numbers. So a variant gives the
//! same bits in any lane of any width. Packs are plain arrays that the compiler vectorises. At run time
//! [`dispatch`] selects the widest instruction set of the processor.

mod blocks;
mod mask;
mod pack;

pub use blocks::Blocks;
pub use mask::{LaneMask, PackMask};
pub use pack::Pack;

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A number, or several numbers with the same operations.
pub trait Lane:
    Copy
    + Debug
    + Default
    + Send
    + Sync
    + PartialEq
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// The result type of comparisons.
    type Mask: LaneMask;

    /// Number of variants side by side.
    const WIDTH: usize;

    /// The same value in every lane.
    fn splat(value: f64) -> Self;

    /// The value `f(i)` in lane `i`.
    fn from_fn(f: impl FnMut(usize) -> f64) -> Self;

    /// The value in lane `i`.
    ///
    /// # Panics
    /// If `i >= WIDTH`.
    fn lane(self, i: usize) -> f64;

    /// Replaces the value in lane `i`.
    ///
    /// # Panics
    /// If `i >= WIDTH`.
    fn set_lane(&mut self, i: usize, value: f64);

    /// `self * a + b` rounded once. Fast only inside [`dispatch`]; correct everywhere.
    #[must_use]
    fn mul_add(self, a: Self, b: Self) -> Self;

    /// Applies `f` to every lane: for functions without a vector form.
    #[must_use]
    fn map(self, f: impl Fn(f64) -> f64) -> Self;

    /// `f` of each lane of `self` and `other`.
    #[must_use]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self;

    /// Lane by lane, `self < other`.
    fn lt(self, other: Self) -> Self::Mask;

    /// Lane by lane, `self <= other`.
    fn le(self, other: Self) -> Self::Mask;

    /// `a` where the mask holds, else `b`.
    #[must_use]
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;

    /// Lane by lane, `self > other`.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }

    /// Lane by lane, `self >= other`.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }

    /// Zero in every lane.
    #[inline(always)]
    #[must_use]
    fn zero() -> Self {
        Self::splat(0.0)
    }

    /// The smaller of the two; `other` if `self` is NaN.
    #[inline(always)]
    #[must_use]
    fn min(self, other: Self) -> Self {
        Self::select(self.lt(other), self, other)
    }

    /// The larger of the two; `other` if `self` is NaN.
    #[inline(always)]
    #[must_use]
    fn max(self, other: Self) -> Self {
        Self::select(self.gt(other), self, other)
    }

    /// `self` limited to `[-bound, bound]`.
    #[inline(always)]
    #[must_use]
    fn clamp_to(self, bound: Self) -> Self {
        self.min(bound).max(-bound)
    }

    /// Magnitude.
    #[inline(always)]
    #[must_use]
    fn abs(self) -> Self {
        self.map(f64::abs)
    }

    /// Square root.
    #[inline(always)]
    #[must_use]
    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }
}

impl Lane for f64 {
    type Mask = bool;
    const WIDTH: usize = 1;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> f64) -> Self {
        f(0)
    }
    #[inline(always)]
    fn lane(self, i: usize) -> f64 {
        assert_eq!(i, 0, "a lone f64 has lane 0 only");
        self
    }
    #[inline(always)]
    fn set_lane(&mut self, i: usize, value: f64) {
        assert_eq!(i, 0, "a lone f64 has lane 0 only");
        *self = value;
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        f64::mul_add(self, a, b)
    }
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        f(self)
    }
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        f(self, other)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn select(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }
}

/// Runs `f` compiled for the widest vector instructions this processor has (AVX-512, AVX2 with FMA, or the
/// baseline).
///
/// Only code inlined into `f` benefits, so kernels passed here are `#[inline(always)]` throughout. The result
/// does not depend on the choice: no operation is reassociated, and a fused multiply-add is rounded once on
/// every processor.
#[inline]
pub fn dispatch<R>(f: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(f)
}
