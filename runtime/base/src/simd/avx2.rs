//! [`Lanes`] in the registers of x86-64 processors with AVX2.
#![allow(unsafe_code)] // Intrinsics; [`super::dispatch`] is the one place that uses this type, see the SAFETY notes.

use super::{LANES, Lanes};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Eight floats in a register.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Avx2(__m256);

macro_rules! avx {
    ($e:expr) => {
        // SAFETY: values of this type are made only under `dispatch`, which has found AVX2; the intrinsic touches
        // registers alone, or memory that a reference covers and that needs no alignment.
        unsafe { $e }
    };
}

macro_rules! operator {
    ($($trait:ident $method:ident $f:ident;)*) => { $(
        impl $trait for Avx2 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self { Self(avx!($f(self.0, o.0))) }
        }
    )* };
}

operator! { Add add _mm256_add_ps; Sub sub _mm256_sub_ps; Mul mul _mm256_mul_ps; Div div _mm256_div_ps; }

impl Neg for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(avx!(_mm256_xor_ps(self.0, _mm256_set1_ps(-0.0))))
    }
}

impl Lanes for Avx2 {
    #[inline(always)]
    fn splat(v: f32) -> Self {
        Self(avx!(_mm256_set1_ps(v)))
    }

    #[inline(always)]
    fn load(a: &[f32; LANES]) -> Self {
        Self(avx!(_mm256_loadu_ps(a.as_ptr())))
    }

    #[inline(always)]
    fn store(self, a: &mut [f32; LANES]) {
        avx!(_mm256_storeu_ps(a.as_mut_ptr(), self.0));
    }

    #[inline(always)]
    fn min(self, o: Self) -> Self {
        Self(avx!(_mm256_min_ps(self.0, o.0)))
    }

