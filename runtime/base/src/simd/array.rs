//! [`Lanes`] on any machine, and the reference that registers are tested against.

use super::{LANES, Lanes};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Eight floats in memory order.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct ArrayLanes([f32; LANES]);

impl ArrayLanes {
    #[inline(always)]
    fn zip(self, o: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], o.0[i])))
    }
}

macro_rules! operator {
    ($($trait:ident $method:ident;)*) => { $(
        impl $trait for ArrayLanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self { self.zip(o, |a, b| a.$method(b)) }
        }
    )* };
}

operator! { Add add; Sub sub; Mul mul; Div div; }

impl Neg for ArrayLanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|v| -v))
    }
}

impl Lanes for ArrayLanes {
    #[inline(always)]
    fn splat(v: f32) -> Self {
        Self([v; LANES])
    }

    #[inline(always)]
    fn load(a: &[f32; LANES]) -> Self {
        Self(*a)
    }

    #[inline(always)]
    fn store(self, a: &mut [f32; LANES]) {
        *a = self.0;
    }

    #[inline(always)]
    fn min(self, o: Self) -> Self {
        self.zip(o, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn max(self, o: Self) -> Self {
        self.zip(o, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }

    #[inline(always)]
    fn round(self) -> Self {
        Self(self.0.map(f32::round_ties_even))
    }

    #[inline(always)]
    fn times_exp2(self, exponent: Self) -> Self {
        self.zip(exponent, |v, n| f32::from_bits(v.to_bits().wrapping_add((n as i32 as u32) << 23)))
    }

    #[inline(always)]
    fn select_lt(a: Self, b: Self, yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|i| if a.0[i] < b.0[i] { yes.0[i] } else { no.0[i] }))
    }

    #[inline(always)]
    fn any_gt(self, o: Self) -> bool {
        (0..LANES).any(|i| self.0[i] > o.0[i])
    }

    #[inline(always)]
    fn bits_lt(self, o: Self) -> u8 {
        (0..LANES).map(|i| u8::from(self.0[i] < o.0[i]) << i).sum()
    }

    #[inline(always)]
    fn rows(m: [Self; 4]) -> [[f32; 4]; LANES] {
        std::array::from_fn(|i| m.map(|v| v.0[i]))
    }

    #[inline(always)]
    fn integers(a: &[i16; LANES]) -> Self {
        Self(a.map(f32::from))
    }

    #[inline(always)]
    fn columns(rows: [&[f32; 4]; LANES]) -> [Self; 4] {
        std::array::from_fn(|i| Self(std::array::from_fn(|j| rows[j][i])))
    }

    #[inline(always)]
    fn gather(table: &[f32], stride: usize, rows: Self, row_len: u32, offsets: Self) -> [Self; 2] {
        let last = table.len() - 1 - stride;
        let at = rows.zip(offsets, |row, offset| {
            f32::from_bits(row.to_bits().wrapping_mul(row_len).wrapping_add(offset as u32))
        });
        let at = at.0.map(|i| (i.to_bits() as usize).min(last));
        [Self(at.map(|i| table[i])), Self(at.map(|i| table[i + stride]))]
    }

    #[inline(always)]
    fn decode(rows: [&[i16; 4]; LANES]) -> [Self; 4] {
        std::array::from_fn(|i| Self(std::array::from_fn(|j| f32::from(rows[j][i]))))
    }

    #[inline(always)]
    fn field(words: [u64; LANES], shift: u32, bits: u32) -> Self {
        let mask = (1u64 << bits) - 1;
        Self(words.map(|w| (w.checked_shr(shift).unwrap_or(0) & mask) as f32))
    }
}
