//! [`F4`] on machines other than x86-64, and the reference the registers are tested against.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Four floats.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct F4([f32; 4]);

macro_rules! operator {
    ($($trait:ident $method:ident;)*) => { $(
        impl $trait for F4 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self { self.zip(o, |a, b| a.$method(b)) }
        }
    )* };
}

operator! { Add add; Sub sub; Mul mul; Div div; }

impl Neg for F4 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|v| -v))
    }
}

#[cfg_attr(test, allow(dead_code))]
impl F4 {
    #[inline(always)]
    fn zip(self, o: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], o.0[i])))
    }

    #[inline(always)]
    pub fn splat(v: f32) -> Self {
        Self([v; 4])
    }

    #[inline(always)]
    pub fn from_array(a: [f32; 4]) -> Self {
        Self(a)
    }

    #[inline(always)]
    pub fn load(a: &[f32; 4]) -> Self {
        Self(*a)
    }

    #[inline(always)]
    pub fn store(self, a: &mut [f32; 4]) {
        *a = self.0;
    }

    #[inline(always)]
    pub fn to_array(self) -> [f32; 4] {
        self.0
    }

    #[inline(always)]
    pub fn min(self, o: Self) -> Self {
        self.zip(o, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    pub fn max(self, o: Self) -> Self {
        self.zip(o, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }

    /// Nearest integer, ties to even. [Limit: |self| < 2^31]
    #[inline(always)]
    pub fn round(self) -> Self {
        Self(self.0.map(|v| v.round_ties_even() + 0.0))
    }

    /// 2 to the power of an integer-valued exponent. [Limit: -126 <= self <= 127]
    #[inline(always)]
    pub fn exp2_integer(self) -> Self {
        Self(self.0.map(|v| f32::from_bits(((v as i32 + 127) as u32) << 23)))
    }

    /// Lane by lane: `if a < b { yes } else { no }`.
    #[inline(always)]
    pub fn select_lt(a: Self, b: Self, yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|i| if a.0[i] < b.0[i] { yes.0[i] } else { no.0[i] }))
    }

    /// True where any lane of `self` is greater than that of `o`.
    #[inline(always)]
    pub fn any_gt(self, o: Self) -> bool {
        (0..4).any(|i| self.0[i] > o.0[i])
    }

    /// Rows to columns.
    #[inline(always)]
    pub fn transpose(m: [Self; 4]) -> [Self; 4] {
        std::array::from_fn(|i| Self(std::array::from_fn(|j| m[j].0[i])))
    }

    /// Four integers of each of four lanes as floats: element i of the result holds component i of every lane.
    #[inline(always)]
    pub fn decode(rows: [&[i16; 4]; 4]) -> [Self; 4] {
        std::array::from_fn(|i| Self(std::array::from_fn(|j| f32::from(rows[j][i]))))
    }
}
