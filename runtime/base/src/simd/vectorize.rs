//! Lets the compiler use wide vectors where the processor has them, in code that stays plain Rust.

use crate::simd::{LaneWork, Lanes, dispatch};

/// Runs `f`, compiled for AVX2 where the processor has it and for the target's baseline elsewhere.
///
/// What `f` calls must be inlined (`#[inline(always)]`) to profit. Both versions do the same IEEE operations in the
/// same order, as multiply and add are never fused here: results do not depend on the processor.
#[inline]
pub fn vectorize<R>(f: impl FnOnce() -> R) -> R {
    dispatch(ScalarWork(f))
}

/// Work that leaves vectors to the compiler.
struct ScalarWork<C>(C);

impl<R, C: FnOnce() -> R> LaneWork for ScalarWork<C> {
    type Output = R;

    #[inline(always)]
    fn run<F: Lanes>(self) -> R {
        self.0()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gives_the_same_bits_as_the_baseline() {
        let xs: Vec<f32> = (0..1000).map(|i| (i as f32 * 0.37).sin()).collect();
        let work = || xs.iter().map(|x| (x * 1.7 + 0.3) * x - x.sqrt().max(0.1)).collect::<Vec<f32>>();
        let bits = |v: Vec<f32>| v.into_iter().map(f32::to_bits).collect::<Vec<u32>>();
        assert_eq!(bits(vectorize(work)), bits(work()));
    }
}