    #[inline(always)]
    fn max(self, o: Self) -> Self {
        Self(avx!(_mm256_max_ps(self.0, o.0)))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(avx!(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0)))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(avx!(_mm256_sqrt_ps(self.0)))
    }

    #[inline(always)]
    fn round(self) -> Self {
        Self(avx!(_mm256_round_ps::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(self.0)))
    }

    #[inline(always)]
    fn times_exp2(self, exponent: Self) -> Self {
        Self(avx!({
            let n = _mm256_slli_epi32::<23>(_mm256_cvtps_epi32(exponent.0));
            _mm256_castsi256_ps(_mm256_add_epi32(_mm256_castps_si256(self.0), n))
        }))
    }

    #[inline(always)]
    fn select_lt(a: Self, b: Self, yes: Self, no: Self) -> Self {
        Self(avx!(_mm256_blendv_ps(no.0, yes.0, _mm256_cmp_ps::<_CMP_LT_OQ>(a.0, b.0))))
    }

    #[inline(always)]
    fn any_gt(self, o: Self) -> bool {
        avx!(_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(self.0, o.0))) != 0
    }

    #[inline(always)]
    fn bits_lt(self, o: Self) -> u8 {
        avx!(_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, o.0))) as u8
    }

    #[inline(always)]
    fn rows(m: [Self; 4]) -> [[f32; 4]; LANES] {
        let mut out = [[0.0; 4]; LANES];
        avx!({
            let (a, b) = (_mm256_unpacklo_ps(m[0].0, m[1].0), _mm256_unpackhi_ps(m[0].0, m[1].0));
            let (c, d) = (_mm256_unpacklo_ps(m[2].0, m[3].0), _mm256_unpackhi_ps(m[2].0, m[3].0));
            // Each holds a row of a lane and of the lane four further on.
            let (p0, p1) = (_mm256_shuffle_ps::<0x44>(a, c), _mm256_shuffle_ps::<0xEE>(a, c));
            let (p2, p3) = (_mm256_shuffle_ps::<0x44>(b, d), _mm256_shuffle_ps::<0xEE>(b, d));
            _mm_storeu_ps(out[0].as_mut_ptr(), _mm256_castps256_ps128(p0));
            _mm_storeu_ps(out[1].as_mut_ptr(), _mm256_castps256_ps128(p1));
            _mm_storeu_ps(out[2].as_mut_ptr(), _mm256_castps256_ps128(p2));
            _mm_storeu_ps(out[3].as_mut_ptr(), _mm256_castps256_ps128(p3));
            _mm_storeu_ps(out[4].as_mut_ptr(), _mm256_extractf128_ps::<1>(p0));
            _mm_storeu_ps(out[5].as_mut_ptr(), _mm256_extractf128_ps::<1>(p1));
            _mm_storeu_ps(out[6].as_mut_ptr(), _mm256_extractf128_ps::<1>(p2));
            _mm_storeu_ps(out[7].as_mut_ptr(), _mm256_extractf128_ps::<1>(p3));
        });
        out
    }

    #[inline(always)]
    fn integers(a: &[i16; LANES]) -> Self {
        Self(avx!(_mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(_mm_loadu_si128(a.as_ptr().cast())))))
    }

    #[inline(always)]
    fn columns(rows: [&[f32; 4]; LANES]) -> [Self; 4] {
        avx!({
            // Each holds a row and the one four lanes further on.
            let m0 = _mm256_loadu2_m128(rows[4].as_ptr(), rows[0].as_ptr());
            let m1 = _mm256_loadu2_m128(rows[5].as_ptr(), rows[1].as_ptr());
            let m2 = _mm256_loadu2_m128(rows[6].as_ptr(), rows[2].as_ptr());
            let m3 = _mm256_loadu2_m128(rows[7].as_ptr(), rows[3].as_ptr());
            let (a, b) = (_mm256_unpacklo_ps(m0, m1), _mm256_unpackhi_ps(m0, m1));
            let (c, d) = (_mm256_unpacklo_ps(m2, m3), _mm256_unpackhi_ps(m2, m3));
            [
                Self(_mm256_shuffle_ps::<0x44>(a, c)),
                Self(_mm256_shuffle_ps::<0xEE>(a, c)),
                Self(_mm256_shuffle_ps::<0x44>(b, d)),
                Self(_mm256_shuffle_ps::<0xEE>(b, d)),
            ]
        })
    }

    #[inline(always)]
    fn gather(table: &[f32], stride: usize, rows: Self, row_len: u32, offsets: Self) -> [Self; 2] {
        assert!(stride < table.len(), "the table has one place at least");
        let last = (table.len() - 1 - stride).min(u32::MAX as usize) as u32;
        let mut at = [0u32; LANES];
        // SAFETY: AVX2 is there, see `avx`. Indices are at most `last`, and `last + stride` lies within the table.
        unsafe {
            let start = _mm256_mullo_epi32(_mm256_castps_si256(rows.0), _mm256_set1_epi32(row_len as i32));
            let i = _mm256_add_epi32(start, _mm256_cvtps_epi32(offsets.0));
            let i = _mm256_min_epu32(i, _mm256_set1_epi32(last as i32));
            _mm256_storeu_si256(at.as_mut_ptr().cast(), i);
            [Self(load_each(table.as_ptr(), &at)), Self(load_each(table.as_ptr().add(stride), &at))]
        }
    }

    #[inline(always)]
    fn decode(rows: [&[i16; 4]; LANES]) -> [Self; 4] {
        let (xy, zw) = interleave(rows[0], rows[1], rows[2], rows[3]);
        let (xy_high, zw_high) = interleave(rows[4], rows[5], rows[6], rows[7]);
        avx!([
            Self(_mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(_mm_unpacklo_epi64(xy, xy_high)))),
            Self(_mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(_mm_unpackhi_epi64(xy, xy_high)))),
            Self(_mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(_mm_unpacklo_epi64(zw, zw_high)))),
            Self(_mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(_mm_unpackhi_epi64(zw, zw_high)))),
        ])
    }

    #[inline(always)]
    fn field(words: [u64; LANES], shift: u32, bits: u32) -> Self {
        let [w0, w1, w2, w3, w4, w5, w6, w7] = words;
        avx!({
            let by = _mm_cvtsi32_si128(shift as i32);
            // In an order that the shuffle of their lower halves undoes.
            let a = _mm256_castsi256_ps(_mm256_srl_epi64(pack_words(w0, w1, w4, w5), by));
            let b = _mm256_castsi256_ps(_mm256_srl_epi64(pack_words(w2, w3, w6, w7), by));
            let halves = _mm256_castps_si256(_mm256_shuffle_ps::<0b10_00_10_00>(a, b));
            Self(_mm256_cvtepi32_ps(_mm256_and_si256(halves, _mm256_set1_epi32((1i32 << bits) - 1))))
        })
    }
}

/// Four words, the first the lowest.
#[inline(always)]
fn pack_words(a: u64, b: u64, c: u64, d: u64) -> __m256i {
    avx!(_mm256_set_epi64x(d as i64, c as i64, b as i64, a as i64))
}

/// x0 x1 x2 x3 y0 y1 y2 y3 and z0 .. w3 of four lanes.
#[inline(always)]
fn interleave(r0: &[i16; 4], r1: &[i16; 4], r2: &[i16; 4], r3: &[i16; 4]) -> (__m128i, __m128i) {
    avx!({
        let a = _mm_unpacklo_epi16(_mm_loadl_epi64(r0.as_ptr().cast()), _mm_loadl_epi64(r2.as_ptr().cast()));
        let b = _mm_unpacklo_epi16(_mm_loadl_epi64(r1.as_ptr().cast()), _mm_loadl_epi64(r3.as_ptr().cast()));
        (_mm_unpacklo_epi16(a, b), _mm_unpackhi_epi16(a, b))
    })
}

/// Eight single loads: quicker than the gather instruction on many processors.
///
/// # Safety
/// AVX2 is there, and all of `at` lie within what `table` points to.
#[inline(always)]
unsafe fn load_each(table: *const f32, at: &[u32; LANES]) -> __m256 {
    // SAFETY: the caller's promise.
    unsafe {
        let v = |l: usize| *table.add(at[l] as usize);
        _mm256_setr_ps(v(0), v(1), v(2), v(3), v(4), v(5), v(6), v(7))
    }
}
