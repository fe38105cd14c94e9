//! Truth values of lanes.

use std::fmt::Debug;
use std::ops::{BitAnd, BitOr, Not};

/// One truth value per lane.
pub trait LaneMask:
    Copy + Debug + Send + Sync + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> + 'static
{
    /// The same truth in every lane.
    fn splat(value: bool) -> Self;
    /// `f(i)` in lane `i`.
    fn from_fn(f: impl FnMut(usize) -> bool) -> Self;
    /// The truth in lane `i`.
    fn test(self, i: usize) -> bool;
    /// Whether any lane holds.
    fn any(self) -> bool;
    /// Whether every lane holds.
    fn all(self) -> bool;
}

impl LaneMask for bool {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        value
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> bool) -> Self {
        f(0)
    }
    #[inline(always)]
    fn test(self, _i: usize) -> bool {
        self
    }
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
}

/// The truth values of a [`crate::Pack`] of `N` lanes: all bits of a lane that holds, none of another. So
/// masks stay in vector registers, and a choice between two packs is bitwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(align(64))]
pub struct PackMask<const N: usize>(pub(crate) [u64; N]);

/// All bits if `truth` holds, else none.
#[inline(always)]
pub(crate) fn bits(truth: bool) -> u64 {
    0_u64.wrapping_sub(u64::from(truth))
}

impl<const N: usize> LaneMask for PackMask<N> {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        Self([bits(value); N])
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> bool) -> Self {
        Self(std::array::from_fn(|i| bits(f(i))))
    }
    #[inline(always)]
    fn test(self, i: usize) -> bool {
        self.0[i] != 0
    }
    #[inline(always)]
    fn any(self) -> bool {
        // Folding without a branch keeps the loop a vector reduction.
        self.0.iter().fold(0, |a, b| a | b) != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0.iter().fold(u64::MAX, |a, b| a & b) != 0
    }
}

impl<const N: usize> BitAnd for PackMask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] & other.0[i]))
    }
}

impl<const N: usize> BitOr for PackMask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] | other.0[i]))
    }
}

impl<const N: usize> Not for PackMask<N> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0.map(|bits| !bits))
    }
}
