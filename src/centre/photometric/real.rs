//! Numbers that formulas are written for once: one `f32`, or as many at once as the machine's vectors hold.
//!
//! A loop over pixels that reads and writes a dozen rows is not turned into vectors by the compiler, which cannot know that the rows are
//! different memory. So the closed forms of blurred edges are written for whole vectors, and read like those for numbers.

use super::gram::WIDEST;
use pulp::Simd;
use std::array;
use std::f32::consts::{FRAC_PI_2, PI};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number, or a vector of them.
pub(super) trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f32, Output = Self>
    + Sub<f32, Output = Self>
    + Mul<f32, Output = Self>
{
    /// The same number everywhere, as many as this one is.
    fn like(self, value: f32) -> Self;

    /// `self * factor + more`, in one step where the machine can.
    fn times(self, factor: Self, more: Self) -> Self;

    /// Square root.
    fn sqrt(self) -> Self;

    /// The larger.
    fn at_least(self, least: f32) -> Self;

    /// The smaller.
    fn at_most(self, most: f32) -> Self;

    /// The larger of two vectors.
    fn larger(self, other: Self) -> Self;

    /// The smaller of two vectors.
    fn smaller(self, other: Self) -> Self;

    /// Where this is above zero the first, elsewhere the second.
    fn choose(self, positive: Self, other: Self) -> Self;

    /// Two to the power of the whole number in the low bits.
    fn power_of_two(self) -> Self;

    /// Without its sign.
    #[inline(always)]
    fn magnitude(self) -> Self {
        self.larger(-self)
    }

    /// Between two bounds.
    #[inline(always)]
    fn within(self, least: f32, most: f32) -> Self {
        self.at_least(least).at_most(most)
    }

    /// The polynomial with these coefficients, the highest power's first.
    #[inline(always)]
    fn polynomial<const N: usize>(self, coefficients: [f32; N]) -> Self {
        let mut sum = self.like(0.0);
        for (i, coefficient) in coefficients.into_iter().enumerate() {
            let coefficient = self.like(coefficient);
            sum = if i == 0 {
                coefficient
            } else {
                sum.times(self, coefficient)
            };
        }
        sum
    }
}

impl Real for f32 {
    #[inline(always)]
    fn like(self, value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn times(self, factor: Self, more: Self) -> Self {
        self * factor + more
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }

    #[inline(always)]
    fn at_least(self, least: f32) -> Self {
        self.max(least)
    }

    #[inline(always)]
    fn at_most(self, most: f32) -> Self {
        self.min(most)
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        self.max(other)
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        self.min(other)
    }

    #[inline(always)]
    fn choose(self, positive: Self, other: Self) -> Self {
        if self > 0.0 { positive } else { other }
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        Self::from_bits((self.to_bits() << 23).wrapping_add(ONE_BITS))
    }
}

/// Arc cosine, within 3e-8 (Abramowitz and Stegun, 4.4.46).
#[inline(always)]
pub(super) fn arccos<T: Real>(x: T) -> T {
    let a = x.magnitude();
    let series = a.polynomial([
        -0.001_262_491_1,
        0.006_670_09,
        -0.017_088_126,
        0.030_891_88,
        -0.050_174_305,
        0.088_978_99,
        -0.214_598_8,
        FRAC_PI_2,
    ]);
    let positive = (-a + 1.0).at_least(0.0).sqrt() * series;
    (-x).choose(-positive + PI, positive)
}

/// The bits of 1.
const ONE_BITS: u32 = 127 << 23;

/// A vector of the machine's.
#[derive(Clone, Copy)]
pub(super) struct Floats<S: Simd> {
    simd: S,
    pub(super) values: S::f32s,
}

impl<S: Simd> Floats<S> {
    /// A vector from the machine's own.
    #[inline(always)]
    pub(super) fn new(simd: S, values: S::f32s) -> Self {
        Self { simd, values }
    }

    /// One vector of a row.
    #[inline(always)]
    pub(super) fn of(simd: S, row: &[f32], vector: usize) -> Self {
        Self::new(simd, S::as_simd_f32s(row).0[vector])
    }

    /// The same number everywhere.
    #[inline(always)]
    pub(super) fn all(simd: S, value: f32) -> Self {
        Self::new(simd, simd.splat_f32s(value))
    }

    /// The smallest of them.
    #[inline(always)]
    pub(super) fn smallest(self) -> f32 {
        self.simd.reduce_min_f32s(self.values)
    }

    /// The largest of them.
    #[inline(always)]
    pub(super) fn largest(self) -> f32 {
        self.simd.reduce_max_f32s(self.values)
    }
}

/// The numbers of the columns of a row's vector.
#[inline(always)]
pub(super) fn columns<S: Simd>(simd: S, vector: usize) -> Floats<S> {
    let steps: [f32; WIDEST] = array::from_fn(|i| i as f32);
    let first = S::as_simd_f32s(&steps).0.first();
    let first = first.map_or(Floats::all(simd, 0.0), |steps| Floats::new(simd, *steps));
    first + (vector * S::F32_LANES) as f32
}

macro_rules! operator {
    ($trait:ident, $name:ident, $simd:ident) => {
        impl<S: Simd> $trait for Floats<S> {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self::new(self.simd, self.simd.$simd(self.values, other.values))
            }
        }

        impl<S: Simd> $trait<f32> for Floats<S> {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: f32) -> Self {
                self.$name(Self::all(self.simd, other))
            }
        }
    };
}

operator!(Add, add, add_f32s);
operator!(Sub, sub, sub_f32s);
operator!(Mul, mul, mul_f32s);
operator!(Div, div, div_f32s);

impl<S: Simd> Neg for Floats<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(self.simd, self.simd.neg_f32s(self.values))
    }
}

impl<S: Simd> Real for Floats<S> {
    #[inline(always)]
    fn like(self, value: f32) -> Self {
        Self::all(self.simd, value)
    }

    #[inline(always)]
    fn times(self, factor: Self, more: Self) -> Self {
        let values = self
            .simd
            .mul_add_e_f32s(self.values, factor.values, more.values);
        Self::new(self.simd, values)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::new(self.simd, self.simd.sqrt_f32s(self.values))
    }

    #[inline(always)]
    fn at_least(self, least: f32) -> Self {
        self.larger(self.like(least))
    }

    #[inline(always)]
    fn at_most(self, most: f32) -> Self {
        self.smaller(self.like(most))
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self::new(self.simd, self.simd.max_f32s(self.values, other.values))
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        Self::new(self.simd, self.simd.min_f32s(self.values, other.values))
    }

    #[inline(always)]
    fn choose(self, positive: Self, other: Self) -> Self {
        let simd = self.simd;
        let mask = simd.greater_than_f32s(self.values, simd.splat_f32s(0.0));
        Self::new(simd, simd.select_f32s(mask, positive.values, other.values))
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        let simd = self.simd;
        let bits = simd.transmute_u32s_f32s(self.values);
        let raised = simd.wrapping_dyn_shl_u32s(bits, simd.splat_u32s(23));
        let bits = simd.add_u32s(raised, simd.splat_u32s(ONE_BITS));
        Self::new(simd, simd.transmute_f32s_u32s(bits))
    }
}
