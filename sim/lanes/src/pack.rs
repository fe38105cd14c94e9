//! `N` variants side by side.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use crate::mask::bits;
use crate::{Lane, PackMask};

/// `N` numbers with the same operations; 8 of them fill one AVX-512 register or two AVX2 registers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Pack<const N: usize>(pub [f64; N]);

impl<const N: usize> Default for Pack<N> {
    fn default() -> Self {
        Self([0.0; N])
    }
}

macro_rules! elementwise {
    ($($trait:ident, $method:ident, $op:tt;)*) => {$(
        impl<const N: usize> $trait for Pack<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(std::array::from_fn(|i| self.0[i] $op other.0[i]))
            }
        }
    )*};
}

elementwise! {
    Add, add, +;
    Sub, sub, -;
    Mul, mul, *;
    Div, div, /;
}

impl<const N: usize> Neg for Pack<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl<const N: usize> AddAssign for Pack<N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const N: usize> SubAssign for Pack<N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<const N: usize> Lane for Pack<N> {
    type Mask = PackMask<N>;
    const WIDTH: usize = N;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; N])
    }
    #[inline(always)]
    fn from_fn(f: impl FnMut(usize) -> f64) -> Self {
        Self(std::array::from_fn(f))
    }
    #[inline(always)]
    fn lane(self, i: usize) -> f64 {
        self.0[i]
    }
    #[inline(always)]
    fn set_lane(&mut self, i: usize, value: f64) {
        self.0[i] = value;
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i].mul_add(a.0[i], b.0[i])))
    }
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        PackMask(std::array::from_fn(|i| bits(self.0[i] < other.0[i])))
    }
    #[inline(always)]
    fn le(self, other: Self) -> Self::Mask {
        PackMask(std::array::from_fn(|i| bits(self.0[i] <= other.0[i])))
    }
    #[inline(always)]
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self {
        let choose = |i: usize| (mask.0[i] & a.0[i].to_bits()) | (!mask.0[i] & b.0[i].to_bits());
        Self(std::array::from_fn(|i| f64::from_bits(choose(i))))
    }
}
