//! Eight characters at a time: vectors of eight floats, one lane a character, and what is built of them.
//!
//! Code is generic over [`Lanes`]: on x86-64 processors with AVX2 a vector is one register, elsewhere it is an array
//! that the compiler vectorises. Only operations that IEEE 754 rounds the same way everywhere are used, and multiply
//! and add are never fused, so results are equal on every machine.

mod array;
#[cfg(target_arch = "x86_64")]
mod avx2;
mod quat;
mod scalar;
mod vectorize;

pub use array::ArrayLanes;
#[cfg(target_arch = "x86_64")]
pub use avx2::Avx2;
pub use quat::{Q, V};
pub use scalar::{EXP2, Functions};
pub use vectorize::vectorize;

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Number of lanes.
pub const LANES: usize = 8;

/// Eight floats.
pub trait Lanes:
    Copy + Debug + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Vector with the same number in every lane.
    fn splat(v: f32) -> Self;
    /// Loads a vector from memory.
    fn load(a: &[f32; LANES]) -> Self;
    /// Stores the vector to memory.
    fn store(self, a: &mut [f32; LANES]);
    /// Minimum in each lane; `o` where the two cannot be compared.
    fn min(self, o: Self) -> Self;
    /// Maximum in each lane; `o` where the two cannot be compared.
    fn max(self, o: Self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Nearest integer, ties to even (|self| < 2^31).
    fn round(self) -> Self;
    /// Product with 2 to the power of an integer-valued exponent (self and the result are normal numbers).
    fn times_exp2(self, exponent: Self) -> Self;
    /// Choice in each lane: `if a < b { yes } else { no }`.
    fn select_lt(a: Self, b: Self, yes: Self, no: Self) -> Self;
    /// True where any lane of `self` is greater than that of `o`.
    fn any_gt(self, o: Self) -> bool;
    /// Mask of lanes: bit i is set where lane i of `self` is less than that of `o`.
    fn bits_lt(self, o: Self) -> u8;
    /// Four vectors as one row of four for each lane.
    fn rows(m: [Self; 4]) -> [[f32; 4]; LANES];
    /// The inverse of [`Self::rows`]: element i of the result holds component i of every lane's row.
    fn columns(rows: [&[f32; 4]; LANES]) -> [Self; 4];
    /// Two numbers of a table for each lane, `stride` apart: at `row * row_len + offset` and `stride` further.
    ///
    /// Indices beyond the table read its last entry instead, so that no lane needs a check.
    ///
    /// - `rows`: the bits of each lane are an unsigned integer.
    /// - `offsets`: integer-valued (0 to 2^24).
    /// - `table`: (> stride)
    fn gather(table: &[f32], stride: usize, rows: Self, row_len: u32, offsets: Self) -> [Self; 2];
    /// Four integers of each lane as floats: element i of the result holds component i of every lane.
    fn decode(rows: [&[i16; 4]; LANES]) -> [Self; 4];
    /// A field of bits of each lane's word, as floats.
    ///
    /// - `shift`: its lowest bit (shift + bits <= 64).
    /// - `bits`: its width (0 to 24).
    fn field(words: [u64; LANES], shift: u32, bits: u32) -> Self;

    /// Eight integers as floats.
    fn integers(a: &[i16; LANES]) -> Self;

    /// Vector of an array.
    #[inline(always)]
    fn from_array(a: [f32; LANES]) -> Self {
        Self::load(&a)
    }

    /// Array of the lanes.
    #[inline(always)]
    fn to_array(self) -> [f32; LANES] {
        let mut a = [0.0; LANES];
        self.store(&mut a);
        a
    }
}

/// Work that is generic over [`Lanes`].
pub trait LaneWork {
    /// Result of the work.
    type Output;
    /// Does the work. Everything it calls must be inlined (`#[inline(always)]`) to profit. A closure on lanes that is called twice
    /// is compiled as a function without vectors.
    fn run<F: Lanes>(self) -> Self::Output;
}

/// Does the work with the widest vectors the processor has.
#[inline]
pub fn dispatch<W: LaneWork>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        #[allow(unsafe_code)]
        // SAFETY: the processor has the one feature that `with_avx2` asks for.
        return unsafe { with_avx2(work) };
    }
    with_arrays(work)
}

