//! [`F4`] on x86-64.
#![allow(unsafe_code)] // Intrinsics of SSE2, which every x86-64 processor has; see the SAFETY notes.

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Four floats.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct F4(__m128);

macro_rules! sse {
    ($e:expr) => {
        // SAFETY: the intrinsic only needs SSE2, which is part of the x86-64 baseline; it touches registers alone.
        unsafe { $e }
    };
}

macro_rules! operator {
    ($($trait:ident $method:ident $f:ident;)*) => { $(
        impl $trait for F4 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self { Self(sse!($f(self.0, o.0))) }
        }
    )* };
}

operator! { Add add _mm_add_ps; Sub sub _mm_sub_ps; Mul mul _mm_mul_ps; Div div _mm_div_ps; }

impl Neg for F4 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(sse!(_mm_xor_ps(self.0, _mm_set1_ps(-0.0))))
    }
}

impl F4 {
    #[inline(always)]
    pub fn splat(v: f32) -> Self {
        Self(sse!(_mm_set1_ps(v)))
    }

    #[inline(always)]
    pub fn from_array(a: [f32; 4]) -> Self {
        Self(sse!(_mm_setr_ps(a[0], a[1], a[2], a[3])))
    }

    #[inline(always)]
    pub fn load(a: &[f32; 4]) -> Self {
        // SAFETY: the reference covers the sixteen bytes that are read; the load needs no alignment.
        Self(unsafe { _mm_loadu_ps(a.as_ptr()) })
    }

    #[inline(always)]
    pub fn store(self, a: &mut [f32; 4]) {
        // SAFETY: the reference covers the sixteen bytes that are written; the store needs no alignment.
        unsafe { _mm_storeu_ps(a.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    pub fn to_array(self) -> [f32; 4] {
        let mut a = [0.0; 4];
        self.store(&mut a);
        a
    }

    #[inline(always)]
    pub fn min(self, o: Self) -> Self {
        Self(sse!(_mm_min_ps(self.0, o.0)))
    }

    #[inline(always)]
    pub fn max(self, o: Self) -> Self {
        Self(sse!(_mm_max_ps(self.0, o.0)))
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        Self(sse!(_mm_andnot_ps(_mm_set1_ps(-0.0), self.0)))
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(sse!(_mm_sqrt_ps(self.0)))
    }

    /// Nearest integer, ties to even. [Limit: |self| < 2^31]
    #[inline(always)]
    pub fn round(self) -> Self {
        Self(sse!(_mm_cvtepi32_ps(_mm_cvtps_epi32(self.0))))
    }

    /// 2 to the power of an integer-valued exponent. [Limit: -126 <= self <= 127]
    #[inline(always)]
    pub fn exp2_integer(self) -> Self {
        Self(sse!(_mm_castsi128_ps(_mm_slli_epi32::<23>(_mm_add_epi32(_mm_cvtps_epi32(self.0), _mm_set1_epi32(127))))))
    }

    /// Lane by lane: `if a < b { yes } else { no }`.
    #[inline(always)]
    pub fn select_lt(a: Self, b: Self, yes: Self, no: Self) -> Self {
        Self(sse!({
            let m = _mm_cmplt_ps(a.0, b.0);
            _mm_or_ps(_mm_and_ps(m, yes.0), _mm_andnot_ps(m, no.0))
        }))
    }

    /// True where any lane of `self` is greater than that of `o`.
    #[inline(always)]
    pub fn any_gt(self, o: Self) -> bool {
        sse!(_mm_movemask_ps(_mm_cmpgt_ps(self.0, o.0))) != 0
    }

    /// Rows to columns.
    #[inline(always)]
    pub fn transpose(m: [Self; 4]) -> [Self; 4] {
        sse!({
            let (a, b) = (_mm_unpacklo_ps(m[0].0, m[1].0), _mm_unpackhi_ps(m[0].0, m[1].0));
            let (c, d) = (_mm_unpacklo_ps(m[2].0, m[3].0), _mm_unpackhi_ps(m[2].0, m[3].0));
            [_mm_movelh_ps(a, c), _mm_movehl_ps(c, a), _mm_movelh_ps(b, d), _mm_movehl_ps(d, b)].map(Self)
        })
    }

    /// Four integers of each of four lanes as floats: element i of the result holds component i of every lane.
    #[inline(always)]
    pub fn decode(rows: [&[i16; 4]; 4]) -> [Self; 4] {
        // SAFETY: each load reads the eight bytes its reference covers; the rest is SSE2 on registers.
        unsafe {
            let load = |r: &[i16; 4]| _mm_loadl_epi64(r.as_ptr().cast());
            let (a, b) =
                (_mm_unpacklo_epi16(load(rows[0]), load(rows[2])), _mm_unpacklo_epi16(load(rows[1]), load(rows[3])));
            // a: x0 x2 y0 y2 z0 z2 w0 w2, b: x1 x3 y1 y3 ...; interleaved: x0 x1 x2 x3 y0 y1 ...
            let (xy, zw) = (_mm_unpacklo_epi16(a, b), _mm_unpackhi_epi16(a, b));
            let low = |v| Self(_mm_cvtepi32_ps(_mm_srai_epi32::<16>(_mm_unpacklo_epi16(v, v))));
            let high = |v| Self(_mm_cvtepi32_ps(_mm_srai_epi32::<16>(_mm_unpackhi_epi16(v, v))));
            [low(xy), high(xy), low(zw), high(zw)]
        }
    }
}