/// Not inlined into [`dispatch`], whose stack frame would then hold its locals while [`with_avx2`] runs: in unoptimised builds, hundreds
/// of kilobytes.
#[cfg_attr(target_arch = "x86_64", inline(never))]
fn with_arrays<W: LaneWork>(work: W) -> W::Output {
    work.run::<ArrayLanes>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2<W: LaneWork>(work: W) -> W::Output {
    work.run::<Avx2>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Work that keeps a megabyte on the stack.
    struct Large(usize);

    impl LaneWork for Large {
        type Output = usize;

        #[inline(always)]
        fn run<F: Lanes>(self) -> usize {
            let kept = [self.0 as u8; 1 << 20];
            self.0 - std::hint::black_box(&kept).as_ptr() as usize
        }
    }

    /// A thread has two megabytes of stack. Locals for registers and for arrays were there at once.
    #[test]
    #[cfg_attr(miri, ignore = "Miri does not lay out a stack")]
    fn the_stack_holds_the_work_once() {
        let here = 0u8;
        let deep = dispatch(Large(std::hint::black_box(&here) as *const u8 as usize));
        assert!((1 << 20..3 << 19).contains(&deep), "{deep} bytes");
    }

    /// Results of everything [`Lanes`] can do.
    struct Everything {
        a: [f32; LANES],
        b: [f32; LANES],
        codes: [[i16; 4]; LANES],
        integers: [i16; LANES],
    }

    impl LaneWork for Everything {
        type Output = Vec<[f32; LANES]>;

        fn run<F: Lanes>(self) -> Self::Output {
            let (x, y) = (F::from_array(self.a), F::from_array(self.b));
            let (sin, cos) = x.sin_cos8();
            let mut out = vec![
                x + y,
                x - y,
                x * y,
                x / y,
                -x,
                x.min(y),
                x.max(y),
                x.abs().sqrt(),
                x.round(),
                F::select_lt(x, y, x * y, y),
                F::splat(if x.any_gt(y) { 1.0 } else { 0.0 }),
                y.exp8(),
                (-y.abs()).exp2_neg(),
                F::angle_from_ahead(x, y),
                sin,
                cos,
            ];
            let fields = [(0, 0), (0, 24), (13, 11), (47, 17), (63, 1), (64, 0)];
            out.extend(fields.map(|(shift, bits)| F::field(words(), shift, bits)));
            out.push(F::integers(&self.integers));
            out.extend(F::decode(self.codes.each_ref()));
            let mut out: Vec<[f32; LANES]> = out.into_iter().map(F::to_array).collect();
            let rows = F::rows([x, y, x + y, x - y]);
            out.extend(rows.chunks(2).map(|r| std::array::from_fn(|i| r[i / 4][i % 4])));
            out.extend(F::columns(rows.each_ref()).map(F::to_array));
            let places = F::from_array(std::array::from_fn(|i| f32::from_bits(i as u32)));
            let offsets = F::from_array(std::array::from_fn(|i| (i % 3) as f32));
            out.extend(F::gather(&table(), 4, places, 9, offsets).map(F::to_array));
            out.push([f32::from(x.bits_lt(y)); LANES]);
            out
        }
    }

    /// Words whose fields all differ.
    fn words() -> [u64; LANES] {
        std::array::from_fn(|i| 0x9e37_79b9_7f4a_7c15u64.wrapping_mul(2 * i as u64 + 1))
    }

    /// Something to gather from, too short for the last lanes.
    fn table() -> [f32; 60] {
        std::array::from_fn(|i| i as f32 * 1.5 - 7.0)
    }

    fn eight() -> impl Strategy<Value = [f32; LANES]> {
        prop::array::uniform8(-100.0f32..100.0)
    }

    proptest! {
        #[test]
        fn registers_and_arrays_give_the_same_bits(
            a in eight(), b in eight(), codes in prop::array::uniform8(prop::array::uniform4(any::<i16>())),
            integers in prop::array::uniform8(any::<i16>())
        ) {
            let plain = Everything { a, b, codes, integers }.run::<ArrayLanes>();
            let widest = dispatch(Everything { a, b, codes, integers });
            let bits = |v: &[[f32; LANES]]| v.iter().flatten().map(|f| f.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(bits(&plain), bits(&widest));
            let from_end = |k: usize| plain[plain.len() - k];
            for lane in 0..LANES {
                let word = words()[lane];
                let fields = [0, word & 0xff_ffff, word >> 13 & 0x7ff, word >> 47, word >> 63, 0].map(|f| f as f32);
                let got: Vec<f32> = (0..6).map(|k| from_end(22 - k)[lane]).collect();
                prop_assert_eq!(got, fields.to_vec());
            }
            prop_assert_eq!(from_end(16).to_vec(), integers.map(f32::from).to_vec());
            prop_assert_eq!(from_end(13)[3], f32::from(codes[3][2]));
            prop_assert_eq!(from_end(11)[..4].to_vec(), vec![a[0], b[0], a[0] + b[0], a[0] - b[0]]);
            prop_assert_eq!((from_end(7), from_end(6)), (a, b), "columns undo rows");
            let table = table();
            for lane in 0..LANES {
                let place = (lane * 9 + lane % 3).min(table.len() - 1 - 4);
                prop_assert_eq!((from_end(3)[lane], from_end(2)[lane]), (table[place], table[place + 4]));
                prop_assert_eq!(from_end(1)[0] as u8 >> lane & 1 == 1, a[lane] < b[lane]);
            }
        }
    }
}
